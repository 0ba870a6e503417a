"""Reductions (mean, median, maximum) over many stretches of frames at once.

A long clip has hundreds of plants of a few dozen frames; a numpy call for each measure of each plant would cost more
than the arithmetic.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Bools, Floats, Ints, frozen


@dataclass(frozen=True, eq=False)
class Segments:
    """Stretches `[start, end)` of a clip, laid end to end.

    Args:
        spans: the stretches, each of at least one frame; they may overlap.
    """

    spans: tuple[tuple[int, int], ...]
    lengths: Ints
    starts: Ints  # where each begins in the arrays laid end to end
    frames: Ints  # (N,) the clip's frame of each of their frames
    owner: Ints  # (N,) which stretch it belongs to

    def __len__(self) -> int:
        return len(self.spans)

    def largest(self, values: Floats) -> Floats:
        """Find the largest of values (N,) in each stretch, (S,)."""
        return np.maximum.reduceat(values, self.starts) if len(self) else np.zeros(0)

    def mean(self, values: Floats) -> Floats:
        """Compute the mean of values (N,) in each stretch, (S,)."""
        return np.add.reduceat(values, self.starts) / self.lengths if len(self) else np.zeros(0)

    def median(self, values: Floats) -> Floats:
        """Compute the median of values (N,) in each stretch, (S,)."""
        if not len(self):
            return np.zeros(0)
        ordered = values[np.lexsort((values, self.owner))]
        low, high = self.starts + (self.lengths - 1) // 2, self.starts + self.lengths // 2
        return np.asarray(0.5 * (ordered[low] + ordered[high]))

    def quantile(self, values: Floats, share: float) -> Floats:
        """Compute a quantile of values (N,) in each stretch, (S,), to the bit that of `np.quantile`."""
        if not len(self):
            return np.zeros(0)
        ordered = values[np.lexsort((values, self.owner))]
        at = share * (self.lengths - 1)  # among the ordered values of each stretch
        low = np.floor(at).astype(np.intp)
        part = at - low
        before, after = ordered[self.starts + low], ordered[self.starts + np.minimum(low + 1, self.lengths - 1)]
        step = after - before
        return np.asarray(np.where(part < 0.5, before + step * part, after - step * (1.0 - part)))

    def kept(self, keep: Bools) -> Segments:
        """Keep only some of the frames of the stretches.

        Args:
            keep: (N,) which; at least one in each stretch.
        """
        lengths = np.add.reduceat(keep.astype(np.intp), self.starts) if len(self) else self.lengths
        return Segments(
            self.spans,
            frozen(lengths, np.intp),
            frozen(np.cumsum(lengths) - lengths, np.intp),
            frozen(self.frames[keep], np.intp),
            frozen(self.owner[keep], np.intp),
        )

    def middle(self) -> Ints:
        """Find the index of each stretch's middle frame in the arrays laid end to end, (S,)."""
        return self.starts + self.lengths // 2


def geometric_medians(points: Floats, parts: Segments, weights: Floats | None = None) -> Floats:
    """Find geometric medians (S, D), with the least sum of distances to the points (N, D) of each stretch.

    A few steps of Weiszfeld's method from the mean; distances are at least a hundredth of the usual one.
    """
    share = np.ones(len(points)) if weights is None else weights
    total = np.add.reduceat(share, parts.starts)
    place = np.add.reduceat(share[:, None] * points, parts.starts) / total[:, None]
    for _ in range(5):
        off = points - place[parts.owner]
        away = np.sqrt(np.einsum("ij,ij->i", off, off))
        least = 0.01 * np.add.reduceat(share * away, parts.starts) / total + 1e-9
        closeness = share / np.maximum(away, least[parts.owner])
        place = np.add.reduceat(closeness[:, None] * points, parts.starts)
        place /= np.add.reduceat(closeness, parts.starts)[:, None]
    return place


def distinct(ascending: Ints) -> Ints:
    """Remove repetitions from an ascending array (N,); `np.unique` loads numpy's masked arrays for that, for 10 ms."""
    return np.asarray(ascending[np.diff(ascending, prepend=ascending[:1] - 1) > 0])


def segments(spans: Sequence[tuple[int, int]]) -> Segments:
    """Lay out the stretches of a clip, ready to be reduced over."""
    ends = np.array(spans, dtype=np.intp).reshape(-1, 2)
    lengths = ends[:, 1] - ends[:, 0]
    starts = np.cumsum(lengths) - lengths
    owner = np.repeat(np.arange(len(ends)), lengths)
    frames = np.arange(lengths.sum()) - starts[owner] + ends[owner, 0]
    return Segments(
        tuple((int(a), int(b)) for a, b in ends),
        frozen(lengths, np.intp),
        frozen(starts, np.intp),
        frozen(frames, np.intp),
        frozen(owner, np.intp),
    )

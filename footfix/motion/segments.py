"""Reductions over many stretches of frames at once.

A long clip has hundreds of plants of a few dozen frames; a call of numpy for each and every figure of each would
cost more than the arithmetic.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Floats, Ints, frozen


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
        """(S,) the largest of values (N,) in each stretch."""
        return np.maximum.reduceat(values, self.starts) if len(self) else np.zeros(0)

    def mean(self, values: Floats) -> Floats:
        """(S,) the mean of values (N,) in each stretch."""
        return np.add.reduceat(values, self.starts) / self.lengths if len(self) else np.zeros(0)

    def median(self, values: Floats) -> Floats:
        """(S,) the median of values (N,) in each stretch."""
        if not len(self):
            return np.zeros(0)
        ordered = values[np.lexsort((values, self.owner))]
        low, high = self.starts + (self.lengths - 1) // 2, self.starts + self.lengths // 2
        return np.asarray(0.5 * (ordered[low] + ordered[high]))

    def middle(self) -> Ints:
        """(S,) the place of each stretch's middle frame in the arrays laid end to end."""
        return self.starts + self.lengths // 2


def distinct(ascending: Ints) -> Ints:
    """An ascending array (N,) without repetitions; `np.unique` loads numpy's masked arrays to do that, for 10 ms."""
    return ascending[np.diff(ascending, prepend=ascending[:1] - 1) > 0]


def segments(spans: Sequence[tuple[int, int]]) -> Segments:
    """The stretches of a clip, ready to be reduced over."""
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

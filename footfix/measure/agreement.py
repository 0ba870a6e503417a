"""How well contacts agree with known ones: frame by frame, and event by event.

Pure functions on masks and times. An event is a strike (a contact starts) or an off (it ends); events are
paired one to one within a window, as onsets are in music transcription (mir_eval: C. Raffel et al., ISMIR 2014).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs


@dataclass(frozen=True)
class Frames:
    """Counts of frames: the confusion matrix of found contacts against true ones.

    Args:
        both: in contact, and found (true positives).
        found: found, and not in contact (false positives).
        missed: in contact, and not found (false negatives).
        neither: neither in contact nor found (true negatives).
    """

    both: int = 0
    found: int = 0
    missed: int = 0
    neither: int = 0

    def __add__(self, more: Frames) -> Frames:
        return Frames(
            self.both + more.both, self.found + more.found, self.missed + more.missed, self.neither + more.neither
        )

    @property
    def precision(self) -> float:
        return self.both / (self.both + self.found) if self.both + self.found else 1.0

    @property
    def recall(self) -> float:
        return self.both / (self.both + self.missed) if self.both + self.missed else 1.0

    @property
    def f1(self) -> float:
        """Compute the harmonic mean of precision and recall; 1 where there are no contacts and none was found."""
        total = 2 * self.both + self.found + self.missed
        return 2 * self.both / total if total else 1.0


def frames(found: Bools, true: Bools, *, known: Bools | None = None, tolerance: int = 0) -> Frames:
    """Count how two masks agree, frame by frame.

    Args:
        found, true: (F,) in contact.
        known: (F,) frames in which the truth is known; all by default.
        tolerance: frames that disagree count as right within this many frames of a true start or end.
    """
    found = np.where(_near_edge(true, tolerance), true, found)
    scored = np.ones(len(true), dtype=np.bool_) if known is None else known
    counts = [int(np.count_nonzero(scored & a & b)) for a in (found, ~found) for b in (true, ~true)]
    both, wrong, missed, neither = counts
    return Frames(both, wrong, missed, neither)


def _near_edge(mask: Bools, tolerance: int) -> Bools:
    """Mark the frames (F,) up to `tolerance` frames before or after a start or an end."""
    near = np.zeros(len(mask), dtype=np.bool_)
    for edge in (np.flatnonzero(np.diff(mask.astype(np.int8))) + 1).tolist():
        near[max(edge - tolerance, 0) : edge + tolerance] = True
    return near


def edges(mask: Bools, frame_time: float) -> tuple[Floats, Floats]:
    """Find the times [s] of strikes and offs of a mask (F,); the clip's first and last frame are none of them.

    A foot that is not in contact in one frame and is in the next landed between the two: the time is halfway.
    """
    stretches = runs(mask)
    strikes = [a - 0.5 for a, _ in stretches if a > 0]
    offs = [b - 0.5 for _, b in stretches if b < len(mask)]
    return np.array(strikes) * frame_time, np.array(offs) * frame_time


@dataclass(frozen=True, eq=False)
class Events:
    """True events paired with found ones.

    Args:
        errors: (n,) [s] found minus true, of the pairs.
        missed: true events without a partner.
        extra: found events without a partner.
    """

    errors: Floats
    missed: int
    extra: int

    @property
    def median(self) -> float:
        """Compute the median absolute error [s]; NaN where nothing was paired."""
        return float(np.median(np.abs(self.errors))) if len(self.errors) else float("nan")

    def quantile(self, share: float) -> float:
        """Find the absolute error [s] that this share of the pairs does not exceed."""
        return float(np.quantile(np.abs(self.errors), share)) if len(self.errors) else float("nan")


def events(found: Floats, true: Floats, *, window: float = 0.15) -> Events:
    """Pair events one to one, the nearest first.

    Args:
        found, true: [s] times, in order.
        window: [s] events farther apart than this are never paired.
    """
    apart = found[None, :] - true[:, None]  # (true, found) [s]
    left = np.abs(apart)
    errors = []
    while left.size and left.min() <= window:
        pair = np.unravel_index(int(np.argmin(left)), left.shape)
        errors.append(apart[pair])
        left[pair[0], :] = left[:, pair[1]] = np.inf
    return Events(np.array(errors), len(true) - len(errors), len(found) - len(errors))


def together(parts: list[Events]) -> Events:
    """Join the events of several clips."""
    errors = np.concatenate([part.errors for part in parts]) if parts else np.zeros(0)
    return Events(errors, sum(part.missed for part in parts), sum(part.extra for part in parts))


def feet(mask: Bools) -> Bools:
    """Tell when heel or toe of a foot is in contact, (F, legs), from a mask (F, 2 legs) of alternating heel and toe."""
    return np.asarray(mask[:, 0::2] | mask[:, 1::2])


def calibration(confidence: Floats, right: Bools, bins: int = 5) -> list[tuple[float, float, int]]:
    """Compare confidences with the share that was right: for each bin mean confidence, that share, and the count.

    Args:
        confidence: (n,) of contacts.
        right: (n,) whether each was right.
        bins: of equal count, by confidence.
    """
    order = np.argsort(confidence, kind="stable")
    return [
        (float(confidence[part].mean()), float(right[part].mean()), len(part))
        for part in np.array_split(order, bins)
        if len(part)
    ]

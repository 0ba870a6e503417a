"""When a foot lands and when it leaves, to a few milliseconds: by how it is braked, and by how it tips.

The ankle of a foot that comes down is braked by the floor, whichever part of the foot meets it. A foot that
pushes off tips over its toe quicker and quicker; it is slowed down as its load goes, and swung back once it is
free. So the vertical acceleration of the ankle, and the angular acceleration of the foot's pitch, take the same
course in everyone who walks, runs or jumps, and the plates' first and last 20 N lie at one place of it. Neither
knows of skate along the floor, of the height of the floor or of guessed sole points that are a little off.

The path says which foot lands and leaves about when; a line through the acceleration around then says how much
later it is, twice over. Its few numbers are fitted to plates by `benchmarks/fit_timing.py`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.detect.evidence import LIFT, STEP, Sampled
from footfix.detect.viterbi import Stretch
from footfix.motion.clip import Floats
from footfix.motion.smoothing import savgol

LOOKS = 2  # the second look is from where the first one led
SHARE = 0.05  # of a plant's time that its start and end are moved at most


@dataclass(frozen=True, eq=False)
class Line:
    """How much later than a moment something happens, by a curve around that moment.

    Args:
        taps: (T,) grid steps after the moment (before it, where negative) at which the curve is looked at.
        weights: (T,) [grid steps per unit of the curve].
        bias: [grid steps].
        farthest: [grid steps] that the path is wrong at most.
    """

    taps: tuple[int, ...]
    weights: Floats
    bias: float
    farthest: float

    @cached_property
    def _taps(self) -> Floats:
        return np.array(self.taps, dtype=np.float64)

    def later(self, curve: Floats, at: float) -> float:
        """[grid steps] from a moment to what happens; 0 where the clip shows too little of either side."""
        if not -self.taps[0] <= at <= len(curve) - 1 - self.taps[-1]:
            return 0.0
        return float(self.bias + _seen(curve, at + self._taps) @ self.weights)

    def finds(self, curve: Floats, about: float, most: float = np.inf) -> float:
        """[grid steps] when that happens which is said to happen about then, at most so far from it."""
        at, most = about, min(most, self.farthest)
        for _ in range(LOOKS):
            at = min(max(at + self.later(curve, at), about - most), about + most)
        return at


@dataclass(frozen=True, eq=False)
class Timing:
    """What tells when feet land, by `braking`, and when they leave, by `tipping`."""

    landing: Line
    leaving: Line


def seen(curve: Floats, at: Floats, taps: tuple[int, ...]) -> Floats:
    """(m, T) a curve (n,) at some steps about each of some moments (m,) [grid steps], all of them within it."""
    return _seen(curve, at[:, None] + np.array(taps))


def _seen(curve: Floats, places: Floats) -> Floats:
    left = np.minimum(places.astype(np.intp), len(curve) - 2)
    before = curve[left]
    return np.asarray(before + (places - left) * (curve[left + 1] - before))


def braking(sampled: Sampled, k: int) -> Floats:
    """(n,) [leg lengths/s^2] the upward acceleration of one foot's ankle."""
    return savgol(sampled.tracks.feet[k].ankle[:, 1], STEP, seconds=LIFT, degree=2, derivative=2)


def tipping(sampled: Sampled, k: int) -> Floats:
    """(n,) [rad/s^2] the angular acceleration of one foot's pitch, positive where the toe is swung up."""
    foot, (forward, _) = sampled.tracks.feet[k], sampled.axes[k]
    along = foot.toe - foot.heel
    pitch = np.unwrap(np.arctan2(along[:, 1], np.sum(along[:, ::2] * forward, axis=1)))  # (n,) [rad]
    return savgol(pitch, STEP, seconds=LIFT, degree=2, derivative=2)


def timed(found: list[Stretch], sampled: Sampled, k: int, timing: Timing) -> list[Stretch]:
    """The stretches of one foot, each plant from when it lands to when it leaves.

    A plant never starts before the last one ended or after its own first part, and so for its end.
    """
    return timed_by(found, braking(sampled, k), tipping(sampled, k), timing)


def timed_by(found: list[Stretch], brakes: Floats, tips: Floats, timing: Timing) -> list[Stretch]:
    """The same by the accelerations (n,) of one foot's `braking` and `tipping` that are known."""
    out = list(found)
    first = 0
    for last in range(len(found)):
        if last + 1 < len(found) and found[last + 1].start == found[last].end:
            continue  # the plant rolls on
        start, end = found[first].start, found[last].end
        most = SHARE * (end - start)
        if start > -np.inf:
            earliest = out[first - 1].end if first else -np.inf
            lands = timing.landing.finds(brakes, start, most)
            out[first] = out[first]._replace(start=min(max(lands, earliest), out[first].end))
        if end < np.inf:
            latest = found[last + 1].start if last + 1 < len(found) else np.inf
            leaves = timing.leaving.finds(tips, end, most)
            out[last] = out[last]._replace(end=max(min(leaves, latest), out[last].start))
        first = last + 1
    return out

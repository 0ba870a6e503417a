"""Landing and lift-off times to a few milliseconds, from the ankle's deceleration and the foot's pitch.

The floor brakes the ankle of a landing foot, whichever part of the foot meets it. A foot that pushes off pitches
over its toe faster and faster; its pitch slows as the load goes, and swings back once the foot is free. So the
vertical acceleration of the ankle, and the angular acceleration of the foot's pitch, have the same shape in everyone
who walks, runs or jumps, and a force plate's first and last 20 N lie at a fixed point of it. Neither depends on skate
along the floor, on the height of the floor, or on small errors of estimated sole points.

The state path gives approximate event times; a linear fit to the acceleration around each refines it, in two passes.
The coefficients are fitted to force plates by `benchmarks/fit_timing.py`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.detect.evidence import LIFT, STEP, Sampled
from footfix.detect.viterbi import Stretch
from footfix.motion.clip import Floats
from footfix.motion.smoothing import savgol

LOOKS = 2  # passes of refinement; the second starts at the result of the first
SHARE = 0.05  # of a plant's duration: the farthest that its start and end are moved


@dataclass(frozen=True, eq=False)
class Line:
    """Predict how long after a time an event follows, from a curve around it.

    Args:
        taps: (T,) grid steps after that time (before it, where negative) at which the curve is sampled.
        weights: (T,) [grid steps per unit of the curve].
        bias: [grid steps].
        farthest: [grid steps] greatest error of the state path.
    """

    taps: tuple[int, ...]
    weights: Floats
    bias: float
    farthest: float

    @cached_property
    def _taps(self) -> Floats:
        return np.array(self.taps, dtype=np.float64)

    def later(self, curve: Floats, at: float) -> float:
        """Predict the time from `at` to the event [grid steps]; 0 where the clip is too short on either side."""
        if not -self.taps[0] <= at <= len(curve) - 1 - self.taps[-1]:
            return 0.0
        return float(self.bias + _seen(curve, at + self._taps) @ self.weights)

    def finds(self, curve: Floats, about: float, most: float = np.inf) -> float:
        """Refine an event time [grid steps] by at most `most`."""
        at, most = about, min(most, self.farthest)
        for _ in range(LOOKS):
            at = min(max(at + self.later(curve, at), about - most), about + most)
        return at


@dataclass(frozen=True, eq=False)
class Timing:
    """The linear fits that refine landings, from `braking`, and lift-offs, from `tipping`."""

    landing: Line
    leaving: Line


def seen(curve: Floats, at: Floats, taps: tuple[int, ...]) -> Floats:
    """Sample a curve (n,) at `taps` around each time (m,) [grid steps], all within the curve: (m, T)."""
    return _seen(curve, at[:, None] + np.array(taps))


def _seen(curve: Floats, places: Floats) -> Floats:
    left = np.minimum(places.astype(np.intp), len(curve) - 2)
    before = curve[left]
    return np.asarray(before + (places - left) * (curve[left + 1] - before))


def braking(sampled: Sampled, k: int) -> Floats:
    """Compute the upward acceleration of one foot's ankle, (n,) [leg lengths/s^2]."""
    return savgol(sampled.tracks.feet[k].ankle[:, 1], STEP, seconds=LIFT, degree=2, derivative=2)


def tipping(sampled: Sampled, k: int) -> Floats:
    """Compute the angular acceleration of one foot's pitch, (n,) [rad/s^2], positive where the toe swings up."""
    foot, (forward, _) = sampled.tracks.feet[k], sampled.axes[k]
    along = foot.toe - foot.heel
    pitch = np.unwrap(np.arctan2(along[:, 1], np.sum(along[:, ::2] * forward, axis=1)))  # (n,) [rad]
    return savgol(pitch, STEP, seconds=LIFT, degree=2, derivative=2)


def timed(found: list[Stretch], sampled: Sampled, k: int, timing: Timing) -> list[Stretch]:
    """Refine when each plant of one foot starts and ends.

    A start stays after the end of the plant before and within the plant's first part; an end likewise.
    """
    return timed_by(found, braking(sampled, k), tipping(sampled, k), timing)


def timed_by(found: list[Stretch], brakes: Floats, tips: Floats, timing: Timing) -> list[Stretch]:
    """Do the same from accelerations (n,) already computed by `braking` and `tipping`."""
    out = list(found)
    first = 0
    for last in range(len(found)):
        if last + 1 < len(found) and found[last + 1].start == found[last].end:
            continue  # the same plant goes on, with another part of the foot
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

"""When a foot leaves the floor, to a few milliseconds: by how it tips.

A foot that pushes off tips over its toe quicker and quicker; it is slowed down as its load goes, and swung back
once it is free. So the angular acceleration of its pitch passes through the same steep rise in everyone who
walks or runs, and the plates' last 20 N lie at one place of it. The pitch knows nothing of skate, of the floor
and of the figure's size: it is the angle of a line between two points of one foot.

The path says which foot leaves about when; a line through the acceleration around then says how much later it
is, twice over. Its few numbers are fitted to plates by `benchmarks/fit_leaving.py`.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from footfix.detect.evidence import LIFT, STEP, Sampled
from footfix.detect.network import SWING
from footfix.detect.path import Stretch
from footfix.motion.clip import Floats
from footfix.motion.smoothing import savgol

LOOKS = 2  # the second look is from where the first one led
SHARE, FARTHEST = 0.05, 3.0  # of a plant's time, and [grid steps], that its end is moved at most


@dataclass(frozen=True, eq=False)
class Leaving:
    """The line that tells how much later than a moment a foot leaves.

    Args:
        taps: (T,) grid steps after the moment (before it, where negative) at which tipping is looked at.
        weights: (T,) [grid steps per rad/s^2].
        bias: [grid steps].
    """

    taps: tuple[int, ...]
    weights: Floats
    bias: float

    def later(self, tips: Floats, at: float) -> float:
        """[grid steps] from a moment to the leaving; 0 where the clip shows too little of either side."""
        if not -self.taps[0] <= at <= len(tips) - 1 - self.taps[-1]:
            return 0.0
        return float(self.bias + seen(tips, np.array([at]), self.taps)[0] @ self.weights)

    def leaves(self, tips: Floats, about: float, farthest: float) -> float:
        """[grid steps] when a foot leaves that is said to leave about then, or farthest from it."""
        at = about
        for _ in range(LOOKS):
            at = min(max(at + self.later(tips, at), about - farthest), about + farthest)
        return at


def seen(tips: Floats, at: Floats, taps: tuple[int, ...]) -> Floats:
    """(m, T) the curve (n,) at some steps about each of some moments (m,) [grid steps]."""
    return np.asarray(np.interp(at[:, None] + np.array(taps), np.arange(len(tips)), tips))


def tipping(sampled: Sampled, k: int) -> Floats:
    """(n,) [rad/s^2] the angular acceleration of one foot's pitch, positive where the toe is swung up."""
    foot, (forward, _) = sampled.tracks.feet[k], sampled.axes[k]
    along = foot.toe - foot.heel
    pitch = np.unwrap(np.arctan2(along[:, 1], np.sum(along[:, ::2] * forward, axis=1)))  # (n,) [rad]
    return savgol(pitch, STEP, seconds=LIFT, degree=2, derivative=2)


def timed(found: list[Stretch], tips: Floats, leaving: Leaving) -> list[Stretch]:
    """The same stretches, each plant ending when its foot leaves; never before its last part or after the next."""
    out = []
    landed = found[0].start if found else 0.0
    for stretch, following in pairwise([*found, Stretch(np.inf, np.inf, SWING)]):
        if stretch.end < following.start:
            farthest = min(SHARE * (stretch.end - landed), FARTHEST)
            end = max(leaving.leaves(tips, stretch.end, farthest), stretch.start)
            stretch = stretch._replace(end=min(end, following.start))
            landed = following.start
        out.append(stretch)
    return out

"""Where the sole is: heel and ball of each foot, from the pose in which the foot lies flat; and the floor.

A skeleton's ankle is a hand's breadth above the floor, and no joint marks the heel. What is common to feet is
measured: of 130 feet with markers, the ankle stands 0.075 to 0.11 leg lengths above the floor, the MTP joint
(the ball) 0.04 to 0.065, the back of the heel 0.07 behind the ankle. The heel touches the floor a little in
front of its back.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats, Ints
from footfix.rig.sample import Sample

# All in leg lengths, but for the last three.
_ANKLE_HEIGHT, _ANKLE_HEIGHTS = 0.095, (0.06, 0.14)  # the usual one, and the least and most that is believed
_BALL_HEIGHT, _BALL_HEIGHTS = 0.045, (0.025, 0.06)
_TIP_HEIGHT = 0.012  # of the tip of the toes
_HEEL_BEHIND = 0.07
_BALL_AHEAD = 0.16
_ON_TOES = 0.2  # a foot that reaches so far below its ankle stands on its toes
_BALL_OF_TIP = 0.72  # the ball's way ahead of the ankle, as a share of the tip's
_HEEL_OF_BALL = 0.45  # the heel's way behind the ankle, as a share of the ball's way ahead
_STILL = 0.25  # [leg lengths / s] a foot that moves less may be standing
_LEVEL = 0.12  # [leg lengths / s] a foot that rises and falls less may be standing on something that moves
_OFTEN = 0.4  # share of the most used level's frames that makes another height a level too


@dataclass(frozen=True)
class Foot:
    """A foot that lies flat, seen from its ankle.

    Args:
        up, ahead: unit vectors in the ankle's frame.
        ball: (3,) the toe joint in the ankle's frame; None without one.
        up_at_toe: the unit vector up in the toe joint's frame.
        ankle_height, ball_height: above the floor, in the clip's units.
        behind: how far the heel is behind the ankle.
        reach: how far the ball is ahead of the ankle.
        guessed: what the clip could not tell.
    """

    up: Floats
    ahead: Floats
    up_at_toe: Floats | None
    ankle_height: float
    ball_height: float
    behind: float
    reach: float
    guessed: tuple[str, ...]

    @property
    def origin(self) -> str:
        """How it was found, for people."""
        return "a usual foot on this leg" if self.guessed else "the pose in which the foot lies flat"


UP = np.array([0.0, 1.0, 0.0])


def foot(sample: Sample, ankle: int, toe: int | None, facing: Floats, leg: float) -> Foot:
    """How a foot lies when it is flat on the floor.

    Args:
        sample: frames of a clip [m], y up.
        ankle, toe: its joints.
        facing: (S, 3) the way the figure faces, level, in the world.
        leg: leg length [m].
    """
    flat = _flat_frames(sample, ankle, toe, leg)
    up = _usual(rotation.rotate(rotation.inverse(sample.turns[flat, ankle]), UP))
    guessed: list[str] = []
    tip, tip_down = _tip(sample, ankle, toe, flat, up)
    ahead = _level(tip, up)
    if np.linalg.norm(ahead) < 0.03 * leg:
        guessed.append("direction")
        ahead = _level(_usual(rotation.rotate(rotation.inverse(sample.turns[flat, ankle]), facing[flat])), up)
    ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-12)
    far, deep = float(tip @ ahead), max(tip_down, 0.0)
    if toe is not None:
        below = _below(sample, toe, flat)
        ball = (
            float(np.clip(below + _TIP_HEIGHT * leg, *(leg * np.array(_BALL_HEIGHTS))))
            if below > 0.0
            else _BALL_HEIGHT * leg
        )
        height = float(np.clip(deep + ball, *(leg * np.array(_ANKLE_HEIGHTS))))
        up_at_toe = _usual(rotation.rotate(rotation.inverse(sample.turns[flat, toe]), UP))
        return Foot(up, ahead, up_at_toe, height, ball, _behind(far, leg), far, tuple(guessed))
    if deep > _ON_TOES * leg:  # a paw: the ankle stands high, and only the toes touch
        height = deep + _TIP_HEIGHT * leg
        return Foot(up, ahead, None, height, height, 0.1 * leg - far, far, tuple(guessed))
    height = _ANKLE_HEIGHT * leg
    if deep > 0.02 * leg:
        height = float(np.clip(deep + _TIP_HEIGHT * leg, *(leg * np.array(_ANKLE_HEIGHTS))))
    if far < 0.03 * leg:
        guessed.append("length")
        far = _BALL_AHEAD * leg / _BALL_OF_TIP
    ball_ahead = float(np.clip(_BALL_OF_TIP * far, 0.1 * leg, 0.22 * leg))
    return Foot(up, ahead, None, height, height, _behind(ball_ahead, leg), ball_ahead, tuple(guessed))


def _behind(ahead: float, leg: float) -> float:
    """How far the heel is behind the ankle when the ball is this far ahead of it."""
    return float(np.clip(_HEEL_OF_BALL * ahead, 0.04 * leg, _HEEL_BEHIND * leg))


def _flat_frames(sample: Sample, ankle: int, toe: int | None, leg: float) -> Ints:
    """The frames in which a foot most likely stands flat: slow and low. (n,) indices."""
    joints = [ankle] if toe is None else [ankle, toe]
    heights, velocities = sample.places[:, joints, 1], sample.velocities[:, joints]
    resting = _resting(heights, velocities, leg).all(axis=1)
    if not resting.any():
        resting = heights[:, 0] <= np.quantile(heights[:, 0], 0.2)
    low = heights[:, 0] <= float(np.quantile(heights[resting, 0], 0.5)) + 0.03 * leg
    return np.flatnonzero(resting & low)


def _usual(vectors: Floats) -> Floats:
    """The direction (3,) that most of `vectors` (n, 3) have."""
    centre = np.median(vectors, axis=0)
    for _ in range(3):
        centre = centre / max(float(np.linalg.norm(centre)), 1e-12)
        closeness = vectors @ centre / np.maximum(np.linalg.norm(vectors, axis=-1), 1e-12)
        near = closeness >= min(0.966, float(np.quantile(closeness, 0.5)))  # within 15 degrees, or the nearer half
        centre = np.mean(vectors[near], axis=0)
    return np.asarray(centre / max(float(np.linalg.norm(centre)), 1e-12))


def _level(vector: Floats, up: Floats) -> Floats:
    return np.asarray(vector - (vector @ up) * up)


def _tip(sample: Sample, ankle: int, toe: int | None, flat: Ints, up: Floats) -> tuple[Floats, float]:
    """The toe joint, or else the farthest tip of the foot, in the ankle's frame; and how deep the foot reaches."""
    origin, back = sample.places[flat, ankle], rotation.inverse(sample.turns[flat, ankle])
    if toe is not None:
        here = np.median(rotation.rotate(back, sample.places[flat, toe] - origin), axis=0)
        return here, float(-(here @ up))
    tips = _tips(sample, ankle, flat)
    if not tips:
        return np.zeros(3), 0.0
    seen = [np.median(rotation.rotate(back, tip - origin), axis=0) for tip in tips]
    farthest = max(seen, key=lambda tip: float(np.linalg.norm(_level(tip, up))))
    return farthest, max(float(-(tip @ up)) for tip in seen)


def _tips(sample: Sample, joint: int, flat: Ints) -> list[Floats]:
    """The tracks of all joints and End Sites below a joint, in the flat frames."""
    skeleton = sample.skeleton
    below = {joint}
    for other in range(joint + 1, len(skeleton)):
        if int(skeleton.parents[other]) in below:
            below.add(other)
    tips = [sample.places[flat, other] for other in sorted(below - {joint})]
    return tips + [sample.ends[flat, e] for e, parent in enumerate(skeleton.end_parents.tolist()) if parent in below]


def _below(sample: Sample, toe: int, flat: Ints) -> float:
    """How far the deepest tip of the toes is below the ball."""
    tips = _tips(sample, toe, flat)
    return max((float(np.median(sample.places[flat, toe, 1] - tip[:, 1])) for tip in tips), default=0.0)


def alike(feet: list[Foot], ends: list[str], leg: float) -> list[Foot]:
    """The same feet; left and right of one end of the body get the mean of their measures, where those agree."""
    out = list(feet)
    for end in set(ends):
        pair = [i for i, own in enumerate(ends) if own == end]
        if len(pair) != 2:
            continue
        a, b = (feet[i] for i in pair)
        if (a.up_at_toe is None) != (b.up_at_toe is None):
            continue
        means = {name: 0.5 * (getattr(a, name) + getattr(b, name)) for name in _MEASURES}
        agreed = {name: mean for name, mean in means.items() if abs(getattr(a, name) - mean) < 0.015 * leg}
        for i in pair:
            out[i] = replace(feet[i], **agreed)
    return out


_MEASURES = ("ankle_height", "ball_height", "behind", "reach")


def floor(heights: Floats, velocities: Floats, leg: float) -> tuple[float, tuple[float, ...]]:
    """The lowest height at which soles rest often, and the others at which they do.

    Somebody who jumps off a box or walks up stairs rests on several levels; the floor is the lowest of those
    that at least `_OFTEN` as many rest on as on the most used one.

    Args:
        heights: (S, P) [m] of the sole points.
        velocities: (S, P, 3) [m/s].
        leg: leg length [m].
    """
    values = np.sort(heights[_resting(heights, velocities, leg)])
    band = 0.015 * leg
    steps = min(20000, max(2, int((values[-1] - values[0]) / (0.25 * band)) + 8))
    grid = np.linspace(values[0] - band, values[-1] + band, steps)
    count = np.searchsorted(values, grid + band, side="right") - np.searchsorted(values, grid - band)
    levels = []
    left = count.astype(np.float64)
    while left.max() > _OFTEN * count.max():
        level = float(grid[np.argmax(left)])
        levels.append(float(np.median(values[np.abs(values - level) <= band])))
        left[np.abs(grid - level) < 6.0 * band] = 0.0
    levels.sort()
    return levels[0], tuple(levels[1:])


def _resting(heights: Floats, velocities: Floats, leg: float) -> Bools:
    """(S, P) which points may be resting: those that are still, or level and low where none is still for long.

    On a treadmill, or in a clip whose root is held in place, planted feet travel; but not up or down.
    """
    still = np.linalg.norm(velocities, axis=-1) <= _STILL * leg
    if still.mean() >= 0.25:
        return np.asarray(still)
    low, high = np.quantile(heights, [0.03, 0.97], axis=0)
    level = (np.abs(velocities[..., 1]) <= _LEVEL * leg) & (heights <= low + 0.25 * (high - low) + 0.01 * leg)
    return np.asarray(level if level.any() else heights <= low)

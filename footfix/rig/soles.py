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
from footfix.motion.clip import Bools, Floats
from footfix.rig.sample import Sample

# All in leg lengths.
_ANKLE_HEIGHT = 0.095
_BALL_HEIGHT = 0.045
_HEEL_BEHIND = 0.065
_BALL_AHEAD = 0.16
_STILL = 0.25  # [leg lengths / s] a foot that moves less may be standing


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
    if toe is not None:
        reach = float(tip @ ahead)
        down = float(np.clip(-(tip @ up), 0.0, 0.09 * leg))
        below = _below(sample, toe, flat)
        ball_height = (
            float(np.clip(below + 0.012 * leg, 0.025 * leg, 0.06 * leg)) if below > 0.0 else _BALL_HEIGHT * leg
        )
        up_at_toe = _usual(rotation.rotate(rotation.inverse(sample.turns[flat, toe]), UP))
        height = down + ball_height
    else:
        far = float(tip @ ahead)
        if far < 0.03 * leg:
            guessed.append("length")
        reach = float(np.clip(0.72 * far, 0.1 * leg, 0.22 * leg)) if far >= 0.03 * leg else _BALL_AHEAD * leg
        down = tip_down
        height = (
            float(np.clip(down + 0.015 * leg, 0.06 * leg, 0.13 * leg)) if down > 0.02 * leg else _ANKLE_HEIGHT * leg
        )
        ball_height, up_at_toe = height, None
    behind = float(np.clip(0.42 * reach, 0.04 * leg, _HEEL_BEHIND * leg))
    return Foot(up, ahead, up_at_toe, height, ball_height, behind, reach, tuple(guessed))


def _flat_frames(sample: Sample, ankle: int, toe: int | None, leg: float) -> Floats:
    """The frames in which a foot most likely stands flat: slow and low. (n,) indices."""
    joints = [ankle] if toe is None else [ankle, toe]
    speed = np.linalg.norm(sample.velocities[:, joints], axis=-1).max(axis=1)
    height = sample.places[:, ankle, 1]
    slow = speed <= max(_STILL * leg, float(np.quantile(speed, 0.2)))
    low = height <= float(np.quantile(height[slow], 0.5)) + 0.03 * leg
    return np.flatnonzero(slow & low)


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


def _tip(sample: Sample, ankle: int, toe: int | None, flat: Floats, up: Floats) -> tuple[Floats, float]:
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


def _tips(sample: Sample, joint: int, flat: Floats) -> list[Floats]:
    """The tracks of all joints and End Sites below a joint, in the flat frames."""
    skeleton = sample.skeleton
    below = {joint}
    for other in range(joint + 1, len(skeleton)):
        if int(skeleton.parents[other]) in below:
            below.add(other)
    tips = [sample.places[flat, other] for other in sorted(below - {joint})]
    return tips + [sample.ends[flat, e] for e, parent in enumerate(skeleton.end_parents.tolist()) if parent in below]


def _below(sample: Sample, toe: int, flat: Floats) -> float:
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


def floor(heights: Floats, speeds: Floats, leg: float) -> tuple[float, tuple[float, ...]]:
    """The height at which most soles rest, and other heights at which nearly as many do.

    Args:
        heights: (S, P) [m] of the sole points.
        speeds: (S, P) [m/s].
        leg: leg length [m].
    """
    resting = _resting(heights, speeds, leg)
    values = np.sort(heights[resting])
    band = 0.015 * leg
    grid = (
        np.arange(values[0] - band, values[-1] + 2.0 * band, 0.25 * band)
        if values[-1] - values[0] < 1e3 * band
        else values
    )
    density = np.searchsorted(values, grid + band) - np.searchsorted(values, grid - band)
    best = float(density.max())
    level = float(np.median(grid[density >= 0.98 * best][:1]))
    near = values[np.abs(values - level) <= band]
    others = []
    rest = np.abs(grid - level) > 5.0 * band
    if rest.any() and float(density[rest].max()) > 0.4 * best:
        others.append(float(grid[rest][np.argmax(density[rest])]))
    return float(np.median(near)) if len(near) else level, tuple(others)


def _resting(heights: Floats, speeds: Floats, leg: float) -> Bools:
    still = speeds <= _STILL * leg
    if still.mean() < 0.05:
        still = speeds <= np.quantile(speeds, 0.2)
    return np.asarray(still)

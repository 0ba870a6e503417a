"""Find clips that are cycles: the last frame leads to the first, moved by the travel of one round.

Cycles are processed as several rounds end to end (see `repeated_rounds`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints, take_frames
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig

_SAME = 0.3  # of the clip's usual step (root mean square over the joints): poses that differ less are the same
_ALIKE = 0.45  # the same for two steps, one across the seam, where feet of cycles cut by hand may jerk
_ERRS = 0.6  # or this share of the same error within the clip, in the worst of ten frames
_MOVES = 0.2  # of the usual step: a smaller step across the seam is a pause, not a stride
_TILT = 3.0  # [degrees] greatest difference of the root's lean at both ends
_HEIGHT = 0.02  # [leg lengths] greatest difference of its height
_NEAR = 1.5  # of the usual step: greatest step across the seam of an animation in place that is likely to be a cycle,
_NEAR_TURN = 0.005  # [rad] or this, for idle animations, whose usual step is tiny
_NEAR_HEIGHT = 0.04  # [leg lengths]
_IN_PLACE = 0.15  # [leg lengths] greatest distance of its root between both ends,
_IN_PLACE_YAW = 10.0  # [degrees] and greatest turn
_EQUAL = 2e-4  # [rad, leg lengths] frames that differ less are equal within the rounding of a file
_LONGEST = 12.0  # [s] longest round, or if the last frame repeats the first,
_LONGEST_SAME = 120.0  # [s]
_FEWEST = 8  # frames of one round


@dataclass(frozen=True)
class Cycle:
    """One round of a cycle.

    Args:
        frames: of one round; the clip has one more where its last frame repeats the first.
        yaw: [rad] by which a round turns the figure.
    """

    frames: int
    yaw: float


def may_be_cycle(clip: Clip) -> bool:
    """Tell whether a clip is neither too short nor too long for one round."""
    return len(clip) >= _FEWEST and len(clip) * clip.frame_time <= _LONGEST_SAME


def find_cycle(clip: Clip, rig: Rig, pose: Pose, *, likely: bool = False) -> Cycle | None:
    """Find whether a clip is a cycle.

    Its last frame repeats the first, moved over the floor and turned about the vertical; or it is one step before that,
    and the step across the seam is like its neighbours. The figure must move at the seam, since two pauses are no
    cycle, unless the two frames are equal.

    Args:
        clip: F frames.
        rig: its root.
        pose: of the clip, with the root.
        likely: whether the clip is probably a cycle, as game animations are. In place, its ends then need only be about
            a step apart, or look the same, and it may pause there.
    """
    frames = len(clip)
    if not may_be_cycle(clip) or _tilt(pose.rotation(rig.root)[[0, -1]]) > np.radians(_TILT):
        return None
    above = clip.skeleton.ancestors(rig.root)
    joints = [joint for joint in range(len(clip.skeleton)) if joint not in above]

    def step(a: Ints, b: Ints) -> Floats:  # (n, J, 3) [rad]
        before, after = (np.stack([take_frames(clip.rotation(joint), at) for joint in joints], axis=1) for at in (a, b))
        return rotation.to_rotation_vector(rotation.multiply(rotation.inverse(before), after))

    every = np.arange(0, frames - 1, 1 if frames * clip.frame_time <= _LONGEST else 1 + frames // 200)
    steps = step(every, every + 1)
    usual = _size(steps)
    ends = step(np.array([frames - 3, frames - 2, frames - 1, 0, 1]), np.array([frames - 2, frames - 1, 0, 1, 2]))
    earlier, last, over, first, later = ends
    height, turn = pose.position(rig.root)[:, 1], pose.rotation(rig.root)
    low, yaw = _HEIGHT * rig.leg_length, _yaw(turn)
    if usual < 1e-6:
        return None
    if _size(over) < _EQUAL and abs(height[-1] - height[0]) < _EQUAL * rig.leg_length:
        return Cycle(frames - 1, yaw)
    beside = 0.5 * (first + last)
    if likely and _near(pose, rig, yaw) and _size(over) < max(_NEAR * usual, _NEAR_TURN):
        closed = _size(over) < max(_SAME * usual, _size(over - beside)) or _size(over) >= _NEAR * usual
        return Cycle(frames - 1 if closed else frames, yaw)
    if frames * clip.frame_time > _LONGEST or min(_size(first), _size(last)) < _MOVES * usual:
        return None
    if _size(over) < _SAME * usual and abs(height[-1] - height[0]) < low:
        return Cycle(frames - 1, yaw)
    rise = 0.5 * (height[1] - height[0] + height[-1] - height[-2])
    curved = beside + (first - later + last - earlier) / 6.0  # by the cubic through four steps: few frames make a round
    off = min(_size(over - beside), _size(over - curved))
    if off < max(_ALIKE * usual, _ERRS * _errs(steps)) and abs(height[0] - height[-1] - rise) < low:
        return Cycle(frames, yaw + 0.5 * (_yaw(turn[:2]) + _yaw(turn[-2:])))
    return None


def _errs(steps: Floats) -> float:
    """Measure how much steps (n, J, 3) differ from the mean of their neighbours [rad], in the worst of ten."""
    off = steps[1:-1] - 0.5 * (steps[:-2] + steps[2:])
    return float(np.quantile(np.sqrt(np.mean(np.sum(off**2, axis=2), axis=1)), 0.9))


def _near(pose: Pose, rig: Rig, yaw: float) -> bool:
    """Tell whether the root ends about where it begins."""
    way = (pose.position(rig.root)[-1] - pose.position(rig.root)[0]) / rig.leg_length
    level = float(np.hypot(way[0], way[2]))
    rises = np.abs(np.diff(pose.position(rig.root)[:, 1])) / rig.leg_length  # of a figure that bounds
    high = max(_NEAR_HEIGHT, _NEAR * float(np.quantile(rises, 0.9)))
    return level < _IN_PLACE and abs(float(way[1])) < high and abs(yaw) < np.radians(_IN_PLACE_YAW)


def said_to_be_one(pose: Pose, rig: Rig) -> Cycle:
    """Get the cycle of a clip whose last frame is the first of the next round."""
    return Cycle(len(pose.positions) - 1, _yaw(pose.rotation(rig.root)))


def _size(turns: Floats) -> float:
    """Compute the root mean square of rotation vectors (..., 3) [rad]."""
    return float(np.sqrt(np.mean(np.sum(turns**2, axis=-1))))


def _tilt(turns: Floats) -> float:
    """Measure by how much the vertical of the last of some frames (n, 4) differs from the first's [rad]."""
    up = rotation.rotate(rotation.inverse(turns), np.array([0.0, 1.0, 0.0]))
    return float(np.arccos(np.clip(up[0] @ up[-1], -1.0, 1.0)))


def _yaw(turns: Floats) -> float:
    """Measure the turn about the vertical from the first to the last of some frames (n, 4) [rad]."""
    return float(rotation.yaw(rotation.multiply(turns[-1], rotation.inverse(turns[0]))))

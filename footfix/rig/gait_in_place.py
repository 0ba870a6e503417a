"""A gait in place: the velocity of the ground relative to a figure that walks or runs on the spot.

It is found from the paths of the feet alone, before contacts are known. In a gait, feet move in one direction while
they are low, all at about the same speed, and return higher up. Other motion differs: in idling or striking the feet
stand, in dancing or dodging they return as low as they went, in turning on the spot their directions differ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import Pose
from footfix.motion.smoothing import savgol
from footfix.rig.rig import Rig

_LOW = (0.04, 0.2)  # greatest height of a low foot over its lowest [leg lengths, share of its usual rise], the lesser
_LOWEST = 0.02  # quantile of a foot's height that counts as its lowest, in case it sinks into the floor
_SLOWEST = 0.25  # [leg lengths/s] least speed of the ground
_ONE_WAY = 0.65  # least length of the sum of low feet's steps, as a share of the sum of their lengths
_EACH = (0.4, 2.0)  # range of each foot's mean speed while it is low, as a multiple of the common speed
_RISE = (0.012, -0.03)  # [leg lengths] least extra height of the forward motion, mean of the feet, and each foot
_STAYS = 0.1  # greatest speed of the hips, as a multiple of the ground's speed
_FEWEST = 12  # frames
_KEPT = (0.3, 2.0)  # range of a planted foot's speed, as a multiple of the common speed
_FLIGHT = 0.1  # weight of the ground's mean speed, relative to that of a foot at its lowest
_SMOOTH = 0.1  # [s] smoothing window of the ground's speed from low feet


@dataclass(frozen=True, eq=False)
class Gait:
    """The motion of the ground under a figure that stays in place.

    Args:
        velocity: (3,) [m/s] horizontal velocity of the ground.
        passed: (F, 3) [m] displacement of the ground by the motion of low feet, whose speed is seldom constant in
            animations.
    """

    velocity: Floats
    passed: Floats


def gait_in_place(rig: Rig, pose: Pose, frame_time: float) -> Gait | None:
    """Find the motion of the ground under a figure that walks or runs in place; None for other motion.

    Args:
        rig: its soles and hips.
        pose: F frames of `rig.joints()`.
        frame_time: [s].
    """
    size = rig.leg_length
    hips = np.mean([pose.position(leg.hip) for leg in rig.legs], axis=0)
    if len(hips) < _FEWEST:
        return None
    steps, heights = zip(*(_steps(rig, k, pose) for k in range(len(rig.legs))), strict=True)
    speeds = np.stack(steps) / frame_time  # (legs, F - 1, 2) [m/s]
    over = np.stack(heights)
    over = over - np.quantile(over, _LOWEST, axis=1, keepdims=True)
    limit = np.minimum(_LOW[0] * size, _LOW[1] * np.quantile(over, 0.95, axis=1, keepdims=True))
    low = over <= limit
    each = np.array([own[stands].mean(axis=0) for own, stands in zip(speeds, low, strict=True)])  # (legs, 2)
    common = each.mean(axis=0)
    speed = float(np.linalg.norm(common))
    if speed < _SLOWEST * size:
        return None
    ahead = common / speed
    along = speeds @ ahead  # (legs, F - 1) [m/s]
    one_way = float(np.linalg.norm(speeds[low].sum(axis=0)) / np.linalg.norm(speeds[low], axis=1).sum())
    ratios = (each @ ahead) / speed
    forth = [own[way < 0.0].mean() if (way < 0.0).any() else 0.0 for own, way in zip(over, along, strict=True)]
    back = [own[way > 0.0].mean() if (way > 0.0).any() else 0.0 for own, way in zip(over, along, strict=True)]
    rise = np.subtract(forth, back) / size
    travel = float(np.linalg.norm((hips[-1] - hips[0])[[0, 2]])) / (len(hips) * frame_time)
    if one_way < _ONE_WAY or ratios.min() < _EACH[0] or ratios.max() > _EACH[1]:
        return None
    if rise.mean() < _RISE[0] or rise.min() < _RISE[1] or travel > _STAYS * speed:
        return None
    stands = low & (along > _KEPT[0] * speed) & (along < _KEPT[1] * speed)
    usual = float(np.median(along[stands])) if stands.any() else speed
    pace = _pace(along, np.where(stands, 1.0 - over / limit, 0.0), frame_time, usual)
    level = np.array([ahead[0], 0.0, ahead[1]])
    passed = np.concatenate([[0.0], np.cumsum(pace) * frame_time])
    return Gait(usual * level, passed[:, None] * level)


def _steps(rig: Rig, leg: int, pose: Pose) -> tuple[Floats, Floats]:
    """Compute horizontal steps (F - 1, 2) [m] and heights (F - 1,) [m] of a leg's lowest sole point."""
    tracks = np.stack([pose.point(sole.joint, np.array(sole.offset)) for sole in rig.soles if sole.leg == leg])
    heights = 0.5 * (tracks[:, 1:, 1] + tracks[:, :-1, 1])
    which, frames = np.argmin(heights, axis=0), np.arange(heights.shape[1])
    return np.diff(tracks, axis=1)[which, frames][:, [0, 2]], heights[which, frames]


def _pace(along: Floats, weights: Floats, frame_time: float, usual: float) -> Floats:
    """Compute the ground's speed (F - 1,) [m/s]: that of the feet, lower ones weighing more; its mean in flight."""
    total = weights.sum(axis=0) + _FLIGHT
    mean = ((weights * along).sum(axis=0) + _FLIGHT * usual) / total
    return np.asarray(savgol(mean, frame_time, seconds=_SMOOTH, degree=1))


def carried(clip: Clip, rig: Rig, passed: Floats) -> Clip:
    """Make the clip on a ground at rest: the figure moves as far as the ground (F, 3) [m] did, the other way."""
    top = rig.root
    while clip.skeleton.parents[top] >= 0:
        top = int(clip.skeleton.parents[top])
    return clip.with_joints({top: clip.position(top) - passed}, {})

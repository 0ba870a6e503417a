"""A gait in place: the velocity with which the ground passes under a figure that walks or runs and stays where it is.

It is read from the paths of the feet alone, before anybody knows when they are planted. In a gait, feet go one way
while they are low, all at about one speed, and come back above that. Nothing else looks like it: who idles or strikes
stands, who dances or dodges comes back as low as he went, and who turns on the spot has feet that go different ways.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import Pose
from footfix.motion.smoothing import savgol
from footfix.rig.rig import Rig

_LOW = (0.04, 0.2)  # a foot is low up to so high over its lowest [leg lengths, share of its usual rise], the lesser
_LOWEST = 0.02  # share of its frames that may be lower than what counts as a foot's lowest: of one that digs in
_SLOWEST = 0.25  # [leg lengths/s] of a ground that passes
_ONE_WAY = 0.65  # share of the way of low feet that is to be left when all their steps are added up
_EACH = (0.4, 2.0)  # times the common speed that each foot has while it is low, on average
_RISE = (0.012, -0.03)  # [leg lengths] by which feet are higher on their way forth than back, on average, and each
_STAYS = 0.1  # times the speed of the ground, below which the hips travel
_FEWEST = 12  # frames
_KEPT = (0.3, 2.0)  # times the common speed at which a low foot is taken for one that stands
_FLIGHT = 0.1  # weight of the usual speed of the ground against that of a foot at its lowest
_SMOOTH = 0.1  # [s] over which the speed of the ground, as low feet tell it, is smoothed


@dataclass(frozen=True, eq=False)
class Gait:
    """How the ground passes under a figure that stays.

    Args:
        velocity: (3,) [m/s] of the ground, level.
        passed: (F, 3) [m] how far it has gone by as feet that are low say, whose speed need not be even: animators
            seldom give it one.
    """

    velocity: Floats
    passed: Floats


def gait_in_place(rig: Rig, pose: Pose, frame_time: float) -> Gait | None:
    """Find how the ground passes under a figure that walks or runs in place; None where it does not.

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
    """(F - 1, 2) [m] how the lowest sole point of a leg moves over the floor, and (F - 1,) [m] how high it is."""
    tracks = np.stack([pose.point(sole.joint, np.array(sole.offset)) for sole in rig.soles if sole.leg == leg])
    heights = 0.5 * (tracks[:, 1:, 1] + tracks[:, :-1, 1])
    which, frames = np.argmin(heights, axis=0), np.arange(heights.shape[1])
    return np.diff(tracks, axis=1)[which, frames][:, [0, 2]], heights[which, frames]


def _pace(along: Floats, weights: Floats, frame_time: float, usual: float) -> Floats:
    """(F - 1,) [m/s] the speed of the ground: that of feet, more the lower they are; the usual one in flight."""
    total = weights.sum(axis=0) + _FLIGHT
    mean = ((weights * along).sum(axis=0) + _FLIGHT * usual) / total
    return np.asarray(savgol(mean, frame_time, seconds=_SMOOTH, degree=1))


def carried(clip: Clip, rig: Rig, passed: Floats) -> Clip:
    """The clip over a ground at rest: the figure goes as far as the ground (F, 3) [m] passes under it."""
    top = rig.root
    while clip.skeleton.parents[top] >= 0:
        top = int(clip.skeleton.parents[top])
    return clip.with_joints({top: clip.position(top) - passed}, {})

"""The file's zero plane: whether the feet rest on it, and the heights of heel and ball over it.

Most clips come with their floor at height zero: capture volumes are calibrated to it, and tools draw their grid
there. Where the resting toe joints lie a foot's thickness over that plane, it is the floor, and the thickness
of the sole is measured. In other clips (hips at the origin, drifting poses from video) height zero is not the floor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.motion.clip import Floats
from footfix.rig.frame_sample import Sample
from footfix.rig.soles import MESH_OVER_LOW, SoleEstimate, floor, resting

# In leg lengths.
_LEAST = -0.005  # resting height of a ball on the plane, at least: toe joints of some skeletons lie on the ground
_OVER_USUAL = 0.025  # above the usual height of a ball (0.045) or a tip (0.012), at most: 0.07, or 0.037
_ONE_LEVEL = 0.06  # heights nearer to each other are of one level; stairs and boxes are farther apart
_UNEVEN = 0.05  # if two feet rest farther apart in height, one stands on something
_MOST_ANKLE = 0.16  # greatest height of an ankle over its sole (shoes with heels); a higher one never stood flat
_LEAST_DROP = 0.02  # a tip less than this below its ankle does not show where the sole is
_SKIN = 0.035  # resting soles of a skin within this distance of the plane are meant to rest on it
_ON_PLANE = 0.02  # the same where other soles are below the ground
_SUNK = 0.15  # a mesh up to this far below the plane is sunk into the floor; stairs are farther down
_WHILE = 0.8  # share of the frames with a foot at rest in which another one must rest on the plane


def on_zero_plane(
    sample: Sample, feet: Sequence[SoleEstimate], joints: Sequence[tuple[int, int | None]], leg: float
) -> tuple[SoleEstimate, ...] | None:
    """Measure heel and ball over the file's zero plane, if that is where the feet rest.

    Args:
        sample: frames of a clip [m], y up.
        feet: how each foot lies when it is flat; left and right are alike.
        joints: ankle and toe joint of each.
        leg: leg length [m].

    Returns:
        The same feet, their heights measured; None where the toes rest elsewhere.
    """
    if len({toe is None for _, toe in joints}) != 1:
        return None  # one foot's toe joint can't be compared with the other's tip
    if any(toe is None and foot.drop <= _LEAST_DROP * leg for foot, (_, toe) in zip(feet, joints, strict=True)):
        return None
    heights = [_rest_height(sample, ankle, toe, leg) for ankle, toe in joints]
    uneven = max(heights) - min(heights) > _UNEVEN * leg
    rest = min(heights) if uneven else float(np.mean(heights))  # [m]
    most = _OVER_USUAL * leg + float(np.mean([foot.usual for foot in feet]))
    if not _LEAST * leg <= rest <= most:
        return None
    return tuple(_measured(foot, rest, leg) for foot in feet)


def skin_on_zero_plane(heights: Floats, velocities: Floats, level: float, leg: float) -> bool:
    """Tell whether the feet of a skin stand on the file's zero plane.

    They do where they rest on it; and where one rests on it nearly always while another is a little below: an animal
    that sits has its hind feet in the ground, and no floor under its fore feet is there.

    Args:
        heights: (S, L) [m] of the lowest point of each foot's sole.
        velocities: (S, L, 3) [m/s].
        level: [m] on which soles rest most.
        leg: leg length [m].
    """
    if abs(level) < _SKIN * leg:
        return True
    rest = resting(heights, velocities, leg, MESH_OVER_LOW)
    on_plane = (rest & (np.abs(heights) < _ON_PLANE * leg)).any(axis=1)
    return bool(-_SUNK * leg < level < 0.0 and on_plane.sum() >= _WHILE * rest.any(axis=1).sum())


def _measured(foot: SoleEstimate, rest: float, leg: float) -> SoleEstimate:
    """Set the height of the ball, and that of the ankle above it as in the pose in which the foot lies flat.

    A joint that rests a little below the plane is a sole point itself: none lies above its joint. Where there is no toe
    joint, its place is as much higher than was assumed as the tip of the foot is, unless the foot stands on that tip.
    """
    ankle = float(np.clip(rest + foot.drop, 0.0, _MOST_ANKLE * leg))
    if foot.up_at_toe is not None:
        ball = max(rest, 0.0)
    else:
        ball = max(foot.ball_height + rest - foot.usual, 0.0) if foot.ball_height else 0.0
    return replace(foot, ankle_height=ankle, ball_height=ball, measured=True)


def _rest_height(sample: Sample, ankle: int, toe: int | None, leg: float) -> float:
    """Find the usual height [m] of the toe joint while it rests; of the lowest tip where there is none.

    Of several levels it is the lowest on which the foot often rests.
    """
    place, velocity = (sample.places, sample.velocities) if toe is not None else _lowest_tip(sample, ankle)
    joint = 0 if toe is None else toe
    height, velocity = place[:, [joint], 1], velocity[:, [joint]]  # (S, 1) [m], (S, 1, 3) [m/s]
    level, _ = floor(height, velocity, leg)
    at_rest = height[resting(height, velocity, leg)]
    return float(np.median(at_rest[np.abs(at_rest - level) <= _ONE_LEVEL * leg]))


def _lowest_tip(sample: Sample, ankle: int) -> tuple[Floats, Floats]:
    """Find what is lowest below an ankle, (S, 1, 3) [m], and its velocity [m/s]."""
    joints = list(sample.below(ankle)[1:])
    ends = [e for e, parent in enumerate(sample.skeleton.end_parents.tolist()) if parent in (ankle, *joints)]
    places = np.concatenate([sample.places[:, joints], sample.ends[:, ends]], axis=1)  # (S, P, 3) [m]
    velocities = np.concatenate([sample.velocities[:, joints], sample.end_velocities[:, ends]], axis=1)
    lowest = np.argmin(places[..., 1], axis=1)[:, None, None]
    return np.take_along_axis(places, lowest, axis=1), np.take_along_axis(velocities, lowest, axis=1)

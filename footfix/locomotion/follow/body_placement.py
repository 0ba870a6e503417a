"""Place body and feet of walks on a path."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from footfix.locomotion.follow.footsteps import Ground
from footfix.locomotion.follow.walk_poses import WalkingFoot, WalkPoses
from footfix.locomotion.loop.root_motion import root_in_world, with_root
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.kinematics import forward

_SWING = 3  # least number of frames of a swing


@dataclass(frozen=True, eq=False)
class Lean:
    """How a body leans.

    Args:
        angle: (F,) [rad] to the left, about the path's tangent on the floor.
        neck: the joint that compensates it, None for none.
        share: share of the lean that it compensates.
        lower: (F,) [m] by which the body is lowered.
    """

    angle: Floats
    neck: int | None = None
    share: float = 0.0
    lower: Floats | None = None


def lay_body(posed: WalkPoses, ground: Ground, lean: Lean) -> Clip:
    """Place the body on a path, with its feet.

    Args:
        posed: F frames on the spot.
        ground: the path under it, moved aside by where it leans from.
        lean: about that point of the floor.
    """
    floor, phi = posed.rig.floor, lean.angle
    laid, leans = posed.clip, posed.root
    if posed.body is not None:  # the joint that carries the body stays upright, and on the path
        position, turn = root_in_world(laid, posed.root)
        leans, path = posed.body, replace(ground, aside=np.zeros_like(ground.aside))
        laid = with_root(laid, posed.root, path.lay(position), rotation.multiply(ground.turn, turn))
    position, turn = root_in_world(posed.clip, leans)
    if np.any(phi):
        roll = rotation.from_axis_angle(np.array([0.0, 0.0, 1.0]), -phi)
        up = np.array([0.0, floor, 0.0])
        position = rotation.rotate(roll, position - up) + up
        turn = rotation.multiply(roll, turn)
    if lean.lower is not None:
        position = position - np.outer(lean.lower, [0.0, 1.0, 0.0])
    if posed.body is None or np.any(phi) or lean.lower is not None:
        laid = with_root(laid, leans, ground.lay(position), rotation.multiply(ground.turn, turn))
    if lean.neck is None or not lean.share or not np.any(phi):
        return laid
    neck, parent = lean.neck, int(laid.skeleton.parents[lean.neck])
    above = forward(laid, [parent]).rotation(parent)
    tangent = rotation.rotate(ground.turn, np.array([0.0, 0.0, 1.0]))
    back = rotation.from_axis_angle(tangent, lean.share * phi)
    local = rotation.multiply(rotation.inverse(above), rotation.multiply(back, above))
    local = rotation.multiply(local, laid.rotation(neck))
    return laid.with_joints({}, {neck: np.where((phi != 0.0)[:, None], local, laid.rotation(neck))})


@dataclass(frozen=True, eq=False)
class Goal:
    """The goal of a foot in the world.

    Args:
        ankle: (F, 3) [m].
        turn: (F, 4) of the ankle's frame.
        swings: frames in which it swings with its leg from stance to stance, without a goal.
        usual: (F, 3) [m/s^2] by how much knee, ankle and toe accelerate in the walks.
    """

    ankle: Floats
    turn: Floats
    swings: tuple[slice, ...]
    usual: Floats

    def held(self) -> Bools:
        """Mark the frames (F,) in which the goal counts."""
        out = np.ones(len(self.ankle), dtype=np.bool_)
        for some in self.swings:
            out[some] = False
        return out


def goal_of(foot: WalkingFoot, ground: Ground, yaw: Floats, shift: Floats, height: Floats) -> Goal:
    """Compute a foot's goal on the path.

    Args:
        foot: as it walks along z.
        ground: the path at the moments that carry it.
        yaw: (F,) [rad] by which it is turned about its toe.
        shift: (F, 3) [m] by which the toe is moved for that, walking along z.
        height: (F,) [m] of the toe joint.
    """
    toe = ground.lay(np.stack([foot.toe[:, 0], height, foot.toe[:, 2]], axis=1) + shift)
    turn = rotation.multiply(rotation.about_vertical(ground.heading + yaw), foot.turn)
    return Goal(toe + rotation.rotate(turn, foot.ankle), turn, _free_swings(foot), foot.usual)


def _free_swings(foot: WalkingFoot) -> tuple[slice, ...]:
    """List the swings in which a foot, or its body, is blended.

    A foot blended separately leaves the floor a little before or after its leg bends for that, which would make a
    nearly straight knee jerk.
    """
    swings = [b + np.flatnonzero(foot.mixed[b:a]) for (_, b), (a, _) in pairwise(foot.steps.stances)]
    return tuple(slice(int(each[0]), int(each[-1]) + 1) for each in swings if len(each) >= _SWING)

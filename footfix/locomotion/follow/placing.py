"""Body and feet of walks laid along a path, and legs that lead from one to the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.correction import apply
from footfix.enforce.papers.leg import (
    can_turn,
    captured_leg,
    correction_of,
    effector_tracks,
    local_rotations,
    two_bones,
    where_moved,
)
from footfix.locomotion.follow.posing import Foot, Posed
from footfix.locomotion.follow.steps import Ground
from footfix.locomotion.loop.travel import root_in_world, with_root
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import forward
from footfix.motion.vectors import norm
from footfix.rig.rig import Rig

_BENT = 0.992  # of a leg's bones, to which it is stretched where it is kept from being straight
_MOVED = 1e-7  # [m, rad] a foot that is off by less is where it is to be


@dataclass(frozen=True, eq=False)
class Lean:
    """How a body leans.

    Args:
        angle: (F,) [rad] to the left, about the path's tangent on the floor.
        neck: the joint that takes it back, None for none.
        share: how much of it.
        lower: (F,) [m] by which the body is lowered.
    """

    angle: Floats
    neck: int | None = None
    share: float = 0.0
    lower: Floats | None = None


def lay_body(posed: Posed, ground: Ground, lean: Lean) -> Clip:
    """Put the body on a path; feet go along with it.

    Args:
        posed: F frames on the spot.
        ground: the path under it, moved aside by where it leans from.
        lean: about that place on the floor.
    """
    floor, phi = posed.rig.floor, lean.angle
    laid, leans = posed.clip, posed.root
    if posed.body is not None:  # what carries the body keeps upright, and to the path
        place, turn = root_in_world(laid, posed.root)
        leans, path = posed.body, replace(ground, aside=np.zeros_like(ground.aside))
        laid = with_root(laid, posed.root, path.lay(place), rotation.multiply(ground.turn, turn))
    place, turn = root_in_world(posed.clip, leans)
    if np.any(phi):
        roll = rotation.from_axis_angle(np.array([0.0, 0.0, 1.0]), -phi)
        up = np.array([0.0, floor, 0.0])
        place = rotation.rotate(roll, place - up) + up
        turn = rotation.multiply(roll, turn)
    if lean.lower is not None:
        place = place - np.outer(lean.lower, [0.0, 1.0, 0.0])
    if posed.body is None or np.any(phi) or lean.lower is not None:
        laid = with_root(laid, leans, ground.lay(place), rotation.multiply(ground.turn, turn))
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
    """Where a foot is to be in the world.

    Args:
        ankle: (F, 3) [m].
        turn: (F, 4) of the ankle's frame.
    """

    ankle: Floats
    turn: Floats


def goal_of(foot: Foot, ground: Ground, yaw: Floats, shift: Floats, height: Floats) -> Goal:
    """Where a foot is on the path.

    Args:
        foot: as it walks along z.
        ground: the path at the moments that carry it.
        yaw: (F,) [rad] by which it is turned about its toe.
        shift: (F, 3) [m] by which the toe is moved for that, walking along z.
        height: (F,) [m] of the toe joint.
    """
    toe = ground.lay(np.stack([foot.toe[:, 0], height, foot.toe[:, 2]], axis=1) + shift)
    turn = rotation.multiply(rotation.about_vertical(ground.heading + yaw), foot.turn)
    return Goal(toe + rotation.rotate(turn, foot.ankle), turn)


def hips_of(clip: Clip, rig: Rig) -> list[Floats]:
    """For each leg (F, 3) [m] the hip."""
    seen = forward(clip, [leg.hip for leg in rig.legs])
    return [seen.position(leg.hip) for leg in rig.legs]


def reaches(clip: Clip, rig: Rig, bent: Floats) -> list[Floats]:
    """Tell for each leg (F,) [m] how far from hip to ankle it may be stretched.

    That is as far as it ever was captured. Where its foot steps elsewhere it is kept from being that straight: near
    the straight line a knee shoots forwards and back by what an ankle hardly moves.

    Args:
        clip: F frames.
        rig: its legs.
        bent: (F,) how much of that is wanted, 0 to 1.
    """
    seen = forward(clip, [joint for leg in rig.legs for joint in (leg.hip, leg.knee, leg.ankle)])
    most = list[Floats]()
    for leg in rig.legs:
        hip, knee, ankle = (seen.position(joint) for joint in (leg.hip, leg.knee, leg.ankle))
        far, bones = float(norm(ankle - hip).max()), norm(knee - hip) + norm(ankle - knee)
        most.append(far - bent * np.maximum(far - _BENT * bones, 0.0))
    return most


def bend_legs(clip: Clip, rig: Rig, goals: Sequence[Goal], farthest: Sequence[float]) -> Clip:
    """Bend legs so that ankles are at their goals; what is there already keeps its numbers.

    Args:
        clip: the body, as `lay_body` has put it.
        rig: its legs.
        goals: one a leg.
        farthest: for each leg [m] from hip to ankle, what it may be stretched to.
    """
    seen = rig.pose(clip)
    tracks = effector_tracks(rig, seen)
    turns: dict[int, Floats] = {}
    for number, (leg, goal, most) in enumerate(zip(rig.legs, goals, farthest, strict=True)):
        if not can_turn(clip, leg):
            continue
        captured = captured_leg(rig, seen, number, tracks)
        moves = norm(goal.ankle - captured.ankle) > _MOVED
        moves |= rotation.angle(rotation.multiply(rotation.inverse(captured.turn), goal.turn)) > _MOVED
        if not np.any(moves):
            continue
        line = goal.ankle - captured.hip
        limit = np.maximum(most, norm(captured.ankle - captured.hip))
        share = np.minimum(1.0, limit / np.maximum(norm(line), 1e-9))
        ankle = np.where((share < 1.0)[:, None], captured.hip + share[:, None] * line, goal.ankle)
        turns |= where_moved(
            clip, local_rotations(clip, seen, captured, two_bones(captured, ankle), goal.turn), moves
        )  # fmt: skip
    return apply(clip, correction_of(clip, rig, turns)) if turns else clip

"""Bend the legs of a body on a path to its footsteps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.enforce.correction import apply
from footfix.enforce.two_bone_ik import (
    CapturedLeg,
    can_turn,
    captured_leg,
    correction_of,
    local_rotations,
    where_moved,
)
from footfix.locomotion.follow.blend_weight import ease
from footfix.locomotion.follow.body_placement import Goal
from footfix.locomotion.follow.stride import smoothed
from footfix.locomotion.follow.swinging import swung
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import forward
from footfix.motion.vectors import cross, dot, norm, unit
from footfix.rig.rig import Rig

_BENT = 0.992  # of the length of a leg's bones: longest leg where it is kept from being straight
_PLANE = 0.8  # [rad] flexion from which a knee determines the plane of its leg
_STEADY = 0.3  # [s] smoothing window of that plane
_MOVED = 1e-7  # [m, rad] a foot nearer to its goal than this is not moved


def hips_of(clip: Clip, rig: Rig) -> list[Floats]:
    """Get the hip of each leg, (F, 3) [m]."""
    seen = forward(clip, [leg.hip for leg in rig.legs])
    return [seen.position(leg.hip) for leg in rig.legs]


def reaches(clip: Clip, rig: Rig, reach: Sequence[float], bent: Floats) -> list[Floats]:
    """Compute the greatest allowed distance from hip to ankle of each leg, (F,) [m].

    It is the greatest captured distance. Where a foot is moved, the leg is kept from being that straight: near straight
    a tiny motion of the ankle moves the knee a lot.

    Args:
        clip: F frames.
        rig: its legs.
        reach: [m] of each, as far as it ever was captured.
        bent: (F,) how much of that to apply, 0 to 1.
    """
    seen = forward(clip, [joint for leg in rig.legs for joint in (leg.hip, leg.knee, leg.ankle)])
    most = list[Floats]()
    for leg, own in zip(rig.legs, reach, strict=True):
        hip, knee, ankle = (seen.position(joint) for joint in (leg.hip, leg.knee, leg.ankle))
        far, bones = max(own, float(norm(ankle - hip).max())), norm(knee - hip) + norm(ankle - knee)
        most.append(far - bent * np.maximum(far - _BENT * bones, 0.0))
    return most


def bend_legs(clip: Clip, rig: Rig, goals: Sequence[Goal], farthest: Sequence[float], way: Floats) -> Clip:
    """Bend legs so that ankles reach their goals; legs that are there already are unchanged.

    Args:
        clip: the body, as `lay_body` has put it.
        rig: its legs.
        goals: one a leg.
        farthest: for each leg [m] the greatest allowed distance from hip to ankle.
        way: (F, 4) the frame in which the figure walks along z.
    """
    seen = rig.pose(clip)
    tracks = rig.held(seen)
    wide = round(_STEADY / clip.frame_time)
    turns: dict[int, Floats] = {}
    for number, (leg, goal, most) in enumerate(zip(rig.legs, goals, farthest, strict=True)):
        if not can_turn(clip, leg):
            continue
        captured = captured_leg(rig, seen, number, tracks)
        moves = norm(goal.ankle - captured.ankle) > _MOVED
        moves |= rotation.apart(captured.turn, goal.turn) > _MOVED
        if not np.any(moves):
            continue
        line = goal.ankle - captured.hip
        limit = np.maximum(most, norm(captured.ankle - captured.hip))
        share = np.minimum(1.0, limit / np.maximum(norm(line), 1e-9))
        ankle = np.where((share < 1.0)[:, None], captured.hip + share[:, None] * line, goal.ankle)
        solved, foot = swung(captured, ankle, goal, astray(captured, way, wide))
        turns |= where_moved(clip, local_rotations(clip, seen, captured, solved, foot), moves)
    return apply(clip, correction_of(clip, rig, turns)) if turns else clip


def astray(leg: CapturedLeg, way: Floats, wide: int) -> Floats:
    """Find the turn (F,) [rad] about its own line of a leg that was nearly straight and is bent now.

    The plane of a nearly straight leg is badly determined, and may turn within some frames unnoticed; once the leg is
    bent, its knee would jump aside. So the plane is taken from frames nearby in which the leg was bent more.

    It is measured relative to the direction of travel, not to the pelvis, whose frame may turn differently in two walks
    that look the same.

    Args:
        leg: as it was.
        way: (F, 4) the frame in which the figure walks along z.
        wide: [frames] over which the plane is smoothed.
    """
    line = unit(leg.hip - leg.ankle)
    usual = rotation.rotate(rotation.inverse(way), leg.knee_axis).mean(axis=0)
    side = rotation.rotate(way, unit(usual))
    side = unit(side - dot(side, line)[:, None] * line)
    angle = np.unwrap(np.arctan2(dot(cross(side, leg.knee_axis), line), dot(side, leg.knee_axis)))
    weight = np.sin(leg.flexion) ** 2 + 1e-6
    steady = smoothed(weight * angle, wide) / smoothed(weight, wide)
    return np.asarray((steady - angle) * (1.0 - ease(np.abs(leg.flexion) / _PLANE)))

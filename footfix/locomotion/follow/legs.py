"""Legs that lead from a body on a path to where its feet step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.enforce.correction import apply
from footfix.enforce.papers.leg import (
    CapturedLeg,
    LegTurns,
    can_turn,
    captured_leg,
    correction_of,
    effector_tracks,
    flexion_for,
    local_rotations,
    two_bones,
    where_moved,
)
from footfix.locomotion.follow.blend import ease
from footfix.locomotion.follow.placing import Goal
from footfix.locomotion.follow.stride import smoothed
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import forward
from footfix.motion.vectors import cross, dot, norm, unit
from footfix.rig.rig import Rig

_BENT = 0.992  # of a leg's bones, to which it is stretched where it is kept from being straight
_ROUNDED = 0.15  # [rad] of a knee's flexion, below which it is taken to be less than it is told by
_MORE = 0.15  # [rad] by which a knee is bent more for its leg's plane to be steadied
_PLANE = 0.8  # [rad] a knee that is bent by more tells the plane of its leg
_STEADY = 0.3  # [s] over which that plane is smoothed
_CLEAR = 0.01  # [m] over which a foot that gets too low is lifted
_ENDS = 0.25  # of a swing, in which that comes and goes
_OUT = 0.3  # [rad] by which slopes at the ends of a swing carry a leg out, at most
_MOVED = 1e-7  # [m, rad] a foot that is off by less is where it is to be


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


def bend_legs(clip: Clip, rig: Rig, goals: Sequence[Goal], farthest: Sequence[float], way: Floats) -> Clip:
    """Bend legs so that ankles are at their goals; what is there already keeps its numbers.

    Args:
        clip: the body, as `lay_body` has put it.
        rig: its legs.
        goals: one a leg.
        farthest: for each leg [m] from hip to ankle, what it may be stretched to.
        way: (F, 4) the frame in which the figure walks along z.
    """
    seen = rig.pose(clip)
    tracks = effector_tracks(rig, seen)
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
        solved, foot = _swung(captured, ankle, goal, way, wide)
        turns |= where_moved(clip, local_rotations(clip, seen, captured, solved, foot), moves)
    return apply(clip, correction_of(clip, rig, turns)) if turns else clip


def _swung(leg: CapturedLeg, ankle: Floats, goal: Goal, way: Floats, wide: int) -> tuple[LegTurns, Floats]:
    """Solve a leg for where its foot stands; where it swings, as it is mixed, led over from one stance to the next.

    Led over are the knee's flexion, the direction from hip to ankle, and the turn of the foot: led over to an ankle's
    place, a leg that is nearly straight would be torn.

    Args:
        leg: as it is mixed.
        ankle: (F, 3) [m] where it is to be.
        goal: its foot.
        way: (F, 4) the frame in which the figure walks along z.
        wide: [frames] over which the plane of a leg that is nearly straight is smoothed.

    Returns:
        What turns the leg, and (F, 4) the ankle's frame.
    """
    bent, foot = flexion_for(leg, ankle), goal.turn.copy()
    swivel = steadied(leg, way, bent, wide)
    if not goal.swings:
        return two_bones(leg, ankle, swivel), foot
    thigh, shank, line = leg.knee - leg.hip, leg.ankle - leg.knee, ankle - leg.hip
    aside = rotation.to_rotation_vector(rotation.between(leg.ankle - leg.hip, line))
    turned = rotation.to_rotation_vector(rotation.continuous(rotation.multiply(foot, rotation.inverse(leg.turn))))
    for some in goal.swings:
        line[some] = rotation.rotate(rotation.from_rotation_vector(_led_over(aside, some)), (leg.ankle - leg.hip)[some])
        foot[some] = rotation.multiply(rotation.from_rotation_vector(_led_over(turned, some)), leg.turn[some])
        bent[some] = _led_flexion(leg.flexion, bent, some)
    bend = rotation.from_axis_angle(leg.knee_axis, bent - leg.flexion)
    far = norm(thigh + rotation.rotate(bend, shank))
    led = leg.hip + far[:, None] * unit(line)
    lift = np.zeros(len(far))
    for some in goal.swings:
        lift[some] = _lifted(leg, some, (led, foot), (ankle, goal.turn))
    if np.any(lift):
        up = led + np.outer(lift, [0.0, 1.0, 0.0])
        bent, line = bent + flexion_for(leg, up) - flexion_for(leg, led), up - leg.hip
        bend = rotation.from_axis_angle(leg.knee_axis, bent - leg.flexion)
    swing = rotation.between(thigh + rotation.rotate(bend, shank), line)
    return LegTurns(rotation.multiply(rotation.from_axis_angle(unit(-line), swivel), swing), bend), foot


def _lifted(
    leg: CapturedLeg, some: slice, led: tuple[Floats, Floats], asked: tuple[Floats, Floats]
) -> Floats:
    """Find (n,) [m] by which a swinging foot is lifted so that it gets no lower than it ever does by itself.

    Args:
        leg: as it is mixed.
        some: frames of the swing.
        led: (F, 3) [m] the ankle and (F, 4) its frame, as they are led,
        asked: and as the foot goes by itself.
    """
    ends = [leg.in_foot(leg.effector(part)) for part in ("heel", "toe")]

    def low(ankle: Floats, turn: Floats) -> Floats:
        return np.asarray(np.min([(ankle + rotation.rotate(turn, end))[:, 1] for end in ends], axis=0))

    lack = low(*asked).min() - low(*led)[some]
    if not np.any(lack > 0.0):
        return np.zeros(len(lack))
    u = np.arange(1, len(lack) + 1) / (len(lack) + 1)
    soft = 0.5 * (lack + np.hypot(lack, _CLEAR))
    return np.asarray(soft * ease(u / _ENDS) * ease((1.0 - u) / _ENDS))


def steadied(leg: CapturedLeg, way: Floats, bent: Floats, wide: int) -> Floats:
    """Find (F,) [rad] by which a leg that was nearly straight, and is bent now, turns about its own line.

    The plane of a leg that is nearly straight means little, and may swing round within some frames, unseen; when the
    leg is bent, its knee would be thrown aside. So it goes by the frames around in which the leg was bent more.

    It is seen from the way, not from the pelvis: a pelvis that has joints between it and the hips may turn otherwise
    in one walk than in another, and both figures look the same.

    Args:
        leg: as it was.
        way: (F, 4) the frame in which the figure walks along z.
        bent: (F,) [rad] the flexion of the knee now.
        wide: [frames] over which the plane is smoothed.
    """
    line = unit(leg.hip - leg.ankle)
    usual = rotation.rotate(rotation.inverse(way), leg.knee_axis).mean(axis=0)
    side = rotation.rotate(way, unit(usual))
    side = unit(side - dot(side, line)[:, None] * line)
    angle = np.unwrap(np.arctan2(dot(cross(side, leg.knee_axis), line), dot(side, leg.knee_axis)))
    weight = np.sin(leg.flexion) ** 2 + 1e-6
    steady = smoothed(weight * angle, wide) / smoothed(weight, wide)
    more = ease((np.abs(bent) - np.abs(leg.flexion)) / _MORE) * (1.0 - ease(np.abs(leg.flexion) / _PLANE))
    return np.asarray((steady - angle) * more)


def _led_flexion(mixed: Floats, asked: Floats, some: slice) -> Floats:
    """(n,) [rad] a knee's flexion while its foot swings.

    A knee that is overstretched by some degrees in one frame and bent in the next, its leg being straight in both, is
    told by how straight it is, rounded off.

    Args:
        mixed: (F,) [rad] as the leg is mixed,
        asked: (F,) [rad] and as its stances ask.
        some: frames of the swing.
    """
    signs = np.sign(mixed[some])
    if np.all(signs == signs[0]):
        return np.asarray(mixed[some] + _led_over((asked - mixed)[:, None], some)[:, 0])
    bent = np.hypot(mixed, _ROUNDED)
    led = bent[some] + _led_over((np.hypot(asked, _ROUNDED) - bent)[:, None], some)[:, 0]
    return np.sqrt(np.maximum(led**2 - _ROUNDED**2, 0.0))


def _led_over(track: Floats, some: slice) -> Floats:
    """(n, D) a curve over frames of a track (F, D) that leads on at both ends with the slopes there.

    It is the cubic that does. Where its slopes are so steep that they would carry it far out, each of them comes to
    rest earlier: a leg that is nearly straight at the one end is bent quickly there, and no farther for that.
    """
    a, b = max(some.start - 1, 1), min(some.stop, len(track) - 2)
    count = np.arange(some.start, some.stop, dtype=np.float64)
    u = ((count - a) / (b - a))[:, None]
    step = track[b] - track[a]
    out = track[a] + u**2 * (3.0 - 2.0 * u) * step
    return np.asarray(
        out + _led_on(track[a] - track[a - 1], count - a, b - a) - _led_on(track[b + 1] - track[b], b - count, b - a)
    )


def _led_on(slope: Floats, away: Floats, frames: int) -> Floats:
    """(n, D) how far a slope (D,) [rad a frame] carries (n,) frames away, at rest after so many of them or fewer."""
    most = _OUT / (4.0 / 27.0 * max(float(np.linalg.norm(slope)), 1e-12))  # u (1 - u)^2 gets to 4 / 27
    until = min(float(frames), most)
    u = np.clip(away / until, 0.0, 1.0)[:, None]
    return np.asarray(until * u * (1.0 - u) ** 2 * slope)

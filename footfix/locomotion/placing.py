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
from footfix.locomotion.blend import Timeline, Zone
from footfix.locomotion.steps import Ground, Steps, find_steps
from footfix.locomotion.travel import root_in_world, with_root
from footfix.locomotion.walk import Walk
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import forward
from footfix.motion.vectors import norm
from footfix.rig.rig import Rig

_MOVED = 1e-7  # [m, rad] a foot that is off by less is where it is to be


@dataclass(frozen=True, eq=False)
class Foot:
    """A foot as it walks along z, in the frame that carries it.

    Args:
        steps: its stances.
        toe: (F, 3) [m] the toe joint, or the ball of the sole; seen from where the frame is at `steps.moment`.
        turn: (F, 4) of the ankle's frame.
        ankle: (F, 3) [m] from the toe to the ankle, in the ankle's frame.
        heel: (F, 3) [m] from the toe to the heel, in the same.
    """

    steps: Steps
    toe: Floats
    turn: Floats
    ankle: Floats
    heel: Floats


@dataclass(frozen=True, eq=False)
class Posed:
    """Walks one after the other, on the spot, and their feet.

    Args:
        clip: F frames on the spot, along z.
        root: what carries it.
        body: the joint by which the body is placed below that, if any.
        rig: its legs.
        feet: one a leg.
        planted: (F, E) which sole points are planted.
        sure: (F, E) confidence of that.
    """

    clip: Clip
    root: int
    body: int | None
    rig: Rig
    feet: tuple[Foot, ...]
    planted: Bools
    sure: Floats


def pose(walks: Sequence[Walk], timeline: Timeline) -> Posed:
    """Take the poses of a timeline from its walks.

    A foot is blended by the weight of the moment that carries it, the middle of its stance: so it stands still in a
    blend, too.

    Args:
        walks: with one skeleton, on one floor.
        timeline: which moment of which walk each frame shows.
    """
    rig = walks[0].rig
    down = np.concatenate([_planted(walks, zone, zone.weight) for zone in timeline.zones])
    own = [[e for e, sole in enumerate(rig.soles) if sole.leg == k] for k in range(len(rig.legs))]
    steps = [find_steps(np.asarray(down[:, soles].any(axis=1)), timeline.frame_time) for soles in own]
    moments = [each.moment for each in steps]
    parts = [_zone(walks, zone, moments, timeline.frame_time) for zone in timeline.zones]
    feet = tuple(
        Foot(each, *(np.concatenate([part.feet[k][n] for part in parts]) for n in range(4)))
        for k, each in enumerate(steps)
    )
    weights = [_weight(zone, moments) for zone in timeline.zones]
    planted, sure = np.zeros_like(down), np.zeros(down.shape)
    for zone, weight in zip(timeline.zones, weights, strict=True):
        for k, soles in enumerate(own):
            planted[zone.frames, soles[0] : soles[-1] + 1] = _planted(walks, zone, weight[k])[:, soles]
        sure[zone.frames] = _sure(walks, zone)
    return Posed(_joined([part.clip for part in parts]), walks[0].root, walks[0].body, rig, feet, planted, sure)


def _planted(walks: Sequence[Walk], zone: Zone, weight: Floats) -> Bools:
    """(n, E) what is planted in a zone: as in the walk that weighs more."""
    some = zone.frames
    one, two = (walks[k].planted(at[some]) for k, at in zip(zone.walks, zone.at, strict=True))
    return np.where(weight[some][:, None] >= 0.5, two, one)


def _sure(walks: Sequence[Walk], zone: Zone) -> Floats:
    one, two = (walks[k].sure(at[zone.frames]) for k, at in zip(zone.walks, zone.at, strict=True))
    return np.where(zone.weight[zone.frames][:, None] >= 0.5, two, one)


def _weight(zone: Zone, moments: Sequence[Floats]) -> list[Floats]:
    """For each leg (F,) the weight of the moment that carries it."""
    count = np.arange(len(zone.weight))
    return [np.interp(moment, count, zone.weight) for moment in moments]


@dataclass(frozen=True, eq=False)
class _Part:
    clip: Clip
    feet: list[tuple[Floats, ...]]


def _zone(walks: Sequence[Walk], zone: Zone, moments: Sequence[Floats], frame_time: float) -> _Part:
    """The poses and the feet of a zone."""
    some = zone.frames
    weights = [each[some] for each in _weight(zone, moments)]
    weight = zone.weight[some]
    every = np.stack([weight, *weights])
    a, b = (walks[k] for k in zone.walks)
    alone = a is b and zone.at[0] is zone.at[1]
    seen: list[Bools] = [
        np.asarray(alone | (every < 1.0).any(axis=0)), np.asarray((every > 0.0).any(axis=0) & (not alone))
    ]  # fmt: skip
    clips = [walk.at(at[some][use]) for walk, at, use in zip((a, b), zone.at, seen, strict=True)]
    feet = [_feet(walk, clip, at, moments, some, use)
            for walk, clip, at, use in zip((a, b), clips, zone.at, seen, strict=True)]  # fmt: skip
    legs = []
    for k, own in enumerate(weights):
        legs.append(_blended_foot(feet[0][k], feet[1][k], seen, own))
    below = {}
    for k, leg in enumerate(a.rig.legs):
        for joint in range(len(a.clip.skeleton)):
            if joint != leg.ankle and leg.ankle in a.clip.skeleton.ancestors(joint):
                below[joint] = weights[k]
    return _Part(_blended(clips, seen, weight, below, frame_time), legs)


def _feet(
    walk: Walk, clip: Clip, at: Floats, moments: Sequence[Floats], some: slice, use: Bools
) -> list[tuple[Floats, ...]]:  # fmt: skip
    """Each foot of a walk in the frames that use it, as `Foot` has it."""
    count = np.arange(len(at))
    seen = forward(clip, clip.skeleton.with_ancestors(walk.rig.joints()))
    feet = list[tuple[Floats, ...]]()
    tracks = effector_tracks(walk.rig, seen)
    for k, (leg, moment) in enumerate(zip(walk.rig.legs, moments, strict=True)):
        ankle, turn = seen.position(leg.ankle), seen.rotation(leg.ankle)
        ends = {sole.part: track for sole, track in zip(walk.rig.soles, tracks, strict=True) if sole.leg == k}
        toe, back = ends["toe"], rotation.inverse(turn)
        gone = (at[some] - np.interp(moment[some], count, at))[use] * walk.length / walk.frames
        offs = [rotation.rotate(back, each - toe) for each in (ankle, ends["heel"])]
        feet.append((toe + np.outer(gone, [0.0, 0.0, 1.0]), turn, *offs))
    return feet


def _blended_foot(
    one: tuple[Floats, ...], two: tuple[Floats, ...], seen: Sequence[Bools], weight: Floats
) -> tuple[Floats, ...]:  # fmt: skip
    return (
        _mixed(one[0], two[0], seen, weight),
        _mixed(one[1], two[1], seen, weight, turn=True),
        *(_mixed(a, b, seen, weight) for a, b in zip(one[2:], two[2:], strict=True)),
    )


def _mixed(one: Floats, two: Floats, seen: Sequence[Bools], weight: Floats, *, turn: bool = False) -> Floats:
    """(n, D) a track of two that are seen in some frames each, by the second's weight."""
    if not np.any(seen[1]):
        return one
    if not np.any(seen[0]):
        return two
    out = np.empty((one.shape[1], len(weight))).T
    out[seen[1]] = two
    first = weight <= 0.0
    out[first] = one[first[seen[0]]]
    both = (weight > 0.0) & (weight < 1.0)
    a, b, w = one[both[seen[0]]], two[both[seen[1]]], weight[both]
    out[both] = rotation.slerp(a, b, w) if turn else a + w[:, None] * (b - a)
    return out


def _blended(
    clips: Sequence[Clip], seen: Sequence[Bools], weight: Floats, below: dict[int, Floats], frame_time: float
) -> Clip:  # fmt: skip
    one, two = clips
    places, turns = list[Floats](), list[Floats]()
    for joint in range(len(one.skeleton)):
        own = below.get(joint, weight)
        places.append(_mixed(one.place(joint), two.place(joint), seen, own))
        turns.append(_mixed(one.turn(joint), two.turn(joint), seen, own, turn=True))
    return Clip.from_tracks(one.skeleton, places, turns, frame_time)


def _joined(clips: Sequence[Clip]) -> Clip:
    if len(clips) == 1:
        return clips[0]
    joints = range(len(clips[0].skeleton))
    places = [np.concatenate([clip.place(joint) for clip in clips]) for joint in joints]
    turns = [np.concatenate([clip.turn(joint) for clip in clips]) for joint in joints]
    return Clip.from_tracks(clips[0].skeleton, places, turns, clips[0].frame_time)


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
    local = rotation.multiply(local, laid.turn(neck))
    return laid.with_joints({}, {neck: np.where((phi != 0.0)[:, None], local, laid.turn(neck))})


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


def reaches(clip: Clip, rig: Rig) -> list[Floats]:
    """For each leg (F,) [m] from hip to ankle, as captured."""
    seen = forward(clip, [joint for leg in rig.legs for joint in (leg.hip, leg.ankle)])
    return [norm(seen.position(leg.ankle) - seen.position(leg.hip)) for leg in rig.legs]


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


def contacts_of(posed: Posed, some: slice) -> Contacts:
    """The contacts of some frames of walks one after the other."""
    clip = posed.clip.frames(some)
    return posed.rig.no_contacts(clip).with_mask(posed.planted[some], posed.sure[some])


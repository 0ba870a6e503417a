"""Poses of walks one after the other, on the spot, and of their feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.papers.leg import effector_tracks
from footfix.locomotion.follow.steps import Steps, find_steps
from footfix.locomotion.follow.timeline import Timeline, Zone
from footfix.locomotion.follow.walk import Walk
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import forward
from footfix.rig.rig import Rig


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
        places.append(_mixed(one.position(joint), two.position(joint), seen, own))
        turns.append(_mixed(one.rotation(joint), two.rotation(joint), seen, own, turn=True))
    return Clip.from_tracks(one.skeleton, places, turns, frame_time)


def _joined(clips: Sequence[Clip]) -> Clip:
    if len(clips) == 1:
        return clips[0]
    joints = range(len(clips[0].skeleton))
    places = [np.concatenate([clip.position(joint) for clip in clips]) for joint in joints]
    turns = [np.concatenate([clip.rotation(joint) for clip in clips]) for joint in joints]
    return Clip.from_tracks(clips[0].skeleton, places, turns, clips[0].frame_time)


def contacts_of(posed: Posed, some: slice) -> Contacts:
    """The contacts of some frames of walks one after the other."""
    clip = posed.clip.frames(some)
    return posed.rig.no_contacts(clip).with_mask(posed.planted[some], posed.sure[some])

"""Poses of blended walks on the spot, with the motion of their feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.locomotion.follow.blend_schedule import Timeline, Zone
from footfix.locomotion.follow.blend_weight import ease
from footfix.locomotion.follow.footsteps import Steps, find_steps
from footfix.locomotion.follow.key_times import Keys, in_step
from footfix.locomotion.follow.pose_blend import joined, mixed, mixed_clip
from footfix.locomotion.follow.prepared_walk import Walk
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats, Skeleton
from footfix.motion.contacts import Contacts, runs
from footfix.motion.kinematics import Pose, forward
from footfix.rig.rig import Rig

_BRIEF = 0.06  # [s] shorter gaps in a contact are filled
_LEADS = 0.12  # [s] after the middle of a stance, at which its blend weight is taken
_ROUNDS = 3  # iterations between durations of stances and their weights
_ALIKE = 0.01  # [strides] stances of two walks whose durations differ less are treated as equal


@dataclass(frozen=True, eq=False)
class WalkingFoot:
    """A foot of a walk along z, in the frame of its stance.

    Args:
        steps: its stances.
        toe: (F, 3) [m] the toe joint, or where it would be; seen from where the frame is at `steps.moment`.
        turn: (F, 4) of the ankle's frame.
        ankle: (F, 3) [m] from the toe to the ankle, in the ankle's frame.
        heel: (F, 3) [m] from the toe to the heel, in the same.
        mixed: (F,) whether the foot, or the body above it, is blended from two walks.
        usual: (F, 3) [m/s^2] usual accelerations of its knee, ankle and toe in the walks, see `Walk.jolts`.
    """

    steps: Steps
    toe: Floats
    turn: Floats
    ankle: Floats
    heel: Floats
    mixed: Bools
    usual: Floats


@dataclass(frozen=True, eq=False)
class WalkPoses:
    """Walks one after the other, on the spot, and their feet.

    Args:
        clip: F frames on the spot, along z.
        root: what carries it.
        body: the joint by which the body is placed below that, if any.
        rig: its legs.
        feet: one a leg.
        planted: (F, E) which sole points are planted.
        sure: (F, E) confidence of that.
        mixed: (F,) 0 where one walk is shown, 1 where both count equally.
        reach: [m] greatest distance from hip to ankle of each leg in the walks.
        stride: [frames] duration of the longest stride.
    """

    clip: Clip
    root: int
    body: int | None
    rig: Rig
    feet: tuple[WalkingFoot, ...]
    planted: Bools
    sure: Floats
    mixed: Floats
    reach: tuple[float, ...]
    stride: int


def pose(walks: Sequence[Walk], timeline: Timeline) -> WalkPoses:
    """Take the poses of a timeline from its walks.

    A foot is blended with a constant weight throughout each stance, so that it stands still in a blend, too.

    Args:
        walks: with one skeleton, on one floor.
        timeline: which time of which walk each frame shows.
    """
    rig = walks[0].rig
    steps = _steps(walks, timeline)
    parts = [_zone(walks, timeline, zone, [each.moment for each in steps]) for zone in timeline.zones]
    feet = tuple(_joined_foot(each, parts, k) for k, each in enumerate(steps))
    weight = timeline.weight()
    planted = _closed(np.concatenate([part.planted for part in parts]), (weight > 0.0) & (weight < 1.0), timeline)
    sure = np.concatenate([_sure(walks, zone) for zone in timeline.zones])
    clip, both = joined([part.clip for part in parts]), ease(30.0 * weight * (1.0 - weight))
    shown = sorted({k for zone in timeline.zones for k in zone.walks})
    reach = tuple(float(each) for each in np.max([walks[k].reach for k in shown], axis=0))
    return WalkPoses(
        clip, walks[0].root, walks[0].body, rig, feet, planted, sure, both, reach, _stride(walks, timeline)
    )


def _stride(walks: Sequence[Walk], timeline: Timeline) -> int:
    """Find the duration of the longest stride [frames], from the walks shown alone before and after each blend."""
    found = list[float]()
    for zone in timeline.zones:
        alone = zone.at[0][1] - zone.at[0][0], zone.at[1][-1] - zone.at[1][-2]
        found += [walks[k].frames / walks[k].strides / float(step) for k, step in zip(zone.walks, alone, strict=True)]
    return round(max(found))


def _closed(planted: Bools, mixed: Bools, timeline: Timeline) -> Bools:
    """Fill brief gaps in contacts (F, E) of a blend, between the end of one walk's contact and the other's lead."""
    brief, out = round(_BRIEF / timeline.frame_time), planted.copy()
    for own in out.T:
        for start, end in runs(~own):
            if end - start <= brief and start > 0 and end < len(own) and bool(mixed[start:end].all()):
                own[start:end] = True
    return out


def _steps(walks: Sequence[Walk], timeline: Timeline) -> list[Steps]:
    """Find the stances of each leg; in a blend their lengths depend on weights, and these on the stances' middles."""
    found = []
    for leg in range(len(walks[0].rig.legs)):
        own = [e for e, sole in enumerate(walks[0].rig.soles) if sole.leg == leg]
        weights = [zone.weight for zone in timeline.zones]
        for _ in range(_ROUNDS if bool(timeline.blended().any()) else 1):
            down = [_in_zone(walks, timeline.keys, zone, leg, weight)[1][:, own]
                    for zone, weight in zip(timeline.zones, weights, strict=True)]  # fmt: skip
            steps = find_steps(np.asarray(np.concatenate(down).any(axis=1)), timeline.frame_time)
            weights = [_weight(zone, steps.moment, timeline.frame_time) for zone in timeline.zones]
        found.append(steps)
    return found


def _in_zone(
    walks: Sequence[Walk], keys: Sequence[Keys], zone: Zone, leg: int, weight: Floats
) -> tuple[tuple[Floats, Floats], Bools]:  # fmt: skip
    """Find the moments (F,) of either walk that a leg shows, and which sole points are planted then, (n, E)."""
    pair, own = [walks[k] for k in zone.walks], [keys[k] for k in zone.walks]
    at = zone.at if zone.at[0] is zone.at[1] else _in_step(own, leg, zone, weight)
    return at, _planted(pair, at, zone.frames, weight)


def _planted(pair: Sequence[Walk], at: Sequence[Floats], some: slice, weight: Floats) -> Bools:
    """Take the planted sole points (n, E) in a zone from the walk with the greater weight."""
    one, two = (walk.planted(each[some]) for walk, each in zip(pair, at, strict=True))
    return np.where(weight[some][:, None] >= 0.5, two, one)


def _sure(walks: Sequence[Walk], zone: Zone) -> Floats:
    one, two = (walks[k].sure(at[zone.frames]) for k, at in zip(zone.walks, zone.at, strict=True))
    return np.where(zone.weight[zone.frames][:, None] >= 0.5, two, one)


def _weight(zone: Zone, moment: Floats, frame_time: float) -> Floats:
    """Take the weight (F,) for a foot from shortly after the moment that places it, near its lift.

    A leg that lags behind the body would still be down when the body moves on, and its knee would jerk.
    """
    return np.interp(moment + _LEADS / frame_time, np.arange(len(zone.weight)), zone.weight)


@dataclass(frozen=True, eq=False)
class _Part:
    clip: Clip
    feet: list[tuple[Floats, ...]]
    mixed: list[Bools]
    planted: Bools
    usual: Floats


def _joined_foot(steps: Steps, parts: Sequence[_Part], k: int) -> WalkingFoot:
    toe, turn, ankle, heel = (np.concatenate([part.feet[k][n] for part in parts]) for n in range(4))
    both = np.concatenate([part.mixed[k] for part in parts])
    usual = np.concatenate([np.broadcast_to(part.usual[k], (len(part.planted), 3)) for part in parts])
    return WalkingFoot(steps, toe, turn, ankle, heel, both, usual)


def _zone(walks: Sequence[Walk], timeline: Timeline, zone: Zone, moments: Sequence[Floats]) -> _Part:
    """Make the poses, the feet and the contacts of a zone."""
    some, own = zone.frames, [_weight(zone, moment, timeline.frame_time) for moment in moments]
    every = np.stack([zone.weight, *own])[:, some]
    pair = tuple(walks[k] for k in zone.walks)
    alone = pair[0] is pair[1] and zone.at[0] is zone.at[1]
    seen: list[Bools] = [
        np.asarray(alone | (every < 1.0).any(axis=0)), np.asarray((every > 0.0).any(axis=0) & (not alone))
    ]  # fmt: skip
    clips = pair[0].at(zone.at[0][some][seen[0]]), pair[1].at(zone.at[1][some][seen[1]])
    rig, skeleton = pair[0].rig, pair[0].clip.skeleton
    usual_seen = [forward(clip, skeleton.with_ancestors(rig.joints())) for clip in clips]
    feet, below = list[tuple[Floats, ...]](), dict[int, tuple[Clip, Clip, Floats]]()
    planted = np.zeros((some.stop - some.start, len(rig.soles)), dtype=np.bool_)
    for k, (leg, weight, moment) in enumerate(zip(rig.legs, own, moments, strict=True)):
        at, down = _in_zone(walks, timeline.keys, zone, k, weight)
        matter = _of_leg(rig, skeleton, k)
        posed = tuple(
            clip if np.array_equal(mine[some], usual[some]) else walk.at(mine[some][use], matter)
            for walk, clip, mine, usual, use in zip(pair, clips, at, zone.at, seen, strict=True)
        )
        own_seen = [first if mine is clip else forward(mine, matter)
                    for mine, clip, first in zip(posed, clips, usual_seen, strict=True)]  # fmt: skip
        tracks = [_foot(walk, there, k, mine, usual, moment, some, use)
                  for walk, there, mine, usual, use in zip(pair, own_seen, at, zone.at, seen, strict=True)]  # fmt: skip
        feet.append(_blended_foot(tracks[0], tracks[1], seen, weight[some]))
        below |= {joint: (posed[0], posed[1], weight[some]) for joint in range(len(skeleton))
                  if joint != leg.ankle and leg.ankle in skeleton.ancestors(joint)}  # fmt: skip
        soles = [e for e, sole in enumerate(rig.soles) if sole.leg == k]
        planted[:, soles] = down[:, soles]
    both = [np.asarray((not alone) & ((every > 0.0) & (every < 1.0))[[0, k + 1]].any(axis=0)) for k in range(len(own))]
    usual = np.maximum(pair[0].jolts, pair[1].jolts)
    return _Part(mixed_clip(clips, seen, zone.weight[some], below), feet, both, planted, usual)


def _in_step(keys: Sequence[Keys], leg: int, zone: Zone, weight: Floats) -> tuple[Floats, Floats]:
    """Find times (F,) of two walks at which one leg is at the same point of its stance or swing.

    Key-times align strikes, but a foot whose stance is longer in one walk would be lifted by the other walk during it.
    In a blend its stance lasts the mean of both.
    """
    one, two = (key.stances[leg] for key in keys)
    mix = (weight > 0.0) & (weight < 1.0)
    if one is None or two is None or not np.any(mix) or abs(one[1] - two[1]) < _ALIKE:
        return zone.at
    stands = one[1] + weight[mix] * (two[1] - one[1])
    out = zone.at[0].copy(), zone.at[1].copy()
    for mine, key, (strike, own) in zip(out, keys, (one, two), strict=True):
        mine[mix] = key.frame(in_step(zone.time[mix], strike, stands, own))
    return out


def _of_leg(rig: Rig, skeleton: Skeleton, number: int) -> tuple[int, ...]:
    """List the joints that determine a foot, and all below it."""
    leg = rig.legs[number]
    soles = [sole.joint for sole in rig.soles if sole.leg == number]
    below = [joint for joint in range(len(skeleton)) if leg.ankle in skeleton.ancestors(joint)]
    return skeleton.with_ancestors([*soles, *below, *([] if leg.toe is None else [leg.toe])])


def _foot(
    walk: Walk, seen: Pose, leg: int, at: Floats, usual: Floats, moment: Floats, some: slice, use: Bools
) -> tuple[Floats, ...]:  # fmt: skip
    """Get a foot of a walk in the frames that use it, as `WalkingFoot` has it."""
    ankle, turn = (each(walk.rig.legs[leg].ankle) for each in (seen.position, seen.rotation))
    mine = replace(walk.rig, soles=tuple(sole for sole in walk.rig.soles if sole.leg == leg))
    tracks = mine.held(seen)
    ends = {sole.part: track for sole, track in zip(mine.soles, tracks, strict=True)}
    toe, back = ends["toe"], rotation.inverse(turn)
    gone = (at[some] - np.interp(moment[some], np.arange(len(at)), usual))[use] * walk.length / walk.frames
    offs = [rotation.rotate(back, each - toe) for each in (ankle, ends["heel"])]
    return (toe + np.outer(gone, [0.0, 0.0, 1.0]), turn, *offs)


def _blended_foot(
    one: tuple[Floats, ...], two: tuple[Floats, ...], seen: Sequence[Bools], weight: Floats
) -> tuple[Floats, ...]:  # fmt: skip
    return (
        mixed(one[0], two[0], seen, weight),
        mixed(one[1], two[1], seen, weight, turn=True),
        *(mixed(a, b, seen, weight) for a, b in zip(one[2:], two[2:], strict=True)),
    )


def contacts_of(posed: WalkPoses, some: slice) -> Contacts:
    """Make the contacts of some frames of walks one after the other."""
    clip = posed.clip.frames(some)
    return posed.rig.no_contacts(clip).with_mask(posed.planted[some], posed.sure[some])

"""Locomotion frame by frame, foreseen: cycles for what is asked, carried along, with feet that stand.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 3 to 6.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footfix.enforce.papers.ease import gamma
from footfix.locomotion.leg_pose import LegPose, bent_to, leg_pose
from footfix.locomotion.model import CycleModel, place_of_root
from footfix.locomotion.plan import Course, Line, Plan, Point, make_course
from footfix.locomotion.stance import (
    QUANTITIES,
    SIGMA,
    Span,
    Stance,
    contact_mask,
    displacement,
    foot_goal,
    placed,
    sample_times,
    share_of_toe,
    with_ends,
)
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats

SOONEST = 0.25  # [s] within which parameters change at the soonest
_COMMITTED = 0.12  # [s] before a foot is set down, from when on its place does not change any more
_BRIEFEST = 0.03  # [s] a contact that is foreseen to be shorter is none
_AHEAD = 1.4  # [s] that are foreseen at least
_RESIDUAL = 0.3  # [s] in which what a changed plan left over is gone at the latest
_SOON = 0.05  # [s]


@dataclass(frozen=True, eq=False)
class Postures:
    """Postures of a figure at T times.

    Args:
        times: (T,) [s].
        place: (T, 3) [m] the root.
        turns: (T, J, 4) xyzw each joint's rotation in its parent's frame.
        contacts: (T, E) whether each effector is planted.
        names: of the effectors.
    """

    times: Floats
    place: Floats
    turns: Floats
    contacts: Bools
    names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.times)

    def clip(self, model: CycleModel, frame_time: float) -> Clip:
        """The postures as frames of a clip."""
        skeleton, root = model.skeleton, model.rig.root
        places = np.tile(skeleton.offsets, (len(self), 1, 1))
        places[:, root] = self.place
        return Clip(skeleton, places, self.turns, frame_time)


@dataclass(frozen=True, eq=False)
class Residual:
    """What of a displacement a changed plan left over, and until when it fades (G eq. 11)."""

    since: float
    until: float
    value: Floats

    def at(self, times: Floats) -> Floats:
        """(T, ...) what is left of it."""
        u = (times - self.since) / (self.until - self.since)
        return np.asarray(np.multiply.outer(gamma(u) * (times >= self.since), self.value))


@dataclass(frozen=True, eq=False)
class Foreseen:
    """What is going to happen as long as nothing else is asked for.

    Args:
        course: phase, place and heading.
        stances: of each leg, in order of time.
        residuals: of each leg, quantity -> what fades.
    """

    course: Course
    stances: tuple[tuple[Stance, ...], ...]
    residuals: tuple[Mapping[str, Sequence[Residual]], ...] = field(default=())


def foresee(model: CycleModel, plan: Plan, line: Line | None, start: Point, until: float) -> Foreseen:
    """Foresee the course of a plan and where the feet are going to stand.

    Args:
        model: the figure and its cycles.
        plan: what is asked for.
        line: the path to go along, if any.
        start: where the course is known.
        until: [s].
    """
    back = 1.6 / float(model.frequency(plan.at(np.array([start.time])))[0])
    course = make_course(plan, line, start, until, start.time - back, model.frequency)
    found = [_placed(model, course, each) for each in timetable(model, course)]
    return Foreseen(course, tuple(found), tuple({} for _ in found))


def changed(model: CycleModel, old: Foreseen, plan: Plan, now: float, until: float) -> Foreseen:
    """Foresee anew from a time on, at which another plan holds, or more of it is wanted.

    What stands stays, and a foot about to be set down comes down where it was to. Others get new places; what leads
    them there now, and does not any more, fades (G eq. 11, put right: as printed it jumps).
    """
    start = old.course.point(now)
    back = 1.6 / float(model.frequency(plan.at(np.array([now])))[0])
    course = make_course(plan, old.course.line, start, until, now - back, model.frequency)
    found = []
    for number, stances in enumerate(timetable(model, course)):
        before = {each.count: each for each in old.stances[number]}
        kept = [_kept(before[s.count], s, now) if s.count in before else s for s in stances]
        place_again = [s.count in before and before[s.count].start <= now + _COMMITTED for s in stances]
        missing = [s for s in old.stances[number] if s.start <= now and s.count not in {k.count for k in kept}
                   and s.end > now - 2.0 * SIGMA]  # fmt: skip
        new = _placed(model, course, kept, place_again)
        found.append(tuple(sorted((*missing, *new), key=lambda s: s.count)))
    new_one = Foreseen(course, tuple(found), tuple({} for _ in found))
    return replace(new_one, residuals=tuple(_residuals(model, old, new_one, k, now) for k in range(len(found))))


def _kept(old: Stance, new: Stance, now: float) -> Stance:
    """A stance with its new times, and of the old ones what has begun, or ended."""

    def span(was: Span | None, becomes: Span | None) -> Span | None:
        if was is None or was[0] > now:
            return becomes
        if was[1] <= now or becomes is None:
            return (was[0], max(min(was[1], now + _BRIEFEST), was[0] + 1e-3)) if was[1] > now else was
        return (was[0], max(becomes[1], now + 1e-3))

    if old.start > now + _COMMITTED:
        return new
    return replace(old, heel=span(old.heel, new.heel), toe=span(old.toe, new.toe))


def timetable(model: CycleModel, course: Course) -> list[list[Stance]]:
    """When each foot is going to stand, by the phases at which it does in the cycles on the way; without places."""
    asked = course.plan.at(course.grid)
    spans = model.contact_phases(asked)
    set_down = course.phase[:, None] - spans[:, :, 0]
    lifted = set_down - spans[:, :, 1]
    low, high = int(np.floor(set_down[0].min())), int(np.ceil(set_down[-1].max()))
    counts = np.arange(low, high + 1)
    effectors = model.rig.soles
    times: dict[tuple[int, str], list[Span | None]] = {}
    for e, sole in enumerate(effectors):
        begin, end = (np.interp(counts, curve[:, e], course.grid, left=np.nan, right=np.nan) for curve in (set_down, lifted))
        last = course.grid[-1] + 0.3 / max(float(model.frequency(course.plan.at(course.grid[-1:]))[0]), 0.1)
        end = np.where(np.isnan(end) & ~np.isnan(begin), last, end)
        times[sole.leg, sole.part] = [
            (float(a), float(b)) if np.isfinite(a) and b - a >= _BRIEFEST else None for a, b in zip(begin, end, strict=True)
        ]
    found = []
    for leg in range(len(model.rig.legs)):
        pairs = zip(counts, times[leg, "heel"], times[leg, "toe"], strict=True)
        found.append([Stance(leg, int(k), heel, toe) for k, heel, toe in pairs if heel is not None or toe is not None])
    return found


def _placed(
    model: CycleModel, course: Course, stances: Sequence[Stance], again: Sequence[bool] | None = None
) -> tuple[Stance, ...]:
    """Stances of one foot with their places; those that have one keep it."""
    if not stances:
        return ()
    times = [sample_times(each) for each in stances]
    pose = free_legs(model, course, np.concatenate(times), [stances[0].leg])[0]
    found, at = [], 0
    for k, (stance, own) in enumerate(zip(stances, times, strict=True)):
        part = _part(pose, slice(at, at + len(own)))
        keeps = again is not None and again[k]
        found.append((with_ends if keeps else placed)(stance, part, model))
        at += len(own)
    return tuple(found)


def _part(pose: LegPose, which: slice) -> LegPose:
    places = {joint: each[which] for joint, each in pose.places.items()}
    turns = {joint: each[which] for joint, each in pose.turns.items()}
    return LegPose(pose.number, places, turns, pose.heel[which], pose.toe[which])


def free_postures(model: CycleModel, course: Course, times: Floats) -> tuple[Floats, Floats]:
    """(T, 3) [m] the root and (T, J, 4) all rotations as the cycles have them, no foot held (G eq. 5, 6)."""
    rows = model.rows(course.phases(times), course.plan.at(times))
    place, heading = course.where(times)
    turns = model.turns(rows)
    turns[:, model.rig.root] = rotation.multiply(rotation.about_vertical(heading), turns[:, model.rig.root])
    return place_of_root(rows, place, heading, model.rig.leg_length), turns


def free_legs(model: CycleModel, course: Course, times: Floats, legs: Sequence[int]) -> list[LegPose]:
    """The legs as the cycles have them."""
    place, turns = free_postures(model, course, times)
    return [leg_pose(model, number, place, turns[:, model.rig.root], turns) for number in legs]


def _off(
    model: CycleModel, foreseen: Foreseen, pose: LegPose, times: Floats
) -> tuple[dict[str, Floats], Floats]:
    """What leads a foot off the cycle: quantity -> (T, 3), and (T,) by which of its ends."""
    stances, residuals = foreseen.stances[pose.number], foreseen.residuals[pose.number]
    off = {name: displacement(name, stances, times, pose, model) for name in QUANTITIES}
    share = share_of_toe(stances, times)
    for name, left in residuals.items():
        for each in left:
            if name == "share":
                share = share + each.at(times)
            else:
                off[name] = off[name] + each.at(times)
    return off, share


def _residuals(model: CycleModel, old: Foreseen, new: Foreseen, number: int, now: float) -> dict[str, list[Residual]]:
    """What led a foot off the cycle at a time, and does not any more."""
    at = np.array([now])
    (pose,) = free_legs(model, new.course, at, [number])
    was, now_is = (_off(model, each, pose, at) for each in (old, new))
    found = {}
    for name in QUANTITIES:
        gap = was[0][name][0] - now_is[0][name][0]
        if np.any(np.abs(gap) > 1e-9):
            found[name] = [Residual(now, _until(new.stances[number], name, now), gap)]
    gap = was[1][0] - now_is[1][0]
    if abs(gap) > 1e-9:
        found["share"] = [Residual(now, _until(new.stances[number], "heel", now), np.asarray(gap))]
    return found


def _until(stances: Sequence[Stance], quantity: str, now: float) -> float:
    starts = [span[0] for each in stances if (span := each.span(quantity)) is not None and span[0] > now]
    return now + min(max(min(starts, default=np.inf) - now, _SOON), _RESIDUAL)


def postures(model: CycleModel, foreseen: Foreseen, times: Floats) -> Postures:
    """The postures at some times (T,) [s], feet held."""
    place, turns = free_postures(model, foreseen.course, times)
    rig = model.rig
    masks: dict[int, Bools] = {}
    for number in range(len(rig.legs)):
        pose = leg_pose(model, number, place, turns[:, rig.root], turns)
        off, share = _off(model, foreseen, pose, times)
        ankle, foot, toes = foot_goal(model, pose, off, share)
        for joint, turn in bent_to(model, pose, pose.places[rig.legs[number].hip], ankle, foot, toes).items():
            turns[:, joint] = turn
        for e, sole in enumerate(rig.soles):
            if sole.leg == number:
                masks[e] = contact_mask(foreseen.stances[number], sole.part, times)
    contacts = np.stack([masks[e] for e in range(len(rig.soles))], axis=1)
    return Postures(times, place, rotation.normalize(turns), contacts, tuple(sole.name for sole in rig.soles))

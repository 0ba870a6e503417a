"""Locomotion frame by frame, foreseen: cycles for what is asked, carried along, with feet that stand.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 3 to 6.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footfix.enforce.papers.ease import gamma
from footfix.locomotion.leg_pose import LegPoses
from footfix.locomotion.model import CycleModel, place_of_root
from footfix.locomotion.plan import Course, Line, Plan, Point, make_course
from footfix.locomotion.stance import (
    SIGMA,
    FootPlan,
    Span,
    Stance,
    foot_plan,
    goals,
    led_off,
    placed,
    sample_times,
    with_ends,
)
from footfix.locomotion.timeline import within
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats

SOONEST = 0.25  # [s] within which parameters change at the soonest
_COMMITTED = 0.12  # [s] before a foot is set down, from when on its place does not change any more
_BRIEFEST = 0.03  # [s] a contact that is foreseen to be shorter is none
_AHEAD = 1.4  # [s] that are foreseen at least
_RESIDUAL = 0.3  # [s] in which what a changed plan left over is gone at the latest
_SOON = 0.01  # [s] in which it is gone at the soonest


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
        """(T, size) what is left of it."""
        u = (times - self.since) / (self.until - self.since)
        return np.asarray((gamma(u) * (times >= self.since))[:, None] * self.value)


@dataclass(frozen=True, eq=False)
class Foreseen:
    """What is going to happen as long as nothing else is asked for.

    Args:
        course: phase, place and heading.
        feet: what each foot is going to do.
        residuals: of each foot, quantity -> what fades.
    """

    course: Course
    feet: tuple[FootPlan, ...]
    residuals: tuple[Mapping[str, Residual], ...] = field(default=())


def foresee(model: CycleModel, plan: Plan, line: Line | None, start: Point, until: float) -> Foreseen:
    """Foresee the course of a plan and where the feet are going to stand.

    Args:
        model: the figure and its cycles.
        plan: what is asked for.
        line: the path to go along, if any.
        start: where the course is known.
        until: [s].
    """
    course = _course(model, plan, line, start, until)
    stances = [each for own in timetable(model, course, until) for each in own]
    feet = _feet(model, _placed(model, course, stances, [False] * len(stances)))
    return Foreseen(course, feet, tuple({} for _ in feet))


def _course(model: CycleModel, plan: Plan, line: Line | None, start: Point, until: float) -> Course:
    """The course, with the past in which feet that stand were set down, and the time in which they are lifted again."""
    slow = 1.0 / model.frequency(plan.at(np.array([start.time, until])))
    return make_course(plan, line, start, until + float(slow[1]), start.time - 1.3 * float(slow[0]), model.frequency)


def _feet(model: CycleModel, stances: Sequence[Stance]) -> tuple[FootPlan, ...]:
    legs = range(len(model.rig.legs))
    return tuple(foot_plan(sorted((s for s in stances if s.leg == k), key=lambda s: s.count)) for k in legs)


def changed(model: CycleModel, old: Foreseen, plan: Plan, now: float, until: float) -> Foreseen:
    """Foresee anew from a time on, at which another plan holds, or more of it is wanted.

    What stands stays, and a foot about to be set down comes down where it was to. Others get new places; what leads
    them there now, and does not any more, fades (G eq. 11, put right: as printed it jumps).
    """
    course = _course(model, plan, old.course.line, old.course.point(now), until)
    over, stances, stays = list[Stance](), list[Stance](), list[bool]()
    for foot, coming in zip(old.feet, timetable(model, course, until), strict=True):
        over += [each for each in foot.stances if now - 2.0 * SIGMA < each.end <= now]
        before = {each.count: each for each in foot.stances if each.start <= now + _COMMITTED}
        coming = [s for s in coming if (before[s.count] if s.count in before else s).end > now]
        stances += [_kept(before[each.count], each, now) if each.count in before else each for each in coming]
        stays += [each.count in before for each in coming]
    new = _feet(model, [*over, *_placed(model, course, stances, stays)])
    found = Foreseen(course, new, tuple({} for _ in new))
    return replace(found, residuals=_residuals(model, old, found, now))


def _kept(old: Stance, new: Stance, now: float) -> Stance:
    """A stance with its new times, and of the old ones what has begun, or ended."""

    def span(was: Span | None, becomes: Span | None) -> Span | None:
        if was is None or was[0] > now:
            return becomes if becomes is None else (max(becomes[0], now), max(becomes[1], now + 1e-3))
        if was[1] <= now or becomes is None:
            return (was[0], max(min(was[1], now + _BRIEFEST), was[0] + 1e-3)) if was[1] > now else was
        return (was[0], max(becomes[1], now + 1e-3))

    return replace(old, heel=span(old.heel, new.heel), toe=span(old.toe, new.toe))


def timetable(model: CycleModel, course: Course, until: float) -> list[list[Stance]]:
    """When each foot is going to stand, by the phases at which it does in the cycles on the way; without places.

    Of those that begin after `until` [s] each foot has one, to be led to.
    """
    asked = course.plan.at(course.grid)
    spans = model.contact_phases(asked)
    set_down = course.phase[:, None] - spans[:, :, 0]
    lifted = set_down - spans[:, :, 1]
    low, high = int(np.floor(set_down[0].min())), int(np.ceil(set_down[-1].max()))
    counts = np.arange(low, high + 1)
    times: dict[tuple[int, str], list[Span | None]] = {}
    for e, sole in enumerate(model.rig.soles):
        begin, end = (np.interp(counts, c[:, e], course.grid, left=np.nan, right=np.nan) for c in (set_down, lifted))
        end = np.where(np.isnan(end), course.grid[-1], end)
        times[sole.leg, sole.part] = [
            (float(a), float(b)) if np.isfinite(a) and b - a >= _BRIEFEST else None for a, b in zip(begin, end, strict=True)
        ]
    found = []
    for leg in range(len(model.rig.legs)):
        pairs = zip(counts, times[leg, "heel"], times[leg, "toe"], strict=True)
        own = [Stance(leg, int(k), heel, toe) for k, heel, toe in pairs if heel is not None or toe is not None]
        later = [k for k, each in enumerate(own) if each.start > until]
        found.append(own[: later[0] + 1] if later else own)
    return found


def _placed(model: CycleModel, course: Course, stances: Sequence[Stance], stays: Sequence[bool]) -> list[Stance]:
    """Stances with their places; those that stay keep theirs."""
    if not stances:
        return []
    times = [sample_times(each) for each in stances]
    every = np.concatenate(times)
    place, turns = free_postures(model, course, every)
    poses = model.legs.poses(place, turns[:, model.rig.root], turns)
    found, at = [], 0
    for stance, own, keeps in zip(stances, times, stays, strict=True):
        found.append((with_ends if keeps else placed)(stance, poses.some(slice(at, at + len(own))), model))
        at += len(own)
    return found


def free_postures(model: CycleModel, course: Course, times: Floats) -> tuple[Floats, Floats]:
    """(T, 3) [m] the root and (T, J, 4) all rotations as the cycles have them, no foot held (G eq. 5, 6)."""
    rows = model.rows(course.phases(times), course.plan.at(times))
    place, heading = course.where(times)
    turns = model.turns(rows)
    turns[:, model.rig.root] = rotation.multiply(rotation.about_vertical(heading), turns[:, model.rig.root])
    return place_of_root(rows, place, heading, model.rig.leg_length), turns


def _off(foreseen: Foreseen, pose: LegPoses, times: Floats) -> dict[str, Floats]:
    """What leads the feet off the cycle: quantity -> (T, L, size)."""
    each_foot = []
    for foot, residuals in zip(foreseen.feet, foreseen.residuals, strict=True):
        off = led_off(foot, times, pose)
        for name, left in residuals.items():
            off[name] = off[name] + left.at(times)
        each_foot.append(off)
    return {name: np.stack([off[name] for off in each_foot], axis=1) for name in each_foot[0]}


def _residuals(model: CycleModel, old: Foreseen, new: Foreseen, now: float) -> tuple[Mapping[str, Residual], ...]:
    """What led the feet off the cycle at a time, and does not any more."""
    at = np.array([now])
    place, turns = free_postures(model, new.course, at)
    pose = model.legs.poses(place, turns[:, model.rig.root], turns)
    was, becomes = (_off(each, pose, at) for each in (old, new))
    found = []
    for k, foot in enumerate(new.feet):
        own = {}
        for name in was:
            gap = was[name][0, k] - becomes[name][0, k]
            if np.any(np.abs(gap) > 1e-9):
                own[name] = Residual(now, _until(foot, name, now), gap)
        found.append(own)
    return tuple(found)


def _until(foot: FootPlan, quantity: str, now: float) -> float:
    """[s] when what is left over of a quantity has to be gone: when it is held next."""
    spans = foot.spans(quantity if quantity in foot.lines else "heel")
    coming = min((start for start, _ in spans if start > now), default=np.inf)
    return now + min(max(coming - now, _SOON), _RESIDUAL)


def postures(model: CycleModel, foreseen: Foreseen, times: Floats) -> Postures:
    """The postures at some times (T,) [s], feet held."""
    place, turns = free_postures(model, foreseen.course, times)
    rig, legs = model.rig, model.legs
    pose = legs.poses(place, turns[:, rig.root], turns)
    turns[:, legs.turned] = legs.bent(pose, model.knees, *goals(pose, _off(foreseen, pose, times)))
    contacts = [within(foreseen.feet[sole.leg].spans(sole.part), times) for sole in rig.soles]
    return Postures(times, place, turns, np.stack(contacts, axis=1), tuple(sole.name for sole in rig.soles))

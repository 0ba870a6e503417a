"""Prediction of locomotion: cycles for the requested parameters, moved along the course, with planted feet held.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 3 to 6.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.easing import replanned
from footfix.locomotion.cycles.foot_offsets import SIGMA, Feet, make_feet
from footfix.locomotion.cycles.leg_pose import LegPoses
from footfix.locomotion.cycles.model import CycleModel
from footfix.locomotion.cycles.plan import Course, Line, Plan, Point, make_course
from footfix.locomotion.cycles.postures import OffsetPostures, Postures, cycle_postures, held, leg_poses
from footfix.locomotion.cycles.stance import Span, Stance, sample_times, settled
from footfix.motion.clip import Floats

_SOONEST = 0.25  # [s] shortest time in which parameters change
# fastest changes that planted feet can follow
_TURN_RATE = np.radians(150.0)  # [rad/s^2] of the turn
_SPEED_RATE = 0.5  # [sqrt(g l)/s] of the speed
_RUN_RATE = 0.7  # [1/s] of the share of running
_COMMITTED = 0.07  # [s] this long before a foot is set down its place is final
_SETTLING = 0.2  # [s] before that, over which it changes less and less
_BRIEFEST = 0.03  # [s] shorter predicted contacts are ignored
_PAST = 0.25  # [s] of the past included in a course
_RESIDUAL = 0.3  # [s] longest fade-out of the offset left by a change of plan
_SOON = 0.01  # [s] shortest such fade-out


@dataclass(frozen=True, eq=False)
class Residual:
    """Offsets of the feet left over from an earlier plan, which fade out (G eq. 11).

    Args:
        since: [s].
        until: (L, Q) [s] when it is gone.
        value: (L, Q, 3) what was left over.
    """

    since: float
    until: Floats
    value: Floats

    def faded(self, off: Floats, times: Floats) -> Floats:
        """Add the fading offsets to the planned ones (T, L, Q, 3) at times (T,)."""
        return replanned(off, (times[:, None, None] - self.since) / (self.until - self.since), self.value)


@dataclass(frozen=True, eq=False)
class Prediction:
    """The prediction for an unchanged request.

    Args:
        course: phase, place and heading.
        feet: the coming stances.
        residual: offsets left from an earlier plan.
    """

    course: Course
    feet: Feet
    residual: Residual | None = None

    def offsets_at(self, times: Floats, pose: LegPoses) -> Floats:
        """Compute the offsets of feet from the cycle's leg poses at times (T,) [s], (T, L, Q, 3)."""
        off = self.feet.offsets_at(times, pose)
        return off if self.residual is None else self.residual.faded(off, times)


def predict(model: CycleModel, plan: Plan, line: Line | None, start: Point, until: float) -> Prediction:
    """Predict the course of a plan, and where the feet will be planted.

    Args:
        model: the figure and its cycles.
        plan: what is asked for.
        line: the path to go along, if any.
        start: where the course is known.
        until: [s].
    """
    slow = 1.3 / float(model.frequency(plan.at(np.array([start.time])))[0])
    course = _course(model, plan, line, start, until, slow)
    stances = [each for own in timetable(model, course, until) for each in own]
    poses = leg_poses(model, course, sample_times(stances).ravel())
    return Prediction(course, _feet(model, settled(stances, [0.0] * len(stances), poses, model)))


def _course(model: CycleModel, plan: Plan, line: Line | None, start: Point, until: float, past: float) -> Course:
    """Predict the course, with some of the past [s], until feet planted at its end are lifted again."""
    slow = 1.0 / float(model.frequency(plan.at(np.array([until])))[0])
    return make_course(plan, line, start, until + slow, start.time - past, model.frequency)


def _feet(model: CycleModel, stances: Sequence[Stance]) -> Feet:
    legs = range(len(model.rig.legs))
    return make_feet([sorted((s for s in stances if s.leg == k), key=lambda s: s.count) for k in legs])


def changed_plan(model: CycleModel, plan: Plan, now: float, ends: Floats, target: Plan) -> Plan:
    """Make the plan whose parameters change to a target (one row), each by a time, or as soon as feet can follow.

    Args:
        model: the figure and its cycles.
        plan: what was asked for.
        now: [s].
        ends: (3 + S,) [s] when speed, run, turn and styles are to have got there; nan for those that go on as planned.
        target: what they are to become.
    """
    here = plan.at(np.array([now]))
    needed = np.zeros(len(ends))
    needed[0] = (target.speed[0] - here.speed[0]) / (_SPEED_RATE * model.froude)
    needed[1] = (target.run[0] - here.run[0]) / _RUN_RATE
    needed[2] = (target.turn[0] - here.turn[0]) / _TURN_RATE
    return plan.changed(now, np.maximum(ends, now + np.maximum(np.abs(needed), _SOONEST)), target)


@dataclass(frozen=True, eq=False)
class Replanning:
    """The first step of replanning: the course, and the times of stances on it.

    Args:
        now: [s] the time from which on it holds.
        course: phase, place and heading.
        over: stances that have ended, but still affect a foot.
        stances: present and coming ones, new ones without places.
        stays: (n,) share of its known place that each of them keeps.
    """

    now: float
    course: Course
    over: Sequence[Stance]
    stances: Sequence[Stance]
    stays: Sequence[float]


def begin_replanning(model: CycleModel, old: Prediction, plan: Plan, now: float, until: float) -> Replanning:
    """Step 1 of replanning: compute the course and the times of stances from a time on.

    Planted feet stay, and a foot about to be set down keeps its planned place. Others get new places.

    Args:
        model: the figure and its cycles.
        old: the earlier prediction.
        plan: the request; unchanged up to now.
        now, until: [s].
    """
    course = _course(model, plan, old.course.line, old.course.point(now), until, _PAST)
    over, stances, stays = _coming(old.feet, timetable(model, course, until), now)
    return Replanning(now, course, over, stances, stays)


def posed(model: CycleModel, replanning: Replanning) -> LegPoses:
    """Step 2 of replanning: pose the legs at the stances' sample times."""
    return leg_poses(model, replanning.course, sample_times(replanning.stances).ravel())


def placed(model: CycleModel, replanning: Replanning, poses: LegPoses) -> Feet:
    """Step 3 of replanning: choose the places of the feet."""
    return _feet(model, [*replanning.over, *settled(replanning.stances, replanning.stays, poses, model)])


def with_offsets(model: CycleModel, replanning: Replanning, feet: Feet, times: Floats) -> OffsetPostures:
    """Step 4 of replanning: compute frames at the time of the change, and at later times (T,) [s]."""
    soon = np.concatenate([[replanning.now], times])
    cycle = cycle_postures(model, replanning.course, soon)
    return OffsetPostures(soon, cycle, feet.offsets_at(soon, cycle.legs))


def finish(
    old: Prediction, replanning: Replanning, feet: Feet, soon: OffsetPostures
) -> tuple[Prediction, OffsetPostures]:
    """Step 5 of replanning: complete the prediction.

    Offsets of feet by the earlier plan fade out (G eq. 11, corrected: as printed it jumps).

    Args:
        old: the earlier prediction.
        replanning: from `begin_replanning`.
        feet: from `placed`.
        soon: from `with_offsets`.

    Returns:
        The prediction, and the frames without that of the change.
    """
    was = old.offsets_at(soon.times[:1], soon.cycle.legs.some(slice(0, 1)))[0]
    residual = _residual(was - soon.off[0], feet, replanning.now)
    times = soon.times[1:]
    off = residual.faded(soon.off[1:], times)
    return Prediction(replanning.course, feet, residual), OffsetPostures(times, soon.cycle.some(slice(1, None)), off)


def _coming(
    feet: Feet, expected: Sequence[Sequence[Stance]], now: float
) -> tuple[list[Stance], list[Stance], list[float]]:
    """List ended stances that still affect a foot, present and coming ones, and the share of its place each keeps."""
    over, stances, stays = list[Stance](), list[Stance](), list[float]()
    for known, coming in zip(feet.stances, expected, strict=True):
        over += [each for each in known if now - 2.0 * SIGMA < each.end <= now]
        before = {each.count: each for each in known}
        for each in coming:
            old = before.get(each.count)
            left = np.inf if old is None else old.start - now - _COMMITTED
            if old is not None and left <= 0.0:
                if old.end > now:
                    stances.append(_kept(old, each, now))
                    stays.append(1.0)
            elif each.end > now:
                stances.append(each if old is None else replace(each, points=old.points, frames=old.frames))
                stays.append(max(1.0 - left / _SETTLING, 0.0))
    return over, stances, stays


def _kept(old: Stance, new: Stance, now: float) -> Stance:
    """Give a planted stance its new times, except for what has begun or ended already."""

    def span(was: Span | None, becomes: Span | None) -> Span | None:
        if was is None or was[0] > now:
            return becomes if becomes is None else (max(becomes[0], now), max(becomes[1], now + 1e-3))
        if was[1] <= now or becomes is None:
            return (was[0], max(min(was[1], now + _BRIEFEST), was[0] + 1e-3)) if was[1] > now else was
        return (was[0], max(becomes[1], now + 1e-3))

    return replace(old, heel=span(old.heel, new.heel), toe=span(old.toe, new.toe))


def timetable(model: CycleModel, course: Course, until: float) -> list[list[Stance]]:
    """Compute the times of each foot's stances from the contact phases of the cycles; without places.

    Each foot has one stance that begins after `until` [s], since its swing leads there.
    """
    spans = model.contact_phases(course.asked)
    set_down = course.known[:, :1] - spans[:, :, 0]
    lifted = set_down - spans[:, :, 1]
    low, high = int(np.floor(set_down[0].min())), int(np.ceil(set_down[-1].max()))
    counts = np.arange(low, high + 1)
    times: dict[tuple[int, str], list[Span | None]] = {}
    for e, sole in enumerate(model.rig.soles):
        begin = np.interp(counts, set_down[:, e], course.grid, right=np.inf).tolist()
        end = np.interp(counts, lifted[:, e], course.grid, left=-np.inf).tolist()
        times[sole.leg, sole.part] = [(a, b) if b - a >= _BRIEFEST else None for a, b in zip(begin, end, strict=True)]
    found = []
    for leg in range(len(model.rig.legs)):
        pairs = zip(counts, times[leg, "heel"], times[leg, "toe"], strict=True)
        own = [Stance(leg, int(k), heel, toe) for k, heel, toe in pairs if heel is not None or toe is not None]
        later = [k for k, each in enumerate(own) if each.start > until]
        found.append(own[: later[0] + 1] if later else own)
    return found


def _residual(gap: Floats, feet: Feet, now: float) -> Residual:
    """Make the residual of offsets (L, Q, 3), which fades out until the next contact begins."""
    until = np.empty(gap.shape[:2])
    for leg, own in enumerate(feet.stances):
        begins = [[span[0] for each in own if (span := each.spans[k]) is not None] for k in range(4)]
        # by which end a foot is led makes no difference while both are planted, and only then
        alone = [each.start for each in own] + [each.flat[1] for each in own if each.flat is not None]
        for q, times in enumerate((*begins, alone, begins[0], ())):
            coming = min((time for time in times if time > now), default=np.inf)
            until[leg, q] = now + min(max(coming - now, _SOON), _RESIDUAL)
    return Residual(now, until, gap)


def postures(model: CycleModel, prediction: Prediction, times: Floats) -> Postures:
    """Make the postures at some times (T,) [s], with planted feet held."""
    cycle = cycle_postures(model, prediction.course, times)
    return held(model, prediction.feet, OffsetPostures(times, cycle, prediction.offsets_at(times, cycle.legs)))

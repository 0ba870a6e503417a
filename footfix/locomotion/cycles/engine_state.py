"""The state of a running engine: frames one after another, while requests change.

The future is predicted, and predicted again when the request changes, in five parts over five frames. Frames in the
meantime follow the earlier prediction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footfix.locomotion.cycles.engine import (
    Replanning,
    begin_replanning,
    changed_plan,
    finish,
    placed,
    posed,
    postures,
    predict,
    with_offsets,
)
from footfix.locomotion.cycles.foot_offsets import Feet
from footfix.locomotion.cycles.leg_pose import LegPoses
from footfix.locomotion.cycles.model import CycleModel
from footfix.locomotion.cycles.plan import Line, Plan, Point
from footfix.locomotion.cycles.postures import OffsetPostures, Postures, held
from footfix.motion.clip import Bools, Floats

_KNOWN = 0.9  # [s] how far is predicted after a change of the request
_LEAST = 0.45  # [s] when only this is left, the prediction is renewed,
_LONG = 1.6  # [s] this far where the request has not changed
_PAST = 0.3  # [s] for which past requests are kept
_JOIN = 0.15  # [s] in which the motion catches up with a request made some frames ago
_BATCH = 5  # frames made at once, which costs little more than one frame
_BRIEF = 0.02  # [s] longer frames do two parts of the work each
_FRESH = 0.1  # [s] greatest age of a prediction while requests change all the time


@dataclass(frozen=True, eq=False)
class _Work:
    """A prediction in progress.

    Args:
        replanning: the first part.
        until: [s] how far.
        behind: (3 + S,) integrals of the requested parameters until then, minus those predicted; None without a new
            request.
        poses, feet, soon: the results of the next parts, once done.
    """

    replanning: Replanning
    until: float
    behind: Floats | None
    poses: LegPoses | None = None
    feet: Feet | None = None
    soon: OffsetPostures | None = None


class Live:
    """A figure animated frame by frame.

    Args:
        model: the figure and its cycles.
        plan: the request.
        line: the path to follow, if any.
    """

    def __init__(self, model: CycleModel, plan: Plan, line: Line | None) -> None:
        self.model = model
        self.time = 0.0
        self._until = _KNOWN
        self._since = -np.inf  # [s] when the last prediction for a changed request began
        self._far = 0.0  # [s] farthest that `ahead` was called for
        self.prediction = predict(model, plan, line, Point(), self._until)
        self._plan = plan  # the request
        self._ends = plan.ends()  # [s] when its targets were asked to be reached, even if too soon for feet to follow
        self._joined = -1.0, np.zeros(len(self._ends))  # [s] when it was last predicted, how far behind
        self._asked = False  # whether the request has changed since
        self._work: _Work | None = None
        self._made: tuple[Postures, int] | None = None  # frames, and which of them is the one now
        self._dt = 0.0  # [s] between the last two

    def ask(self, target: Plan, named: Bools, over: float) -> None:
        """Change the request from now on; parameters requested again without an earlier time are not changed.

        Args:
            target: one row of target parameters.
            named: (3 + S,) which of them.
            over: [s] how long it takes, or as long as feet need to follow.
        """
        row, last, end = target.table[0], self._plan.table[-1], self.time + over
        changed = named & ((row != last) | (end < self._ends))
        if changed.any():
            self._ends, self._asked = np.where(changed, end, self._ends), True
            target = Plan.of_table(target.times, np.where(changed, row, last)[None])
            plan = changed_plan(self.model, self._plan, self.time, np.where(changed, end, np.nan), target)
            self._plan = plan.since(self.time - _PAST)

    def step(self, dt: float) -> tuple[Postures, int]:
        """Advance by `dt` [s]; return frames, and the index of the new one."""
        steady, self._dt, self.time = dt == self._dt, dt, self.time + dt
        if self._work is not None and self._work.soon is not None and self.time >= self._work.replanning.now:
            self._made = self._finish(self._times(dt)), 0
            return self._made
        known = self._known()
        if known is None:
            self._made = postures(self.model, self.prediction, self._times(dt if steady else 0.0)), 0
        else:
            self._made = known
        if known is not None or not steady:  # there is time for a part of the work
            if self._work is not None or not steady or self._made[1] + 1 < len(self._made[0]):
                self._go_on(dt)
            if dt > _BRIEF:
                self._go_on(dt)
        return self._made

    def ahead(self, seconds: float, frames: int) -> Postures:
        """Predict the postures now and at even times from now on.

        They include the latest request, except while requests change all the time.
        """
        self._far = max(self._far, seconds)
        times = np.linspace(self.time, self.time + seconds, frames)
        changing = self._asked or self._work is not None
        if self._until - self.time >= seconds and (not changing or self.time - self._since <= _FRESH):
            return postures(self.model, self.prediction, times)
        self._drop()
        if self._begin(self.time):
            while self._work is not None and self._work.feet is None:
                self._go_on(0.0)
            self._made = None
            return self._finish(times)
        return postures(self.model, self.prediction, times)

    def _go_on(self, dt: float) -> None:
        """Do the next part of a prediction in progress, for frames `dt` [s] apart."""
        work = self._work
        if work is None:
            self._begin(_later(self.time, dt, 2 if dt > _BRIEF else 4)[-1])  # when the work is done
        elif work.poses is None:
            self._work = replace(work, poses=posed(self.model, work.replanning))
        elif work.feet is None:
            self._work = replace(work, feet=placed(self.model, work.replanning, work.poses))
        elif work.soon is None:
            times = _later(work.replanning.now, dt, _BATCH - 1)
            self._work = replace(work, soon=with_offsets(self.model, work.replanning, work.feet, np.array(times)))

    def _begin(self, now: float) -> bool:
        """Begin a prediction from a time on, if the request has changed, or too little is left."""
        least = max(_LEAST, self._far)
        if not self._asked and self._until - now >= least:
            return False
        plan, behind = self.prediction.course.plan, None
        if self._asked:
            behind = self._behind_at(now)
            plan = plan.joined(now, _JOIN, self._plan, behind)
        until = now + max(_KNOWN if self._asked else _LONG, least + _LEAST)
        replanning = begin_replanning(self.model, self.prediction, plan.since(now - _PAST), now, until)
        self._work, self._asked = _Work(replanning, until, behind), False
        return True

    def _behind_at(self, now: float) -> Floats:
        """Compute the integrals of the request minus those of the prediction at a time, (3 + S,)."""
        joined, behind = self._joined
        since = joined if now < joined + _JOIN else max(joined + _JOIN, now - _PAST)
        more = self._plan.sums(since, now) - self.prediction.course.plan.sums(since, now)
        return more + behind if since == joined else more

    def _finish(self, times: Floats) -> Postures:
        """Finish a prediction, and make frames at some times."""
        work = self._work
        assert work is not None and work.feet is not None
        soon = work.soon
        if soon is None or not np.array_equal(soon.times[1:], times):
            soon = with_offsets(self.model, work.replanning, work.feet, times)
        self.prediction, frames = finish(self.prediction, work.replanning, work.feet, soon)
        self._until, self._work = work.until, None
        if work.behind is not None:
            self._since, self._joined = work.replanning.now, (work.replanning.now, work.behind)
        return held(self.model, self.prediction.feet, frames)

    def _drop(self) -> None:
        """Drop a prediction in progress, which has to start at another time."""
        if self._work is not None:
            self._asked, self._work = True, None

    def _times(self, dt: float) -> Floats:
        """List the times of some frames, the first of them now."""
        now, *others = _later(self.time, dt, _BATCH - 1)
        return np.array([now, *(time for time in others if time < self._until)])

    def _known(self) -> tuple[Postures, int] | None:
        """Get the frame now, if it was made."""
        if self._made is None:
            return None
        found, k = self._made
        return (found, k + 1) if k + 1 < len(found) and found.times[k + 1] == self.time else None


def _later(time: float, dt: float, frames: int) -> list[float]:
    """List a time [s] and those of the next frames `dt` [s] apart, summed up as by `step`: equal to the last bit."""
    times = [time]
    while dt > 0.0 and len(times) <= frames:
        times.append(times[-1] + dt)
    return times

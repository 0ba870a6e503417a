"""The requests to the engine over time, and the resulting course: phase, place and heading.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 3 and 6.4.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from footfix.motion.clip import Floats, frozen

_STEP = 1.0 / 30.0  # [s] of the grid on which the course is known; between its times it is integrated exactly
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_NODES, _WEIGHTS = frozen(0.5 * (1.0 + _NODES)), frozen(0.5 * _WEIGHTS)  # of a step that goes from 0 to 1


class Line(Protocol):
    """A path over the floor by its arc length, as `Path` is."""

    def position(self, s: Floats) -> Floats:
        """(..., 2) [m] x and z."""

    def heading(self, s: Floats) -> Floats:
        """(...) [rad] about the vertical, 0 along z, growing to the left."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Parameters at some times; linear in between (G 6.4), constant before and after.

    Args:
        times: (K,) [s], ascending.
        speed: (K,) [m/s].
        run: (K,) 0 for a walk, 1 for a run.
        turn: (K,) [rad/s] to the left.
        style: (K, S) weights of the styles.
    """

    times: Floats
    speed: Floats
    run: Floats
    turn: Floats
    style: Floats

    def __post_init__(self) -> None:
        for name in _ROWS:
            value = getattr(self, name)
            if value.flags.writeable:  # of a part of what is read-only nothing need be done
                object.__setattr__(self, name, frozen(value))

    @classmethod
    def of_table(cls, times: Floats, table: Floats) -> Plan:
        """The plan of times (K,) and a `table` (K, 3 + S), which is not to be written to any more."""
        table.flags.writeable = False
        plan = cls(times, table[:, 0], table[:, 1], table[:, 2], table[:, 3:])
        plan.__dict__["table"] = table  # it need not be put together again
        return plan

    @cached_property
    def table(self) -> Floats:
        """(K, 3 + S) speed, run, turn and styles."""
        table = np.empty((len(self.times), 3 + self.style.shape[1]))
        table[:, 0], table[:, 1], table[:, 2], table[:, 3:] = self.speed, self.run, self.turn, self.style
        return table

    def at(self, times: Floats) -> Plan:
        """The parameters at other times (T,)."""
        return Plan.of_table(times, self.rows(times))

    def rows(self, times: Floats) -> Floats:
        """(T, 3 + S) what `table` is at other times (T,)."""
        known, table = self.times, self.table
        if len(known) == 1:
            rows = np.empty((len(times), table.shape[1]))
            rows[:] = table[0]
            return rows
        k = np.minimum(np.maximum(known.searchsorted(times, side="right") - 1, 0), len(known) - 2)
        low, first = known[k], table[k]
        share = np.minimum(np.maximum((times - low) / (known[k + 1] - low), 0.0), 1.0)[:, None]
        return np.asarray((1.0 - share) * first + share * table[k + 1])

    def of_speeds(self, speed: Floats) -> Plan:
        """The same with other speeds (K,) [m/s]."""
        return replace(self, speed=speed)

    def some(self, which: slice) -> Plan:
        """The parameters at some of the times."""
        return Plan.of_table(self.times[which], self.table[which])

    def since(self, time: float) -> Plan:
        """Drop requests that ended before a time [s]."""
        first = max(int(self.times.searchsorted(time, side="right")) - 1, 0)
        return self if first == 0 else self.some(slice(first, None))

    def ends(self) -> Floats:
        """(3 + S,) [s] the times at which speed, run, turn and styles are what they stay; -inf where always."""
        moving = self.table != self.table[-1]
        last = len(moving) - 1 - np.argmax(moving[::-1], axis=0)
        return np.where(moving.any(axis=0), self.times[np.minimum(last + 1, len(moving) - 1)], -np.inf)

    def changed(self, now: float, ends: Floats, target: Plan) -> Plan:
        """The plan as it was up to a time, from which on some parameters go to others.

        Args:
            now: [s] the time of the change.
            ends: (3 + S,) [s] when speed, run, turn and styles have got there; nan for those that go on as planned.
            target: one row, what they are to become.
        """
        named = ends == ends  # nan is not
        later = () if named.all() else self.times[int(self.times.searchsorted(now, side="right")) :].tolist()
        times = np.array(sorted({now, *ends[named].tolist(), *later}))
        was = self.rows(times)
        share = np.minimum((times[:, None] - now) / (ends - now), 1.0)
        rows = np.where(named, was[0] + share * (target.table[0] - was[0]), was)
        if len(times) > 2:
            slopes = (rows[1:] - rows[:-1]) / (times[1:] - times[:-1])[:, None]
            kept = np.ones(len(times), dtype=np.bool_)
            kept[1:-1] = (np.abs(slopes[1:] - slopes[:-1]) > 1e-9).any(axis=1)
            times, rows = times[kept], rows[kept]
        past = int(self.times.searchsorted(now - 1e-9))
        return Plan.of_table(np.concatenate([self.times[:past], times]), np.concatenate([self.table[:past], rows]))

    def joined(self, now: float, over: float, other: Plan, behind: Floats) -> Plan:
        """The plan that it was up to a time, and `over` [s] later is another one, having made up for what is `behind`.

        Args:
            now: [s].
            over: [s] in which it gets there.
            other: what it is to become.
            behind: (3 + S,) by how much the integrals of its rows are less than they ought to be; those of speed and
                turn are made up for, so that it goes on where it would be.
        """
        past, later = int(self.times.searchsorted(now - 1e-9)), int(other.times.searchsorted(now + over, side="right"))
        ends = np.array([now, now + over])
        here, there = self.rows(ends[:1]), other.rows(ends[1:])
        behind = behind + other.sums(now, now + over) - 0.5 * over * (here[0] + there[0])
        between = 0.5 * (here + there)
        between[:, :3:2] += behind[:3:2] * (2.0 / over)  # a triangle over what is in line
        between[:, 0] = np.maximum(between[:, 0], 0.0)
        times = np.concatenate([self.times[:past], [now, now + 0.5 * over, now + over], other.times[later:]])
        return Plan.of_table(times, np.concatenate([self.table[:past], here, between, there, other.table[later:]]))

    def sums(self, since: float, until: float) -> Floats:
        """(3 + S,) the integrals of its rows from one time to another [s]."""
        low, high = int(self.times.searchsorted(since, side="right")), int(self.times.searchsorted(until))
        times = np.array([since, *self.times[low:high].tolist(), until])
        rows = self.rows(times)
        return np.asarray(0.5 * (times[1:] - times[:-1]) @ (rows[1:] + rows[:-1]))


_ROWS = ("times", "speed", "run", "turn", "style")


@dataclass(frozen=True)
class Point:
    """Where a course is known: phase [cycles], arc length [m], heading [rad] and place (x, z) [m] at a time [s]."""

    time: float = 0.0
    phase: float = 0.0
    length: float = 0.0
    heading: float = 0.0
    x: float = 0.0
    z: float = 0.0


@dataclass(frozen=True, eq=False)
class Course:
    """Phase, place and heading over time, from a plan.

    Eq. 5 to 7 of G, summed up: the phase is the integral of the frequency, the heading that of the angular speed, the
    place that of the speed in the direction of the heading. As printed, eq. 7 takes the direction at the end of a step
    for all of it; here the arc is integrated, by Gauss's rule, which leaves nothing to be seen.

    Args:
        plan: what is asked for.
        line: the path that it goes along; None where `plan.turn` says where it goes.
        grid: (G,) [s].
        known: (G, 5) there: phase [cycles], arc length [m], heading [rad], and place, x and z [m].
        asked: what is asked for on the grid.
        frequency: [Hz] of parameters.
    """

    plan: Plan
    line: Line | None
    grid: Floats
    known: Floats
    asked: Plan
    frequency: Callable[[Plan], Floats]

    def at(self, times: Floats) -> tuple[Floats, Plan]:
        """Tell (T, 5) what `known` has, and what is asked for, at times (T,) [s]; on a path the place is the path's."""
        k = np.minimum(np.maximum(self.grid.searchsorted(times, side="right") - 1, 0), len(self.grid) - 1)
        known, asked = self.known[k], self.plan.rows(times)
        steps = _steps(self.frequency, self.asked.table[k], asked, times - self.grid[k])
        out = np.asarray(known + _headed(steps, known[:, 2]))
        if self.line is not None:
            out[:, 2], out[:, 3:] = self.line.heading(out[:, 1]), self.line.position(out[:, 1])
        return out, Plan.of_table(times, asked)

    def phases(self, times: Floats) -> Floats:
        """(T,) [cycles] since the course began, at times (T,) [s]."""
        return self.at(times)[0][:, 0]

    def lengths(self, times: Floats) -> Floats:
        """(T,) [m] gone."""
        return self.at(times)[0][:, 1]

    def where(self, times: Floats) -> tuple[Floats, Floats]:
        """(T, 2) [m] x and z, and (T,) [rad] the heading."""
        found, _ = self.at(times)
        return found[:, 3:], found[:, 2]

    def point(self, time: float) -> Point:
        """All of it at one time."""
        return Point(time, *self.at(np.array([time]))[0][0].tolist())


def make_course(
    plan: Plan, line: Line | None, start: Point, until: float, since: float, frequency: Callable[[Plan], Floats]
) -> Course:
    """Compute the course of a plan through a point.

    Args:
        plan: what is asked for.
        line: the path it goes along, if any.
        start: where it is known.
        until, since: [s] the times that it is wanted for.
        frequency: [Hz] of parameters.
    """
    count = max(1, int(np.ceil((until - since) / _STEP)))
    step = (until - since) / count
    knots = [knot for knot in plan.times.tolist() if since < knot < until]
    grid = np.array(sorted({since + k * step for k in range(count)} | {until, start.time, *knots}))
    at = int(grid.searchsorted(start.time))
    asked = plan.rows(grid)
    steps = _steps(frequency, asked[:-1], asked[1:], grid[1:] - grid[:-1])
    known = np.zeros((len(grid), 5))
    value = np.array((start.phase, start.length, start.heading, start.x, start.z))
    np.add.accumulate(steps[:, :3], axis=0, out=known[1:, :3])
    known[:, :3] += value[:3] - known[at, :3]
    np.add.accumulate(_headed(steps, known[:-1, 2])[:, 3:], axis=0, out=known[1:, 3:])
    known[:, 3:] += value[3:] - known[at, 3:]
    return Course(plan, line, grid, known, Plan.of_table(grid, asked), frequency)


def _steps(frequency: Callable[[Plan], Floats], first: Floats, last: Floats, lasts: Floats) -> Floats:
    """Integrate (T, 5) by how much phase, length, heading and place grow in steps, headed along z.

    Args:
        frequency: [Hz] of parameters.
        first, last: (T, 3 + S) parameters at the ends of the steps, in between linear, so that turns change evenly.
        lasts: (T,) [s].
    """
    change = last - first
    rows = first[:, None] + change[:, None] * _NODES[:, None]  # (T, 4, 3 + S)
    asked = Plan.of_table(np.empty(rows.shape[0] * rows.shape[1]), rows.reshape(-1, rows.shape[2]))
    angle = (lasts[:, None] * _NODES) * (first[:, 2:3] + (0.5 * _NODES) * change[:, 2:3])
    speed = rows[:, :, 0]
    out = np.empty((len(lasts), 5))
    out[:, 0] = frequency(asked).reshape(angle.shape) @ _WEIGHTS
    out[:, 1:3] = (first + 0.5 * change)[:, :3:2]
    out[:, 3] = (speed * np.sin(angle)) @ _WEIGHTS
    out[:, 4] = (speed * np.cos(angle)) @ _WEIGHTS
    out *= lasts[:, None]
    return out


def _headed(steps: Floats, heading: Floats) -> Floats:
    """Turn the places of steps (T, 5) to headings (T,)."""
    sine, cosine = np.sin(heading), np.cos(heading)
    x, z = steps[:, 3].copy(), steps[:, 4].copy()
    steps[:, 3], steps[:, 4] = x * cosine + z * sine, z * cosine - x * sine
    return steps

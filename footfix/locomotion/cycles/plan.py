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
        """Compute the places (..., 2) [m], x and z."""

    def heading(self, s: Floats) -> Floats:
        """Compute the heading (...) [rad] about the vertical, 0 along z, growing to the left."""


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
            if value.flags.writeable:  # a view of a read-only array is read-only already
                object.__setattr__(self, name, frozen(value))

    @classmethod
    def of_table(cls, times: Floats, table: Floats) -> Plan:
        """Make the plan of times (K,) and a `table` (K, 3 + S), which becomes read-only."""
        table.flags.writeable = False
        plan = cls(times, table[:, 0], table[:, 1], table[:, 2], table[:, 3:])
        plan.__dict__["table"] = table  # fills the cached property
        return plan

    @cached_property
    def table(self) -> Floats:
        """Join speed, run, turn and styles, (K, 3 + S)."""
        table = np.empty((len(self.times), 3 + self.style.shape[1]))
        table[:, 0], table[:, 1], table[:, 2], table[:, 3:] = self.speed, self.run, self.turn, self.style
        return table

    def at(self, times: Floats) -> Plan:
        """Compute the parameters at other times (T,)."""
        return Plan.of_table(times, self.rows(times))

    def rows(self, times: Floats) -> Floats:
        """Interpolate `table` at other times (T,), (T, 3 + S)."""
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
        """Replace the speeds (K,) [m/s]."""
        return replace(self, speed=speed)

    def some(self, which: slice) -> Plan:
        """Take the parameters at some of the times."""
        return Plan.of_table(self.times[which], self.table[which])

    def since(self, time: float) -> Plan:
        """Drop requests that ended before a time [s]."""
        first = max(int(self.times.searchsorted(time, side="right")) - 1, 0)
        return self if first == 0 else self.some(slice(first, None))

    def ends(self) -> Floats:
        """Find when speed, run, turn and styles get to their final values, (3 + S,) [s]; -inf where always."""
        moving = self.table != self.table[-1]
        last = len(moving) - 1 - np.argmax(moving[::-1], axis=0)
        return np.where(moving.any(axis=0), self.times[np.minimum(last + 1, len(moving) - 1)], -np.inf)

    def changed(self, now: float, ends: Floats, target: Plan) -> Plan:
        """Lead some parameters from their values at a time to others; the plan before that time stays.

        Args:
            now: [s] the time of the change.
            ends: (3 + S,) [s] when speed, run, turn and styles reach the target; nan for those that go on as planned.
            target: one row of target values.
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
        """Change over to another plan within `over` [s], catching up with what is `behind`.

        Args:
            now: [s].
            over: [s] duration of the change.
            other: the plan after it.
            behind: (3 + S,) by how much the integrals of this plan's rows are behind those of the other's; speed and
                turn catch up, so that the figure arrives where the other plan has it.
        """
        past, later = int(self.times.searchsorted(now - 1e-9)), int(other.times.searchsorted(now + over, side="right"))
        ends = np.array([now, now + over])
        here, there = self.rows(ends[:1]), other.rows(ends[1:])
        behind = behind + other.sums(now, now + over) - 0.5 * over * (here[0] + there[0])
        between = 0.5 * (here + there)
        between[:, :3:2] += behind[:3:2] * (2.0 / over)  # the area of this triangle is what is behind
        between[:, 0] = np.maximum(between[:, 0], 0.0)
        times = np.concatenate([self.times[:past], [now, now + 0.5 * over, now + over], other.times[later:]])
        return Plan.of_table(times, np.concatenate([self.table[:past], here, between, there, other.table[later:]]))

    def sums(self, since: float, until: float) -> Floats:
        """Integrate the rows from one time to another [s], (3 + S,)."""
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
    place that of the speed in the direction of the heading. As printed, eq. 7 uses the direction at the end of a step
    for the whole step; here the arc is integrated by Gaussian quadrature, with an error too small to be seen.

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
        """Compute (T, 5), as `known` has it, and the requests at times (T,) [s]; on a path the place is the path's."""
        k = np.minimum(np.maximum(self.grid.searchsorted(times, side="right") - 1, 0), len(self.grid) - 1)
        known, asked = self.known[k], self.plan.rows(times)
        steps = _steps(self.frequency, self.asked.table[k], asked, times - self.grid[k])
        out = np.asarray(known + _headed(steps, known[:, 2]))
        if self.line is not None:
            out[:, 2], out[:, 3:] = self.line.heading(out[:, 1]), self.line.position(out[:, 1])
        return out, Plan.of_table(times, asked)

    def phases(self, times: Floats) -> Floats:
        """Compute the phases (T,) [cycles] since the course began, at times (T,) [s]."""
        return self.at(times)[0][:, 0]

    def lengths(self, times: Floats) -> Floats:
        """Compute the arc lengths (T,) [m] at times (T,) [s]."""
        return self.at(times)[0][:, 1]

    def where(self, times: Floats) -> tuple[Floats, Floats]:
        """Compute the places (T, 2) [m], x and z, and the headings (T,) [rad]."""
        found, _ = self.at(times)
        return found[:, 3:], found[:, 2]

    def point(self, time: float) -> Point:
        """Compute the point of the course at one time."""
        return Point(time, *self.at(np.array([time]))[0][0].tolist())


def make_course(
    plan: Plan, line: Line | None, start: Point, until: float, since: float, frequency: Callable[[Plan], Floats]
) -> Course:
    """Compute the course of a plan through a point.

    Args:
        plan: what is asked for.
        line: the path it goes along, if any.
        start: where it is known.
        until, since: [s] end and start of the course.
        frequency: computes the frequency [Hz] for parameters.
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
    """Compute how much phase, length, heading and place grow in steps that start along z, (T, 5).

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

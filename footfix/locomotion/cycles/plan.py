"""What is asked of the engine at which time, and the course that makes of it: phase, place and heading.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 3 and 6.4.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from footfix.motion.clip import Floats, Ints, frozen

_STEP = 1.0 / 60.0  # [s] of the grid on which the course is known; between its times it is integrated exactly
_GAUSS = np.polynomial.legendre.leggauss(4)


class Line(Protocol):
    """A path over the floor by its arc length, as `Path` is."""

    def place(self, s: Floats) -> Floats:
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
        for name in ("times", "speed", "run", "turn", "style"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def at(self, times: Floats) -> Plan:
        """The parameters at other times (T,)."""
        speed, run, turn = (np.interp(times, self.times, each) for each in (self.speed, self.run, self.turn))
        style = [np.interp(times, self.times, each) for each in self.style.T]
        return Plan(times, speed, run, turn, np.stack(style, axis=1) if style else np.zeros((len(times), 0)))

    def of_speeds(self, speed: Floats) -> Plan:
        """The same with other speeds (K,) [m/s]."""
        return replace(self, speed=speed)

    def changed(self, now: float, over: float, target: Plan) -> Plan:
        """The plan as it was up to a time, from which on its parameters go to others within `over` [s].

        Args:
            now: [s] the time of the change.
            over: [s] how long it takes.
            target: one row, what they are to become.
        """
        kept = self.times < now - 1e-9
        parts = [replace(self, **{n: getattr(self, n)[kept] for n in _ROWS}), self.at(np.array([now])),
                 replace(target, times=np.array([now + over]))]  # fmt: skip
        return Plan(*(np.concatenate([getattr(part, name) for part in parts]) for name in _ROWS))


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
    """Phase, place and heading over time, as a plan has them.

    Eq. 5 to 7 of G, summed up: the phase is the integral of the frequency, the heading that of the angular speed, the
    place that of the speed in the direction of the heading. As printed, eq. 7 takes the direction at the end of a step
    for all of it; here the arc is integrated, by Gauss's rule, which leaves nothing to be seen.

    Args:
        plan: what is asked for.
        line: the path that it goes along; None where `plan.turn` says where it goes.
        grid: (G,) [s].
        phase, length, heading: (G,) [cycles], [m], [rad].
        place: (G, 2) [m] x and z.
        frequency: [Hz] of parameters.
    """

    plan: Plan
    line: Line | None
    grid: Floats
    phase: Floats
    length: Floats
    heading: Floats
    place: Floats
    frequency: Callable[[Plan], Floats]

    def phases(self, times: Floats) -> Floats:
        """(T,) [cycles] since the course began, at times (T,) [s]."""
        k, low = self._before(times)
        return np.asarray(self.phase[k] + self._integral(low, times, self.frequency))

    def lengths(self, times: Floats) -> Floats:
        """(T,) [m] gone."""
        k, low = self._before(times)
        return np.asarray(self.length[k] + self._integral(low, times, lambda plan: plan.speed))

    def where(self, times: Floats) -> tuple[Floats, Floats]:
        """(T, 2) [m] x and z, and (T,) [rad] the heading."""
        if self.line is not None:
            s = self.lengths(times)
            return np.asarray(self.line.place(s)), np.asarray(self.line.heading(s))
        k, low = self._before(times)
        place = self.place[k] + _arc(self.plan, self.heading[k], low, times)
        return place, self.heading[k] + self._integral(low, times, lambda plan: plan.turn)

    def point(self, time: float) -> Point:
        """All of it at one time."""
        at = np.array([time])
        place, heading = self.where(at)
        x, z = place[0]
        return Point(time, float(self.phases(at)[0]), float(self.lengths(at)[0]), float(heading[0]), float(x), float(z))

    def _before(self, times: Floats) -> tuple[Ints, Floats]:
        k = np.clip(np.searchsorted(self.grid, times, side="right") - 1, 0, len(self.grid) - 1)
        return k, self.grid[k]

    def _integral(self, low: Floats, high: Floats, value: Callable[[Plan], Floats]) -> Floats:
        return _quadrature(self.plan, low, high, value)


def make_course(
    plan: Plan, line: Line | None, start: Point, until: float, since: float, frequency: Callable[[Plan], Floats]
) -> Course:
    """The course of a plan that goes through a point.

    Args:
        plan: what is asked for.
        line: the path it goes along, if any.
        start: where it is known.
        until, since: [s] the times that it is wanted for.
        frequency: [Hz] of parameters.
    """
    count = max(1, int(np.ceil((until - since) / _STEP)))
    knots = plan.times[(plan.times > since) & (plan.times < until)]
    grid = np.unique(np.concatenate([np.linspace(since, until, count + 1), knots, [start.time]]))
    low, high = grid[:-1], grid[1:]
    at = int(np.searchsorted(grid, start.time))

    def summed(steps: Floats, value: object) -> Floats:
        total = np.concatenate([np.zeros((1, *steps.shape[1:])), np.cumsum(steps, axis=0)])
        return np.asarray(total - total[at] + value)

    nodes, weights = _GAUSS
    half = 0.5 * (high - low)
    times = (low + half)[:, None] + half[:, None] * nodes
    asked = plan.at(times.ravel())
    speed, turn = asked.speed.reshape(times.shape), asked.turn.reshape(times.shape)
    phase = summed(frequency(asked).reshape(times.shape) @ weights * half, start.phase)
    length = summed(speed @ weights * half, start.length)
    heading = summed(turn @ weights * half, start.heading)
    first = plan.at(low).turn[:, None]
    angle = heading[:-1, None] + 0.5 * (first + turn) * (times - low[:, None])  # turns change evenly in between
    steps = np.stack([(speed * part(angle)) @ weights * half for part in (np.sin, np.cos)], axis=1)
    place = summed(steps, np.array([start.x, start.z]))
    return Course(plan, line, grid, phase, length, heading, place, frequency)


def _quadrature(plan: Plan, low: Floats, high: Floats, value: Callable[[Plan], Floats]) -> Floats:
    """(T,) integrals of a parameter from times (T,) to times (T,), between which the plan has no knot."""
    nodes, weights = _GAUSS
    half = 0.5 * (high - low)
    times = (low + half)[:, None] + half[:, None] * nodes
    values = value(plan.at(times.ravel())).reshape(times.shape)
    return np.asarray((values @ weights) * half)


def _arc(plan: Plan, heading: Floats, low: Floats, high: Floats) -> Floats:
    """(T, 2) [m] x and z of the way from times to times, begun at headings (T,)."""
    nodes, weights = _GAUSS
    half = 0.5 * (high - low)
    times = (low + half)[:, None] + half[:, None] * nodes
    asked = plan.at(times.ravel())
    first = plan.at(low).turn[:, None]
    angle = heading[:, None] + 0.5 * (first + asked.turn.reshape(times.shape)) * (times - low[:, None])
    speed = asked.speed.reshape(times.shape)
    return np.stack([(speed * part(angle)) @ weights * half for part in (np.sin, np.cos)], axis=1)

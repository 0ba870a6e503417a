"""Enforcement in a window: the least squares of `enforce` on the newest frames, with frames already shown fixed.

A window begins with two frames that were shown, so that neither place nor speed jumps, and ends with the newest frame.
It starts from the solution of the window before, so that one round is enough; each frame is in several windows before
it is shown. Where a strike is elsewhere or earlier than planned, the motion to it is planned again from the foot's
present place and speed (as G eq. 11 does with an ease).
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce import solve
from footfix.enforce.easing import gamma
from footfix.enforce.leg import ANKLE, LEG, ROOT, TOE
from footfix.enforce.params import EnforceParams
from footfix.enforce.problem import Problem
from footfix.enforce.standing_heights import nominal
from footfix.enforce.whole_clip import costs_of, faded
from footfix.motion.clip import Bools, Floats
from footfix.motion.kinematics import Pose
from footfix.stream.calibration import Calibration
from footfix.stream.gauss_newton import Fixed, descend
from footfix.stream.leg_rotations import Turned, Turner
from footfix.stream.legs import Legs, own_of, places_of, states_of
from footfix.stream.pins import Asked, Stacked, pins_of
from footfix.stream.plants import FootPlants, Ground, follow
from footfix.stream.toe_lock import exact

_FIRST = 8e-4  # [m/s] of slip below which its cost is a parabola, in the first round of the last window
_LAST_ROUNDS = 6  # rounds of that window's solution
BEFORE = 2  # frames that were shown, in a window
_FORGETS = 3.0  # [s] over which the usual fault of plants is averaged
_CAUGHT_UP = 0.01  # [leg lengths] a released foot may be planted again once it is this near to its capture
_RAISED = 0.5  # [s] over which a figure is raised to its floor


@dataclass(frozen=True, eq=False)
class Settled:
    """The solution for n frames to be given out.

    Args:
        shift: (n, 3) [m] of the root.
        turned: the legs' joints.
        on: (n, 2 legs) when heel and toe of each are planted, without feet that could not reach their place in time.
    """

    shift: Floats
    turned: Turned
    on: Bools


class Window:
    """The enforcement of one figure in a stream."""

    def __init__(
        self, known: Calibration, translates: bool, turner: Turner, frame_time: float, params: EnforceParams, first: int
    ) -> None:
        """Begin with frame number `first`; nothing was shown yet.

        Args:
            known: the calibrated figure.
            translates: whether its root can be moved.
            turner: what turns its joints.
            frame_time: [s].
            params: how contacts are enforced.
            first: number of the first frame that may be changed.
        """
        self._known, self._translates, self._frame_time, self._params = known, translates, frame_time, params
        self._turner, self._costs = turner, costs_of(params)
        rig, heights = known.rig, params.heights == "floor"
        at_floor = np.array([nominal(rig, e) for e in range(len(rig.soles))])
        order = [next(e for e, s in enumerate(rig.soles) if (s.leg, s.part) == (k, part))
                 for k in range(len(rig.legs)) for part in ("heel", "toe")]  # fmt: skip
        self._ground = Ground(
            rest=known.rest[order].reshape(-1, 2), nominal=at_floor[order].reshape(-1, 2), tips=known.tips,
            near=params.pins.near * rig.leg_length, sink=params.pins.sink * rig.leg_length, leg_length=rig.leg_length,
            frame_time=frame_time, heights=heights,
        )  # fmt: skip
        self._feet = [FootPlants() for _ in rig.legs]
        self._first, self._seen, self._fault = first, first, known.fault
        self._x = np.zeros((ROOT + LEG * len(rig.legs), 0))  # of the frames of the window before
        self.belt = known.belt  # (3,) [m/s] of the ground under plants to come
        self.left = [False] * len(rig.legs)  # released feet that have not caught up with their capture
        self._fixed: dict[int, Fixed] = {}  # for windows of so many frames
        self._problems: dict[int, Problem] = {}  # of these windows
        self._begin = self._shown = first  # numbers of the first of these, and of the first that was not shown

    @property
    def feet(self) -> Sequence[FootPlants]:
        """Get the plants of each foot as shown."""
        return self._feet

    def lifted(self, legs: Legs, first: int) -> tuple[Legs, Floats]:
        """Raise a figure that floats or is sunk, gradually from the beginning.

        Args:
            legs: as captured, n frames.
            first: number of the first of them.

        Returns:
            The legs, and (n,) [m] by how much they were raised.
        """
        n = legs.flexion.shape[1]
        if not self._known.lift or not self._translates or self._params.heights != "floor":
            return legs, np.zeros(n)
        since = (first - self._first + np.arange(n)) * self._frame_time
        lift = np.asarray(self._known.lift * (1.0 - gamma(np.asarray(since / _RAISED, dtype=np.float64))))
        return legs.raised(lift), lift

    def solve(
        self, legs: Legs, pose: Pose, on: Bools, first: int, *, last: bool = False
    ) -> Generator[None, None, Settled]:
        """Solve for the newest frames, and finish those that are given out now; yield before and after the round.

        Args:
            legs: as captured and lifted, n frames.
            pose: as captured, of those frames that go out now.
            on: (n, 2 legs) when heel and toe of each are planted.
            first: number of the first frame: at most two before the first that was not shown.
            last: whether no frames follow.
        """
        n = len(on)
        window = first + np.arange(n)
        past = min(max(self._shown - first, 0), n)
        shown = slice(past, past + len(pose.positions))
        x = self._started(first, n)
        captured, at = legs.places(), states_of(legs, x[:ROOT], own_of(x))
        asked = Asked(captured, at.places, window, self._ground, self.belt * self._frame_time, self._params.pins)
        pins = pins_of(self._feet, legs, on, asked)
        yield
        problem = self._problem(legs, captured, int(window[-1]), last=last)
        if last and n > BEFORE + 1:  # the only one that no frame waits for
            problem = replace(problem, pins=pins.apart(legs.kinds.tips))
            x = solve.descend(problem, x, _LAST_ROUNDS, first=_FIRST, last=_LAST_ROUNDS, fixed=window < self._shown)
        elif n > BEFORE + 1:
            fixed = self._same(problem, n)
            x = descend(problem, x, past, legs=legs, pins=pins, fixed=fixed, at=at)
            yield
        x[:, shown] = exact(
            legs.frames(shown), x[:, shown], pins.place[:, TOE, :, shown], pins.placed[TOE, :, shown] > 0.0,
            [foot.stands(TOE) for foot in self._feet], self._ground.leg_length, self._frame_time,
        )  # fmt: skip
        state = faded(x, problem)[:, shown]
        turned = self._turner.turn(pose, legs.frames(shown), state)
        on = _in_time(on, turned.late, past)
        self._follow(pins, on, shown, places_of(legs, x[:ROOT], own_of(x)), asked)
        self._x, self._begin, self._shown = x, first, first + shown.stop
        return Settled(state[:ROOT].T, turned, on[shown])

    def _follow(self, pins: Stacked, on: Bools, shown: slice, places: Floats, asked: Asked) -> None:
        """Update plants after frames were shown, with their points at places (3, P, L, n) [m]."""
        near = _CAUGHT_UP * self._ground.leg_length
        for k, foot in enumerate(self._feet):
            self._feet[k] = foot = follow(
                foot, k, asked.captured[:, :, k], places[:, :, k], (pins.place[:, :, k], pins.placed[:, k]),
                on[:, 2 * k : 2 * k + 2], asked.window, shown, self._ground, asked.belt,
            )  # fmt: skip
            off = (places - asked.captured)[::2, :ANKLE, k, shown.stop - 1]
            self.left[k] = foot.left or (self.left[k] and bool(np.any(np.hypot(*off) > near)))

    def _problem(self, legs: Legs, captured: Floats, newest: int, *, last: bool) -> Problem:
        """Make the problem of a window; its pins, and its legs unless it is the last, come from elsewhere."""
        n, fault = legs.flexion.shape[1], self._usual_fault(captured, newest)
        if last or n not in self._problems:
            self._problems[n] = Problem(
                legs.apart(), (), self._frame_time, self._known.rig.leg_length, self._costs, self._known.noise,
                self._known.white, np.zeros(n), self._translates, onward=not last,
            )  # fmt: skip
        return replace(self._problems[n], fault=np.full(n, fault))

    def _same(self, problem: Problem, n: int) -> Fixed:
        """Get what is the same in all windows of n frames."""
        if n not in self._fixed:
            self._fixed[n] = Fixed.of(problem)
        return self._fixed[n]

    def _started(self, first: int, n: int) -> Floats:
        """Get the last solution (U, n) for these frames; the newest ones repeat its last state."""
        x = np.zeros((len(self._x), n))
        known = self._x[:, max(first - self._begin, 0) :][:, :n]
        x[:, : known.shape[1]] = known
        if known.shape[1]:
            x[:, known.shape[1] :] = known[:, -1:]
        return x

    def _usual_fault(self, captured: Floats, newest: int) -> float:
        """Estimate the usual fault of plants [m], from present and recent ones."""
        now = 0.0
        for k, foot in enumerate(self._feet):
            for point, plant in enumerate(foot.plants[:2]):
                if plant is not None and plant.place is not None and not plant.free:
                    now = max(now, plant.off(captured[:, point, k, -1], newest))
        kept = np.exp(-(newest + 1 - self._seen) * self._frame_time / _FORGETS)
        self._seen = newest + 1
        self._fault = max(now, self._known.fault + (self._fault - self._known.fault) * kept)
        return self._fault


def _in_time(on: Bools, late: Bools, past: int) -> Bools:
    """Drop the contacts (n, 2 legs) of legs that are late (L, m), in the frames from `past` on."""
    on = on.copy()
    for k in np.flatnonzero(late.any(axis=1)).tolist():
        behind = past + np.flatnonzero(late[k])
        on[behind[0] : behind[-1] + 1, 2 * k : 2 * k + 2] = False
    return on

"""Enforcement in a window: the least squares of a whole clip on the newest frames, those that were shown held fixed.

A window begins with two frames that were shown, so that neither place nor speed jumps, and ends with the newest one.
It starts from what was found for it a moment before, so that a round or two are enough; each frame is in several
windows before it is shown. Where a strike turns out to be elsewhere, or earlier, than it was planned, the way to it
begins anew from where the foot is by then, at the speed it has (what G eq. 11 does with an ease).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.enforce.floors import nominal
from footfix.enforce.leg import LEG, ROOT, LegTracks, raise_leg
from footfix.enforce.papers.ease import gamma
from footfix.enforce.params import EnforceParams
from footfix.enforce.problem import Problem
from footfix.enforce.whole_clip import costs_of, faded
from footfix.motion.clip import Bools, Floats, Ints
from footfix.stream.calibration import Calibration
from footfix.stream.descent import descend
from footfix.stream.held import Foot, Ground, follow
from footfix.stream.objective import Legs, places_of
from footfix.stream.pins import pins_of

BEFORE = 2  # frames that were shown, in a window
_ROUNDS, _LAST_ROUNDS = 2, 6  # a window, and of the last one
_FORGETS = 3.0  # [s] in which the fault that plants usually have is learnt anew
_RAISED = 0.5  # [s] in which a figure is raised to its floor


class Window:
    """The enforcement of one figure in a stream."""

    def __init__(
        self, known: Calibration, translates: bool, frame_time: float, params: EnforceParams, first: int
    ) -> None:
        """Begin with frame number `first`; nothing was shown yet.

        Args:
            known: the figure.
            translates: whether its root can be moved.
            frame_time: [s].
            params: how contacts are enforced.
            first: number of the first frame that may be changed.
        """
        self._known, self._translates, self._frame_time, self._params = known, translates, frame_time, params
        rig, heights = known.rig, params.heights == "floor"
        at_floor = np.array([nominal(rig, e) for e in range(len(rig.soles))])
        order = [next(e for e, s in enumerate(rig.soles) if (s.leg, s.part) == (k, part))
                 for k in range(len(rig.legs)) for part in ("heel", "toe")]  # fmt: skip
        self._ground = Ground(
            rest=known.rest[order].reshape(-1, 2), nominal=at_floor[order].reshape(-1, 2), tips=known.tips,
            near=params.pins.near * rig.leg_length, sink=params.pins.sink * rig.leg_length, leg_length=rig.leg_length,
            frame_time=frame_time, heights=heights,
        )  # fmt: skip
        self._feet = [Foot() for _ in rig.legs]
        self._first, self._seen, self._fault = first, first, known.fault
        self._x = np.zeros((ROOT + LEG * len(rig.legs), 0))  # of the frames of the window before
        self._begin = self._shown = first  # numbers of the first of these, and of the first that was not shown

    @property
    def feet(self) -> Sequence[Foot]:
        """What was shown of each foot."""
        return self._feet

    def lifted(self, legs: Sequence[LegTracks], first: int) -> tuple[tuple[LegTracks, ...], Floats]:
        """Raise a figure that floats or is sunk, little by little from the beginning.

        Args:
            legs: as captured, n frames.
            first: number of the first of them.

        Returns:
            The legs, and (n,) [m] by how much they were raised.
        """
        since = (first - self._first + np.arange(len(legs[0].flexion))) * self._frame_time
        lift = np.asarray(self._known.lift * (1.0 - gamma(np.asarray(since / _RAISED, dtype=np.float64))))
        if not self._known.lift or not self._translates or self._params.heights != "floor":
            return tuple(legs), np.zeros(len(lift))
        return tuple(raise_leg(leg, lift) for leg in legs), lift

    def solve(self, legs: Sequence[LegTracks], on: Bools, first: int, stop: int, *, last: bool = False) -> Floats:
        """Find the state of the frames up to `stop`, which are shown by that.

        Args:
            legs: as captured and lifted, n frames.
            on: (n, 2 legs) when heel and toe of each are planted.
            first: number of the first frame: at most two before the first that was not shown.
            stop: number of the first frame that is not to be shown.
            last: whether no frames follow.

        Returns:
            (U, n) the state, without what is too small to be seen; what is beyond `stop` is only a plan.
        """
        n = len(on)
        window = first + np.arange(n)
        belt = self._known.belt * self._frame_time
        fixed = np.asarray(window < self._shown)
        x, stacked = self._started(first, n), Legs.of(legs)
        plan = self._places(stacked, x)
        pins = tuple(
            pins_of(
                foot, leg, k, [*plan[:, :, k].swapaxes(0, 1)], on[:, 2 * k : 2 * k + 2], window, self._ground, belt,
                self._params.pins,
            )
            for k, (foot, leg) in enumerate(zip(self._feet, legs, strict=True))
        )  # fmt: skip
        problem = Problem(
            tuple(legs), pins, self._frame_time, self._known.rig.leg_length, costs_of(self._params), self._known.noise,
            self._known.white, np.full(n, self._usual_fault(legs, window)), self._translates, onward=not last,
        )  # fmt: skip
        if n > BEFORE + 1:
            x = descend(problem, x, _LAST_ROUNDS if last else _ROUNDS, int(fixed.sum()), legs=stacked)
        places = self._places(stacked, x)
        for k, leg in enumerate(legs):
            self._feet[k] = follow(
                self._feet[k], leg, k, [*places[:, :, k].swapaxes(0, 1)], pins[k], on[:, 2 * k : 2 * k + 2], window,
                slice(int(fixed.sum()), stop - first), self._ground, belt,
            )  # fmt: skip
        self._x, self._begin, self._shown = x, first, stop
        return faded(x, problem)

    @staticmethod
    def _places(legs: Legs, x: Floats) -> Floats:
        """(3, P, L, n) [m] where the points of all legs are in a state."""
        own = x[ROOT:].reshape(-1, LEG, x.shape[1]).swapaxes(0, 1)
        return places_of(legs, x[:ROOT], own)[0]

    def _started(self, first: int, n: int) -> Floats:
        """(U, n) what was found for these frames a moment before; the newest keep the last state."""
        x = np.zeros((len(self._x), n))
        known = self._x[:, max(first - self._begin, 0) :][:, :n]
        x[:, : known.shape[1]] = known
        if known.shape[1]:
            x[:, known.shape[1] :] = known[:, -1:]
        return x

    def _usual_fault(self, legs: Sequence[LegTracks], window: Ints) -> float:
        """[m] how far plants stray: those that stand now, and lately."""
        now = 0.0
        for foot, leg in zip(self._feet, legs, strict=True):
            for point, plant in enumerate(foot.plants[:2]):
                if plant is not None and plant.place is not None and not plant.free:
                    off = leg.place(point)[:, -1] - plant.places(window[-1:], self._frame_time)[:, 0]
                    now = max(now, float(np.hypot(off[0], off[2])))
        kept = np.exp(-(window[-1] + 1 - self._seen) * self._frame_time / _FORGETS)
        self._seen = int(window[-1]) + 1
        self._fault = max(now, self._known.fault + (self._fault - self._known.fault) * kept)
        return self._fault

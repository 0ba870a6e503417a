"""A round of Gauss-Newton on a window, whose first frames keep their state."""

from __future__ import annotations

import numpy as np

from footfix.enforce.assembly import System
from footfix.enforce.problem import Problem
from footfix.enforce.solve import DAMPING, EPS, STATIC, solved
from footfix.motion.clip import Floats, Ints
from footfix.stream.objective import Legs, Normal, Stacked, normal

_LONGEST = 0.1  # [m, rad] that a state goes in a round
_FIRST = 4.0  # times `EPS` in all rounds but the last


def descend(problem: Problem, x: Floats, rounds: int, fixed: int, *, legs: Legs | None = None) -> Floats:
    """Take some rounds from a state.

    Args:
        problem: the window's.
        x: (U, F) where to begin.
        rounds: how many.
        fixed: frames at the beginning that keep their state.
        legs: the problem's, stacked, where they are known.
    """
    legs, pins = Legs.of(problem.legs) if legs is None else legs, Stacked.of(problem.pins)
    free = np.asarray(np.flatnonzero(problem.free()), dtype=np.intp)
    x = x.copy()
    for n in range(rounds):
        eps = (EPS if n == rounds - 1 else _FIRST * EPS) * problem.frame_time
        found = normal(problem, legs, pins, x, eps, STATIC)
        step = _step(problem, found, free, fixed)
        x[np.ix_(free, np.arange(fixed, x.shape[1]))] += np.clip(step, -_LONGEST, _LONGEST)
    return x


def _step(problem: Problem, found: Normal, free: Ints, fixed: int) -> Floats:
    """(n, F - fixed) the step of the free unknowns, by a banded Cholesky decomposition; none where there is none."""
    s0, _ = problem.near()
    system = System(
        rows=np.arange(problem.unknowns), gradient=found.gradient[fixed:].T, main=found.main[fixed:].transpose(1, 2, 0),
        next=found.next[fixed:].transpose(1, 2, 0), near=found.near[..., fixed:], cost=0.0,
    )  # fmt: skip
    try:
        return solved(system, free, DAMPING * 60.0 * problem.frame_time / s0[free] ** 2, None)
    except np.linalg.LinAlgError:
        return np.zeros((len(free), system.gradient.shape[1]))

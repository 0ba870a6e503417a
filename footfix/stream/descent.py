"""A round of Gauss-Newton on a window, whose first frames keep their state."""

from __future__ import annotations

import numpy as np

from footfix.enforce.problem import Problem
from footfix.enforce.solve import _DAMPING, _STATIC, EPS
from footfix.motion.clip import Floats, Ints
from footfix.stream.objective import Legs, Normal, Stacked, normal

_LONGEST = 0.1  # [m, rad] that a state goes in a round
_FIRST = 4.0  # times `EPS` in all rounds but the last


def descend(problem: Problem, x: Floats, rounds: int, fixed: int) -> Floats:
    """Take some rounds from a state.

    Args:
        problem: the window's.
        x: (U, F) where to begin.
        rounds: how many.
        fixed: frames at the beginning that keep their state.
    """
    legs, pins = Legs.of(problem.legs), Stacked.of(problem.pins)
    free = np.asarray(np.flatnonzero(problem.free()), dtype=np.intp)
    x = x.copy()
    for n in range(rounds):
        eps = (EPS if n == rounds - 1 else _FIRST * EPS) * problem.frame_time
        found = normal(problem, legs, pins, x, eps, _STATIC)
        step = _step(problem, found, free, fixed)
        x[np.ix_(free, np.arange(fixed, x.shape[1]))] += np.clip(step, -_LONGEST, _LONGEST)
    return x


def _step(problem: Problem, found: Normal, free: Ints, fixed: int) -> Floats:
    """(n, F - fixed) the step of the free unknowns, by a banded Cholesky decomposition."""
    from scipy.linalg.lapack import dpbsv

    rows, columns = np.ix_(free, free)
    main, next_ = found.main[fixed:, rows, columns], found.next[fixed:, rows, columns]
    near = found.near[:, free, fixed:]
    F, U = main.shape[:2]
    bands = np.zeros((F, U, 2 * U + 1))  # of the lower triangle, column by column
    for b in range(U):
        bands[:, b, : U - b] = main[:, b:, b]
        bands[:-1, b, U - b : 2 * U - b] = next_[:, :, b]
    s0, _ = problem.near()
    bands[..., 0] += near[0].T + _DAMPING * 60.0 * problem.frame_time / s0[free] ** 2
    bands[:-1, :, U] += near[1, :, :-1].T
    bands[:-2, :, 2 * U] += near[2, :, :-2].T
    right = -found.gradient[fixed:, free].reshape(-1)
    _, solved, info = dpbsv(bands.reshape(F * U, 2 * U + 1).T, right, lower=1, overwrite_ab=1, overwrite_b=1)
    if info:
        return np.zeros((U, F))
    return np.asarray(solved.reshape(F, U).T)

"""Gauss-Newton rounds on a window whose first frames are fixed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import as_strided

from footfix.enforce.costs import RATE
from footfix.enforce.problem import Problem
from footfix.enforce.solve import DAMPING, EPS, STATIC
from footfix.enforce.terms import near
from footfix.motion.banded import solve_banded
from footfix.motion.clip import Floats, Ints, frozen
from footfix.stream.legs import Legs, LegStates
from footfix.stream.objective import Normal, normal
from footfix.stream.pins import Stacked

_LONGEST = 0.1  # [m, rad] longest step of a state in a round


@dataclass(frozen=True, eq=False)
class Fixed:
    """Values shared by all windows of the same number of frames.

    Args:
        near: (3, U, F) bands of NEAR.
        free: which unknowns there are.
        damping: (n,) of these.
    """

    near: Floats
    free: Ints
    damping: Floats

    @classmethod
    def of(cls, problem: Problem) -> Fixed:
        """Compute them for a window."""
        U, F = problem.unknowns, problem.frames
        bands, _ = near(problem, np.zeros((U, F)), np.arange(U))
        free = np.asarray(np.flatnonzero(problem.free()), dtype=np.intp)
        s0, _ = problem.near()
        return cls(frozen(bands), free, frozen(DAMPING * RATE * problem.frame_time / s0[free] ** 2))


def descend(
    problem: Problem, x: Floats, past: int, *, legs: Legs, pins: Stacked, fixed: Fixed, at: LegStates | None = None
) -> Floats:
    """Take a round from a state.

    Args:
        problem: the window's.
        x: (U, F) where to begin.
        past: frames at the beginning whose state is fixed.
        legs, pins: the problem's, stacked.
        fixed: what is the same in all such windows.
        at: the legs' points in that state, where they are known.
    """
    found = normal(problem, legs, pins, x, EPS * problem.frame_time, STATIC, fixed.near, at)
    out = x.copy()
    out[fixed.free, past:] += np.clip(_step(found, fixed, past), -_LONGEST, _LONGEST)
    return out


def _step(found: Normal, fixed: Fixed, past: int) -> Floats:
    """Compute the step (n, F - past) of the free unknowns by a banded Cholesky decomposition; zero if that fails."""
    gradient, main, next_ = found.gradient[past:], found.main[past:], found.next[past:]
    own, bands = fixed.free, found.near[:, fixed.free, past:]
    if len(own) < gradient.shape[1]:
        gradient, main, next_ = gradient[:, own], main[:, own[:, None], own], next_[:, own[:, None], own]
    F, U = gradient.shape
    matrix = np.zeros((F, U, 2 * U + 1))  # column by column, from the diagonal down
    size, unit = U * (2 * U + 1), matrix.itemsize
    # row r of column c stands r - c after its diagonal; what is above the diagonal is zero, and falls on zeros
    for blocks, after in ((main * np.tri(U), 0), (next_, U)):
        n = len(blocks)
        view = as_strided(matrix.reshape(-1)[after:], (n, U, U), (size * unit, 2 * U * unit, unit))
        view[...] = blocks.swapaxes(1, 2)
    matrix[..., 0] += bands[0].T + fixed.damping
    matrix[..., U] += bands[1].T
    matrix[..., 2 * U] += bands[2].T
    try:
        return solve_banded(matrix.reshape(F * U, 2 * U + 1), -gradient.reshape(-1)).reshape(F, U).T
    except np.linalg.LinAlgError:
        return np.zeros((U, F))

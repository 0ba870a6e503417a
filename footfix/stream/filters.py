"""Filters over the newest stretch of a track, which is always as long: products with one matrix, and lowest values."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from footfix.detect.evidence import STEP
from footfix.motion.clip import Floats, frozen
from footfix.motion.smoothing import savgol


def filtered(x: Floats, *, seconds: float, degree: int, derivative: int = 0, step: float = STEP) -> Floats:
    """Filter (n, ...) along its first axis, as `savgol` does, several times faster.

    Args:
        x: any unit.
        seconds: [s] window.
        degree: of the polynomial.
        derivative: 0 for the value, 1 for the speed [unit/s], 2 for the acceleration [unit/s^2].
        step: [s] from one to the next; detection's grid unless told otherwise.
    """
    matrix = _matrix(len(x), seconds, degree, derivative, step)
    return np.asarray(matrix @ x.reshape(len(x), -1)).reshape(x.shape)


@lru_cache(maxsize=64)
def _matrix(n: int, seconds: float, degree: int, derivative: int, step: float) -> Floats:
    return frozen(savgol(np.eye(n), step, seconds=seconds, degree=degree, derivative=derivative))


def floors(ahead: Floats, behind: Floats, seconds: float, count: int) -> tuple[Floats, Floats]:
    """Find the lowest values within some seconds ahead, and behind, both with now; see `detect.evidence.floors`.

    Args:
        ahead, behind: (n, m) on detection's grid, the values that are looked at.
        seconds: [s] how far.
        count: for how many of the newest steps it is wanted.

    Returns:
        (count, m) each.
    """
    n = max(round(seconds / STEP), 1) + 1
    long = min(count + n, len(ahead))
    beyond = np.full((n, ahead.shape[1]), np.inf)
    later, earlier = np.concatenate([ahead[-count:], beyond]), np.concatenate([beyond, behind[-long:]])
    width = 1
    while width < n:  # the lowest of 2 w is the lower of two lowest of w
        hop = min(width, n - width)
        later = np.minimum(later[:-hop], later[hop:])
        earlier = np.minimum(earlier[:-hop], earlier[hop:])
        width += hop
    return later[:count], earlier[-count:]

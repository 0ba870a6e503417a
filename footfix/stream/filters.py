"""Filters of the newest stretch of a track: several times as fast on few values as those for whole clips."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import as_strided, sliding_window_view

from footfix.detect.evidence import STEP
from footfix.motion.clip import Floats, frozen
from footfix.motion.smoothing import savgol, window_frames


def filtered(x: Floats, *, seconds: float, degree: int, derivative: int = 0, step: float = STEP) -> Floats:
    """Filter (n, ...) along its first axis, as `savgol` does.

    Args:
        x: any unit.
        seconds: [s] window.
        degree: of the polynomial.
        derivative: 0 for the value, 1 for the speed [unit/s], 2 for the acceleration [unit/s^2].
        step: [s] from one to the next; detection's grid unless told otherwise.
    """
    n, window = len(x), window_frames(seconds, step, degree)
    if n < window:
        return savgol(x, step, seconds=seconds, degree=degree, derivative=derivative)
    first, inner, last = _weights(window, seconds, degree, derivative, step)
    flat = np.ascontiguousarray(x.reshape(n, -1))
    width = flat.shape[1]
    down, along = flat.strides
    windows = as_strided(flat, (n - window + 1, width, window), (down, along, down)).reshape(-1, window)
    out = np.empty((n, width))
    half = len(first)
    out[:half] = first @ flat[:window]
    out[half : n - half] = (windows @ inner).reshape(-1, width)
    out[n - half :] = last @ flat[n - window :]
    return out.reshape(x.shape)


@lru_cache(maxsize=64)
def _weights(window: int, seconds: float, degree: int, derivative: int, step: float) -> tuple[Floats, Floats, Floats]:
    """The weights of a window's values in its first half (h, window), in its middle (window,), and in its last half."""
    all_of_it = savgol(np.eye(window), step, seconds=seconds, degree=degree, derivative=derivative)
    half = window // 2
    return frozen(all_of_it[:half]), frozen(all_of_it[half]), frozen(all_of_it[half + 1 :])


def slopes(x: Floats, seconds: float, count: int) -> Floats:
    """Find the slope of the straight line through a window about each moment, as `savgol` of degree 1 does.

    Args:
        x: (n, m) on detection's grid, any unit.
        seconds: [s] window; where too little of it follows, the newest whole one counts.
        count: for how many of the newest steps it is wanted.

    Returns:
        (count, m) [unit/s]; zero where no whole window is known yet.
    """
    window = window_frames(seconds, STEP, 1)
    half = window // 2
    x = x[-max(count + half, window) :]
    if len(x) < window:
        return np.zeros((count, x.shape[1]))
    along = np.arange(window) - half
    inner = sliding_window_view(x, window, axis=0) @ (along / (STEP * (along @ along)))
    return np.asarray(inner[np.clip(np.arange(len(x) - count, len(x)) - half, 0, len(inner) - 1)])


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

"""Filters for the newest part of a track, several times faster on few values than those for whole clips."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from footfix.detect.evidence import STEP
from footfix.motion.clip import Floats, frozen
from footfix.motion.smoothing import savgol, window_frames

_MOST = 128  # most values filtered by one matrix product


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
    if n < window or n > _MOST:
        return savgol(x, step, seconds=seconds, degree=degree, derivative=derivative)
    return np.asarray(_matrix(n, seconds, degree, derivative, step) @ x.reshape(n, -1)).reshape(x.shape)


@lru_cache(maxsize=64)
def _matrix(n: int, seconds: float, degree: int, derivative: int, step: float) -> Floats:
    """Make the matrix (n, n) that filters n values; mostly zeros, but one product is faster than skipping them."""
    return frozen(savgol(np.eye(n), step, seconds=seconds, degree=degree, derivative=derivative))


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
    x = x[-max(count + window // 2, window) :]
    if len(x) < window:
        return np.zeros((count, x.shape[1]))
    return np.asarray(_lines(len(x), window, count) @ x)


@lru_cache(maxsize=16)
def _lines(n: int, window: int, count: int) -> Floats:
    """Compute the weights (count, n) of n values in the slopes of the newest steps."""
    half = window // 2
    along = np.arange(window) - half
    middle = np.clip(np.arange(n - count, n), half, n - 1 - half)
    out = np.zeros((count, n))
    out[np.arange(count)[:, None], middle[:, None] + along] = along / (STEP * (along @ along))
    return frozen(out)


def steps_of(seconds: float) -> int:
    """Count the steps that lie within some seconds of one, with it."""
    return max(round(seconds / STEP), 1) + 1


class Lowest:
    """The lowest values of tracks within some seconds ahead, and behind, with now; see `detect.evidence.floors`."""

    def __init__(self, x: Floats, seconds: float, count: int) -> None:
        """Lay tracks (k, n) on detection's grid out, to be looked at as far as some seconds, for the newest steps."""
        long = steps_of(seconds) - 1
        rows = min(count + long, x.shape[1])
        self._count, self._first = count, long + rows - count  # column of the first step that is wanted
        self._x = np.full((len(x), 2 * long + rows), np.inf)
        self._x[:, long : long + rows] = x[:, x.shape[1] - rows :]

    def ahead(self, seconds: float, tracks: slice) -> Floats:
        """Find the lowest values ahead of some tracks, (k, count)."""
        return self._lowest(self._first, steps_of(seconds), tracks)

    def behind(self, seconds: float, tracks: slice) -> Floats:
        """Find the lowest values behind of some tracks, (k, count)."""
        return self._lowest(self._first + 1 - steps_of(seconds), steps_of(seconds), tracks)

    def _lowest(self, first: int, n: int, tracks: slice) -> Floats:
        # the n steps from each on are a view: one operation on many numbers is quicker than many on few
        size, long = self._x.itemsize, self._x.shape[1]
        shape, start = (tracks.stop - tracks.start, n, self._count), (tracks.start * long + first) * size
        windows: Floats = np.ndarray(shape, self._x.dtype, self._x, start, (long * size, size, size))
        return np.asarray(np.minimum.reduce(windows, axis=1))

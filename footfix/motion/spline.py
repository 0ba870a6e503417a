"""Curves through values: cubic splines, smooth to the second derivative, and monotone cubics without overshoot."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.motion.banded import solve_tridiagonal
from footfix.motion.clip import Floats, Ints

_AROUND = 24  # knots by which a closed curve is repeated at both ends, so that end effects vanish


@dataclass(frozen=True, eq=False)
class Cubic:
    """A piecewise cubic curve; beyond its ends the outermost cubics are extended.

    Args:
        at: (N,) the knots, rising.
        values: (N, D) there.
        slopes: (N, D) first derivatives there.
    """

    at: Floats
    values: Floats
    slopes: Floats

    def __call__(self, wanted: Floats, derivative: int = 0) -> Floats:
        """Evaluate the curve, or its first or second derivative, at places (...): (..., D)."""
        wanted = np.asarray(wanted, dtype=np.float64)
        flat = wanted.ravel()
        k: Ints = np.clip(np.searchsorted(self.at, flat, side="right") - 1, 0, len(self.at) - 2)
        u = flat - self.at[k]
        c = [np.take(each, k, axis=1) for each in self._coefficients[derivative:]]
        if derivative == 0:
            out = c[0] + u * (c[1] + u * (c[2] + u * c[3]))
        elif derivative == 1:
            out = c[0] + u * (2.0 * c[1] + u * (3.0 * c[2]))
        else:
            out = 2.0 * c[0] + 6.0 * u * c[1]
        return np.asarray(out.T.reshape(*wanted.shape, self.values.shape[1]))

    @cached_property
    def _coefficients(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Compute the coefficients, each (D, N - 1), so that arithmetic runs over the many places, not the few D."""
        width = np.diff(self.at)[:, None]
        rise = np.diff(self.values, axis=0) / width
        a, b = self.slopes[:-1], self.slopes[1:]
        c0, c1, c2, c3 = (
            np.ascontiguousarray(each.T)
            for each in (self.values[:-1], a, (3.0 * rise - 2.0 * a - b) / width, (a + b - 2.0 * rise) / width**2)
        )
        return c0, c1, c2, c3


def spline(at: Floats, values: Floats, *, closed: bool = False) -> Cubic:
    """Make the cubic spline through values, natural at its ends, or closed.

    Args:
        at: (N,) the knots, rising.
        values: (N, D); of a closed curve the last are the first.
        closed: whether its end continues at its start.
    """
    at, values = np.asarray(at, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if not closed:
        return Cubic(at, values, _slopes(at, values))
    n = len(at) - 1
    count = np.arange(-_AROUND, n + _AROUND + 1)
    more = at[count % n] + np.floor_divide(count, n) * (at[-1] - at[0])
    slopes = _slopes(more, values[count % n])[_AROUND : _AROUND + n + 1]
    slopes[-1] = slopes[0]
    return Cubic(at, values, slopes)


def _slopes(at: Floats, values: Floats) -> Floats:
    """Compute the slopes (N, D) of the natural spline from its second derivatives m.

    h(k-1) m(k-1) + 2 (h(k-1) + h(k)) m(k) + h(k) m(k+1) = 6 (rise(k) - rise(k-1)).
    """
    width = np.diff(at)
    rise = np.diff(values, axis=0) / width[:, None]
    bend = np.zeros_like(values)
    if len(at) == 3:
        bend[1] = 6.0 * (rise[1] - rise[0]) / (2.0 * (at[2] - at[0]))
    elif len(at) > 3:
        bend[1:-1] = solve_tridiagonal(2.0 * (width[:-1] + width[1:]), width[1:-1], 6.0 * np.diff(rise, axis=0))
    left = rise - width[:, None] * (2.0 * bend[:-1] + bend[1:]) / 6.0
    last = rise[-1] + width[-1] * (bend[-2] + 2.0 * bend[-1]) / 6.0
    return np.concatenate([left, last[None]])


def monotone(at: Floats, values: Floats) -> Cubic:
    """Make a curve through values (N, D) that rises and falls only where they do.

    Source: F. N. Fritsch and J. Butland, A method for constructing local monotone piecewise cubic interpolants, SIAM J.
    Sci. Stat. Comput. 5 (1984).

    Args:
        at: (N,) the knots, rising.
        values: (N, D).
    """
    width = np.diff(at)[:, None]
    rise = np.diff(values, axis=0) / width
    slopes = np.concatenate([rise[:1], np.zeros((len(at) - 2, values.shape[1])), rise[-1:]])
    a, b = width[:-1] + 2.0 * width[1:], 2.0 * width[:-1] + width[1:]
    same = rise[:-1] * rise[1:] > 0.0
    before, after = np.where(same, rise[:-1], 1.0), np.where(same, rise[1:], 1.0)
    slopes[1:-1] = np.where(same, (a + b) / (a / before + b / after), 0.0)
    return Cubic(np.asarray(at, dtype=np.float64), np.asarray(values, dtype=np.float64), slopes)

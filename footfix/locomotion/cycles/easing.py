"""Values eased over time from one held span to the next, by the cubic step Gamma (G eq. 9, 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.motion.clip import Floats, Ints
from footfix.motion.vectors import norm

_LEAST = 1e-6  # [s] shortest stretch
_BEND = 0.1  # [s] longest time in which the slope at the end of a stretch fades out
_ASIDE = 0.01  # [the value's unit] divided by a steep slope, the time for that slope, at least 0.02 s

Span = tuple[float, float]  # [s]
Row = tuple[float, int, int, int, int, int]  # start [s]; indices of two values and two slopes; what holds it, or -1


@dataclass(frozen=True, eq=False)
class Timelines:
    """Q values (3,) over time, each in stretches of time that lie end to end.

    In a stretch, a value is eased from one to another, or is held by something else.

    Args:
        begins: (Q,) index of each value's first stretch, among all S.
        starts: (S,) [s] start of each stretch, ascending for each value; its first stretch also holds before its start.
        lengths: (S,) [s].
        values: (S, 2, 3) values at its start and end.
        slopes: (S, 2, 3) [1/s] slopes there; those of the step itself are zero.
        holder: (S,) what holds it, -1 where nothing does.
    """

    begins: Ints
    starts: Floats
    lengths: Floats
    values: Floats
    slopes: Floats
    holder: Ints

    @cached_property
    def _keys(self) -> tuple[Floats, Floats, float, float]:
        """Prepare the search of `at`: starts (S,) ascending over all values, each value's shift (Q,), and their range.
        """
        low, high = float(self.starts.min()) - 1.0, float(self.starts.max()) + 1.0
        added = np.asarray((high - low + 1.0) * np.arange(len(self.begins)), dtype=np.float64)
        counts = np.diff(np.append(self.begins, len(self.starts)))
        keys: Floats = self.starts + np.repeat(added, counts)
        return keys, added, low, high

    @cached_property
    def _spans(self) -> Floats:
        """Compute the times (S, 2) [s] in which the extra slopes at the ends of each stretch fade out."""
        steep = np.maximum(norm(self.slopes), 1e-9)
        span: Floats = np.minimum(np.maximum(_ASIDE / steep, 0.02), _BEND)
        return np.minimum(span, 0.5 * self.lengths[:, None])

    @cached_property
    def _table(self) -> tuple[Floats, Floats, Floats]:
        """Prepare each stretch as polynomials.

        Returns:
            (S, 3) and (S, 3) factors and summands that convert the time since its start to shares of the stretch, and
            of the spans at its ends; and (S, 4, 3) the coefficients of the last value, the fall to it, and both slopes.
        """
        count = len(self.starts)
        factors, summands, parts = np.zeros((count, 3)), np.zeros((count, 3)), np.empty((count, 4, 3))
        factors[:, 0], factors[:, 1:] = 1.0 / self.lengths, 1.0 / self._spans
        factors[:, 2] *= -1.0
        summands[:, 2] = self.lengths / self._spans[:, 1]
        parts[:, 0], parts[:, 1] = self.values[:, 1], self.values[:, 0] - self.values[:, 1]
        parts[:, 2:] = self._spans[..., None] * self.slopes
        parts[:, 3] *= -1.0
        return factors, summands, parts

    def at(self, times: Floats) -> tuple[Floats, Ints]:
        """Evaluate the values (T, Q, 3) at times (T,) [s], and tell (T, Q) what holds them instead."""
        keys, added, low, high = self._keys
        within = np.minimum(np.maximum(times, low), high)[:, None] + added
        k = np.maximum(keys.searchsorted(within.ravel(), side="right").reshape(within.shape) - 1, self.begins)
        factors, summands, parts = self._table
        u = (times[:, None] - self.starts[k])[..., None] * factors[k] + summands[k]
        u = np.minimum(np.maximum(u, 0.0), 1.0)
        fall, bends = u[..., 0], u[..., 1:]
        weights = np.ones((*k.shape, 1, 4))
        weights[..., 0, 1] += (2.0 * fall - 3.0) * fall * fall
        weights[..., 0, 2:] = bends * (1.0 - bends) ** 2  # slope 1 at the end of the stretch, value and slope 0 inside
        return (weights @ parts[k])[..., 0, :], self.holder[k]


def timelines(every: Sequence[Sequence[Row]], some: Floats) -> Timelines:
    """Join the rows of several values, from `held_rows` and `through_rows`, whose values are among (N, 3)."""
    counts = np.array([len(rows) for rows in every])
    table = np.array([row for own in every for row in own])  # numbers of rows are small, so floats hold them
    starts, index = table[:, 0], table[:, 1:].astype(np.intp)
    begins = np.cumsum(counts) - counts
    lengths = np.empty(len(starts))
    lengths[:-1] = np.maximum(starts[1:] - starts[:-1], _LEAST)
    lengths[begins + counts - 1] = 1.0
    return Timelines(begins, starts, lengths, some[index[:, :2]], some[index[:, 2:4]], index[:, 4])


def held_rows(spans: Sequence[Span], values: Sequence[int], slopes: Sequence[int], holders: Sequence[int],
              sigma: float) -> list[Row]:  # fmt: skip
    """Hold a value in spans, eased in before each and out after it, and interpolated between close ones.

    Args:
        spans: [s] start and end of each span, in order of time.
        values: for each the index of the value at its start; that at its end comes next. Index 0 is the value zero.
        slopes: likewise, indices of the slopes there.
        holders: what holds it in each.
        sigma: [s] duration of an ease.
    """
    before = (spans[0][0] if spans else 0.0) - sigma - 1.0
    rows: list[Row] = [(before, 0, 0, 0, 0, -1)]
    for k, ((start, end), v, w, holder) in enumerate(zip(spans, values, slopes, holders, strict=True)):
        if k == 0 or start - spans[k - 1][1] >= 2.0 * sigma:
            rows.append((start - sigma, 0, v, 0, w, -1))
        rows.append((start, v, v + 1, 0, 0, holder))
        if k + 1 == len(spans) or spans[k + 1][0] - end >= 2.0 * sigma:
            rows += [(end, v + 1, 0, w + 1, 0, -1), (end + sigma, 0, 0, 0, 0, -1)]
        else:
            rows.append((end, v + 1, values[k + 1], w + 1, slopes[k + 1], -1))
    return rows


def through_rows(times: Sequence[float], first: int) -> list[Row]:
    """Interpolate a number at some times, in order; `first` is the index of its first value, the others follow."""
    last = first + len(times) - 1
    return [(at, first + k, min(first + k + 1, last), 0, 0, -1) for k, at in enumerate(times)]

"""Values eased over time from one held span to the next, by the cubic step Gamma (G eq. 9, 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.motion.clip import Floats, Ints
from footfix.motion.vectors import norm

_LEAST = 1e-6  # [s] of a stretch
_BEND = 0.1  # [s] within which a value that is let go, or taken up, changes its slope,
_ASIDE = 0.01  # and less where the slope is steep: what it is led aside for it is a sixth of this [of its unit]

Span = tuple[float, float]  # [s]
Row = tuple[float, int, int, int, int, int]  # start, the four values at its ends among some, and what holds it


@dataclass(frozen=True, eq=False)
class Timelines:
    """Values (3,) over time, Q of them, each of stretches of time that lie end to end.

    In a stretch a value is eased from one to another, or is held by something else.

    Args:
        begins: (Q,) where the stretches of each value begin, among all S.
        starts: (S,) [s], ascending for each value; its first stretch reaches back for ever.
        lengths: (S,) [s].
        values: (S, 2, 3) values at its ends.
        slopes: (S, 2, 3) slopes there, beside that of the step, of [1/s]; the last one towards the stretch.
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
        """(S,) starts, ascending over all values, what is added for each (Q,), and the times that they cover."""
        low, high = float(self.starts.min()) - 1.0, float(self.starts.max()) + 1.0
        added = np.asarray((high - low + 1.0) * np.arange(len(self.begins)), dtype=np.float64)
        counts = np.diff(np.append(self.begins, len(self.starts)))
        keys: Floats = self.starts + np.repeat(added, counts)
        return keys, added, low, high

    @cached_property
    def _spans(self) -> Floats:
        """(S, 2) [s] over which the slopes at the ends come back to nothing."""
        steep = np.maximum(norm(self.slopes), 1e-9)
        span: Floats = np.minimum(np.maximum(_ASIDE / steep, 0.02), _BEND)
        return np.minimum(span, 0.5 * self.lengths[:, None])

    @cached_property
    def _table(self) -> tuple[Floats, Floats, Floats]:
        """What a stretch is made of.

        Returns:
            (S, 3) and (S, 3) factors and summands that make shares of the time since its start: of the stretch, and of
            the spans at its ends; and (S, 4, 3) what is added up: its last value, as much as it falls, and its bends.
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
        """(T, Q, 3) values at times (T,) [s], and (T, Q) what holds them instead."""
        keys, added, low, high = self._keys
        within = np.minimum(np.maximum(times, low), high)[:, None] + added
        k = np.maximum(keys.searchsorted(within.ravel(), side="right").reshape(within.shape) - 1, self.begins)
        factors, summands, parts = self._table
        u = (times[:, None] - self.starts[k])[..., None] * factors[k] + summands[k]
        u = np.minimum(np.maximum(u, 0.0), 1.0)
        fall, bends = u[..., 0], u[..., 1:]
        weights = np.ones((*k.shape, 1, 4))
        weights[..., 0, 1] += (2.0 * fall - 3.0) * fall * fall
        weights[..., 0, 2:] = bends * (1.0 - bends) ** 2  # cubics that come back to nothing
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
        spans: [s] from when until when it is held, in order of time.
        values: for each where among all values that at its start stands, followed by that at its end; 0 is zero.
        slopes: likewise, how it changes there.
        holders: what holds it then.
        sigma: [s] of an ease.
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
    """Lead a number through some values in order of time, of which the first stands at an index."""
    last = first + len(times) - 1
    return [(at, first + k, min(first + k + 1, last), 0, 0, -1) for k, at in enumerate(times)]

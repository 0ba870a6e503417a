"""Values led over time from one held stretch to the next, by the cubic step Gamma (G eq. 9, 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Floats, Ints, frozen

_LEAST = 1e-6  # [s] of a stretch
_BEND = 0.1  # [s] within which a value that is let go, or taken up, changes its slope,
_ASIDE = 0.02  # and less where the slope is steep: what it is led aside for it is a sixth of this [of its unit]
_ZERO = (0.0, 0.0, 0.0)

Row = tuple[float, Sequence[float], Sequence[float], Sequence[float], Sequence[float], int]


@dataclass(frozen=True, eq=False)
class Timelines:
    """Values (3,) over time, Q of them, each of stretches of time that lie end to end.

    Over a stretch a value goes from one to another, or something else holds it.

    Args:
        begins: (Q + 1,) where the stretches of each value begin, among all S.
        starts: (S,) [s], ascending for each value; its first stretch reaches back for ever.
        lengths: (S,) [s].
        first, last: (S, 3) values at its ends.
        leaving, coming: (S, 3) slopes there, beside that of the step, of [1/s].
        holder: (S,) what holds it, -1 where nothing does.
    """

    begins: tuple[int, ...]
    starts: Floats
    lengths: Floats
    first: Floats
    last: Floats
    leaving: Floats
    coming: Floats
    holder: Ints

    def at(self, times: Floats) -> tuple[Floats, Ints]:
        """(T, Q, 3) values at times (T,) [s], and (T, Q) what holds them instead."""
        k = np.empty((len(times), len(self.begins) - 1), dtype=np.intp)
        for q in range(k.shape[1]):
            a, b = self.begins[q], self.begins[q + 1]
            k[:, q] = a + np.maximum(self.starts[a:b].searchsorted(times, side="right") - 1, 0)
        length = self.lengths[k]
        since = times[:, None] - self.starts[k]
        u = np.minimum(np.maximum(since / length, 0.0), 1.0)
        fall = ((2.0 * u - 3.0) * u * u + 1.0)[..., None]
        last = self.last[k]
        value = last + fall * (self.first[k] - last)
        value += _bent(self.leaving[k], since, length) - _bent(self.coming[k], length - since, length)
        return value, self.holder[k]


def _bent(slope: Floats, since: Floats, length: Floats) -> Floats:
    """(..., 3) what a slope (..., 3) adds, some time after it held (...) [s]: a cubic that comes back to nothing."""
    steep = np.sqrt(np.einsum("...k,...k->...", slope, slope))
    span = np.minimum(np.minimum(np.maximum(_ASIDE / np.maximum(steep, 1e-9), 0.02), _BEND), 0.5 * length)
    u = np.minimum(np.maximum(since / span, 0.0), 1.0)
    return np.asarray((span * u * (1.0 - u) ** 2)[..., None] * slope)


def timelines(every: Sequence[Sequence[Row]]) -> Timelines:
    """Join the rows of several values, from `held_rows` and `through_rows`."""
    begins = np.concatenate([[0], np.cumsum([len(rows) for rows in every])])
    rows = [row for own in every for row in own]
    starts = np.array([row[0] for row in rows])
    lengths = np.empty(len(starts))
    lengths[:-1] = np.maximum(starts[1:] - starts[:-1], _LEAST)
    lengths[begins[1:] - 1] = 1.0
    values = np.array([row[1:5] for row in rows])
    first, last, leaving, coming = (frozen(values[:, c]) for c in range(4))
    holder = np.array([row[5] for row in rows])
    return Timelines(
        tuple(begins.tolist()), frozen(starts), frozen(lengths), first, last, leaving, coming, holder
    )  # fmt: skip


def held_rows(
    spans: Sequence[tuple[float, float]], ends: Sequence[Floats], slopes: Sequence[Floats], holders: Sequence[int],
    sigma: float,
) -> list[Row]:  # fmt: skip
    """A value that is held in spans, eased in before each and out after it, and led over where they are close.

    Args:
        spans: [s] from when until when it is held, in order of time.
        ends: for each (2, 3) the value at its start and at its end.
        slopes: for each (2, 3) how it changes there, of [1/s].
        holders: what holds it then.
        sigma: [s] of an ease.
    """
    before = min((start for start, _ in spans), default=0.0) - sigma - 1.0
    rows: list[Row] = [(before, _ZERO, _ZERO, _ZERO, _ZERO, -1)]
    for k, ((start, end), (first, last), (rises, falls)) in enumerate(zip(spans, ends, slopes, strict=True)):
        if k == 0 or start - spans[k - 1][1] >= 2.0 * sigma:
            rows.append((start - sigma, _ZERO, first, _ZERO, rises, -1))
        rows.append((start, first, last, _ZERO, _ZERO, holders[k]))
        if k + 1 == len(spans) or spans[k + 1][0] - end >= 2.0 * sigma:
            rows += [(end, last, _ZERO, falls, _ZERO, -1), (end + sigma, _ZERO, _ZERO, _ZERO, _ZERO, -1)]
        else:
            rows.append((end, last, ends[k + 1][0], falls, slopes[k + 1][0], -1))
    return rows


def through_rows(knots: Sequence[tuple[float, float]]) -> list[Row]:
    """A number that goes through some (time, value) in order of time; it stands first of the three."""
    knots = knots or [(0.0, 0.0)]
    after = [value for _, value in knots[1:]] + [knots[-1][1]]
    return [(at, (v, 0.0, 0.0), (w, 0.0, 0.0), _ZERO, _ZERO, -1) for (at, v), w in zip(knots, after, strict=True)]

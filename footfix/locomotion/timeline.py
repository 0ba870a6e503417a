"""Values led over time from one held stretch to the next, by the cubic step Gamma (G eq. 9, 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.enforce.papers.ease import gamma
from footfix.motion.clip import Bools, Floats, Ints, frozen

_LEAST = 1e-6  # [s] of a stretch
_BEND = 0.1  # [s] within which a value that is let go, or taken up, changes its slope,
_ASIDE = 0.02  # and less where the slope is steep: what it is led aside for it is a sixth of this [of its unit]


@dataclass(frozen=True, eq=False)
class Timeline:
    """Stretches of time, end to end; over each a value goes from one to another, or something else holds it.

    Args:
        starts: (S,) [s], ascending; the first stretch reaches back for ever.
        lengths: (S,) [s].
        first, last: (S, K) values at its ends.
        leaving, coming: (S, K) slopes there, beside that of the step, of [1/s].
        holder: (S,) what holds it, -1 where nothing does.
    """

    starts: Floats
    lengths: Floats
    first: Floats
    last: Floats
    leaving: Floats
    coming: Floats
    holder: Ints

    def __post_init__(self) -> None:
        for name in ("starts", "lengths", "first", "last", "leaving", "coming"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    def at(self, times: Floats) -> tuple[Floats, Ints]:
        """(T, K) values, and (T,) what holds them instead."""
        k = np.maximum(np.searchsorted(self.starts, times, side="right") - 1, 0)
        since, length = times - self.starts[k], self.lengths[k]
        fall = gamma(since / length)[:, None]
        last = self.last[k]
        value = last + fall * (self.first[k] - last)
        if self.bends:
            value += _bent(self.leaving[k], since, length) - _bent(self.coming[k], length - since, length)
        return value, self.holder[k]

    @cached_property
    def bends(self) -> bool:
        """Whether it has slopes at all."""
        return bool(np.any(self.leaving) or np.any(self.coming))


def _bent(slope: Floats, since: Floats, length: Floats) -> Floats:
    """(T, K) what a slope (T, K) adds, some time after it held (T,) [s]: a cubic that comes back to nothing."""
    steep = np.sqrt(np.einsum("tk,tk->t", slope, slope))
    span = np.minimum(np.clip(_ASIDE / np.maximum(steep, 1e-9), 0.02, _BEND), 0.5 * length)
    u = np.clip(since / span, 0.0, 1.0)
    return np.asarray((span * u * (1.0 - u) ** 2)[:, None] * slope)


def make_timeline(
    spans: Sequence[tuple[float, float]], ends: Sequence[Floats], slopes: Sequence[Floats], holders: Sequence[int],
    sigma: float, size: int,
) -> Timeline:  # fmt: skip
    """A value that is held in spans, eased in before each and out after it, and led over where they are close.

    Args:
        spans: [s] from when until when it is held, in order of time.
        ends: for each (2, K) the value at its start and at its end.
        slopes: for each (2, K) how it changes there, of [1/s].
        holders: what holds it then.
        sigma: [s] of an ease.
        size: K.
    """
    zero = np.zeros(size)
    rows: list[tuple[float, Floats, Floats, Floats, Floats, int]] = [(-np.inf, zero, zero, zero, zero, -1)]
    for k, ((start, end), (first, last), (rises, falls)) in enumerate(zip(spans, ends, slopes, strict=True)):
        if k == 0 or start - spans[k - 1][1] >= 2.0 * sigma:
            rows.append((start - sigma, zero, first, zero, rises, -1))
        rows.append((start, first, last, zero, zero, holders[k]))
        if k + 1 == len(spans) or spans[k + 1][0] - end >= 2.0 * sigma:
            rows += [(end, last, zero, falls, zero, -1), (end + sigma, zero, zero, zero, zero, -1)]
        else:
            rows.append((end, last, ends[k + 1][0], falls, slopes[k + 1][0], -1))
    starts = np.array([row[0] for row in rows])
    starts[0] = min(starts[1:].min(initial=0.0), 0.0) - 1.0
    lengths = np.append(np.maximum(np.diff(starts), _LEAST), 1.0)
    columns = [np.array([row[c] for row in rows]) for c in range(1, 6)]
    return Timeline(starts, lengths, *columns)


def through(knots: Sequence[tuple[float, float]]) -> Timeline:
    """A number that goes through some (time, value) in order of time."""
    if not knots:
        knots = [(0.0, 0.0)]
    at, value = np.array(knots).T
    after = np.append(value[1:], value[-1])
    lengths = np.append(np.maximum(np.diff(at), _LEAST), 1.0)
    flat = np.zeros((len(at), 1))
    return Timeline(at, lengths, value[:, None], after[:, None], flat, flat, np.full(len(at), -1))


def within(spans: Sequence[tuple[float, float]], times: Floats) -> Bools:
    """(T,) whether times lie in one of some spans [s]."""
    if not spans:
        return np.zeros(len(times), dtype=np.bool_)
    low, high = np.array(spans).T
    return np.asarray(((times[:, None] >= low) & (times[:, None] <= high)).any(axis=1))

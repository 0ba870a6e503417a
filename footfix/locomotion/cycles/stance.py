"""Stances of an engine's feet: times and places predicted from the cycle.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 4 and 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from footfix.locomotion.cycles.leg_pose import LegPoses, too_short
from footfix.locomotion.cycles.leg_vectors import between, dot, norm, turns_between, unit
from footfix.locomotion.cycles.model import CycleModel
from footfix.motion.clip import Floats, Ints, frozen

HELD = ("heel", "toe", "foot", "toes")  # what a stance holds: two places, a turn, a heading
_INSIDE = 7  # samples of a contact, whose mean is where the foot is to stand
_REACHED = 5  # samples of a heel's contact, at which the leg has to reach it
_ENDS = 2 * len(HELD)
_SAMPLES = _INSIDE + 2 * _ENDS + _REACHED
_STRETCHED = 0.9985  # [of a leg's reach] farthest place of a heel
_FARTHEST = 0.025  # [of a leg's reach] by which a place is moved nearer at most
_DELTA = 0.004  # [s] step of the differences that give slopes
_FLAT = np.array([1.0, 0.0, 1.0])
UP = np.array([0.0, 1.0, 0.0])
_EVENLY, _ON_HEEL = np.linspace(0.0, 1.0, _INSIDE), np.linspace(0.0, 1.0, _REACHED)
_EARLY = (1.0 - _ON_HEEL) / np.sum(1.0 - _ON_HEEL)
_BESIDE = np.array([_DELTA, -_DELTA])
_WAY = np.array([[1.0], [-1.0]]) / _DELTA
_WHERE = _INSIDE + 2 * np.arange(4)[:, None] + np.array([0, 1, _ENDS, _ENDS + 1])  # (4, 4) the samples of `HELD`

_NOWHERE, _NO_ENDS = frozen(np.zeros((2, 3))), frozen(np.zeros((4, 2, 3)))
_AS_IT_IS = frozen(np.tile(np.eye(3), (2, 1, 1)))

Span = tuple[float, float]  # [s]


@dataclass(frozen=True, eq=False)
class Stance:
    """One stance of a foot.

    Args:
        leg: index among the rig's legs.
        count: number of its cycle since the engine began.
        heel, toe: [s] when they are planted; None where they never are.
        points: (2, 3) [m] where heel and toe stand.
        frames: (2, 3, 3) those of ankle and toe joint while both are planted.
        ends, slopes: (4, 2, 3) offset of each of `HELD` from the cycle at the start and at the end of being held, [m]
            or [rad], and its derivative there [1/s].
        down: [m] by how much the figure is lowered so that the leg reaches the floor when the heel is set down.
    """

    leg: int
    count: int
    heel: Span | None
    toe: Span | None
    points: Floats = field(default_factory=lambda: _NOWHERE)
    frames: Floats = field(default_factory=lambda: _AS_IT_IS)
    ends: Floats = field(default_factory=lambda: _NO_ENDS)
    slopes: Floats = field(default_factory=lambda: _NO_ENDS)
    down: float = 0.0

    @cached_property
    def flat(self) -> Span | None:
        """Find when heel and toe are both planted [s]; None where they never are."""
        if self.heel is None or self.toe is None:
            return None
        low, high = max(self.heel[0], self.toe[0]), min(self.heel[1], self.toe[1])
        return (low, high) if high > low else None

    @property
    def start(self) -> float:
        """Find when the foot is set down [s]."""
        if self.heel is None or self.toe is None:
            return (self.heel or self.toe or (np.inf, np.inf))[0]
        return min(self.heel[0], self.toe[0])

    @property
    def end(self) -> float:
        """Find when the foot is lifted [s]."""
        if self.heel is None or self.toe is None:
            return (self.heel or self.toe or (-np.inf, -np.inf))[1]
        return max(self.heel[1], self.toe[1])

    @cached_property
    def spans(self) -> tuple[Span | None, ...]:
        """List when each of `HELD` is held [s]."""
        return self.heel, self.toe, self.flat, self.toe


def sample_times(stances: Sequence[Stance]) -> Floats:
    """List the times (n, M) [s] at which the cycle is sampled for each stance."""
    if not stances:
        return np.zeros((0, _SAMPLES))
    rows = []
    for each in stances:
        own = each.flat or each.toe or each.heel
        rows.append((own, *(span or own for span in each.spans), each.heel or own))
    spans = np.array(rows)  # (n, 6, 2)
    ends = spans[:, 1:5]
    beside = ends + _BESIDE
    parts = [_spread(spans[:, 0], _EVENLY), ends.reshape(-1, _ENDS), beside.reshape(-1, _ENDS),
             _spread(spans[:, 5], _ON_HEEL)]  # fmt: skip
    return np.concatenate(parts, axis=1)


def _spread(spans: Floats, shares: Floats) -> Floats:
    """Place times (n, M) in spans (n, 2) by shares (M,)."""
    return np.asarray(spans[:, :1] + (spans[:, 1:] - spans[:, :1]) * shares)


def settled(stances: Sequence[Stance], stays: Sequence[float], poses: LegPoses, model: CycleModel) -> list[Stance]:
    """Compute the places of stances and their offsets from the cycle; stances that stay keep their places.

    A foot has its mean pose of the time in which heel and toe are planted (G 5.1). It is moved to where the heel was
    early in its contact, to the height at which it stands in the cycles, and nearer if the leg would not reach it.

    Args:
        stances: n of them.
        stays: for each what share of the place that it has it keeps.
        poses: the legs as the cycle has them at the n x M `sample_times`.
        model: the figure.
    """
    if not stances:
        return []
    rows = np.arange(len(stances) * _SAMPLES).reshape(-1, _SAMPLES)
    legs = np.array([each.leg for each in stances])
    soles, frames = poses.soles[rows, legs[:, None]], poses.ends[rows, legs[:, None]]  # (n, M, 2, 3), and 3 x 3
    points, turned = _places(stances, legs, soles, frames, model)
    points += _where_set_down(stances, points, soles[:, -_REACHED:, 0])[:, None]
    points += _nearer(stances, poses, rows[:, -_REACHED:], legs, points[:, 0])[:, None]
    for k in np.flatnonzero(stays).tolist():
        if stays[k] == 1.0:
            points[k], turned[k] = stances[k].points, stances[k].frames
        else:
            points[k] += stays[k] * np.mean(stances[k].points - points[k], axis=0)
    down = _down(stances, poses, rows[:, -_REACHED], legs, points[:, 0], model)
    off = np.empty((len(stances), 4, 4, 3))  # of each of `HELD` at its start, its end, and beside them
    two = np.arange(2)
    off[:, :2] = points[:, :, None] - soles[:, _WHERE[:2], two[:, None]]
    off[:, 2:] = turns_between(frames[:, _WHERE[2:], two[:, None]], turned[:, :, None])
    off[:, 3] *= UP
    ends = off[:, :, :2]
    slopes = (off[:, :, 2:] - ends) * _WAY
    return [
        Stance(each.leg, each.count, each.heel, each.toe, points[k], turned[k], ends[k], slopes[k], down[k])
        for k, each in enumerate(stances)
    ]


def _places(
    stances: Sequence[Stance], legs: Ints, soles: Floats, frames: Floats, model: CycleModel
) -> tuple[Floats, Floats]:
    """Find where the cycle has heels and toes (n, 2, 3) [m], and their frames (n, 2, 3, 3)."""
    middle = _INSIDE // 2
    level = model.sole_levels[legs]  # (n, 2)
    points = soles[:, :_INSIDE].mean(axis=1)
    points[..., 1] = level
    turned = frames[:, middle]
    flat = np.array([each.flat is not None for each in stances])
    along = soles[:, middle, 1] - soles[:, middle, 0]
    rise = level[:, 1] - level[:, 0]
    size = np.sqrt(np.maximum(dot(along, along) - rise * rise, 0.0))
    lying = size[:, None] * unit(along * _FLAT) + rise[:, None] * UP
    points[flat, 0] = (points[:, 1] - lying)[flat]
    turned[flat, 0] = (between(along, lying) @ turned[:, 0])[flat]
    return points, turned


def _where_set_down(stances: Sequence[Stance], points: Floats, heel: Floats) -> Floats:
    """Move places (n, 2, 3) over the floor, by (n, 3) [m], towards where the cycle has the heels (n, M, 3) early on.

    While the speed changes, the cycle's foot does not stay where it was set down. Early in a contact the leg is
    straight and can't make up for that; later the knee bends, or the heel is lifted.
    """
    early = np.where([[each.heel is not None] for each in stances], _EARLY, 0.0)
    return np.asarray(np.einsum("nm,nmi->ni", early, heel - points[:, None, 0]) * _FLAT)


def _nearer(stances: Sequence[Stance], poses: LegPoses, rows: Ints, legs: Ints, heel_at: Floats) -> Floats:
    """Move places (n, 3) nearer, horizontally by (n, 3) [m], so that legs always reach the heels."""
    hip, ankle, heel = (each[rows, legs[:, None]] for each in (poses.hip, poses.ankle, poses.heel))
    limit = poses.reach[rows, legs[:, None]]
    limit = np.where(norm(ankle - hip) > _STRETCHED * limit, limit, _STRETCHED * limit)  # straight legs may stay so
    line = ankle - heel + heel_at[:, None] - hip
    short = norm(line * _FLAT) - np.sqrt(np.maximum(limit**2 - line[..., 1] ** 2, 0.0))  # (n, samples)
    worst = np.argmax(short, axis=1)
    each = np.arange(len(stances))
    stands = np.array([stance.heel is not None for stance in stances])
    by = np.minimum(np.maximum(short[each, worst], 0.0), _FARTHEST * limit[each, worst]) * stands
    return np.asarray(-by[:, None] * unit(line[each, worst] * _FLAT))


def _down(
    stances: Sequence[Stance], poses: LegPoses, rows: Ints, legs: Ints, heel_at: Floats, model: CycleModel
) -> list[float]:
    """Compute by how much (n,) [m] to lower the figure so that legs reach the floor when heels are set down."""
    hip, ankle, heel = (each[rows, legs] for each in (poses.hip, poses.ankle, poses.heel))
    short = too_short(ankle - heel + heel_at - hip, poses.reach[rows, legs], model.rig.leg_length)
    return [float(by) if each.heel is not None else 0.0 for each, by in zip(stances, short, strict=True)]

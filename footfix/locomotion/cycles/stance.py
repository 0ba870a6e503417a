"""When and where a foot of an engine stands: foreseen from the cycle.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 4 and 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footfix.locomotion.cycles.leg_pose import LegPoses, between, reach, vector_between
from footfix.locomotion.cycles.model import CycleModel
from footfix.motion.clip import Floats, Ints
from footfix.motion.vectors import norm, unit

HELD = ("heel", "toe", "foot", "toes")  # what a stance holds: two places, a turn, a heading
_INSIDE = 7  # samples of a contact, of which it is told where the foot is to stand
_REACHED = 5  # samples of a heel's contact, at which the leg has to be long enough
_ENDS = 2 * len(HELD)
_SAMPLES = _INSIDE + 2 * _ENDS + _REACHED
_STRETCHED = 0.9985  # of a leg's reach, at which a heel is placed at the farthest
_FARTHEST = 0.025  # of a leg's reach, by which a place is drawn nearer at most
_DELTA = 0.004  # [s] over which slopes are told
_FLAT = np.array([1.0, 0.0, 1.0])
_UP = np.array([0.0, 1.0, 0.0])

Span = tuple[float, float]  # [s]


@dataclass(frozen=True, eq=False)
class Stance:
    """A foot on the floor, once.

    Args:
        leg: index among the rig's legs.
        count: of the cycles since the engine began.
        heel, toe: [s] when they are planted; None where they never are.
        heel_place, toe_place: (3,) [m] where.
        foot, toes: (3, 3) the frames of ankle and toe joint while both are planted.
        ends, slopes: (4, 2, 3) how far off the cycle each of `HELD` is when it begins to be held and when it ends, [m]
            or [rad], and how that changes then [1/s].
    """

    leg: int
    count: int
    heel: Span | None
    toe: Span | None
    heel_place: Floats = field(default_factory=lambda: np.zeros(3))
    toe_place: Floats = field(default_factory=lambda: np.zeros(3))
    foot: Floats = field(default_factory=lambda: np.eye(3))
    toes: Floats = field(default_factory=lambda: np.eye(3))
    ends: Floats = field(default_factory=lambda: np.zeros((4, 2, 3)))
    slopes: Floats = field(default_factory=lambda: np.zeros((4, 2, 3)))

    @property
    def flat(self) -> Span | None:
        """[s] while heel and toe are planted."""
        if self.heel is None or self.toe is None:
            return None
        low, high = max(self.heel[0], self.toe[0]), min(self.heel[1], self.toe[1])
        return (low, high) if high > low else None

    @property
    def start(self) -> float:
        """[s] when the foot is set down."""
        return min(span[0] for span in (self.heel, self.toe) if span is not None)

    @property
    def end(self) -> float:
        """[s] when it is lifted."""
        return max(span[1] for span in (self.heel, self.toe) if span is not None)

    def span(self, quantity: str) -> Span | None:
        """[s] while one of `HELD` is held."""
        return {"heel": self.heel, "toe": self.toe, "foot": self.flat, "toes": self.toe}[quantity]


def sample_times(stances: Sequence[Stance]) -> Floats:
    """(n, M) [s] the times at which the cycle is looked at for each stance."""
    inside = np.array([each.flat or each.toe or each.heel for each in stances])  # (n, 2)
    spans = [[each.span(name) for name in HELD] for each in stances]
    ends = np.array([[span or tuple(own) for span in of] for of, own in zip(spans, inside, strict=True)])  # (n, 4, 2)
    heel = np.array([each.heel or tuple(own) for each, own in zip(stances, inside, strict=True)])
    beside = ends + np.array([_DELTA, -_DELTA])
    parts = [_spread(inside, _INSIDE), ends.reshape(-1, _ENDS), beside.reshape(-1, _ENDS), _spread(heel, _REACHED)]
    return np.concatenate(parts, axis=1)


def _spread(spans: Floats, count: int) -> Floats:
    """(n, count) even times of spans (n, 2)."""
    return np.asarray(spans[:, :1] + (spans[:, 1:] - spans[:, :1]) * np.linspace(0.0, 1.0, count))


def settled(stances: Sequence[Stance], stays: Sequence[bool], poses: LegPoses, model: CycleModel) -> list[Stance]:
    """Give stances their places, and tell how far off the cycle they are; those that stay keep their places.

    A foot stands where the cycle has it, in the mean of the time in which heel and toe are planted, at the height at
    which it does in the cycles (G 5.1), and so near that the leg reaches it.

    Args:
        stances: n of them.
        stays: for each whether it has a place.
        poses: the legs as the cycle has them at the n x M `sample_times`.
        model: the figure.
    """
    rows = np.arange(len(stances) * _SAMPLES).reshape(-1, _SAMPLES)
    legs = np.array([each.leg for each in stances])
    heel, toe, foot, toes = (getattr(poses, name)[rows, legs[:, None]] for name in HELD)
    held = _places(stances, legs, heel, toe, foot, toes, model)
    held[0], held[1] = _within_reach(stances, poses, rows[:, -_REACHED:], legs, held[0], held[1])
    if any(stays):
        kept = np.array(stays)
        for q, name in enumerate(("heel_place", "toe_place", "foot", "toes")):
            held[q][kept] = [getattr(each, name) for each, stay in zip(stances, stays, strict=True) if stay]
    off = np.empty((len(stances), _SAMPLES, 3))
    two = [slice(_INSIDE + 2 * q, _INSIDE + 2 * q + 2) for q in range(4)]
    beside = [slice(each.start + _ENDS, each.stop + _ENDS) for each in two]
    for a, b in zip(two, beside, strict=True):
        for q, at in ((two.index(a), a), (two.index(a), b)):
            off[:, at] = off_cycle(HELD[q], held[q][:, None], (heel, toe, foot, toes)[q][:, at])
    ends = off[:, _INSIDE : _INSIDE + _ENDS].reshape(-1, 4, 2, 3)
    way = np.array([[1.0], [-1.0]]) / _DELTA
    slopes = way * (off[:, _INSIDE + _ENDS : _INSIDE + 2 * _ENDS].reshape(-1, 4, 2, 3) - ends)
    return [
        replace(each, heel_place=held[0][k], toe_place=held[1][k], foot=held[2][k], toes=held[3][k], ends=ends[k],
                slopes=slopes[k])
        for k, each in enumerate(stances)
    ]  # fmt: skip


def off_cycle(quantity: str, held: Floats, free: Floats) -> Floats:
    """(..., 3) [m] or [rad] from what the cycle has to what is held: places (..., 3) or frames (..., 3, 3)."""
    if quantity in ("heel", "toe"):
        return np.asarray(held - free)
    turn = vector_between(free, np.broadcast_to(held, free.shape))
    return turn if quantity == "foot" else turn * _UP


def _places(
    stances: Sequence[Stance], legs: Ints, heel: Floats, toe: Floats, foot: Floats, toes: Floats, model: CycleModel
) -> list[Floats]:
    """Heels' and toes' places (n, 3) [m], and frames (n, 3, 3) of feet and toes, where the cycle has them."""
    rig, middle = model.rig, _INSIDE // 2
    level = np.zeros((len(rig.legs), 2))
    for e, sole in enumerate(rig.soles):
        level[sole.leg, int(sole.part == "toe")] = model.levels[e] * rig.leg_length
    heel_at, toe_at = heel[:, :_INSIDE].mean(axis=1), toe[:, :_INSIDE].mean(axis=1)
    heel_at[:, 1], toe_at[:, 1] = level[legs, 0], level[legs, 1]
    flat = np.array([each.flat is not None for each in stances])
    along = toe[:, middle] - heel[:, middle]
    rise = level[legs, 1] - level[legs, 0]
    size = np.sqrt(np.maximum(np.sum(along * along, axis=1) - rise * rise, 0.0))
    lying = size[:, None] * unit(along * _FLAT) + rise[:, None] * _UP
    turned = np.where(flat[:, None, None], between(along, lying) @ foot[:, middle], foot[:, middle])
    return [np.where(flat[:, None], toe_at - lying, heel_at), toe_at, turned, toes[:, middle]]


def _within_reach(
    stances: Sequence[Stance], poses: LegPoses, rows: Ints, legs: Ints, heel_at: Floats, toe_at: Floats
) -> tuple[Floats, Floats]:
    """Places (n, 3) [m] drawn nearer over the floor, where a leg would not reach its heel throughout the contact."""
    hip, ankle, heel = (getattr(poses, name)[rows, legs[:, None]] for name in ("hip", "ankle", "heel"))
    limit = reach(poses)[rows, legs[:, None]]
    limit = np.where(norm(ankle - hip) > _STRETCHED * limit, limit, _STRETCHED * limit)  # straight legs may stay so
    line = ankle - heel + heel_at[:, None] - hip
    short = norm(line * _FLAT) - np.sqrt(np.maximum(limit**2 - line[..., 1] ** 2, 0.0))  # (n, samples)
    worst = np.argmax(short, axis=1)
    each = np.arange(len(stances))
    stands = np.array([stance.heel is not None for stance in stances])
    by = np.minimum(np.maximum(short[each, worst], 0.0), _FARTHEST * limit[each, worst]) * stands
    nearer = -by[:, None] * unit(line[each, worst] * _FLAT)
    return heel_at + nearer, toe_at + nearer

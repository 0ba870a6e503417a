"""Where the feet of an engine stand: foreseen from the cycle and the plan, held, and led to.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 4 and 5.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footfix.enforce.papers.ease import gamma
from footfix.locomotion.leg_pose import LegPose, heel_offset
from footfix.locomotion.model import CycleModel
from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats
from footfix.motion.vectors import unit

SIGMA = 0.3  # [s] of an ease, before a contact and after it (G 5.2)
_INSIDE = 7  # samples of a contact, of which it is told where the foot is to stand

Span = tuple[float, float]  # [s]


@dataclass(frozen=True, eq=False)
class Stance:
    """A foot on the floor, once.

    Args:
        leg: index among the rig's legs.
        count: of the cycles since the engine began.
        heel, toe: [s] when they are planted; None where they never are.
        heel_place, toe_place: (3,) [m] where.
        foot, toes: (4,) the frames of ankle and toe joint while heel and toe are both planted, and while the toe is.
        ends: how far off the cycle each of these is when it begins and when it ends: quantity -> (2, 3).
    """

    leg: int
    count: int
    heel: Span | None
    toe: Span | None
    heel_place: Floats = field(default_factory=lambda: np.zeros(3))
    toe_place: Floats = field(default_factory=lambda: np.zeros(3))
    foot: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 0.0, 1.0]))
    toes: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 0.0, 1.0]))
    ends: dict[str, Floats] = field(default_factory=dict)

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
        """[s] while a quantity is held: "heel", "toe", "foot" (its turn) or "toes" (theirs)."""
        return {"heel": self.heel, "toe": self.toe, "foot": self.flat, "toes": self.toe}[quantity]


QUANTITIES = ("heel", "toe", "foot", "toes")


def sample_times(stance: Stance) -> Floats:
    """[s] the times of a stance at which the cycle is looked at: inside of what tells its place, then the spans' ends."""
    inside = stance.flat or stance.toe or stance.heel
    assert inside is not None
    ends = [each for name in QUANTITIES for each in (stance.span(name) or (stance.start, stance.end))]
    return np.concatenate([np.linspace(*inside, _INSIDE), ends])


def placed(stance: Stance, pose: LegPose, model: CycleModel) -> Stance:
    """A stance with its place: where the cycle has the foot, in the mean of the time that both ends are planted.

    Args:
        stance: when.
        pose: the leg as the cycle has it at `sample_times`.
        model: the figure.
    """
    leg, few = model.rig.legs[stance.leg], slice(0, _INSIDE)
    level = {sole.part: model.levels[e] * model.rig.leg_length
             for e, sole in enumerate(model.rig.soles) if sole.leg == stance.leg}  # fmt: skip
    middle = _INSIDE // 2
    foot, toe, heel = pose.turns[leg.ankle][middle], pose.toe[few].mean(axis=0), pose.heel[few].mean(axis=0)
    toes = pose.turns[leg.toe][middle] if leg.toe is not None else foot
    toe[1], heel[1] = level["toe"], level["heel"]
    if stance.flat is not None:
        along = pose.toe[middle] - pose.heel[middle]
        level_off = _levelled(along, level["toe"] - level["heel"])
        turn = rotation.between(along, level_off)
        foot, toes = rotation.multiply(turn, foot), rotation.multiply(turn, toes)
        heel = toe - level_off
    found = replace(stance, heel_place=heel, toe_place=toe, foot=foot, toes=toes)
    return with_ends(found, pose, model)


def with_ends(stance: Stance, pose: LegPose, model: CycleModel) -> Stance:
    """A stance that stays where it is, with how far off the cycle it is at the ends of its spans."""
    rows = np.arange(_INSIDE, _INSIDE + 2 * len(QUANTITIES)).reshape(-1, 2)
    ends = {name: _off(stance, name, pose, model)[own] for name, own in zip(QUANTITIES, rows, strict=True)}
    return replace(stance, ends=ends)


def _levelled(along: Floats, rise: float) -> Floats:
    """(3,) [m] a vector as long, over the floor in the same direction, that rises by so much."""
    flat = np.sqrt(max(float(along @ along) - rise * rise, 0.0))
    return flat * unit(along * [1.0, 0.0, 1.0]) + [0.0, rise, 0.0]


def _off(stance: Stance, quantity: str, pose: LegPose, model: CycleModel) -> Floats:
    """(T, 3) [m] or [rad] from what the cycle has to what a stance holds."""
    leg = model.rig.legs[stance.leg]
    if quantity == "heel":
        return np.asarray(stance.heel_place - pose.heel)
    if quantity == "toe":
        return np.asarray(stance.toe_place - pose.toe)
    held, joint = (stance.foot, leg.ankle) if quantity == "foot" else (stance.toes, leg.toe if leg.toe is not None else leg.ankle)
    return rotation.to_rotation_vector(rotation.multiply(held, rotation.inverse(pose.turns[joint])))


def displacement(quantity: str, stances: Sequence[Stance], times: Floats, pose: LegPose, model: CycleModel) -> Floats:
    """(T, 3) [m] or [rad] how far a quantity is led off the cycle: to what holds it, and from there to the next (G eq. 9).

    Args:
        quantity: which one.
        stances: of one foot, in order of time.
        times: (T,) [s].
        pose: the leg as the cycle has it.
        model: the figure.
    """
    out = np.zeros((len(times), 3))
    own = [(each.span(quantity), each) for each in stances if each.span(quantity) is not None]
    before: tuple[float, Floats] | None = None
    for span, stance in own:
        assert span is not None
        start, end = span
        first, last = stance.ends[quantity]
        inside = (times >= start) & (times <= end)
        if np.any(inside):
            out[inside] = _off(stance, quantity, pose, model)[inside]
        if before is not None and start - before[0] < 2.0 * SIGMA:
            between = (times > before[0]) & (times < start)
            fall = gamma((times[between] - before[0]) / max(start - before[0], 1e-9))[:, None]
            out[between] = fall * before[1] + (1.0 - fall) * first
        else:
            if before is not None:
                _fall(out, times, before)
            ahead = (times >= start - SIGMA) & (times < start)
            out[ahead] = (1.0 - gamma((times[ahead] - start + SIGMA) / SIGMA))[:, None] * first
        before = (end, last)
    if before is not None:
        _fall(out, times, before)
    return out


def _fall(out: Floats, times: Floats, before: tuple[float, Floats]) -> None:
    after = (times > before[0]) & (times < before[0] + SIGMA)
    out[after] = gamma((times[after] - before[0]) / SIGMA)[:, None] * before[1]


def share_of_toe(stances: Sequence[Stance], times: Floats) -> Floats:
    """(T,) by which of its ends a foot is led: 0 by the heel, 1 by the toe; while both are planted they say the same."""
    knots: list[tuple[float, float]] = []
    for each in stances:
        if each.heel is None:
            knots += [(each.start, 1.0), (each.end, 1.0)]
        elif each.toe is None:
            knots += [(each.start, 0.0), (each.end, 0.0)]
        else:
            first, last = float(each.toe[0] < each.heel[0]), float(each.toe[1] >= each.heel[1])
            low, high = each.flat or (each.heel[1], each.toe[0])
            knots += [(each.start, first), (low, first), (high, last), (each.end, last)]
    if not knots:
        return np.zeros(len(times))
    at, value = np.array(knots).T
    k = np.clip(np.searchsorted(at, times, side="right") - 1, 0, len(at) - 1)
    after = np.minimum(k + 1, len(at) - 1)
    u = (times - at[k]) / np.maximum(at[after] - at[k], 1e-9)
    fall = gamma(u)
    return np.asarray(fall * value[k] + (1.0 - fall) * value[after])


def foot_goal(
    model: CycleModel, pose: LegPose, off: dict[str, Floats], share: Floats
) -> tuple[Floats, Floats, Floats]:
    """Where a foot is to be: (T, 3) [m] its ankle, (T, 4) the frames of ankle and toe joint in the world.

    Args:
        model: the figure.
        pose: the leg as the cycle has it.
        off: quantity -> (T, 3), from `displacement`.
        share: (T,) from `share_of_toe`.
    """
    leg = model.rig.legs[pose.number]
    turn = rotation.from_rotation_vector(off["foot"])
    part = share[:, None]
    pivot = pose.heel + part * (pose.toe - pose.heel)
    goal = pivot + (1.0 - part) * off["heel"] + part * off["toe"]
    ankle = goal + rotation.rotate(turn, pose.places[leg.ankle] - pivot)
    foot = rotation.multiply(turn, pose.turns[leg.ankle])
    toes = pose.turns[leg.toe if leg.toe is not None else leg.ankle]
    return ankle, foot, rotation.multiply(rotation.from_rotation_vector(off["toes"]), toes)


def contact_mask(stances: Sequence[Stance], part: str, times: Floats) -> Bools:
    """(T,) whether heel or toe is planted."""
    mask = np.zeros(len(times), dtype=np.bool_)
    for each in stances:
        span = each.span(part)
        if span is not None:
            mask |= (times >= span[0]) & (times <= span[1])
    return mask


__all__ = ["Callable", "Stance", "contact_mask", "displacement", "foot_goal", "heel_offset", "placed", "sample_times"]

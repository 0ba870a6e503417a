"""Where the feet of an engine stand: foreseen from the cycle and the plan, held, and led to.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 4 and 5.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footfix.locomotion.leg_pose import LegPoses, between, reach, turned_by, vector_between
from footfix.locomotion.model import CycleModel
from footfix.locomotion.timeline import Timeline, make_timeline, through
from footfix.motion.clip import Floats, Ints
from footfix.motion.vectors import norm, unit

SIGMA = 0.3  # [s] of an ease, before a contact and after it (G 5.2)
_INSIDE = 7  # samples of a contact, of which it is told where the foot is to stand
_REACHED = 5  # samples of a heel's contact, at which the leg has to be long enough
_PEEL = 0.08  # [s] after the heel has left the floor, and before the foot is set down, in which it becomes free to turn
_STRETCHED = 0.9985  # of a leg's reach, at which a heel is placed at the farthest
_FARTHEST = 0.05  # [leg lengths] by which a place is drawn nearer at most
_DELTA = 0.004  # [s] over which slopes are told
_SIZES = {"heel": 3, "toe": 3, "foot": 3, "toes": 1}  # numbers of what is held: two places, a turn, a heading

Span = tuple[float, float]  # [s]
Off = Mapping[str, Floats]


@dataclass(frozen=True, eq=False)
class Stance:
    """A foot on the floor, once.

    Args:
        leg: index among the rig's legs.
        count: of the cycles since the engine began.
        heel, toe: [s] when they are planted; None where they never are.
        heel_place, toe_place: (3,) [m] where.
        foot, toes: (3, 3) the frames of ankle and toe joint while both are planted.
        ends, slopes: how far off the cycle each quantity is when it begins to be held, and when it ends, and how that
            changes then [1/s]: quantity -> (2, size).
    """

    leg: int
    count: int
    heel: Span | None
    toe: Span | None
    heel_place: Floats = field(default_factory=lambda: np.zeros(3))
    toe_place: Floats = field(default_factory=lambda: np.zeros(3))
    foot: Floats = field(default_factory=lambda: np.eye(3))
    toes: Floats = field(default_factory=lambda: np.eye(3))
    ends: Off = field(default_factory=dict)
    slopes: Off = field(default_factory=dict)

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
        """[s] while a quantity is held: "heel", "toe", "foot" (its turn) or "toes" (their heading)."""
        return {"heel": self.heel, "toe": self.toe, "foot": self.flat, "toes": self.toe}[quantity]


def sample_times(stance: Stance) -> Floats:
    """[s] the times of a stance at which the cycle is looked at: inside of what tells its place, then the spans' ends."""
    inside = stance.flat or stance.toe or stance.heel
    assert inside is not None
    ends = np.array([stance.span(name) or inside for name in _SIZES])  # (4, 2)
    heel = stance.heel or inside
    return np.concatenate([
        np.linspace(*inside, _INSIDE), ends.ravel(), (ends + np.array([_DELTA, -_DELTA])).ravel(),
        np.linspace(*heel, _REACHED),
    ])  # fmt: skip


def placed(stance: Stance, pose: LegPoses, model: CycleModel) -> Stance:
    """A stance with its place: where the cycle has the foot, in the mean of the time that both ends are planted.

    Args:
        stance: when.
        pose: the legs as the cycle has them at `sample_times`.
        model: the figure.
    """
    rig, k, middle = model.rig, stance.leg, _INSIDE // 2
    level = {s.part: float(model.levels[e]) * rig.leg_length for e, s in enumerate(rig.soles) if s.leg == k}
    foot, toes = pose.foot[middle, k], pose.toes[middle, k]
    toe, heel = pose.toe[:_INSIDE, k].mean(axis=0), pose.heel[:_INSIDE, k].mean(axis=0)
    toe[1], heel[1] = level["toe"], level["heel"]
    if stance.flat is not None:
        along = pose.toe[middle, k] - pose.heel[middle, k]
        level_off = _levelled(along, level["toe"] - level["heel"])
        foot = between(along, level_off) @ foot
        heel = toe - level_off
    nearer = _nearer(pose.some(slice(-_REACHED, None)), k, heel) if stance.heel else 0.0
    found = replace(stance, heel_place=heel + nearer, toe_place=toe + nearer, foot=foot, toes=toes)
    return with_ends(found, pose, model)


def _nearer(pose: LegPoses, k: int, heel: Floats) -> Floats:
    """(3,) [m] by which a heel's place must be nearer over the floor, for the leg to reach it throughout its contact."""
    hip, ankle = pose.hip[:, k], pose.ankle[:, k] - pose.heel[:, k] + heel
    limit = _STRETCHED * reach(pose)[:, k]
    line = ankle - hip
    flat = np.hypot(line[:, 0], line[:, 2])
    room = np.sqrt(np.maximum(limit**2 - line[:, 1] ** 2, 0.0))
    worst = int(np.argmax(flat - room))
    short = min(max(flat[worst] - room[worst], 0.0), _FARTHEST * limit[worst])
    return np.asarray(-short * unit(line[worst] * [1.0, 0.0, 1.0]))


def with_ends(stance: Stance, pose: LegPoses, model: CycleModel) -> Stance:
    """A stance that stays where it is, with how far off the cycle it is at the ends of its spans."""
    n = 2 * len(_SIZES)
    rows = np.arange(_INSIDE, _INSIDE + n).reshape(-1, 2)
    one = np.zeros(2, np.intp)
    ends = {name: _held(name, [stance], one, pose, own) for name, own in zip(_SIZES, rows, strict=True)}
    beside = {name: _held(name, [stance], one, pose, own + n) for name, own in zip(_SIZES, rows, strict=True)}
    way = np.array([[1.0], [-1.0]]) / _DELTA
    return replace(stance, ends=ends, slopes={name: way * (beside[name] - ends[name]) for name in _SIZES})


def _levelled(along: Floats, rise: float) -> Floats:
    """(3,) [m] a vector as long, over the floor in the same direction, that rises by so much."""
    flat = np.sqrt(max(float(along @ along) - rise * rise, 0.0))
    return flat * unit(along * [1.0, 0.0, 1.0]) + [0.0, rise, 0.0]


def _held(quantity: str, stances: Sequence[Stance], holder: Ints, pose: LegPoses, rows: Ints) -> Floats:
    """(n, size) [m] or [rad] from what the cycle has at some rows of a pose to what stances hold."""
    leg = stances[0].leg
    if quantity == "heel":
        return np.array([stances[k].heel_place for k in holder]) - pose.heel[rows, leg]
    if quantity == "toe":
        return np.array([stances[k].toe_place for k in holder]) - pose.toe[rows, leg]
    name = "foot" if quantity == "foot" else "toes"
    off = vector_between(getattr(pose, name)[rows, leg], np.array([getattr(stances[k], name) for k in holder]))
    return off if quantity == "foot" else off[:, 1:2]


@dataclass(frozen=True, eq=False)
class FootPlan:
    """What one foot is going to do.

    Args:
        stances: in order of time.
        lines: quantity -> how it is led off the cycle.
        share: by which of its ends the foot is led: 0 by the heel, 1 by the toe; while both are planted they say the same.
        free: 1 while the foot may turn about its toe, 0 while its heel is planted.
    """

    stances: tuple[Stance, ...]
    lines: Mapping[str, Timeline]
    share: Timeline
    free: Timeline

    def spans(self, quantity: str) -> list[Span]:
        """[s] when a quantity is held."""
        return [span for each in self.stances if (span := each.span(quantity)) is not None]


def foot_plan(stances: Sequence[Stance]) -> FootPlan:
    """The plan of one foot, of its stances in order of time."""
    lines = {}
    for name, size in _SIZES.items():
        own = [(k, each) for k, each in enumerate(stances) if each.span(name) is not None]
        spans = [span for _, each in own if (span := each.span(name)) is not None]
        ends = [each.ends[name] for _, each in own]
        slopes = [each.slopes[name] for _, each in own]
        lines[name] = make_timeline(spans, ends, slopes, [k for k, _ in own], SIGMA, size)
    share, free = list[tuple[float, float]](), list[tuple[float, float]]()
    for each in stances:
        if free and free[-1][1] == 1.0 and each.start - _PEEL > free[-1][0]:
            free.append((each.start - _PEEL, 1.0))
        if each.heel is None or each.toe is None:
            by = float(each.heel is None)
            share += [(each.start, by), (each.end, by)]
            free += [(each.start, by), (each.end, by)]
            continue
        first, last = float(each.toe[0] < each.heel[0]), float(each.toe[1] >= each.heel[1])
        low, high = each.flat or (each.heel[1], max(each.toe[0], each.heel[1] + 1e-3))
        share += [(each.start, first), (low, first), (high, last), (each.end, last)]
        free += [(each.heel[0], 0.0), (each.heel[1], 0.0)]
        if each.end > each.heel[1]:
            peel = min(_PEEL, each.end - each.heel[1])
            free += [(each.heel[1] + peel, 1.0), (max(each.end, each.heel[1] + peel), 1.0)]
    return FootPlan(tuple(stances), lines, through(share), through(free))


def led_off(plan: FootPlan, times: Floats, pose: LegPoses) -> dict[str, Floats]:
    """How a foot is led off the cycle: quantity -> (T, size), and "share" and "free" (T, 1).

    Args:
        plan: of the foot.
        times: (T,) [s].
        pose: the legs as the cycle has them.
    """
    off = {}
    for name, line in plan.lines.items():
        value, holder = line.at(times)
        rows = np.flatnonzero(holder >= 0)
        if len(rows):
            value[rows] = _held(name, plan.stances, holder[rows], pose, rows)
        off[name] = value
    off["share"], off["free"] = plan.share.at(times)[0], plan.free.at(times)[0]
    return off


def goals(pose: LegPoses, off: Mapping[str, Floats]) -> tuple[Floats, Floats, Floats]:
    """Where feet are to be: (T, L, 3) [m] the ankles, (T, L, 3, 3) the frames of ankles and toe joints.

    Args:
        pose: the legs as the cycle has them.
        off: quantity -> (T, L, size), of all legs, from `led_off`.
    """
    turn, part = turned_by(off["foot"]), off["share"]
    pivot = pose.heel + part * (pose.toe - pose.heel)
    goal = pivot + (1.0 - part) * off["heel"] + part * off["toe"]
    ankle = goal + (turn @ (pose.ankle - pivot)[..., None])[..., 0]
    foot = turn @ pose.foot
    toe = goal + (turn @ (pose.toe - pivot)[..., None])[..., 0]
    ankle, peel = _peeled(pose, ankle, toe, off["free"][..., 0])
    heading = turned_by(off["toes"] * np.array([0.0, 1.0, 0.0]))
    return ankle, peel @ foot, heading @ pose.toes


def _peeled(pose: LegPoses, ankle: Floats, toe: Floats, free: Floats) -> tuple[Floats, Floats]:
    """Turn feet about their toes where a leg would be stretched farther than in the cycle: the heel comes up instead.

    Returns:
        (T, L, 3) [m] the ankles, and (T, L, 3, 3) the turns.
    """
    limit, was, now = reach(pose), norm(pose.ankle - pose.hip), norm(ankle - pose.hip)
    room = np.maximum(limit - was, 1e-6)
    beyond = np.maximum(now - was, 0.0)
    wanted = now - free * (beyond - room * (1.0 - np.exp(-beyond / room)))
    # in the triangle of hip, toe and ankle the angle at the toe tells how far the ankle is from the hip
    arm, line = ankle - toe, pose.hip - toe
    r, d = norm(arm), norm(line)
    lever = np.maximum(2.0 * r * d, 1e-9)
    old, new = (np.arccos(np.clip((r * r + d * d - x * x) / lever, -1.0, 1.0)) for x in (now, wanted))
    axis = unit(np.cross(arm, line))
    turn = turned_by(axis * (old - new)[..., None])
    return toe + (turn @ arm[..., None])[..., 0], turn

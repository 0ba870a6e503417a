"""Offsets that hold an engine's feet in stances, and lead them from one stance to the next.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), section 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.locomotion.cycles.easing import Row, Timelines, held_rows, through_rows, timelines
from footfix.locomotion.cycles.leg_pose import LegPoses, too_short
from footfix.locomotion.cycles.leg_vectors import applied, cross, dot, turned_by, turns_between, unit
from footfix.locomotion.cycles.stance import HELD, UP, Span, Stance
from footfix.motion.clip import Bools, Floats

SIGMA = 0.3  # [s] of an ease, before a contact and after it (G 5.2)
_PEEL = 0.12  # [s] after the heel leaves the floor, and before the foot lands, over which it becomes free to turn
_STRAIGHT = 0.1  # [of a leg's reach] this near to its reach a leg is so straight that its foot turns about the toe
_LOWEST = 0.08  # [leg lengths] greatest lowering of a figure
_DOWN = 0.3  # [s] before and after a heel is set down, over which the figure is lowered and raised again
_QUANTITIES = (*HELD, "share", "free", "down")
_TWO = np.arange(2)


@dataclass(frozen=True, eq=False)
class Feet:
    """The coming stances of all feet.

    Args:
        stances: of each foot, in order of time.
        lines: offsets of the feet from the cycle, seven for each foot: the four of `HELD`; the share of the toe, from 0
            where the heel places the foot to 1 where the toe does (while both are planted they agree); how free the
            foot is to turn about its toe, 0 while its heel is planted; and how far the figure is lowered for it [m].
    """

    stances: tuple[tuple[Stance, ...], ...]
    lines: Timelines

    def planted(self, times: Floats) -> Bools:
        """Tell whether heel and toe of each foot are planted, (T, L, 2)."""
        at = times[:, None, None, None]
        begins, ends = self._planted
        return np.asarray(((at >= begins) & (at <= ends)).any(axis=3))

    @cached_property
    def _planted(self) -> tuple[Floats, Floats]:
        """List when contacts of heels and toes begin and end, (L, 2, n) [s], padded with contacts that never are."""
        most = max(map(len, self.stances), default=0)
        never = (np.inf, -np.inf)
        spans = [[[span or never for each in own for span in (each.spans[part],)] + [never] * (most - len(own))
                  for part in range(2)] for own in self.stances]  # fmt: skip
        table = np.array(spans).reshape(len(self.stances), 2, most, 2)
        return table[..., 0], table[..., 1]

    @cached_property
    def _held(self) -> tuple[Floats, Floats]:
        every = [each for own in self.stances for each in own]
        return np.array([each.points for each in every]), np.array([each.frames for each in every])

    def offsets_at(self, times: Floats, pose: LegPoses) -> Floats:
        """Compute the offsets of the feet from the cycle (G eq. 9), (T, L, 7, 3); the last three are numbers in
        component 0.

        Args:
            times: (T,) [s].
            pose: the legs as the cycle has them.
        """
        value, holder = self.lines.at(times)
        shape = (len(times), len(self.stances), len(_QUANTITIES))
        value, holder = value.reshape(*shape, 3), holder.reshape(shape)[:, :, :4]
        if any(self.stances):
            points, frames = self._held
            off = np.empty((*shape[:2], 4, 3))
            off[:, :, :2] = points[holder[:, :, :2], _TWO] - pose.soles
            off[:, :, 2:] = turns_between(pose.ends, frames[holder[:, :, 2:], _TWO])
            off[:, :, 3] *= UP
            np.copyto(value[:, :, :4], off, where=(holder >= 0)[..., None])
        return value


def make_feet(stances: Sequence[Sequence[Stance]]) -> Feet:
    """Make the motion of feet from the stances of each in order of time."""
    every = [each for own in stances for each in own]
    n = len(every)
    rows: list[list[Row]] = []
    numbers = list[float]()
    at = 0
    for own in stances:
        for q in range(len(HELD)):
            which = [k for k, each in enumerate(own, at) if each.spans[q] is not None]
            spans = [span for each in own if (span := each.spans[q]) is not None]
            values = [1 + 2 * (4 * k + q) for k in which]
            rows.append(held_rows(spans, values, [8 * n + v for v in values], which, SIGMA))
        for knots in _knots(own):
            times, through = zip(*(knots or [(0.0, 0.0)]), strict=True)
            rows.append(through_rows(times, 1 + 16 * n + len(numbers)))
            numbers += through
        at += len(own)
    some = np.zeros((1 + 16 * n + len(numbers), 3))
    if n:
        some[1 : 1 + 8 * n] = np.array([each.ends for each in every]).reshape(-1, 3)
        some[1 + 8 * n : 1 + 16 * n] = np.array([each.slopes for each in every]).reshape(-1, 3)
    some[1 + 16 * n :, 0] = numbers
    return Feet(tuple(map(tuple, stances)), timelines(rows, some))


def _knots(stances: Sequence[Stance]) -> tuple[list[Span], list[Span], list[Span]]:
    """List times and values of a foot's three numbers: share of the toe, freedom to turn, lowering of the figure [m].
    """
    share, free, down = list[Span](), list[Span](), list[Span]()
    for each in stances:
        if each.heel is not None and each.down > 0.0:
            strike = each.heel[0]
            before = max(strike - _DOWN, down[-1][0] if down else -np.inf)
            down += [(before, 0.0), (strike, each.down), (strike + _DOWN, 0.0)]
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
    return share, free, down


def goals(pose: LegPoses, off: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Compute the goals of feet.

    Args:
        pose: the legs as the cycle has them.
        off: (T, L, 7, 3) from `Feet.offsets_at`.

    Returns:
        (T, L, 3) [m] the hips, (T, L, 3) the ankles, and (T, L, 3, 3) the frames of ankles and toe joints.
    """
    by_heel, by_toe, part = off[:, :, 0], off[:, :, 1], off[:, :, 4, :1]
    turns = turned_by(off[:, :, 2:4])
    turn, heading = turns[:, :, 0], turns[:, :, 1]
    hip = np.array(pose.hip)
    hip[..., 1] -= np.add.reduce(off[:, :, 6, 0], axis=1, keepdims=True)
    pivot = pose.heel + part * (pose.toe - pose.heel)
    goal = pivot + by_heel + part * (by_toe - by_heel)
    arms = np.empty((*goal.shape, 2))
    arms[..., 0], arms[..., 1] = pose.ankle, pose.toe
    both = goal[..., None] + turn @ (arms - pivot[..., None])
    ankle, peel = _peeled(pose, hip, both[..., 0], both[..., 1], off[:, :, 5, 0])
    return hip, ankle, peel @ (turn @ pose.foot), heading @ pose.toes


def lowered(pose: LegPoses, line: Floats, free: Floats, size: float) -> Floats:
    """Compute by how much more (T,) [m] to lower the figure so that its legs reach planted feet; rarely needed.

    Args:
        pose: the legs as the cycle has them.
        line: (T, L, 3) [m] from the hips to where the ankles are to be.
        free: (T, L) how free feet are to turn about their toes instead.
        size: [m] of a leg.
    """
    down = np.max((1.0 - free) * too_short(line, pose.reach, size), axis=1)
    return np.asarray(np.minimum(down, _LOWEST * size))


def _peeled(pose: LegPoses, hip: Floats, ankle: Floats, toe: Floats, free: Floats) -> tuple[Floats, Floats]:
    """Raise heels, turning feet about their toes, where a straight leg would be stretched farther than in the cycle.

    A bent knee extends instead; hip, ankle and toe may then lie on one line, where no turn would help.

    Returns:
        (T, L, 3) [m] the ankles, and (T, L, 3, 3) the turns.
    """
    was, line = pose.far, ankle - hip
    now = np.sqrt(dot(line, line))
    near = _STRAIGHT * pose.reach
    room = np.maximum(near * (1.0 - np.exp((was - pose.reach) / near)), 1e-6)
    beyond = np.maximum(now - pose.reach + room, 0.0)
    wanted = now - free * (beyond - room * (1.0 - np.exp(-beyond / room)))
    # in the triangle of hip, toe and ankle the angle at the toe tells how far the ankle is from the hip
    arm, line = ankle - toe, hip - toe
    r, d = dot(arm, arm), dot(line, line)
    cosines = np.empty((2, *now.shape))
    cosines[0], cosines[1] = now, wanted
    cosines = (r + d - cosines * cosines) / np.maximum(2.0 * np.sqrt(r * d), 1e-9)
    old, new = np.arccos(np.minimum(np.maximum(cosines, -1.0), 1.0))
    turn = turned_by(unit(cross(arm, line)) * (old - new)[..., None])
    return toe + applied(turn, arm), turn

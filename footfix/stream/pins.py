"""The pins of a window: constraints on the points of all feet from plants already shown and plants to come."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.leg import ANKLE, HEEL, TIP, TOE
from footfix.enforce.pins import PinParams, Pins
from footfix.motion.clip import Bools, Floats, Ints
from footfix.motion.contacts import runs
from footfix.stream.arithmetic import median
from footfix.stream.legs import POINTS, Legs
from footfix.stream.plants import FootPlants, Ground, Plant, masks

_FIRM = {HEEL: 0.3, TOE: 25.0, ANKLE: 0.3}  # weight of the place of a plant that was shown
_LED = 0.5  # share of the remaining height by which a coming plant approaches its level per round
_PLANNED = 0.6  # weight of a coming plant's place, relative to that of one that was shown
_FEWEST = 2  # least number of frames of a coming plant from which its place is found
_FIRST_STEP = 0.3  # weight of a plant's first step, in which the foot is still landing
_DRAWN = 1.0 / 6.0  # weight of the floor's height for a plant of 0.6 s, since its duration is not known yet


@dataclass(frozen=True, eq=False)
class Stacked:
    """The pins of P points of L legs in a window, stacked; fields as of `Pins`.

    Args:
        hold: (P, L, F - 1).
        slip: (3, P, L, F - 1) [m].
        stands: (P, L, F).
        level, draw, lowest, placed: (P, L, F).
        place: (3, P, L, F) [m].
        rise: (L, F) [m] of the tips; infinite where they may be anywhere.
    """

    hold: Floats
    slip: Floats
    stands: Bools
    level: Floats
    draw: Floats
    lowest: Floats
    place: Floats
    placed: Floats
    rise: Floats

    @classmethod
    def none(cls, captured: Floats, belt: Floats) -> Stacked:
        """Make pins without constraints for points at (3, P, L, F) [m], on ground that moves (3,) [m] a frame."""
        one = captured.shape[1:]
        between = (*one[:-1], one[-1] - 1)
        slip = np.empty((3, *between))
        slip[...] = belt[:, None, None, None]
        return cls(
            np.zeros(between), slip, np.zeros(one, dtype=np.bool_), captured[1].copy(), np.zeros(one),
            np.full(one, -np.inf), np.zeros(captured.shape), np.zeros(one), np.full(one[1:], np.inf),
        )  # fmt: skip

    def apart(self, tips: Sequence[bool]) -> tuple[tuple[Pins, ...], ...]:
        """Split them by leg, where some legs have `tips`."""
        return tuple(
            tuple(
                Pins(
                    self.hold[p, k], self.slip[:, p, k], self.stands[p, k], self.level[p, k], self.draw[p, k],
                    self.lowest[p, k], self.place[:, p, k], self.placed[p, k],
                    rise=self.rise[k] if p == TIP else None,
                )
                for p in range(POINTS if tip else TIP)
            )
            for k, tip in enumerate(tips)
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Asked:
    """The input from which pins are made.

    Args:
        captured: (3, P, L, n) [m] the points.
        plan: (3, P, L, n) [m] the same as planned a moment before.
        window: (n,) numbers of the frames.
        ground: what plants stand on.
        belt: (3,) [m] that the ground of new plants moves in a frame.
        params: the tolerances.
    """

    captured: Floats
    plan: Floats
    window: Ints
    ground: Ground
    belt: Floats
    params: PinParams


def pins_of(feet: Sequence[FootPlants], legs: Legs, on: Bools, asked: Asked) -> Stacked:
    """Make the pins of all feet's points in a window.

    Args:
        feet: their plants as shown.
        legs: as captured, n frames.
        on: (n, 2 legs) when heel and toe of each are planted.
        asked: what pins are made of.
    """
    out, low = Stacked.none(asked.captured, asked.belt), np.full((POINTS, len(feet)), -np.inf)
    for k, foot in enumerate(feet):
        own = on[:, 2 * k : 2 * k + 2]
        when = [(mask, runs(mask)) for mask in masks(own)[:TIP]]
        when.append(when[TOE])
        step = _floor_step(foot, k, when, asked)
        for point in range(POINTS if legs.kinds.tips[k] else TIP):
            if point != ANKLE:
                low[point, k] = _lowest(k, point, bool(when[point][1]), step, asked.ground)
            if legs.kinds.turns[k]:  # the root must not move to serve a leg that can't turn
                out.stands[point, k] = when[point][0]
                for start, end in when[point][1]:
                    _hold(out, foot, k, point, start, end, asked)
                    if point == TIP and legs.kinds.bends[k]:
                        out.rise[k, start:end] = _rise(asked.captured[1, :, k, start:end], k, asked.ground)
    np.minimum(asked.captured[1], low[..., None], out=out.lowest)
    upright = slice(TIP, None) if asked.ground.heights else slice(None)
    out.slip[1, upright] = np.diff(asked.captured[1, upright], axis=-1)
    return out


def _floor_step(
    foot: FootPlants, k: int, when: Sequence[tuple[Bools, Sequence[tuple[int, int]]]], asked: Asked
) -> float:
    """Compute how much higher than the rig's the lower of the floors before and after a step is [m]."""
    steps, ground = [foot.step], asked.ground
    for point in (HEEL, TOE):
        for start, end in when[point][1]:
            steps.append(ground.step(ground.level(asked.captured[1, point, k, start:end], k, point), k, point))
    return min(steps)


def _hold(out: Stacked, foot: FootPlants, k: int, point: int, start: int, end: int, asked: Asked) -> None:
    """Hold a point while it is planted, in the frames [start, end) of the window."""
    window, ground, n = asked.window, asked.ground, len(asked.window)
    plant = _of_run(foot, TOE if point == TIP else point, int(window[start]))
    if plant is not None and plant.free:
        return
    begun = int(window[start]) if plant is None else plant.start
    weight = {TIP: asked.params.tip, ANKLE: asked.params.ankle}.get(point, 1.0)
    out.hold[point, k, start : end - 1] = weight * _ramp(window[start : end - 1] - begun, end < n, ground, asked.params)
    if point in (HEEL, TOE) and ground.heights:
        own = ground.level(asked.captured[1, point, k, start:end], k, point) if plant is None else plant.level
        out.level[point, k, start:end], out.draw[point, k, start:end] = own, _DRAWN
    if plant is not None:
        out.slip[:, point, k, start : end - 1] = plant.belt[:, None]
    if point == TIP:
        return
    if plant is not None and plant.place is not None:
        out.place[:, point, k, start:end] = plant.places(window[start:end], ground.frame_time)
        out.placed[point, k, start:end] = _FIRM[point]
        return
    landed = max(start, begun + 1 - int(window[0]))
    if end - landed >= _FEWEST:
        place = _planned(asked.plan[:, point, k, landed:end], asked.belt)
        if point != ANKLE and ground.heights:
            place[1] += _LED * (out.level[point, k, start] - place[1])
        out.place[:, point, k, landed:end] = place
        out.placed[point, k, landed:end] = _PLANNED * _FIRM[point]


def _planned(plan: Floats, belt: Floats) -> Floats:
    """Choose the place (3, n) [m] of a coming plant: the middle of its planned places (3, n) [m], at its height."""
    moved = belt[:, None] * np.arange(plan.shape[1])
    place = median(plan - moved)[:, None] + moved
    place[1] = plan[1]
    return place


def _of_run(foot: FootPlants, point: int, number: int) -> Plant | None:
    """Get the plant that was shown already and continues in frame `number`."""
    plant = foot.plants[point]
    return plant if plant is not None and plant.start <= number else None


def _ramp(since: Ints, ends: bool, ground: Ground, params: PinParams) -> Floats:
    """Compute weights (n,) of a plant's steps, lower where the foot lands, and where it leaves if that is known."""
    weights = np.where(since == 0, _FIRST_STEP, 1.0)
    if ends:
        soft = max(1, round(params.edge / ground.frame_time))
        left = np.arange(len(since))[::-1]
        weights = np.minimum(weights, ((left + 0.5) / soft) ** 2 + params.edge_weight)
    return weights


def _rise(captured: Floats, k: int, ground: Ground) -> Floats:
    """Compute how far (n,) [m] above its toe joint a tip may be, from the points' captured heights (P, n) [m]."""
    return np.asarray(np.maximum(captured[TIP] - captured[TOE], float(ground.tips[k] - ground.rest[k, TOE])))


def _lowest(k: int, point: int, stands: bool, step: float, ground: Ground) -> float:
    """Compute the least allowed height of a point [m]: the floor, unless it was captured lower."""
    usual = float(ground.tips[k]) if point == TIP else float(ground.rest[k, point])
    if point != TIP and stands:
        usual = max(usual, float(ground.nominal[k, point]))
    return usual + step - ground.sink

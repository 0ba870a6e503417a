"""The pins of a window: what its plants, those to come and those that were shown, ask of a foot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.enforce.leg import ANKLE, HEEL, POINTS, TIP, TOE, LegTracks
from footfix.enforce.pins import PinParams, Pins
from footfix.motion.clip import Bools, Floats, Ints
from footfix.motion.contacts import runs
from footfix.stream.held import Foot, Ground, Plant, masks

_FIRM = {HEEL: 0.3, TOE: 25.0, ANKLE: 0.3}  # how much the place of a plant that was shown counts
_LED = 0.5  # of the way to its level that a plant to come is led every time
_PLANNED = 0.6  # share of that for one to come
_FEWEST = 2  # frames of a plant to come, of which its place can be told
_FIRST_STEP = 0.3  # weight of the first step of a plant, in which a foot still lands
_DRAWN = 1.0 / 6.0  # how much the floor counts of a plant of 0.6 s; nobody knows yet how long one will be


def pins_of(
    foot: Foot, leg: LegTracks, k: int, plan: Sequence[Floats], on: Bools, window: Ints, ground: Ground, belt: Floats,
    params: PinParams,
) -> tuple[Pins, ...]:  # fmt: skip
    """Lay out what the points of a foot are to do in a window.

    Args:
        foot: what was shown of it.
        leg: as captured, n frames.
        k: which leg.
        plan: of its points, (3, n) [m] each, as planned a moment before.
        on: (n, 2) when heel and toe are planted.
        window: (n,) numbers of the frames.
        ground: what plants stand on.
        belt: (3,) [m] that the ground of new plants moves in a frame.
        params: the tolerances.
    """
    when = masks(on)
    step = _floor_step(foot, leg, k, on, ground)
    points = range(len(POINTS) if len(leg.points) > 2 else TIP)
    return tuple(
        _pins(foot, leg, k, point, plan[point], when[point], window, ground, belt, params, step) for point in points
    )


def _floor_step(foot: Foot, leg: LegTracks, k: int, on: Bools, ground: Ground) -> float:
    """[m] how much higher than the rig's the lower of the floors is on which a foot stood, or is about to stand."""
    steps = [foot.step]
    for point in (HEEL, TOE):
        for start, end in runs(on[:, point]):
            steps.append(ground.step(ground.level(leg.place(point)[1, start:end], k, point), k, point))
    return min(steps)


def _pins(
    foot: Foot, leg: LegTracks, k: int, point: int, plan: Floats, on: Bools, window: Ints, ground: Ground, belt: Floats,
    params: PinParams, step: float,
) -> Pins:  # fmt: skip
    n, track = len(on), leg.place(point)
    weight = {TIP: params.tip, ANKLE: params.ankle}.get(point, 1.0)
    hold, draw, placed = np.zeros(n - 1), np.zeros(n), np.zeros(n)
    level, place = track[1].copy(), np.zeros((3, n))
    slip = np.repeat(belt[:, None], n - 1, axis=1)
    for start, end in runs(on):
        plant = _of_run(foot, TOE if point == TIP else point, window[start])
        if plant is not None and plant.free:
            continue
        begun = window[start] if plant is None else plant.start
        hold[start : end - 1] = weight * _ramp(window[start : end - 1] - begun, end < n, ground, params)
        if point in (HEEL, TOE) and ground.heights:
            own = ground.level(track[1, start:end], k, point) if plant is None else plant.level
            level[start:end], draw[start:end] = own, _DRAWN
        if plant is not None:
            slip[:, start : end - 1] = plant.belt[:, None]
        if point != TIP and plant is not None and plant.place is not None:
            place[:, start:end] = plant.places(window[start:end], ground.frame_time)
            placed[start:end] = _FIRM[point]
        elif point != TIP:
            landed = max(start, begun + 1 - int(window[0]))
            if end - landed >= _FEWEST:
                place[:, landed:end] = _planned(plan[:, landed:end], belt)
                if point != ANKLE and ground.heights:
                    place[1, landed:end] += _LED * (level[start] - place[1, landed:end])
                placed[landed:end] = _PLANNED * _FIRM[point]
    if point == TIP or not ground.heights:
        slip[1] = np.diff(track[1])
    if not leg.turns:  # the root is not to follow a leg that can't
        hold[:] = draw[:] = placed[:] = 0.0
    return Pins(hold, slip, on, level, draw, _lowest(track[1], k, point, on, ground, step), place, placed)


def _planned(plan: Floats, belt: Floats) -> Floats:
    """(3, n) [m] where a point is to stand that was planned to be at (3, n) [m]: in their middle, at its height."""
    moved = belt[:, None] * np.arange(plan.shape[1])
    place = np.median(plan - moved, axis=1)[:, None] + moved
    place[1] = plan[1]
    return place


def _of_run(foot: Foot, point: int, number: int) -> Plant | None:
    """The plant that was shown already and goes on in frame `number`."""
    plant = foot.plants[point]
    return plant if plant is not None and plant.start <= number else None


def _ramp(since: Ints, ends: bool, ground: Ground, params: PinParams) -> Floats:
    """(n,) weights of a plant's steps, less where the foot lands, and where it leaves if that is known."""
    weights = np.where(since == 0, _FIRST_STEP, 1.0)
    if ends:
        soft = max(1, round(params.edge / ground.frame_time))
        left = np.arange(len(since))[::-1]
        weights = np.minimum(weights, ((left + 0.5) / soft) ** 2 + params.edge_weight)
    return weights


def _lowest(captured: Floats, k: int, point: int, on: Bools, ground: Ground, step: float) -> Floats:
    """(n,) [m] how low a point may be: not below the floor, if it was not captured there."""
    if point == ANKLE:
        return np.full(len(captured), -np.inf)
    usual = float(ground.tips[k]) if point == TIP else float(ground.rest[k, point])
    if point != TIP and on.any():
        usual = max(usual, float(ground.nominal[k, point]))
    return np.minimum(captured, usual + step - ground.sink)

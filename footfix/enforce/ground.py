"""The ground that plants stand on, where that is not simply the floor of the world.

A treadmill's belt carries planted feet along, and a clip that hovers or is sunk as a whole stands too high or too
low by the same amount everywhere. Both are taken out of the tracks before targets are set, so that all that
follows works on feet that stand on a floor at rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.foot import Foot
from footfix.enforce.plants import Stance, centre
from footfix.motion.clip import Floats
from footfix.motion.segments import middle


@dataclass(frozen=True, kw_only=True)
class GroundParams:
    """What makes a ground. Speeds in leg lengths a second."""

    belt: float = 0.15  # planted feet that all move at least this fast, in a figure that stays, are on a belt
    belt_spread: float = 0.3  # how far they may differ from each other, as a share of that speed
    lift: float = 0.005  # leg lengths that all plants must be off the floor for the whole figure to be moved
    agree: float = 0.8  # share of plants that must agree, within half of that


def carried(foot: Foot, offset: Floats) -> Foot:
    """The same leg, moved by `offset` (3,) or (F, 3) [m]."""
    return replace(
        foot, hip=foot.hip + offset, knee=foot.knee + offset, ankle=foot.ankle + offset,
        heel=foot.heel + offset, ball=foot.ball + offset,
    )  # fmt: skip


def belt(
    stands: Sequence[Stance], legs: Sequence[Foot], frame_time: float, leg_length: float, params: GroundParams
) -> Floats:
    """(3,) [m/s] with which planted feet move on purpose; zero on a floor at rest."""
    velocities, seconds = [], []
    for stance in stands:
        for plant in stance.plants:
            track = legs[stance.leg].point(plant.part)[plant.frames]
            if len(track) >= 3:
                times = (len(track) - 1) * frame_time
                velocities.append((track[-1] - track[0]) * [1.0, 0.0, 1.0] / times)
                seconds.append(times)
    if len(velocities) < 4:
        return np.zeros(3)
    v, weights = np.array(velocities), np.array(seconds)
    common = centre(v, weights)
    speed = float(np.linalg.norm(common))
    spread = _weighted_median(np.linalg.norm(v - common, axis=1), weights)
    hips = np.mean([foot.hip for foot in legs], axis=0)
    travel = float(np.linalg.norm((hips[-1] - hips[0])[[0, 2]])) / (len(hips) * frame_time)
    on_belt = speed > params.belt * leg_length and max(spread, travel) < params.belt_spread * speed
    return common if on_belt else np.zeros(3)


def lift(stands: Sequence[Stance], legs: Sequence[Foot], leg_length: float, params: GroundParams) -> float:
    """[m] by which the whole figure is to be raised: what all its plants lack to their floors, if they agree."""
    lacks = np.array([
        stance.level - middle(legs[stance.leg].point(plant.part)[plant.frames, 1])
        for stance in stands
        for plant in stance.plants
    ])  # fmt: skip
    if len(lacks) < 3:
        return 0.0
    common = float(np.median(lacks))
    agreeing = float(np.mean(np.abs(lacks - common) < 0.5 * abs(common)))
    return common if abs(common) > params.lift * leg_length and agreeing >= params.agree else 0.0


def _weighted_median(values: Floats, weights: Floats) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(total, 0.5 * total[-1])]])

"""Small changes of style: planted feet moved or turned on purpose, such as a pigeon-toed walk (G §6.3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from footfix.enforce.foot import Foot
from footfix.enforce.plants import Plant, Stance, centre
from footfix.motion import rotation
from footfix.motion.clip import Floats

_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, kw_only=True)
class StyleParams:
    """How planted feet stand otherwise than captured."""

    toe_out: Mapping[str, float] = field(default_factory=dict)  # leg name -> [degrees] outwards, about the heel
    offset: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    # sole point name -> outwards, up, forwards, as the foot stands [leg lengths]


def styled(stance: Stance, foot: Foot, names: Mapping[int, str], leg_length: float, params: StyleParams) -> Stance:
    """The stance with its targets moved.

    Args:
        stance: with its targets set.
        foot: the leg.
        names: names of the sole points by index.
        leg_length: [m].
        params: what is to be moved; nothing by default.
    """
    if not params.toe_out and not params.offset:
        return stance
    outwards = -1.0 if foot.leg.side == "right" else 1.0
    plants = []
    for plant in stance.plants:
        heel, forward = _stands(plant, stance, foot)
        turn = rotation.from_axis_angle(_UP, outwards * np.radians(params.toe_out.get(foot.leg.name, 0.0)))
        target = plant.target
        if plant.part == "toe":
            target = heel + rotation.rotate(turn, target - heel)
        forward = rotation.rotate(turn, forward)
        aside, up, ahead = (leg_length * each for each in params.offset.get(names[plant.effector], (0.0, 0.0, 0.0)))
        # up x forward points to the figure's left
        target = target + outwards * aside * np.cross(_UP, forward) + up * _UP + ahead * forward
        plants.append(replace(plant, target=target))
    return replace(stance, plants=tuple(plants))


def _stands(plant: Plant, stance: Stance, foot: Foot) -> tuple[Floats, Floats]:
    """Where the heel of a plant's foot stands (3,) [m], and where the foot points (3,), on the floor."""
    heels = stance.parts("heel")
    if heels:
        heel = max(heels, key=lambda other: min(plant.end, other.end) - max(plant.start, other.start)).target
    else:
        heel = centre(foot.heel[plant.frames])
        heel = heel * [1.0, 0.0, 1.0] + [0.0, plant.target[1], 0.0]
    along = (foot.ball - foot.heel)[plant.frames].sum(axis=0) * [1.0, 0.0, 1.0]
    return heel, along / max(float(np.linalg.norm(along)), 1e-300)

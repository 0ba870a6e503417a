"""Small changes of style: planted feet moved or turned on purpose, such as a pigeon-toed walk (G §6.3)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footfix.enforce.footplant import Footplant
from footfix.enforce.leg import HEEL, POINTS, TOE, LegTracks
from footfix.enforce.standing_heights import Floors
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.rig.rig import Rig

_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, kw_only=True)
class StyleParams:
    """Changes to how planted feet stand.

    Args:
        toe_out: leg name -> turn of the foot outwards about the heel [degrees].
        offset: sole point name -> shift outwards, up and forwards, seen from the foot [leg lengths].
    """

    toe_out: Mapping[str, float] = field(default_factory=dict)
    offset: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)


def styled(
    plants: Sequence[Footplant], legs: Sequence[LegTracks], rig: Rig, floors: Floors, params: StyleParams
) -> tuple[Footplant, ...]:
    """Request changed places of planted feet.

    Args:
        plants: of the clip.
        legs: as captured.
        rig: names, size and floor.
        floors: the heights that joints stand at.
        params: what is to be moved; nothing by default.
    """
    if not params.toe_out and not params.offset:
        return tuple(plants)
    # asked places are of the sole, which lies below its joint
    soles = [floors.plants[p.id] - (floors.rest[p.effector] - rig.floor) for p in plants]
    return tuple(_moved(p, legs[p.leg], rig, float(soles[p.id]), params) for p in plants)


def _moved(plant: Footplant, leg: LegTracks, rig: Rig, height: float, params: StyleParams) -> Footplant:
    angle = params.toe_out.get(leg.leg.name, 0.0)
    offset = params.offset.get(plant.name)
    if not angle and offset is None:
        return plant
    heel, ball, own = (
        np.median(leg.place(point)[:, plant.frames], axis=1) for point in (HEEL, TOE, POINTS.index(plant.part))
    )
    outwards = -1.0 if leg.leg.side == "right" else 1.0
    turn = rotation.about_vertical(outwards * np.radians(angle))
    place = heel + rotation.rotate(turn, own - heel) if plant.part == "toe" else own
    forward = rotation.rotate(turn, _level(ball - heel))
    aside, up, ahead = (rig.leg_length * each for each in offset or (0.0, 0.0, 0.0))
    # up x forward points to the figure's left
    place = place + outwards * aside * np.cross(_UP, forward) + ahead * forward
    x, _, z = place.tolist()
    return replace(plant, asked=(x, height + up, z))


def _level(vector: Floats) -> Floats:
    """Find the direction of a vector over the floor, (3,)."""
    level = vector * [1.0, 0.0, 1.0]
    return np.asarray(level / max(float(np.linalg.norm(level)), 1e-300))

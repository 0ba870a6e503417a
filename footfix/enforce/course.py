"""The course of a leg over the whole clip: what is asked of every one of its stances, found for all at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.foot import Foot
from footfix.enforce.plants import Plant, PlantParams, Stance
from footfix.motion.clip import Bools, Floats
from footfix.motion.segments import centres, segments
from footfix.motion.vectors import norm


@dataclass(frozen=True, eq=False)
class Course:
    """One leg over the whole clip.

    Args:
        foot: its tracks.
        flat: (F,) both ends of the foot are planted.
        heading: (F,) [rad] where the foot points on the floor, from heel to ball, continuous.
        line: (F, 3) [m] from hip to ankle.
        free: (F,) [m] how long that may be before the leg is stretched beyond the source.
        spots: for each plant, by effector and start, the middle (2,) [m] of where it was on the floor; of where it
            was while the foot was flat, if it ever was.
    """

    foot: Foot
    flat: Bools
    heading: Floats
    line: Floats
    free: Floats
    spots: Mapping[tuple[int, int], Floats]


def courses(stances: Sequence[Stance], feet: Sequence[Foot], params: PlantParams) -> tuple[Course, ...]:
    """The courses of all legs with these stances."""
    return tuple(
        _course([plant for stance in stances if stance.leg == k for plant in stance.plants], foot, params)
        for k, foot in enumerate(feet)
    )


def _course(plants: Sequence[Plant], foot: Foot, params: PlantParams) -> Course:
    on = {part: np.zeros(len(foot), dtype=np.bool_) for part in ("heel", "toe")}
    for plant in plants:
        on[plant.part][plant.frames] = True
    flat = on["heel"] & on["toe"]
    along, line = foot.ball - foot.heel, foot.ankle - foot.hip
    spots: dict[tuple[int, int], Floats] = {}
    for part in on:
        own = [plant for plant in plants if plant.part == part]
        if own:
            parts = segments([(plant.start, plant.end) for plant in own])
            on_sole = flat[parts.frames].astype(np.float64)
            share = np.where(parts.largest(on_sole)[parts.owner] > 0.0, on_sole, 1.0)
            middles = centres(foot.point(part)[parts.frames][:, [0, 2]], parts, share)
            spots.update({(plant.effector, plant.start): middles[n] for n, plant in enumerate(own)})
    return Course(
        foot=foot,
        flat=np.asarray(flat),
        heading=np.unwrap(np.arctan2(along[:, 0], along[:, 2])),
        line=line,
        free=np.maximum(norm(line), params.stretch * foot.length),
        spots=spots,
    )

"""The height of each joint of a planted foot: on the floor, or on a step of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.footplant import Footplant, stands
from footfix.enforce.leg import TIP, LegTracks
from footfix.motion.clip import Floats
from footfix.motion.contacts import runs
from footfix.motion.segments import segments
from footfix.rig.rig import Rig


@dataclass(frozen=True, eq=False)
class Floors:
    """Heights of the joints of planted feet.

    Args:
        rest: (E,) [m] usual height of the toe joint, or of the heel, at rest.
        tips: (legs,) [m] usual height of the toes' tip while the foot lies flat.
        plants: for each plant, by its id, the target height [m] of its joint.
    """

    rest: Floats
    tips: Floats
    plants: tuple[float, ...]


def floors(plants: Sequence[Footplant], legs: Sequence[LegTracks], rig: Rig, near: float) -> Floors:
    """Find the height at which each joint stands on its floor, from the heights at which it usually does.

    Args:
        plants: of the clip.
        legs: as captured.
        rig: its floor and soles.
        near: [m] a plant nearer than this to the floor stands on it, else on a step of its own.
    """
    rest = np.array([nominal(rig, e) for e in range(len(rig.soles))])
    own = _heights(plants, legs).tolist()
    for e in range(len(rest)):
        mine = [p for p in plants if p.effector == e and abs(own[p.id] - rest[e]) < near]
        if mine:
            rest[e] = np.median(np.concatenate([legs[p.leg].place(p.point)[1, p.frames] for p in mine]))
    on = stands(plants, len(legs[0].flexion), len(legs))
    tips = np.zeros(len(legs))
    for k, leg in enumerate(legs):
        flat = on[k, 0] & on[k, 1]
        if len(leg.points) > 2:
            frames = flat if np.any(flat) else on[k, 1] if np.any(on[k, 1]) else np.ones_like(flat)
            tips[k] = np.median(leg.place(TIP)[1, frames])
    heights = tuple(height(own[p.id], float(rest[p.effector]), nominal(rig, p.effector), near) for p in plants)
    return Floors(rest, tips, heights)


def height(own: float, rest: float, floor: float, near: float) -> float:
    """Choose the target height of a plant [m]: the usual one of its joint if it is near that, else its own, on a step.

    Where a joint is usually below the rig's floor, plants captured higher are not moved below the floor.
    """
    if abs(own - rest) >= near:
        return own
    return max(rest, min(own, floor))


def nominal(rig: Rig, effector: int) -> float:
    """Get the height [m] of what a plant holds, its sole on the rig's floor: a toe joint's own height above it."""
    return rig.floor + rig.held_height(rig.soles[effector])


def lacks(plants: Sequence[Footplant], legs: Sequence[LegTracks], rig: Rig) -> Floats:
    """Measure each plant's height error: wanted minus captured, (N,) [m]."""
    return np.array([nominal(rig, p.effector) for p in plants]) - _heights(plants, legs)


def _heights(plants: Sequence[Footplant], legs: Sequence[LegTracks]) -> Floats:
    """Measure the median height of each plant's joint, (N,) [m]."""
    found = np.zeros(len(plants))
    for e in {plant.effector for plant in plants}:
        own = [k for k, plant in enumerate(plants) if plant.effector == e]
        parts, first = segments([(plants[k].start, plants[k].end) for k in own]), plants[own[0]]
        found[own] = parts.median(legs[first.leg].place(first.point)[1, parts.frames])
    return found


def floor_steps(plants: Sequence[Footplant], floors: Floors, frames: int, near: float) -> Floats:
    """Compute the height of the floor under a foot over the rig's, (F,) [m]; between plants, the lower of the two."""
    step = np.zeros(frames)
    steps = [floors.plants[p.id] - floors.rest[p.effector] for p in plants]
    by_plant = sorted((p.start, p.end, up if abs(up) >= near else 0.0) for p, up in zip(plants, steps, strict=True))
    if not by_plant:
        return step
    known = np.full(frames, np.nan)
    for start, end, high in by_plant:
        known[start:end] = np.fmin(known[start:end], high)
    for start, end in runs(np.isnan(known)):
        sides = known[max(start - 1, 0)], known[min(end, frames - 1)]
        known[start:end] = np.fmin(*sides)
    return known

"""What the mesh of a foot asks of its pins: where a skin is given, no vertex of it goes below the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.footplant import Footplant
from footfix.enforce.papers.leg import effector_tracks
from footfix.enforce.pins import Floors, Pins
from footfix.motion.clip import Bools, Floats
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig

_SINK = 0.0012  # [leg lengths] how deep a vertex may be: 1 mm of a grown-up
_DEEP = 0.0025  # [leg lengths] a plant whose mesh is deeper does not stay as it is


def sunk(plants: Sequence[Footplant], rig: Rig, pose: Pose, lift: float, floors: Floors, near: float) -> Bools:
    """Tell (N,) the plants in which the mesh of the foot is too deep in the floor to be left there.

    Args:
        plants: of the clip.
        rig: its floor and meshes.
        pose: of the clip as captured.
        lift: [m] by which the figure is raised.
        floors: the heights at which joints stand.
        near: [m] a plant farther than this from the floor stands on a step of its own.
    """
    lowest = [low + lift for low in rig.lowest(pose)]
    out = np.zeros(len(plants), np.bool_)
    for plant in plants:
        step = floors.plants[plant.id] - floors.rest[plant.effector]
        level = rig.floor + (step if abs(step) >= near else 0.0)
        out[plant.id] = level - float(lowest[plant.effector][plant.frames].min()) > _DEEP * rig.leg_length
    return out


def over_floor(pins: tuple[Pins, ...], number: int, rig: Rig, pose: Pose, step: Floats) -> tuple[Pins, ...]:
    """Keep heel and toe of a leg so high that no vertex of their parts of the foot is below the floor.

    How far the lowest vertex is below the joint that is held depends on how the foot is turned; it is taken as captured.

    Args:
        pins: of the leg: heel, toe, and others.
        number: of the leg.
        rig: its floor and meshes.
        pose: of the clip as captured.
        step: (F,) [m] how much higher than the rig's floor that under the foot is.
    """
    held, lowest = effector_tracks(rig, pose), rig.lowest(pose)
    out = list(pins)
    for e, sole in enumerate(rig.soles):
        if sole.leg == number:
            at = 0 if sole.part == "heel" else 1
            least = rig.floor + step + held[e][:, 1] - lowest[e] - _SINK * rig.leg_length
            out[at] = replace(out[at], lowest=np.asarray(least), level=np.maximum(out[at].level, least))
    return tuple(out)

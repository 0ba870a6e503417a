"""What the mesh of a foot asks of its pins: where a skin is given, no vertex of it goes below the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.floors import Floors
from footfix.enforce.footplant import Footplant
from footfix.enforce.papers.leg import effector_tracks
from footfix.enforce.pins import Pins
from footfix.motion.clip import Bools, Floats
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig

_SINK = 0.0012  # [leg lengths] how deep a vertex may be: 1 mm of a grown-up
_LEFT = 0.001  # [leg lengths] deeper than that, up to which it is left
_DEEP = 0.0025  # [leg lengths] a plant whose mesh is deeper does not stay as it is

AllPins = tuple[tuple[Pins, ...], ...]


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


def over_floor(pins: Sequence[tuple[Pins, ...]], rig: Rig, pose: Pose, steps: Sequence[Floats]) -> AllPins:
    """Keep heel and toe of each leg so high that no vertex of their parts of the foot is below the floor.

    How far the lowest vertex is below the joint that is held depends on how the foot is turned: as captured.

    Args:
        pins: of each leg: heel, toe, and others.
        rig: its floor and meshes.
        pose: of the clip as captured.
        steps: of each leg (F,) [m] how much higher than the rig's floor that under the foot is.
    """
    held, lowest = effector_tracks(rig, pose), rig.lowest(pose)
    out = [list(own) for own in pins]
    for e, sole in enumerate(rig.soles):
        at, own = int(sole.part == "toe"), out[sole.leg]
        least = rig.floor + steps[sole.leg] + held[e][:, 1] - lowest[e] - _SINK * rig.leg_length
        own[at] = replace(own[at], lowest=least, level=np.maximum(own[at].level, least))
    return tuple(tuple(own) for own in out)


def raised(
    pins: Sequence[tuple[Pins, ...]], rig: Rig, pose: Pose, steps: Sequence[Floats]
) -> tuple[AllPins, float]:  # fmt: skip
    """Raise what heel and toe may be at least by what is still in the floor.

    Args:
        pins: of each leg: heel, toe, and others.
        rig: its floor and meshes.
        pose: of the clip as corrected.
        steps: of each leg (F,) [m] how much higher than the rig's floor that under the foot is.

    Returns:
        The pins, and [m] how much deeper a vertex is than it may be.
    """
    out, deepest = [list(own) for own in pins], 0.0
    for sole, low in zip(rig.soles, rig.lowest(pose), strict=True):
        at, own = int(sole.part == "toe"), out[sole.leg]
        deep = np.maximum(rig.floor + steps[sole.leg] - _SINK * rig.leg_length - low, 0.0)
        least = own[at].lowest + deep
        own[at] = replace(own[at], lowest=least, level=np.maximum(own[at].level, least))
        deepest = max(deepest, float(deep.max(initial=0.0)) - _LEFT * rig.leg_length)
    return tuple(tuple(own) for own in out), deepest

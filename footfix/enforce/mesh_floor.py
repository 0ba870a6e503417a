"""Adjust pins to the mesh of the foot, so that no vertex of a given skin goes below the floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.footplant import Footplant
from footfix.enforce.leg import LegTracks
from footfix.enforce.pins import Pins
from footfix.enforce.standing_heights import Floors
from footfix.enforce.vertices import Vertices, depths, vertices_of
from footfix.motion.clip import Bools, Floats, Skeleton
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig

_SINK = 0.0006  # [leg lengths] greatest depth of a vertex: half a millimetre for an adult
_LEFT = 0.001  # [leg lengths] a vertex up to this much deeper is not corrected
_ON_ZERO = 0.03  # [leg lengths] a floor within this distance of the file's zero plane is that plane
_ON_STEP = 0.03  # [leg lengths] by which a vertex in a step is raised at most
_AROUND = 0.2  # [s] before and after a vertex is in the floor, in which joints may turn to bring it out
_DEEP = 0.0025  # [leg lengths] a plant whose mesh is deeper than this is corrected

AllPins = tuple[tuple[Pins, ...], ...]


def sunk(plants: Sequence[Footplant], rig: Rig, pose: Pose, lift: float, floors: Floors, near: float) -> Bools:
    """Mark the plants (N,) in which the mesh of the foot is too deep in the floor to be left there.

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
    """Raise the target heights of heel and toe so that no vertex of their parts of the foot is below the floor.

    The distance from the held joint down to the lowest vertex depends on the foot's orientation, taken as captured.

    Args:
        pins: of each leg: heel, toe, and others.
        rig: its floor and meshes.
        pose: of the clip as captured.
        steps: of each leg (F,) [m] how much higher than the rig's floor that under the foot is.
    """
    held, lowest = rig.held(pose), rig.lowest(pose)
    out = [list(own) for own in pins]
    for e, sole in enumerate(rig.soles):
        at, own = int(sole.part == "toe"), out[sole.leg]
        least = rig.floor + steps[sole.leg] + held[e][:, 1] - lowest[e] - _SINK * rig.leg_length
        own[at] = replace(own[at], level=np.maximum(own[at].level, least))
    return tuple(tuple(own) for own in out)


def skins_of(
    rig: Rig, legs: Sequence[LegTracks], pose: Pose, lift: float, steps: Sequence[Floats], skeleton: Skeleton
) -> dict[int, Vertices]:
    """Choose the vertices that are kept over the floor, by leg.

    Args:
        rig: its floor and meshes.
        legs: as captured, raised by `lift`.
        pose: of the clip as captured.
        lift: [m] by which the figure is raised.
        steps: of each leg (F,) [m] how much higher than the rig's floor that under the foot is.
        skeleton: of the clip.
    """
    found = {}
    for mesh in rig.meshes:
        step = steps[mesh.leg]
        lowest = rig.floor + step - _SINK * rig.leg_length
        # A step is only where a foot once stood: what comes up to it or leaves it need not be over it.
        own = mesh.lowest(pose) + lift + _ON_STEP * rig.leg_length
        lowest = np.where(step > 0.0, np.maximum(np.minimum(lowest, own), rig.floor - _SINK * rig.leg_length), lowest)
        found[mesh.leg] = vertices_of(mesh, legs[mesh.leg], pose, lift, lowest, skeleton)
    return found


def steps_of(rig: Rig, steps: Sequence[Floats]) -> list[Floats]:
    """Leave out steps (F,) [m] below a file's zero plane: a mesh below it is in the floor, not on a lower one."""
    on_zero = abs(rig.floor) < _ON_ZERO * rig.leg_length
    return [np.maximum(each, 0.0) if on_zero else each for each in steps]


def too_deep(skins: Mapping[int, Vertices], legs: Sequence[LegTracks], leg_length: float) -> bool:
    """Tell whether a vertex is too deep in the floor, in any frame, to be left there."""
    return any(float(depths(own, legs[k]).max(initial=0.0)) > _LEFT * leg_length for k, own in skins.items())


def deeper(fault: Floats, skins: Mapping[int, Vertices], legs: Sequence[LegTracks], frame_time: float) -> Floats:
    """Raise faults (F,) [m] to the depth of vertices in the floor, so that joints may turn far enough to correct it.

    Args:
        fault: of the plants nearby.
        skins: by leg.
        legs: as captured.
        frame_time: [s].
    """
    if not skins:
        return fault
    from scipy.ndimage import maximum_filter1d

    around = 2 * max(1, round(_AROUND / frame_time)) + 1
    for k, own in skins.items():
        fault = np.maximum(fault, maximum_filter1d(depths(own, legs[k]), around, mode="nearest"))
    return fault

"""Targets: where each plant is to stand, C_p of G section 5.1."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.footplant import Footplant
from footfix.enforce.two_bone_ik import can_turn
from footfix.motion.clip import Clip, Floats
from footfix.motion.segments import geometric_medians, segments
from footfix.motion.vectors import norm, unit
from footfix.rig.rig import Rig

_FLAT = np.array([1.0, 0.0, 1.0])


@dataclass(frozen=True, kw_only=True)
class TargetParams:
    """Where plants stand.

    Args:
        near: a plant within this distance of the rig's floor stands on it, any other on its own level [leg lengths].
    """

    near: float = 0.067


def legs_to_hold(clip: Clip, rig: Rig, plants: Sequence[Footplant]) -> Iterator[tuple[int, list[int]]]:
    """List the legs that stand and that the file can turn, by their numbers, each with the numbers of its plants."""
    for number, leg in enumerate(rig.legs):
        own = [k for k, plant in enumerate(plants) if plant.leg == number]
        if own and can_turn(clip, leg):
            yield number, own


def near_floor(rig: Rig, soles: Sequence[Floats], plants: Sequence[Footplant], params: TargetParams) -> list[bool]:
    """Say of each plant whether it stands on the floor of the rig, by the tracks (F, 3) [m] of the sole points."""
    return [
        abs(float(np.median(soles[plant.effector][plant.frames, 1])) - rig.floor) <= params.near * rig.leg_length
        for plant in plants
    ]


def targets(
    rig: Rig,
    soles: Sequence[Floats],
    tracks: Sequence[Floats],
    plants: Sequence[Footplant],
    ground: Floats,
    params: TargetParams,
) -> list[Floats]:
    """Place every plant: its own place over its contact, on the floor, or where it is asked for.

    Each effector has one height on the floor, the median of its plants there; a plant off the floor (on stairs) keeps
    its own. Heel and toe must be a foot's length apart, but places found one by one are not if the foot slides: of two
    that overlap in time the later one is placed relative to the earlier one; where they begin together, the toe
    relative to the heel.

    Args:
        rig: its legs, soles and floor.
        soles: for each sole point its track (F, 3) [m].
        tracks: for each its effector's, from `Rig.held`.
        plants: the plants.
        ground: (F, 3) [m] displacement of the ground under planted feet; zeros on a floor at rest.
        params: which plants stand on the rig's floor.

    Returns:
        For each plant the place (3,) [m] of its effector where the ground is undisplaced.
    """
    on_floor = near_floor(rig, [sole - ground for sole in soles], plants, params)
    own = [usual_place((tracks[p.effector] - ground)[p.frames]) for p in plants]
    for e in range(len(rig.soles)):
        level = [k for k, plant in enumerate(plants) if plant.effector == e and on_floor[k]]
        height = np.median([own[k][1] for k in level]) if level else 0.0
        for k in level:
            own[k][1] = height
    for k, plant in enumerate(plants):
        if plant.asked is not None:  # labels give a place of the sole; the joint is above it
            moved = ground[(plant.start + plant.end) // 2]
            sole = np.median((soles[plant.effector] - ground)[plant.frames, 1])
            up = own[k][1] - (rig.floor if on_floor[k] else sole)
            own[k] = np.array(plant.asked) - moved + [0.0, up, 0.0]
    return _a_foot_apart(tracks, plants, own)


def usual_place(places: Floats) -> Floats:
    """Find the median (3,) [m] of places (N, 3) [m]: over the floor that of the plane, whichever way its axes lie."""
    x, z = geometric_medians(places[:, [0, 2]], segments([(0, len(places))]))[0]
    return np.array([x, np.median(places[:, 1]), z])


def _a_foot_apart(tracks: Sequence[Floats], plants: Sequence[Footplant], places: Sequence[Floats]) -> list[Floats]:
    """Move the places (3,) [m] of plants of one foot that overlap to the distance that its effectors have."""
    placed: dict[int, Floats] = {}
    order = sorted(range(len(plants)), key=lambda k: (plants[k].asked is None, plants[k].start, plants[k].part))
    for k in order:
        plant, placed[k] = plants[k], places[k]
        beside = [j for j in placed if j != k and _overlap(plants[j], plant)]
        if plant.asked is not None or not beside:
            continue
        other, at = plants[beside[0]], placed[beside[0]]
        both = slice(max(plant.start, other.start), min(plant.end, other.end))
        apart = (tracks[plant.effector] - tracks[other.effector])[both]
        up = places[k][1] - at[1]
        flat = np.sqrt(max(float(np.median(norm(apart))) ** 2 - up * up, 0.0))
        placed[k] = at + flat * unit(apart.mean(axis=0) * _FLAT) + [0.0, up, 0.0]
    return [placed[k] for k in range(len(plants))]


def _overlap(one: Footplant, other: Footplant) -> bool:
    same_foot = one.leg == other.leg and one.part != other.part
    return same_foot and max(one.start, other.start) < min(one.end, other.end)

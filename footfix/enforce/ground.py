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
from footfix.enforce.plants import Stance, agreement, centre
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.motion.segments import middle
from footfix.motion.vectors import norm

_MOST = 0.7  # of their time plants must go with the belt,
_OUTLIERS = 2  # and no more one after the other may not


@dataclass(frozen=True, kw_only=True)
class GroundParams:
    """What makes a ground. Speeds in leg lengths a second."""

    belt: float = 0.15  # planted feet that all move at least this fast, in a figure that stays, are on a belt
    belt_spread: float = 0.3  # how far they may differ from each other, as a share of that speed
    belt_plants: int = 8  # one after the other that make a belt, where the figure is not on it all the time,
    belt_walk: float = 0.5  # and that they move at least as fast
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
    """(F, 3) [m/s] with which planted feet move on purpose; zero on a floor at rest.

    It is one velocity for as long as the figure is on the belt, which it may get on and off.
    """
    frames = len(legs[0])
    rides = sorted(_rides(stands, legs, frame_time), key=lambda ride: ride.start + ride.end)
    velocity = np.zeros((frames, 3))
    if len(rides) < 4:
        return velocity
    hips = np.mean([foot.hip for foot in legs], axis=0)
    travel = (hips[-1] - hips[0]) / (frames * frame_time)
    if _go_along(rides, travel, params.belt * leg_length, params) is not None:
        return velocity + _centre(rides)
    if len(rides) < params.belt_plants:
        return velocity
    on_belt = np.zeros(len(rides), dtype=np.bool_)
    slow = (1.0 - params.belt_spread) * params.belt_walk * leg_length
    quick = norm(np.array([ride.velocity for ride in rides])) > slow
    many = np.convolve(quick, np.ones(params.belt_plants), mode="valid") >= _MOST * params.belt_plants
    for k in np.flatnonzero(many).tolist():
        some = rides[k : k + params.belt_plants]
        start, end = min(ride.start for ride in some), max(ride.end for ride in some)
        travel = (hips[end - 1] - hips[start]) / ((end - start) * frame_time)
        along = _go_along(some, travel, params.belt_walk * leg_length, params)
        if along is not None and len({ride.leg for ride in some}) > 1:
            on_belt[k : k + params.belt_plants] |= along
    for first, last in runs(_without_gaps(on_belt, _OUTLIERS)):
        some = rides[first:last]
        velocity[min(ride.start for ride in some) : max(ride.end for ride in some)] = _centre(some)
    return velocity


def _without_gaps(mask: Bools, longest: int) -> Bools:
    """(N,) the mask, True in its inner gaps that are no longer than that, too."""
    out = mask.copy()
    for start, end in runs(~mask):
        if start > 0 and end < len(mask) and end - start <= longest:
            out[start:end] = True
    return out


@dataclass(frozen=True)
class _Ride:
    """How a plant of a leg moves over the floor: its frames `[start, end)`, velocity (3,) [m/s] and time [s]."""

    leg: int
    start: int
    end: int
    velocity: Floats
    seconds: float


def _rides(stands: Sequence[Stance], legs: Sequence[Foot], frame_time: float) -> list[_Ride]:
    rides = []
    for stance in stands:
        for plant in stance.plants:
            track = legs[stance.leg].point(plant.part)[plant.frames]
            if len(track) >= 3:
                seconds = (len(track) - 1) * frame_time
                velocity = (track[-1] - track[0]) * [1.0, 0.0, 1.0] / seconds
                rides.append(_Ride(stance.leg, plant.start, plant.end, velocity, seconds))
    return rides


def _centre(rides: Sequence[_Ride]) -> Floats:
    return centre(np.array([ride.velocity for ride in rides]), np.array([ride.seconds for ride in rides]))


def _go_along(rides: Sequence[_Ride], travel: Floats, least: float, params: GroundParams) -> Bools | None:
    """(N,) which of these plants go along with what is their common velocity, `least` [m/s] or more.

    None where not most of them do, or the hips, which go on by `travel` (3,) [m/s], don't stay.
    """
    common = _centre(rides)
    speed = float(np.linalg.norm(common))
    near = np.array([float(np.linalg.norm(ride.velocity - common)) < params.belt_spread * speed for ride in rides])
    most = float(np.average(near, weights=[ride.seconds for ride in rides])) >= _MOST
    stays = float(np.hypot(travel[0], travel[2])) < params.belt_spread * speed
    return near if stays and most and speed > least else None


def lift(stands: Sequence[Stance], legs: Sequence[Foot], leg_length: float, params: GroundParams) -> float:
    """[m] by which the whole figure is to be raised: what all its plants lack to their floors, if they agree."""
    lacks = np.array([
        stance.level - middle(legs[stance.leg].point(plant.part)[plant.frames, 1])
        for stance in stands
        for plant in stance.plants
    ])  # fmt: skip
    if len(lacks) < 3:
        return 0.0
    common, agreeing = agreement(lacks)
    return common if abs(common) > params.lift * leg_length and agreeing >= params.agree else 0.0

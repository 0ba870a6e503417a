"""The ground that plants stand on: a treadmill's belt, or the floor under a figure that floats or is sunk.

A belt carries planted feet along; the plants of a clip that floats or is sunk are all too high or too low by the same
amount.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import Contacts, runs
from footfix.motion.kinematics import Pose
from footfix.motion.segments import geometric_medians, segments
from footfix.motion.vectors import norm
from footfix.notes import Note
from footfix.rig.gait_in_place import Gait, gait_in_place
from footfix.rig.rig import Rig

_MOST = 0.7  # [share] plants must move with the belt for this share of their time,
OUTLIERS = 2  # and at most this many in a row may not
_ON_FLOOR = 0.05  # [share] of plants that stand on the floor, from which the figure is not raised or lowered
_NEAR_GAIT = 0.6  # greatest deviation of planted feet from the ground's velocity in a gait in place, as a share of it


@dataclass(frozen=True, kw_only=True)
class GroundParams:
    """When the ground is a moving belt, and when the whole figure is raised or lowered.

    Args:
        belt: planted feet of a figure in place that all move at least this fast are on a belt [leg lengths/s].
        belt_spread: greatest deviation of their velocity, as a share of the belt's speed [share].
        belt_plants: least number of such plants in a row, where the figure is on the belt for part of the clip [count].
        belt_walk: least speed of these plants [leg lengths/s].
        lift: the whole figure is raised or lowered if its plants are off the floor by at least this [leg lengths].
        agree: share of the plants that must agree within half of that [share].
        step: but not if some plants stand nearer than this to the floor, and would be farther from it than this
            [leg lengths].
    """

    belt: float = 0.15
    belt_spread: float = 0.3
    belt_plants: int = 8
    belt_walk: float = 0.5
    lift: float = 0.0055
    agree: float = 0.8
    step: float = 0.067


@dataclass(frozen=True)
class Drift:
    """How a plant of a leg moves over the floor: frames `[start, end)`, velocity (3,) and steps [m/s], time [s]."""

    leg: int
    start: int
    end: int
    velocity: Floats
    steps: Floats
    seconds: float

    @classmethod
    def of(cls, leg: int, start: int, track: Floats, frame_time: float) -> Drift:
        """Measure the drift of a plant of a leg whose point was at (n, 3) [m] from a frame on."""
        seconds = (len(track) - 1) * frame_time
        velocity = (track[-1] - track[0]) * [1.0, 0.0, 1.0] / seconds
        return cls(leg, start, start + len(track), velocity, np.diff(track, axis=0) / frame_time, seconds)


def belt(rig: Rig, pose: Pose, contacts: Contacts, frame_time: float, params: GroundParams) -> Floats:
    """Find the motion of a treadmill's belt under planted feet.

    It has one velocity for as long as the figure is on the belt, which it may get on and off.

    Args:
        rig: its soles and hips.
        pose: F frames of `rig.joints()`.
        contacts: when each sole point is planted.
        frame_time: [s].
        params: when the ground is a belt.

    Returns:
        (F, 3) [m], zeros on a floor at rest.
    """
    drifts = sorted(_drifts(rig, pose, contacts, frame_time), key=lambda drift: drift.start + drift.end)
    gait = gait_in_place(rig, pose, frame_time)
    if gait is None:
        velocity = _velocity(drifts, rig, pose, frame_time, params)  # (F, 3) [m/s]
    else:
        velocity = np.tile(_of_gait(drifts, gait), (len(pose.positions), 1))
    return np.concatenate([np.zeros((1, 3)), np.cumsum(velocity[:-1] * frame_time, axis=0)])


def _of_gait(drifts: Sequence[Drift], gait: Gait) -> Floats:
    """Find the ground's velocity under a gait in place (3,) [m/s]: that of most planted feet that move with it."""
    speed = float(np.linalg.norm(gait.velocity))
    along = np.array([float(np.linalg.norm(each.velocity - gait.velocity)) < _NEAR_GAIT * speed for each in drifts])
    return usual_step(drifts, along) if along.any() else gait.velocity


def _velocity(drifts: Sequence[Drift], rig: Rig, pose: Pose, frame_time: float, params: GroundParams) -> Floats:
    hips = np.mean([pose.position(leg.hip) for leg in rig.legs], axis=0)
    frames, legs = len(hips), len(rig.legs)
    velocity = np.zeros((frames, 3))
    if len(drifts) < 4:
        return velocity
    travel = (hips[-1] - hips[0]) / (frames * frame_time)
    along = go_along(drifts, travel, params.belt * rig.leg_length, params)
    if along is not None:
        return velocity + usual_step(drifts, along)
    if len(drifts) < params.belt_plants:
        return velocity
    on_belt = np.zeros(len(drifts), dtype=np.bool_)
    slow = (1.0 - params.belt_spread) * params.belt_walk * rig.leg_length
    quick = norm(np.array([drift.velocity for drift in drifts])) > slow
    many = np.convolve(quick, np.ones(params.belt_plants), mode="valid") >= _MOST * params.belt_plants
    for k in np.flatnonzero(many).tolist():
        some = drifts[k : k + params.belt_plants]
        start, end = min(drift.start for drift in some), max(drift.end for drift in some)
        travel = (hips[end - 1] - hips[start]) / ((end - start) * frame_time)
        along = go_along(some, travel, params.belt_walk * rig.leg_length, params)
        if along is not None and len({d.leg for d, goes in zip(some, along.tolist(), strict=True) if goes}) == legs:
            on_belt[k : k + params.belt_plants] |= along
    for first, last in runs(_without_gaps(on_belt, OUTLIERS)):
        some = drifts[first:last]
        along = np.ones(len(some), dtype=np.bool_)
        velocity[min(drift.start for drift in some) : max(drift.end for drift in some)] = usual_step(some, along)
    return velocity


def usual_step(drifts: Sequence[Drift], along: Bools) -> Floats:
    """Find the velocity of most plants on the belt (3,) [m/s]; in a cleaned clip, exactly the speed of its belt."""
    steps = np.concatenate([drift.steps for drift, goes in zip(drifts, along.tolist(), strict=True) if goes])
    return np.asarray(np.median(steps, axis=0) * [1.0, 0.0, 1.0])


def _without_gaps(mask: Bools, longest: int) -> Bools:
    """Fill the inner gaps of a mask (N,) that are no longer than that."""
    out = mask.copy()
    for start, end in runs(~mask):
        if start > 0 and end < len(mask) and end - start <= longest:
            out[start:end] = True
    return out


def _drifts(rig: Rig, pose: Pose, contacts: Contacts, frame_time: float) -> list[Drift]:
    drifts = []
    for sole, effector in zip(rig.soles, contacts.effectors, strict=True):
        track = pose.point(sole.joint, np.array(sole.offset))
        for c in effector.contacts:
            if c.wish != "forbid" and c.end - c.start >= 3:
                drifts.append(Drift.of(sole.leg, c.start, track[c.start : c.end], frame_time))
    return drifts


def _centre(drifts: Sequence[Drift]) -> Floats:
    points, weights = np.array([drift.velocity for drift in drifts]), np.array([drift.seconds for drift in drifts])
    return np.asarray(geometric_medians(points, segments([(0, len(points))]), weights)[0])


def go_along(drifts: Sequence[Drift], travel: Floats, least: float, params: GroundParams) -> Bools | None:
    """Mark the plants (N,) that move with their common velocity, `least` [m/s] or more.

    None where fewer than most of them do, or where the hips, with velocity `travel` (3,) [m/s], don't stay in place.
    """
    common = _centre(drifts)
    speed = float(np.linalg.norm(common))
    near = np.array([float(np.linalg.norm(drift.velocity - common)) < params.belt_spread * speed for drift in drifts])
    most = float(np.average(near, weights=[drift.seconds for drift in drifts])) >= _MOST
    stays = float(np.hypot(travel[0], travel[2])) < params.belt_spread * speed
    return near if stays and most and speed > least else None


def belt_notes(ground: Floats, frame_time: float) -> tuple[Note, ...]:
    """Make a note that the ground (F, 3) [m] moves, and how fast."""
    step = np.linalg.norm(np.diff(ground, axis=0), axis=1)
    moves = step > 0.0
    if not np.any(moves):
        return ()
    speed = float(np.median(step[moves])) / frame_time
    where = "" if moves.all() else f" for {np.count_nonzero(moves) * frame_time:.1f} s"
    text = f"the figure stays in place{where}: planted feet are taken along at {speed:.2f} m/s, as on a belt"
    return (Note("in-place", text),)


def lift(lacks: Floats, leg_length: float, params: GroundParams) -> float:
    """Find by how much to raise the whole figure: the common height error of its plants, if they agree.

    Args:
        lacks: (N,) [m] height error of each plant.
        leg_length: [m].
        params: how many must agree.

    Returns:
        [m], negative where it is to be lowered.
    """
    if len(lacks) < 3:
        return 0.0
    common, near = float(np.median(lacks)), params.step * leg_length
    agreeing = float(np.mean(np.abs(lacks - common) < 0.5 * abs(common)))
    on_floor = (np.abs(lacks) < near) & (np.abs(lacks - common) >= near)
    if float(np.mean(on_floor)) > _ON_FLOOR:  # the others stand on something: a belt that is higher than the floor
        return 0.0
    return common if abs(common) > params.lift * leg_length and agreeing >= params.agree else 0.0

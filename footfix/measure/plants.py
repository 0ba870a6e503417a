"""Measures of single plants: how far a planted sole point slides, turns, sinks and floats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose
from footfix.motion.segments import Segments, segments
from footfix.rig.rig import Rig

# A slide that viewers notice: M. Prazak, L. Hoyet, C. O'Sullivan, Perceptual evaluation of footskate
# cleanup, SCA 2011.
NOTICED_MM = 21.0

AT_REST = np.zeros(3)  # [m/s] of a floor that does not move


@dataclass(frozen=True)
class PlantMeasure:
    """What one planted sole point does while it should stand still.

    Args:
        effector: name of the sole point.
        start, end: frames `[start, end)`.
        slide_mm: farthest horizontal distance from its median place.
        yaw_deg: farthest turn of the foot about the vertical from its median heading.
        penetration_mm: deepest below its floor, 0 if never.
        float_mm: highest above its floor, 0 if never.
        speed_cm_s: mean horizontal speed.
        peak_speed_cm_s: highest horizontal speed between two frames.
    """

    effector: str
    start: int
    end: int
    slide_mm: float
    yaw_deg: float
    penetration_mm: float
    float_mm: float
    speed_cm_s: float
    peak_speed_cm_s: float


def slide(track: Floats, plants: Segments) -> Floats:
    """(S,) [m] farthest horizontal distance of a track (F, 3) [m] from its median place in each plant."""
    x, z = track[plants.frames, 0], track[plants.frames, 2]
    away = np.hypot(x - plants.median(x)[plants.owner], z - plants.median(z)[plants.owner])
    return plants.largest(away)


def yaw(turns: Floats, plants: Segments) -> Floats:
    """(S,) [rad] farthest turn of rotations (F, 4) about the vertical from their median heading in each plant.

    Each frame is held against the plant's middle one, in the world; of that turn, the twist about the
    vertical counts, so a foot that only rolls from heel to toe does not turn.
    """
    planted = turns[plants.frames]
    middle = planted[plants.middle()][plants.owner]
    q = rotation.multiply(planted, rotation.inverse(middle))
    twist = 2.0 * np.arctan2(q[:, 1], q[:, 3])
    twist = twist - 2.0 * np.pi * np.round(twist / (2.0 * np.pi))
    return plants.largest(np.abs(twist - plants.median(twist)[plants.owner]))


def speeds(track: Floats, plants: Segments, frame_time: float) -> tuple[Floats, Floats]:
    """(S,), (S,) [m/s] mean and highest horizontal speed of a track (F, 3) [m] from frame to frame in each plant."""
    steps = np.zeros(len(plants.frames))
    steps[1:] = np.hypot(*np.diff(track[plants.frames][:, [0, 2]], axis=0).T) / frame_time
    steps[plants.starts] = 0.0  # the step into a plant is none of its own
    mean = plants.mean(steps) * plants.lengths / np.maximum(plants.lengths - 1, 1)
    return mean, plants.largest(steps)


def measure_plants(
    clip: Clip, rig: Rig, contacts: Contacts, pose: Pose, levels: Sequence[Floats], belt: Floats = AT_REST
) -> tuple[PlantMeasure, ...]:
    """The measures of every contact.

    Args:
        clip: the motion.
        rig: its sole points.
        contacts: which of them are planted when.
        pose: forward kinematics of `rig.joints()`.
        levels: for each effector (contacts,) [m] the height of the floor under each of its contacts.
        belt: (3,) [m/s] with which the floor itself moves, as under an in-place cycle, or (F, 3) [m] how far it has.

    Returns:
        One measure a contact, effector by effector, in order of time.
    """
    found: list[PlantMeasure] = []
    belt = np.asarray(belt)
    carried = belt if belt.ndim == 2 else np.arange(len(clip))[:, None] * clip.frame_time * belt  # (F, 3) [m]
    for sole, effector, heights in zip(rig.soles, contacts.effectors, levels, strict=True):
        counted = np.array([contact.wish != "forbid" for contact in effector.contacts], dtype=np.bool_)
        if not np.any(counted):
            continue
        plants = segments([(c.start, c.end) for c in effector.contacts if c.wish != "forbid"])
        track = pose.point(sole.joint, np.asarray(sole.offset)) - carried  # (F, 3) [m] over the floor
        mean_speed, peak_speed = speeds(track, plants, clip.frame_time)
        above = track[plants.frames, 1] - heights[counted][plants.owner]  # (N,) [m]
        columns = (
            1000.0 * slide(track, plants),
            np.degrees(yaw(pose.rotation(sole.joint), plants)),
            1000.0 * np.maximum(plants.largest(-above), 0.0),
            1000.0 * np.maximum(plants.largest(above), 0.0),
            100.0 * mean_speed,
            100.0 * peak_speed,
        )
        rows = np.stack(columns, axis=1).tolist()
        found.extend(
            PlantMeasure(effector.name, start, end, *row) for (start, end), row in zip(plants.spans, rows, strict=True)
        )
    return tuple(found)


def floor_levels(rig: Rig, contacts: Contacts, pose: Pose) -> tuple[Floats, ...]:
    """The height of the floor under each contact, for each effector (contacts,) [m].

    A plant whose median height is within a twentieth of the leg length of the rig's floor stands on that
    floor; another one (a stair, a box) stands on its own level.
    """
    levels = []
    for sole, effector in zip(rig.soles, contacts.effectors, strict=True):
        height = pose.point(sole.joint, np.asarray(sole.offset))[:, 1]
        plants = segments([(c.start, c.end) for c in effector.contacts])
        own = plants.median(height[plants.frames])
        levels.append(np.where(np.abs(own - rig.floor) < 0.05 * rig.leg_length, rig.floor, own))
    return tuple(levels)

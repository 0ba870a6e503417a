"""Measures of single plants: how far a planted sole point slides, turns, sinks and floats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig

# A slide that viewers notice: M. Prazak, L. Hoyet, C. O'Sullivan, Perceptual evaluation of footskate
# cleanup, SCA 2011.
NOTICED_MM = 21.0


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


def slide(track: Floats) -> float:
    """Farthest horizontal distance [m] of a track (n, 3) [m] from its median place."""
    places = track[:, [0, 2]]
    return float(np.max(np.linalg.norm(places - np.median(places, axis=0), axis=1)))


def yaw(turns: Floats) -> float:
    """Farthest turn [rad] about the vertical of rotations (n, 4) from their median heading.

    The heading is the twist of the rotation about the vertical axis, so a foot that only rolls from heel
    to toe does not turn.
    """
    # Each frame against the middle one, in the world; of that turn, the twist about the vertical.
    q = rotation.multiply(turns, rotation.inverse(turns[len(turns) // 2]))
    twist = np.unwrap(2.0 * np.arctan2(q[:, 1], q[:, 3]))
    return float(np.max(np.abs(twist - np.median(twist))))


def measure_plants(
    clip: Clip, rig: Rig, contacts: Contacts, pose: Pose, levels: Sequence[Floats]
) -> tuple[PlantMeasure, ...]:
    """The measures of every contact.

    Args:
        clip: the motion.
        rig: its sole points.
        contacts: which of them are planted when.
        pose: forward kinematics of `rig.joints()`.
        levels: for each effector (contacts,) [m] the height of the floor under each of its contacts.

    Returns:
        One measure a contact, effector by effector, in order of time.
    """
    found = []
    for sole, effector, heights in zip(rig.soles, contacts.effectors, levels, strict=True):
        track = pose.point(sole.joint, np.asarray(sole.offset))  # (F, 3) [m]
        turns = pose.rotation(sole.joint)
        for contact, level in zip(effector.contacts, heights, strict=True):
            if contact.wish == "forbid":
                continue
            span = slice(contact.start, contact.end)
            planted = track[span]
            steps = np.linalg.norm(np.diff(planted[:, [0, 2]], axis=0), axis=1) / clip.frame_time  # [m/s]
            above = planted[:, 1] - level
            found.append(
                PlantMeasure(
                    effector.name,
                    contact.start,
                    contact.end,
                    slide_mm=1000.0 * slide(planted),
                    yaw_deg=float(np.degrees(yaw(turns[span]))),
                    penetration_mm=1000.0 * max(0.0, -float(above.min())),
                    float_mm=1000.0 * max(0.0, float(above.max())),
                    speed_cm_s=100.0 * float(steps.mean()) if len(steps) else 0.0,
                    peak_speed_cm_s=100.0 * float(steps.max()) if len(steps) else 0.0,
                )
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
        own = np.array([np.median(height[c.start : c.end]) for c in effector.contacts])
        levels.append(np.where(np.abs(own - rig.floor) < 0.05 * rig.leg_length, rig.floor, own))
    return tuple(levels)

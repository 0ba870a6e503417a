"""Measures of single plants: how far a planted foot slides, turns, sinks and floats."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from footfix.measure.skinned_joints import Seen, seen_of
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose
from footfix.motion.segments import Segments
from footfix.rig.rig import Rig

# A slide that viewers notice: M. Prazak, L. Hoyet, C. O'Sullivan, Perceptual evaluation of footskate
# cleanup, SCA 2011.
NOTICED_MM = 21.0

_NEAR = 0.05  # leg lengths: a plant whose median height is no farther from the rig's floor stands on that floor


@dataclass(frozen=True)
class PlantMeasure:
    """How a planted foot moves while it should stand still.

    All is measured relative to the ground, over the whole contact but its first and last frame, in which the foot still
    lands or lifts (contacts of less than 5 frames are measured whole).

    Args:
        effector: name of the sole point.
        start, end: frames `[start, end)` of the contact.
        slide_mm: farthest horizontal distance of the visible point from its median place: of a toe plant the toe joint
            (the place where it would be on a foot that has none), of a heel plant the ankle while heel and toe are
            planted (the heel's sole point where they never are).
        tip_slide_mm: the same of the tip of the toes, for toe plants; None where the foot has no tip.
        sole_slide_mm: the same of the sole point.
        travel_mm: horizontal distance of the visible point from its first place to its last.
        yaw_deg: farthest turn of the foot about the vertical from its median heading.
        penetration_mm: deepest that the sole point is below the floor under the plant, 0 if never; with a skin, the
            deepest vertex of the foot.
        float_mm: highest that the sole point is above it, 0 if never; with a skin, the lowest vertex of its part.
        speed_cm_s: mean horizontal speed of the visible point.
        peak_speed_cm_s: its highest horizontal speed between two frames.
    """

    effector: str
    start: int
    end: int
    slide_mm: float
    tip_slide_mm: float | None
    sole_slide_mm: float
    travel_mm: float
    yaw_deg: float
    penetration_mm: float
    float_mm: float
    speed_cm_s: float
    peak_speed_cm_s: float


def slide(track: Floats, plants: Segments) -> Floats:
    """Measure how far a track (F, 3) [m] gets from its median place over the floor in each plant, (S,) [m]."""
    x, z = track[plants.frames, 0], track[plants.frames, 2]
    away = np.hypot(x - plants.median(x)[plants.owner], z - plants.median(z)[plants.owner])
    return plants.largest(away)


def yaw(turns: Floats, plants: Segments) -> Floats:
    """Measure the farthest turn of rotations (F, 4) about the vertical from their median in each plant, (S,) [rad].

    Each frame is compared with the plant's middle one, in the world; of that rotation only the twist about the vertical
    counts, so that a foot that rolls from heel to toe does not turn.
    """
    planted = turns[plants.frames]
    middle = planted[plants.middle()][plants.owner]
    q = rotation.multiply(planted, rotation.inverse(middle))
    twist = 2.0 * np.arctan2(q[:, 1], q[:, 3])
    twist = twist - 2.0 * np.pi * np.round(twist / (2.0 * np.pi))
    return plants.largest(np.abs(twist - plants.median(twist)[plants.owner]))


def travel(track: Floats, plants: Segments) -> Floats:
    """Measure the horizontal distance of a track (F, 3) [m] from its first place to its last in each plant, (S,) [m].
    """
    first, last = (track[plants.frames[at]] for at in (plants.starts, plants.starts + plants.lengths - 1))
    return np.asarray(np.hypot(last[:, 0] - first[:, 0], last[:, 2] - first[:, 2]))


def speeds(track: Floats, plants: Segments, frame_time: float) -> tuple[Floats, Floats]:
    """Measure mean and highest horizontal speed of a track (F, 3) [m] in each plant, (S,) [m/s] each."""
    steps = np.zeros(len(plants.frames))
    steps[1:] = np.hypot(*np.diff(track[plants.frames][:, [0, 2]], axis=0).T) / frame_time
    follows = np.diff(plants.frames, prepend=-2) == 1
    follows[plants.starts] = False  # the step into a plant is not part of it
    steps[~follows] = 0.0
    share = plants.mean(follows.astype(np.float64))
    return plants.mean(steps) / np.maximum(share, 1e-12), plants.largest(steps)


def floor_levels(heights: Floats, plants: Segments, rig: Rig) -> Floats:
    """Find the height of the floor under each plant, (S,) [m].

    Args:
        heights: (F,) [m] of the sole point; with a skin, of the lowest vertex of the foot.
        plants: its plants.
        rig: its floor; a plant that is far from it (on a stair, a box) has a floor of its own.
    """
    own = plants.median(heights[plants.frames])
    return np.where(np.abs(own - rig.floor) < _NEAR * rig.leg_length, rig.floor, own)


def measure_plants(
    clip: Clip, rig: Rig, contacts: Contacts, pose: Pose, belt: Floats | None = None
) -> tuple[PlantMeasure, ...]:
    """Measure every contact.

    Args:
        clip: F frames.
        rig: its legs, sole points and floor.
        contacts: when each sole point is planted, in the order of `rig.soles`; what is forbidden is no plant.
        pose: forward kinematics of `seen.posed`.
        belt: (F, 3) [m] how far the ground has moved, as under a figure on a treadmill; at rest by default.

    Returns:
        One measure a contact, effector by effector, in order of time.
    """
    ground = np.zeros((len(clip), 3)) if belt is None else belt
    found: list[PlantMeasure] = []
    lowest = rig.lowest(pose) if rig.meshes else ()
    for k, seen in enumerate(seen_of(clip, rig, contacts, pose, ground)):
        if len(seen.plants):
            whole = [(c.start, c.end) for c in contacts.effectors[k].contacts if c.wish != "forbid"]
            if lowest:
                foot = [low for low, sole in zip(lowest, rig.soles, strict=True) if sole.leg == rig.soles[k].leg]
                heights, deepest = lowest[k] - ground[:, 1], np.min(foot, axis=0) - ground[:, 1]
            else:
                heights = deepest = seen.sole[:, 1]
            rows = _columns(seen, heights, deepest, pose.rotation(rig.soles[k].joint), rig, clip.frame_time)
            found.extend(PlantMeasure(rig.soles[k].name, *span, *row) for span, row in zip(whole, rows, strict=True))
    return tuple(found)


def _columns(
    seen: Seen, heights: Floats, deepest: Floats, turns: Floats, rig: Rig, frame_time: float
) -> list[tuple[Any, ...]]:
    """Compute, for each plant of a sole point, the fields of `PlantMeasure` after `end`.

    Args:
        seen: the plants of a sole point.
        heights, deepest: (F,) [m] of what stands on the floor, and of the lowest point of the foot.
        turns: (F, 4) of the joint that carries the sole point.
        rig: its floor.
        frame_time: [s].
    """
    plants = seen.plants
    level = floor_levels(deepest, plants, rig)[plants.owner]  # (N,) [m]
    above, below = heights[plants.frames] - level, level - deepest[plants.frames]  # (N,) [m]
    mean, peak = speeds(seen.track, seen.parts, frame_time)  # [m/s]
    columns = [
        1000.0 * slide(seen.track, seen.parts),
        1000.0 * slide(seen.sole, plants),
        1000.0 * travel(seen.track, seen.parts),
        np.degrees(yaw(turns, plants)),
        1000.0 * np.maximum(plants.largest(below), 0.0),
        1000.0 * np.maximum(plants.largest(above), 0.0),
        100.0 * mean,
        100.0 * peak,
    ]
    slides, *others = (column.tolist() for column in columns)
    tips = [None] * len(plants) if seen.tip is None else (1000.0 * slide(seen.tip, plants)).tolist()
    return list(zip(slides, tips, *others, strict=True))

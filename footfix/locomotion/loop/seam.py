"""Measures of a cycle's seam, where its end meets its start; measured on the finished cycle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.footplant import Footplant
from footfix.locomotion.loop.residual_slide import stretches
from footfix.locomotion.loop.root_motion import Travel
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import forward
from footfix.rig.rig import Rig

BESIDE = 5  # frames on each side of the seam
_INNER = 4  # least number of frames of a cycle away from its seam
_INSIDE = 99.0  # percentile of the accelerations away from the seam
FLOOR = 0.5  # [m/s^2] least reference acceleration, so that noise of a joint that hardly moves does not count
_LEAST = 5  # least number of frames of a measured plant
_TRIM = 1  # frames at each end of a plant that are not measured


@dataclass(frozen=True)
class Seam:
    """The seam of a cycle.

    Args:
        gap_mm: largest distance of a joint between the two poses that were joined, after the best turn and shift.
        gap_deg: largest angle between a joint's rotations in its parent's frame.
        changed_mm: largest distance by which closing moved a joint.
        changed_deg: largest angle by which closing turned a joint in its parent's frame.
        median_ratio, worst_ratio: of the joints, the largest acceleration beside the seam over the 99th percentile
            elsewhere; 1 is a seam like any other frame.
        slide_mm: farthest distance of a toe (its joint, or where that would be) planted across the seam from its
            median place; None without such a plant.
    """

    gap_mm: float
    gap_deg: float
    changed_mm: float
    changed_deg: float
    median_ratio: float
    worst_ratio: float
    slide_mm: float | None = None


def figure(clip: Clip, rig: Rig) -> Floats:
    """Compute the root and all joints and End Sites below it, (F, joints, 3) [m]."""
    skeleton = clip.skeleton
    mine = [joint for joint in range(len(skeleton)) if rig.root in skeleton.ancestors(joint)]
    ends = [(j, at) for j, at in zip(skeleton.end_parents.tolist(), skeleton.end_offsets, strict=True) if j in mine]
    pose = forward(clip, mine)
    tips = [pose.point(joint, at)[:, None] for joint, at in ends]
    return np.concatenate([pose.positions, *tips], axis=1)


def apart(clip: Clip, rig: Rig, start: int, end: int, travel: Travel) -> tuple[float, float]:
    """Measure the largest differences [m] and [rad] of joints in two frames, with places moved by the travel.

    Rotations are those in the parent's frame, so that a root's travel and turn do not count.
    """
    place = figure(clip.frames(np.array([start, end])), rig)
    far = float(np.linalg.norm(place[1] - travel.places(place[0]), axis=1).max())
    turns = np.stack([clip.rotation(joint)[[start, end]] for joint in range(len(clip.skeleton))], axis=1)
    below = clip.skeleton.parents >= 0
    turned = rotation.angle(rotation.multiply(turns[1], rotation.inverse(turns[0])))[below]
    return far, float(turned.max(initial=0.0))


def changes(before: Clip, after: Clip, rig: Rig) -> tuple[float, float]:
    """Measure the largest differences [m] and [rad] of joints in two clips of the same frames."""
    moved = float(np.linalg.norm(figure(after, rig) - figure(before, rig), axis=2).max(initial=0.0))
    turned = 0.0
    for joint in range(len(before.skeleton)):
        old, new = before.rotation(joint), after.rotation(joint)
        if old is not new:
            turned = max(turned, float(rotation.angle(rotation.multiply(new, rotation.inverse(old))).max(initial=0.0)))
    return moved, turned


def accelerations(clip: Clip, rig: Rig) -> Floats:
    """Compute accelerations (F, joints) [m/s^2] of the root and all joints below it; zero at the clip's ends."""
    found = np.zeros((len(clip), 0))
    if len(clip) > 2:
        found = np.pad(accelerations_of(figure(clip, rig), clip.frame_time), ((1, 1), (0, 0)))
    return found


def accelerations_of(tracks: Floats, frame_time: float) -> Floats:
    """Compute the accelerations (F - 2, J) [m/s^2] of tracks (F, J, 3) [m], frame by frame."""
    return np.asarray(np.linalg.norm(np.diff(tracks, n=2, axis=0), axis=2) / frame_time**2)


def ratios(clip: Clip, rig: Rig, travel: Travel) -> tuple[float, float]:
    """Compute the median and largest ratio, over all joints, of accelerations beside the seam to those elsewhere.

    Args:
        clip: L + 1 frames, the last of which is the first moved by `travel`.
        rig: its root.
        travel: of one round.
    """
    return ratios_of(figure(clip, rig), travel, clip.frame_time)


def ratios_of(seen: Floats, travel: Travel, frame_time: float) -> tuple[float, float]:
    """Compute the same ratios from joint places (L + 1, joints, 3) [m] and a frame time [s]."""
    one = seen[:-1]
    length = len(one)
    track = np.concatenate([travel.places_back(one[-1:]), one, travel.places(one[:1])])
    sharp = accelerations_of(track, frame_time)
    frame = np.arange(length)
    near = max(min(BESIDE, (length - _INNER) // 2), 1)  # of a short one some frames are left
    beside = (frame <= near) | (frame >= length - near)
    own = np.percentile(sharp[~beside], _INSIDE, axis=0)
    ratio = sharp[beside].max(axis=0) / np.maximum(own, FLOOR)
    return float(np.median(ratio)), float(ratio.max())


def slide(
    clip: Clip, rig: Rig, plants: Sequence[Footplant], travel: Travel, ground: Floats
) -> float | None:  # fmt: skip
    """Measure the farthest horizontal distance [m] of a toe held across the seam from its median place.

    It is the toe joint; the place where it would be on a foot that has none.

    Args:
        clip: L + 1 frames, the last of which is the first moved by `travel`.
        rig: its legs and soles.
        plants: of the cycle, with the frames in which they are held.
        travel: of one round.
        ground: (L + 1, 3) [m] how far the ground under planted feet has moved, as on a treadmill.
    """
    found = list[float]()
    for sole, toe in zip(rig.soles, rig.held(rig.pose(clip)), strict=True):
        if sole.part != "toe":
            continue
        own = [span for p in plants if p.leg == sole.leg and p.part == "toe" for span in stretches(p, len(clip))]
        after = [end for start, end in own if start == 0]
        before = [start for start, end in own if end == len(clip)]
        if after and before and before[0] > 0:
            rolled = [ground[before[0] : -1], ground[-1] - ground[0] + ground[: after[0]]]
            track = np.concatenate([toe[before[0] : -1], travel.places(toe[: after[0]])]) - np.concatenate(rolled)
            if len(track) >= _LEAST:
                found.append(_strays(track[_TRIM:-_TRIM]))
    return max(found, default=None)


def _strays(track: Floats) -> float:
    flat = track[:, [0, 2]]
    return float(np.linalg.norm(flat - np.median(flat, axis=0), axis=1).max())

"""Visible points of a planted foot: the joints that its skin is bound to, not estimated sole points.

The skin of the toes is bound to the toe joint, that of the heel to the ankle. Where heel and ball are on the sole is
an estimate, and a foot that rolls over such a point may hold it still while everything that is seen of it moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Bools, Clip, Floats, Skeleton
from footfix.motion.contacts import Contact, Contacts
from footfix.motion.kinematics import Pose, forward
from footfix.motion.segments import Segments, segments
from footfix.rig.rig import Rig

_TRIMMED = 5  # contacts of at least this many frames are measured without first and last, where feet land or lift
FEWEST = 3  # least number of frames with heel and toe both planted for the ankle to be measured
_NO_TIP = 0.01  # [m] a foot whose end is no farther from the toe joint has no tip


def counted(contact: Contact) -> tuple[int, int]:
    """Choose the measured frames of a contact: all except the first and the last, where it has enough frames."""
    trim = 1 if contact.end - contact.start >= _TRIMMED else 0
    return contact.start + trim, contact.end - trim


@dataclass(frozen=True, eq=False)
class Seen:
    """The visible point of one sole point's plants.

    Args:
        plants: the frames of each contact that are measured.
        parts: those of them in which `track` is measured.
        track: (F, 3) [m] of the joint that is seen, over the ground.
        sole: (F, 3) [m] of the sole point, over the ground.
        tip: (F, 3) [m] of the tip of the toes, None for heels and for feet that have none.
    """

    plants: Segments
    parts: Segments
    track: Floats
    sole: Floats
    tip: Floats | None


def seen_of(clip: Clip, rig: Rig, contacts: Contacts, pose: Pose, ground: Floats) -> tuple[Seen, ...]:
    """Find the visible points of each sole point's plants.

    Args:
        clip: F frames.
        rig: its legs and sole points.
        contacts: when each is planted; what is forbidden is no plant.
        pose: forward kinematics of `posed`.
        ground: (F, 3) [m] how far the ground has moved.

    Returns:
        One a sole point, in the order of `rig.soles`.
    """
    spans = [[counted(c) for c in each.contacts if c.wish != "forbid"] for each in contacts.effectors]
    stands: dict[tuple[int, str], Bools] = {}
    for sole, own in zip(rig.soles, spans, strict=True):
        stands[sole.leg, sole.part] = mask = np.zeros(len(clip), dtype=np.bool_)
        for start, end in own:
            mask[start:end] = True
    found = []
    for sole, own in zip(rig.soles, spans, strict=True):
        plants, leg = segments(own), rig.legs[sole.leg]
        point = pose.point(sole.joint, np.asarray(sole.offset)) - ground  # (F, 3) [m]
        parts, track, tip = plants, pose.point(*rig.held_at(sole)) - ground, None
        if sole.part == "heel":
            together = stands[sole.leg, "heel"] & stands[sole.leg, "toe"]
            parts, track = _heel(plants, together, pose.position(leg.ankle) - ground, point)
        elif leg.toe is not None:
            tip_at = tip_of(clip.skeleton, leg.toe)
            tip = None if tip_at is None else pose.point(*tip_at) - ground
        found.append(Seen(plants, parts, track, point, tip))
    return tuple(found)


def _heel(plants: Segments, together: Bools, ankle: Floats, point: Floats) -> tuple[Segments, Floats]:
    """Choose the frames of heel plants that are measured, and the track (F, 3) [m] to measure in them.

    While the toe is planted too, the ankle rests; where it never is, the foot rolls over its heel, and only the heel's
    sole point `point` (F, 3) [m] is left to measure.
    """
    if not len(plants):
        return plants, point
    both = together[plants.frames]  # (N,)
    flat = (np.add.reduceat(both.astype(np.intp), plants.starts) >= FEWEST)[plants.owner]  # (N,)
    track = point.copy()
    track[plants.frames[flat]] = ankle[plants.frames[flat]]
    return plants.kept(both | ~flat), track


def tip_of(skeleton: Skeleton, toe: int) -> tuple[int, Floats] | None:
    """Find the tip of the toes: among all joints and End Sites below the toe joint, the farthest from it at rest.

    Returns:
        The joint that carries the tip and where it is in that joint's frame (3,) [m]; None where nothing ends more
        than a centimetre from the toe joint.
    """
    at = {toe: np.zeros(3)}  # [m] from the toe joint, at rest
    ends = []
    for joint in range(toe + 1, len(skeleton)):  # parents precede children
        parent = int(skeleton.parents[joint])
        if parent in at:
            at[joint] = at[parent] + np.nan_to_num(skeleton.offsets[joint])
            ends.append((float(np.linalg.norm(at[joint])), joint, np.zeros(3)))
    for carrier, offset in zip(skeleton.end_parents.tolist(), np.nan_to_num(skeleton.end_offsets), strict=True):
        if carrier in at:
            ends.append((float(np.linalg.norm(at[carrier] + offset)), carrier, offset))
    far, joint, offset = max(ends, key=lambda end: end[0], default=(0.0, toe, np.zeros(3)))
    return (joint, offset) if far > _NO_TIP else None


def posed(clip: Clip, rig: Rig) -> Pose:
    """Compute the pose of the joints that are measured: those of the rig, and those that carry the tips of toes."""
    tips = [tip_of(clip.skeleton, leg.toe) for leg in rig.legs if leg.toe is not None]
    return forward(clip, clip.skeleton.with_ancestors((*rig.joints(), *(tip[0] for tip in tips if tip is not None))))

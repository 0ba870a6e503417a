"""Correction: what enforcement wants changed, as data; one function applies it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, frozen
from footfix.motion.kinematics import forward
from footfix.rig.followers import Follower

_NOTHING = 1e-9  # [m, rad]


@dataclass(frozen=True, eq=False)
class Correction:
    """What is to change in a clip.

    Args:
        root: the joint whose place is shifted.
        root_shift: (F, 3) [m] in the world.
        joints: the joints whose rotations are replaced.
        rotations: (F, len(joints), 4) xyzw their new local rotations; where nothing is to change, the very
            numbers of the clip, so that unchanged values stay exactly the same.
        followers: joints outside the legs that go along with a foot.
    """

    root: int
    root_shift: Floats
    joints: tuple[int, ...]
    rotations: Floats
    followers: tuple[Follower, ...] = ()

    def __post_init__(self) -> None:
        for name in ("root_shift", "rotations"):
            object.__setattr__(self, name, frozen(getattr(self, name)))


def apply(clip: Clip, correction: Correction) -> Clip:
    """Correct a clip. Frames and joints that the correction leaves alone keep their very numbers."""
    places: dict[int, Floats] = {}
    moved = np.any(correction.root_shift != 0.0, axis=1)
    if np.any(moved):
        shift = correction.root_shift[moved]
        parent = int(clip.skeleton.parents[correction.root])
        if parent >= 0:  # the shift is in the world, the channel in the parent's frame
            turn = forward(clip.frames(np.flatnonzero(moved)), [parent]).rotation(parent)
            shift = rotation.rotate(rotation.inverse(turn), shift)
        places[correction.root] = np.array(clip.position(correction.root), order="F")
        places[correction.root][moved] += shift
    turns = {joint: correction.rotations[:, k] for k, joint in enumerate(correction.joints)}
    corrected = clip.with_joints(places, turns) if places or turns else clip
    for follower in correction.followers if places or turns else ():
        corrected = _led_along(clip, corrected, follower)
    return corrected


def _led_along(before: Clip, after: Clip, follower: Follower) -> Clip:
    """Move a follower to where it was before beside its foot, in frames in which it is not there."""
    joint, foot = follower.joint, follower.foot
    parent = int(after.skeleton.parents[joint])
    was = forward(before, sorted({joint, foot}))
    now = forward(after, sorted({joint, foot, *({parent} - {-1})}))
    turn = rotation.multiply(now.rotation(foot), rotation.inverse(was.rotation(foot)))
    beside = was.position(joint) - was.position(foot)
    place = now.position(foot) + (beside if follower.level else rotation.rotate(turn, beside))
    turned = rotation.multiply(turn, was.rotation(joint)) if follower.turns else was.rotation(joint)
    off = np.linalg.norm(place - now.position(joint), axis=1) > _NOTHING
    twisted = rotation.apart(turned, now.rotation(joint)) > _NOTHING
    if parent >= 0:
        back = rotation.inverse(now.rotation(parent))
        place, turned = rotation.rotate(back, place - now.position(parent)), rotation.multiply(back, turned)
    places = np.where(off[:, None], place, after.position(joint))
    turns = np.where(twisted[:, None], turned, after.rotation(joint))
    able = after.skeleton.rotates[joint] and np.any(twisted)
    return after.with_joints({joint: places} if np.any(off) else {}, {joint: turns} if able else {})

"""Correction: what enforcement wants changed, as data; one function applies it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, frozen
from footfix.motion.kinematics import forward


@dataclass(frozen=True, eq=False)
class Correction:
    """What is to change in a clip.

    Args:
        root: the joint whose place is shifted.
        root_shift: (F, 3) [m] in the world.
        joints: the joints whose rotations are replaced.
        rotations: (F, len(joints), 4) xyzw their new local rotations; where nothing is to change, the very
            numbers of the clip, so that what did not need changing stays the same to the digit.
    """

    root: int
    root_shift: Floats
    joints: tuple[int, ...]
    rotations: Floats

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
        places[correction.root] = np.array(clip.place(correction.root), order="F")
        places[correction.root][moved] += shift
    turns = {joint: correction.rotations[:, k] for k, joint in enumerate(correction.joints)}
    return clip.with_joints(places, turns) if places or turns else clip

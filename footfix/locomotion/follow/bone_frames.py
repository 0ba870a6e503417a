"""Convert walks of one skeleton whose joints have different frames to the frames of the first walk."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.locomotion.follow.prepared_walk import Walk
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.motion.kinematics import Pose, forward
from footfix.motion.vectors import unit

_OTHER = np.radians(45.0)  # no two walks turn a bone of a leg about itself so differently in the mean
_BONE = 1e-3  # [leg lengths] a bone that is shorter is none
_ALONG = 1e-3  # [rad] by which bones may differ and still lie along one line


def in_frames_of_first(walks: Sequence[Walk]) -> tuple[Walk, ...]:
    """Convert walks to the joint frames of the first one; equal walks stay the same object."""
    led: dict[int, Walk] = {}
    for walk in walks:
        if id(walk) not in led:
            led[id(walk)] = in_frames_of(walks[0], walk) if walk is not walks[0] else walk
    return tuple(led[id(walk)] for walk in walks)


def in_frames_of(first: Walk, other: Walk) -> Walk:
    """Convert a walk to the joint frames of the first walk, if those of the legs differ widely.

    The twist of a bone about itself does not show on a stick figure, and solvers of inverse kinematics choose it
    arbitrarily. Blended with other twists, the figure's mesh would be distorted. Joint positions do not change.

    Args:
        first: the walk whose frames are used.
        other: with the same skeleton.
    """
    skeleton = first.clip.skeleton
    every = tuple(range(len(skeleton)))
    seen = [forward(walk.clip, every) for walk in (first, other)]
    ahead = [rotation.inverse(_ahead(first, pose)) for pose in seen]
    turns: dict[int, Floats] = {}
    for joint in every:
        children = list(skeleton.children[joint])
        if not skeleton.rotates[[joint, *children]].all() or skeleton.translates[children].any():
            continue
        want, have = (rotation.multiply(back, _mean(pose.rotation(joint)))
                      for back, pose in zip(ahead, seen, strict=True))  # fmt: skip
        turns[joint] = _free(rotation.multiply(rotation.inverse(have), want), _bones(first, joint))
    legs = skeleton.with_ancestors([leg.ankle for leg in first.rig.legs])
    if max((float(rotation.angle(turns[joint])) for joint in legs if joint in turns), default=0.0) <= _OTHER:
        return other
    return replace(other, clip=other.clip.with_joints({}, _local(other, turns)))


def _ahead(walk: Walk, pose: Pose) -> Floats:
    """Compute the mean heading of the hips (4,)."""
    if len(walk.rig.legs) < 2:
        return rotation.identity()
    one, two = (pose.position(leg.hip).mean(axis=0) for leg in walk.rig.legs[:2])
    return rotation.about_vertical(np.arctan2(*(one - two)[[0, 2]]))


def _local(walk: Walk, turns: dict[int, Floats]) -> dict[int, Floats]:
    """Compute the joints' rotations (F, 4) after some frames are turned by `turns`, with all below where it was."""
    skeleton = walk.clip.skeleton
    still = rotation.identity()
    moved = set(turns) | {child for joint in turns for child in skeleton.children[joint]}
    return {
        joint: rotation.multiply(
            rotation.multiply(
                rotation.inverse(turns.get(int(skeleton.parents[joint]), still)), walk.clip.rotation(joint)
            ),
            turns.get(joint, still),
        )
        for joint in moved
    }


def _bones(walk: Walk, joint: int) -> Floats:
    """List what hangs from a joint, (N, 3) [m]: places of its children, and End Sites."""
    skeleton = walk.clip.skeleton
    below = [walk.clip.position(child)[0] for child in skeleton.children[joint]]
    ends = skeleton.end_offsets[skeleton.end_parents == joint]
    bones = np.concatenate([np.reshape(below, (-1, 3)), ends])
    return np.asarray(bones[np.linalg.norm(bones, axis=1) > _BONE * walk.rig.leg_length])


def _free(turn: Floats, bones: Floats) -> Floats:
    """Take the part (4,) of a turn that leaves bones (N, 3) where they are."""
    if not len(bones):
        return turn
    line = unit(bones)
    if np.any(np.linalg.norm(np.cross(line, line[0]), axis=1) > _ALONG):
        return rotation.identity()
    twist = np.append((turn[:3] @ line[0]) * line[0], turn[3])
    return rotation.normalize(twist)


def _mean(turns: Floats) -> Floats:
    """Average rotations (F, 4) to (4,)."""
    return np.asarray(np.linalg.eigh(turns.T @ turns)[1][:, -1])

"""Forward kinematics over whole clips."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints, frozen


@dataclass(frozen=True, eq=False)
class Pose:
    """Joints in the world, frame by frame.

    Args:
        joints: which joints, in the order of the arrays.
        positions: (F, len(joints), 3) [m].
        rotations: (F, len(joints), 4) xyzw, each joint's frame in the world.
    """

    joints: tuple[int, ...]
    positions: Floats
    rotations: Floats

    def frames(self, which: Ints) -> Pose:
        """Take the joints in some frames only."""
        places, turns = (np.take(each.transpose(1, 2, 0), which, axis=2) for each in (self.positions, self.rotations))
        return Pose(self.joints, places.transpose(2, 0, 1), turns.transpose(2, 0, 1))

    def position(self, joint: int) -> Floats:
        """Get the track of one joint in the world, by its index in the skeleton, (F, 3) [m]."""
        return self.positions[:, self.joints.index(joint)]

    def rotation(self, joint: int) -> Floats:
        """Get the rotation of one joint's frame in the world, by its index in the skeleton, (F, 4)."""
        return self.rotations[:, self.joints.index(joint)]

    def point(self, joint: int, offset: Floats) -> Floats:
        """Compute the track (F, 3) [m] of a point fixed in a joint's frame at `offset` (3,) or (F, 3) [m]."""
        return self.position(joint) + rotation.rotate(self.rotation(joint), np.asarray(offset))


def forward(clip: Clip, joints: Iterable[int] | None = None) -> Pose:
    """Compute where joints are in the world.

    Args:
        clip: F frames of J joints.
        joints: which ones are wanted; all by default. Only these and their ancestors are computed.

    Returns:
        Their places [m] and rotations, in the order asked for.
    """
    skeleton = clip.skeleton
    wanted = tuple(range(len(skeleton))) if joints is None else tuple(joints)
    frames = len(clip)
    # (J, component, F): each joint's components are contiguous over frames, which is what makes this fast
    places = np.empty((len(wanted), 3, frames))
    turns = np.empty((len(wanted), 4, frames))
    slots: dict[int, list[int]] = {}
    for slot, joint in enumerate(wanted):
        slots.setdefault(joint, []).append(slot)
    for joint, place, turn in _walk(clip, skeleton.with_ancestors(wanted), slots):
        for slot in slots.get(joint, ()):
            places[slot], turns[slot] = place.T, turn.T
    return Pose(wanted, frozen(places.transpose(2, 0, 1)), frozen(turns.transpose(2, 0, 1)))


def places(clip: Clip) -> Floats:
    """Compute all joints' places in the world (F, J, 3) [m]: the positions of `forward`, in half its time."""
    out = np.empty((len(clip.skeleton), 3, len(clip)))
    for joint, place, _ in _walk(clip, range(len(clip.skeleton)), ()):
        out[joint] = place.T
    return frozen(out.transpose(2, 0, 1))


def _walk(clip: Clip, needed: Sequence[int], turned: Container[int]) -> Iterator[tuple[int, Floats, Floats]]:
    """Go through joints from the roots down, each with its place and its rotation in the world.

    Args:
        clip: F frames.
        needed: some joints and all above them, in the order of the file.
        turned: those whose rotation is needed; that of others without children is not computed.

    Yields:
        The joint, (F, 3) [m], and (F, 4), in the parent's frame where it was not computed.
    """
    last_use = {int(clip.skeleton.parents[joint]): joint for joint in needed}
    world: dict[int, tuple[Floats, Floats]] = {}
    for joint in needed:  # parents stand before children
        parent = int(clip.skeleton.parents[joint])
        place, turn = clip.position(joint), clip.rotation(joint)
        if parent >= 0:
            parent_place, parent_turn = world[parent]
            place = parent_place + rotation.rotate(parent_turn, place)
            if joint in last_use or joint in turned:
                turn = rotation.multiply(parent_turn, turn)
            if last_use[parent] == joint:
                del world[parent]  # limits memory to the width of the tree, not its size
        if joint in last_use:
            world[joint] = (place, turn)
        yield joint, place, turn

"""From a state to new rotations of all legs' joints at once: what `enforce.posed.local_rotations` says of one leg."""

from __future__ import annotations

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.leg import LEG, ROOT, B, K, Q, W
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats, Ints
from footfix.motion.kinematics import Pose
from footfix.stream.legs import Legs
from footfix.stream.part import Part


def correction(part: Part, clip: Clip, pose: Pose, legs: Legs, x: Floats, shift: Floats) -> Correction:
    """Turn a state of some frames into a correction of them.

    Args:
        part: the figure.
        clip: n frames of it, as captured.
        pose: of them.
        legs: in them.
        x: (U, n) the state.
        shift: (n, 3) [m] of the root.
    """
    L, n = len(legs.kinds.legs), len(clip)
    own = np.asarray(x[ROOT:]).reshape(L, LEG, n)
    changed = np.any(own != 0.0, axis=1)  # (L, n)
    if not changed.any():
        return Correction(part.known.rig.root, shift, (), np.zeros((n, 0, 4)), part.known.followers)
    joints, slots, turned = _joints(part, pose, legs)
    local = _local(pose, slots, _world(legs, own.transpose(1, 0, 2)))  # (4, L, n, 4)
    which, rotations = [], []
    for k in np.flatnonzero(changed.any(axis=1)).tolist():
        for at in np.flatnonzero(turned[:, k]).tolist():
            joint = int(joints[at, k])
            which.append(joint)
            rotations.append(np.where(changed[k][:, None], local[at, k], clip.rotation(joint)))
    return Correction(part.known.rig.root, shift, tuple(which), np.stack(rotations, axis=1), part.known.followers)


def _joints(part: Part, pose: Pose, legs: Legs) -> tuple[Ints, Ints, Bools]:
    """(4, L) hip, knee, ankle and toe; (2, 4, L) where the pose has them and their parents; (4, L) which are turned."""
    parents, kinds = part.skeleton.parents, legs.kinds
    joints = np.array(
        [[leg.hip, leg.knee, leg.ankle, leg.ankle if leg.toe is None else leg.toe] for leg in kinds.legs]
    ).T
    slot = {joint: k for k, joint in enumerate(pose.joints)} | {-1: -1}
    slots = np.array([[[slot[joint] for joint in row] for row in some.tolist()] for some in (joints, parents[joints])])
    turned = np.ones(joints.shape, dtype=np.bool_)
    turned[3] = kinds.bends
    return joints, slots, turned


def _world(legs: Legs, x: Floats) -> Floats:
    """(4, L, n, 4) what turns thigh, shank, foot and toes in the world, by the legs' unknowns (8, L, n)."""
    vectors = np.stack([x[K] * legs.axis, x[Q], x[W], x[B] * legs.toe_hinge], axis=1)  # (3, 4, L, n)
    bend, line, foot, toes = rotation.from_rotation_vector(vectors.transpose(1, 2, 3, 0))
    thigh, shank, way = (each.transpose(1, 2, 0) for each in (legs.thigh, legs.shank, legs.line))
    # the line from hip to ankle keeps its direction while the knee bends
    swing = rotation.multiply(line, rotation.between(thigh + rotation.rotate(bend, shank), way))
    below = rotation.multiply(np.stack([swing, foot]), np.stack([bend, toes]))
    return np.stack([swing, below[0], foot, below[1]])


def _local(pose: Pose, slots: Ints, turns: Floats) -> Floats:
    """(4, L, n, 4) local rotations of joints turned in the world, each below a parent that is turned as the one above.

    Args:
        pose: as captured.
        slots: (2, 4, L) where it has the joints, and their parents.
        turns: (4, L, n, 4) of the joints.
    """
    captured = pose.rotations.transpose(1, 0, 2)[slots]  # (2, 4, L, n, 4)
    captured[1][slots[1] < 0] = rotation.identity()
    still = rotation.identity(turns.shape[1:3])
    world = rotation.multiply(np.stack([turns, np.concatenate([still[None], turns[:3]])]), captured)
    return rotation.normalize(rotation.multiply(rotation.inverse(world[1]), world[0]))

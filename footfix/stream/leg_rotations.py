"""Compute new rotations of all legs' joints from a state, as `enforce.leg_state` does for one leg."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.correction import Correction, apply
from footfix.enforce.leg import LEG, ROOT, B, K, Q, W
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats, Ints
from footfix.motion.kinematics import Pose
from footfix.stream.arithmetic import between, from_rotation_vector, product, product_back, turned
from footfix.stream.joint_speed_limit import FASTEST, limited
from footfix.stream.legs import Kinds, Legs
from footfix.stream.subskeleton import Subskeleton


@dataclass(frozen=True, eq=False)
class Turned:
    """New rotations of all legs' joints in some frames.

    Args:
        rotations: (4, L, n, 4) new local rotations of hip, knee, ankle and toe.
        changed: (L, n) where a leg's rotations differ from the captured ones.
        late: (L, n) where a leg's turn was limited by the greatest joint speed.
    """

    rotations: Floats
    changed: Bools
    late: Bools


class Turner:
    """Turns the joints of a figure's legs as states require, frame by frame, without jumps."""

    def __init__(
        self, part: Subskeleton, joints: Sequence[int], kinds: Kinds, frame_time: float, *, goes_on: bool = True
    ) -> None:
        """Begin with a figure.

        Args:
            part: the figure.
            joints: those that its poses are of.
            kinds: what its legs are like.
            frame_time: [s].
            goes_on: whether frames were given out before, as captured.
        """
        own = np.array(
            [[leg.hip, leg.knee, leg.ankle, leg.ankle if leg.toe is None else leg.toe] for leg in kinds.legs]
        ).T
        slot = {joint: k for k, joint in enumerate(joints)} | {-1: -1}
        both = (own, part.skeleton.parents[own])
        self._slots: Ints = np.array([[[slot[joint] for joint in row] for row in each.tolist()] for each in both])
        self._joints, self._part = own, part
        self._written = np.ones(own.shape, dtype=np.bool_)
        self._written[3] = kinds.bends
        self._most = float(np.radians(FASTEST)) * frame_time
        self._last = rotation.identity(own.shape) if goes_on else None  # (4, L, 4) correction in the last frame

    def turn(self, pose: Pose, legs: Legs, x: Floats) -> Turned:
        """Turn the joints in the next n frames as a state (U, n) requires, from pose and legs as captured."""
        own = x[ROOT:].reshape(-1, LEG, x.shape[1])
        changed = np.any(own != 0.0, axis=1)  # (L, n)
        world = pose.rotations.transpose(1, 0, 2)[self._slots]  # (2, 4, L, n, 4)
        world[1][self._slots[1] < 0] = rotation.identity()
        captured = product_back(world[1], world[0])
        wanted = _local(world, _world(legs, own.swapaxes(0, 1)))
        more = np.where(
            (changed & self._written[..., None])[..., None],
            product(wanted, rotation.inverse(captured)), rotation.identity(),
        )  # fmt: skip
        more, late = limited(more, more[:, :, 0] if self._last is None else self._last, self._most)
        self._last = more[:, :, -1]
        rotations = np.where(late[..., None], product(more, captured), wanted)
        return Turned(rotations, changed | late, late)

    def corrected(self, clip: Clip, turned: Turned, shift: Floats) -> Clip:
        """Correct n frames of the figure, its root shifted by (n, 3) [m], too."""
        rig = self._part.known.rig
        if self._part.known.followers or clip.skeleton.parents[rig.root] >= 0:
            return apply(clip, self.correction(clip, turned, shift))
        which = self._written & turned.changed.any(axis=1)
        joints, places, turns = self._joints[which], np.array(clip.positions), np.array(clip.rotations)
        wanted = np.where(
            turned.changed[None, ..., None], turned.rotations, turns[:, self._joints].transpose(1, 2, 0, 3)
        )
        turns[:, joints] = wanted[which].swapaxes(0, 1)
        places[:, rig.root] += shift
        return Clip.from_tracks(clip.skeleton, places, turns, clip.frame_time)

    def correction(self, clip: Clip, turned: Turned, shift: Floats) -> Correction:
        """Lay out as a correction what is to change in n frames of the figure, its root shifted by (n, 3) [m], too."""
        joints, rotations = [], []
        for k, changed in enumerate(turned.changed):
            for at in np.flatnonzero(self._written[:, k] & changed.any()).tolist():
                joint = int(self._joints[at, k])
                joints.append(joint)
                rotations.append(np.where(changed[:, None], turned.rotations[at, k], clip.rotation(joint)))
        stacked = np.stack(rotations, axis=1) if rotations else np.zeros((len(clip), 0, 4))
        return Correction(self._part.known.rig.root, shift, tuple(joints), stacked, self._part.known.followers)


def _world(legs: Legs, x: Floats) -> Floats:
    """Compute the world rotations (4, L, n, 4) of thigh, shank, foot and toes from the legs' unknowns (8, L, n)."""
    vectors = np.empty((3, 4, *x.shape[1:]))
    vectors[:, 0], vectors[:, 1], vectors[:, 2], vectors[:, 3] = x[K] * legs.axis, x[Q], x[W], x[B] * legs.toe_hinge
    turns = from_rotation_vector(vectors)  # of bend, line, foot and toes
    bent = np.moveaxis(turned(turns[0], np.moveaxis(legs.shank, 0, -1)), -1, 0)
    # the line from hip to ankle keeps its direction while the knee bends
    turns[1] = product(turns[1], between(legs.thigh + bent, legs.line))
    out = np.empty_like(turns)
    out[::2] = turns[1:3]
    out[1::2] = product(turns[1:3], turns[[0, 3]])
    return out


def _local(captured: Floats, turns: Floats) -> Floats:
    """Convert world rotations to local ones (4, L, n, 4), each below a parent turned as the joint above.

    Args:
        captured: (2, 4, L, n, 4) rotations of the joints, and of their parents, in the world.
        turns: (4, L, n, 4) of the joints.
    """
    above = np.concatenate([rotation.identity((1, *turns.shape[1:3])), turns[:3]])
    world = product(np.stack([turns, above]), captured)
    return rotation.normalize(product_back(world[1], world[0]))

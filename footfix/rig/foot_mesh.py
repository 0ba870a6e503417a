"""The mesh of a foot on a clip's joints: where its vertices are, and how low the lowest of them is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats, Ints, frozen
from footfix.motion.kinematics import Pose

_BLOCK = 2048  # frames computed at a time


@dataclass(frozen=True, eq=False)
class FootMesh:
    """Vertices of one foot, skinned to joints of a clip.

    Args:
        leg: index into `Rig.legs`.
        joints: (V, k) the joints that move each vertex.
        weights: (V, k) their skinning weights, which add up to 1.
        offsets: (V, k, 3) [m] where the vertex is in each of these joints' frames.
        sole: (V,) which vertices are of the sole.
        toe: (V,) which belong to the toe's sole point, the others to the heel's.
        outlines: vertices along the outline of the part that moves with the ankle, and of the part that moves with the
            toe joint.
    """

    leg: int
    joints: Ints
    weights: Floats
    offsets: Floats
    sole: Bools
    toe: Bools
    outlines: tuple[tuple[int, ...], ...] = ()

    def __post_init__(self) -> None:
        for key in ("weights", "offsets"):
            object.__setattr__(self, key, frozen(getattr(self, key)))
        object.__setattr__(self, "joints", frozen(self.joints, np.intp))
        for key in ("sole", "toe"):
            object.__setattr__(self, key, frozen(getattr(self, key), np.bool_))

    def __len__(self) -> int:
        return len(self.sole)

    @cached_property
    def carriers(self) -> tuple[int, ...]:
        """List the joints that move it."""
        return tuple(np.unique(self.joints[self.weights > 0.0]).tolist())

    def tracks(self, pose: Pose, which: Ints) -> Floats:
        """Compute the tracks (F, N, 3) [m] of some vertices (N,) by linear blend skinning."""
        return self._skinned(pose, which, slice(None), slice(0, 3))

    def lowest(self, pose: Pose, which: Bools | None = None) -> Floats:
        """Compute the height (F,) [m] of the lowest vertex, of all or of some (V,) of them."""
        some = np.arange(len(self)) if which is None else np.flatnonzero(which)
        found = [self._skinned(pose, some, block, slice(1, 2))[..., 0].min(axis=1) for block in _blocks(pose)]
        return np.concatenate(found) if found else np.zeros(0)

    def _skinned(self, pose: Pose, which: Ints, frames: slice, axes: slice) -> Floats:
        """Compute some coordinates of some vertices in some frames (f, N, a)."""
        joints, weights, offsets = self.joints[which], self.weights[which], self.offsets[which]
        out: Floats | None = None
        for joint in np.unique(joints[weights > 0.0]).tolist():
            at = np.array(pose.position(joint)[frames, axes])  # (f, a)
            axis = rotation.to_matrix(pose.rotation(joint)[frames])[:, axes]  # (f, a, 3)
            out = np.zeros((len(at), len(which), at.shape[1])) if out is None else out
            for slot in range(joints.shape[1]):
                rows = np.flatnonzero((joints[:, slot] == joint) & (weights[:, slot] > 0.0))
                if len(rows):
                    own = weights[rows, slot][:, None]
                    out[:, rows] += np.einsum("fab,vb->fva", axis, offsets[rows, slot] * own) + own * at[:, None]
        return np.zeros((len(pose.positions[frames]), 0, 3)) if out is None else out


def _blocks(pose: Pose) -> Iterator[slice]:
    for start in range(0, len(pose.positions), _BLOCK):
        yield slice(start, start + _BLOCK)

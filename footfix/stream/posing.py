"""Forward kinematics of a few frames, for all joints of one depth together: what `motion.kinematics` says of a clip."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Skeleton
from footfix.motion.kinematics import Pose
from footfix.stream.arithmetic import product


class Posing:
    """Where some joints of a figure are in the world."""

    def __init__(self, skeleton: Skeleton, joints: Sequence[int]) -> None:
        """Know the figure, and which joints are wanted."""
        self._joints = tuple(joints)
        needed = np.array(skeleton.with_ancestors(joints), dtype=np.intp)
        depth = np.array([len(skeleton.ancestors(joint)) for joint in needed.tolist()])
        self._levels = [needed[depth == k] for k in range(1, int(depth.max()) + 1)]
        self._parents = [skeleton.parents[level] for level in self._levels]
        self._wanted = np.array(joints, dtype=np.intp)

    def __call__(self, clip: Clip) -> Pose:
        """Put the joints of a clip of F frames."""
        places, turns = clip.positions.transpose(2, 1, 0), clip.rotations.transpose(2, 1, 0)  # (3 or 4, J, F)
        at, turned = np.array(places), np.array(turns)
        for level, parents in zip(self._levels[1:], self._parents[1:], strict=True):
            above = turned[:, parents].transpose(1, 2, 0)
            at[:, level] = at[:, parents] + rotation.rotate(above, places[:, level].transpose(1, 2, 0)).transpose(
                2, 0, 1
            )
            turned[:, level] = product(above, turns[:, level].transpose(1, 2, 0)).transpose(2, 0, 1)
        return Pose(
            self._joints, at[:, self._wanted].transpose(2, 1, 0), turned[:, self._wanted].transpose(2, 1, 0)
        )  # fmt: skip

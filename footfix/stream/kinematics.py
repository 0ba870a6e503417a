"""Forward kinematics of a few frames in few operations, as `motion.kinematics` computes for a clip.

Rotations go from depth to depth, each by one product of matrices; then all places are sums of turned offsets, of a
joint and all above it, which is one product for all of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.motion.clip import Clip, Skeleton
from footfix.motion.kinematics import Pose
from footfix.stream.arithmetic import after, turned


class Posing:
    """Computes where some joints of a figure are in the world."""

    def __init__(self, skeleton: Skeleton, joints: Sequence[int]) -> None:
        """Set up for a figure and the wanted joints."""
        self._joints = tuple(joints)
        needed = skeleton.with_ancestors(joints)
        slot = {joint: k for k, joint in enumerate(needed)}
        paths = [skeleton.ancestors(joint) for joint in needed]
        deepest = max(len(path) for path in paths)
        levels = [[k for k, path in enumerate(paths) if len(path) == depth] for depth in range(2, deepest + 1)]
        self._needed = np.array(needed, dtype=np.intp)
        self._below = np.array([k for k, path in enumerate(paths) if len(path) > 1], dtype=np.intp)
        self._above = np.array([slot.get(int(skeleton.parents[joint]), 0) for joint in needed], dtype=np.intp)
        self._levels = [(np.array(level, dtype=np.intp), self._above[level]) for level in levels]
        # (wanted, needed) whose offsets lead to a joint
        self._leads = np.array([[joint in paths[slot[each]] for joint in needed] for each in joints], dtype=np.float64)
        self._wanted = np.array([slot[joint] for joint in joints], dtype=np.intp)

    def __call__(self, clip: Clip) -> Pose:
        """Compute the joints' pose in a clip of F frames."""
        world = clip.rotations.transpose(1, 0, 2)[self._needed]  # (N, F, 4)
        then = after(world)  # (N, F, 4, 4)
        for level, parents in self._levels:
            world[level] = (then[level] @ world[parents][..., None])[..., 0]
        offsets = clip.positions.transpose(1, 0, 2)[self._needed]  # (N, F, 3)
        below = self._below
        offsets[below] = turned(world[self._above[below]], offsets[below])
        n = len(clip)
        places = (self._leads @ offsets.reshape(len(offsets), -1)).reshape(-1, n, 3)
        return Pose(self._joints, places.swapaxes(0, 1), world[self._wanted].swapaxes(0, 1))

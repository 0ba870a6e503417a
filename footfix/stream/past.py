"""What a stream remembers of its newest frames: their rows, their legs, and the joints about them."""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Floats
from footfix.motion.kinematics import Pose
from footfix.stream.legs import Kinds, Legs
from footfix.stream.ring import Ring


class Past:
    """The newest frames."""

    def __init__(self, kinds: Kinds, joints: tuple[int, ...], columns: int, capacity: int) -> None:
        """Begin with no frames.

        Args:
            kinds: what the legs are like.
            joints: that poses are of.
            columns: numbers in a row.
            capacity: frames that are remembered at least.
        """
        self._kinds, self._joints = kinds, joints
        self.rows = Ring((columns,), capacity)
        self._legs = Ring((35 * len(kinds.legs),), capacity)
        self._pose = Ring((7 * len(joints),), capacity)

    @property
    def end(self) -> int:
        """Number of the frame that comes next."""
        return self.rows.end

    def append(self, rows: Floats, legs: Legs, pose: Pose) -> None:
        """Add the next frames (n, C), their legs and joints."""
        n = len(rows)
        self.rows.append(rows)
        self._legs.append(legs.rows())
        self._pose.append(np.concatenate([pose.positions.reshape(n, -1), pose.rotations.reshape(n, -1)], axis=1))

    def legs(self, first: int) -> Legs:
        """Get the legs from frame `first` on."""
        return Legs.of_rows(self._kinds, self._legs.view(first))

    def pose(self, first: int, stop: int) -> Pose:
        """Get the joints in frames `[first, stop)`."""
        rows = self._pose.view(first, stop)
        n, joints = len(rows), len(self._joints)
        return Pose(
            self._joints, rows[:, : 3 * joints].reshape(n, joints, 3), rows[:, 3 * joints :].reshape(n, joints, 4)
        )

"""The newest frames of a stream: their rows, legs, and joints."""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Clip, Floats, Skeleton
from footfix.motion.kinematics import Pose
from footfix.stream.legs import Kinds, Legs
from footfix.stream.ring_buffer import Ring


class History:
    """The newest frames."""

    def __init__(
        self, kinds: Kinds, joints: tuple[int, ...], skeleton: Skeleton, frame_time: float, columns: int, capacity: int
    ) -> None:
        """Begin with no frames.

        Args:
            kinds: what the legs are like.
            joints: that poses are of.
            skeleton: of the joints that are worked on.
            frame_time: [s].
            columns: numbers in a row.
            capacity: frames that are remembered at least.
        """
        self._kinds, self._joints = kinds, joints
        self.rows = Ring((columns,), capacity)
        self._legs = Ring((35 * len(kinds.legs),), capacity)
        self._pose = Ring((7 * len(joints),), capacity)
        self._skeleton, self._frame_time = skeleton, frame_time
        self._local = Ring((7 * len(skeleton),), capacity)

    @property
    def end(self) -> int:
        """Number of the frame that comes next."""
        return self.rows.end

    def append(self, rows: Floats, clip: Clip, legs: Legs, pose: Pose) -> None:
        """Add the next frames (n, C), what they say, their legs and joints."""
        n = len(rows)
        self.rows.append(rows)
        self._local.append(np.concatenate([clip.positions.reshape(n, -1), clip.rotations.reshape(n, -1)], axis=1))
        self._legs.append(legs.rows())
        self._pose.append(np.concatenate([pose.positions.reshape(n, -1), pose.rotations.reshape(n, -1)], axis=1))

    def clip(self, first: int, stop: int) -> Clip:
        """Get the motion of frames `[first, stop)`."""
        columns, n = np.ascontiguousarray(self._local.view(first, stop).T), len(self._skeleton)
        places, turns = columns[: 3 * n].reshape(n, 3, -1), columns[3 * n :].reshape(n, 4, -1)
        return Clip.from_tracks(self._skeleton, places.transpose(2, 0, 1), turns.transpose(2, 0, 1), self._frame_time)

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

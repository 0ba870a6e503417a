"""The legs of a stream's newest frames, as enforcement looks at them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.enforce.leg import LegTracks
from footfix.motion.clip import Floats
from footfix.motion.kinematics import Pose
from footfix.stream.ring import Ring

_VECTORS = ("hip", "ankle", "line", "thigh", "shank", "axis", "reach", "toe_hinge")
_NUMBERS = ("flexion", "least")


class LegRing:
    """The newest frames of some legs, and of the joints about them."""

    def __init__(self, legs: Sequence[LegTracks], pose: Pose, capacity: int) -> None:
        """Begin with no frames.

        Args:
            legs: what they are like, of any frames.
            pose: of the same.
            capacity: frames that are remembered at least.
        """
        self._like, self._joints = tuple(legs), pose.joints
        self._counts = tuple(len(leg.points) for leg in legs)
        rows = sum(3 * (len(_VECTORS) + count) + len(_NUMBERS) for count in self._counts)
        self._legs = Ring((rows,), capacity)
        self._pose = Ring((7 * len(pose.joints),), capacity)

    @property
    def end(self) -> int:
        """Number of the frame that comes next."""
        return self._legs.end

    def append(self, legs: Sequence[LegTracks], pose: Pose) -> None:
        """Add the next frames of the same legs and joints."""
        parts = []
        for leg in legs:
            parts += [getattr(leg, name) for name in _VECTORS] + list(leg.points)
            parts += [getattr(leg, name)[None] for name in _NUMBERS]
        self._legs.append(np.concatenate(parts).T)
        n = len(pose.positions)
        self._pose.append(np.concatenate([pose.positions.reshape(n, -1), pose.rotations.reshape(n, -1)], axis=1))

    def legs(self, first: int) -> tuple[LegTracks, ...]:
        """Get the legs from frame `first` on."""
        rows = np.ascontiguousarray(self._legs.view(first).T)
        found, at = [], 0
        for leg, count in zip(self._like, self._counts, strict=True):
            some: dict[str, Floats] = {}
            for name in _VECTORS:
                some[name], at = rows[at : at + 3], at + 3
            points = tuple(rows[at + 3 * k : at + 3 * k + 3] for k in range(count))
            at += 3 * count
            some |= {name: rows[at + k] for k, name in enumerate(_NUMBERS)}
            at += len(_NUMBERS)
            found.append(LegTracks(leg.leg, **some, points=points, bends=leg.bends, turns=leg.turns))
        return tuple(found)

    def pose(self, first: int, stop: int) -> Pose:
        """Get the joints in frames `[first, stop)`."""
        rows = self._pose.view(first, stop)
        n, joints = len(rows), len(self._joints)
        return Pose(
            self._joints, rows[:, : 3 * joints].reshape(n, joints, 3), rows[:, 3 * joints :].reshape(n, joints, 4)
        )

"""Skeleton and Clip: the motion as arrays, in one frame of reference (metres, y up).

Euler angles, channel orders, units and axes exist only in `footfix.formats`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Bools = NDArray[np.bool_]


def frozen(array: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """A read-only view of an array (a copy only where the type differs)."""
    view = np.asarray(array, dtype=dtype).view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints, their tree and their rest offsets.

    Args:
        names: joint names as in the file; they may repeat, the index is the identity.
        parents: (J,) index of each joint's parent, -1 for a root; a parent stands before its children.
        offsets: (J, 3) [m] place of each joint in its parent's frame, at rest.
        end_parents: (E,) the joints that carry End Sites.
        end_offsets: (E, 3) [m] place of each End Site in its joint's frame.
        translates: (J,) joints whose place can be animated (three position channels); default the roots.
        rotates: (J,) joints whose rotation can be animated freely (three rotation channels); default all.
    """

    names: tuple[str, ...]
    parents: Ints
    offsets: Floats
    end_parents: Ints = field(default_factory=lambda: np.zeros(0, np.intp))
    end_offsets: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    translates: Bools = None  # type: ignore[assignment]  # filled in from the parents
    rotates: Bools = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        n = len(self.names)
        parents = frozen(self.parents, np.intp)
        if parents.shape != (n,) or np.any(parents >= np.arange(n)) or np.any(parents < -1):
            raise ValueError("parents must be (J,), each before its children, -1 for a root")
        freeze = object.__setattr__
        freeze(self, "names", tuple(self.names))
        freeze(self, "parents", parents)
        freeze(self, "offsets", frozen(self.offsets).reshape(n, 3))
        freeze(self, "end_parents", frozen(self.end_parents, np.intp))
        freeze(self, "end_offsets", frozen(self.end_offsets).reshape(-1, 3))
        translates = parents < 0 if self.translates is None else self.translates
        rotates = np.ones(n) if self.rotates is None else self.rotates
        freeze(self, "translates", frozen(translates, np.bool_))
        freeze(self, "rotates", frozen(rotates, np.bool_))

    def __len__(self) -> int:
        return len(self.names)

    @cached_property
    def children(self) -> tuple[tuple[int, ...], ...]:
        """The children of each joint, in the order of the file."""
        lists: list[list[int]] = [[] for _ in self.names]
        for joint, parent in enumerate(self.parents.tolist()):
            if parent >= 0:
                lists[parent].append(joint)
        return tuple(tuple(each) for each in lists)

    def with_ancestors(self, joints: Iterable[int]) -> tuple[int, ...]:
        """Some joints and all above them, in the order of the file, each once."""
        wanted = set(joints)
        for joint in range(max(wanted, default=-1), -1, -1):  # parents stand before children
            if joint in wanted:
                wanted.add(int(self.parents[joint]))
        return tuple(sorted(wanted - {-1}))

    def ancestors(self, joint: int) -> tuple[int, ...]:
        """The joint, its parent, and so on up to its root."""
        path = []
        while joint >= 0:
            path.append(joint)
            joint = int(self.parents[joint])
        return tuple(path)


@dataclass(frozen=True, eq=False)
class Clip:
    """A motion: for each frame the local place and rotation of each joint.

    Args:
        skeleton: the joints.
        positions: (F, J, 3) [m] place of each joint in its parent's frame (the rest offset, or what
            position channels put in its stead).
        rotations: (F, J, 4) unit quaternions xyzw, each joint's frame in its parent's.
        frame_time: [s] between frames.
    """

    skeleton: Skeleton
    positions: Floats
    rotations: Floats
    frame_time: float

    def __post_init__(self) -> None:
        positions, rotations = frozen(self.positions), frozen(self.rotations)
        joints = len(self.skeleton)
        if positions.ndim != 3 or positions.shape[1:] != (joints, 3):
            raise ValueError(f"positions must be (F, {joints}, 3), not {positions.shape}")
        if rotations.shape != (*positions.shape[:2], 4):
            raise ValueError(f"rotations must be {(*positions.shape[:2], 4)}, not {rotations.shape}")
        if not self.frame_time > 0.0:
            raise ValueError(f"frame_time must be positive, not {self.frame_time}")
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "rotations", rotations)

    def __len__(self) -> int:
        return int(self.positions.shape[0])

    @property
    def fps(self) -> float:
        """Frames per second."""
        return 1.0 / self.frame_time

    def frames(self, which: slice | Ints) -> Clip:
        """The clip of some frames only; the frame time stays as it is."""
        return replace(self, positions=_some(self.positions, which), rotations=_some(self.rotations, which))


def _some(array: Floats, frames: slice | Ints) -> Floats:
    """Some frames of (F, J, n); the frames of each number stay side by side in memory, for kinematics is twice as
    slow where they do not."""
    if isinstance(frames, slice):
        return array[frames]
    return np.take(array.transpose(1, 2, 0), frames, axis=-1).transpose(2, 0, 1)

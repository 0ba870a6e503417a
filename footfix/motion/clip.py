"""Skeleton and Clip: the motion as arrays, in one frame of reference (metres, y up).

Euler angles, channel orders, units and axes exist only in `footfix.formats`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footfix.errors import ArgumentError

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Bools = NDArray[np.bool_]


def frozen(array: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """Make a read-only view of an array (a copy only where the type differs)."""
    view = np.asarray(array, dtype=dtype).view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joints, their tree and their rest offsets.

    Examples:
        >>> leg = Skeleton(("hip", "knee", "ankle"), [-1, 0, 1], [[0, 0, 0], [0, -0.45, 0], [0, -0.42, 0]])
        >>> leg.children
        ((1,), (2,), ())

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
            raise ArgumentError(f"parents must be ({n},), one a name, each before its children, -1 for a root")
        if np.size(self.offsets) != 3 * n:
            raise ArgumentError(f"offsets must be ({n}, 3), one a joint, not {np.shape(self.offsets)}")
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
        """List the children of each joint, in the order of the file."""
        lists: list[list[int]] = [[] for _ in self.names]
        for joint, parent in enumerate(self.parents.tolist()):
            if parent >= 0:
                lists[parent].append(joint)
        return tuple(tuple(each) for each in lists)

    def with_ancestors(self, joints: Iterable[int]) -> tuple[int, ...]:
        """List some joints and all above them, in the order of the file, each once."""
        wanted = set(joints)
        for joint in range(max(wanted, default=-1), -1, -1):  # parents stand before children
            if joint in wanted:
                wanted.add(int(self.parents[joint]))
        return tuple(sorted(wanted - {-1}))

    def ancestors(self, joint: int) -> tuple[int, ...]:
        """List the joint, its parent, and so on up to its root."""
        path = []
        while joint >= 0:
            path.append(joint)
            joint = int(self.parents[joint])
        return tuple(path)


@dataclass(frozen=True, eq=False)
class Clip:
    """A motion: for each frame the place and rotation of each joint in the frame of its parent, y up.

    Positions are parent-local, as BVH channels are, and not where joints are in the world: that is
    `footfix.global_positions(clip)`. Motion given as world positions alone is cleaned by `footfix.clean_positions`.

    Examples:
        >>> leg = Skeleton(("hip", "knee"), [-1, 0], [[0, 0, 0], [0, -0.45, 0]])
        >>> at_rest = np.tile([0.0, 0.0, 0.0, 1.0], (60, 2, 1))
        >>> clip = Clip(leg, np.tile(leg.offsets, (60, 1, 1)), at_rest, frame_time=1 / 60)
        >>> len(clip), clip.positions.shape
        (60, (60, 2, 3))

    Args:
        skeleton: the joints.
        positions: (F, J, 3) [m] place of each joint in its parent's frame: its rest offset (of a root: where it is
            in the world), or the values of its position channels.
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
            raise ArgumentError(f"positions must be (F, {joints}, 3), one a joint, not {positions.shape}")
        if rotations.shape != (*positions.shape[:2], 4):
            raise ArgumentError(f"rotations must be xyzw {(*positions.shape[:2], 4)}, not {rotations.shape}")
        if not self.frame_time > 0.0:
            raise ArgumentError(f"frame_time must be positive, the seconds from frame to frame, not {self.frame_time}")
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "rotations", rotations)

    @classmethod
    def from_tracks(
        cls, skeleton: Skeleton, places: Floats | Sequence[Floats], turns: Floats | Sequence[Floats], frame_time: float
    ) -> Clip:
        """Make a clip from tracks, which may be shared with other clips that differ in a few joints only.

        This saves memory: most joints never leave their rest offset, and an hour of 200 joints takes 5 GB in full.

        Args:
            skeleton: the joints, at least one.
            places: for each joint (F, 3) [m], or all of them as `positions`.
            turns: for each joint (F, 4), or all of them as `rotations`.
            frame_time: [s] between frames.
        """
        clip: Clip = object.__new__(cls)
        clip.__dict__.update(skeleton=skeleton, frame_time=frame_time)
        for whole, parts, given in (("positions", "_places", places), ("rotations", "_turns", turns)):
            is_whole = isinstance(given, np.ndarray)
            clip.__dict__[whole if is_whole else parts] = frozen(given) if is_whole else tuple(map(frozen, given))
        return clip

    def __getattr__(self, name: str) -> Floats:
        # Called for a missing attribute: arrays of all joints are made from tracks only when they are needed.
        tracks = self.__dict__.pop({"positions": "_places", "rotations": "_turns"}.get(name, ""), None)
        if tracks is None:
            raise AttributeError(name)
        whole = frozen(np.stack([track.T for track in tracks]).transpose(2, 0, 1))
        self.__dict__[name] = whole
        return whole

    def position(self, joint: int) -> Floats:
        """Get the track of one joint in its parent's frame, (F, 3) [m]."""
        tracks = self.__dict__.get("_places")
        return self.positions[:, joint] if tracks is None else tracks[joint]

    def rotation(self, joint: int) -> Floats:
        """Get the rotations of one joint in its parent's frame, (F, 4)."""
        tracks = self.__dict__.get("_turns")
        return self.rotations[:, joint] if tracks is None else tracks[joint]

    def with_joints(self, places: Mapping[int, Floats], turns: Mapping[int, Floats]) -> Clip:
        """Replace the tracks of some joints; those of the others are shared, not copied.

        Args:
            places: joint -> (F, 3) [m].
            turns: joint -> (F, 4).
        """
        joints = range(len(self.skeleton))
        return Clip.from_tracks(
            self.skeleton,
            [places[joint] if joint in places else self.position(joint) for joint in joints],
            [turns[joint] if joint in turns else self.rotation(joint) for joint in joints],
            self.frame_time,
        )

    def __len__(self) -> int:
        return len(self.position(0)) if len(self.skeleton) else len(self.positions)

    @property
    def fps(self) -> float:
        """Get the frames per second."""
        return 1.0 / self.frame_time

    def frames(self, which: slice | Ints) -> Clip:
        """Cut out some frames; the frame time stays as it is."""
        joints = range(len(self.skeleton))
        return Clip.from_tracks(
            self.skeleton,
            [take_frames(self.position(joint), which) for joint in joints],
            [take_frames(self.rotation(joint), which) for joint in joints],
            self.frame_time,
        )


def constant_track(value: ArrayLike, frames: int) -> Floats:
    """Make a track (F, n) that is the same in every frame, in the memory of one frame."""
    return np.broadcast_to(np.asarray(value, dtype=np.float64), (frames, np.size(value)))


def same_track(one: Floats, other: Floats) -> bool:
    """Tell whether two tracks (F, n) lie in the same memory, so that their numbers need not be compared."""
    where = [(each.__array_interface__["data"], each.strides, each.shape) for each in (one, other)]
    return where[0] == where[1]


def per_frame(function: Callable[[Floats], Floats], track: Floats) -> Floats:
    """Apply a function to the frames of a track (F, n), once where all are the same."""
    if len(track) and track.strides[0] == 0:
        return np.broadcast_to(function(track[:1]), track.shape)
    return function(track)


def take_frames(track: Floats, frames: slice | Ints) -> Floats:
    """Take some frames of a track, contiguous in memory, since kinematics would be twice as slow otherwise."""
    if isinstance(frames, slice):
        return track[frames]
    if len(track) and track.strides[0] == 0:
        return np.broadcast_to(track[:1], (len(frames), track.shape[1]))
    return np.take(track.T, frames, axis=-1).T

"""Convert rows of a stream to motion and back: BVH channels, or positions and rotations of all joints.

The numbers are the same as in `formats.bvh.channels`, but all joints with one channel order are converted together: a
stream handles a few frames at a time, so that its time depends on the number of operations.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from footfix.formats.bvh.channels import (
    AXES,
    joint_channels,
    nearest_angles,
    permuted,
    placed,
    to_clip,
    write_quaternions,
)
from footfix.formats.bvh.document import Document
from footfix.formats.bvh.tree import Channel
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints, Skeleton
from footfix.stream.euler import to_euler
from footfix.stream.subskeleton import Subskeleton


@dataclass(frozen=True, eq=False)
class _Turning:
    """Joints whose rotation channels have one order.

    Args:
        order: axis of each channel.
        joints: (m,).
        columns: (m, len(order)) of a row.
        turn: (4,) from the file's axes to ours, of roots; None where there is nothing to turn.
    """

    order: tuple[int, ...]
    joints: Ints
    columns: Ints
    turn: Floats | None = None

    @property
    def letters(self) -> str:
        """Get the order as letters."""
        return "".join("XYZ"[axis] for axis in self.order)

    def angles(self, wanted: Floats, near: Floats) -> Floats:
        """Convert local rotations (n, m, 4) to angles (n, m, len(order)) [rad], nearest to given ones."""
        if self.turn is not None:
            wanted = rotation.multiply(rotation.inverse(self.turn), wanted)
        if sorted(self.order) == [0, 1, 2]:
            return to_euler(wanted, self.order, near)
        return nearest_angles(wanted.reshape(-1, 4), self.letters, near.reshape(-1, near.shape[-1])).reshape(near.shape)


@dataclass(frozen=True, eq=False)
class _Moving:
    """A joint that has position channels: (m,) columns of a row, and (m,) which axis each is."""

    joint: int
    columns: Ints
    axes: Ints


class Channels:
    """Rows of a BVH file's channels."""

    def __init__(self, document: Document, part: Subskeleton, frame_time: float) -> None:
        """Set up the columns from a file's header.

        Args:
            document: unit, up axis, channels, and what positions are counted from.
            part: the joints that are worked on.
            frame_time: [s].
        """
        number = {joint: k for k, joint in enumerate(part.joints)}
        which = [k for k, channel in enumerate(document.channels) if channel.kind and channel.joint in number]
        channels = tuple(document.channels[k]._replace(joint=number[document.channels[k].joint]) for k in which)
        joints, own = list(part.joints), part.skeleton
        self._base, self._frame_time = document.base[joints], frame_time
        self._unit, self._up = document.unit_m, document.up
        still = Skeleton(
            own.names, own.parents, document.skeleton.offsets[joints], own.end_parents,
            own.end_offsets / document.unit_m, own.translates, own.rotates,
        )  # fmt: skip
        rest = to_clip(still, channels, np.zeros((1, len(channels))), self._base, frame_time)
        self._offsets = still.offsets[..., None]
        self._skeleton = placed(rest, self._unit, self._up).skeleton
        self._roots = np.flatnonzero(own.parents < 0) if self._up != "y" else np.zeros(0, dtype=np.intp)
        moves = [(which[k], c.joint, c.axis) for k, c in enumerate(channels) if c.kind == "P"]
        self._places = tuple(np.array(each, dtype=np.intp) for each in zip(*moves, strict=True)) if moves else ()
        self._turnings = _turnings(channels, which, own, range(len(own)), self._up)
        led = {each.joint for each in part.known.followers}
        turned = led | {
            joint
            for leg in part.known.rig.legs
            for joint in (leg.hip, leg.knee, leg.ankle, leg.toe)
            if joint is not None
        }
        self._written = [each for each in _turnings(channels, which, own, sorted(turned), self._up) if each.order]
        self._moving = [
            _Moving(joint, *(np.array(each, dtype=np.intp) for each in zip(*own_moves, strict=True)))
            for joint in sorted({part.known.rig.root, *led})
            if (own_moves := [(column, axis) for column, moved, axis in moves if moved == joint])
        ]

    def read(self, rows: Floats) -> Clip:
        """Read the motion of the part's joints from rows (n, C), in metres, y up."""
        block = np.ascontiguousarray(rows.T)
        joints, n = len(self._skeleton), len(rows)
        places, turns = np.empty((joints, 3, n)), np.empty((joints, 4, n))
        places[...] = self._offsets
        if self._places:
            columns, moved, axes = self._places
            places[moved, axes] = block[columns] + self._base[moved, axes][:, None]
        for each in self._turnings:
            if each.order:
                write_quaternions(np.deg2rad(block[each.columns.T]), each.order, turns, each.joints, slice(None))
            else:
                turns[each.joints] = rotation.identity()[:, None]
            if each.turn is not None:
                turned = rotation.multiply(each.turn, turns[each.joints].swapaxes(1, 2))
                turns[each.joints] = turned.swapaxes(1, 2)
        if self._unit != 1.0:
            places *= self._unit
        for root in self._roots.tolist():
            places[root] = permuted(places[root].T, AXES[self._up]).T
        return Clip.from_tracks(self._skeleton, places.transpose(2, 0, 1), turns.transpose(2, 0, 1), self._frame_time)

    def write(self, rows: Floats, before: Clip, after: Clip) -> Floats:
        """Write the motion `after` in place of `before` into rows (n, C): legs, followers and root."""
        out = rows.copy()
        for moved in self._moving:
            old, new = before.position(moved.joint), after.position(moved.joint)
            differs = (old != new) & np.isfinite(new)
            if not differs.any():
                continue
            new = new / self._unit
            if moved.joint in self._roots:
                back = AXES[self._up].T
                new, differs = permuted(new, back), permuted(differs.astype(np.float64), np.abs(back)) > 0.0
            new = new[:, moved.axes] - self._base[moved.joint, moved.axes]
            out[:, moved.columns] = np.where(differs[:, moved.axes], new, rows[:, moved.columns])
        for each in self._written:
            old, new = before.rotations[:, each.joints], after.rotations[:, each.joints]
            changed = ((old != new) & np.isfinite(new)).any(axis=-1, keepdims=True)  # (n, m, 1)
            if changed.any():
                own = rows[:, each.columns]
                out[:, each.columns] = np.where(changed, np.rad2deg(each.angles(new, np.deg2rad(own))), own)
        return out


def _turnings(
    channels: tuple[Channel, ...], which: list[int], skeleton: Skeleton, joints: Iterable[int], up: str
) -> list[_Turning]:
    """Group joints by the order of their rotation channels; roots separately where they are turned.

    Args:
        channels: of the part's joints.
        which: for each the column of a row.
        skeleton: the part's.
        joints: which ones.
        up: the file's upward axis.
    """
    turns = joint_channels(channels, len(skeleton), "R")
    groups: dict[tuple[tuple[int, ...], bool], list[int]] = {}
    for joint in joints:
        order = tuple(axis for _, axis in turns[joint])
        groups.setdefault((order, up != "y" and bool(skeleton.parents[joint] < 0)), []).append(joint)
    return [
        _Turning(
            order, np.array(group, dtype=np.intp),
            np.array([[which[k] for k, _ in turns[joint]] for joint in group], dtype=np.intp),
            rotation.from_matrix(AXES[up]) if root else None,
        )
        for (order, root), group in groups.items()
    ]  # fmt: skip


class Arrays:
    """Rows of positions (3 J), then rotations (4 J) of all joints of a skeleton."""

    def __init__(self, skeleton: Skeleton, part: Subskeleton, frame_time: float) -> None:
        """Set up the columns of a skeleton and the joints that are corrected."""
        joints, J = np.array(part.joints), len(skeleton)
        self._part, self._frame_time = part, frame_time
        self._places = joints[:, None] * 3 + np.arange(3)
        self._turns = 3 * J + joints[:, None] * 4 + np.arange(4)

    def read(self, rows: Floats) -> Clip:
        """Read the motion of the part's joints from rows (n, 7 J)."""
        columns = np.ascontiguousarray(rows.T)
        places, turns = (columns[which].transpose(2, 0, 1) for which in (self._places, self._turns))
        return Clip.from_tracks(self._part.skeleton, places, turns, self._frame_time)

    def write(self, rows: Floats, before: Clip, after: Clip) -> Floats:
        """Write the motion `after` in place of `before` into rows (n, 7 J)."""
        out = rows.copy()
        out[:, self._places], out[:, self._turns] = after.positions, after.rotations
        return out

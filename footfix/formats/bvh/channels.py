"""Convert channels to clips and back. Euler angles, file units and file axes exist only in this package."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from footfix.formats.bvh.tree import Channel
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats, Ints, Skeleton, constant_track, per_frame, same_track
from footfix.motion.threads import at_once

_BLOCK = 1 << 14  # rotations worked on together: their arrays stay in the cache of a core

# Each row is one axis of footfix (x, y up, z) in the file's axes; proper rotations, so nothing is mirrored.
AXES: dict[str, Floats] = {
    "y": np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]]),
    "-y": np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, -1]]),
    "z": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]),
    "-z": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "x": np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]),
    "-x": np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
}


def joint_channels(channels: Sequence[Channel], joints: int, kind: str) -> list[list[tuple[int, int]]]:
    """List for each joint its columns of a kind ("P" or "R") in order, as (column, axis)."""
    found: list[list[tuple[int, int]]] = [[] for _ in range(joints)]
    for column, channel in enumerate(channels):
        if channel.kind == kind:
            found[channel.joint].append((column, channel.axis))
    return found


def position_base(
    skeleton: Skeleton, channels: Sequence[Channel], column: Callable[[int], Floats], frames: int
) -> Floats:
    """Find the origin (J, 3) [file units] that the position channels of each joint are relative to.

    It is zero, since position channels replace the OFFSET. But where those of a joint below the root are zero in every
    frame and its OFFSET is not, the exporter wrote them relative to the OFFSET: else the bone would have no length.

    Args:
        skeleton: in the file's units and axes.
        channels: what each column is.
        column: the numbers (F,) of a column.
        frames: F.
    """
    base = np.zeros((len(skeleton), 3))
    for joint, columns in enumerate(joint_channels(channels, len(skeleton), "P")):
        below = columns and skeleton.parents[joint] >= 0 and skeleton.offsets[joint].any()
        if below and frames and not any(column(c)[0] or column(c).any() for c, _ in columns):
            base[joint] = skeleton.offsets[joint]
    return base


def to_clip(skeleton: Skeleton, channels: Sequence[Channel], values: Floats, base: Floats, frame_time: float) -> Clip:
    """Make a clip, in units and axes of the file, from the numbers of its rows.

    Position channels replace the OFFSET; an axis without a position channel keeps the OFFSET's value.

    Args:
        skeleton: in the file's units and axes.
        channels: what each column of `values` is.
        values: (F, C) as in the file: its units, degrees.
        base: (J, 3) the origin of each joint's positions, from `position_base`.
        frame_time: [s].
    """
    joints, frames = len(skeleton), len(values)
    moves = [(column, c.joint, c.axis) for column, c in enumerate(channels) if c.kind == "P"]
    places = [constant_track(offset, frames) for offset in skeleton.offsets]
    for moved in {joint for _, joint, _ in moves}:
        places[moved] = np.array(places[moved], order="F")
    rotations = np.empty((joints, 4, frames))
    orders: dict[tuple[int, ...], list[int]] = {}
    turns = joint_channels(channels, joints, "R")
    for joint, columns in enumerate(turns):
        orders.setdefault(tuple(axis for _, axis in columns), []).append(joint)
    size = max(64, _BLOCK // joints)

    def convert(start: int) -> None:
        block = np.ascontiguousarray(values[start : start + size].T)  # (C, frames of the block)
        span = slice(start, start + block.shape[1])
        for column, joint, axis in moves:
            places[joint][span, axis] = block[column] + base[joint, axis]
        for order, group in orders.items():
            if not order:
                rotations[group, :, span] = rotation.identity()[:, None]
            else:
                which = np.array([[column for column, _ in turns[joint]] for joint in group])
                write_quaternions(np.deg2rad(block[which.T]), order, rotations, group, span)

    at_once([partial(convert, start) for start in range(0, frames, size)], frames)
    return Clip.from_tracks(skeleton, places, rotations.transpose(2, 0, 1), frame_time)


def write_quaternions(
    angles: Floats, order: tuple[int, ...], out: Floats, group: Sequence[int] | Ints, span: slice
) -> None:
    """Write the quaternions of intrinsic angles (n, joints of the group, frames) [rad] into (J, 4, F)."""
    if sorted(order) != [0, 1, 2]:
        letters = "".join("XYZ"[axis] for axis in order)
        out[group, :, span] = np.moveaxis(rotation.from_euler(np.moveaxis(angles, 0, -1), letters), -1, 1)
        return
    i, j, k = order
    parity = 1.0 if (j - i) % 3 == 1 else -1.0
    half = 0.5 * angles
    (sa, sb, sc), (ca, cb, cc) = np.sin(half), np.cos(half)
    # q = q_i(a) q_j(b) q_k(c), multiplied out; parity is +1 where i, j, k is an even permutation of x, y, z
    sb_p, cacc, sasc, casc, sacc = parity * sb, ca * cc, sa * sc, ca * sc, sa * cc
    out[group, i, span] = sacc * cb + casc * sb_p
    out[group, j, span] = cacc * sb - parity * (sasc * cb)
    out[group, k, span] = casc * cb + sacc * sb_p
    out[group, 3, span] = cacc * cb - sasc * sb_p


def check_unit_and_up(unit_m: float, up: str) -> None:
    """Check that the unit [m] and the upward axis are valid.

    Raises:
        ValueError: one of them is not.
    """
    if up not in AXES:
        raise ValueError(f"up must be one of {', '.join(AXES)}, not {up!r}")
    if not 0.0 < unit_m < float("inf"):
        raise ValueError(f"unit_m must be positive, not {unit_m}")


def placed(clip: Clip, unit_m: float, up: str) -> Clip:
    """Convert a clip from file units and axes to metres and y up."""
    return _transformed(clip, unit_m, AXES[up])


def displaced(clip: Clip, unit_m: float, up: str) -> Clip:
    """Convert a clip from metres and y up to file units and axes: undo `placed`."""
    return _transformed(clip, 1.0 / unit_m, AXES[up].T)


def _transformed(clip: Clip, unit_m: float, axes: Floats) -> Clip:
    """Scale all lengths and turn the root joints; arrays that don't change are shared with the input."""
    skeleton, roots = clip.skeleton, np.flatnonzero(clip.skeleton.parents < 0)
    places, rotations, offsets = [clip.position(j) for j in range(len(skeleton))], clip.rotations, skeleton.offsets
    if unit_m != 1.0:
        places = [per_frame(lambda place: place * unit_m, each) for each in places]
        offsets = offsets * unit_m
    if not np.array_equal(axes, AXES["y"]):
        turn = rotation.from_matrix(axes)
        rotations, offsets = rotations.copy(order="K"), offsets.copy()
        for root in roots.tolist():
            places[root] = per_frame(lambda place: permuted(place, axes), places[root])
            offsets[root] = permuted(offsets[root], axes)
            rotations[:, root] = rotation.multiply(turn, rotations[:, root])
    skeleton = replace(skeleton, offsets=offsets, end_offsets=skeleton.end_offsets * unit_m)
    return Clip.from_tracks(skeleton, places, rotations, clip.frame_time)


def permuted(vectors: Floats, axes: Floats) -> Floats:
    """Compute `axes @ vectors` for a matrix of 0, 1 and -1: exact to the last bit, and never -0."""
    source = np.argmax(np.abs(axes), axis=1)
    return np.asarray(vectors[..., source] * axes[np.arange(3), source] + 0.0)


@dataclass(frozen=True, eq=False)
class Change:
    """The new numbers of one column.

    Args:
        column: its index.
        frames: (F,) True in the frames that change.
        values: (F,) [file units, or degrees] the new numbers; meaningless in frames that don't change.
    """

    column: int
    frames: Bools
    values: Floats


def changes(
    channels: Sequence[Channel], values: Floats, base: Floats, old: Clip, new: Clip, unit_m: float, up: str
) -> Iterator[Change]:
    """Find the numbers to write so that the file holds the motion `new` in place of `old`.

    A joint's rotation is written on the Euler branch nearest to the file's own angles in the same frame. Changes that
    a joint has no channels for are left out; one or two rotation channels get the nearest rotation that they can make.

    Args:
        channels: what each column of `values` is.
        values: (F, C) of the file.
        base: (J, 3) the origin of its positions, from `position_base`.
        old: the clip that the file holds [m], y up.
        new: the clip to be written, of the same skeleton and number of frames.
        unit_m: metres in a unit of the file.
        up: the file's upward axis.
    """
    joints = len(old.skeleton)
    moves, turns = joint_channels(channels, joints, "P"), joint_channels(channels, joints, "R")
    for joint in range(joints):
        axes = AXES[up] if old.skeleton.parents[joint] < 0 else AXES["y"]
        if moves[joint] and not same_track(old.position(joint), new.position(joint)):
            for change in _moved(moves[joint], old.position(joint), new.position(joint), unit_m, axes):
                yield replace(change, values=change.values - base[joint, channels[change.column].axis])
        if turns[joint] and not same_track(old.rotation(joint), new.rotation(joint)):
            turned: Bools = np.asarray(_differs(old.rotation(joint), new.rotation(joint)).any(axis=1))
            if turned.any():
                yield from _turned(turns[joint], values, turned, new.rotation(joint)[turned], axes)


def _differs(old: Floats, new: Floats) -> Bools:
    return np.asarray((old != new) & np.isfinite(new))


def _moved(columns: list[tuple[int, int]], old: Floats, new: Floats, unit_m: float, axes: Floats) -> Iterator[Change]:
    differs = _differs(old, new)
    if not differs.any():
        return
    back = permuted(new / unit_m, axes.T)
    moved = permuted(differs.astype(np.float64), np.abs(axes.T)) > 0.0
    for column, axis in columns:
        if moved[:, axis].any():
            yield Change(column, moved[:, axis], back[:, axis])


def _turned(
    columns: list[tuple[int, int]], values: Floats, frames: Bools, wanted: Floats, axes: Floats
) -> Iterator[Change]:
    if not np.array_equal(axes, AXES["y"]):
        wanted = rotation.multiply(rotation.inverse(rotation.from_matrix(axes)), wanted)
    order = "".join("XYZ"[axis] for _, axis in columns)
    near = np.deg2rad(np.stack([values[:, column][frames] for column, _ in columns], axis=1))
    if sorted(order) == ["X", "Y", "Z"]:
        angles = rotation.to_euler(wanted, order, near=near)
    else:
        angles = nearest_angles(wanted, order, near)
    for k, (column, _) in enumerate(columns):
        whole = np.zeros(len(frames))
        whole[frames] = np.rad2deg(angles[:, k])
        yield Change(column, frames, whole)


def nearest_angles(q: Floats, order: str, near: Floats, sweeps: int = 40) -> Floats:
    """Find the angles (N, n) [rad] whose rotation comes nearest to `q` (N, 4), for an order of any axes.

    One angle at a time is optimised while the others are held: for `A R(angle) B` nearest to `q` the best angle is
    twice the arc tangent of the axis component of `A^-1 q B^-1` over its real part. For one axis this is exact.
    """
    angles = near.copy()
    for _ in range(1 if len(order) == 1 else sweeps):
        for k, letter in enumerate(order):
            before = rotation.from_euler(angles[:, :k], order[:k])
            after = rotation.from_euler(angles[:, k + 1 :], order[k + 1 :])
            rest = rotation.multiply(rotation.multiply(rotation.inverse(before), q), rotation.inverse(after))
            best = 2.0 * np.arctan2(rest[:, "XYZ".index(letter)], rest[:, 3])
            angles[:, k] = best - 2.0 * np.pi * np.round((best - near[:, k]) / (2.0 * np.pi))
    return angles

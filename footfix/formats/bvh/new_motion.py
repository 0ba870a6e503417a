"""A BVH file with new motion: the header of an existing file, and rows written from another clip of its skeleton."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from footfix.formats.bvh.channels import changes, joint_channels
from footfix.formats.bvh.document import Document
from footfix.formats.bvh.fixed_point import fixed
from footfix.formats.bvh.numbers import decimals
from footfix.formats.bvh.select_frames import header_for
from footfix.formats.bvh.splice import LEAST_DECIMALS, row_blocks
from footfix.motion.clip import Clip, Floats, Ints

_BLOCK = 1024  # rows formatted together


def with_motion(document: Document, frames: Ints, clip: Clip) -> bytes:
    """Write a file of a clip of the same skeleton.

    Where the clip's values equal the file's, the file's own numbers are written. Angles are continuous from frame to
    frame, and may pass 360 degrees.

    Args:
        document: the file whose header is kept.
        frames: (F,) for each frame of the clip, the index of the file's frame that it comes from.
        clip: F frames [m], y up.
    """
    values = document.values[frames].copy()
    old = document.clip.frames(frames)
    with np.errstate(invalid="ignore"):
        found = changes(document.channels, values, document.base, old, clip, document.unit_m, document.up)
        for change in list(found):
            values[change.frames, change.column] = change.values[change.frames]
    for columns in joint_channels(document.channels, len(document.skeleton), "R"):
        axes = "".join("XYZ"[axis] for _, axis in columns)
        own = [column for column, _ in columns]
        if columns:
            values[:, own] = continuous_angles(values[:, own], sorted(axes) == ["X", "Y", "Z"])
    head, newline = header_for(document, len(frames))
    text = head + b"".join(_lines(np.nan_to_num(values), _places(document), newline))
    if document.rows.comma:
        text = head + text[len(head) :].replace(b".", b",")
    return text.decode("utf-8").encode(document.encoding) if document.encoding else text


def continuous_angles(angles: Floats, three: bool) -> Floats:
    """Find Euler angles (F, n) [degrees] of the same rotations that are continuous from frame to frame.

    About three different axes a rotation has two sets of angles; the set nearer to the previous frame's is taken.
    Whether to switch sets between two frames does not depend on the set in use, so the choice is a running sum.
    """
    if three:
        other = np.stack([angles[:, 0] + 180.0, 180.0 - angles[:, 1], angles[:, 2] + 180.0], axis=1)
        over = _turn(other[1:] - angles[:-1]) < _turn(np.diff(angles, axis=0))
        if over.any():
            angles = np.where((np.cumsum(np.append(False, over)) % 2 == 1)[:, None], other, angles)
    step = np.diff(angles, axis=0)
    laps = np.cumsum(np.round(step / 360.0), axis=0)
    return np.asarray(angles - 360.0 * np.concatenate([np.zeros((1, angles.shape[1])), laps]))


def _turn(step: Floats) -> Floats:
    return np.asarray(np.abs(step - 360.0 * np.round(step / 360.0)).sum(axis=1))


def _places(document: Document) -> int:
    """Choose how many decimals to write: as many as the file's own numbers, and at least `LEAST_DECIMALS`."""
    block = next(row_blocks(document.rows), None)
    if block is None:
        return LEAST_DECIMALS
    _, starts, ends = block
    return max(LEAST_DECIMALS, min(int(decimals(document.rows.text, starts, ends).max(initial=0)), 12))


def _lines(values: Floats, places: int, newline: bytes) -> Iterator[bytes]:
    for start in range(0, len(values), _BLOCK):
        some = values[start : start + _BLOCK]
        letters = fixed(some.ravel(), places)
        cells = np.full((*some.shape, letters.shape[1] + 1), ord(" "), dtype=np.uint8)
        cells[..., :-1] = letters.reshape(*some.shape, -1)
        cells[:, -1, -1] = ord("\n")
        yield cells.tobytes().translate(None, b"\0").replace(b"\n", newline)

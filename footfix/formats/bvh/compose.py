"""A BVH file written from scratch, for a clip that was made from arrays rather than read from a file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from footfix.formats.bvh.fixed_point import fixed
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Skeleton

_ORDER = "ZXY"  # gimbal lock when a joint is raised sideways by 90 degrees: rare in hips and legs
_ROTATIONS = ("Zrotation", "Xrotation", "Yrotation")
_POSITIONS = ("Xposition", "Yposition", "Zposition")
_DECIMALS = 6
_BLOCK = 1024  # rows formatted together


def compose(clip: Clip, *, unit_m: float = 0.01) -> bytes:
    """Write a clip as a BVH file, y up.

    Args:
        clip: F frames of J joints [m]. All rotations are written, also of joints whose skeleton says they have none.
        unit_m: [m] unit of the file, centimetres by default.
    """
    skeleton = clip.skeleton
    channels = [[*_POSITIONS, *_ROTATIONS] if moves else list(_ROTATIONS) for moves in skeleton.translates.tolist()]
    scaled = replace(skeleton, offsets=skeleton.offsets / unit_m, end_offsets=skeleton.end_offsets / unit_m)
    lines, order = hierarchy_lines(scaled, channels, _numbers)
    lines += motion_lines(len(clip), clip.frame_time)
    return b"\n".join(lines) + b"\n" + b"".join(_rows(clip, order, unit_m))


def motion_lines(frames: int, frame_time: float) -> list[bytes]:
    """Write the headings of the MOTION part."""
    seconds = np.format_float_positional(frame_time, trim="0").encode()
    return [b"MOTION", b"Frames: %d" % frames, b"Frame Time: " + seconds]


def hierarchy_lines(
    skeleton: Skeleton, channels: Sequence[Sequence[str]], number: Callable[[Floats], bytes]
) -> tuple[list[bytes], list[int]]:
    """Write the lines of a hierarchy; list the joints in the order in which they are written: depth first.

    Args:
        skeleton: in units of the file.
        channels: the names of each joint's channels.
        number: writes an offset.
    """
    lines, order, ends = [b"HIERARCHY"], list[int](), dict[int, list[Floats]]()
    for joint, offset in zip(skeleton.end_parents.tolist(), skeleton.end_offsets, strict=True):
        ends.setdefault(joint, []).append(offset)
    stack = [(root, 0, False) for root in reversed(np.flatnonzero(skeleton.parents < 0).tolist())]
    while stack:
        joint, depth, closing = stack.pop()
        indent = b"\t" * depth
        if closing:
            lines.append(indent + b"}")
            continue
        order.append(joint)
        name = " ".join(skeleton.names[joint].replace("{", "(").replace("}", ")").split()).encode("utf-8", "replace")
        lines += [indent + (b"JOINT " if depth else b"ROOT ") + name, indent + b"{"]
        lines.append(indent + b"\tOFFSET " + number(skeleton.offsets[joint]))
        lines.append(indent + " ".join(["\tCHANNELS", str(len(channels[joint])), *channels[joint]]).encode())
        for end in ends.get(joint, ()):
            lines += [indent + b"\tEnd Site", indent + b"\t{"]
            lines += [indent + b"\t\tOFFSET " + number(end), indent + b"\t}"]
        stack.append((joint, depth, True))
        stack += [(child, depth + 1, False) for child in reversed(skeleton.children[joint])]
    return lines, order


def _numbers(values: Floats) -> bytes:
    return b" ".join(row.tobytes().replace(b"\0", b"") for row in fixed(np.asarray(values), _DECIMALS))


def _rows(clip: Clip, order: list[int], unit_m: float) -> list[bytes]:
    columns = []
    for joint in order:
        if clip.skeleton.translates[joint]:
            columns += list((clip.positions[:, joint] / unit_m).T)
        columns += list(np.rad2deg(smooth_euler(clip.rotations[:, joint], _ORDER)).T)
    blocks = []
    for start in range(0, len(clip), _BLOCK):
        values = np.stack([column[start : start + _BLOCK] for column in columns], axis=1)
        letters = fixed(values.ravel(), _DECIMALS)
        cells = np.full((*values.shape, letters.shape[1] + 1), ord(" "), dtype=np.uint8)
        cells[..., :-1] = letters.reshape(*values.shape, -1)
        cells[:, -1, -1] = ord("\n")
        blocks.append(cells.tobytes().translate(None, b"\0"))
    return blocks


def smooth_euler(q: Floats, order: str) -> Floats:
    """Find Euler angles (F, 3) [rad] of rotations (F, 4) that are continuous from frame to frame.

    Each rotation has two sets of angles; the set nearer to the previous frame's is taken. Whether to switch sets
    between two frames does not depend on the set in use, so the choice is a running sum.
    """
    first = rotation.to_euler(q, order)
    second = np.stack([first[:, 0] + np.pi, np.pi - first[:, 1], first[:, 2] + np.pi], axis=1)
    over = _turn(second[1:] - first[:-1]) < _turn(first[1:] - first[:-1])
    other = np.concatenate([[False], np.cumsum(over) % 2 == 1])
    return np.asarray(np.unwrap(np.where(other[:, None], second, first), axis=0))


def _turn(step: Floats) -> Floats:
    return np.asarray(np.abs(step - 2.0 * np.pi * np.round(step / (2.0 * np.pi))).sum(axis=1))

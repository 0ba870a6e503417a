"""What the rows of a stream say: channels of a BVH file, or positions and rotations of all joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footfix.formats.bvh.channels import changes, placed, to_clip
from footfix.formats.bvh.document import Document
from footfix.motion.clip import Clip, Floats, Skeleton
from footfix.stream.part import Part


class Channels:
    """Rows of a BVH file's channels."""

    def __init__(self, document: Document, part: Part, frame_time: float) -> None:
        """Know the file by its header, placed.

        Args:
            document: unit, up axis, channels, and what positions are counted from.
            part: the joints that are worked on.
            frame_time: [s].
        """
        number = {joint: k for k, joint in enumerate(part.joints)}
        which = [k for k, channel in enumerate(document.channels) if channel.kind and channel.joint in number]
        self._columns = np.array(which, dtype=np.intp)
        self._channels = tuple(
            document.channels[k]._replace(joint=number[document.channels[k].joint]) for k in which
        )
        joints = list(part.joints)
        whole, own = document.skeleton, part.skeleton
        self._skeleton = replace(
            own, offsets=whole.offsets[joints], end_offsets=own.end_offsets / document.unit_m,
        )  # fmt: skip
        self._base, self._frame_time = document.base[joints], frame_time
        self._unit, self._up = document.unit_m, document.up

    def read(self, rows: Floats) -> Clip:
        """The motion of the part's joints of rows (n, C) [m], y up."""
        own = to_clip(self._skeleton, self._channels, rows[:, self._columns], self._base, self._frame_time)
        return own if self._unit == 1.0 and self._up == "y" else placed(own, self._unit, self._up)

    def write(self, rows: Floats, before: Clip, after: Clip) -> Floats:
        """(n, C) the rows with the motion `after` in place of `before`."""
        out, own = rows.copy(), rows[:, self._columns]
        for change in changes(self._channels, own, self._base, before, after, self._unit, self._up):
            out[change.frames, self._columns[change.column]] = change.values[change.frames]
        return out


class Arrays:
    """Rows of positions (3 J), then rotations (4 J) of all joints of a skeleton."""

    def __init__(self, skeleton: Skeleton, part: Part, frame_time: float) -> None:
        """Know the skeleton, and the joints of it that are worked on."""
        joints, J = np.array(part.joints), len(skeleton)
        self._part, self._frame_time = part, frame_time
        self._places = joints[:, None] * 3 + np.arange(3)
        self._turns = 3 * J + joints[:, None] * 4 + np.arange(4)

    def read(self, rows: Floats) -> Clip:
        """The motion of the part's joints of rows (n, 7 J)."""
        places, turns = (
            [np.ascontiguousarray(rows[:, each].T).T for each in which] for which in (self._places, self._turns)
        )
        return Clip.from_tracks(self._part.skeleton, places, turns, self._frame_time)

    def write(self, rows: Floats, before: Clip, after: Clip) -> Floats:
        """(n, 7 J) the rows with the motion `after` in place of `before`."""
        out = rows.copy()
        for k in range(len(self._part.joints)):
            out[:, self._places[k]] = after.position(k)
            out[:, self._turns[k]] = after.rotation(k)
        return out

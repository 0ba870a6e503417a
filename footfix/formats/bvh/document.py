"""A BVH file as a value: its text, its numbers, and what they mean.

BVH has no written standard: a file is read as its author most likely meant it, every assumption is noted, and the text
is kept as it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footfix.formats.bvh.channels import check_unit_and_up, displaced, to_clip
from footfix.formats.bvh.channels import placed as in_metres
from footfix.formats.bvh.rows import Rows
from footfix.formats.bvh.tree import Channel
from footfix.motion.clip import Bools, Clip, Floats, Skeleton
from footfix.notes import Note


@dataclass(frozen=True, eq=False)
class Document:
    """One BVH file.

    Args:
        name: of the file, for messages.
        text: the bytes of the file; of a UTF-16 file, its text as UTF-8.
        encoding: the encoding to write the text in, such as "utf-16-le"; empty where `text` is the file itself.
        skeleton: in the file's units and axes.
        channels: what each column of the rows is.
        rows: the numbers, and where they stand.
        frame_time: [s]; a plausible one where the file's own makes no sense.
        notes: what was assumed, and what is wrong.
        base: (J, 3) [file units] the origin of each joint's position channels.
        motion_at: where in the text the MOTION part begins.
        unit_m: [m] one unit of the file.
        up: the file's upward axis: "y", "-y", "z", "-z", "x" or "-x".
    """

    name: str
    text: bytes
    encoding: str
    skeleton: Skeleton
    channels: tuple[Channel, ...]
    rows: Rows
    frame_time: float
    notes: tuple[Note, ...]
    base: Floats
    motion_at: int
    unit_m: float = 1.0
    up: str = "y"

    metric = False  # nothing says what a BVH is in
    start = 0.0  # [s]
    skin = None  # a BVH has no mesh

    @property
    def values(self) -> Floats:
        """Get the numbers of the rows (F, C), in the file's units and degrees."""
        return self.rows.values

    @property
    def moved(self) -> Bools:
        """Mark the joints (J,) that the file may move: all."""
        return np.ones(len(self.skeleton), np.bool_)

    @property
    def frames(self) -> int:
        """Count the rows of motion."""
        return len(self.rows.values)

    @property
    def columns(self) -> int:
        """Count the numbers of a row."""
        return int(self.rows.values.shape[1]) if self.rows.values.ndim == 2 else 0

    @property
    def unusable(self) -> tuple[Note, ...]:
        """List the notes that say why nothing can be done with this motion; empty for a sound file."""
        return tuple(note for note in self.notes if note.severity == "error")

    @cached_property
    def file_clip(self) -> Clip:
        """Get the motion in the file's units and axes."""
        with np.errstate(invalid="ignore"):
            return to_clip(self.skeleton, self.channels, self.values, self.base, self.frame_time)

    @cached_property
    def clip(self) -> Clip:
        """Get the motion in metres, y up."""
        if self.unit_m == 1.0 and self.up == "y":
            return self.file_clip
        found = in_metres(self.file_clip, self.unit_m, self.up)
        self.__dict__.pop("file_clip", None)  # rarely needed again, and half as large as the file
        return found

    def in_file(self, clip: Clip) -> Clip:
        """Convert a clip from metres, y up, to the file's units and axes."""
        return displaced(clip, self.unit_m, self.up)

    def placed(self, *, unit_m: float | None = None, up: str | None = None) -> Document:
        """Return the same file read with another unit [m] and upward axis."""
        unit_m, up = self.unit_m if unit_m is None else unit_m, self.up if up is None else up
        check_unit_and_up(unit_m, up)
        document = replace(self, unit_m=unit_m, up=up)
        if "file_clip" in self.__dict__:
            document.__dict__["file_clip"] = self.file_clip
        return document

"""BVH files: read without loss, written with only those numbers new that had to change.

A `Document` keeps the text of the file. Nobody wrote a standard for BVH, so it is read as a person would mean
it, and every assumption is a note; what has no meaning is refused, saying where and why.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footfix.errors import InputError
from footfix.formats import bvh_channels
from footfix.formats.bvh_again import said_again
from footfix.formats.bvh_compose import compose
from footfix.formats.bvh_doubts import frame_time, look_over
from footfix.formats.bvh_hierarchy import read_hierarchy
from footfix.formats.bvh_motion import Headings, read_headings, read_rows
from footfix.formats.bvh_numbers import number
from footfix.formats.bvh_rows import Rows
from footfix.formats.bvh_text import Cursor, Limits, Notes, refuse_strangers, unmask
from footfix.formats.bvh_tree import Channel, Hierarchy
from footfix.formats.bvh_write import Columns, splice
from footfix.motion.clip import Clip, Floats, Skeleton, frozen
from footfix.notes import Note

__all__ = ["Document", "Limits", "compose", "decode", "encode", "glance"]

_LIMITS = Limits()
_MOTION = re.compile(rb"motion|frame", re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class Document:
    """One BVH file.

    Args:
        name: of the file, for messages.
        text: the file as bytes in which words can be found (UTF-16 becomes UTF-8).
        encoding: what the text is to be encoded in again; empty where it is the file itself.
        skeleton: in the file's units and axes.
        channels: what each column of the rows is.
        rows: the numbers, and where they stand.
        frame_time: [s]; a plausible one where the file's own makes no sense.
        notes: what was assumed, and what is wrong.
        base: (J, 3) what position channels are counted from, in file units.
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

    @property
    def values(self) -> Floats:
        """(F, C) the numbers of the rows, in the file's units and degrees."""
        return self.rows.values

    @property
    def unusable(self) -> tuple[Note, ...]:
        """The notes that say why nothing can be done with this motion; empty for a sound file."""
        return tuple(note for note in self.notes if note.severity == "error")

    @cached_property
    def file_clip(self) -> Clip:
        """The motion in the file's units and axes."""
        with np.errstate(invalid="ignore"):
            return bvh_channels.to_clip(self.skeleton, self.channels, self.values, self.base, self.frame_time)

    @cached_property
    def clip(self) -> Clip:
        """The motion in metres, y up. With `unit_m` and `up` as they come, it is the `file_clip`."""
        if self.unit_m == 1.0 and self.up == "y":
            return self.file_clip
        found = bvh_channels.placed(self.file_clip, self.unit_m, self.up)
        self.__dict__.pop("file_clip", None)  # hardly asked for again, and half as large as the file
        return found

    def in_file(self, clip: Clip) -> Clip:
        """A clip in metres, y up, in the file's units and axes."""
        return bvh_channels.displaced(clip, self.unit_m, self.up)

    def placed(self, *, unit_m: float | None = None, up: str | None = None) -> Document:
        """The same file, with another belief about its unit and its upward axis."""
        unit_m, up = self.unit_m if unit_m is None else unit_m, self.up if up is None else up
        if up not in bvh_channels.AXES:
            raise ValueError(f"up must be one of {', '.join(bvh_channels.AXES)}, not {up!r}")
        if not 0.0 < unit_m < float("inf"):
            raise ValueError(f"unit_m must be positive, not {unit_m}")
        document = replace(self, unit_m=unit_m, up=up)
        if "file_clip" in self.__dict__:
            document.__dict__["file_clip"] = self.file_clip
        return document


def decode(data: bytes, *, name: str = "", limits: Limits = _LIMITS) -> Document:
    """Reads a BVH file.

    Args:
        data: the file.
        name: what it is called in errors.
        limits: beyond these it is refused.

    Raises:
        InputError: it is no BVH, or damaged beyond reading; with line and column.
    """
    try:
        return _decode(data, name, limits)
    except InputError as error:
        raise (error.within(name) if name and not error.file else error) from None


def glance(head: bytes, *, limits: Limits = _LIMITS) -> None:
    """Looks at the first bytes of a large file, so that gigabytes of something else need not be read.

    Args:
        head: the first bytes.
        limits: if there are as many as a header may have, the motion must have begun in them.

    Raises:
        InputError: whatever follows, it will be refused.
    """
    refuse_strangers(head)
    wide = head.startswith((b"\xff\xfe", b"\xfe\xff"))
    if len(head) >= limits.header and not wide and not _MOTION.search(head):
        raise InputError(f"there is no MOTION in the first {limits.header} bytes", hint="limits.header allows more")


def encode(document: Document, clip: Clip | None = None) -> bytes:
    """Writes the file with the motion of `clip`.

    Where `clip` has the very numbers of `document.clip`, the text stays as it is to the byte. Elsewhere the
    numbers of the channels that changed are replaced: with the file's own decimals and at least 6, without
    exponents, on the Euler branch nearest to the file's own angles.

    Args:
        document: the file.
        clip: F frames of its joints [m], y up; by default nothing changes.
    """
    text = document.text if clip is None else _spliced(document, clip)[0]
    return _encoded(document, text)


def rewrite(document: Document, clip: Clip, *, limits: Limits = _LIMITS) -> tuple[bytes, Clip]:
    """Writes the file with the motion of `clip`, as `encode` does, and says what reading it again will find.

    Args:
        document: the file.
        clip: F frames of its joints [m], y up.
        limits: beyond these it can't be read again.

    Returns:
        The file, and the motion in it [m], y up; `document.clip` itself where nothing changed.
    """
    text, said = _spliced(document, clip)
    written = _encoded(document, text)
    if text == document.text:
        return written, document.clip
    with np.errstate(invalid="ignore"):
        again = said_again(document, said)
    if again is None:
        read = decode(written, name=document.name, limits=limits)
        again = read.placed(unit_m=document.unit_m, up=document.up).clip
    return written, again


def _encoded(document: Document, text: bytes) -> bytes:
    return text.decode("utf-8").encode(document.encoding) if document.encoding else text


def _spliced(document: Document, clip: Clip) -> tuple[bytes, Columns]:
    """The text with the motion of `clip`, and what it says in the columns that changed."""
    old, rows = document.clip, document.rows
    if clip is old:
        return document.text, {}
    if (len(clip), len(clip.skeleton)) != (len(old), len(old.skeleton)):
        of = [f"{len(each)} frames of {len(each.skeleton)} joints" for each in (clip, old)]
        raise ValueError(f"the clip has {of[0]}, the file {of[1]}")
    with np.errstate(invalid="ignore"):  # numbers that are none stay as they stand
        found = bvh_channels.changes(
            document.channels, rows.values, document.base, old, clip, document.unit_m, document.up
        )
        return splice(document.text, rows, list(found))


def _decode(data: bytes, name: str, limits: Limits) -> Document:
    if len(data) > limits.bytes:
        raise InputError(f"{len(data)} bytes, more than {limits.bytes}", hint="limits.bytes allows more")
    notes = Notes()
    notes.text = data
    text, encoding = unmask(data, notes)
    notes.text = text
    cursor = Cursor(text, notes)
    tree = read_hierarchy(cursor, limits)
    headings = read_headings(cursor)
    rows = _fit(cursor, tree, headings, limits)
    seconds = frame_time(headings, notes)
    skeleton = tree.skeleton()
    base = bvh_channels.position_base(
        skeleton, tree.channels, lambda column: rows.values[:, column], len(rows.values)
    )
    look_over(tree, skeleton, headings, rows, base, notes)
    return Document(
        name=name,
        text=text,
        encoding=encoding,
        skeleton=skeleton,
        channels=tuple(tree.channels),
        rows=replace(rows, values=frozen(rows.values)),
        frame_time=seconds,
        notes=tuple(sorted(notes.found, key=lambda note: (note.line or 0, note.column or 0))),
        base=frozen(base),
        motion_at=headings.at,
    )


def _fit(cursor: Cursor, tree: Hierarchy, headings: Headings, limits: Limits) -> Rows:
    """Reads the rows, and settles by them what the channels are.

    A row may have the channels of End Sites, or do without. Where the count after CHANNELS is not that of the
    names, rows of as many numbers as there are names settle it; else it is what's wrong with the file.
    """
    columns = len(tree.channels)
    layouts = [columns, columns - len(tree.end_channels)] if tree.end_channels else [columns]
    declared = number(headings.frames or b"")
    count = int(declared) if declared is not None and declared.is_integer() else None
    try:
        rows = read_rows(cursor, layouts, count, limits.frames)
    except InputError:
        if tree.miscounts:
            raise _miscount(cursor, tree) from None
        raise
    if rows.values.shape[1] != columns:
        dead = set(tree.end_channels)
        tree.channels = [channel for k, channel in enumerate(tree.channels) if k not in dead]
    if tree.miscounts:
        error = _miscount(cursor, tree)
        if not len(rows.values):
            raise error
        more = f", and so {len(tree.miscounts) - 1} more times" if len(tree.miscounts) > 1 else ""
        what = f"{error.what}{more}; the rows agree with the names"
        cursor.notes.add("channel-count", what, "warning", at=tree.miscounts[0][0])
    return rows


def _miscount(cursor: Cursor, tree: Hierarchy) -> InputError:
    at, said, named = tree.miscounts[0]
    what = f"CHANNELS says {said}, {named} names follow"
    return cursor.fail(what, at=at, hint="make the count agree with the names")

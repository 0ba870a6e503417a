"""Reading BVH: without loss, as its author most likely meant it; an error says where and why a file can't be read."""

from __future__ import annotations

import re
from dataclasses import replace

from footfix.errors import InputError
from footfix.formats.bvh.channels import position_base
from footfix.formats.bvh.document import Document
from footfix.formats.bvh.hierarchy import read_hierarchy
from footfix.formats.bvh.motion import Headings, read_headings, read_rows
from footfix.formats.bvh.numbers import number
from footfix.formats.bvh.oddities import frame_time, look_over
from footfix.formats.bvh.rows import Rows
from footfix.formats.bvh.text import Cursor, Limits, Notes, refuse_other_formats, searchable_text
from footfix.formats.bvh.tree import Hierarchy
from footfix.motion.clip import frozen

_LIMITS = Limits()
_MOTION = re.compile(rb"motion|frame", re.IGNORECASE)


def decode(data: bytes, *, name: str = "", limits: Limits = _LIMITS) -> Document:
    """Read a BVH file.

    Args:
        data: the file.
        name: what it is called in errors.
        limits: a file beyond them is refused.

    Raises:
        InputError: it is not BVH, or too damaged to read; with line and column.
    """
    try:
        return _decode(data, name, limits)
    except InputError as error:
        raise (error.within(name) if name and not error.file else error) from None


def glance(head: bytes, *, limits: Limits = _LIMITS) -> None:
    """Check the first bytes of a large file, so that gigabytes of something else need not be read.

    Args:
        head: the first bytes.
        limits: a head as long as `limits.header` must contain the beginning of the motion.

    Raises:
        InputError: the file will be refused, whatever follows.
    """
    refuse_other_formats(head)
    wide = head.startswith((b"\xff\xfe", b"\xfe\xff"))
    if len(head) >= limits.header and not wide and not _MOTION.search(head):
        raise InputError(f"there is no MOTION in the first {limits.header} bytes", hint="limits.header allows more")


def _decode(data: bytes, name: str, limits: Limits) -> Document:
    if len(data) > limits.bytes:
        raise InputError(f"{len(data)} bytes, more than {limits.bytes}", hint="limits.bytes allows more")
    notes = Notes()
    notes.text = data
    text, encoding = searchable_text(data, notes)
    notes.text = text
    cursor = Cursor(text, notes)
    tree = read_hierarchy(cursor, limits)
    headings = read_headings(cursor)
    rows = _fit(cursor, tree, headings, limits)
    seconds = frame_time(headings, notes)
    skeleton = tree.skeleton()
    base = position_base(skeleton, tree.channels, lambda column: rows.values[:, column], len(rows.values))
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
    """Read the rows, and decide by their length what the channels are.

    Rows may hold the channels of End Sites or leave them out. Where the count after CHANNELS differs from the number
    of names, rows as long as there are names decide for the names; else the count is reported as the error.
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

"""The MOTION part: its two headings, and its rows."""

from __future__ import annotations

import re
from dataclasses import dataclass
from io import BytesIO

import numpy as np

from footfix.formats.bvh.numbers import number
from footfix.formats.bvh.plain_rows import read_plain
from footfix.formats.bvh.rows import Rows
from footfix.formats.bvh.text import Cursor

_HEADING = re.compile(
    rb"[ \t]*(?:(?P<time>frame[ \t_]*time)|frames?(?:[ \t_]*count)?)\b[ \t]*[:=]?[ \t]*(?P<value>[^\s:=]*)",
    re.IGNORECASE,
)
_NEXT_ON_LINE = re.compile(rb"[ \t]*(\S{0,400})")
_USUAL_HEADING = re.compile(rb"\s*(?:Frames:|Frame Time:)[ \t]+\S+")


@dataclass
class Headings:
    """What `Frames:` and `Frame Time:` say, as text; None where the line is missing."""

    frames: bytes | None = None
    frames_at: int = 0
    time: bytes | None = None
    time_at: int = 0
    at: int = 0  # where the MOTION part begins


def read_headings(cursor: Cursor) -> Headings:
    """Read `MOTION`, `Frames:` and `Frame Time:` in any order and spelling; leave the cursor at the rows."""
    headings, notes = Headings(at=cursor.start), cursor.notes
    word = cursor.peek()
    odd = [] if word == b"MOTION" else [cursor.start]
    if word.upper() == b"MOTION":
        cursor.take()
    else:
        notes.add("motion-keyword-missing", "the word MOTION is missing", at=cursor.start)
        odd.clear()
    while cursor.peek() and (found := _HEADING.match(cursor.text, cursor.start)):
        value = found["value"]
        if value and (b"," in value or b"/" in value or not _USUAL_HEADING.fullmatch(found[0])):
            odd.append(cursor.start)
        if found["time"]:
            headings.time, headings.time_at = value, found.start("value")
        else:
            headings.frames, headings.frames_at = value, found.start("value")
        cursor.pos = found.end()
        after = _NEXT_ON_LINE.match(cursor.text, cursor.pos)
        word = after[1] if after else b""
        if number(word) is None and word[:5].lower() != b"frame":
            cursor.line()  # else the next heading, or the rows, go on in the same line
    if odd:
        notes.add("heading-spelling", "a heading is spelled in a way that strict readers don't know", at=odd[0])
    return headings


def read_rows(cursor: Cursor, layouts: list[int], declared: int | None, max_frames: int) -> Rows:
    """Read the rows.

    Args:
        cursor: stands where the rows begin.
        layouts: how many columns a row may have, the likeliest first.
        declared: the number of frames that `Frames:` gives, None if it gives none.
        max_frames: more rows than this are refused.

    Returns:
        The rows, with as many columns as one of the layouts has.

    Raises:
        InputError: the rows don't fit the channels.
    """
    text, start = cursor.text, cursor.pos
    rows = None
    if layouts[0] and text[start : start + 1_000_000].strip():
        rows = _read_regular(text, start, layouts)
    if rows is None:
        from footfix.formats.bvh.ragged_rows import read_ragged  # most files never need it

        rows = read_ragged(cursor, layouts, declared)
    if len(rows.values) > max_frames:
        what = f"{len(rows.values)} frames, more than {max_frames}"
        raise cursor.fail(what, at=start, hint="limits.frames allows more")
    return rows


def _read_regular(text: bytes, start: int, layouts: list[int]) -> Rows | None:
    """Read well-formed rows: one a line, all of the same length; None where they are not."""
    values = read_plain(text, start)
    if values is None:
        try:
            stream = BytesIO(text)  # shares the bytes with the text
            stream.seek(start)
            values = np.loadtxt(stream, comments=None, ndmin=2)
        except ValueError:
            return None
    return Rows(values, text, start, len(text)) if values.shape[1] in layouts else None

"""The MOTION part: its two headings, and the rows as an array with the place of each number in the text."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from io import BytesIO
from itertools import pairwise

import numpy as np

from footfix.errors import InputError
from footfix.formats.bvh_numbers import foreign, number, tokens, words
from footfix.formats.bvh_text import Cursor, Notes, readable
from footfix.motion.clip import Bools, Floats, Ints

_HEADING = re.compile(
    rb"[ \t]*(?:(?P<time>frame[ \t_]*time)|frames?(?:[ \t_]*count)?)\b[ \t]*[:=]?[ \t]*(?P<value>[^\s:=]*)",
    re.IGNORECASE,
)
_NEXT_PART = re.compile(rb"^[ \t]*(?:MOTION|HIERARCHY)\b", re.IGNORECASE | re.MULTILINE)
_COMMENT = re.compile(rb"^[ \t]*(?:#|//|;)[^\r\n]*", re.MULTILINE)


@dataclass(frozen=True, eq=False)
class Rows:
    """The motion rows.

    Args:
        values: (F, C) the numbers.
        text: the text in which words are numbers: the file's, with what is no number blanked out, every byte
            in its place.
        start, stop: where the numbers begin and end in it.
        first: (F,) for each row the index of its first word, or None where row f begins at word f C.
        width: (F,) for each row how many words it has, or None where all have C or more.
        comma: numbers are written with a decimal comma.
    """

    values: Floats
    text: bytes
    start: int
    stop: int
    first: Ints | None = None
    width: Ints | None = None
    comma: bool = False


@dataclass
class Headings:
    """What `Frames:` and `Frame Time:` say, as text; None where the line is missing."""

    frames: bytes | None = None
    frames_at: int = 0
    time: bytes | None = None
    time_at: int = 0
    at: int = 0  # where the MOTION part begins


def read_headings(cursor: Cursor) -> Headings:
    """Reads `MOTION`, `Frames:` and `Frame Time:` in any order and spelling; leaves the cursor at the rows."""
    headings, notes = Headings(at=cursor.start), cursor.notes
    if cursor.peek().upper() == b"MOTION":
        cursor.take()
    else:
        notes.add("motion-keyword-missing", "the word MOTION is missing", at=cursor.start)
    while (word := cursor.peek()) and (found := _HEADING.match(cursor.text, cursor.start)):
        value = found["value"]
        if found["time"]:
            headings.time, headings.time_at = value, found.start("value")
        else:
            headings.frames, headings.frames_at = value, found.start("value")
        cursor.pos = found.end()
        after = cursor.line().split()
        if after and number(after[0]) is not None:
            cursor.pos = found.end()  # the rows go on in the same line
        del word
    return headings


def read_rows(cursor: Cursor, layouts: list[int], declared: int | None, max_frames: int) -> tuple[Rows, int]:
    """Reads the rows.

    Args:
        cursor: stands where the rows begin.
        layouts: how many columns a row may have, the likeliest first.
        declared: what `Frames:` says, None if nothing of use.
        max_frames: more rows than this are refused.

    Returns:
        The rows, and how many columns they have: one of the layouts.

    Raises:
        InputError: the rows don't fit the channels.
    """
    text, start = cursor.text, cursor.pos
    rows = None
    if layouts[0] and text[start : start + 1_000_000].strip():
        rows = _read_regular(text, start, layouts)
    if rows is None:
        rows = _read_irregular(cursor, layouts, declared)
    if len(rows.values) > max_frames:
        what = f"{len(rows.values)} frames, more than {max_frames}"
        raise cursor.fail(what, at=start, hint="limits.frames allows more")
    return rows, rows.values.shape[1]


def _read_regular(text: bytes, start: int, layouts: list[int]) -> Rows | None:
    """Rows as they should be: one a line, all equally long. numpy's reader is the fastest exact one."""
    try:
        values = np.loadtxt(BytesIO(memoryview(text)[start:]), comments=None, ndmin=2)
    except ValueError:
        return None
    return Rows(values, text, start, len(text)) if values.shape[1] in layouts else None


def _read_irregular(cursor: Cursor, layouts: list[int], declared: int | None) -> Rows:
    text, start, stop, comma = _blank_out(cursor)
    starts, ends = tokens(text, start, stop)
    values, strange = _numbers(text, starts, ends, start, stop)
    line = _lines(text, starts, start, stop)
    keep = _keep_rows(cursor, starts, ends, line, strange)
    stop = start if not len(starts) else stop
    firsts, counts = _line_counts(line, keep)
    if not layouts[0] or not len(firsts):
        return Rows(np.zeros((0, layouts[0])), text, start, stop, comma=comma)
    for columns in layouts:
        found = _arrange(cursor, starts, firsts, counts, columns, declared)
        if found is not None:
            break
    else:
        raise _misfit(cursor, starts, firsts, counts, layouts)
    first, width = found
    if len(first) and width is None and np.array_equal(first, np.arange(len(first)) * columns):
        stop = int(ends[first[-1] + columns - 1])
        rows = Rows(values[: len(first) * columns].reshape(-1, columns), text, start, stop, comma=comma)
    else:
        rows = _gather(Rows(values, text, start, stop, first, width, comma), columns)
    _note_strange(cursor, rows, starts, ends, strange & keep)
    return rows


def _blank_out(cursor: Cursor) -> tuple[bytes, int, int, bool]:
    """The text with comments, second parts and separating commas blanked; where it ends; is the comma decimal."""
    text, start = cursor.text, cursor.pos
    second = _NEXT_PART.search(text, start)
    stop = len(text)
    if second:
        stop = second.start()
        cursor.notes.add("motion-repeated", "a second part follows the motion; only the first is read", "warning",
                         at=stop)  # fmt: skip
    comment = _COMMENT.search(text, start, stop)
    if comment:
        if not cursor.notes.has("comment"):
            cursor.notes.add("comment", "comments are no part of BVH; passed over", at=comment.start())
        body = _COMMENT.sub(lambda found: b" " * len(found[0]), text[start:stop])
        text = text[:start] + body
    comma = text.find(b",", start, stop) >= 0
    if comma:
        decimal = text.find(b".", start, stop) < 0
        where = text.find(b",", start, stop)
        kind = ("decimal-comma", "numbers have a decimal comma") if decimal else ("commas", "commas between numbers")
        cursor.notes.add(kind[0], kind[1] + ", which few readers take; read as such", at=where)
        text = text[:start] + text[start:stop].replace(b",", b"." if decimal else b" ")
        comma = decimal
    return text, start, stop, comma


def _numbers(text: bytes, starts: Ints, ends: Ints, start: int, stop: int) -> tuple[Floats, Bools]:
    """The value of each word, NaN where it is none, and which words are no numbers at all."""
    strange = np.zeros(len(starts), dtype=np.bool_)
    split = words(text, start, stop)
    odd = foreign(text, starts, start, stop)
    for k in odd.tolist():
        split[k] = b"nan" if (value := number(split[k])) is None else repr(value).encode()
        strange[k] = value is None
    try:
        return np.array(split, dtype=np.float64), strange
    except ValueError:
        values = np.empty(len(split))
        for k, word in enumerate(split):
            value = number(word)
            strange[k] |= value is None
            values[k] = np.nan if value is None else value
        return values, strange


def _lines(text: bytes, starts: Ints, start: int, stop: int) -> Ints:
    """The line that each word stands in, counted from 0 where the rows begin."""
    raw = np.frombuffer(text, np.uint8, stop - start, start)
    breaks = np.flatnonzero((raw == ord("\n")) | (raw == ord("\r"))) + start
    return np.asarray(np.searchsorted(breaks, starts))


def _keep_rows(cursor: Cursor, starts: Ints, ends: Ints, line: Ints, strange: Bools) -> Bools:
    """Which words belong to rows: not those of lines that are text rather than numbers."""
    keep = np.ones(len(starts), dtype=np.bool_)
    if not strange.any():
        return keep
    count, letters = np.bincount(line), np.bincount(line, weights=strange)
    prose = (letters > 0) & (2 * letters >= count)
    if not prose.any():
        return keep
    first = int(np.flatnonzero(prose)[0])
    k = int(np.searchsorted(line, first))
    shown = readable(cursor.text[starts[k] : ends[k]])
    if np.any((count > 0) & ~prose & (np.arange(len(count)) > first)):
        cursor.notes.add("text-in-rows", f"a line of text among the rows ('{shown}'); passed over", "warning",
                         at=int(starts[k]))  # fmt: skip
    else:
        cursor.notes.add("trailing-text", f"text after the last row ('{shown}'); passed over", "warning",
                         at=int(starts[k]))  # fmt: skip
    return ~prose[line]


def _line_counts(line: Ints, keep: Bools) -> tuple[Ints, Ints]:
    """For each line that has numbers: the index of its first word, and how many words it has."""
    kept = np.flatnonzero(keep)
    if not len(kept):
        return kept, kept
    begins = np.flatnonzero(np.diff(line[kept], prepend=-1))
    return kept[begins], np.diff(np.append(begins, len(kept)))


def _arrange(
    cursor: Cursor, starts: Ints, firsts: Ints, counts: Ints, columns: int, declared: int | None
) -> tuple[Ints, Ints | None] | None:
    """How lines make up rows of `columns` numbers: where each row begins, and how long rows are if some are short."""
    notes, total, right = cursor.notes, int(counts.sum()), counts == columns
    tidy = np.array_equal(firsts, np.cumsum(counts) - counts)  # nothing was passed over between the rows
    if 2 * right.sum() < len(counts) and tidy and _is_wrapped(counts, columns, declared):
        notes.add("rows-wrapped", "frames are not one to a line; read by counting numbers", at=int(starts[0]))
        if total % columns:
            _note_cut(notes, int(starts[total - total % columns]), total % columns, columns)
        return np.arange(total // columns) * columns, None
    if counts[-1] < columns and (len(counts) == 1 or 2 * right.sum() >= len(counts) - 1):
        _note_cut(notes, int(starts[firsts[-1]]), int(counts[-1]), columns)
        firsts, counts, right = firsts[:-1], counts[:-1], right[:-1]
    if right.all():
        return firsts, None
    if 2 * right.sum() < len(right):
        return None
    for kind, wrong in (("short", counts < columns), ("long", counts > columns)):
        frames = np.flatnonzero(wrong)
        if len(frames):
            what = "interpolated from its neighbours" if kind == "short" else "the numbers too many are passed over"
            notes.add(f"row-{kind}", f"{len(frames)} of {len(counts)} rows too {kind}: frame {frames[0]} has "
                      f"{counts[frames[0]]} numbers where the channels ask for {columns}; {what}", "warning",
                      at=int(starts[firsts[frames[0]]]), start=int(frames[0]), end=int(frames[-1]) + 1)  # fmt: skip
    return firsts, counts if np.any(counts < columns) else None


def _is_wrapped(counts: Ints, columns: int, declared: int | None) -> bool:
    """Do rows run over line ends: does each begin on a new line, or does each line hold whole rows?"""
    total, ends = int(counts.sum()), np.cumsum(counts)
    if total < columns:
        return False
    agrees = declared is not None and abs(total // columns - declared) <= 1
    if total % columns == 0 and not np.any(counts % columns):
        return agrees or len(counts) == 1
    each = np.arange(columns, total + 1, columns)
    uneven = bool(np.any(counts[: len(counts) // 2] != counts[0]))
    return bool(np.isin(each, ends).all()) and (agrees or uneven)


def _note_cut(notes: Notes, at: int, found: int, columns: int) -> None:
    notes.add("last-row-cut", f"the last row has {found} of {columns} numbers: the file is cut short; "
              "that row is passed over", "warning", at=at)  # fmt: skip


def _misfit(cursor: Cursor, starts: Ints, firsts: Ints, counts: Ints, layouts: list[int]) -> InputError:
    usual = int(np.argmax(np.bincount(counts)))
    k = int(np.flatnonzero(counts == usual)[0])
    return cursor.fail(
        f"rows have {usual} numbers, but the hierarchy has {layouts[0]} channels",
        at=int(starts[firsts[k]]),
        hint="the hierarchy and the motion are not of one file, or the file is damaged",
    )


def _gather(rows: Rows, columns: int) -> Rows:
    """The array of rows that begin anywhere; rows too short are interpolated from whole neighbours."""
    first, flat = rows.first, rows.values
    assert first is not None
    index = first[:, None] + np.arange(columns)
    values = flat[np.minimum(index, len(flat) - 1)]
    if rows.width is None:
        return replace(rows, values=values)
    good, bad = np.flatnonzero(rows.width >= columns), np.flatnonzero(rows.width < columns)
    before = good[np.maximum(np.searchsorted(good, bad) - 1, 0)]
    after = good[np.minimum(np.searchsorted(good, bad), len(good) - 1)]
    share = np.where(after > before, (bad - before) / np.maximum(after - before, 1), 0.0)[:, None]
    step = values[after] - values[before]
    step[np.abs(step) > 180.0] = 0.0  # an angle that wraps in between keeps its value
    values[bad] = values[before] + share * step
    return replace(rows, values=values)


def _note_strange(cursor: Cursor, rows: Rows, starts: Ints, ends: Ints, strange: Bools) -> None:
    """Words in rows that are no numbers: their value is not known."""
    for k in np.flatnonzero(strange)[:1].tolist():
        begins = np.arange(len(rows.values)) * rows.values.shape[1] if rows.first is None else rows.first
        frame = max(int(np.searchsorted(begins, k, side="right")) - 1, 0)
        count = int(strange.sum())
        cursor.notes.add(
            "not-a-number",
            f"'{readable(cursor.text[starts[k] : ends[k]])}' in frame {frame} is no number"
            + (f", nor are {count - 1} more" if count > 1 else ""),
            "error", at=int(starts[k]), start=frame, end=frame + 1,
        )  # fmt: skip


def consecutive(rows: Rows) -> list[tuple[int, int]]:
    """Stretches of rows `[a, b)` whose words follow one another without a gap; a short row is its own."""
    assert rows.first is not None
    columns = rows.values.shape[1]
    breaks = np.diff(rows.first) != columns
    if rows.width is not None:
        breaks |= rows.width[1:] < columns
    return list(pairwise([0, *(np.flatnonzero(breaks) + 1).tolist(), len(rows.first)]))

"""Irregular motion rows: wrapped, cut off, too long or too short, with text or commas among the numbers."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from footfix.errors import InputError
from footfix.formats.bvh.numbers import foreign, number, tokens, words
from footfix.formats.bvh.rows import Rows
from footfix.formats.bvh.text import Cursor, Notes, readable
from footfix.formats.bvh.unseparated_numbers import count_numbers, decimals_throughout, describe
from footfix.motion.clip import Bools, Floats, Ints

_NEXT_PART = re.compile(rb"^[ \t]*(?:MOTION|HIERARCHY)\b", re.IGNORECASE | re.MULTILINE)
_WORDS = 100_000  # taken apart together
_COMMENT = re.compile(rb"^[ \t]*(?:#|//|;)[^\r\n]*", re.MULTILINE)


def read_ragged(cursor: Cursor, layouts: list[int], declared: int | None) -> Rows:
    text, start, stop, comma = _blank_out(cursor)
    padding = len(text) - len(text.rstrip(b"\0"))
    if padding:
        cursor.notes.add("padding", f"the file ends in {padding} NUL bytes", "warning", at=len(text) - padding)
    starts, ends = tokens(text, start, stop)
    values, strange = _numbers(text, starts, ends)
    line = _lines(text, starts, start, stop)
    _refuse_glued(cursor, starts, ends, line, strange, layouts)
    keep = _keep_rows(cursor, starts, ends, line, strange)
    stop = start if not len(starts) else stop
    firsts, counts = _line_counts(line, keep)
    if not len(firsts) and strange.any() and declared != 0:
        k = int(np.argmax(strange))
        what = f"the rows are not numbers: '{readable(cursor.text[starts[k] : ends[k]])}'"
        raise cursor.fail(what, at=int(starts[k]), hint="numbers are separated by blanks")
    if not len(firsts):
        return Rows(np.zeros((0, layouts[0])), text, start, stop, comma=comma)
    for columns in layouts:
        found = _arrange(cursor, starts, firsts, counts, columns, declared) if columns else None
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
    """Blank out comments, a second MOTION part, separating commas; return the end, and whether commas are decimal."""
    text, start = cursor.text, cursor.pos
    stop = len(text)

    def holds(*letters: bytes) -> bool:  # a search for single letters is many times faster than one by pattern
        return any(text.find(letter, start, stop) >= 0 for letter in letters)

    second = _NEXT_PART.search(text, start) if holds(b"o", b"O", b"h", b"H") else None
    if second:
        stop = second.start()
        cursor.notes.add("motion-repeated", "a second part follows the motion; only the first is read", "warning",
                         at=stop)  # fmt: skip
    comment = _COMMENT.search(text, start, stop) if holds(b"#", b"//", b";") else None
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
        if not cursor.notes.has(kind[0]):
            cursor.notes.add(kind[0], kind[1] + ", which few readers take; read as such", at=where)
        text = text[:start] + text[start:stop].replace(b",", b"." if decimal else b" ")
        comma = decimal
    return text, start, stop, comma


def _numbers(text: bytes, starts: Ints, ends: Ints) -> tuple[Floats, Bools]:
    """Convert each word to its value, NaN where it is none; mark the words that are no numbers at all."""
    values, strange = np.empty(len(starts)), np.zeros(len(starts), dtype=np.bool_)
    for begin in range(0, len(starts), _WORDS):  # words as objects take many times the memory of their text
        part = slice(begin, begin + _WORDS)
        start, stop = int(starts[part][0]), int(ends[part][-1])
        split = words(text, start, stop)
        for k in foreign(text, starts[part], start, stop).tolist():
            value = number(split[k])
            split[k] = b"nan" if value is None else repr(value).encode()
            strange[begin + k] = value is None
        try:
            values[part] = np.array(split, dtype=np.float64)
        except ValueError:
            read = [number(word) for word in split]
            strange[part] |= [value is None for value in read]
            values[part] = [np.nan if value is None else value for value in read]
    return values, strange


def _lines(text: bytes, starts: Ints, start: int, stop: int) -> Ints:
    """Find the line that each word stands in, counted from 0 where the rows begin."""
    raw = np.frombuffer(text, np.uint8, stop - start, start)
    breaks = np.flatnonzero((raw == ord("\n")) | (raw == ord("\r"))) + start
    return np.asarray(np.searchsorted(breaks, starts))


def _refuse_glued(cursor: Cursor, starts: Ints, ends: Ints, line: Ints, strange: Bools, layouts: list[int]) -> None:
    """Refuse numbers that run together, in lines that become whole rows when they are separated.

    Raises:
        InputError: there are such.
    """
    counts = np.bincount(line) if strange.any() else np.zeros(0, dtype=np.intp)
    more = np.zeros_like(counts)
    first: dict[int, int] = {}
    for k in np.flatnonzero(strange).tolist():
        extra = count_numbers(cursor.text[starts[k] : ends[k]]) - 1
        if extra:
            more[line[k]] += extra
            first.setdefault(int(line[k]), k)
    for at, k in first.items():
        if counts[at] + more[at] in layouts:
            what, hint = describe(cursor.text[starts[k] : ends[k]], decimals_throughout(cursor.text, cursor.pos))
            raise cursor.fail(what, at=int(starts[k]), hint=hint)


def _keep_rows(cursor: Cursor, starts: Ints, ends: Ints, line: Ints, strange: Bools) -> Bools:
    """Mark the words that belong to rows: not those of lines that are text rather than numbers."""
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
    """Find for each line that has numbers the index of its first word, and how many words it has."""
    kept = np.flatnonzero(keep)
    if not len(kept):
        return kept, kept
    begins = np.flatnonzero(np.diff(line[kept], prepend=-1))
    return kept[begins], np.diff(np.append(begins, len(kept)))


def _arrange(
    cursor: Cursor, starts: Ints, firsts: Ints, counts: Ints, columns: int, declared: int | None
) -> tuple[Ints, Ints | None] | None:
    """Group lines into rows of `columns` numbers: where each row begins, and the rows' lengths if some are short."""
    notes, total, right = cursor.notes, int(counts.sum()), counts == columns
    tidy = np.array_equal(firsts, np.cumsum(counts) - counts)  # nothing was passed over between the rows
    usual = 2 * right.sum() >= len(counts) and declared != total / columns
    if not right.all() and not usual and tidy and _is_wrapped(counts, columns, declared):
        notes.add("rows-wrapped", "frames are not one to a line; read by counting numbers", at=int(starts[0]))
        if total % columns:
            _note_cut(notes, int(starts[total - total % columns]), total % columns, columns, total // columns, declared)
        return np.arange(total // columns) * columns, None
    if counts[-1] < columns and (len(counts) == 1 or 2 * right.sum() >= len(counts) - 1):
        _note_cut(notes, int(starts[firsts[-1]]), int(counts[-1]), columns, len(counts) - 1, declared)
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
    """Tell whether rows are wrapped, each beginning on a new line, or lines hold one or more whole rows."""
    total, ends = int(counts.sum()), np.cumsum(counts)
    if total < columns:
        return False
    agrees = declared is not None and abs(total // columns - declared) <= 1
    if total % columns == 0 and not np.any(counts % columns):
        return agrees or len(counts) == 1
    each = np.arange(columns, total + 1, columns)
    uneven = bool(np.any(counts[: len(counts) // 2] != counts[0]))
    return bool(np.isin(each, ends).all()) and (agrees or uneven)


def _note_cut(notes: Notes, at: int, found: int, columns: int, whole: int, declared: int | None) -> None:
    """Note that a file ends in the middle of a row: an error if frames are missing, else a warning."""
    lost = declared is None or whole < declared
    rest = "the file is cut short; export or copy it again, or let `footfix inspect --repair` take that row out"
    notes.add("last-row-cut", f"the last row has {found} of {columns} numbers: "
              + (rest if lost else "that row is passed over"), "error" if lost else "warning", at=at)  # fmt: skip


def _misfit(cursor: Cursor, starts: Ints, firsts: Ints, counts: Ints, layouts: list[int]) -> InputError:
    usual = int(np.argmax(np.bincount(counts)))
    k = int(np.flatnonzero(counts == usual)[0])
    return cursor.fail(
        f"rows have {usual} numbers, but the hierarchy has {layouts[0]} channels",
        at=int(starts[firsts[k]]),
        hint="the hierarchy and the motion are not of one file, or the file is damaged",
    )


def _gather(rows: Rows, columns: int) -> Rows:
    """Gather rows into an array; values that short rows lack are interpolated from whole neighbours."""
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
    """Note words in rows that are no numbers: their value is not known."""
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

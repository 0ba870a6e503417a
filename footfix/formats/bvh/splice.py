"""Writing: new numbers are put into the old text in place of the old ones, and everything else is copied."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from io import BytesIO
from itertools import chain

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from footfix.formats.bvh.channels import Change
from footfix.formats.bvh.fixed_point import Bytes, fixed, read_back
from footfix.formats.bvh.numbers import decimals, token_chunks, tokens
from footfix.formats.bvh.rows import Rows, consecutive
from footfix.motion.clip import Bools, Floats, Ints

LEAST_DECIMALS = 6  # of a number that changes: a micrometre in a file in metres
_LONGEST = 64  # [bytes] of a number that goes into a table of letters
_WIDEST_GAP = 16  # [bytes] between numbers that are written together
_ROW_END = b"\xff"  # between rows of new numbers; never part of a number, hardly ever of the gaps between

RowBlock = tuple[int, Ints, Ints]  # first frame; where each number starts and ends, (rows, C)
Columns = dict[int, Floats]  # column -> (F,) its numbers


def splice(text: bytes, rows: Rows, changed: Sequence[Change]) -> tuple[bytes, Columns]:
    """Replace some of the numbers of a text.

    Args:
        text: the file.
        rows: where its numbers stand.
        changed: the new numbers.

    Returns:
        The new text, and the numbers that it holds in the columns with changes; none of rows that lack numbers.
    """
    changed = sorted((change for change in changed if change.frames.any()), key=lambda change: change.column)
    numbers = {change.column: rows.values[:, change.column].copy() for change in changed}
    if not changed:
        return text, numbers
    some = np.flatnonzero(np.any([change.frames for change in changed], axis=0))
    first, last = int(some[0]), int(some[-1])
    out, done = BytesIO(), 0  # not a list of pieces: joining them takes the memory of the file once more
    for frame, starts, ends in row_blocks(rows):
        if frame > last:
            break
        span = slice(frame, frame + len(starts))
        here = [change for change in changed if change.frames[span].any()] if span.stop > first else []
        if here and starts.shape[1] < rows.values.shape[1]:
            out.write(text[done : int(starts[0, 0])] + _row_text(rows, frame, here))
            done = int(ends[0, -1])
        elif here:
            piece, done = _splice_block(text, rows, span, starts, ends, here, done, numbers)
            out.write(piece)
    out.write(memoryview(text)[done:])
    return out.getvalue(), numbers


def _row_text(rows: Rows, frame: int, changed: list[Change]) -> bytes:
    """Write a whole row in place of one that lacks numbers, which can't be replaced number by number."""
    values = rows.values[frame].copy()
    for change in changed:
        values[change.column] = change.values[frame]
    text = b" ".join(word.tobytes().translate(None, b"\0") for word in fixed(values, LEAST_DECIMALS))
    return text.replace(b".", b",") if rows.comma else text


def row_blocks(rows: Rows) -> Iterator[RowBlock]:
    """List where all numbers are, some thousand rows at a time; a row that lacks some is a block by itself."""
    columns = rows.values.shape[1]
    if not rows.values.size:
        return
    if rows.first is not None:
        starts, ends = tokens(rows.text, rows.start, rows.stop)
        for a, b in consecutive(rows):
            words = columns if rows.width is None else min(columns, int(rows.width[a]))
            which = slice(int(rows.first[a]), int(rows.first[a]) + (b - a) * words)
            yield a, starts[which].reshape(b - a, words), ends[which].reshape(b - a, words)
        return
    frame, starts, ends = 0, np.zeros(0, np.intp), np.zeros(0, np.intp)
    for more_starts, more_ends in token_chunks(rows.text, rows.start, rows.stop):
        starts, ends = np.concatenate([starts, more_starts]), np.concatenate([ends, more_ends])
        whole_rows = len(starts) // columns
        cut = whole_rows * columns
        if whole_rows:
            yield frame, starts[:cut].reshape(-1, columns), ends[:cut].reshape(-1, columns)
        frame, starts, ends = frame + whole_rows, starts[cut:], ends[cut:]


def _splice_block(
    text: bytes, rows: Rows, span: slice, starts: Ints, ends: Ints, changed: list[Change], done: int, numbers: Columns
) -> tuple[bytes, int]:
    """Write the text from `done` to the block's last new number, record its numbers in `numbers`; return the end."""
    columns = np.array([change.column for change in changed])
    mask = np.stack([change.frames[span] for change in changed], axis=1)
    values = np.stack([change.values[span] for change in changed], axis=1)
    starts, ends = starts[:, columns], ends[:, columns]
    places = max(LEAST_DECIMALS, int(decimals(rows.text, starts, ends).max(where=mask, initial=0)))
    # A number that would be the same at the decimals written stays as it is.
    mask &= np.isfinite(values)
    mask &= np.abs(values - rows.values[span, columns]) > 0.5 * 10.0**-places
    used = np.flatnonzero(mask.any(axis=1))
    if not len(used):
        return b"", done
    if len(used) < len(starts):
        starts, ends, mask, values = starts[used], ends[used], mask[used], values[used]
    _note_down(numbers, columns, span.start + used, mask, read_back(values[mask], places))
    low, high = int(starts[0, 0]), int(ends[-1, -1])
    if (ends - starts).max() > _LONGEST or any(text.find(own, low, high) >= 0 for own in (b"\0", _ROW_END)):
        return _one_by_one(text, rows.comma, starts[mask], ends[mask], fixed(values[mask], places), done)
    joined = (np.diff(columns) == 1) & ((starts[:, 1:] - ends[:, :-1]).max(axis=0) <= _WIDEST_GAP)
    new, bounds = list[list[bytes]](), list[Ints]()
    for group in np.split(np.arange(len(columns)), np.flatnonzero(~joined) + 1):
        letters = fixed(values[:, group][mask[:, group]], places)
        new.append(_run_text(text, rows.comma, starts[:, group], ends[:, group], mask[:, group], letters))
        bounds += [starts[:, group[0]], ends[:, group[-1]]]
    # kept text, new numbers, kept text, new numbers, ... row by row
    cuts = [done, *np.stack(bounds, axis=1).ravel().tolist()]
    kept = [text[a:b] for a, b in zip(cuts[0:-1:2], cuts[1::2], strict=True)]
    row_by_row = chain.from_iterable(zip(*new, strict=True))
    return b"".join(chain.from_iterable(zip(kept, row_by_row, strict=True))), cuts[-1]


def _one_by_one(text: bytes, comma: bool, starts: Ints, ends: Ints, new: Bytes, done: int) -> tuple[bytes, int]:
    """Replace one number after the other: for numbers or gaps too long for arrays of characters."""
    pieces = list[bytes]()
    for start, end, letters in zip(starts.tolist(), ends.tolist(), new, strict=True):
        word = letters.tobytes().translate(None, b"\0")
        pieces += [text[done:start], word.replace(b".", b",") if comma else word]
        done = end
    return b"".join(pieces), done


def _note_down(numbers: Columns, columns: Ints, frames: Ints, mask: Bools, new: Floats) -> None:
    values = np.empty(mask.shape)
    values[mask] = new
    for k, column in enumerate(columns.tolist()):
        numbers[column][frames[mask[:, k]]] = values[mask[:, k], k]


def _words(text: bytes, starts: Ints, ends: Ints) -> Bytes:
    """Copy words into an array (N, longest) of characters, padded with NUL at the end."""
    sizes = ends - starts
    low, longest = int(starts[0]), int(sizes.max())
    raw = np.frombuffer(text, np.uint8, min(len(text), int(starts[-1]) + longest) - low, low)
    raw = np.append(raw, np.zeros(longest, np.uint8))  # the last words of a text are looked at beyond its end
    letters = sliding_window_view(raw, longest)[starts - low]
    letters[np.arange(longest) >= sizes[:, None]] = 0
    return letters


def _run_text(text: bytes, comma: bool, starts: Ints, ends: Ints, mask: Bools, formatted: Bytes) -> list[bytes]:
    """Write the text of neighbouring columns (rows, n), row by row; gaps and unchanged numbers are copied."""
    count, n = starts.shape
    raw = np.frombuffer(text, np.uint8)
    if comma:
        formatted[formatted == ord(".")] = ord(",")
    gaps = starts[:, 1:] - ends[:, :-1]
    longest, gap = int((ends - starts).max(where=~mask, initial=0)), int(gaps.max(initial=0))
    width = max(formatted.shape[1], longest) + max(gap, 1)
    cells = np.zeros((count, n, width), dtype=np.uint8)
    cells[:, :, : formatted.shape[1]][mask] = formatted
    if longest:
        cells[:, :, :longest][~mask] = _words(text, starts[~mask], ends[~mask])
    for k in range(gap):
        which = gaps > k
        cells[:, :-1, k - gap][which] = raw[ends[:, :-1][which] + k]
    cells[:, -1, -1] = ord(_ROW_END)
    return cells.tobytes().translate(None, b"\0").split(_ROW_END)[:-1]

"""The motion rows as numbers, and where each is in the text."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from footfix.formats.bvh.numbers import token_chunks
from footfix.motion.clip import Floats, Ints


@dataclass(frozen=True, eq=False)
class Rows:
    """The motion rows.

    Args:
        values: (F, C) the numbers.
        text: the file's text with everything but numbers blanked out, so that offsets stay the same.
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


def consecutive(rows: Rows) -> list[tuple[int, int]]:
    """Find stretches of rows `[a, b)` whose words follow one another without a gap; a short row is its own."""
    assert rows.first is not None
    columns = rows.values.shape[1]
    breaks = np.diff(rows.first) != columns
    if rows.width is not None:
        breaks |= (rows.width[1:] < columns) | (rows.width[:-1] < columns)
    return list(pairwise([0, *(np.flatnonzero(breaks) + 1).tolist(), len(rows.first)]))


def offset_of(rows: Rows, frame: int, column: int) -> int:
    """Find where in the text a number of a row stands; the end of the rows where a short row has none."""
    word = frame * rows.values.shape[1] if rows.first is None else int(rows.first[frame])
    word += column if rows.width is None else min(column, int(rows.width[frame]) - 1)
    for starts, _ in token_chunks(rows.text, rows.start, rows.stop):
        if word < len(starts):
            return int(starts[word])
        word -= len(starts)
    return rows.stop

"""The motion rows of most files: every number with the same few decimals, rows of one length, one a line.

Such numbers are integers over one power of ten. Their digits are read eight at a time, in 60 % of the time of numpy's
reader, which reads all other files; both give the same values to the last bit.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from footfix.motion.clip import Floats, Ints
from footfix.motion.threads import at_once

Words = NDArray[np.uint64]  # eight letters each, the first one lowest

_CHUNK = 1 << 18  # [bytes] looked at together: the arrays made of them fit into the cache of a core
_MOST = 8  # digits before the point, and after it
_EXACT = 15  # digits of a whole number that a float holds
_ZEROS, _SIXES, _HIGH = (np.uint64(int(_MOST * letter, 16)) for letter in ("30", "06", "f0"))
# Masks that keep the last 0 to 8 characters of eight.
_LAST = np.array([(1 << 64) - (1 << 8 * (_MOST - count)) for count in range(_MOST + 1)], dtype=np.uint64)


def read_plain(text: bytes, start: int) -> Floats | None:
    """Read the numbers (F, C) of the rows, from `start` to the end of a text; None where rows are not so regular."""
    first = text.find(b".", start)
    decimals = 0
    while first >= 0 and text[first + 1 + decimals : first + 2 + decimals].isdigit():
        decimals += 1
    if not 0 < decimals <= _MOST or start < _MOST:
        return None
    words = np.ndarray((len(text) - _MOST + 1,), "<u8", text, 0, (1,))
    spans = list[tuple[int, int]]()
    while start < len(text):
        stop = start + _CHUNK
        stop = text.rfind(b"\n", start, stop) + 1 if stop < len(text) else len(text)
        if not stop:
            return None
        spans.append((start, stop))
        start = stop

    def read(start: int, stop: int) -> Floats | None:
        found = _tokens(text, start, stop)
        if found is None or np.any(found[2] != found[2][0]):
            return None
        values = _values(text, words, *found[:2], decimals)
        return None if values is None else values.reshape(-1, found[2][0])

    top = read(*spans[0]) if spans else None
    if top is None:  # most texts that are not so regular end here
        return None
    parts = [top, *at_once([partial(read, *span) for span in spans[1:]], len(text))]
    rows = [part for part in parts if part is not None and part.shape[1] == top.shape[1]]
    return np.concatenate(rows) if len(rows) == len(parts) else None


def _tokens(text: bytes, start: int, stop: int) -> tuple[Ints, Ints, Ints] | None:
    """Find where the words of some lines start and end in the text, and the number of words of each non-empty line."""
    raw = np.frombuffer(text, np.uint8, stop - start, start)
    newlines = np.flatnonzero(raw == ord("\n"))
    others = np.count_nonzero(raw < 32) - len(newlines)
    if others and others != text.count(b"\t", start, stop) + text.count(b"\r\n", start, stop):
        return None
    solid = np.empty(len(raw) + 2, dtype=np.bool_)
    solid[0] = solid[-1] = False
    np.greater(raw, 32, out=solid[1:-1])
    edges = np.flatnonzero(solid[1:] != solid[:-1])
    if not len(edges):
        return None
    edges += start
    starts, ends = edges[0::2], edges[1::2]
    lines = np.append(newlines + start, stop)
    lengths = np.diff(np.searchsorted(starts, lines), prepend=0)
    return starts, ends, lengths[lengths > 0]


def _values(text: bytes, words: Words, starts: Ints, ends: Ints, decimals: int) -> Floats | None:
    """Read the numbers (N,) of words; None where one is not digits with a point at the usual place."""
    raw = np.frombuffer(text, np.uint8)
    points = ends - (decimals + 1)
    negative = raw[starts] == ord("-")
    before = points - starts
    before -= negative
    if before.min() < 0 or before.max() > min(_MOST, _EXACT - decimals) or np.any(raw[points] != ord(".")):
        return None
    whole, part = _digits(words[points - _MOST], _LAST[before]), _digits(words[ends - _MOST], _LAST[decimals])
    if whole is None or part is None:
        return None
    whole *= np.uint64(10**decimals)
    whole += part
    # below 2^53, and a power of ten that is exact: the quotient is rounded once, as the decimals are by a reader
    values = whole.view(np.int64) / 10.0**decimals
    np.negative(values, out=values, where=negative)
    return values


def _digits(letters: Words, keep: Words | np.uint64) -> Words | None:
    """Read the characters that are kept as integers; None where one of them is no digit."""
    letters ^= _ZEROS
    letters &= keep
    beyond = letters + _SIXES
    beyond |= letters
    beyond &= _HIGH
    if beyond.any():
        return None
    # neighbours are joined: digits to pairs, pairs to fours, those to eights
    for size, power, mask in ((8, 10, 0x00FF00FF00FF00FF), (16, 100, 0x0000FFFF0000FFFF), (32, 10_000, 0xFFFFFFFF)):
        np.right_shift(letters, np.uint64(size), out=beyond)
        letters *= np.uint64(power)
        letters += beyond
        letters &= np.uint64(mask)
    return letters

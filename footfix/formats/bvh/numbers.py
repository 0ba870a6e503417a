"""Numbers as text: where they are in a block of bytes, their values, and how many decimals they have."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from footfix.motion.clip import Ints

Bytes = NDArray[np.uint8]

# What separates words: blanks and control characters, and what Latin-1 adds to them.
_BLANK = (np.arange(256) <= 32) | np.isin(np.arange(256), (0x85, 0xA0))
_PLAIN = np.isin(np.arange(256), list(b"0123456789+-.eE"))
_AS_BLANKS = bytes(32 if blank else letter for letter, blank in enumerate(_BLANK.tolist()))
_NAN = re.compile(rb"[-+]?(?:nan(?:\(\w*\))?|1\.?#(?:ind|qnan|snan)\d*|n/a|null|none)", re.IGNORECASE)
_INF = re.compile(rb"([-+]?)(?:inf(?:inity)?|1\.?#inf\d*)", re.IGNORECASE)
_CHUNK = 1 << 20  # [bytes] looked at together: a few such arrays fit into the cache of a core


def number(word: bytes) -> float | None:
    """Convert a word to a number, with the spellings of several C libraries for NaN and infinity.

    A comma is taken as the decimal sign. None where the word is no number.
    """
    if b"_" in word or len(word) > 400:
        return None
    try:
        return float(word.replace(b",", b"."))
    except ValueError:
        if _NAN.fullmatch(word):
            return float("nan")
        found = _INF.fullmatch(word)
        return float(found[1] + b"inf") if found else None


def words(text: bytes, start: int, stop: int) -> list[bytes]:
    """Split `text[start:stop]` into words."""
    return text[start:stop].translate(_AS_BLANKS).split()


def tokens(text: bytes, start: int, stop: int) -> tuple[Ints, Ints]:
    """Find where each of these words starts and ends, as offsets into `text`."""
    raw = np.frombuffer(text, np.uint8, stop - start, start)
    if not len(raw):
        return np.zeros(0, np.intp), np.zeros(0, np.intp)
    # comparing is many times faster than looking up, and numbers are ASCII
    solid = raw > 32 if raw.max() < 128 else ~_BLANK[raw]
    edges = np.empty(len(raw) + 1, dtype=np.bool_)
    edges[0], edges[-1] = solid[0], solid[-1]
    np.not_equal(solid[1:], solid[:-1], out=edges[1:-1])
    found = np.flatnonzero(edges)
    found += start
    return found[0::2], found[1::2]


def token_chunks(text: bytes, start: int, stop: int) -> Iterator[tuple[Ints, Ints]]:
    """Find words a megabyte at a time, so that memory stays small whatever the length of the text."""
    while start < stop:
        cut = min(start + _CHUNK, stop)
        while cut < stop and not _BLANK[text[cut]]:
            cut += 1
        yield tokens(text, start, cut)
        start = cut


def foreign(text: bytes, starts: Ints, start: int, stop: int) -> Ints:
    """Find the indices of those words of `text[start:stop]` that hold bytes other than a plain number's."""
    raw = np.frombuffer(text, np.uint8, stop - start, start)
    strange = np.flatnonzero(~(_PLAIN | _BLANK)[raw]) + start
    return np.asarray(np.unique(np.searchsorted(starts, strange, side="right") - 1))


def decimals(text: bytes, starts: Ints, ends: Ints) -> Ints:
    """Count the digits of each word of `text` after the point; those of the mantissa where there is an exponent.

    Args:
        text: in which the words stand.
        starts, ends: of any shape, in the order of the text; other words may stand between them.
    """
    low, high = int(starts.flat[0]), int(ends.flat[-1])
    raw = np.frombuffer(text, np.uint8, high - low, low)
    last = ends - low
    if text.find(b"e", low, high) >= 0 or text.find(b"E", low, high) >= 0:
        powers = np.append(np.flatnonzero((raw | 32) == ord("e")), len(raw))
        last = np.minimum(last, powers[np.searchsorted(powers, starts - low)])
    elif (first := text.find(b".", low, int(ends.flat[0]))) >= 0:
        # Most files have one number of decimals throughout: to check that is five times faster than to find all points.
        places = int(ends.flat[0]) - first - 1
        likely = last - places - 1
        if np.all(likely >= starts - low) and np.all(raw[likely] == ord(".")):
            return np.full_like(starts, places)
    points = np.flatnonzero(raw == ord("."))
    if not len(points):
        return np.zeros_like(starts)
    point = points[np.maximum(np.searchsorted(points, last) - 1, 0)]
    own = (point >= starts - low) & (point < last)
    return np.where(own, last - point - 1, 0)

"""Numbers that run together for want of a blank (`12.5-3.1`): found, and separated where that is certain."""

from __future__ import annotations

import re

from footfix.formats.bvh.text import place, readable
from footfix.notes import Note

ID = "numbers-run-together"

_NUMBER = rb"(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?"
_GLUED = re.compile(rb"[-+]?" + _NUMBER + rb"(?:[-+]" + _NUMBER + rb")+")
_SEAM = re.compile(rb"(?<=[\d.,])(?=[-+])")  # the sign of an exponent stands behind its e
_ANY = re.compile(rb"\d[.,]?[-+]")
_MOTION = re.compile(
    rb"^[ \t]*MOTION\b.*?^[ \t]*Frame[ \t]*Time[^\r\n]*[\r\n]+", re.IGNORECASE | re.MULTILINE | re.DOTALL
)
_CHANNELS = re.compile(rb"\bCHANNELS[ \t]+(\d+)", re.IGNORECASE)
_LINE = re.compile(rb"[^\r\n]+")


def split_numbers(word: bytes) -> list[bytes]:
    """Split a word of numbers that run together, before each sign; any other word is returned as it is, alone."""
    return _SEAM.split(word) if _GLUED.fullmatch(word) else [word]


def separate_numbers(data: bytes) -> tuple[bytes, tuple[Note, ...]]:
    """Put blanks between numbers that run together, in rows that then have a number for each channel.

    Args:
        data: a BVH file.

    Returns:
        The file (the same bytes where no numbers run together), and a note on how many were separated.
    """
    motion = _MOTION.search(data)
    if motion is None or not _ANY.search(data, motion.end()):
        return data, ()
    columns = sum(int(count) for count in _CHANNELS.findall(data, 0, motion.start()))
    parts, done, rows, numbers, first = [data[: motion.end()]], motion.end(), 0, 0, 0
    for line in _LINE.finditer(data, motion.end()):
        if not _ANY.search(line[0]):
            continue
        words = line[0].split()
        count = sum(len(split_numbers(word)) for word in words)
        if count != columns or count == len(words):
            continue
        first = first or line.start()
        parts += [data[done : line.start()], re.sub(rb"\S+", lambda word: b" ".join(split_numbers(word[0])), line[0])]
        done, rows, numbers = line.end(), rows + 1, numbers + count - len(words)
    if not rows:
        return data, ()
    at, column = place(data, first)
    text = f"blanks put between {numbers} numbers that ran together, in {rows} rows"
    return b"".join([*parts, data[done:]]), (Note(ID, text, line=at, column=column),)


def describe(word: bytes) -> tuple[str, str]:
    """Describe a word of numbers that run together: what is wrong, and what to do next."""
    first, second, *_ = (each.decode("ascii", "replace") for each in split_numbers(word))
    what = f"two numbers run together, '{readable(word)}': a blank is missing between {first} and {second}"
    return what, "`footfix inspect --repair` puts such numbers apart"

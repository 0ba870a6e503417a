"""Numbers that run together for want of a blank (`12.5-3.1`, `0.12501.7500`): found, and separated if that is certain.

A sign begins a number. Without one, the second point in a word betrays that it holds two numbers; where the first of
them ends is certain if all numbers of the file have as many decimals.
"""

from __future__ import annotations

import re

from footfix.formats.bvh.text import place, readable
from footfix.notes import Note

ID = "numbers-run-together"

_SIGNED = rb"[-+]?[.,]*\d[\d.,]*(?:[eE][-+]?\d+)?"  # one way to match any word: else long ones would take forever
_NUMBERS = re.compile(rb"(?:" + _SIGNED + rb")(?:(?=[-+])" + _SIGNED + rb")*")
_SEAM = re.compile(rb"(?<=[\d.,])(?=[-+])")  # the sign of an exponent stands behind its e
_POINT = re.compile(rb"[.,]")
_ANY = re.compile(rb"\d[.,]?[-+]|[.]\d*[.]|,\d*,")
_DECIMALS = re.compile(rb"[.,](\d+)$")
_MOTION = re.compile(
    rb"^[ \t]*MOTION\b.*?^[ \t]*Frame[ \t]*Time[^\r\n]*[\r\n]+", re.IGNORECASE | re.MULTILINE | re.DOTALL
)
_CHANNELS = re.compile(rb"\bCHANNELS[ \t]+(\d+)", re.IGNORECASE)
_LINE = re.compile(rb"[^\r\n]+")
_WORD = re.compile(rb"\S+")


def split_numbers(word: bytes, places: int | None = None) -> list[bytes]:
    """Split a word of numbers that run together; any other word is returned as it is, alone.

    Args:
        word: without blanks.
        places: how many decimals each number of the file has; None where that varies, so that only signs split.
    """
    if not _NUMBERS.fullmatch(word):
        return [word]
    parts = list[bytes]()
    for part in _SEAM.split(word):
        one = rb"[-+]?\d+[.,]\d{%d}" % (places or 0)
        fixed = places and len(_POINT.findall(part)) > 1 and re.fullmatch(rb"(?:" + one + rb")+", part)
        parts += re.findall(one, part) if fixed else [part]
    return parts


def count_numbers(word: bytes) -> int:
    """Count the numbers that run together in a word, each with one point at most; 1 for any other word."""
    return sum(max(1, len(_POINT.findall(part))) for part in split_numbers(word)) if _NUMBERS.fullmatch(word) else 1


def decimals_throughout(text: bytes, start: int) -> int | None:
    """Find how many decimals each number from `start` on has; None where they differ."""
    found = None
    for word in _WORD.finditer(text, start):
        places = _DECIMALS.search(word[0])
        if not places or (found is not None and len(places[1]) != found):
            return None
        found = len(places[1])
    return found


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
    places = decimals_throughout(data, motion.end())
    parts, done, rows, numbers, first = [data[: motion.end()]], motion.end(), 0, 0, 0
    for line in _LINE.finditer(data, motion.end()):
        if not _ANY.search(line[0]):
            continue
        words = line[0].split()
        split = [number for word in words for number in split_numbers(word, places)]
        count = len(split)
        if count != columns or count == len(words) or any(count_numbers(number) > 1 for number in split):
            continue
        first = first or line.start()
        apart = _WORD.sub(lambda word: b" ".join(split_numbers(word[0], places)), line[0])
        parts += [data[done : line.start()], apart]
        done, rows, numbers = line.end(), rows + 1, numbers + count - len(words)
    if not rows:
        return data, ()
    at, column = place(data, first)
    text = f"blanks put between {numbers} numbers that ran together, in {rows} rows"
    return b"".join([*parts, data[done:]]), (Note(ID, text, line=at, column=column),)


def describe(word: bytes, places: int | None) -> tuple[str, str]:
    """Describe a word of numbers that run together: what is wrong, and what to do next.

    Args:
        word: without blanks.
        places: how many decimals each number of the file has; None where that varies.
    """
    what = f"two numbers run together, '{readable(word)}': a blank is missing"
    split = split_numbers(word, places)
    if any(count_numbers(number) > 1 for number in split):
        hint = "where one ends is not certain: write a blank there by hand, or export the clip again"
        return what, hint
    first, second, *_ = (each.decode("ascii", "replace") for each in split)
    return f"{what} between {first} and {second}", "`footfix inspect --repair` puts such numbers apart"

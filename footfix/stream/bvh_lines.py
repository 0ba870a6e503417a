"""Parse a live BVH byte by byte: a header, then rows; broken lines are skipped and reported."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from footfix.errors import InputError
from footfix.formats.bvh.document import Document
from footfix.formats.bvh.numbers import number
from footfix.formats.bvh.read import decode
from footfix.formats.bvh.text import readable
from footfix.motion.clip import Floats

_HEADING = re.compile(rb"frame[ \t_]*time[ \t]*[:=]?[ \t]*[^\s]+[^\n]*\n", re.IGNORECASE)
_HEADER = re.compile(rb"\s*hierarchy\b", re.IGNORECASE)
_FRAMES = re.compile(rb"(frames?[ \t]*:?[ \t]*)(\d+)([ \t]*)", re.IGNORECASE)
_MOTION = re.compile(rb"^[ \t]*motion\b", re.IGNORECASE | re.MULTILINE)
_WORD = re.compile(rb"\S+")
_END = re.compile(rb"\|\||\r?\n")
_LONGEST_ROW = 1 << 20  # [bytes] a longer row is garbage
_LONGEST_HEADER = 8 << 20  # [bytes]
_BEFORE_HEADER = 1 << 16  # [bytes] longest other content before a header
LEAST_DECIMALS = 6


@dataclass(frozen=True, eq=False)
class Row:
    """A row as it came in.

    Args:
        text: the row, with what stands before its numbers.
        values: (C,) the numbers; an invalid one is replaced by the last valid one of its column.
        end: its line ending.
        broken: whether a number was invalid.
    """

    text: bytes
    values: Floats
    end: bytes
    broken: bool = False

    def written(self, values: Floats, *, bare: bool = True) -> bytes:
        """Write the row with new numbers where they differ, with its own number of decimals, at least 6.

        Args:
            values: (C,) the new ones.
            bare: without what stands before the numbers, ended as a line; else as it came.
        """
        out, words = bytearray(self.text), [match.span() for match in _WORD.finditer(self.text)][-len(values) :]
        which = range(len(values)) if self.broken else np.flatnonzero(values != self.values).tolist()
        for k in reversed(which):
            start, end = words[k]
            word = self.text[start:end]
            value = float(values[k])
            if self.broken and value == self.values[k] and number(word) == value:
                continue
            places = max(LEAST_DECIMALS, len(word.partition(b".")[2]) if b"e" not in word.lower() else 0)
            text = b"%.*f" % (places, value)
            out[start:end] = text.removeprefix(b"-") if not text.strip(b"-0.") else text
        if not bare:
            return bytes(out) + self.end
        return bytes(out[words[0][0] :] if self.end == b"||" else out) + (b"\n" if self.end == b"||" else self.end)


@dataclass(frozen=True, eq=False)
class Header:
    """A header as it came in: its text, up to the first row, and the parsed document."""

    text: bytes
    document: Document


@dataclass(frozen=True)
class Said:
    """A fault of the input, in words; `kind` groups similar faults."""

    kind: str
    text: str


Item = Row | Header | Said


class Lines:
    """Splits the input into lines, whatever pieces it comes in."""

    def __init__(self, document: Document | None = None, name: str = "") -> None:
        """Start without input.

        Args:
            document: what rows mean that come without a header.
            name: of the input, in messages.
        """
        self._rest, self._name = b"", name
        self._document, self._hierarchy = document, b""
        self._in_header, self._strange = False, 0
        self._last: Floats | None = None
        self.rows = 0  # that came in, broken ones among them

    def feed(self, data: bytes) -> Iterator[Item]:
        """Take bytes; return the complete items in them.

        Raises:
            InputError: what came is no BVH, or has turned into another figure's.
        """
        self._rest += data
        while (items := self._header() if self._in_header or self._begins_header() else self._line()) is not None:
            yield from items

    def finish(self) -> list[Item]:
        """Return the last items when the input has ended or its peer is gone; then expect the start of a row."""
        rest, self._rest = self._rest, b""
        if self._in_header:
            self._in_header = False
            if self._document is None:
                raise InputError("the input ended within its header", file=self._name)
            return [Said("cut", "the input ended within a header")]
        if not rest.strip():
            return []
        if self._document is None:
            raise InputError("there is no BVH header: the input does not begin with HIERARCHY", file=self._name)
        row = self._row(rest, b"\n")
        if isinstance(row, Row):
            return [row]
        return [Said("cut", f"the input ended in the middle of row {self.rows}, which is left out")]

    def forget(self) -> None:
        """Start with another peer: drop the unfinished line of the last one."""
        self._rest, self._in_header = b"", False

    def _begins_header(self) -> bool:
        start = self._rest.lstrip(b"\xef\xbb\xbf \t\r\n")[:10].upper()
        self._in_header = bool(_HEADER.match(start))
        return self._in_header

    def _header(self) -> list[Item] | None:
        end = _HEADING.search(self._rest)
        if end is None:
            if len(self._rest) > _LONGEST_HEADER:
                raise InputError(f"there is no `Frame Time:` in the first {_LONGEST_HEADER} bytes", file=self._name)
            return None
        text, self._rest = self._rest[: end.end()], self._rest[end.end() :]
        self._in_header = False
        hierarchy = b" ".join(text[: _motion_at(text)].split())
        if self._document is None or not self._hierarchy:
            document = decode(text, name=self._name)
            if self._document is not None and document.skeleton.names != self._document.skeleton.names:
                raise InputError("the header is of another figure than the one it was calibrated on", file=self._name)
            self._hierarchy = hierarchy
            self._document = document
            return [Header(text, document)]
        if hierarchy != self._hierarchy:
            raise InputError(
                f"after {self.rows} rows another header came, of another figure", file=self._name,
                hint="start a stream of its own for each figure",
            )  # fmt: skip
        again = decode(text, name=self._name)
        if abs(again.frame_time / self._document.frame_time - 1.0) > 1e-3:
            self._document = again
            return [Header(text, again)]
        return [Said("header-again", f"the header came again after {self.rows} rows, and was left out")]

    def _line(self) -> list[Item] | None:
        end = _END.search(self._rest)
        if end is None:
            if len(self._rest) > (_BEFORE_HEADER if self._document is None else _LONGEST_ROW):
                if self._document is None:
                    raise InputError("there is no BVH header in the input", file=self._name)
                self._rest = b""
                return [Said("garbage", "a row without an end was left out")]
            return None
        line, self._rest = self._rest[: end.start()], self._rest[end.end() :]
        if not line.strip():
            return []
        if self._document is None:
            self._strange += len(line)
            if self._strange > _BEFORE_HEADER or number((line.split() or [b""])[0]) is not None:
                raise InputError(
                    f"rows came before any header: {readable(line[:40])}", file=self._name,
                    hint="--calibrate FILE.bvh names a file of the same figure",
                )  # fmt: skip
            return [Said("garbage", f"{readable(line[:40])} before the header was left out")]
        return [self._row(line, end[0])]

    def _row(self, line: bytes, end: bytes) -> Item:
        """Parse a line."""
        assert self._document is not None
        columns = len(self._document.channels)
        if line.lstrip()[:6].lower() in (b"motion", b"frames", b"frame:"):
            return Said("heading", f"{readable(line[:40])} among the rows was left out")
        self.rows += 1
        found = line.split()
        if len(found) != columns and not (len(found) > columns and end == b"||"):
            return Said("misfit", f"row {self.rows} has {len(found)} numbers, not {columns}, and was left out")
        found = found[len(found) - columns :]
        try:
            values = np.array([float(word) for word in found])
        except ValueError:
            read = [number(word) for word in found]
            if sum(value is None for value in read) > 0.5 * columns:
                return Said("garbage", f"row {self.rows} holds no numbers, and was left out: {readable(line[:40])}")
            values = np.array([np.nan if value is None else value for value in read])
        good = np.isfinite(values)
        broken = not good.all()
        if broken:
            values = np.where(good, values, np.zeros(columns) if self._last is None else self._last)
        self._last = values
        return Row(line, values, end, broken)


def _motion_at(header: bytes) -> int:
    """Find where the MOTION part begins."""
    found = list(_MOTION.finditer(header))
    return found[-1].start() if found else 0


def header_of(document: Document) -> bytes:
    """Make the header of a file for a stream whose number of frames is not known."""
    end = _HEADING.search(document.text, document.motion_at)
    text = document.text[: end.end()] if end else document.text
    return text[: document.motion_at] + _FRAMES.sub(rb"\g<1>0", text[document.motion_at :], count=1)


def with_room(header: bytes) -> tuple[bytes, int]:
    """Make room in a header for a count of frames that is known later; return where it is, -1 without one."""
    found = _FRAMES.search(header, _motion_at(header))
    if found is None:
        return header, -1
    room = max(0, 10 - len(found[2]) - len(found[3]))
    pad = b" " * room if int(found[2]) == 0 else b""
    return header[: found.end()] + pad + header[found.end() :], found.start(2)


def counted(header: bytes, at: int, frames: int) -> bytes | None:
    """Make the text of the count of frames in a header `with_room`; None where it is right, or does not fit."""
    if at < 0:
        return None
    room = re.match(rb"\d+[ \t]*", header[at:])
    assert room is not None
    text = b"%d" % frames
    if room[0].strip() == text or len(text) > len(room[0]):
        return None
    return text.ljust(len(room[0]))

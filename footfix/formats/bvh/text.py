"""What kind of file the bytes are, and a cursor over its text: encodings, words, lines and columns.

Everything works on bytes and on offsets into them, so that unchanged parts can be copied to the byte.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from footfix.errors import InputError
from footfix.notes import Note, Severity

_WORD = re.compile(rb"[{}]|[^\s{}]+")
_COMMENT = re.compile(rb"(?:#|//|;)[^\r\n]*")

# Other formats that are found under the name .bvh: first bytes, what it is, what to do.
_OTHER_FORMATS = (
    (b"version https://git-lfs", "this is a Git LFS pointer, not the file itself", "fetch it with `git lfs pull`"),
    (b"Kaydara FBX Binary", "this is a binary FBX file under the name of a BVH", "export it as BVH"),
    (b"; FBX", "this is an FBX text file under the name of a BVH", "export it as BVH"),
    (b"glTF", "this is a glTF file under the name of a BVH", "let its name end in .glb"),
    (b"PK\x03\x04", "this is a ZIP archive", "unpack it first"),
    (b"\x1f\x8b", "this is a gzip archive", "unpack it first"),
    (b"7z\xbc\xaf", "this is a 7z archive", "unpack it first"),
    (b"%PDF", "this is a PDF", "give the motion file itself"),
    (b":ASF", "this is an Acclaim skeleton (ASF)", "convert ASF and AMC to BVH"),
    (b":FULLY-SPECIFIED", "this is Acclaim motion (AMC)", "convert ASF and AMC to BVH"),
    (b"BLENDER", "this is a Blender file", "export it as BVH"),
    (b"<?xml", "this is an XML file", "give a BVH"),
    (b"<!doctype html", "this is a web page, probably an error page of a download", "download the file itself"),
    (b"<html", "this is a web page, probably an error page of a download", "download the file itself"),
)


def refuse_other_formats(head: bytes) -> None:
    """Refuse files of other formats under the name of a BVH, told by their first bytes.

    Raises:
        InputError: it is one of those; says which, and what to do.
    """
    start_of_text = head[:64].lstrip(b"\xef\xbb\xbf \t\r\n")
    for start, what, hint in _OTHER_FORMATS:
        if start_of_text[: len(start)].lower() == start.lower():
            raise InputError(what, hint=hint)


def searchable_text(data: bytes, notes: Notes) -> tuple[bytes, str]:
    """Decode a file to ASCII-compatible bytes, in which words can be searched for; return the encoding to write in.

    Args:
        data: the file.
        notes: assumptions are added here.

    Returns:
        (text, encoding): the encoding is empty where the text is the file itself.

    Raises:
        InputError: it is empty, or something other than BVH.
    """
    blank = b"\0 \t\r\n\x1a"
    if not data[:4096].strip(blank) and not data.strip(blank):  # stripping copies: not of sound files
        what = "the file is empty" if not data else "the file holds nothing but blanks"
        raise InputError(what, hint="export or download it again")
    refuse_other_formats(data)
    for bom, encoding in ((b"\xff\xfe\0\0", "utf-32"), (b"\0\0\xfe\xff", "utf-32"),
                          (b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be")):  # fmt: skip
        if data.startswith(bom):
            return _from_wide(data, encoding, notes), encoding
    if data[1:2] == b"\0" and data[3:4] == b"\0" and data[:1].isalpha():
        return _from_wide(data, "utf-16-le", notes), "utf-16-le"
    control = len(data[:1024].translate(None, bytes(range(32, 256)) + b"\t\n\v\f\r\x1a"))
    if control > 16 and b"HIERARCHY" not in data[:1024].upper():
        raise InputError("this is a binary file of another kind, not a BVH", hint="export the motion as BVH")
    return data, ""


def _from_wide(data: bytes, encoding: str, notes: Notes) -> bytes:
    hint = "save it as UTF-8 or ASCII text"
    if encoding == "utf-32":
        raise InputError("the text is UTF-32", hint=hint)
    try:
        text = data.decode(encoding).encode("utf-8")
    except UnicodeError:
        raise InputError(f"the text looks like {encoding.upper()}, but is damaged", hint=hint) from None
    notes.add("encoding-utf16", f"the text is {encoding.upper()}, which few readers take; read as such", at=0)
    return text


def readable(word: bytes | str, limit: int = 40) -> str:
    """Make a word of a file safe to show: printable characters only, and not too long."""
    shown = word[: limit + 1] if isinstance(word, str) else word[: limit + 1].decode("utf-8", "replace")
    shown = "".join(letter if letter.isprintable() else "\N{REPLACEMENT CHARACTER}" for letter in shown)
    return shown if len(shown) <= limit else shown[:limit] + "..."


def place(text: bytes, offset: int) -> tuple[int, int]:
    """Find line and column of an offset, both from 1; the column counts characters."""
    end = b"\n" if text.find(b"\n", 0, 1 << 20) >= 0 else b"\r"
    line = text.count(end, 0, offset) + 1
    start = text.rfind(end, 0, offset) + 1
    before = text[max(start, offset - 10_000) : offset].removeprefix(b"\xef\xbb\xbf")
    return line, len(before.decode("utf-8", "replace")) + 1


@dataclass(frozen=True, kw_only=True)
class Limits:
    """How large a file may be. A file beyond a limit is refused before memory is spent on it.

    Args:
        bytes: of a file; the default holds an hour of 200 joints at 120 frames per second [bytes].
        header: in which the MOTION part must have begun [bytes].
        frames: of a clip; the default is 46 hours at 120 frames per second [count].
        joints: of a skeleton; a body with face and hands has 200 [count].
        nesting: joints below joints [count].
    """

    bytes: int = 4 << 30
    header: int = 64 << 20
    frames: int = 20_000_000
    joints: int = 5_000
    nesting: int = 5_000


@dataclass
class Notes:
    """Collects notes about one text; places are given as offsets into it."""

    text: bytes = b""
    found: list[Note] = field(default_factory=list)

    def add(
        self,
        id: str,
        text: str,
        severity: Severity = "note",
        *,
        at: int | None = None,
        joints: tuple[str, ...] = (),
        start: int | None = None,
        end: int | None = None,
    ) -> None:
        line, column = (None, None) if at is None else place(self.text, at)
        self.found.append(Note(id, text, severity, start, end, joints, line, column))

    def has(self, id: str) -> bool:
        return any(note.id == id for note in self.found)


@dataclass
class Cursor:
    """A cursor that reads a text word by word. `start` is where the last word began, `pos` where it ended."""

    text: bytes
    notes: Notes
    pos: int = 0
    start: int = 0

    def peek(self) -> bytes:
        """Look at the next word (a brace is a word of its own), empty at the end; comments are passed over."""
        while True:
            found = _WORD.search(self.text, self.pos)
            if found is None:
                self.start = len(self.text)
                return b""
            self.start = found.start()
            if not found[0].startswith((b"#", b"//", b";")):
                # a word of many megabytes is none of this format: its beginning is enough to see that
                return self.text[self.start : min(found.end(), self.start + 1000)]
            comment = _COMMENT.match(self.text, self.start)
            if not self.notes.has("comment"):
                self.notes.add("comment", "comments are no part of BVH; passed over", at=self.start)
            self.pos = comment.end() if comment else found.end()

    def take(self) -> bytes:
        """Read the next word, and step over it."""
        word = self.peek()
        self.pos = self.start + len(word)
        return word

    def line(self, stop: bytes = b"") -> bytes:
        """Read the rest of the line, or up to the first of the bytes `stop`; step over it."""
        found = re.compile(rb"[^\r\n" + re.escape(stop) + rb"]*").match(self.text, self.pos)
        self.pos = found.end() if found else self.pos
        return found[0] if found else b""

    def fail(self, what: str, *, at: int | None = None, hint: str = "") -> InputError:
        """Make the error for text that can't be read, with its line and column."""
        line, column = place(self.text, self.start if at is None else at)
        return InputError(what, line=line, column=column, hint=hint)

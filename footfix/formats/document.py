"""The seam between files and clips: what the rest of the house asks of a file of motion, whatever its format.

A format is a module or package with `decode`, `rewrite`, `select`, `glance` and `repair`, named in
`footfix.formats.suffixes`; it may have `legible`, too.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import PurePath
from typing import Any, Protocol

from footfix.formats.bvh.text import Limits
from footfix.formats.suffixes import MOTION
from footfix.motion.clip import Clip, Ints
from footfix.notes import Note

_LIMITS = Limits()
_DEFAULT = ".bvh"


class Document(Protocol):
    """A file of motion as it was read, kept so that it can be written again with only its changes new."""

    @property
    def name(self) -> str:
        """What the file is called, for messages."""

    @property
    def notes(self) -> tuple[Note, ...]:
        """What was assumed in reading it, and what is wrong."""

    @property
    def unusable(self) -> tuple[Note, ...]:
        """The notes that say why nothing can be done with this motion; empty for a sound file."""

    @property
    def frames(self) -> int:
        """How many frames it holds."""

    @property
    def columns(self) -> int:
        """How many numbers a frame has."""

    @property
    def frame_time(self) -> float:
        """[s] of one frame."""

    @property
    def unit_m(self) -> float:
        """[m] one unit of the file."""

    @property
    def up(self) -> str:
        """The file's upward axis: "y", "-y", "z", "-z", "x" or "-x"."""

    @property
    def clip(self) -> Clip:
        """The motion in metres, y up, by the unit and axis it is believed to have."""

    def placed(self, *, unit_m: float | None = None, up: str | None = None) -> Document:
        """Give the same file another belief about its unit and its upward axis."""


def open_document(data: bytes, *, name: str = "", limits: Limits = _LIMITS) -> Document:
    """Read a file of motion; its name says which format it has, and BVH is taken where it does not.

    Args:
        data: the file.
        name: what it is called.
        limits: beyond these it is refused.

    Raises:
        InputError: it is not of its format, or damaged beyond reading; with line and column.
    """
    document: Document = _format(name).decode(data, name=name, limits=limits)
    return document


def legible(data: bytes, *, name: str = "") -> tuple[bytes, tuple[Note, ...]]:
    """Put right what keeps a file from being read at all, with a note for each change; most formats know nothing such.

    Args:
        data: the file.
        name: what it is called.
    """
    known = getattr(_format(name), "legible", None)
    mended: tuple[bytes, tuple[Note, ...]] = known(data) if known else (data, ())
    return mended


def rewrite(document: Document, clip: Clip, *, limits: Limits = _LIMITS) -> tuple[bytes, Clip]:
    """Write a document with the motion of `clip`; only what changed is new.

    Args:
        document: the file.
        clip: F frames of its joints [m], y up.
        limits: beyond these it can't be read again.

    Returns:
        The file, and the motion that reading it again finds [m]; `document.clip` itself where nothing changed.
    """
    written: tuple[bytes, Clip] = _format(document.name).rewrite(document, clip, limits=limits)
    return written


def select(document: Document, frames: Ints, *, limits: Limits = _LIMITS) -> Document:
    """A document with some of the frames of another one, each written as it was.

    Args:
        document: the file.
        frames: which of its frames, in their new order; a frame may come more than once.
        limits: beyond these it can't be read again.
    """
    selected: Document = _format(document.name).select(document, frames, limits=limits)
    return selected


def write_motion(document: Document, frames: Ints, clip: Clip, *, limits: Limits = _LIMITS) -> tuple[bytes, Clip]:
    """Write a BVH file of a new motion of a document's skeleton; that of a BVH file keeps its header.

    Args:
        document: the file.
        frames: (F,) which of its frames are most like those of the clip.
        clip: F frames [m], y up.
        limits: beyond these it can't be read again.

    Returns:
        The file, and the motion that reading it finds [m].
    """
    own = getattr(_format(document.name), "with_motion", None)
    unit_m, up = (document.unit_m, document.up) if own else (0.01, "y")
    if own:
        written: bytes = own(document, frames, clip)
    else:
        written = import_module(MOTION[_DEFAULT]).compose(clip, unit_m=unit_m)
    again = open_document(written, name=_DEFAULT, limits=limits)
    return written, again.placed(unit_m=unit_m, up=up).clip


def glance(head: bytes, *, name: str = "", limits: Limits = _LIMITS) -> None:
    """Look at the first bytes of a large file, so that gigabytes of something else need not be read.

    Raises:
        InputError: whatever follows, it will be refused.
    """
    _format(name).glance(head, limits=limits)


def repair(document: Document) -> tuple[bytes, tuple[Note, ...]]:
    """Write what a strict reader of the format wants, with a note for each change."""
    mended: tuple[bytes, tuple[Note, ...]] = _format(document.name).repair(document)
    return mended


def _format(name: str) -> Any:
    return import_module(MOTION.get(PurePath(name).suffix.lower(), MOTION[_DEFAULT]))

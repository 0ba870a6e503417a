"""The interface between files and clips: what the rest of footfix asks of a file of motion, whatever its format.

A format is a module or package with `decode`, `rewrite`, `select_frames`, `glance` and `repair`, named in
`footfix.formats.suffixes`; it may have `separate_numbers`. One whose files hold several clips also has `clips_of` and
`joined`; where its files may refer to others it has `neighbours_of`, and its functions take `beside`, to read them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Protocol

from footfix.formats.bvh.text import Limits
from footfix.formats.suffixes import MOTION, in_file
from footfix.motion.clip import Bools, Clip, Ints
from footfix.notes import Note
from footfix.rig.params import RigParams

if TYPE_CHECKING:
    from footfix.rig.skin import Skin

Beside = Callable[[str], bytes]  # the bytes of a file that another one names, relative to its folder

_LIMITS = Limits()
_DEFAULT = ".bvh"


class Document(Protocol):
    """A file of motion as it was read, kept so that it can be written again with only its changes new."""

    @property
    def name(self) -> str:
        """Name the file, for messages."""

    @property
    def notes(self) -> tuple[Note, ...]:
        """List what was assumed in reading it, and what is wrong."""

    @property
    def unusable(self) -> tuple[Note, ...]:
        """List the notes that say why nothing can be done with this motion; empty for a sound file."""

    @property
    def frames(self) -> int:
        """Count its frames."""

    @property
    def columns(self) -> int:
        """Count the numbers of a frame."""

    @property
    def frame_time(self) -> float:
        """Get the duration of a frame [s]."""

    @property
    def start(self) -> float:
        """Get the time of the first frame [s]."""

    @property
    def unit_m(self) -> float:
        """Get the length of one unit of the file [m]."""

    @property
    def up(self) -> str:
        """Get the file's upward axis: "y", "-y", "z", "-z", "x" or "-x"."""

    @property
    def clip(self) -> Clip:
        """Get the motion in metres, y up, by the unit and axis that the file most likely has."""

    @property
    def metric(self) -> bool:
        """Tell whether its format prescribes metres and y up; the figure's size is then weak evidence against that."""

    @property
    def moved(self) -> Bools:
        """Mark the joints (J,) that the file may move; a format may leave channels of joints out."""

    @property
    def skin(self) -> Skin | None:
        """Get the character whose meshes the file shows, from which its soles can be taken; None where it shows none.
        """

    def placed(self, *, unit_m: float | None = None, up: str | None = None) -> Document:
        """Return the same file read with another unit [m] and upward axis."""


def open_document(
    data: bytes, *, name: str = "", limits: Limits = _LIMITS, beside: Beside | None = None
) -> Document:  # fmt: skip
    """Read a file of motion; its name says which format it has, and BVH is taken where it does not.

    Args:
        data: the file.
        name: what it is called; of one that holds several clips, the clip's after a "#": character.glb#Walk.
        limits: beyond these it is refused.
        beside: reads a file that this one names.

    Raises:
        InputError: it is not of its format, or damaged beyond reading; with line and column.
    """
    kind = _format(name)
    document: Document = kind.decode(data, name=name, limits=limits, **_fetching(kind, beside))
    return document


def shown_skin(document: Document, params: RigParams, named: Skin | None) -> Skin | None:
    """Give the character whose feet a clip shows: the one that `params` name, or that of the document's own file."""
    return document.skin if params.skin is None and named is None else named


def clips_of(
    data: bytes, *, name: str = "", limits: Limits = _LIMITS, beside: Beside | None = None
) -> tuple[str, ...] | None:  # fmt: skip
    """List the clips that a file holds by name; None where its format holds one, which needs no name.

    Raises:
        InputError: it can't be read, or holds none.
    """
    kind = _format(name)
    if not hasattr(kind, "clips_of"):
        return None
    names: tuple[str, ...] = kind.clips_of(data, name=name, limits=limits, **_fetching(kind, beside))
    return names


def joined(data: bytes, so_far: bytes, written: bytes, *, name: str, beside: Beside | None = None) -> bytes:
    """Join the changes of two files into one.

    Args:
        data: the file that both were made of.
        so_far: it with some of its clips changed.
        written: it with others changed.
        name: what it is called.
        beside: reads a file that it names.
    """
    kind = _format(name)
    whole: bytes = kind.joined(data, so_far, written, name=name, **_fetching(kind, beside))
    return whole


def annotated(data: bytes, extras: Mapping[str, Any], *, name: str, beside: Beside | None = None) -> bytes | None:
    """Write a file with further data (`extras`) of some of its clips, by name; None where its format has none."""
    kind = _format(name)
    if not hasattr(kind, "annotated"):
        return None
    written: bytes = kind.annotated(data, extras, name=name, **_fetching(kind, beside))
    return written


def neighbours_of(
    data: bytes, *, name: str = "", limits: Limits = _LIMITS, beside: Beside | None = None
) -> tuple[str, ...]:  # fmt: skip
    """List the files that a file names, relative to its folder: without them it is not whole."""
    kind = _format(name)
    if not hasattr(kind, "neighbours_of"):
        return ()
    names: tuple[str, ...] = kind.neighbours_of(data, name=name, limits=limits, **_fetching(kind, beside))
    return names


def separate_numbers(data: bytes, *, name: str = "") -> tuple[bytes, tuple[Note, ...]]:
    """Correct what keeps a file from being read at all, with a note for each change; few formats have such faults.

    Args:
        data: the file.
        name: what it is called.
    """
    known = getattr(_format(name), "separate_numbers", None)
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


def select_frames(document: Document, frames: Ints, *, limits: Limits = _LIMITS) -> Document:
    """Make a document with some of the frames of another one, each written as it was.

    Args:
        document: the file.
        frames: which of its frames, in their new order; a frame may come more than once.
        limits: beyond these it can't be read again.
    """
    selected: Document = _format(document.name).select_frames(document, frames, limits=limits)
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
    return import_module(MOTION.get(PurePath(in_file(name)[0]).suffix.lower(), MOTION[_DEFAULT]))


def one_format(name: str, other: str) -> bool:
    """Tell whether two files' names are of one format, as far as they say."""
    return _format(name) is _format(other)


def _fetching(kind: Any, beside: Beside | None) -> dict[str, Beside]:
    return {"beside": beside} if beside is not None and hasattr(kind, "neighbours_of") else {}

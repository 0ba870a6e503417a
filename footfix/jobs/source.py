"""Reading an input file: its unit, up axis and motion frames, and its entry in the outputs."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from footfix.errors import InputError
from footfix.formats.document import Beside, Document, open_document
from footfix.formats.suffixes import bare
from footfix.jobs.shared_legs import with_shared_legs
from footfix.motion.clip import Clip
from footfix.motion.lead_in import motion_range
from footfix.notes import Note
from footfix.rig.params import RigParams
from footfix.rig.units import infer_units
from footfix.settings import Settings

# A clip of fewer frames holds no motion: no speed can be computed.
LEAST_FRAMES = 3


@contextmanager
def about(name: str) -> Iterator[None]:
    """Add the file's name to errors that are raised where file names are not known."""
    try:
        yield
    except InputError as error:
        raise error if error.file else error.within(name) from None


def read(data: bytes, name: str, settings: Settings, *, beside: Beside | None = None) -> Document:
    """Read a file as a document in metres, y up; `beside` reads files that it names.

    Raises:
        InputError: it can't be read, or holds NaN or infinity.
    """
    return opened(data, name, settings, beside)[0]


def opened(data: bytes, name: str, settings: Settings, beside: Beside | None) -> tuple[Document, slice]:
    """Read a file as a document in metres, y up, and find its frames of motion, after a lead-in pose.

    Raises:
        InputError: it can't be read, or holds NaN or infinity.
    """
    document = open_document(data, name=name, limits=settings.limits, beside=beside)
    for broken in document.unusable:
        raise InputError(broken.text, file=name, line=broken.line, column=broken.column)
    if document.frames == 0:
        return document, slice(0, 0)
    frame_range = motion_range(document.clip)
    with about(name):
        return placed(document, settings.rig, frame_range)[0], frame_range


def suited(
    data: bytes, name: str, settings: Settings, beside: Beside | None
) -> tuple[Document, slice, Settings]:  # fmt: skip
    """Open a file and adapt settings to it: its animations share their legs, and those of games are likely cycles.

    Raises:
        InputError: it can't be read, or holds NaN or infinity.
    """
    settings = with_shared_legs(data, name, settings, beside)
    document, frame_range = opened(data, name, settings, beside)
    if document.metric and settings.enforce.cycle == "find":
        settings = replace(settings, enforce=replace(settings.enforce, cycle="likely"))
    return document, frame_range, settings


def placed(
    document: Document, params: RigParams, frame_range: slice | None = None
) -> tuple[Document, tuple[Note, ...]]:
    """Find unit and up axis of a document; return it in metres, y up, with notes on what was doubtful."""
    found = infer_units(document.clip, params, frame_range, metric=document.metric)
    return document.placed(unit_m=found.unit_m, up=found.up), found.notes


def source_entry(data: bytes, name: str, clip: Clip) -> dict[str, Any]:
    """Make the entry on the input file of contacts and report: name, checksum, frames and frame time."""
    return {
        "file": bare(name),
        "sha256": hashlib.sha256(data).hexdigest(),
        "frames": len(clip),
        "frame_time": clip.frame_time,
    }

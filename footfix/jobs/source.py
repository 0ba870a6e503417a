"""A file that comes in: read, its unit and up axis found, and what outputs say of it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from footfix.errors import InputError
from footfix.formats.document import Beside, Document, open_document
from footfix.formats.suffixes import bare
from footfix.jobs.legs import with_shared_legs
from footfix.motion.clip import Clip
from footfix.motion.leadin import motion_range
from footfix.notes import Note
from footfix.rig.params import RigParams
from footfix.rig.units import infer_units
from footfix.settings import Settings

# Fewer frames than this hold no motion: there is no speed to look at.
LEAST_FRAMES = 3


@contextmanager
def about(name: str) -> Iterator[None]:
    """Let errors from below, where nothing knows of files, say which file they are about."""
    try:
        yield
    except InputError as error:
        raise error if error.file else error.within(name) from None


def read(data: bytes, name: str, settings: Settings, *, beside: Beside | None = None) -> Document:
    """Read a file as a document in metres, y up; `beside` reads files that it names.

    Raises:
        InputError: it can't be read, or holds numbers that are none.
    """
    return opened(data, name, settings, beside)[0]


def opened(data: bytes, name: str, settings: Settings, beside: Beside | None) -> tuple[Document, slice]:
    """Read a file as a document in metres, y up, and find the frames of it that are motion.

    Raises:
        InputError: it can't be read, or holds numbers that are none.
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
    """Open a file, and suit settings to it: legs are shared by its animations, and those of games are likely cycles.

    Raises:
        InputError: it can't be read, or holds numbers that are none.
    """
    settings = with_shared_legs(data, name, settings, beside)
    document, frame_range = opened(data, name, settings, beside)
    if document.metric and settings.enforce.cycle == "find":
        settings = replace(settings, enforce=replace(settings.enforce, cycle="likely"))
    return document, frame_range, settings


def placed(
    document: Document, params: RigParams, frame_range: slice | None = None
) -> tuple[Document, tuple[Note, ...]]:
    """Give a document its unit and up axis as found, and say what was doubtful about them."""
    found = infer_units(document.clip, params, frame_range, metric=document.metric)
    return document.placed(unit_m=found.unit_m, up=found.up), found.notes


def source_entry(data: bytes, name: str, clip: Clip) -> dict[str, Any]:
    """Say which file contacts and report are about: its name, checksum, frames and frame time."""
    return {
        "file": bare(name),
        "sha256": hashlib.sha256(data).hexdigest(),
        "frames": len(clip),
        "frame_time": clip.frame_time,
    }

"""Some frames of a file as a file of its own: hierarchy and rows as they are, with another number of frames."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.formats.bvh.document import Document
from footfix.formats.bvh.read import decode
from footfix.formats.bvh.rows import offset_of
from footfix.formats.bvh.text import Limits
from footfix.motion.clip import Ints

_LIMITS = Limits()
_FRAMES = re.compile(rb"(frames?(?![ \t_]*time)(?:[ \t_]*count)?\b[ \t]*[:=]?[ \t]*)[^\s:=]+", re.IGNORECASE)


def select_frames(document: Document, frames: Sequence[int] | Ints, *, limits: Limits = _LIMITS) -> Document:
    """Make the document of some frames.

    Args:
        document: the file.
        frames: which of its frames, in their new order; a frame may come more than once.
        limits: beyond these it can't be read again.

    Returns:
        A document of the file's header, with the new number of frames, and the rows of those frames as they are
        written; its unit, axes and notes are the file's.
    """
    which = np.asarray(frames, dtype=np.intp)
    text, rows = document.text, document.rows
    head, newline = header_for(document, len(which))
    pieces = []
    for run in np.split(which, np.flatnonzero(np.diff(which) != 1) + 1):
        start, last = offset_of(rows, int(run[0]), 0), int(run[-1]) + 1
        stop = offset_of(rows, last, 0) if last < document.frames else rows.stop
        pieces.append(text[start:stop].strip())
    body = newline.join(pieces)
    new = decode(head + body + newline, name=document.name, limits=limits)
    return replace(
        new, encoding=document.encoding, notes=document.notes, base=document.base, frame_time=document.frame_time,
        unit_m=document.unit_m, up=document.up,
    )  # fmt: skip


def header_for(document: Document, frames: int) -> tuple[bytes, bytes]:
    """Copy a file's header for another number of frames, with its last line end; return it and the newline used."""
    text = document.text
    newline = b"\r\n" if b"\r\n" in text[:1000] else b"\n" if b"\n" in text[:1000] else b"\r"
    head = text[: document.motion_at] + _FRAMES.sub(
        lambda found: found[1] + b"%d" % frames, text[document.motion_at : document.rows.start], count=1
    )
    return head.rstrip() + newline, newline

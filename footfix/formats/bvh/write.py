"""Writing BVH: only the numbers that changed are replaced; everything else is the file's own text."""

from __future__ import annotations

import numpy as np

from footfix.formats.bvh.channels import changes
from footfix.formats.bvh.document import Document
from footfix.formats.bvh.motion_after_write import motion_after_write
from footfix.formats.bvh.read import decode
from footfix.formats.bvh.splice import Columns, splice
from footfix.formats.bvh.text import Limits
from footfix.motion.clip import Clip

_LIMITS = Limits()


def encode(document: Document, clip: Clip | None = None) -> bytes:
    """Write the file with the motion of `clip`.

    Where the values of `clip` equal those of `document.clip`, the text stays the same to the byte. The numbers of
    channels that changed are replaced: with as many decimals as the file has and at least 6, without exponents, on
    the Euler branch nearest to the file's own angles.

    Args:
        document: the file.
        clip: F frames of its joints [m], y up; by default nothing changes.
    """
    text = document.text if clip is None else _spliced(document, clip)[0]
    return _encoded(document, text)


def rewrite(document: Document, clip: Clip, *, limits: Limits = _LIMITS) -> tuple[bytes, Clip]:
    """Write the file with the motion of `clip`, as `encode` does, and return the clip that reading it again gives.

    Args:
        document: the file.
        clip: F frames of its joints [m], y up.
        limits: those that it is read again with.

    Returns:
        The file, and the motion in it [m], y up; `document.clip` itself where nothing changed.
    """
    text, numbers = _spliced(document, clip)
    written = _encoded(document, text)
    if text == document.text:
        return written, document.clip
    with np.errstate(invalid="ignore"):
        again = motion_after_write(document, numbers)
    if again is None:
        read = decode(written, name=document.name, limits=limits)
        again = read.placed(unit_m=document.unit_m, up=document.up).clip
    return written, again


def _encoded(document: Document, text: bytes) -> bytes:
    return text.decode("utf-8").encode(document.encoding) if document.encoding else text


def _spliced(document: Document, clip: Clip) -> tuple[bytes, Columns]:
    """Put the motion of `clip` into the text; return it, and the numbers of the columns that changed."""
    old, rows = document.clip, document.rows
    if clip is old:
        return document.text, {}
    if (len(clip), len(clip.skeleton)) != (len(old), len(old.skeleton)):
        of = [f"{len(each)} frames of {len(each.skeleton)} joints" for each in (clip, old)]
        raise ValueError(f"the clip has {of[0]}, the file {of[1]}")
    with np.errstate(invalid="ignore"):  # NaN in the file stays as it is
        found = changes(document.channels, rows.values, document.base, old, clip, document.unit_m, document.up)
        return splice(document.text, rows, list(found))

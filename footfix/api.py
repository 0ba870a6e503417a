"""The Python interface: load, find_rig, detect, clean, loop, save. Arrays in, arrays out."""

from __future__ import annotations

import os
from pathlib import Path

from footfix import job
from footfix.detect.run import detect
from footfix.formats.bvh import compose
from footfix.formats.document import Document, rewrite
from footfix.motion.clip import Clip
from footfix.pipeline import clean, loop
from footfix.rig.find import find_rig
from footfix.settings import Settings

__all__ = ["clean", "detect", "find_rig", "load", "loop", "save"]


def load(path: str | os.PathLike[str], settings: Settings | None = None) -> Document:
    """Read a file of motion.

    Args:
        path: the file.
        settings: how its unit and up axis are found, and how large it may be.

    Returns:
        The file; its `.clip` is the motion in metres, y up, its `.notes` what was odd about it.

    Raises:
        InputError: it can't be read, or holds numbers that are none.
        OSError: it can't be opened.
    """
    return job.read(Path(path).read_bytes(), os.fspath(path), settings or Settings())


def save(path: str | os.PathLike[str], clip: Clip, *, like: Document | None = None) -> None:
    """Write a file of motion, whole or not at all.

    Args:
        path: the file; one that is there is replaced.
        clip: the motion.
        like: the document the clip came from. Its text is kept, and only the numbers of channels that
            changed are written anew. Without it, a plain file in centimetres, y up, is composed.

    Raises:
        OutputError: it could not be written; what stood there still does.
    """
    from footfix.batch.files import write_whole

    write_whole(Path(path), compose(clip) if like is None else rewrite(like, clip)[0])

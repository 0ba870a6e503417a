"""Files of motion: read and written."""

from __future__ import annotations

import os
from pathlib import Path

from footfix.api.parameters import check_settings
from footfix.errors import ArgumentError
from footfix.formats.bvh import compose
from footfix.formats.document import Beside, Document, clips_of, one_format, rewrite
from footfix.formats.suffixes import in_file, is_motion
from footfix.input_checks import check_clip
from footfix.jobs.source import read
from footfix.motion.clip import Clip
from footfix.settings import Settings

__all__ = ["animations", "load", "save"]


def load(
    path: str | os.PathLike[str], settings: Settings | None = None, *, animation: str | None = None
) -> Document:  # fmt: skip
    """Read a file of motion: BVH or glTF.

    Examples:
        >>> walk = load("sample_data/walk_skate.bvh")
        >>> walk.clip.positions.shape, round(walk.clip.fps), walk.unit_m, walk.up
        ((301, 21, 3), 60, 0.01, 'y')

    Args:
        path: the file.
        settings: how its unit and up axis are found, and how large it may be.
        animation: which one of a glTF file that holds several (`animations` lists them); character.glb#Walk as the
            path says the same.

    Returns:
        The file; its `.clip` is the motion in metres, y up, its `.notes` what was odd about it.

    Raises:
        InputError: it can't be read, holds NaN or infinity, or holds several animations, of which none was named.
        OSError: it can't be opened.
    """
    file, named = _file_and_clip(path, animation)
    name = f"{file}#{named}" if named else file
    return read(Path(file).read_bytes(), name, check_settings(settings), beside=_beside(file))


def animations(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """List the animations of a glTF file by name; a BVH file is one clip, which has no name.

    Examples:
        >>> animations("sample_data/walk_skate.bvh")
        ()

    Args:
        path: the file.

    Raises:
        InputError: it can't be read, or holds no animation.
        OSError: it can't be opened.
    """
    file = os.fspath(path)
    return clips_of(Path(file).read_bytes(), name=file, beside=_beside(file)) or ()


def _file_and_clip(path: str | os.PathLike[str], animation: str | None) -> tuple[str, str]:
    """Tell the file that a path means, and the animation in it; "" where neither names one."""
    name = os.fspath(path)
    file, named = (name, "") if Path(name).exists() else in_file(name)
    if named and animation not in (None, named):
        raise ArgumentError(f"{name} names the animation {named!r}, and animation={animation!r} another one")
    return file, animation or named


def _beside(file: str) -> Beside:
    """Make what reads the files that a glTF file names."""
    return lambda name: (Path(file).parent / name).read_bytes()


def save(path: str | os.PathLike[str], clip: Clip, *, like: Document | None = None) -> None:
    """Write a file of motion, whole or not at all.

    Args:
        path: the file; one that is there is replaced.
        clip: the motion.
        like: the document the clip came from. Its text is kept, and only the numbers of channels that
            changed are written anew; of a glTF file, all other animations are kept, too. Without it, a plain BVH file
            in centimetres, y up, is composed.

    Raises:
        ArgumentError: it is not a clip, or not of the document's joints; or the path is that of another format.
        OutputError: it could not be written; what stood there still does.
    """
    from footfix.batch.file_io import write_whole

    check_clip(clip)
    if like is not None and clip.skeleton.names != like.clip.skeleton.names:
        raise ArgumentError(f"the clip's joints are not those of {like.name}; leave out `like` to write a plain file")
    if like is not None and len(clip) != like.frames:
        raise ArgumentError(f"the clip has {len(clip)} frames, {like.name} has {like.frames}; leave out `like`")
    name = os.fspath(path)
    if is_motion(name) and not one_format(name, ".bvh" if like is None else like.name):
        wanted = "needs `like`, the document that it came from" if like is None else f"and {like.name} differ in format"
        raise ArgumentError(f"{name} {wanted}; a clip is written in the format that it was read from, or as BVH")
    write_whole(Path(path), compose(clip) if like is None else rewrite(like, clip)[0])

"""Reading whole files within bounds, and writing them whole or not at all."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from footfix.errors import InputError, OutputError

if TYPE_CHECKING:
    from footfix.formats.bvh.text import Limits

STDIN = "-"
_HEAD = 1 << 26  # [bytes] read before anything else
_PART = 1 << 30  # [bytes] read together


def read_whole(path: str | os.PathLike[str], most_bytes: int, glance: Callable[[bytes], None] | None = None) -> bytes:
    """Read the bytes of a file, or of standard input for "-".

    Args:
        path: which file.
        most_bytes: more are refused.
        glance: looks at the first bytes of a large file, and raises where the rest is not worth reading.

    Raises:
        InputError: it can't be read, or is larger than allowed; no more than that is ever held.
    """
    name = os.fspath(path)
    try:
        if name == STDIN:
            data = _read(sys.stdin.buffer, most_bytes, glance)
        else:
            with open(name, "rb") as file:  # noqa: PTH123  # a name of any bytes, as the system gave it
                data = _read(file, most_bytes, glance)
    except OSError as error:
        raise InputError(f"can't be read: {error.strerror or error}", file=name) from None
    if len(data) > most_bytes:
        raise InputError(
            f"larger than {most_bytes / 1e6:,.0f} MB", file=name, hint="limits.bytes allows more"
        )  # fmt: skip
    return data


def read_clip(path: str, limits: Limits, *, name: str, called: str | None = None) -> bytes:
    """Read a clip's file, or standard input for "-", as bytes; one that is no clip at all is not read to its end.

    Args:
        path: which file.
        limits: how large it may be.
        name: its name, by which its kind is known.
        called: what errors call it, if not by its name.

    Raises:
        InputError: it can't be read, or is larger than allowed.
    """
    from footfix.formats.document import glance

    try:
        return read_whole(path, limits.bytes, partial(glance, name=name, limits=limits))
    except InputError as error:
        raise error.within(called or name) from None


def _read(file: BinaryIO, most_bytes: int, glance: Callable[[bytes], None] | None) -> bytes:
    """Read up to one byte more than `most_bytes`, and set aside no more memory than the file says it needs."""
    try:
        size = os.fstat(file.fileno()).st_size
    except OSError:
        size = 0  # no file of the system
    parts = [file.read(_HEAD)]
    if len(parts[0]) == _HEAD and glance is not None:
        glance(parts[0])
    read = len(parts[0])
    while parts[-1] and read <= most_bytes:
        parts.append(file.read(min(max(size - read, 0), most_bytes - read, _PART) + 1))
        read += len(parts[-1])
    return parts[0] if read == len(parts[0]) else b"".join(parts)


def write_whole(path: Path, data: bytes, *, tag: str = "run") -> None:
    """Write a file so that it appears whole or not at all, with the permissions a new file would have.

    Args:
        path: the file.
        data: its bytes.
        tag: of the run, in the temporary file's name; by it, and by the process, what a killed run left is known.

    Raises:
        OutputError: the folder is missing or read-only, the disk is full; what stood there still does.
    """
    handle, temporary = -1, ""
    try:
        # Beside the target: only within one file system is the replacement a single step.
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".footfix-{tag}-{os.getpid()}-", suffix=".tmp")
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        Path(temporary).chmod(path.stat().st_mode & 0o777 if path.exists() else 0o666 & ~_umask())
        Path(temporary).replace(path)
    except OSError as error:
        if temporary:
            with suppress(OSError):
                Path(temporary).unlink()
        raise OutputError(f"{path}: can't be written: {error.strerror or error}") from None
    except BaseException:
        if temporary:
            with suppress(OSError):
                Path(temporary).unlink()
        raise


def remove_leftovers(folder: Path, *, tag: str, process: int | None = None) -> None:
    """Remove the temporary files that a killed run, or one killed process of it, left in a folder."""
    pattern = f".footfix-{tag}-{'*' if process is None else process}-*.tmp"
    for path in folder.glob(pattern):
        with suppress(OSError):
            path.unlink()


def sync_folder(folder: Path) -> None:
    """Make sure that the names in a folder survive a power cut, where the system can."""
    if os.name == "nt":
        return
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask

"""Reading whole files up to a size limit, and writing files whole or not at all."""

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
        most_bytes: larger files are refused.
        glance: checks the first bytes of a large file, and raises where the rest need not be read.

    Raises:
        InputError: it can't be read, or is larger than allowed; no more than `most_bytes` are ever held.
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
    """Read a clip's file, or standard input for "-", as bytes; files of other kinds are not read to their end.

    Args:
        path: which file.
        limits: how large it may be.
        name: its name, which tells its format.
        called: its name in errors, if another.

    Raises:
        InputError: it can't be read, or is larger than allowed.
    """
    from footfix.formats.document import glance

    try:
        return read_whole(path, limits.bytes, partial(glance, name=name, limits=limits))
    except InputError as error:
        raise error.within(called or name) from None


def _read(file: BinaryIO, most_bytes: int, glance: Callable[[bytes], None] | None) -> bytes:
    """Read up to one byte more than `most_bytes`, without allocating more memory than the file's size."""
    try:
        size = os.fstat(file.fileno()).st_size
    except OSError:
        size = 0  # not a file on disk
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
        tag: of the run, in the temporary file's name; with the process id it tells which files a killed run left.

    Raises:
        OutputError: the folder is missing or read-only, or the disk is full; an existing file is unchanged.
    """
    handle, temporary = -1, ""
    try:
        # Beside the target, since replacing a file is atomic only within one file system.
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
    """Flush the names in a folder to the disk, where the system can, so that they survive a power cut."""
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

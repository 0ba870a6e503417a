"""Reading whole files within bounds, and writing them whole or not at all."""

from __future__ import annotations

import os
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

from footfix.errors import InputError, OutputError

STDIN = "-"


def read_whole(path: str | os.PathLike[str], most_bytes: int) -> bytes:
    """The bytes of a file, or of standard input for "-".

    Raises:
        InputError: it can't be read, or is larger than allowed; no more than that is ever held.
    """
    name = os.fspath(path)
    try:
        if name == STDIN:
            data = sys.stdin.buffer.read(most_bytes + 1)
        else:
            with open(name, "rb") as file:  # noqa: PTH123  # a name of any bytes, as the system gave it
                data = file.read(most_bytes + 1)
    except OSError as error:
        raise InputError(f"can't be read: {error.strerror or error}", file=name) from None
    if len(data) > most_bytes:
        raise InputError(
            f"larger than {most_bytes / 1e6:,.0f} MB", file=name, hint="limits.bytes allows more"
        )  # fmt: skip
    return data


def write_whole(path: Path, data: bytes) -> None:
    """Writes a file so that it appears whole or not at all, with the permissions a new file would have.

    Raises:
        OutputError: the folder is missing or read-only, the disk is full; what stood there still does.
    """
    handle, temporary = -1, ""
    try:
        # Beside the target: only within one file system is the replacement a single step.
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".footfix-", suffix=".tmp")
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


def _umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask

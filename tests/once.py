"""What is made once in a run of the tests, by whichever of its processes wants it first."""

from __future__ import annotations

import os
import pickle
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

FOLDER = "FOOTFIX_TESTS_ONCE"  # environment variable: a folder of this run, set by conftest

_Value = TypeVar("_Value")
_MADE: dict[str, object] = {}


def remembered(key: str, make: Callable[[], _Value]) -> _Value:
    """Make a value that this process, or another one of the run, may have made; nobody is waited for.

    Args:
        key: of all that the value depends on.
        make: gives it; what it gives can be pickled, and is never changed.
    """
    if key not in _MADE:
        folder = os.environ.get(FOLDER)
        made = Path(folder or "") / f"{key}.pickle"
        if folder is not None and made.exists():
            _MADE[key] = pickle.loads(made.read_bytes())
        else:
            _MADE[key] = make()
            if folder is not None:
                _keep(made, _MADE[key])
    return _MADE[key]  # type: ignore[return-value]


def _keep(made: Path, value: object) -> None:
    """Write a value so that its file is there whole or not at all."""
    part = made.with_suffix(f".{os.getpid()}")
    part.write_bytes(pickle.dumps(value))
    part.replace(made)


def once(name: str, make: Callable[[], _Value]) -> _Value:
    """Make a value, or take the one that another process of the run has made.

    Args:
        name: of the value.
        make: gives it; what it gives can be pickled.
    """
    folder = os.environ.get(FOLDER)
    if folder is None:
        return make()
    made, begun = Path(folder) / f"{name}.pickle", Path(folder) / f"{name}.begun"
    try:
        begun.touch(exist_ok=False)
    except FileExistsError:
        until = time.monotonic() + 120.0
        while not made.exists() and begun.exists() and time.monotonic() < until:
            time.sleep(0.05)
        if made.exists():
            return pickle.loads(made.read_bytes())  # type: ignore[no-any-return]
    try:
        value = make()
    except BaseException:
        begun.unlink()  # what failed here is not waited for elsewhere
        raise
    _keep(made, value)
    return value

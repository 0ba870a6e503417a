"""The fields of glTF's JSON, none of them believed: a file may say anything."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from footfix.errors import InputError
from footfix.motion.clip import Floats

Row = Mapping[str, Any]

_MOST = 1 << 40  # no count or offset of a file that fits in memory is larger


def table(tree: Row, key: str) -> list[dict[str, Any]]:
    """Get a top-level list of objects, such as "nodes"; an empty one where there is none.

    Raises:
        InputError: it is something else.
    """
    return _objects(tree.get(key, []), repr(key))


def child(row: Row, key: str, where: str) -> dict[str, Any]:
    """Get an object within another one; an empty one where there is none.

    Raises:
        InputError: it is something else.
    """
    found = row.get(key, {})
    if not isinstance(found, dict):
        raise InputError(f"{where}.{key} is no object")
    return found


def rows_of(row: Row, key: str, where: str) -> list[dict[str, Any]]:
    """Get a list of objects within an object; an empty one where there is none.

    Raises:
        InputError: it is something else.
    """
    return _objects(row.get(key, []), f"{where}.{key}")


def _objects(found: Any, what: str) -> list[dict[str, Any]]:
    """Check that a value is a list of objects."""
    if not isinstance(found, list) or not all(isinstance(each, dict) for each in found):
        raise InputError(f"{what} is no list of objects")
    return found


def whole(row: Row, key: str, where: str, *, default: int | None = None, least: int = 0, below: int = _MOST) -> int:
    """Get a whole number.

    Args:
        row: the object that has it.
        key: of the number.
        where: what the object is called in errors, such as "accessors[3]".
        default: where the object has none; without it the number is needed.
        least, below: what it may be.

    Raises:
        InputError: it is missing, no whole number, or out of its bounds.
    """
    value = row.get(key, default)
    if value is None:
        raise InputError(f"{where} has no {key}")
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, bool) or not isinstance(value, int):
        raise InputError(f"{where}.{key} is {_short(value)}, no whole number")
    if not least <= value < below:
        raise InputError(f"{where}.{key} is {_short(value)}, not within {least} and {below - 1}")
    return value


def index(row: Row, key: str, where: str, size: int) -> int | None:
    """Get an index into a list of `size`; None where the object has none.

    Raises:
        InputError: there is no such entry.
    """
    if row.get(key) is None:
        return None
    value = row[key]
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < size:
        raise InputError(f"{where}.{key} is {_short(value)}, but there are {size} of them")
    return value


def indices(row: Row, key: str, where: str, size: int) -> list[int]:
    """Get a list of indices into a list of `size`; an empty one where there is none.

    Raises:
        InputError: one of them names nothing.
    """
    found = row.get(key, [])
    if not isinstance(found, list):
        raise InputError(f"{where}.{key} is no list")
    for value in found:
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < size:
            raise InputError(f"{where}.{key} names {_short(value)}, but there are {size} of them")
    return found


def floats(row: Row, key: str, where: str, default: list[float]) -> Floats:
    """Get numbers, as many as the default has.

    Raises:
        InputError: there are more or less, or some are no numbers.
    """
    found = row.get(key, default)
    good = isinstance(found, list) and len(found) == len(default)
    if not good or not all(_is_number(value) for value in found):
        raise InputError(f"{where}.{key} is not {len(default)} numbers")
    return np.array(found, dtype=np.float64)


def text(row: Row, key: str) -> str:
    """Get a name or another text; an empty one where there is none."""
    value = row.get(key, "")
    return value if isinstance(value, str) else ""


def _is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) < 1e30 if isinstance(value, int) else math.isfinite(value)


def _short(value: Any) -> str:
    said = repr(value) if not isinstance(value, int) or abs(value) < 10**30 else "a huge number"
    return said if len(said) < 60 else f"{said[:57]}..."

"""Plans of locomotion in YAML: what speed, gait, turn and style are wanted at which time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from footfix.errors import InputError

_KEYS = ("time", "speed", "run", "turn", "style")


@dataclass(frozen=True)
class PlanRow:
    """What is wanted at a time; None where the rows beside it tell.

    Args:
        time: [s].
        speed: [m/s].
        run: 0 for a walk, 1 for a run.
        turn: [degrees/s] to the left.
        style: weights of styles by name.
    """

    time: float
    speed: float | None = None
    run: float | None = None
    turn: float | None = None
    style: Mapping[str, float] | None = None


def decode_plan(data: bytes, *, name: str = "") -> tuple[PlanRow, ...]:
    """Read a plan: a list of rows in order of time, or a mapping with such a list as its `plan`.

    Raises:
        InputError: it is not a plan; the message names the row.
    """
    try:
        read = yaml.safe_load(data)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        raise InputError("this is no YAML", file=name, line=mark.line + 1 if mark else None) from None
    if isinstance(read, Mapping) and set(read) == {"plan"}:
        read = read["plan"]
    if not isinstance(read, Sequence) or isinstance(read, str) or not read:
        raise InputError("a plan is a list of rows such as {time: 0, speed: 1.2, run: 0}", file=name)
    rows = [_row(each, k, name) for k, each in enumerate(read, start=1)]
    for k in range(1, len(rows)):
        if rows[k].time <= rows[k - 1].time:
            text = f"row {k + 1} is at {rows[k].time:g} s, not after row {k} at {rows[k - 1].time:g} s"
            raise InputError(text, file=name)
    return tuple(rows)


def _row(row: Any, number: int, name: str) -> PlanRow:
    if not isinstance(row, Mapping) or "time" not in row:
        raise InputError(f"row {number} of the plan has no time; a row is {{time: SECONDS, ...}}", file=name)
    for key in row:
        if key not in _KEYS:
            raise InputError(f"row {number} of the plan: {key!r} is none of {', '.join(_KEYS)}", file=name)
    values: dict[str, Any] = {}
    for key, low, high in (("time", 0.0, 86400.0), ("speed", 0.0, 100.0), ("run", 0.0, 1.0), ("turn", -720.0, 720.0)):
        value = row.get(key)
        if value is None:
            continue
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
            text = f"row {number} of the plan: {key} must be a number {low:g} to {high:g}, not {value!r}"
            raise InputError(text, file=name)
        values[key] = float(value)
    style = row.get("style")
    if isinstance(style, str):
        style = {style: 1.0}
    if style is not None:
        if not isinstance(style, Mapping) or not all(isinstance(w, (int, float)) for w in style.values()):
            raise InputError(f"row {number} of the plan: style must be a name, or weights by name", file=name)
        values["style"] = {str(key): float(weight) for key, weight in style.items()}
    return PlanRow(**values)

"""What the fields of parameters and measures mean: read from the docstrings of their classes, where they stand once.

A docstring gives a field as `name: meaning [unit]` below `Args:`; the unit may also come first, several names may share
a line, and what goes on is indented further.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from dataclasses import dataclass
from typing import Any

_ENTRY = re.compile(r"( +)(\w+(?:, \w+)*): (.*)")
_UNIT = re.compile(r"\s*\[([^\]]+)\]")


@dataclass(frozen=True)
class Meaning:
    """What a field is.

    Args:
        text: in one line, without a full stop.
        unit: "" where it has none, as a name or a choice.
    """

    text: str
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.text} [{self.unit}]" if self.unit else self.text


def meanings(kind: type[Any]) -> dict[str, Meaning]:
    """Read the meaning of each field of a dataclass that its docstring names, in the order of the fields.

    Args:
        kind: the class.
    """
    said: dict[str, str] = {}
    names: list[str] = []
    depth = 0
    _, _, listed = inspect.cleandoc(kind.__doc__ or "").partition("\nArgs:\n")
    for line in listed.splitlines():
        entry = _ENTRY.fullmatch(line)
        indent = len(line) - len(line.lstrip())
        if not line.strip() or indent == 0:
            break
        if entry and (not names or indent <= depth):
            names, depth = entry[2].split(", "), indent
            said.update(dict.fromkeys(names, entry[3]))
        else:
            said.update({name: f"{said[name]} {line.strip()}" for name in names})
    return {each.name: _meaning(said[each.name]) for each in dataclasses.fields(kind) if each.name in said}


def _meaning(text: str) -> Meaning:
    unit = _UNIT.search(text)
    return Meaning(_UNIT.sub("", text, count=1).strip().rstrip("."), unit[1] if unit else "")

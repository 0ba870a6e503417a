"""Annotations that GitHub shows beside a file: workflow commands, one a line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

Level = Literal["error", "warning", "notice"]
_LEVELS: Mapping[str, Level] = {"error": "error", "warning": "warning", "note": "notice"}


def annotation(level: Level, file: str, message: str, *, line: int | None = None, title: str = "footfix") -> str:
    """Make one workflow command, escaped so that no file name can end it or begin another."""
    place = f"file={_value(file)}" + (f",line={line}" if line is not None else "")
    return f"::{level} {place},title={_value(title)}::{_data(message)}"


def of_note(file: str, note: Mapping[str, Any]) -> str:
    """Make an annotation of a report's note."""
    level = _LEVELS.get(str(note.get("severity")), "notice")
    return annotation(level, file, str(note.get("text", "")), line=note.get("line"), title=f"footfix {note['id']}")


def _data(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _value(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")

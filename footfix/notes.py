"""Notes: what a stage has to tell the user, as data, so that text, JSON, HTML and tests see the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Severity = Literal["note", "warning", "error"]


@dataclass(frozen=True)
class Note:
    """One thing worth telling.

    Args:
        id: stable, lower case with hyphens (`floor-ambiguous`); tests and scripts match on it.
        text: one sentence for a person, ending without a full stop.
        severity: "note" (good to know), "warning" (look at this), "error" (can't be used).
        start, end: the frames it is about, `[start, end)`, if it is about some.
        joints: names of the joints it is about.
        line, column: the place in the file, 1-based, if it is about the text of the file.
    """

    id: str
    text: str
    severity: Severity = "note"
    start: int | None = None
    end: int | None = None
    joints: tuple[str, ...] = ()
    line: int | None = None
    column: int | None = None

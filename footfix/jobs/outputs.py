"""The outputs of one clip, ready to be written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from footfix.report.offenders import Offender

Status = Literal["cleaned", "unchanged", "failed"]


@dataclass(frozen=True)
class Outputs:
    """The outputs of one clip.

    Args:
        status: "cleaned", or "unchanged" where nothing needed correction.
        motion: the corrected file; the same bytes as the input where nothing changed.
        contacts: the contacts file.
        report: the report file as a document.
        pages: further outputs by suffix (".report.html", ".png").
        offenders: the worst plants as small pictures, where a page is made.
    """

    status: Status
    motion: bytes
    contacts: bytes
    report: Mapping[str, Any]
    pages: Mapping[str, bytes] = field(default_factory=dict)
    offenders: tuple[Offender, ...] = ()

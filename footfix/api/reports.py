"""Reports of what was cleaned: as data, in a few lines of text, and as a page."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from pathlib import Path, PurePath
from typing import Any

from footfix.api.parameters import check_settings
from footfix.errors import ArgumentError
from footfix.formats.bvh import compose
from footfix.formats.document import Document, rewrite
from footfix.formats.suffixes import in_file
from footfix.input_checks import check_clip
from footfix.jobs import clean as job
from footfix.jobs.contacts import contacts_json
from footfix.jobs.outputs import Outputs
from footfix.motion.clip import Clip
from footfix.motion.contacts import joined as all_contacts
from footfix.pipeline import Result
from footfix.report.pages import PAGE, draw
from footfix.report.text import summarize
from footfix.rig.rig import joined
from footfix.settings import ReportParams, Settings

__all__ = ["clean_file", "make_page", "make_report", "summarize"]


def clean_file(
    path: str | os.PathLike[str], settings: Settings | None = None, *, labels: str | os.PathLike[str] | None = None
) -> Outputs:
    """Clean one file, as `footfix clean` does, and write nothing.

    Args:
        path: a file of motion; of a glTF file with several animations one of them, character.glb#Walk.
        settings: the parameters of all steps.
        labels: a file of contact labels; what it does not name is detected.

    Returns:
        The bytes of the corrected file (`.motion`), of the contacts file and of the page, and the report document.

    Raises:
        InputError: the clip or the labels can't be used; says why.
        OSError: a file can't be opened.
    """
    from footfix.formats.contacts import decode

    given = None if labels is None else decode(Path(labels).read_bytes(), name=os.fspath(labels))
    file = os.fspath(path) if Path(path).exists() else in_file(os.fspath(path))[0]
    return job.clean_file(
        Path(file).read_bytes(), os.fspath(path), check_settings(settings), labels=given,
        beside=lambda name: (Path(file).parent / name).read_bytes(),
    )  # fmt: skip


def source_of(clip: Clip, like: Document | None) -> dict[str, Any]:
    """Say what a report is about: the file, or a clip that came from arrays as `save` would write it."""
    data = compose(clip) if like is None else rewrite(like, like.clip)[0]
    name = "clip.bvh" if like is None else PurePath(like.name).name
    return {
        "file": name,
        "sha256": hashlib.sha256(data).hexdigest(),
        "frames": len(clip),
        "frame_time": clip.frame_time,
    }


def make_report(
    result: Result | Sequence[Result], before: Clip, *, like: Document | None = None, settings: Settings | None = None
) -> dict[str, Any]:
    """Make the report of a cleaned clip, as `footfix clean` writes it (schema report.v1.json).

    `after` is measured on the arrays; `clean_file` measures what is written, to the decimals of the file.

    Args:
        result: what `clean` or `clean_figures` gave.
        before: the clip that came in; parent-local positions, metres, y up.
        like: the document that the clip came from.
        settings: those that it was cleaned with.

    Raises:
        ArgumentError: the clip is another one.
    """
    results = _each(result)
    check_clip(before)
    if len(results[0].clip) != len(before):
        raise ArgumentError(f"the result has {len(results[0].clip)} frames, and the clip before {len(before)}")
    unit_m, up, notes = (1.0, "y", ()) if like is None else (like.unit_m, like.up, like.notes)
    return job.report_of(
        before, results, source_of(before, like), check_settings(settings), unit_m=unit_m, up=up, notes=notes,
        status="unchanged" if results[0].clip is before else "cleaned", output=None,
    )  # fmt: skip


def make_page(
    result: Result | Sequence[Result], before: Clip, *, like: Document | None = None, settings: Settings | None = None
) -> bytes:
    """Draw the page of a cleaned clip: one HTML file that needs nothing else.

    Args:
        result: what `clean` or `clean_figures` gave.
        before: the clip that came in; parent-local positions, metres, y up.
        like: the document that the clip came from.
        settings: those that it was cleaned with.

    Raises:
        ArgumentError: the clip is another one.
    """
    results = _each(result)
    report = make_report(results, before, like=like, settings=settings)
    contacts = contacts_json(
        all_contacts([each.contacts for each in results]), report["source"], report["rig"], check_settings(settings)
    )
    rig = joined([each.rig for each in results])
    return draw(before, results[0].clip, rig, report, contacts, ReportParams(kind="html"))[0][PAGE]


def _each(result: Result | Sequence[Result]) -> tuple[Result, ...]:
    """List the results of all figures of a clip, of which there may be one."""
    return (result,) if isinstance(result, Result) else tuple(result)

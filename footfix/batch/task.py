"""What goes to a worker and what comes back: one clip's task and its result, and the names of its outputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from footfix.batch.outputs import Job

if TYPE_CHECKING:
    from footfix.formats.contacts import Labels
    from footfix.report.offenders import Offender
    from footfix.settings import Settings

REPORT, PAGE, PICTURE, CONTACTS = ".report.json", ".report.html", ".report.png", ".contacts.json"
EVENTS = ".events.json"


@dataclass(frozen=True)
class Task:
    """A job and all that is needed to do it anywhere.

    Args:
        job: the clip and its outputs.
        settings: the parameters that hold for this clip.
        labels: contacts given for it.
        clip_labels: where the file holds several clips, contacts given for them by their names in names of files.
        animations: of a file that holds several clips, those that are asked for; all by default.
        dry_run: do everything but write.
        force: outputs that are there may be overwritten.
        resume: leave what is done for the same input, settings and version.
        wrote: for a run that is resumed, file name -> SHA-256 of what it wrote for this clip before, as far as
            that is known; None where it had not begun with it, so that files in the way are not its own.
        tag: of the run, in the names of its temporary files.
        folder: what relative paths are relative to.
        keep_report: hand the whole report back, not only what a summary needs.
        extra: what else a kind of work needs.
    """

    job: Job
    settings: Settings
    labels: Labels | None = None
    clip_labels: Mapping[str, Labels] = field(default_factory=dict)
    animations: tuple[str, ...] = ()
    dry_run: bool = False
    force: bool = False
    resume: bool = False
    wrote: Mapping[str, str] | None = None
    tag: str = "run"
    folder: str = ""
    keep_report: bool = True
    extra: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class FileResult:
    """What became of one clip: small, plain and picklable.

    Args:
        source: path of the input.
        status: "cleaned", "unchanged" or "failed"; of other commands "done", "over" (a gate) or "failed".
        error: for a person, where it failed.
        line: of the input, where the error is about one.
        report: the report document or what the command makes in its place; a digest of it in large runs.
        written: paths of the outputs.
        hashes: file name -> SHA-256 of each output.
        data: bytes for standard output.
        offenders: its worst plants, as small pictures.
        skipped: True where it was done already.
        bug: True where the failure is ours, not the file's.
        parts: of a file that holds several clips, what became of each.
        seconds: [s] the clip took; only what is told of a run may hold it, never an output of the clip.
    """

    source: str
    status: str
    error: str = ""
    line: int | None = None
    report: Mapping[str, Any] = field(default_factory=dict)
    written: tuple[str, ...] = ()
    hashes: Mapping[str, str] = field(default_factory=dict)
    data: bytes = b""
    offenders: tuple[Offender, ...] = ()
    skipped: bool = False
    bug: bool = False
    parts: tuple[FileResult, ...] = ()
    seconds: float = 0.0


def beside(settings: Settings) -> tuple[str, ...]:
    """List what the names of the outputs beside a corrected clip end in."""
    kind, png = settings.report.kind, settings.report.png
    asked = {REPORT: kind != "none", PAGE: kind == "html", PICTURE: png}
    return (CONTACTS, *(suffix for suffix, wanted in asked.items() if wanted))

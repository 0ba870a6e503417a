"""A clip's task, which is sent to a worker, and its result, which is sent back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from footfix.batch.output_paths import Job

if TYPE_CHECKING:
    from footfix.formats.contacts import Labels
    from footfix.report.offenders import Offender
    from footfix.settings import Settings

REPORT, PAGE, PICTURE, CONTACTS = ".report.json", ".report.html", ".report.png", ".contacts.json"
EVENTS = ".events.json"


@dataclass(frozen=True)
class Task:
    """A job with everything needed to do it in any process.

    Args:
        job: the clip and its outputs.
        settings: the parameters that hold for this clip.
        labels: contacts given for it.
        clip_labels: contacts given for the clips of a file that holds several, by the clips' names in file names.
        animations: the clips to take from a file that holds several; all by default.
        dry_run: do everything but write.
        force: existing outputs may be overwritten.
        resume: skip what is done for the same input, settings and version.
        wrote: for a run that is resumed, file name -> SHA-256 of what it wrote for this clip before, as far as
            that is known; None where it had not begun the clip, so that existing files are not its own.
        tag: of the run, in the names of its temporary files.
        folder: of relative paths in the settings.
        keep_report: return the whole report, not only what a summary needs.
        extra: further arguments of the command.
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
    """The result of one clip: small, plain and picklable.

    Args:
        source: path of the input.
        status: "cleaned", "unchanged" or "failed"; of other commands "done", "over" (a gate) or "failed".
        error: why it failed, in words.
        line: of the input, where the error is about one.
        report: the report document, or the document that the command makes instead; a digest of it in large runs.
        written: paths of the outputs.
        hashes: file name -> SHA-256 of each output.
        data: bytes for standard output.
        offenders: its worst plants, as small pictures.
        skipped: True where it was done by an earlier run.
        bug: True where the failure is a bug of footfix, not the file's.
        parts: the results of the clips of a file that holds several.
        seconds: [s] the clip took; shown for a run, never written into outputs of the clip.
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

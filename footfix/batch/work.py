"""One clip of a batch, from its file to its output files; the same here, in a worker process and on a cluster."""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from footfix.batch.cleanings import contacts_it_was_cleaned_by
from footfix.batch.files import STDIN, read_whole, sync_folder, write_whole
from footfix.batch.outputs import is_within
from footfix.batch.task import CONTACTS, REPORT, FileResult, Task, beside
from footfix.errors import FootfixError, InputError, OutputError
from footfix.version import __version__

if TYPE_CHECKING:
    from footfix.formats.contacts import Labels
    from footfix.job import Outputs
    from footfix.settings import Settings


def fingerprint(data: bytes, settings: Settings, labels: Labels | None) -> str:
    """What an output depends on, as one hash: the input's bytes, the settings, given labels and the version."""
    from footfix.settings import plain

    digest = hashlib.sha256()
    for part in (hashlib.sha256(data).digest(), json.dumps(plain(settings), sort_keys=True).encode(),
                 repr(labels).encode("utf-8", "surrogateescape"), __version__.encode()):  # fmt: skip
        digest.update(hashlib.sha256(part).digest())
    return digest.hexdigest()


def clean_one(task: Task) -> FileResult:
    """Cleans one clip and writes its outputs, the report last: where that is, all of it is."""
    return guarded(task, _clean)


def loop_one(task: Task) -> FileResult:
    """Cuts a loop out of one clip and writes its outputs, the report last."""
    return guarded(task, _loop)


def detect_one(task: Task) -> FileResult:
    """Finds the contacts of one clip, and writes them or hands them back; `extra["kind"]` is the format."""
    return guarded(task, _detect)


def inspect_one(task: Task) -> FileResult:
    """Looks into one file."""
    return guarded(task, _inspect)


def repair_one(task: Task) -> FileResult:
    """Writes what a strict reader wants of one file."""
    return guarded(task, _repair)


def check_one(task: Task) -> FileResult:
    """Measures one clip and holds it against `extra["gates"]`."""
    return guarded(task, _check)


def guarded(task: Task, work: Any) -> FileResult:
    """The result of some work and the time it took, whatever happens: one clip's failure is never that of others."""
    begun = time.perf_counter()
    return replace(_ended(task, work), seconds=time.perf_counter() - begun)


def _ended(task: Task, work: Any) -> FileResult:
    source = task.job.source
    try:
        result: FileResult = work(task)
        return result
    except InputError as error:
        return FileResult(source, "failed", error=str(error), line=error.line)
    except FootfixError as error:
        return FileResult(source, "failed", error=str(error))
    except MemoryError:
        return FileResult(source, "failed", error=f"{source}: not enough memory for this clip")
    except OSError as error:
        return FileResult(source, "failed", error=f"{source}: {error.strerror or error}")
    except Exception as error:
        if os.environ.get("FOOTFIX_DEBUG"):
            raise
        said = f"{source}: a bug in footfix, not in your file: {type(error).__name__}: {error}"
        return FileResult(source, "failed", error=said, bug=True)


def _read(task: Task) -> bytes:
    from footfix.formats.document import glance

    source = task.job.source
    path = source if source == STDIN else str(Path(task.folder, source))
    try:
        return read_whole(path, task.settings.limits.bytes, partial(glance, name=source, limits=task.settings.limits))
    except InputError as error:
        raise error.within(source) from None


def _clean(task: Task) -> FileResult:
    from footfix.job import clean_file
    from footfix.report.again import clean_again

    job, again = task.job, None
    if job.target is not None and job.source != STDIN:
        here = Path(task.folder)
        again = clean_again(here / job.source, here / job.target, here / job.beside(CONTACTS), task.settings)

    def make(data: bytes, name: str, settings: Settings, *, labels: Labels | None, output: str | None) -> Outputs:
        own, leave = contacts_it_was_cleaned_by(task, data), ""
        if own is not None:
            labels = own
            leave = f"footfix wrote this file, as {own.source} says, so it stays as it is; --anew cleans it again"
        return clean_file(data, name, settings, labels=labels, output=output, again=again, leave=leave)

    return _made(task, make)


def _loop(task: Task) -> FileResult:
    from footfix.looping import loop_file
    from footfix.report.again import clean_loop_again

    job, again = task.job, None
    if job.target is not None:
        here = Path(task.folder)
        again = clean_loop_again(here / job.target, here / job.beside(CONTACTS), task.settings)
    return _made(task, partial(loop_file, again=again), "loop")


def _made(task: Task, make: Callable[..., Outputs], what: str = "") -> FileResult:
    """What `make` makes of a clip's bytes, written; `what` tells it from what cleaning makes of the same bytes."""
    job = task.job
    data = _read(task)
    key = what + fingerprint(data, task.settings, task.labels)
    done = _finished(task, key) if task.resume else None
    if done is not None:
        return done
    output = None if job.target is None else job.target.name
    outputs = make(data, job.source, task.settings, labels=task.labels, output=output)
    return write_outputs(task, outputs, {**outputs.report, "fingerprint": key})


def write_outputs(task: Task, outputs: Outputs, report: Mapping[str, Any]) -> FileResult:
    """Writes the outputs of a clip, with the hash of its motion in the report."""
    job = task.job
    report = {**report, "output_sha256": hashlib.sha256(outputs.motion).hexdigest()}
    files = {} if job.target is None or task.dry_run else _files(task, outputs, report)
    _write(task, files)
    return FileResult(
        job.source,
        outputs.status,
        report=report if task.keep_report else digest(report),
        written=tuple(map(str, files)),
        hashes={path.name: hashlib.sha256(content).hexdigest() for path, content in files.items()},
        data=outputs.motion if job.target is None and not task.dry_run else b"",
        offenders=outputs.offenders,
    )


def _files(task: Task, outputs: Outputs, report: Mapping[str, Any]) -> dict[Path, bytes]:
    """Every output of a clip and its bytes, in the order in which they are written."""
    job = task.job
    assert job.target is not None
    files = {job.beside(CONTACTS): outputs.contacts}
    files |= {job.beside(suffix): page for suffix, page in outputs.pages.items()}
    files[job.target] = outputs.motion
    if task.settings.report.kind != "none":
        text = json.dumps(report, indent=1, ensure_ascii=False) + "\n"
        files[job.beside(REPORT)] = text.encode("utf-8", "surrogateescape")
    return files


def _write(task: Task, files: Mapping[Path, bytes]) -> None:
    """Writes the outputs, the last one only when the others are safe on disk."""
    paths = [(Path(task.folder, path), path, data) for path, data in files.items()]
    if not paths:
        return
    folder = paths[0][0].parent
    folder.mkdir(parents=True, exist_ok=True)
    if task.job.within is not None and not is_within(paths[0][0], Path(task.folder, task.job.within)):
        raise OutputError(f"{paths[0][1]} would lie outside {task.job.within}: a part of its path is a link")
    for path, shown, data in paths:
        _keep_edits(task, path, shown, data)
    new = [path for path, _, _ in paths if not os.path.lexists(path)]
    try:
        for k, (path, _, data) in enumerate(paths):
            if k == len(paths) - 1:
                sync_folder(folder)
            write_whole(path, data, tag=task.tag)
    except OutputError:  # a set that is not whole would only be in the way of the next try
        for path in new:
            path.unlink(missing_ok=True)
        raise


def _keep_edits(task: Task, path: Path, shown: Path, data: bytes) -> None:
    """Raises where a resumed run would overwrite what is not its own, or what a person has changed since."""
    if not task.resume or not path.exists():
        return
    if task.wrote is None:
        raise OutputError(f"{shown}: is there already, made of another input or settings; --force overwrites it")
    before = task.wrote.get(path.name)
    if before is None:  # begun, not ended: whatever lies there, the interrupted run wrote it
        return
    now = hashlib.sha256(path.read_bytes()).hexdigest()
    if now not in (before, hashlib.sha256(data).hexdigest()):
        raise OutputError(f"{shown}: was changed since footfix wrote it; --force overwrites it")


def _finished(task: Task, key: str) -> FileResult | None:
    """What an earlier run made of a clip, if it is whole and of the same input, settings and version."""
    job = task.job
    if job.target is None or task.settings.report.kind == "none":
        return None
    if task.wrote is not None and not task.wrote:
        return None  # begun, and its end not recorded: what the index shows of it is lost, so it is done again
    try:
        report = json.loads(Path(task.folder, job.beside(REPORT)).read_bytes())
    except (OSError, ValueError):
        return None
    if not isinstance(report, dict) or report.get("fingerprint") != key:
        return None
    wanted = [job.target, *(job.beside(suffix) for suffix in beside(task.settings) if suffix != REPORT)]
    if not all(Path(task.folder, path).is_file() for path in wanted):
        return None
    return FileResult(
        job.source,
        str(report["status"]),
        report=report if task.keep_report else digest(report),
        written=(*map(str, wanted), str(job.beside(REPORT))),
        skipped=True,
    )


def digest(report: Mapping[str, Any]) -> dict[str, Any]:
    """What summaries and indexes need of a report, so that ten thousand of them fit in memory."""
    kept = ("effector", "start", "end", "slide_before_mm", "slide_after_mm", "outcome", "reason")
    return {
        **{key: report[key] for key in ("source", "status", "method", "before", "after", "correction", "notes")},
        **({"loop": report["loop"]} if "loop" in report else {}),
        "plants": [{key: plant[key] for key in kept} for plant in report["plants"]],
    }


def _detect(task: Task) -> FileResult:
    from footfix.formats.contacts import ENCODERS
    from footfix.job import contacts_json, detect_file

    job, kind = task.job, task.extra["kind"]
    contacts, entry, rig, notes = detect_file(_read(task), job.source, task.settings, labels=task.labels)
    if kind == "json":
        encoded = contacts_json(contacts, entry, rig, task.settings)
    else:
        encoded = ENCODERS[kind][1](contacts)
    report = {
        "contacts": sum(len(effector.contacts) for effector in contacts.effectors),
        "effectors": {effector.name: len(effector.contacts) for effector in contacts.effectors},
        "coverage": float(contacts.mask().mean()) if contacts.effectors else 0.0,
        "notes": notes,
    }
    if job.target is None or task.dry_run:
        return FileResult(job.source, "done", report=report, data=encoded)
    _write(task, {job.target: encoded})
    return FileResult(job.source, "done", report=report, written=(str(job.target),))


def _inspect(task: Task) -> FileResult:
    from footfix.inspection import inspect_file

    return FileResult(task.job.source, "done", report=inspect_file(_read(task), task.job.source, task.settings))


def _repair(task: Task) -> FileResult:
    from footfix.inspection import repair_file

    job = task.job
    mended, notes = repair_file(_read(task), job.source, task.settings)
    report = {"notes": notes}
    if job.target is None:
        return FileResult(job.source, "done", report=report, data=mended)
    _write(task, {job.target: mended})
    return FileResult(job.source, "done", report=report, written=(str(job.target),))


def _check(task: Task) -> FileResult:
    from footfix.batch.gates import check

    return check(task, _read(task))

"""The work on one file of a batch, from disk to output files; the same here, in a worker process and on a cluster."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from footfix.batch.attempt import attempted
from footfix.batch.earlier_results import contacts_of_cleaning
from footfix.batch.file_io import STDIN, read_clip
from footfix.batch.multi_clip_files import beside_of, joined_result, parts_of, spread
from footfix.batch.skins import skin_for
from footfix.batch.task import CONTACTS, EVENTS, FileResult, Task
from footfix.batch.write_outputs import made, write
from footfix.errors import InputError, OutputError
from footfix.formats.suffixes import STDIN_NAME, in_file

if TYPE_CHECKING:
    from footfix.jobs.outputs import Outputs
    from footfix.report.rerun_command import RerunCommand

Work = Callable[[Task, bytes], FileResult]


def clean_one(task: Task) -> FileResult:
    """Clean one clip and write its outputs, the report last: where that is, all of it is."""
    return _guarded(task, _clean)


def loop_one(task: Task) -> FileResult:
    """Cut a loop out of one clip and write its outputs, the report last."""
    return _guarded(task, _loop)


def detect_one(task: Task) -> FileResult:
    """Find the contacts of one clip, and write or return them; `extra["kind"]` is the format."""
    return _guarded(task, _detect)


def inspect_one(task: Task) -> FileResult:
    """Describe one file."""
    return _guarded(task, _each(_inspect, poses=True))


def repair_one(task: Task) -> FileResult:
    """Repair one file so that strict readers can read it."""
    return _guarded(task, _repair)


def check_one(task: Task) -> FileResult:
    """Measure one clip and compare it with `extra["gates"]`."""
    return _guarded(task, _each(_check))


def sample_one(task: Task) -> FileResult:
    """Find the straight cycles of each clip of a file, of the style `extra["style"]`, and return them."""
    return _guarded(task, _each(_sample))


def _guarded(task: Task, work: Work) -> FileResult:
    """Return the result of some work, with the time it took."""
    begun = time.perf_counter()

    def done() -> FileResult:
        data = _read(task)
        return work(_as_it_is(task, data), data)

    result = attempted(task, done)
    return replace(result, seconds=time.perf_counter() - begun)


def _as_it_is(task: Task, data: bytes) -> Task:
    """Name the task after the format that standard input holds, where that is not BVH."""
    job = task.job
    if job.source != STDIN or not data.startswith(b"glTF"):
        return task
    target = job.target
    if target is not None and target.name == STDIN_NAME:
        target = target.with_suffix(".glb")
    return replace(task, job=replace(job, source="stdin.glb", target=target))


def _each(work: Work, *, poses: bool = False) -> Work:
    """Do some work on every clip of a file, those too short to hold a motion (`poses`) left out."""

    def done(task: Task, data: bytes) -> FileResult:
        parts = parts_of(task, data, poses=poses)
        if parts is None:
            return work(task, data)
        return joined_result(task, [attempted(part, partial(work, part, data)) for part in parts])

    return done


def _read(task: Task) -> bytes:
    source = task.job.source
    path = source if source == STDIN else str(Path(task.folder, source))
    return read_clip(path, task.settings.limits, name=source)


def _clean(task: Task, data: bytes) -> FileResult:
    from footfix.jobs.clean import clean_file

    def make(part: Task) -> Outputs:
        own, leave, labels = contacts_of_cleaning(part, data), "", part.labels
        if own is not None:
            labels = own
            leave = f"footfix wrote this file, as {own.source} says, so it stays as it is; --anew cleans it again"
        return clean_file(
            data, part.job.source, part.settings, labels=labels, output=_output(part), again=_again(part),
            leave=leave, beside=beside_of(part), skin=skin_for(part.settings, part.folder),
        )  # fmt: skip

    return made(task, data, make)


def _loop(task: Task, data: bytes) -> FileResult:
    from footfix.jobs.loop import loop_file

    def make(part: Task) -> Outputs:
        again = _again(part, loop=True)
        return loop_file(
            data, part.job.source, part.settings, labels=part.labels, output=_output(part), again=again,
            beside=beside_of(part), skin=skin_for(part.settings, part.folder),
        )  # fmt: skip

    return made(task, data, make, "loop")


def _output(task: Task) -> str | None:
    return None if task.job.target is None else task.job.target.name


def _again(task: Task, *, loop: bool = False) -> RerunCommand | None:
    """Write the command that cleans a clip again from edited contacts; None where it has no path on disk."""
    from footfix.report.rerun_command import clean_again, clean_loop_again

    job, here = task.job, Path(task.folder)
    if job.target is None or (job.source == STDIN and not loop):
        return None
    contacts, target = here / job.beside(CONTACTS), here / job.target
    if loop:
        return clean_loop_again(target, contacts, task.settings, several=bool(job.end))
    return clean_again(here / in_file(job.source)[0], target, contacts, task.settings, several=bool(job.end))


def _detect(task: Task, data: bytes) -> FileResult:
    """Find the contacts of every clip of a file; write events beside them, or into a copy whose format has a place."""
    result = _each(_detect_clip)(task, data)
    wanted = task.extra.get("events") and task.job.target is not None and not task.dry_run
    return _annotated(task, data, result) if wanted else result


def _detect_clip(task: Task, data: bytes) -> FileResult:
    from footfix.formats.contacts import ENCODERS
    from footfix.formats.events import encode, events_of
    from footfix.jobs.contacts import contacts_json, detect_file

    kind, target = task.extra["kind"], _labels_of(task)
    contacts, entry, rig, notes, start = detect_file(
        data, task.job.source, task.settings, labels=task.labels, beside=beside_of(task),
        skin=skin_for(task.settings, task.folder),
    )  # fmt: skip
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
    if task.extra.get("events"):
        report["events"] = events_of(contacts, start=start)
    if target is None or task.dry_run:
        return FileResult(task.job.source, "done", report=report, data=encoded)
    files = {target: encoded}
    if task.extra.get("events"):
        files[task.job.beside(EVENTS)] = encode(contacts, entry, start=start)
    write(task, files)
    return FileResult(task.job.source, "done", report=report, written=tuple(map(str, files)))


def _labels_of(task: Task) -> Path | None:
    """Choose the path of a clip's labels; for a file of several clips, whose names are known only when it is read."""
    from footfix.formats.contacts import ENDS

    job, one = task.job, bool(task.extra.get("one_file"))
    if job.target is None:
        return None
    if job.end and one and len(task.animations) != 1:
        raise InputError("it holds several clips, and -o names one file", file=job.source, hint="name a folder")
    target = job.beside(ENDS[task.extra["kind"]]) if job.end and not one else job.target
    new = [target] if job.end else []
    for path in [*new, *([job.beside(EVENTS)] if task.extra.get("events") else [])]:
        if os.path.lexists(Path(task.folder, path)) and not (task.force or task.dry_run):
            raise OutputError(f"{path} is there already; --force overwrites it")
    return target


def _inspect(task: Task, data: bytes) -> FileResult:
    from footfix.jobs.inspect import inspect_file

    skin = skin_for(task.settings, task.folder)
    found = inspect_file(data, task.job.source, task.settings, beside=beside_of(task), skin=skin)
    return FileResult(task.job.source, "done", report=found)


def _sample(task: Task, data: bytes) -> FileResult:
    from footfix.jobs.fit_cycles import cycles_of_file

    name, style = task.job.source, task.extra["style"]
    found = cycles_of_file(data, name, task.settings, style=style, beside=beside_of(task))
    return FileResult(name, "done", report={"cycles": found})


def _repair(task: Task, data: bytes) -> FileResult:
    from footfix.jobs.inspect import repair_file

    job, parts = task.job, parts_of(task, data)
    name = job.source if not parts else parts[0].job.source
    mended, notes = repair_file(data, name, task.settings, beside=beside_of(task))
    report = {"notes": notes}
    if job.target is None:
        return FileResult(job.source, "done", report=report, data=mended)
    write(task, {job.target: mended})
    return FileResult(job.source, "done", report=report, written=(str(job.target),))


def _check(task: Task, data: bytes) -> FileResult:
    from footfix.batch.gates import check

    return check(task, data)


def _annotated(task: Task, data: bytes, result: FileResult) -> FileResult:
    """Write a copy of a file with the times when feet strike and lift, where its format has a place for them."""
    from footfix.formats.document import annotated, clips_of

    job = task.job
    assert job.target is not None and job.stem is not None
    names = clips_of(data, name=job.source, limits=task.settings.limits, beside=beside_of(task))
    good = [part for part in spread(result) if "events" in part.report]
    if names is None or not good:
        return result
    extras = {in_file(part.source)[1] or names[0]: {"footfix_events": part.report["events"]} for part in good}
    path = job.stem.with_name(f"{job.stem.name}.events{Path(in_file(job.source)[0]).suffix.lower()}")
    if os.path.lexists(Path(task.folder, path)) and not task.force:
        raise OutputError(f"{path} is there already; --force overwrites it")
    whole = annotated(data, extras, name=job.source, beside=beside_of(task))
    assert whole is not None
    write(task, {path: whole})
    return replace(result, written=(*result.written, str(path)))

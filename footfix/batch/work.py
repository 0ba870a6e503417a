"""One file of a batch, from the disk to its output files; the same here, in a worker process and on a cluster."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from footfix.batch.cleanings import contacts_it_was_cleaned_by
from footfix.batch.clips import beside_of, parts_of, together
from footfix.batch.ending import ended
from footfix.batch.files import STDIN, read_whole
from footfix.batch.making import made, write
from footfix.batch.skins import skin_for
from footfix.batch.task import CONTACTS, FileResult, Task
from footfix.errors import InputError, OutputError
from footfix.formats.suffixes import in_file

if TYPE_CHECKING:
    from footfix.job import Outputs
    from footfix.report.again import Again

Work = Callable[[Task, bytes], FileResult]


def clean_one(task: Task) -> FileResult:
    """Cleans one clip and writes its outputs, the report last: where that is, all of it is."""
    return _guarded(task, _clean)


def loop_one(task: Task) -> FileResult:
    """Cuts a loop out of one clip and writes its outputs, the report last."""
    return _guarded(task, _loop)


def detect_one(task: Task) -> FileResult:
    """Finds the contacts of one clip, and writes them or hands them back; `extra["kind"]` is the format."""
    return _guarded(task, _each(_detect))


def inspect_one(task: Task) -> FileResult:
    """Looks into one file."""
    return _guarded(task, _each(_inspect))


def repair_one(task: Task) -> FileResult:
    """Writes what a strict reader wants of one file."""
    return _guarded(task, _repair)


def check_one(task: Task) -> FileResult:
    """Measures one clip and holds it against `extra["gates"]`."""
    return _guarded(task, _each(_check))


def _guarded(task: Task, work: Work) -> FileResult:
    """The result of some work and the time it took."""
    begun = time.perf_counter()
    result = ended(task, lambda: work(task, _read(task)))
    return replace(result, seconds=time.perf_counter() - begun)


def _each(work: Work) -> Work:
    """Does some work on every clip of a file."""

    def done(task: Task, data: bytes) -> FileResult:
        parts = parts_of(task, data)
        if parts is None:
            return work(task, data)
        return together(task, [ended(part, partial(work, part, data)) for part in parts])

    return done


def _read(task: Task) -> bytes:
    from footfix.formats.document import glance

    source = task.job.source
    path = source if source == STDIN else str(Path(task.folder, source))
    try:
        return read_whole(path, task.settings.limits.bytes, partial(glance, name=source, limits=task.settings.limits))
    except InputError as error:
        raise error.within(source) from None


def _clean(task: Task, data: bytes) -> FileResult:
    from footfix.job import clean_file

    def make(part: Task) -> Outputs:
        own, leave, labels = contacts_it_was_cleaned_by(part, data), "", part.labels
        if own is not None:
            labels = own
            leave = f"footfix wrote this file, as {own.source} says, so it stays as it is; --anew cleans it again"
        return clean_file(
            data, part.job.source, part.settings, labels=labels, output=_output(part), again=_again(part),
            leave=leave, beside=beside_of(part), skin=skin_for(part.settings, part.folder),
        )  # fmt: skip

    return made(task, data, make)


def _loop(task: Task, data: bytes) -> FileResult:
    from footfix.looping import loop_file

    def make(part: Task) -> Outputs:
        again = _again(part, loop=True)
        return loop_file(
            data, part.job.source, part.settings, labels=part.labels, output=_output(part), again=again,
            beside=beside_of(part), skin=skin_for(part.settings, part.folder),
        )  # fmt: skip

    return made(task, data, make, "loop")


def _output(task: Task) -> str | None:
    return None if task.job.target is None else task.job.target.name


def _again(task: Task, *, loop: bool = False) -> Again | None:
    """How a clip is cleaned again from edited contacts; not known where it has no place on the disk."""
    from footfix.report.again import clean_again, clean_loop_again

    job, here = task.job, Path(task.folder)
    if job.target is None or (job.source == STDIN and not loop):
        return None
    contacts, target = here / job.beside(CONTACTS), here / job.target
    if loop:
        return clean_loop_again(target, contacts, task.settings, several=bool(job.end))
    return clean_again(here / in_file(job.source)[0], target, contacts, task.settings, several=bool(job.end))


def _detect(task: Task, data: bytes) -> FileResult:
    from footfix.formats.contacts import ENCODERS, ENDS
    from footfix.job import contacts_json, detect_file

    job, kind = task.job, task.extra["kind"]
    target = job.target
    if job.end and target is not None:
        if task.extra.get("one_file") and len(task.animations) != 1:
            raise InputError("it holds several clips, and -o names one file", file=job.source, hint="name a folder")
        target = target if task.extra.get("one_file") else job.beside(ENDS[kind])
        if os.path.lexists(Path(task.folder, target)) and not task.force:
            raise OutputError(f"{target} is there already; --force overwrites it")
    contacts, entry, rig, notes = detect_file(
        data, job.source, task.settings, labels=task.labels, beside=beside_of(task),
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
    if target is None or task.dry_run:
        return FileResult(job.source, "done", report=report, data=encoded)
    write(task, {target: encoded})
    return FileResult(job.source, "done", report=report, written=(str(target),))


def _inspect(task: Task, data: bytes) -> FileResult:
    from footfix.inspection import inspect_file

    skin = skin_for(task.settings, task.folder)
    found = inspect_file(data, task.job.source, task.settings, beside=beside_of(task), skin=skin)
    return FileResult(task.job.source, "done", report=found)


def _repair(task: Task, data: bytes) -> FileResult:
    from footfix.inspection import repair_file

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

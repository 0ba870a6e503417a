"""Many files: inputs -> jobs -> file results."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from footfix.errors import FootfixError, UsageError
from footfix.files import STDIN, read_whole, write_whole

# What a cleaned file's name ends in where it is written beside its input; such files are no inputs of a folder.
CLEAN_SUFFIX = ".clean.bvh"


@dataclass(frozen=True)
class Source:
    """An input and where it lies below what was named on the command line.

    Args:
        path: the file, or "-" for standard input.
        below: its path relative to the folder that was named; its name alone for a file that was named.
    """

    path: str
    below: Path


@dataclass(frozen=True)
class Job:
    """One clip to do.

    Args:
        source: path of the input, or "-".
        target: path of the corrected file, None where it goes to standard output or nowhere.
        stem: path without suffix, which the other outputs hang theirs on.
    """

    source: str
    target: Path | None
    stem: Path | None


@dataclass(frozen=True)
class FileResult:
    """What became of one clip: small, plain and picklable.

    Args:
        source: path of the input.
        status: "cleaned", "unchanged" or "failed"; of other commands "done" or "failed".
        error: for a person, where it failed.
        report: the report document, or what the command makes in its place.
        written: paths of the outputs.
        data: bytes for standard output.
    """

    source: str
    status: str
    error: str = ""
    report: Mapping[str, Any] = field(default_factory=dict)
    written: tuple[str, ...] = ()
    data: bytes = b""


def sources(named: Iterable[str]) -> tuple[Source, ...]:
    """The inputs that files, folders and "-" stand for.

    A folder gives its `*.bvh` files, of any case, sorted, at any depth; hidden ones and cleaned copies are
    left out.

    Raises:
        UsageError: one is not there, or a folder holds nothing.
    """
    found: dict[str, Source] = {}
    for name in named:
        path = Path(name)
        if name == STDIN:
            found.setdefault(name, Source(name, Path("stdin.bvh")))
        elif path.is_dir():
            below = list(_walk(path))
            if not below:
                raise UsageError(f"{name}: no BVH files in this folder")
            for each in below:
                found.setdefault(str(each), Source(str(each), each.relative_to(path)))
        elif path.exists():
            found.setdefault(name, Source(name, Path(path.name)))
        else:
            raise UsageError(f"{name}: no such file or folder")
    if not found:
        raise UsageError("nothing to do: name a BVH file, a folder, or - for standard input")
    return tuple(found.values())


def _walk(folder: Path) -> Iterator[Path]:
    for root, folders, files in os.walk(folder):
        folders[:] = sorted(each for each in folders if not each.startswith("."))
        for name in sorted(files):
            low = name.lower()
            if low.endswith(".bvh") and not low.endswith(CLEAN_SUFFIX) and not name.startswith("."):
                yield Path(root) / name


def plan(
    found: Sequence[Source], *, output: Path | None, in_place: bool, suffixes: Sequence[str], force: bool
) -> tuple[Job, ...]:
    """The jobs of a run, checked before any work.

    Args:
        found: the inputs.
        output: the folder that outputs go to; beside each input without one.
        in_place: the corrected file takes the input's place.
        suffixes: of the outputs beside the corrected file.
        force: outputs that exist may be overwritten.

    Raises:
        UsageError: two inputs would write one output, or an output is there already.
    """
    jobs: list[Job] = []
    owners: dict[str, str] = {}
    for source in found:
        if source.path == STDIN and output is None:
            jobs.append(Job(source.path, None, None))
            continue
        if output is not None:
            target = output / source.below
        else:
            path = Path(source.path)
            target = path if in_place else path.with_name(path.stem + CLEAN_SUFFIX)
        stem = (output / source.below if output is not None else Path(source.path)).with_suffix("")
        for each in (target, *(stem.with_name(stem.name + suffix) for suffix in suffixes)):
            key = os.path.normcase(os.path.realpath(each))
            if key in owners:
                raise UsageError(
                    f"{owners[key]} and {source.path} would both write {each}; use -o with folders, or rename one"
                )
            owners[key] = source.path
            if each.exists() and not force and not (in_place and each == target):
                raise UsageError(f"{each} is there already; --force overwrites it")
        if not in_place and any(
            os.path.realpath(target) == os.path.realpath(other.path) for other in found if other.path != STDIN
        ):
            raise UsageError(f"{target} is itself an input; write elsewhere, or say --in-place")
        jobs.append(Job(source.path, target, stem))
    return tuple(jobs)


def clean_one(job: Job, config: Any, labels: Any, *, dry_run: bool = False) -> FileResult:
    """Cleans one clip and writes its outputs, the report last: where that is, all of it is."""
    from footfix.job import clean_file

    settings = config.settings(None if job.source == STDIN else Path(job.source))
    try:
        data = read_whole(job.source, settings.limits.bytes)
        output = None if job.target is None else job.target.name
        outputs = clean_file(data, job.source, settings, labels=labels, output=output)
        report = json.dumps(outputs.report, indent=1, ensure_ascii=False).encode("utf-8", "surrogateescape") + b"\n"
        files: dict[Path, bytes] = {}
        if job.stem is not None and job.target is not None and not dry_run:
            beside = job.stem
            files[job.target] = outputs.bvh
            files[beside.with_name(beside.name + ".contacts.json")] = outputs.contacts
            for suffix, page in outputs.pages.items():
                files[beside.with_name(beside.name + suffix)] = page
            if settings.report.kind != "none":
                files[beside.with_name(beside.name + ".report.json")] = report
            job.target.parent.mkdir(parents=True, exist_ok=True)
            for path, content in files.items():
                write_whole(path, content)
        data_out = outputs.bvh if job.target is None and not dry_run else b""
        return FileResult(
            job.source, outputs.status, report=outputs.report, written=tuple(map(str, files)), data=data_out
        )
    except FootfixError as error:
        return FileResult(job.source, "failed", error=str(error))
    except OSError as error:
        return FileResult(job.source, "failed", error=f"{job.source}: {error.strerror or error}")


def run(
    jobs: Sequence[Job], work: Callable[[Job], FileResult], done: Callable[[FileResult], None]
) -> tuple[FileResult, ...]:
    """Does the jobs one after the other; one that fails does not stop the others."""
    results = []
    for job in jobs:
        result = work(job)
        done(result)
        results.append(result)
    return tuple(results)


def plan_labels(found: Sequence[Source], *, output: Path | None, suffix: str, force: bool) -> tuple[Path | None, ...]:
    """Where the label files of inputs go; None for standard output.

    Raises:
        UsageError: two inputs would write one file, or a file is there already.
    """
    targets: list[Path | None] = []
    for source in found:
        if source.path == STDIN and output is None:
            targets.append(None)
            continue
        base = output / source.below if output is not None else Path(source.path)
        target = base.with_name(base.stem + suffix)
        if target in targets:
            raise UsageError(f"two inputs would both write {target}; use -o with folders, or rename one")
        if target.exists() and not force:
            raise UsageError(f"{target} is there already; --force overwrites it")
        targets.append(target)
    return tuple(targets)


def detect_one(source: str, target: Path | None, kind: str, config: Any, labels: Any) -> FileResult:
    """Finds the contacts of one clip, and writes them or hands them back."""
    from footfix.formats.contacts import encode_csv, encode_npz
    from footfix.job import contacts_json, detect_file

    settings = config.settings(None if source == STDIN else Path(source))
    try:
        data = read_whole(source, settings.limits.bytes)
        contacts, entry, rig, notes = detect_file(data, source, settings, labels=labels)
        if kind == "json":
            encoded = contacts_json(contacts, entry, rig, settings)
        else:
            encoded = encode_csv(contacts) if kind == "csv" else encode_npz(contacts)
        count = sum(len(effector.contacts) for effector in contacts.effectors)
        report = {"contacts": count, "notes": notes}
        if target is None:
            return FileResult(source, "done", report=report, data=encoded)
        target.parent.mkdir(parents=True, exist_ok=True)
        write_whole(target, encoded)
        return FileResult(source, "done", report=report, written=(str(target),))
    except FootfixError as error:
        return FileResult(source, "failed", error=str(error))
    except OSError as error:
        return FileResult(source, "failed", error=f"{source}: {error.strerror or error}")


def inspect_one(source: str, config: Any) -> FileResult:
    """Looks into one file."""
    from footfix.job import inspect_file

    settings = config.settings(None if source == STDIN else Path(source))
    try:
        data = read_whole(source, settings.limits.bytes)
        return FileResult(source, "done", report=inspect_file(data, source, settings))
    except FootfixError as error:
        return FileResult(source, "failed", error=str(error))

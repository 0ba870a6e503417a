"""Where outputs go, settled before any work: nothing collides, nothing is overwritten, nothing leaves the folder."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from footfix.batch.files import STDIN
from footfix.batch.inputs import Source
from footfix.errors import UsageError
from footfix.formats.suffixes import cleaned_name


@dataclass(frozen=True)
class Job:
    """One clip to do.

    Args:
        source: path of the input as people know it, or "-".
        target: path of the corrected file, None where it goes to standard output or nowhere.
        stem: path without suffix, which the other outputs hang theirs on.
        name: the clip's name in summaries: its path below the folder that was named, with forward slashes.
        within: the folder that no output may leave; None where outputs go beside their inputs.
    """

    source: str
    target: Path | None
    stem: Path | None
    name: str = ""
    within: Path | None = None

    def beside(self, suffix: str) -> Path:
        """Path of another output of this clip."""
        assert self.stem is not None
        return self.stem.with_name(self.stem.name + suffix)


def plan(
    found: Sequence[Source], *, output: Path | None, in_place: bool, suffixes: Callable[[Source], Sequence[str]],
    force: bool, ours: Callable[[str], bool] = lambda name: False, extra: Iterable[Path] = (), dry_run: bool = False,
    ending: str = "clean",
) -> tuple[Job, ...]:  # fmt: skip
    """The jobs of a run, checked before any work.

    Args:
        found: the inputs.
        output: the folder that outputs go to; beside each input without one.
        in_place: the corrected file takes the input's place.
        suffixes: of an input's outputs beside the corrected file.
        force: outputs that exist may be overwritten.
        ours: whether the outputs of a clip, by its name, are those of a run that is being resumed.
        extra: outputs of the whole run.
        dry_run: nothing will be written.
        ending: of the names of outputs beside their input: "loop" for walk.loop.bvh, walk.loop.report.json.

    Raises:
        UsageError: two inputs would write one output, an output is there already, is an input, would lie
            outside the output folder, or can't be written.
    """
    jobs = tuple(_job(source, output, in_place, ending) for source in found)
    named = {os.path.realpath(source.path): source.path for source in found if source.path != STDIN}
    owners: dict[str, str] = {}
    for source, job in zip(found, jobs, strict=True):
        free = force or dry_run or ours(job.name)
        for each in _outputs(job, suffixes(source)):
            key = os.path.normcase(os.path.realpath(each))
            if key in owners:
                raise UsageError(
                    f"{owners[key]} and {job.source} would both write {each}; use -o with folders, or rename one"
                )
            owners[key] = job.source
            itself = in_place and each == job.target
            if os.path.realpath(each) in named and not itself:
                raise UsageError(f"{each} is itself an input; write elsewhere, or say --in-place")
            if os.path.lexists(each) and not free and not itself:
                raise UsageError(f"{each} is there already; --force overwrites it")
    for each in extra:
        if os.path.lexists(each) and not (force or dry_run or ours("")):
            raise UsageError(f"{each} is there already; --force overwrites it")
    _stay_within(jobs)
    if not dry_run:
        _writable({job.target.parent for job in jobs if job.target is not None})
    return jobs


def plan_labels(found: Sequence[Source], *, output: Path | None, suffix: str, force: bool) -> tuple[Job, ...]:
    """The jobs of a run that writes labels only; a job's target is its label file, None for standard output.

    Raises:
        UsageError: as `plan`.
    """
    jobs = []
    for source in found:
        job = _job(source, output, in_place=False)
        target = None if job.stem is None else job.beside(suffix)
        jobs.append(Job(job.source, target, job.stem, job.name, job.within))
    owners: dict[Path, str] = {}
    for job in jobs:
        if job.target is None:
            continue
        if job.target in owners:
            raise UsageError(f"two inputs would both write {job.target}; use -o with folders, or rename one")
        owners[job.target] = job.source
        if os.path.lexists(job.target) and not force:
            raise UsageError(f"{job.target} is there already; --force overwrites it")
    _stay_within(jobs)
    _writable({job.target.parent for job in jobs if job.target is not None})
    return tuple(jobs)


def _job(source: Source, output: Path | None, in_place: bool, ending: str = "clean") -> Job:
    name = source.below.as_posix()
    if source.path == STDIN and output is None:
        return Job(source.path, None, None, name)
    if output is not None:
        target = output / source.below
        return Job(source.path, target, target.with_suffix(""), name, output)
    path = Path(source.path)
    if in_place:  # behind a link it is the file itself that is replaced
        return Job(source.path, Path(os.path.realpath(path)), path.with_suffix(""), name)
    target = path.with_name(cleaned_name(path.name, ending))
    # what is cleaned keeps the names of its labels and reports; another clip has its own
    return Job(source.path, target, (path if ending == "clean" else target).with_suffix(""), name)


def _outputs(job: Job, suffixes: Sequence[str]) -> Iterator[Path]:
    if job.target is not None:
        yield job.target
        yield from (job.beside(suffix) for suffix in suffixes)


def _stay_within(jobs: Iterable[Job]) -> None:
    for job in jobs:
        if job.within is not None and job.target is not None and not is_within(job.target, job.within):
            raise UsageError(f"{job.target} would lie outside {job.within}: a part of its path is a link")


def is_within(path: Path, folder: Path) -> bool:
    """Whether a file's folder, links followed, lies in another one; the file itself may be a link, it is replaced."""
    inner, outer = os.path.realpath(path.parent), os.path.realpath(folder)
    return inner == outer or inner.startswith(outer.rstrip(os.sep) + os.sep)


def _writable(folders: Iterable[Path]) -> None:
    """Tries the nearest folder that exists above each; none is made before all are known to be good."""
    tried: set[Path] = set()
    for folder in sorted(folders):
        there = folder
        while not os.path.lexists(there) and there != there.parent:
            there = there.parent
        if there in tried:
            continue
        tried.add(there)
        if not there.is_dir():
            raise UsageError(f"{folder}: {there} is a file, not a folder")
        try:
            with tempfile.TemporaryFile(dir=there):
                pass
        except OSError as error:
            raise UsageError(f"{there}: can't be written to: {error.strerror or error}") from None

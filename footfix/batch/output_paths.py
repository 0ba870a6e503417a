"""The paths of outputs, checked before any work: no two are the same, none exists, none is outside the folder."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from footfix.batch.file_io import STDIN
from footfix.batch.inputs import Source
from footfix.errors import UsageError
from footfix.formats.suffixes import OTHERS, cleaned_name, is_motion


@dataclass(frozen=True)
class Job:
    """One clip to do.

    Args:
        source: path of the input as the user gave it, or "-".
        target: path of the corrected file, None where it is written to standard output or not at all.
        stem: path without suffix, to which other outputs add theirs.
        name: the clip's name in summaries: its path below the folder that was given, with forward slashes.
        within: the folder that all outputs must be in; None where outputs are written beside their inputs.
        clip: the name of the clip to take from a file that holds several; "" for all.
        end: the part of the output names after the stem that names such a clip, ".Walk"; "" for a file of one clip.
    """

    source: str
    target: Path | None
    stem: Path | None
    name: str = ""
    within: Path | None = None
    clip: str = ""
    end: str = ""

    def beside(self, suffix: str) -> Path:
        """Return the path of another output of this clip."""
        assert self.stem is not None
        return self.stem.with_name(self.stem.name + suffix)


def names_file(output: Path | None, found: Sequence[Source], *, folder: bool, ends: Sequence[str] = ()) -> bool:
    """Tell whether -o names one file, not a folder: for one clip, a name with the ending of its output.

    Args:
        output: the path given by -o.
        found: the inputs.
        folder: whether the input is a folder; then the output is one too, however many clips it holds.
        ends: endings of output names, in lower case; motion of any format by default.

    Raises:
        UsageError: it names a file for many clips, has the ending of another format, or is an existing folder; or a
            file exists where it names a folder.
    """
    if output is None:
        return False
    is_file = output.name.lower().endswith(tuple(ends)) if ends else is_motion(output.name)
    if not is_file:
        if output.suffix.lower() in OTHERS and not output.is_dir():
            raise UsageError(f"-o {output}: {output.suffix} is not written; name a folder, or for one clip a .bvh file")
        if output.is_file():
            raise UsageError(f"-o {output}: this is a file, not a folder; name a folder, or for one clip a new file")
        return False
    if folder or len(found) > 1:
        if output.is_dir():
            return False
        what = "a folder of clips was named" if folder else f"{len(found)} clips were named"
        raise UsageError(f"-o {output} is the name of one file, but {what}; name a folder")
    if output.is_dir():
        raise UsageError(f"-o {output}: a folder of this name is there, and a file can't be; name another one")
    came = found[0].below.suffix.lower()
    if not ends and is_motion(found[0].below.name) and came != output.suffix.lower():
        raise UsageError(f"-o {output}: {found[0].path} is written in its own format; end the name in {came}")
    return True


def plan(
    found: Sequence[Source], *, output: Path | None, in_place: bool, suffixes: Callable[[Source], Sequence[str]],
    force: bool, ours: Callable[[Job], bool] = lambda job: False, extra: Iterable[Path] = (), extra_ours: bool = False,
    dry_run: bool = False, one_file: bool = False, ending: str = "clean",
) -> tuple[Job, ...]:  # fmt: skip
    """Plan the jobs of a run, and check them before any work.

    Args:
        found: the inputs.
        output: the folder for outputs; None to write them beside each input.
        in_place: the corrected file replaces the input.
        suffixes: of an input's outputs other than the corrected file.
        force: existing outputs may be overwritten.
        ours: whether the outputs of a clip are those of a run that is being resumed.
        extra: outputs of the whole run.
        extra_ours: whether `extra` are those of a run that is being resumed.
        dry_run: nothing will be written.
        one_file: `output` is the path of the one clip's output, not of a folder.
        ending: of the names of outputs beside their input: "loop" for walk.loop.bvh, walk.loop.report.json.

    Raises:
        UsageError: two inputs would write one output, or an output exists, is an input, is outside the output folder,
            or can't be written.
    """
    jobs = tuple(replace(_job(source, output, in_place, one_file, ending), clip=source.clip) for source in found)
    named = {os.path.realpath(source.path): source.path for source in found if source.path != STDIN}
    owners: dict[str, str] = {}
    for source, job in zip(found, jobs, strict=True):
        free = force or dry_run or ours(job)
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
        if os.path.lexists(each) and not (force or dry_run or extra_ours):
            elsewhere = ", -o puts all in a folder of its own" if output is None else ""
            raise UsageError(f"{each} is there already; --force overwrites it{elsewhere}")
    _stay_within(jobs)
    if not dry_run:
        _writable({job.target.parent for job in jobs if job.target is not None})
    return jobs


def plan_labels(
    found: Sequence[Source], *, output: Path | None, suffix: str, force: bool, one_file: bool = False
) -> tuple[Job, ...]:
    """Plan the jobs of a run that writes labels only; a job's target is its label file, None for standard output.

    Raises:
        UsageError: as `plan`.
    """
    jobs = []
    for source in found:
        job = _job(source, output, False, one_file)
        target = output if one_file else None if job.stem is None else job.beside(suffix)
        jobs.append(Job(job.source, target, job.stem, job.name, job.within, source.clip))
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


def _job(source: Source, output: Path | None, in_place: bool, one_file: bool, ending: str = "clean") -> Job:
    name = source.below.as_posix()
    if output is not None and one_file:
        return Job(source.path, output, output.with_suffix(""), name, output.parent)
    if source.path == STDIN and output is None:
        return Job(source.path, None, None, name)
    if output is not None:
        target = output / source.below
        return Job(source.path, target, target.with_suffix(""), name, output)
    path = Path(source.path)
    if in_place:  # of a link, the file that it points to is replaced
        return Job(source.path, Path(os.path.realpath(path)), path.with_suffix(""), name)
    target = path.with_name(cleaned_name(path.name, ending))
    # labels and reports of a cleaned clip have no "clean" in their names; those of a loop have "loop"
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
    """Tell whether a file's folder, with links followed, is in another; the file itself may be a link."""
    inner, outer = os.path.realpath(path.parent), os.path.realpath(folder)
    return inner == outer or inner.startswith(outer.rstrip(os.sep) + os.sep)


def _writable(folders: Iterable[Path]) -> None:
    """Check the nearest existing parent of each folder; no folder is made before all are checked."""
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

"""Files that hold several clips: each clip is a task of its own, and the file's result holds the results of all."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from footfix.batch.file_io import STDIN, read_whole
from footfix.batch.task import FileResult, Task
from footfix.errors import InputError
from footfix.formats.suffixes import in_file

if TYPE_CHECKING:
    from footfix.formats.contacts import Labels

_UNFIT = re.compile(r"[^\w\-+(). ]+")  # characters that are replaced in file names
_LONGEST = 80  # characters of a clip's name in a file name
_NAMED = 12  # clips that a message lists, at most


def beside_of(task: Task) -> Callable[[str], bytes] | None:
    """Make the function that reads files which the task's file refers to; None for standard input."""
    if task.job.source == STDIN:
        return None
    folder = Path(task.folder, in_file(task.job.source)[0]).parent
    return lambda path: read_whole(folder / path, task.settings.limits.bytes)


def parts_of(task: Task, data: bytes, *, poses: bool = True) -> tuple[Task, ...] | None:
    """List the tasks of the clips of a file, as far as they are asked for; None for a file of one clip.

    Args:
        task: of the file.
        data: its bytes.
        poses: whether clips too short to hold a motion are among them, though nobody asks for them by name.

    Raises:
        InputError: it can't be read, holds no clip, or not the one that is asked for.
    """
    from footfix.formats.document import clips_of

    job = task.job
    names = clips_of(data, name=job.source, limits=task.settings.limits, beside=beside_of(task))
    asked = (job.clip,) if job.clip else task.animations
    if names is None:
        return None
    chosen = [_chosen(names, each, job.source) for each in dict.fromkeys(asked)] or list(names)
    if len(names) == 1:
        return None
    if not (poses or asked):
        chosen = [name for name in chosen if not _is_pose(task, data, name)] or chosen
    if task.labels is not None and len(chosen) > 1:
        raise InputError(
            f"the labels are of one clip, but {len(chosen)} are in the file", file=job.source,
            hint="--animation NAME says which one, or name a folder with a label file for each",
        )  # fmt: skip
    ends = file_names(names)
    return tuple(_part(task, name, ends[name]) for name in chosen)


def _is_pose(task: Task, data: bytes, name: str) -> bool:
    """Tell whether a clip of a file has too few frames for a motion, as a T-pose beside animations has."""
    from footfix.formats.document import open_document
    from footfix.jobs.source import LEAST_FRAMES

    limits, beside = task.settings.limits, beside_of(task)
    try:
        return open_document(data, name=f"{task.job.source}#{name}", limits=limits, beside=beside).frames < LEAST_FRAMES
    except InputError:
        return False  # the error is raised where the clip is worked on


def file_names(names: Sequence[str]) -> dict[str, str]:
    """Turn names of clips into file names that are all different, also where case is ignored."""
    found: dict[str, str] = {}
    taken: set[str] = set()
    count: dict[str, int] = {}
    for name in names:
        plain = _UNFIT.sub("_", name)[:_LONGEST].strip(". ") or "clip"
        end = plain
        while end.lower() in taken:
            count[plain] = count.get(plain, 1) + 1
            end = f"{plain}.{count[plain]}"
        taken.add(end.lower())
        found[name] = end
    return found


def joined_result(task: Task, parts: Sequence[FileResult]) -> FileResult:
    """Join the results of the clips of a file to the result of the file."""
    states = [part.status for part in parts]
    order = ("over", "cleaned", "done", "unchanged", "failed")
    return FileResult(
        task.job.source,
        next(each for each in order if each in states),
        written=tuple(dict.fromkeys(path for part in parts for path in part.written)),
        hashes={name: digest for part in parts for name, digest in part.hashes.items()},
        skipped=all(part.skipped for part in parts),
        bug=any(part.bug for part in parts),
        parts=tuple(parts),
    )


def spread(result: FileResult) -> tuple[FileResult, ...]:
    """List the results of the clips of a file; the file's own where it holds one clip."""
    return result.parts or (result,)


def spread_pairs(tasks: Sequence[Task], results: Sequence[FileResult]) -> list[tuple[Task, FileResult]]:
    """List tasks and results of every clip, also of those in files that hold several."""
    return [
        (replace(task, job=replace(task.job, name=named(task.job.name, part))) if result.parts else task, part)
        for task, result in zip(tasks, results, strict=True)
        for part in spread(result)
    ]


def named(name: str, part: FileResult) -> str:
    """Make the name of a clip of a file for summaries."""
    return f"{name}#{in_file(part.source)[1]}"


def _part(task: Task, name: str, end: str) -> Task:
    job, labels = task.job, task.labels
    stem = None if job.stem is None else job.stem.with_name(f"{job.stem.name}.{end}")
    own = replace(job, source=f"{job.source}#{name}", stem=stem, name=f"{job.name}#{name}", clip="", end=f".{end}")
    given: Labels | None = task.clip_labels.get(end, labels)
    return replace(task, job=own, labels=given)


def _chosen(names: Sequence[str], wanted: str, file: str) -> str:
    same = [name for name in names if name == wanted] or [name for name in names if name.lower() == wanted.lower()]
    if len(same) == 1:
        return same[0]
    listed = ", ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")
    raise InputError(f"it has no animation {wanted!r}", file=file, hint=f"there are {listed}")

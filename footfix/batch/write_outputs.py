"""Making the outputs of a file's clips, and writing all of them or none."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from footfix.batch.attempt import attempted
from footfix.batch.file_io import sync_folder, write_whole
from footfix.batch.multi_clip_files import beside_of, joined_result, parts_of
from footfix.batch.output_paths import is_within
from footfix.batch.task import CONTACTS, REPORT, FileResult, Task, beside
from footfix.errors import OutputError
from footfix.version import __version__

if TYPE_CHECKING:
    from footfix.formats.contacts import Labels
    from footfix.jobs.outputs import Outputs
    from footfix.settings import Settings


def fingerprint(data: bytes, settings: Settings, labels: Labels | None) -> str:
    """Hash everything that an output depends on: the input's bytes, the settings, given labels and the version."""
    from footfix.settings import plain

    digest = hashlib.sha256()
    for part in (hashlib.sha256(data).digest(), json.dumps(plain(settings), sort_keys=True).encode(),
                 repr(labels).encode("utf-8", "surrogateescape"), __version__.encode()):  # fmt: skip
        digest.update(hashlib.sha256(part).digest())
    return digest.hexdigest()


def made(task: Task, data: bytes, make: Callable[[Task], Outputs], what: str = "") -> FileResult:
    """Make the outputs of each clip of a file, and write them.

    Args:
        task: of the file.
        data: its bytes.
        make: makes the outputs of the task of one clip.
        what: part of the fingerprint that tells other commands' outputs from those of cleaning.
    """
    parts = parts_of(task, data, poses=not what)
    tasks = (task,) if parts is None else parts
    keys = [what + fingerprint(data, part.settings, part.labels) + part.job.end for part in tasks]
    done = [_finished(part, key) if task.resume else None for part, key in zip(tasks, keys, strict=True)]
    found = [each for each in done if each is not None]
    if len(found) == len(tasks):
        return found[0] if parts is None else joined_result(task, found)
    if parts is None:
        return _written(task, data, [task], [make(task)], keys)[0]
    _refuse_what_is_there(task, parts)
    results = [attempted(part, partial(make, part)) for part in parts]
    good = [k for k, each in enumerate(results) if not isinstance(each, FileResult)]
    outputs = [each for each in results if not isinstance(each, FileResult)]
    if good:
        written = _written(task, data, [parts[k] for k in good], outputs, [keys[k] for k in good])
        for k, result in zip(good, written, strict=True):
            results[k] = result
    return joined_result(task, [each for each in results if isinstance(each, FileResult)])


def write_outputs(task: Task, outputs: Outputs, key: str) -> FileResult:
    """Write the outputs of a clip made from several files; `key` is their fingerprint."""
    return _written(task, b"", [task], [outputs], [key])[0]


def _written(
    task: Task, data: bytes, parts: Sequence[Task], outputs: Sequence[Outputs], keys: Sequence[str]
) -> list[FileResult]:
    """Write the outputs of a file's clips, the reports last, and return the result of each clip."""
    motion = _motion(task, data, outputs)
    sha = hashlib.sha256(motion).hexdigest()
    reports = [
        {**each.report, "fingerprint": key, "output_sha256": sha} for each, key in zip(outputs, keys, strict=True)
    ]
    target = task.job.target
    own: list[dict[Path, bytes]] = [{} for _ in parts]
    outputs = [_of_the_whole(each, motion, sha) for each in outputs]
    if target is not None and not task.dry_run:
        own = [_files(part, each, motion, report) for part, each, report in zip(parts, outputs, reports, strict=True)]
        files = {path: content for some in own for path, content in some.items()}
        last = [path for some in own for path in some if path.name.endswith(REPORT) or path == target]
        _write_neighbours(task, data)
        write(task, {path: files[path] for path in (*(path for path in files if path not in last), target, *last)})
    direct = motion if target is None and not task.dry_run else b""
    return [
        FileResult(
            part.job.source,
            each.status,
            report=report if task.keep_report else digest(report),
            written=tuple(map(str, some)),
            hashes={
                path.name: sha if content is motion else hashlib.sha256(content).hexdigest()
                for path, content in some.items()
            },
            data=direct if k == 0 else b"",
            offenders=each.offenders,
        )
        for k, (part, each, report, some) in enumerate(zip(parts, outputs, reports, own, strict=True))
    ]


def _motion(task: Task, data: bytes, outputs: Sequence[Outputs]) -> bytes:
    """Make the corrected file, with the changes of all its clips."""
    from footfix.formats.document import joined

    changed = [each.motion for each in outputs if each.motion != data]
    if not changed:
        return data
    motion = changed[0]
    for more in changed[1:]:
        motion = joined(data, motion, more, name=task.job.source, beside=beside_of(task))
    return motion


def _of_the_whole(outputs: Outputs, motion: bytes, sha: str) -> Outputs:
    """Put the hash of the final file into outputs, in place of that of the file with only this clip changed."""
    if outputs.motion == motion:
        return outputs
    own = hashlib.sha256(outputs.motion).hexdigest().encode()
    pages = {suffix: page.replace(own, sha.encode()) for suffix, page in outputs.pages.items()}
    return replace(outputs, contacts=outputs.contacts.replace(own, sha.encode()), pages=pages)


def _files(task: Task, outputs: Outputs, motion: bytes, report: Mapping[str, Any]) -> dict[Path, bytes]:
    """List every output of a clip and its bytes."""
    job = task.job
    assert job.target is not None
    files = {job.beside(CONTACTS): outputs.contacts}
    files |= {job.beside(suffix): page for suffix, page in outputs.pages.items()}
    files[job.target] = motion
    if task.settings.report.kind != "none":
        text = json.dumps(report, indent=1, ensure_ascii=False) + "\n"
        files[job.beside(REPORT)] = text.encode("utf-8", "surrogateescape")
    return files


def _refuse_what_is_there(task: Task, parts: Sequence[Task]) -> None:
    """Raise where outputs of a file's clips would overwrite existing files; their names are known only now."""
    if task.force or task.dry_run or task.job.target is None or task.resume:
        return
    for part in parts:
        for path in (part.job.beside(suffix) for suffix in beside(part.settings)):
            if os.path.lexists(Path(task.folder, path)):
                raise OutputError(f"{path} is there already; --force overwrites it")


def _write_neighbours(task: Task, data: bytes) -> None:
    """Copy the files that a file refers to into the folder of its corrected copy, where that is another folder."""
    from footfix.formats.document import neighbours_of

    job, fetch = task.job, beside_of(task)
    if fetch is None or job.target is None:
        return
    folder = Path(task.folder, job.target).parent
    if folder.resolve() == Path(task.folder, job.source).parent.resolve():
        return
    for name in neighbours_of(data, name=job.source, limits=task.settings.limits, beside=fetch):
        path = folder / name
        if (
            not is_within(path, folder)
            or ".." in path.parts
            or not (Path(task.folder, job.source).parent / name).is_file()
        ):
            continue
        content = fetch(name)
        if path.is_file() and path.read_bytes() == content:
            continue
        if os.path.lexists(path) and not task.force:
            raise OutputError(f"{path} is there already, and another file; --force overwrites it")
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, content, tag=task.tag)


def write(task: Task, files: Mapping[Path, bytes]) -> None:
    """Write outputs, the last one only when the others are safely on disk."""
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
    except OutputError:  # an incomplete set would only block the next attempt
        for path in new:
            path.unlink(missing_ok=True)
        raise


def _keep_edits(task: Task, path: Path, shown: Path, data: bytes) -> None:
    """Raise where a resumed run would overwrite files that are not its own, or that were edited since."""
    if not task.resume or not path.exists():
        return
    if task.wrote is None:
        raise OutputError(f"{shown}: is there already, made of another input or settings; --force overwrites it")
    before = task.wrote.get(path.name)
    if before is None:  # begun, not ended: any files there were written by the interrupted run
        return
    now = hashlib.sha256(path.read_bytes()).hexdigest()
    if now not in (before, hashlib.sha256(data).hexdigest()):
        raise OutputError(f"{shown}: was changed since footfix wrote it; --force overwrites it")


def _finished(task: Task, key: str) -> FileResult | None:
    """Find the outputs of a clip by an earlier run, if complete and of the same input, settings and version."""
    job = task.job
    if job.target is None or task.settings.report.kind == "none":
        return None
    if task.wrote is not None and not task.wrote:
        return None  # its end was not recorded, so that the index lacks its entry: done again
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
    """Keep the parts of a report that summaries and indexes need, so that ten thousand fit in memory."""
    kept = ("effector", "start", "end", "slide_before_mm", "slide_after_mm", "outcome", "reason")
    return {
        **{key: report[key] for key in ("source", "status", "method", "before", "after", "correction", "notes")},
        **({"loop": report["loop"]} if "loop" in report else {}),
        "plants": [{key: plant[key] for key in kept} for plant in report["plants"]],
    }

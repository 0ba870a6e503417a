"""What the commands over many clips share: inputs, settings, tasks, progress, and exit codes."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from glob import escape as glob_escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from footfix.batch import inputs
from footfix.batch.file_io import STDIN, read_whole, write_whole
from footfix.batch.inputs import Source
from footfix.batch.journal import Journal
from footfix.batch.multi_clip_files import spread
from footfix.batch.output_paths import Job
from footfix.batch.run import Crew, Outcome, run
from footfix.batch.task import FileResult, Task
from footfix.cli.options import Common, Given, Many
from footfix.cli.progress import Progress
from footfix.errors import ExitCode, UsageError

if TYPE_CHECKING:
    from footfix.config import Config
    from footfix.formats.contacts import Labels
    from footfix.settings import Settings

Say = Callable[[str], None]


def plain(result: FileResult) -> dict[str, Any]:
    """Convert a result to its entry in a `--json` document."""
    entry: dict[str, Any] = {"source": result.source, "status": result.status}
    if result.error:
        entry["error"] = result.error
    if result.written:
        entry["written"] = list(result.written)
    if result.report:
        entry["report"] = dict(result.report)
    return entry


def print_json(document: Any) -> None:
    """Print one document on stdout, in ASCII, so that the console's encoding does not matter."""
    click.echo(json.dumps(document, indent=1))


def code(outcome: Outcome) -> ExitCode:
    """Choose the exit code of a run by its results."""
    results = [part for result in outcome.results for part in spread(result)]
    if any(result.bug for result in results):
        return ExitCode.BUG
    return ExitCode.FAILED if any(result.status == "failed" for result in results) else ExitCode.DONE


def found_inputs(
    src: tuple[str, ...], many: Many, *, leave_out: Path | None = None, own_outputs: bool = False
) -> tuple[Source, ...]:  # fmt: skip
    if many.dask and many.timeout is not None:
        raise UsageError("--timeout stops processes of this machine only; leave it out with --dask")
    if (*src, *many.from_file).count(STDIN) > 1:
        raise UsageError("standard input can be named only once")
    found = inputs.sources(
        src, lists=many.from_file, include=many.include, exclude=many.exclude, leave_out=leave_out,
        own_outputs=own_outputs,
    )  # fmt: skip
    if many.shard is not None:
        found = inputs.shard(found, *many.shard)
    return found


def config_for(src: tuple[str, ...], many: Many, common: Common, options: Mapping[str, Any]) -> Config:
    return config_near([*src, *many.from_file], common, options)


def config_near(named: Sequence[str], common: Common, options: Mapping[str, Any]) -> Config:
    """Find the settings of a run; `footfix.yaml` is searched from the common parent of the inputs upward."""
    from footfix.config import load_config

    parents = [Path(each) if Path(each).is_dir() else Path(each).parent for each in named if each != STDIN]
    try:
        near = Path(os.path.commonpath([str(each.absolute()) for each in parents])) if parents else Path.cwd()
    except ValueError:  # inputs on several drives have no common parent
        near = Path.cwd()
    return load_config(
        config=common.config, preset=common.preset, sets=common.sets, near=near, command_line=dict(options)
    )


def tasks_for(
    jobs: Sequence[Job], found: Sequence[Source], config: Config, given: Given | None = None
) -> list[Task]:  # fmt: skip
    labels = labels_for(given or Given(), found)
    skin = None if given is None else given.skin

    def settings_for(job: Job) -> Settings:
        settings = config.settings(None if job.source == STDIN else Path(job.source))
        return replace(settings, rig=replace(settings.rig, skin=skin)) if skin else settings

    return [
        Task(
            job,
            settings_for(job),
            labels=labels.get(job.source),
            clip_labels=clip_labels_for(given or Given(), source),
            folder=str(Path.cwd()),
        )
        for job, source in zip(jobs, found, strict=True)
    ]


def labels_for(given: Given, found: Sequence[Source]) -> dict[str, Labels]:
    """Find for each input the labels given for it: one file for one clip, or a folder with a file for each."""
    path = given.labels
    if path is None:
        return {}
    from footfix.formats.contacts import ENDS, decode

    def read(file: Path) -> Labels:
        return decode(read_whole(file, 1 << 30), name=str(file), order=given.order)

    if path.is_file():
        if len(found) > 1:
            raise UsageError(f"{path} labels one clip, but {len(found)} are named; give a folder of label files")
        return {found[0].path: read(path)}
    ends = (*ENDS.values(), ".npy", ".npz")
    labels = {}
    for source in found:
        stem = source.below.with_suffix("")
        places = [(path / folder / stem.name) for folder in dict.fromkeys((stem.parent, Path()))]
        names = (place.with_name(place.name + end) for place in places for end in ends)
        file = next((each for each in names if each.is_file()), None)
        if file is None and clip_labels_for(given, source):
            continue
        if file is None:
            raise UsageError(f"{path} holds no {stem.as_posix()}.contacts.json (.csv, .npz, .npy) for {source.path}")
        labels[source.path] = read(file)
    return labels


def clip_labels_for(given: Given, source: Source) -> dict[str, Labels]:
    """Find the labels in a folder for the clips of a file that may hold several: character.Walk.contacts.json ..."""
    path, stem = given.labels, source.below.with_suffix("").name
    if path is None or not path.is_dir() or source.below.suffix.lower() in ("", ".bvh"):
        return {}
    from footfix.formats.contacts import ENDS, decode

    found: dict[str, Labels] = {}
    for end in (*ENDS.values(), ".npy", ".npz"):
        for folder in dict.fromkeys((path / source.below.parent, path)):
            for file in sorted(folder.glob(f"{glob_escape(stem)}.*{end}")):
                clip = file.name[len(stem) + 1 : -len(end)]
                found.setdefault(clip, decode(read_whole(file, 1 << 30), name=str(file), order=given.order))
    return found


def run_tasks(
    work: Callable[[Task], FileResult], tasks: Sequence[Task], many: Many, common: Common, style: str,
    journal: Journal, told: Callable[[FileResult, Say], None],
) -> Outcome:  # fmt: skip
    """Run the tasks, showing progress; failures are printed at once."""
    from footfix.report.text import printable

    progress = Progress(len(tasks), shown=not common.quiet and not common.as_json)

    def finished(result: FileResult) -> None:
        for each in (part for part in spread(result) if part.error):
            progress.say(f"footfix: {printable(each.error)}")
            if style == "github":
                from footfix.report.annotations import annotation

                click.echo(annotation("error", result.source, each.error, line=each.line))
        told(result, progress.say)
        progress.step(failed=result.status == "failed", skipped=result.skipped)

    def on_interrupt(running: int) -> None:
        progress.say("footfix: finishing the clips that are being worked on; once more stops at once")

    tasks = [replace(task, animations=many.animation) for task in tasks]
    crew = Crew(many.jobs, many.timeout, many.dask)
    try:
        return run(work, tasks, crew=crew, on_result=finished, journal=journal, on_interrupt=on_interrupt)
    finally:
        progress.close()


def write_file(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, data)


def one_or_many(documents: list[Any]) -> Any:
    return documents[0] if len(documents) == 1 else {"format": "footfix-run", "version": 1, "files": documents}


def reading(source: Source) -> Job:
    """Make the job of an input that nothing is written for."""
    return Job(source.path, None, None, source.below.as_posix(), clip=source.clip)

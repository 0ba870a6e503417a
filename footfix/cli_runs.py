"""What the commands over many clips do: settle inputs and outputs, run, tell, and sum up."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from footfix.batch import inputs, outputs
from footfix.batch.inputs import Source
from footfix.batch.journal import Journal, Past, recall
from footfix.batch.outputs import Job
from footfix.batch.run import Crew, Outcome, run
from footfix.batch.work import (
    CONTACTS,
    PAGE,
    PICTURE,
    REPORT,
    FileResult,
    Task,
    beside,
    check_one,
    clean_one,
    detect_one,
    inspect_one,
)
from footfix.cli_options import Common, Many
from footfix.console import Progress
from footfix.errors import UsageError
from footfix.files import STDIN, read_whole, write_whole

if TYPE_CHECKING:
    from footfix.config import Config
    from footfix.formats.contacts import Labels
    from footfix.report.summary import Entry

OVER_BUDGET, FAILED, BUG, INTERRUPTED = 1, 3, 4, 130


def clean(
    src: tuple[str, ...], *, output: Path | None, in_place: bool, options: Mapping[str, Any], labels: Path | None,
    dry_run: bool, force: bool, resume: bool, junit: Path | None, style: str, many: Many, common: Common,
) -> int:  # fmt: skip
    """`footfix clean`."""
    if output is not None and in_place:
        raise UsageError("-o and --in-place exclude each other")
    if resume and output is None:
        raise UsageError("--resume goes on in a folder of outputs; say which with -o")
    found = _found(src, many, leave_out=output)
    config = _config(src, many, common, options)
    kind = config.settings().report.kind
    past = recall(output) if output is not None and resume else Past()
    whole = _whole_run(output, many, kind) if output is not None and _several(src, found) else {}
    jobs = outputs.plan(
        found, output=output, in_place=in_place, suffixes=beside(config.settings()), force=force, dry_run=dry_run,
        ours=lambda name: resume and (name == "" or name in past.begun or _reported(output, name)),
        extra=whole.values(),
    )  # fmt: skip
    if common.as_json and any(job.target is None for job in jobs):
        raise UsageError("--json and a clip on standard output exclude each other; say where the clip goes with -o")
    few = len(jobs) == 1 or common.as_json
    tasks = [
        replace(task, dry_run=dry_run, resume=resume and not force, keep_report=few, tag=many.tag,
                wrote=past.hashes.get(task.job.name, {}) if task.job.name in past.begun else None)
        for task in _tasks(jobs, found, config, labels)
    ]  # fmt: skip
    writes = output is not None and not dry_run and (whole or resume)
    journal = Journal(output if writes else None, many.tag)
    try:
        outcome = _run(clean_one, tasks, many, common, style, journal, _told_cleaned(common, few))
        if not outcome.interrupted:
            journal.finish()
    finally:
        journal.close()
    return _close_clean(outcome, tasks, {} if dry_run else whole, past, junit, style, common)


def _close_clean(
    outcome: Outcome, tasks: Sequence[Task], whole: Mapping[str, Path], past: Past, junit: Path | None, style: str,
    common: Common,
) -> int:  # fmt: skip
    """What is told and written at the end of a run of `clean`."""
    from footfix.report.summary import table

    if common.as_json:
        print_json({"format": "footfix-run", "version": 1, "files": [plain(each) for each in outcome.results]})
    if outcome.interrupted:
        return INTERRUPTED
    entries = [_entry(task, result) for task, result in zip(tasks, outcome.results, strict=True)]
    if whole:
        _write_whole_run(entries, outcome.results, tasks, whole, past)
    if junit is not None:
        _write_junit("footfix clean", junit, entries, outcome.results)
    if len(tasks) > 1 and not common.quiet and style == "text":
        say(table(entries))
    return code(outcome)


def detect(
    src: tuple[str, ...], *, output: Path | None, kind: str, options: Mapping[str, Any], labels: Path | None,
    force: bool, many: Many, common: Common,
) -> int:  # fmt: skip
    """`footfix detect`."""
    found = _found(src, many, leave_out=output)
    config = _config(src, many, common, options)
    jobs = outputs.plan_labels(found, output=output, suffix=f".contacts.{kind}", force=force or common.as_json)
    tasks = [
        replace(task, extra={"kind": kind}, dry_run=common.as_json, tag=many.tag)
        for task in _tasks(jobs, found, config, labels)
    ]

    def told(result: FileResult, say: Callable[[str], None]) -> None:
        if common.as_json:
            return
        if result.data:
            sys.stdout.buffer.write(result.data)
        elif not common.quiet and not result.error and (len(tasks) == 1 or common.verbose):
            say(f"{result.source}: {result.report['contacts']} contacts -> {', '.join(result.written)}")
        for note in result.report.get("notes", ()) if not common.quiet else ():
            if common.verbose or note["severity"] != "note":
                say(f"  {note['severity']}: {note['text']}")

    outcome = _run(detect_one, tasks, many, common, "text", Journal(None, ""), told)
    if common.as_json:
        files = [json.loads(result.data) if result.data else plain(result) for result in outcome.results]
        print_json(_one_or_many(files))
    return INTERRUPTED if outcome.interrupted else code(outcome)


def inspect(src: tuple[str, ...], *, many: Many, common: Common) -> int:
    """`footfix inspect`."""
    from footfix.report.inspection import describe

    found = _found(src, many, own_outputs=True)
    config = _config(src, many, common, {})
    tasks = _tasks([_reading(source) for source in found], found, config, None)
    outcome = _run(inspect_one, tasks, many, common, "text", Journal(None, ""), lambda result, say: None)
    if common.as_json:
        print_json(_one_or_many([dict(each.report) if each.report else plain(each) for each in outcome.results]))
    else:
        for result in outcome.results:
            if result.report:
                click.echo(describe(result.report, quiet=common.quiet))
    return INTERRUPTED if outcome.interrupted else code(outcome)


def report(
    named: tuple[str, ...], *, source: Path | None, kind: Literal["none", "html"], png: bool, output: Path | None,
    force: bool,
) -> int:  # fmt: skip
    """`footfix report`."""
    from footfix.batch.redrawing import redraw_one
    from footfix.settings import ReportParams

    params = ReportParams(kind=kind, png=png)
    failed = False
    for name in named:
        result = redraw_one(Path(name), source, params, output, force=force)
        failed |= bool(result.error)
        say(f"footfix: {result.error}" if result.error else f"{name} -> {', '.join(result.written)}")
    return FAILED if failed else 0


def check(
    src: tuple[str, ...], *, most: tuple[str, ...], junit: Path | None, labels: Path | None, style: str, anew: bool,
    many: Many, common: Common,
) -> int:  # fmt: skip
    """`footfix check`."""
    from footfix.batch import gates
    from footfix.report import checking

    limits = gates.parse(most)
    found = _found(src, many, own_outputs=True)
    config = _config(src, many, common, {})
    jobs = [_reading(source) for source in found]
    tasks = [replace(task, extra={"gates": limits, "anew": anew}) for task in _tasks(jobs, found, config, labels)]
    for task in tasks:
        gates.known(task.settings.gates)
    outcome = _run(check_one, tasks, many, common, style, Journal(None, ""), lambda result, say: None)
    rows = [checking.row(result.source, result.status, result.report, result.error) for result in outcome.results]
    if common.as_json:
        print_json(checking.document(rows))
    elif style == "github":
        for line in checking.workflow_commands(rows):
            click.echo(line)
    else:
        click.echo(checking.text(rows, quiet=common.quiet, verbose=common.verbose), nl=False)
    if outcome.interrupted:
        return INTERRUPTED
    if junit is not None:
        _write(junit, checking.junit(rows))
    ended = code(outcome)
    return OVER_BUDGET if not ended and any(result.status == "over" for result in outcome.results) else ended


def say(text: str) -> None:
    """Talk goes to stderr; stdout is for what was asked for."""
    click.echo(text, err=True)


def plain(result: FileResult) -> dict[str, Any]:
    """A result as it stands in a `--json` document."""
    entry: dict[str, Any] = {"source": result.source, "status": result.status}
    if result.error:
        entry["error"] = result.error
    if result.written:
        entry["written"] = list(result.written)
    if result.report:
        entry["report"] = dict(result.report)
    return entry


def print_json(document: Any) -> None:
    """One document on stdout; ASCII, so that it is the same on a console of any encoding."""
    click.echo(json.dumps(document, indent=1))


def code(outcome: Outcome) -> int:
    """The exit code that results stand for."""
    if any(result.bug for result in outcome.results):
        return BUG
    return FAILED if any(result.status == "failed" for result in outcome.results) else 0


def _found(
    src: tuple[str, ...], many: Many, *, leave_out: Path | None = None, own_outputs: bool = False
) -> tuple[Source, ...]:  # fmt: skip
    if many.dask and many.timeout is not None:
        raise UsageError("--timeout stops processes of this machine; a cluster's are not ours to stop")
    if (*src, *many.from_file).count(STDIN) > 1:
        raise UsageError("standard input can be named only once")
    found = inputs.sources(
        src, lists=many.from_file, include=many.include, exclude=many.exclude, leave_out=leave_out,
        own_outputs=own_outputs,
    )  # fmt: skip
    if many.shard is not None:
        found = inputs.shard(found, *many.shard)
    return found


def _config(src: tuple[str, ...], many: Many, common: Common, options: Mapping[str, Any]) -> Config:
    return config_near([*src, *many.from_file], common, options)


def config_near(named: Sequence[str], common: Common, options: Mapping[str, Any]) -> Config:
    """The settings of a run; `footfix.yaml` is looked for from the common parent of what was named, upward."""
    from footfix.config import load_config

    parents = [Path(each) if Path(each).is_dir() else Path(each).parent for each in named if each != STDIN]
    try:
        near = Path(os.path.commonpath([str(each.absolute()) for each in parents])) if parents else Path.cwd()
    except ValueError:  # inputs on several drives have no common parent
        near = Path.cwd()
    return load_config(
        config=common.config, preset=common.preset, sets=common.sets, near=near, command_line=dict(options)
    )


def _several(src: tuple[str, ...], found: Sequence[Source]) -> bool:
    return len(found) > 1 or any(Path(each).is_dir() for each in src)


def _whole_run(output: Path, many: Many, kind: str) -> dict[str, Path]:
    files = {"summary": output / many.named("summary", ".json")}
    if kind == "html":
        files["index"] = output / many.named("index", ".html")
    return files


def _reported(output: Path | None, name: str) -> bool:
    """Whether a report with a fingerprint lies there; then the clip decides for itself whether it is done."""
    assert output is not None
    path = (output / name).with_suffix("")
    try:
        head = json.loads(path.with_name(path.name + REPORT).read_bytes())
    except (OSError, ValueError):
        return False
    return isinstance(head, dict) and "fingerprint" in head


def _reading(source: Source) -> Job:
    return Job(source.path, None, None, source.below.as_posix())


def _tasks(jobs: Sequence[Job], found: Sequence[Source], config: Config, labels: Path | None) -> list[Task]:
    given = _labels_for(labels, found)
    return [
        Task(
            job,
            config.settings(None if job.source == STDIN else Path(job.source)),
            labels=given.get(job.source),
            folder=str(Path.cwd()),
        )
        for job in jobs
    ]


def _labels_for(path: Path | None, found: Sequence[Source]) -> dict[str, Labels]:
    """For each input the labels given for it: one file for one clip, or a folder with a file for each."""
    if path is None:
        return {}
    from footfix.formats.contacts import decode

    if path.is_file():
        if len(found) > 1:
            raise UsageError(f"{path} labels one clip, but {len(found)} are named; give a folder of label files")
        return {found[0].path: decode(read_whole(path, 1 << 30), name=str(path))}
    given = {}
    for source in found:
        stem = source.below.with_suffix("")
        places = [(path / folder / stem.name) for folder in dict.fromkeys((stem.parent, Path()))]
        kinds = ("json", "csv", "npz")
        names = (place.with_name(f"{place.name}.contacts.{kind}") for place in places for kind in kinds)
        file = next((each for each in names if each.is_file()), None)
        if file is None:
            raise UsageError(f"{path} holds no {stem.as_posix()}.contacts.json (.csv, .npz) for {source.path}")
        given[source.path] = decode(read_whole(file, 1 << 30), name=str(file))
    return given


def _run(
    work: Callable[[Task], FileResult], tasks: Sequence[Task], many: Many, common: Common, style: str,
    journal: Journal, told: Callable[[FileResult, Callable[[str], None]], None],
) -> Outcome:  # fmt: skip
    """Runs the tasks, with a bar or lines of progress; failures are told at once."""
    progress = Progress(len(tasks), shown=not common.quiet and not common.as_json)

    def ended(result: FileResult) -> None:
        if result.error:
            progress.say(f"footfix: {result.error}")
            if style == "github":
                from footfix.report.annotations import annotation

                click.echo(annotation("error", result.source, result.error, line=result.line))
        told(result, progress.say)
        progress.step(failed=result.status == "failed", skipped=result.skipped)

    def asked_to_stop(running: int) -> None:
        progress.say("footfix: finishing the clips that are being worked on; once more stops at once")

    crew = Crew(many.jobs, many.timeout, many.dask)
    try:
        return run(work, tasks, crew=crew, told=ended, journal=journal, asked_to_stop=asked_to_stop)
    finally:
        progress.close()


def _told_cleaned(common: Common, few: bool) -> Callable[[FileResult, Callable[[str], None]], None]:
    def told(result: FileResult, say: Callable[[str], None]) -> None:
        from footfix.report.text import summarize

        if result.data:
            sys.stdout.buffer.write(result.data)
        if not result.error and not common.quiet and not common.as_json and (few or common.verbose):
            say(summarize(result.report, verbose=common.verbose and few))

    return told


def _entry(task: Task, result: FileResult) -> Entry:
    from footfix.report.summary import Entry

    kinds: dict[str, str] = {CONTACTS: "contacts", REPORT: "report", PAGE: "page", PICTURE: "picture"}
    base = task.job.within
    written: dict[str, str] = {}
    for path in map(Path, result.written):
        kind = next((kinds[suffix] for suffix in kinds if path.name.endswith(suffix)), "bvh")
        written[kind] = (path.relative_to(base) if base is not None else path).as_posix()
    order: tuple[str, ...] = ("bvh", "contacts", "report", "page", "picture")
    outputs_of = {kind: written[kind] for kind in order if kind in written}
    return Entry(task.job.name, result.status, result.error, result.line, result.report, outputs_of)


def _write_whole_run(
    entries: Sequence[Entry], results: Sequence[FileResult], tasks: Sequence[Task], whole: Mapping[str, Path],
    past: Past,
) -> None:  # fmt: skip
    from footfix.report.index import IndexRow, render_index
    from footfix.report.offenders import Offender
    from footfix.report.summary import summarize_run

    text = json.dumps(summarize_run(entries), indent=1, ensure_ascii=False) + "\n"
    _write(whole["summary"], text.encode("utf-8", "surrogateescape"))
    if "index" not in whole:
        return
    rows = []
    for entry, result in zip(entries, results, strict=True):
        pictures = result.offenders
        if result.skipped:
            pictures = tuple(Offender(**each) for each in past.offenders.get(entry.source, ()))
        report = entry.report or {"status": "failed"}
        rows.append(IndexRow(entry.source, entry.outputs.get("page", ""), report, entry.error, pictures))
    _write(whole["index"], render_index(rows).encode("utf-8", "replace"))


def _write_junit(suite: str, path: Path, entries: Sequence[Entry], results: Sequence[FileResult]) -> None:
    from footfix.report.junit import Case, junit
    from footfix.report.text import released

    cases = [
        Case(entry.source, error=entry.error, output=tuple(released(entry.report)) if entry.report else ())
        for entry in entries
    ]
    _write(path, junit(suite, cases))


def _write(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, data)


def _one_or_many(documents: list[Any]) -> Any:
    return documents[0] if len(documents) == 1 else {"format": "footfix-run", "version": 1, "files": documents}

"""`footfix clean`: settle inputs and outputs, run, and sum up."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from footfix.batch import outputs
from footfix.batch.inputs import Source
from footfix.batch.journal import Journal, Past, recall
from footfix.batch.run import Outcome
from footfix.batch.task import CONTACTS, PAGE, PICTURE, REPORT, FileResult, Task, beside
from footfix.batch.work import clean_one
from footfix.cli.options import Common, Many, many, shared
from footfix.cli.running import (
    Say,
    code,
    config_for,
    found_inputs,
    plain,
    print_json,
    run_tasks,
    tasks_for,
    write_file,
)
from footfix.cli.say import say
from footfix.errors import ExitCode, UsageError

if TYPE_CHECKING:
    from footfix.report.summary import Entry


@click.command()
@click.argument("src", nargs=-1)
@click.option("-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder for the outputs.")
@click.option("--in-place", is_flag=True, help="Put the corrected file in the input's place.")
@click.option("--method", type=click.Choice(["ik", "root", "both"]), help="How plants are held (enforce.method).")
@click.option("--labels", type=click.Path(exists=True, path_type=Path),
              help="Contacts to use in place of detection: JSON, CSV or NPZ, or a folder of them.")  # fmt: skip
@click.option("--report", type=click.Choice(["none", "json", "html"]), help="What is written beside the clip.")
@click.option("--png", is_flag=True, help="Also draw a picture of the worst plants.")
@click.option("--dry-run", is_flag=True, help="Do everything but write.")
@click.option("--force", is_flag=True, help="Overwrite outputs that are there.")
@click.option("--resume", is_flag=True, help="Go on with an interrupted run: leave what is done already.")
@click.option("--junit", type=click.Path(dir_okay=False, path_type=Path), help="Write the results as JUnit XML.")
@click.option("--format", "style", type=click.Choice(["text", "github"]), default="text", show_default=True,
              help="How failures are told.")  # fmt: skip
@many
@shared
def clean(
    src: tuple[str, ...], output: Path | None, in_place: bool, method: str | None, labels: Path | None,
    report: str | None, png: bool, dry_run: bool, force: bool, resume: bool, junit: Path | None, style: str, many: Many,
    common: Common,
) -> int:  # fmt: skip
    """Take the foot skate out of clips.

    SRC is a BVH file, a folder, or - for standard input.
    """
    options: dict[str, Any] = {}
    if method:
        options["enforce"] = {"method": method}
    if report:
        options["report"] = {"kind": report}
    if png:
        options.setdefault("report", {})["png"] = True
    return cleaned(
        src, output=output, in_place=in_place, options=options, labels=labels, dry_run=dry_run, force=force,
        resume=resume, junit=junit, style=style, many=many, common=common,
    )  # fmt: skip


def cleaned(
    src: tuple[str, ...], *, output: Path | None, in_place: bool, options: Mapping[str, Any], labels: Path | None,
    dry_run: bool, force: bool, resume: bool, junit: Path | None, style: str, many: Many, common: Common,
    work: Callable[[Task], FileResult] = clean_one, ending: str = "clean",
) -> int:  # fmt: skip
    """Settle inputs and outputs, run, and sum up."""
    if output is not None and in_place:
        raise UsageError("-o and --in-place exclude each other")
    if resume and output is None:
        raise UsageError("--resume goes on in a folder of outputs; say which with -o")
    found = found_inputs(src, many, leave_out=output)
    config = config_for(src, many, common, options)
    kind = config.settings().report.kind
    past = recall(output) if output is not None and resume else Past()
    whole = _whole_run(output, many, kind) if output is not None and _several(src, found) else {}
    jobs = outputs.plan(
        found, output=output, in_place=in_place, force=force, dry_run=dry_run,
        suffixes=lambda source: beside(config.settings(Path(source.path))),
        ours=lambda name: resume and (name == "" or name in past.begun or _reported(output, name)),
        extra=whole.values(), ending=ending,
    )  # fmt: skip
    if common.as_json and any(job.target is None for job in jobs):
        raise UsageError("--json and a clip on standard output exclude each other; say where the clip goes with -o")
    few = len(jobs) == 1 or common.as_json
    tasks = [
        replace(task, dry_run=dry_run, resume=resume and not force, keep_report=few, tag=many.tag,
                wrote=past.hashes.get(task.job.name, {}) if task.job.name in past.begun else None)
        for task in tasks_for(jobs, found, config, labels)
    ]  # fmt: skip
    writes = output is not None and not dry_run and (whole or resume)
    journal = Journal(output if writes else None, many.tag)
    try:
        outcome = run_tasks(work, tasks, many, common, style, journal, _told_cleaned(common, few))
        if not outcome.interrupted:
            journal.finish()
    finally:
        journal.close()
    return _close_clean(outcome, tasks, {} if dry_run else whole, past, junit, style, common, f"footfix {ending}")


def _close_clean(
    outcome: Outcome, tasks: Sequence[Task], whole: Mapping[str, Path], past: Past, junit: Path | None, style: str,
    common: Common, suite: str,
) -> int:  # fmt: skip
    """What is told and written at the end of a run of `clean`."""
    from footfix.report.summary import table

    if common.as_json:
        print_json({"format": "footfix-run", "version": 1, "files": [plain(each) for each in outcome.results]})
    if outcome.interrupted:
        return ExitCode.INTERRUPTED
    entries = [_entry(task, result) for task, result in zip(tasks, outcome.results, strict=True)]
    if whole:
        _write_whole_run(entries, outcome.results, tasks, whole, past)
    if junit is not None:
        _write_junit(suite, junit, entries, outcome.results)
    if len(tasks) > 1 and not common.quiet and style == "text":
        say(table(entries))
    return code(outcome)


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


def _told_cleaned(common: Common, few: bool) -> Callable[[FileResult, Say], None]:
    def told(result: FileResult, say: Say) -> None:
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
    from footfix.report.offenders import Offender
    from footfix.report.summary import summarize_run
    from footfix.report.web.index import IndexRow, render_index

    text = json.dumps(summarize_run(entries), indent=1, ensure_ascii=False) + "\n"
    write_file(whole["summary"], text.encode("utf-8", "surrogateescape"))
    if "index" not in whole:
        return
    rows = []
    for entry, result in zip(entries, results, strict=True):
        pictures = result.offenders
        if result.skipped:
            pictures = tuple(Offender(**each) for each in past.offenders.get(entry.source, ()))
        report = entry.report or {"status": "failed"}
        rows.append(IndexRow(entry.source, entry.outputs.get("page", ""), report, entry.error, pictures))
    write_file(whole["index"], render_index(rows).encode("utf-8", "replace"))


def _write_junit(suite: str, path: Path, entries: Sequence[Entry], results: Sequence[FileResult]) -> None:
    from footfix.report.junit import Case, junit
    from footfix.report.text import released

    cases = [
        Case(entry.source, error=entry.error, output=tuple(released(entry.report)) if entry.report else ())
        for entry in entries
    ]
    write_file(path, junit(suite, cases))

"""What `footfix detect`, `inspect`, `report` and `check` do."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import click

from footfix.batch import outputs
from footfix.batch.inputs import Source
from footfix.batch.journal import Journal
from footfix.batch.outputs import Job
from footfix.batch.work import FileResult, check_one, detect_one, inspect_one, repair_one
from footfix.cli_common import (
    FAILED,
    INTERRUPTED,
    OVER_BUDGET,
    Say,
    code,
    config_for,
    found_inputs,
    one_or_many,
    plain,
    print_json,
    run_tasks,
    say,
    tasks_for,
    write_file,
)
from footfix.cli_options import Common, Many
from footfix.errors import UsageError
from footfix.files import STDIN


def detect(
    src: tuple[str, ...], *, output: Path | None, kind: str, options: Mapping[str, Any], labels: Path | None,
    force: bool, many: Many, common: Common,
) -> int:  # fmt: skip
    """`footfix detect`."""
    found = found_inputs(src, many, leave_out=output)
    config = config_for(src, many, common, options)
    jobs = outputs.plan_labels(found, output=output, suffix=f".contacts.{kind}", force=force or common.as_json)
    tasks = [
        replace(task, extra={"kind": kind}, dry_run=common.as_json, tag=many.tag)
        for task in tasks_for(jobs, found, config, labels)
    ]

    def told(result: FileResult, say: Say) -> None:
        if common.as_json:
            return
        if result.data:
            sys.stdout.buffer.write(result.data)
        elif not common.quiet and not result.error and (len(tasks) == 1 or common.verbose):
            say(f"{result.source}: {result.report['contacts']} contacts -> {', '.join(result.written)}")
        for note in result.report.get("notes", ()) if not common.quiet else ():
            if common.verbose or note["severity"] != "note":
                say(f"  {note['severity']}: {note['text']}")

    outcome = run_tasks(detect_one, tasks, many, common, "text", Journal(None, ""), told)
    if common.as_json:
        files = [json.loads(result.data) if result.data else plain(result) for result in outcome.results]
        print_json(one_or_many(files))
    return INTERRUPTED if outcome.interrupted else code(outcome)


def inspect(src: tuple[str, ...], *, many: Many, common: Common) -> int:
    """`footfix inspect`."""
    from footfix.report.inspection import describe

    found = found_inputs(src, many, own_outputs=True)
    config = config_for(src, many, common, {})
    tasks = tasks_for([_reading(source) for source in found], found, config, None)
    outcome = run_tasks(inspect_one, tasks, many, common, "text", Journal(None, ""), lambda result, say: None)
    if common.as_json:
        print_json(one_or_many([dict(each.report) if each.report else plain(each) for each in outcome.results]))
    else:
        for result in outcome.results:
            if result.report:
                click.echo(describe(result.report, quiet=common.quiet))
    return INTERRUPTED if outcome.interrupted else code(outcome)


def repair(src: tuple[str, ...], *, output: Path | None, force: bool, many: Many, common: Common) -> int:
    """`footfix inspect --repair`."""
    found = found_inputs(src, many, leave_out=output)
    config = config_for(src, many, common, {})
    if output is None and any(source.path != STDIN for source in found):
        raise UsageError("--repair writes files: say where with -o")
    jobs = outputs.plan(found, output=output, in_place=False, suffixes=lambda source: (), force=force)

    def told(result: FileResult, say: Say) -> None:
        if result.data:
            sys.stdout.buffer.write(result.data)
        if common.quiet or common.as_json or result.error:
            return
        changes = result.report["notes"]
        say(f"{result.source}: {len(changes)} changes" if changes else f"{result.source}: nothing to change")
        for note in changes:
            place = f" line {note['line']}:" if "line" in note else ""
            say(f"  {note['severity']} [{note['id']}]{place} {note['text']}")

    outcome = run_tasks(repair_one, tasks_for(jobs, found, config, None), many, common, "text", Journal(None, ""), told)
    if common.as_json:
        print_json(one_or_many([plain(each) for each in outcome.results]))
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
    found = found_inputs(src, many, own_outputs=True)
    config = config_for(src, many, common, {})
    jobs = [_reading(source) for source in found]
    tasks = [replace(task, extra={"gates": limits, "anew": anew}) for task in tasks_for(jobs, found, config, labels)]
    for task in tasks:
        gates.known(task.settings.gates)
    outcome = run_tasks(check_one, tasks, many, common, style, Journal(None, ""), lambda result, say: None)
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
        write_file(junit, checking.junit(rows))
    ended = code(outcome)
    return OVER_BUDGET if not ended and any(result.status == "over" for result in outcome.results) else ended


def _reading(source: Source) -> Job:
    return Job(source.path, None, None, source.below.as_posix())

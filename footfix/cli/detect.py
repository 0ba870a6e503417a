"""`footfix detect`: contact labels only."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from footfix.batch import outputs
from footfix.batch.journal import Journal
from footfix.batch.task import FileResult
from footfix.batch.work import detect_one
from footfix.cli.options import Common, Many, many, shared
from footfix.cli.running import (
    Say,
    code,
    config_for,
    found_inputs,
    one_or_many,
    plain,
    print_json,
    run_tasks,
    tasks_for,
)
from footfix.errors import ExitCode


@click.command()
@click.argument("src", nargs=-1)
@click.option("-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder for the outputs.")
@click.option("--format", "kind", type=click.Choice(["json", "csv", "npz"]), default="json", show_default=True)
@click.option(
    "--method", type=click.Choice(["auto", "threshold", "adaptive", "lyard"]), help="Detector (detect.method)."
)
@click.option("--labels", type=click.Path(exists=True, path_type=Path), help="Contacts to keep; the rest is detected.")
@click.option("--force", is_flag=True, help="Overwrite outputs that are there.")
@many
@shared
def detect(
    src: tuple[str, ...], output: Path | None, kind: str, method: str | None, labels: Path | None, force: bool,
    many: Many, common: Common,
) -> int:  # fmt: skip
    """Find contacts only, as labels."""
    options = {"detect": {"method": method}} if method else {}
    return detected(
        src, output=output, kind=kind, options=options, labels=labels, force=force, many=many, common=common
    )


def detected(
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
    return ExitCode.INTERRUPTED if outcome.interrupted else code(outcome)

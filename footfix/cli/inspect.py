"""`footfix inspect`: describe files, or repair them."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from footfix.batch import output_paths
from footfix.batch.file_io import STDIN
from footfix.batch.journal import Journal
from footfix.batch.multi_clip_files import spread
from footfix.batch.one_file import inspect_one, repair_one
from footfix.batch.task import FileResult
from footfix.cli.options import Common, Many, many, shared
from footfix.cli.running import (
    Say,
    code,
    config_for,
    found_inputs,
    one_or_many,
    plain,
    print_json,
    reading,
    run_tasks,
    tasks_for,
)
from footfix.errors import ExitCode, UsageError


@click.command()
@click.argument("src", nargs=-1, type=click.Path(allow_dash=True))
@click.option("--repair", is_flag=True, help="Write what a strict reader wants, and say what was changed.")
@click.option("-o", "--output", type=click.Path(path_type=Path), metavar="PATH",
              help="Folder for repaired files; with one file also a name for it.")  # fmt: skip
@click.option("--force", is_flag=True, help="Overwrite existing outputs.")
@many
@shared
def inspect(src: tuple[str, ...], repair: bool, output: Path | None, force: bool, many: Many, common: Common) -> int:
    """Say what is in a file: rig, units, floor, and everything odd about it."""
    if repair:
        return run_repair(src, output=output, force=force, many=many, common=common)
    return run_inspect(src, many=many, common=common)


def run_inspect(src: tuple[str, ...], *, many: Many, common: Common) -> int:
    """Run `footfix inspect`."""
    from footfix.report.inspection import describe

    found = found_inputs(src, many, own_outputs=True)
    config = config_for(src, many, common, {})
    tasks = tasks_for([reading(source) for source in found], found, config)
    outcome = run_tasks(inspect_one, tasks, many, common, "text", Journal(), lambda result, say: None)
    clips = [each for result in outcome.results for each in spread(result)]
    if common.as_json:
        print_json(one_or_many([dict(each.report) if each.report else plain(each) for each in clips]))
    else:
        for result in clips:
            if result.report:
                click.echo(describe(result.report, quiet=common.quiet))
    return ExitCode.INTERRUPTED if outcome.interrupted else code(outcome)


def run_repair(src: tuple[str, ...], *, output: Path | None, force: bool, many: Many, common: Common) -> int:
    """Run `footfix inspect --repair`."""
    found = found_inputs(src, many, leave_out=output)
    config = config_for(src, many, common, {})
    if output is None and any(source.path != STDIN for source in found):
        raise UsageError("--repair writes files: say where with -o")
    folder = bool(many.from_file) or any(Path(each).is_dir() for each in src)
    one_file = output_paths.names_file(output, found, folder=folder)
    jobs = output_paths.plan(
        found, output=output, in_place=False, suffixes=lambda source: (), force=force, one_file=one_file
    )  # fmt: skip

    def print_repairs(result: FileResult, say: Say) -> None:
        if result.data:
            sys.stdout.buffer.write(result.data)
        if common.quiet or common.as_json or result.error:
            return
        changes = result.report["notes"]
        say(f"{result.source}: {len(changes)} changes" if changes else f"{result.source}: nothing to change")
        for note in changes:
            place = f" line {note['line']}:" if "line" in note else ""
            say(f"  {note['severity']} [{note['id']}]{place} {note['text']}")

    outcome = run_tasks(repair_one, tasks_for(jobs, found, config), many, common, "text", Journal(), print_repairs)
    if common.as_json:
        print_json(one_or_many([plain(each) for each in outcome.results]))
    return ExitCode.INTERRUPTED if outcome.interrupted else code(outcome)

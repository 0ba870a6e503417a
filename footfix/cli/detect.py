"""`footfix detect`: contact labels only."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from footfix.batch import output_paths
from footfix.batch.journal import Journal
from footfix.batch.multi_clip_files import spread
from footfix.batch.one_file import detect_one
from footfix.batch.task import FileResult
from footfix.cli.closing_message import wrote
from footfix.cli.options import Common, Given, Many, given, many, shared
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
from footfix.cli.stderr import say
from footfix.errors import ExitCode


@click.command()
@click.argument("src", nargs=-1, type=click.Path(allow_dash=True))
@click.option("-o", "--output", type=click.Path(path_type=Path), metavar="PATH",
              help="Folder for the outputs; with one clip also the name of the label file, ending in its format.")
@click.option("--format", "kind", type=click.Choice(["json", "csv", "frames", "npz", "npy"]),
              help="json; csv: a row a contact; frames: CSV with a row a frame; npz: mask, names, confidence and "
              "intervals; npy: the mask (F, 4) alone. By default as -o ends, else json.")
@click.option("--method", type=click.Choice(["auto", "threshold", "adaptive", "lyard"]),
              help="Detector (detect.method).")
@click.option("--events", is_flag=True, help="Also write when feet strike and lift, as walk.events.json; a glTF file "
              "gets a copy, too: character.events.glb has them as extras of its animations.")  # fmt: skip
@given("Contacts to keep; the rest is detected")
@click.option("--force", is_flag=True, help="Overwrite existing outputs.")
@many
@shared
def detect(
    src: tuple[str, ...], output: Path | None, kind: str | None, method: str | None, events: bool, given: Given,
    force: bool, many: Many, common: Common,
) -> int:  # fmt: skip
    """Find contacts only, as labels.

    Labels are written beside each clip, as walk.contacts.json, or into -o's folder; those of several clips are summed
    up in a table: plants of each effector, and the share of its frames in which an effector is planted.
    """
    options = {"detect": {"method": method}} if method else {}
    return run_detect(
        src, output=output, kind=kind, options=options, given=given, force=force, many=many, common=common,
        events=events,
    )  # fmt: skip


def run_detect(
    src: tuple[str, ...], *, output: Path | None, kind: str | None, options: Mapping[str, Any], given: Given,
    force: bool, many: Many, common: Common, events: bool = False,
) -> int:  # fmt: skip
    """Run `footfix detect`."""
    from footfix.formats.contacts import ENDS

    found = found_inputs(src, many, leave_out=output)
    config = config_for(src, many, common, options)
    folder = bool(many.from_file) or any(Path(each).is_dir() for each in src)
    one_file = output_paths.names_file(output, found, folder=folder, ends=tuple(_SHORT))
    if kind is None:
        named = "" if output is None or not one_file else output.name.lower()
        kind = next((each for end, each in _SHORT.items() if named.endswith(end)), "json")
    jobs = output_paths.plan_labels(
        found, output=output, suffix=ENDS[kind], force=force or common.as_json, one_file=one_file
    )  # fmt: skip
    tasks = [
        replace(task, extra={"kind": kind, "one_file": one_file, "events": events}, dry_run=common.as_json,
                force=force, tag=many.tag)
        for task in tasks_for(jobs, found, config, given)
    ]  # fmt: skip
    outcome = run_tasks(detect_one, tasks, many, common, "text", Journal(), _told_detected(common, len(tasks) == 1))
    clips = [each for result in outcome.results for each in spread(result)]
    if common.as_json:
        print_json(one_or_many([_document(result, kind) for result in clips]))
    if outcome.interrupted:
        return ExitCode.INTERRUPTED
    if len(clips) > 1 and not common.quiet and not common.as_json:
        click.echo(_table(clips))
        say(wrote(outcome.results, every=common.verbose) or "nothing was written")
    return code(outcome)


# Ending of a label file's name -> its format; longer endings come first.
_SHORT = {".frames.csv": "frames", ".csv": "csv", ".json": "json", ".npz": "npz", ".npy": "npy"}


def _told_detected(common: Common, alone: bool) -> Callable[[FileResult, Say], None]:
    def told(result: FileResult, say: Say) -> None:
        if common.as_json:
            return
        for part in result.parts:
            told(part, say)
        if result.data:
            sys.stdout.buffer.write(result.data)
        elif not common.quiet and not result.error and alone and not result.parts and result.written:
            say(f"{result.source}: {result.report['contacts']} contacts -> {', '.join(result.written)}")
        for note in result.report.get("notes", ()) if not common.quiet else ():
            if common.verbose or note["severity"] != "note":
                say(f"  {note['severity']}: {'' if alone else result.source + ': '}{note['text']}")

    return told


def _document(result: FileResult, kind: str) -> Any:
    """Make the document that --json prints of a clip: its contacts file, or for other formats the counts."""
    if result.data and kind == "json":
        return json.loads(result.data)
    return plain(result)


def _table(results: Sequence[FileResult]) -> str:
    """Write a table of plants of each effector and coverage, for all clips with effectors of the same names."""
    from footfix.report.text import printable

    lines: list[str] = []
    header: list[str] = []
    width = max(len(printable(result.source)) for result in results)
    for result in results:
        where = f"{printable(result.source):<{width}}"
        if result.error:
            lines.append(f"{where}  failed")
            continue
        names = list(result.report["effectors"])
        if names != header:
            header = names
            lines.append(f"{'clip':<{width}}  {'  '.join(names)}  planted")
        counts = "  ".join(f"{count:>{len(name)}}" for name, count in result.report["effectors"].items())
        lines.append(f"{where}  {counts}  {100.0 * result.report['coverage']:5.0f} %")
    return "\n".join(lines)

"""`footfix clean`: find inputs and outputs, run, and sum up."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from footfix.batch import output_paths
from footfix.batch.inputs import Source
from footfix.batch.journal import Journal, Past, journal_in, recall
from footfix.batch.multi_clip_files import spread, spread_pairs
from footfix.batch.one_file import clean_one
from footfix.batch.output_paths import Job
from footfix.batch.run import Outcome
from footfix.batch.task import CONTACTS, PAGE, PICTURE, REPORT, FileResult, Task, beside
from footfix.cli.closing_message import wrote
from footfix.cli.options import Common, Given, Many, Writing, given, many, shared, writing
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
from footfix.cli.stderr import say
from footfix.errors import ExitCode, UsageError

if TYPE_CHECKING:
    from footfix.report.summary import Entry


@dataclass(frozen=True)
class Whole:
    """The outputs of a whole run.

    Args:
        folder: where they are written; None where the command line names no one folder for all clips.
        own: whether the folder holds only outputs, as one given by -o does.
        files: "summary" and "index" -> path; none for a single clip.
    """

    folder: Path | None = None
    own: bool = False
    files: Mapping[str, Path] = field(default_factory=dict)


@click.command()
@click.argument("src", nargs=-1, type=click.Path(allow_dash=True))
@click.option("-o", "--output", type=click.Path(path_type=Path), metavar="PATH",
              help="Folder for the outputs; with one file also the name of the corrected one, ending as it does.")
@click.option("--in-place", is_flag=True, help="Put the corrected file in the input's place.")
@click.option("--method", type=click.Choice(["ik", "root", "both"]), help="How plants are held (enforce.method).")
@given("Contacts to use in place of detection")
@click.option("--report", type=click.Choice(["none", "json", "html"]), help="What is written beside the clip.")
@click.option("--png", is_flag=True, help="Also draw a picture of the worst plants.")
@click.option("--anew", is_flag=True, help="Clean even files that footfix wrote, as a report beside them says.")
@writing
@many
@shared
def clean(
    src: tuple[str, ...], output: Path | None, in_place: bool, method: str | None, given: Given,
    report: str | None, png: bool, anew: bool, writing: Writing, many: Many, common: Common,
) -> int:  # fmt: skip
    """Take the foot skate out of clips.

    SRC is a BVH or glTF file (.glb, .gltf, .vrm, .vrma), a folder, or - for standard input.

    Beside walk.bvh are written walk.clean.bvh, walk.contacts.json, walk.report.json and walk.report.html; -o FOLDER
    puts them there, as walk.bvh and so on, and -o NAME.bvh gives the corrected clip a name of its own. Every
    animation of a glTF file is a clip: character.glb gives character.clean.glb, character.Walk.contacts.json, and so
    on for each. For one folder, index.html and summary.json are written too: into that folder, or into the one that
    -o names. Several files or folders get those two with -o only.
    """
    options: dict[str, Any] = {}
    if method:
        options["enforce"] = {"method": method}
    if report:
        options["report"] = {"kind": report}
    if png:
        options.setdefault("report", {})["png"] = True
    return run_clips(
        src, output=output, in_place=in_place, options=options, given=given, writing=writing, anew=anew, many=many,
        common=common,
    )  # fmt: skip


def run_clips(
    src: tuple[str, ...], *, output: Path | None, in_place: bool, options: Mapping[str, Any], given: Given,
    writing: Writing, many: Many, common: Common,
    work: Callable[[Task], FileResult] = clean_one, ending: str = "clean", anew: bool = False,
) -> int:  # fmt: skip
    """Find inputs and outputs, run, and sum up; for every command that makes a clip from each clip.

    Args:
        src: files and folders of the command line.
        output, in_place: the options of `clean`.
        options: settings that the command's own options stand for.
        given: contacts given by the user.
        writing, many, common: options on writing, on inputs and processes, and on settings and messages.
        work: the function that makes the outputs of a task.
        anew: whether clips written by an earlier cleaning are cleaned again.
        ending: "clean" or "loop": part of the names of outputs beside their input, and the command's name in JUnit.
    """
    if output is not None and in_place:
        raise UsageError("-o and --in-place exclude each other")
    found = found_inputs(src, many, leave_out=output)
    one_file = output_paths.names_file(output, found, folder=bool(many.from_file) or _a_folder(src))
    config = config_for(src, many, common, options)
    whole = whole_run(src, found, None if one_file else output, many, config.settings().report.kind, ending)
    dry_run, force, resume = writing.dry_run, writing.force, writing.resume
    past = recall(whole.folder, ending) if whole.folder is not None and resume else Past()
    jobs = output_paths.plan(
        found, output=output, in_place=in_place, force=force, dry_run=dry_run, one_file=one_file,
        suffixes=lambda source: beside(config.settings(Path(source.path))),
        ours=lambda job: resume and (job.name in past.begun or _reported(job)),
        extra=whole.files.values(), extra_ours=resume and (whole.own or bool(past.begun)), ending=ending,
    )  # fmt: skip
    if common.as_json and any(job.target is None for job in jobs):
        raise UsageError("--json and a clip on standard output exclude each other; say where the clip goes with -o")
    few = len(jobs) == 1 or common.as_json
    tasks = [
        replace(task, extra={"anew": anew}, dry_run=dry_run, force=force, resume=resume and not force,
                keep_report=few, tag=many.tag,
                wrote=past.hashes.get(task.job.name, {}) if task.job.name in past.begun else None)
        for task in tasks_for(jobs, found, config, given)
    ]  # fmt: skip
    writes = whole.folder is not None and not dry_run and (whole.files or resume)
    path = journal_in(whole.folder, many.tag, own=whole.own, ending=ending) if writes and whole.folder else None
    journal = Journal(path)
    try:
        outcome = run_tasks(work, tasks, many, common, writing.style, journal, _print_verdicts(common, few))
        if not outcome.interrupted:
            journal.finish()
    finally:
        journal.close()
    whole = replace(whole, files={}) if dry_run else whole
    return _close_clean(outcome, tasks, whole, past, writing, common, ending)


def _close_clean(
    outcome: Outcome, tasks: Sequence[Task], whole: Whole, past: Past, writing: Writing, common: Common, ending: str
) -> int:  # fmt: skip
    """Write the summary, index and JUnit file of a run, print its last messages, and return the exit code."""
    from footfix.report.summary import table

    if common.as_json:
        files = [plain(each) for result in outcome.results for each in spread(result)]
        print_json({"format": "footfix-run", "version": 1, "files": files})
    if outcome.interrupted:
        return ExitCode.INTERRUPTED
    clips = spread_pairs(tasks, outcome.results)
    entries = [_entry(task, result, whole) for task, result in clips]
    if whole.files:
        _write_whole_run(entries, [result for _, result in clips], whole.files, past)
    if writing.junit is not None:
        _write_junit(f"footfix {ending}", writing.junit, entries, [result for _, result in clips])
    if common.quiet or common.as_json:
        return code(outcome)
    if len(entries) > 1 and writing.style == "text":
        say(table(entries))
    hint = "" if len(tasks) == 1 else "-o FOLDER adds index.html and summary.json"
    text = wrote(outcome.results, extra=whole.files.values(), hint="" if whole.files else hint, every=common.verbose)
    if text:
        say(text)
    return code(outcome)


def _a_folder(src: Sequence[str]) -> bool:
    return any(Path(each).is_dir() for each in src)


def whole_run(
    src: Sequence[str], found: Sequence[Source], output: Path | None, many: Many, kind: str,
    ending: str = "clean",
) -> Whole:  # fmt: skip
    """Choose where summary and index of a run are written: into -o's folder, or into the only folder given.

    Args:
        src: files and folders of the command line.
        found: the inputs.
        output: the folder of -o.
        many: the shard, which is part of the names.
        kind: of the reports; an index is written only where there are pages.
        ending: of the command's outputs; part of the names, except for "clean", where several commands may write into
            one folder.
    """
    folder = output
    if folder is None and len(src) == 1 and not many.from_file and _a_folder(src):
        folder = Path(src[0])
    if folder is None or not (len(found) > 1 or _a_folder(src)):
        return Whole(folder, output is not None)
    before = "" if ending == "clean" or output is not None else f"{ending}."
    files = {"summary": folder / many.named(f"{before}summary", ".json")}
    if kind == "html":
        files["index"] = folder / many.named(f"{before}index", ".html")
    return Whole(folder, output is not None, files)


def _reported(job: Job) -> bool:
    """Tell whether a report with a fingerprint exists; by it each task finds out whether its clip is done."""
    if job.stem is None:
        return False
    try:
        head = json.loads(job.beside(REPORT).read_bytes())
    except (OSError, ValueError):
        return False
    return isinstance(head, dict) and "fingerprint" in head


def _print_verdicts(common: Common, few: bool) -> Callable[[FileResult, Say], None]:
    def print_verdict(result: FileResult, say: Say) -> None:
        from footfix.report.text import summarize

        for each in spread(result):
            if each.data:
                sys.stdout.buffer.write(each.data)
            shown = (few and not result.parts) or common.verbose
            if not each.error and not common.quiet and not common.as_json and shown:
                say(summarize(each.report, verbose=common.verbose and few))

    return print_verdict


def _entry(task: Task, result: FileResult, whole: Whole) -> Entry:
    from footfix.report.summary import Entry

    kinds: dict[str, str] = {CONTACTS: "contacts", REPORT: "report", PAGE: "page", PICTURE: "picture"}
    base = task.job.within or whole.folder
    written: dict[str, str] = {}
    for path in map(Path, result.written):
        kind = next((kinds[suffix] for suffix in kinds if path.name.endswith(suffix)), path.suffix[1:].lower())
        written[kind] = path.as_posix() if base is None else _from(base, path)
    motion = [kind for kind in written if kind not in kinds.values()]
    outputs_of = {kind: written[kind] for kind in (*motion, *kinds.values()) if kind in written}
    return Entry(task.job.name, result.status, result.error, result.line, result.report, outputs_of)


def _from(base: Path, path: Path) -> str:
    """Make a file's path relative to a folder; links are followed, since --in-place replaces their targets."""
    if path.is_relative_to(base):
        return path.relative_to(base).as_posix()
    return Path(os.path.relpath(os.path.realpath(path), os.path.realpath(base))).as_posix()


def _write_whole_run(
    entries: Sequence[Entry], results: Sequence[FileResult], whole: Mapping[str, Path], past: Past
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
        Case(entry.source, error=entry.error, output=tuple(released(entry.report)) if entry.report else (),
             seconds=result.seconds)
        for entry, result in zip(entries, results, strict=True)
    ]  # fmt: skip
    write_file(path, junit(suite, cases))

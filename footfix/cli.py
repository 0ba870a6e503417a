"""The command line: clean, detect, check, inspect, settings, report. No mathematics, no file formats.

Heavy imports stand inside the commands, so that `footfix --help` answers at once.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from footfix.errors import FootfixError, UsageError
from footfix.version import __version__

if TYPE_CHECKING:
    from footfix.batch import FileResult
    from footfix.config import Config
    from footfix.formats.contacts import Labels

Command = TypeVar("Command", bound=Callable[..., Any])

INTERRUPTED, BUG, OVER_BUDGET, FAILED = 130, 4, 1, 3


def main() -> None:
    """The entry point: commands, and what each kind of failure means to a shell."""
    _bytes_through()
    try:
        code = cli.main(standalone_mode=False)
        sys.exit(code if isinstance(code, int) else 0)
    except click.exceptions.Abort:
        sys.exit(INTERRUPTED)
    except click.ClickException as error:
        error.show()
        sys.exit(UsageError.exit_code)
    except FootfixError as error:
        say(f"footfix: {error}")
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        say("footfix: interrupted")
        sys.exit(INTERRUPTED)
    except BrokenPipeError:
        # The reader of our output has gone. Python would complain once more when it closes stdout.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    except Exception as error:
        say(f"footfix: a bug in footfix, not in your file: {type(error).__name__}: {error}")
        if os.environ.get("FOOTFIX_DEBUG"):
            raise
        say("footfix: please report it; FOOTFIX_DEBUG=1 shows where it happened")
        sys.exit(BUG)


def _bytes_through() -> None:
    """File names of any bytes, on consoles of any encoding, are shown as well as they can be, and never fail."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def say(text: str) -> None:
    """Talk goes to stderr; stdout is for what was asked for."""
    click.echo(text, err=True)


def shared(command: Command) -> Command:
    """The options that every command on clips takes."""
    for option in reversed(
        (
            click.option("--config", type=click.Path(exists=True, dir_okay=False, path_type=Path),
                         help="Settings file; without it footfix.yaml is looked for from the inputs upward."),
            click.option("--preset", metavar="NAME", help="Packed settings: mocap, video, ml-generated, ..."),
            click.option("--set", "sets", multiple=True, metavar="NAME=VALUE",
                         help="One setting, such as detect.method=threshold. May be repeated."),
            click.option("--json", "as_json", is_flag=True, help="One JSON document on stdout."),
            click.option("-q", "--quiet", is_flag=True, help="Only errors."),
            click.option("-v", "--verbose", is_flag=True, help="All measures and notes."),
        )
    ):  # fmt: skip
        command = option(command)
    return command


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="footfix")
def cli() -> None:
    """Cleans motion-capture clips: finds footplants and takes the foot skate out.

    footfix clean walk.bvh   writes walk.clean.bvh, contact labels and a report beside it.
    """


@cli.command()
@click.argument("src", nargs=-1, required=True)
@click.option("-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder for the outputs.")
@click.option("--in-place", is_flag=True, help="Put the corrected file in the input's place.")
@click.option("--method", type=click.Choice(["ik", "root", "both"]), help="How plants are held (enforce.method).")
@click.option("--labels", type=click.Path(exists=True, path_type=Path),
              help="Contacts to use in place of detection: JSON, CSV or NPZ, or a folder of them.")  # fmt: skip
@click.option("--report", type=click.Choice(["none", "json", "html"]), help="What is written beside the clip.")
@click.option("--dry-run", is_flag=True, help="Do everything but write.")
@click.option("--force", is_flag=True, help="Overwrite outputs that are there.")
@shared
def clean(
    src: tuple[str, ...], output: Path | None, in_place: bool, method: str | None, labels: Path | None,
    report: str | None, dry_run: bool, force: bool, config: Path | None, preset: str | None, sets: tuple[str, ...],
    as_json: bool, quiet: bool, verbose: bool,
) -> int:  # fmt: skip
    """Take the foot skate out of clips.

    SRC is a BVH file, a folder, or - for standard input.
    """
    from footfix import batch
    from footfix.report.text import summarize

    if output is not None and in_place:
        raise UsageError("-o and --in-place exclude each other")
    options: dict[str, Any] = {}
    if method:
        options["enforce"] = {"method": method}
    if report:
        options["report"] = {"kind": report}
    found = batch.sources(src)
    settings = _config(src, config, preset, sets, options)
    kind = settings.settings().report.kind
    suffixes = [
        ".contacts.json",
        *([".report.json"] if kind != "none" else []),
        *([".report.html"] if kind == "html" else []),
    ]
    jobs = batch.plan(found, output=output, in_place=in_place, suffixes=suffixes, force=force or dry_run)
    if as_json and any(job.target is None for job in jobs):
        raise UsageError("--json and a clip on standard output exclude each other; say where the clip goes with -o")
    given = _labels_for(labels, [job.source for job in jobs])

    def done(result: FileResult) -> None:
        if result.data:
            sys.stdout.buffer.write(result.data)
        if result.error:
            say(f"footfix: {result.error}")
        elif not quiet and not as_json:
            say(summarize(result.report, verbose=verbose))

    results = batch.run(jobs, lambda job: batch.clean_one(job, settings, given[job.source], dry_run=dry_run), done)
    if as_json:
        _print_json({"format": "footfix-run", "version": 1, "files": [_plain(result) for result in results]})
    elif len(results) > 1 and not quiet:
        failed = sum(result.status == "failed" for result in results)
        say(f"{len(results)} clips: {len(results) - failed} done, {failed} failed")
    return _code(results)


@cli.command()
@click.argument("src", nargs=-1, required=True)
@click.option("-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder for the outputs.")
@click.option("--format", "kind", type=click.Choice(["json", "csv", "npz"]), default="json", show_default=True)
@click.option(
    "--method", type=click.Choice(["auto", "threshold", "adaptive", "lyard"]), help="Detector (detect.method)."
)
@click.option("--labels", type=click.Path(exists=True, path_type=Path), help="Contacts to keep; the rest is detected.")
@click.option("--force", is_flag=True, help="Overwrite outputs that are there.")
@shared
def detect(
    src: tuple[str, ...], output: Path | None, kind: str, method: str | None, labels: Path | None, force: bool,
    config: Path | None, preset: str | None, sets: tuple[str, ...], as_json: bool, quiet: bool, verbose: bool,
) -> int:  # fmt: skip
    """Find contacts only, as labels."""
    from footfix import batch

    found = batch.sources(src)
    settings = _config(src, config, preset, sets, {"detect": {"method": method}} if method else {})
    targets = batch.plan_labels(found, output=output, suffix=f".contacts.{kind}", force=force or as_json)
    given = _labels_for(labels, [source.path for source in found])
    results = []
    for source, target in zip(found, targets, strict=True):
        result = batch.detect_one(source.path, None if as_json else target, kind, settings, given[source.path])
        results.append(result)
        if result.error:
            say(f"footfix: {result.error}")
        elif result.data and not as_json:
            sys.stdout.buffer.write(result.data)
        elif not quiet and not as_json:
            say(f"{source.path}: {result.report['contacts']} contacts -> {', '.join(result.written)}")
        for note in result.report.get("notes", ()) if not quiet else ():
            if verbose or note["severity"] != "note":
                say(f"  {note['severity']}: {note['text']}")
    if as_json:
        documents = [json.loads(result.data) if result.data else _plain(result) for result in results]
        _print_json(
            documents[0] if len(documents) == 1 else {"format": "footfix-run", "version": 1, "files": documents}
        )
    return _code(results)


@cli.command()
@click.argument("src", nargs=-1, required=True)
@shared
def inspect(
    src: tuple[str, ...], config: Path | None, preset: str | None, sets: tuple[str, ...], as_json: bool, quiet: bool,
    verbose: bool,
) -> int:  # fmt: skip
    """Say what is in a file: rig, units, floor, and everything odd about it."""
    from footfix import batch
    from footfix.report.inspection import describe

    settings = _config(src, config, preset, sets, {})
    results = []
    for source in batch.sources(src):
        result = batch.inspect_one(source.path, settings)
        results.append(result)
        if result.error:
            say(f"footfix: {result.error}")
        elif not as_json:
            click.echo(describe(result.report, quiet=quiet))
    if as_json:
        documents = [dict(result.report) if result.report else _plain(result) for result in results]
        _print_json(
            documents[0] if len(documents) == 1 else {"format": "footfix-run", "version": 1, "files": documents}
        )
    return _code(results)


@cli.command()
@click.argument("src", nargs=-1)
@shared
def settings(
    src: tuple[str, ...], config: Path | None, preset: str | None, sets: tuple[str, ...], as_json: bool, quiet: bool,
    verbose: bool,
) -> int:  # fmt: skip
    """Print the settings that hold, each with its origin, as YAML that --config takes."""
    from footfix import settings as composed

    chosen = _config(src or (".",), config, preset, sets, {})
    path = Path(src[0]) if src else None
    if as_json:
        _print_json(composed.plain(chosen.settings(path)))
    else:
        click.echo(composed.as_yaml(chosen.stack(path)), nl=False)
    return 0


def _config(
    src: tuple[str, ...], config: Path | None, preset: str | None, sets: tuple[str, ...], options: dict[str, Any]
) -> Config:
    from footfix.config import load_config

    places = [str((Path(each) if Path(each).is_dir() else Path(each).parent).absolute()) for each in src if each != "-"]
    try:
        near = Path(os.path.commonpath(places)) if places else Path.cwd()
    except ValueError:  # inputs on several drives have no common parent
        near = Path.cwd()
    return load_config(config=config, preset=preset, sets=sets, near=near, command_line=options)


def _labels_for(path: Path | None, named: list[str]) -> dict[str, Labels | None]:
    """For each input the labels given for it: one file for one clip, or a folder with a file for each."""
    if path is None:
        return dict.fromkeys(named)
    from footfix.files import read_whole
    from footfix.formats.contacts import decode

    if path.is_file():
        if len(named) > 1:
            raise UsageError(f"{path} labels one clip, but {len(named)} are named; give a folder of label files")
        return {named[0]: decode(read_whole(path, 1 << 30), name=str(path))}
    found: dict[str, Labels | None] = {}
    for name in named:
        stem = Path(name).stem
        file = next(
            (each for kind in ("json", "csv", "npz") if (each := path / f"{stem}.contacts.{kind}").is_file()), None
        )
        if file is None:
            raise UsageError(f"{path} holds no {stem}.contacts.json (.csv, .npz) for {name}")
        found[name] = decode(read_whole(file, 1 << 30), name=str(file))
    return found


def _plain(result: FileResult) -> dict[str, Any]:
    entry: dict[str, Any] = {"source": result.source, "status": result.status}
    if result.error:
        entry["error"] = result.error
    if result.written:
        entry["written"] = list(result.written)
    if result.report:
        entry["report"] = dict(result.report)
    return entry


def _print_json(document: Any) -> None:
    # ASCII, so that it is the same document on a console of any encoding
    click.echo(json.dumps(document, indent=1))


def _code(results: Any) -> int:
    return FAILED if any(result.status == "failed" for result in results) else 0

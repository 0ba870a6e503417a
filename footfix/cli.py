"""The command line: clean, detect, check, inspect, settings, report. No mathematics, no file formats.

Heavy imports stand inside the commands, so that `footfix --help` answers at once.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import click

from footfix.cli_options import Common, Many, many, shared
from footfix.errors import FootfixError, UsageError
from footfix.version import __version__

INTERRUPTED, BUG = 130, 4


def main() -> None:
    """The entry point: does what the command line asks for, and ends the process."""
    try:
        code = run()
        _hear_no_more()
    except KeyboardInterrupt:  # one more, on the way out
        _hear_no_more()
        code = INTERRUPTED
    if code == INTERRUPTED:  # Python itself would end as killed, had it been at code from a string, as dataclasses are
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(code)
    sys.exit(code)


def _hear_no_more() -> None:
    """All is written and said: while Python puts itself away, an interrupt would only make another code of this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def run() -> int:
    """Does what the command line asks for, and gives what each kind of ending means to a shell: its exit code."""
    _bytes_through()
    # One thread a process: batches run as many processes, and sums come out the same to the last bit.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    try:
        code = cli.main(standalone_mode=False)
        sys.stdout.flush()
    except click.exceptions.Abort:
        return INTERRUPTED
    except click.ClickException as error:
        error.show()
        return UsageError.exit_code
    except FootfixError as error:
        say(f"footfix: {error}")
        return error.exit_code
    except KeyboardInterrupt:
        say("footfix: interrupted")
        return INTERRUPTED
    except (BrokenPipeError, SystemExit):  # what click makes of a pipe whose reader has gone
        # Python would complain once more when it closes stdout.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        say(f"footfix: can't write what was asked for: {error.strerror or error}")
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FootfixError.exit_code
    except Exception as error:
        say(f"footfix: a bug in footfix, not in your file: {type(error).__name__}: {error}")
        if os.environ.get("FOOTFIX_DEBUG"):
            raise
        say("footfix: please report it; FOOTFIX_DEBUG=1 shows where it happened")
        return BUG
    finally:
        gc.freeze()  # Python looks through all that is left before it ends, for 20 ms; the system takes it back anyway
    return code if isinstance(code, int) else 0


def _bytes_through() -> None:
    """File names of any bytes, on consoles of any encoding, are shown as well as they can be, and never fail."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def say(text: str) -> None:
    """Talk goes to stderr; stdout is for what was asked for."""
    click.echo(text, err=True)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="footfix")
def cli() -> None:
    """Cleans motion-capture clips: finds footplants and takes the foot skate out.

    footfix clean walk.bvh   writes walk.clean.bvh, contact labels and a report beside it.
    """


@cli.command()
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
    from footfix import cli_clean

    options: dict[str, Any] = {}
    if method:
        options["enforce"] = {"method": method}
    if report:
        options["report"] = {"kind": report}
    if png:
        options.setdefault("report", {})["png"] = True
    return cli_clean.clean(
        src, output=output, in_place=in_place, options=options, labels=labels, dry_run=dry_run, force=force,
        resume=resume, junit=junit, style=style, many=many, common=common,
    )  # fmt: skip


@cli.command()
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
    from footfix import cli_runs

    options = {"detect": {"method": method}} if method else {}
    return cli_runs.detect(
        src, output=output, kind=kind, options=options, labels=labels, force=force, many=many, common=common
    )


@cli.command()
@click.argument("src", nargs=-1)
@click.option("--max", "most", multiple=True, metavar="NAME=VALUE",
              help="The most a measure may be, such as slide_mm=21. May be repeated.")  # fmt: skip
@click.option("--labels", type=click.Path(exists=True, path_type=Path), help="Contacts to measure against.")
@click.option("--anew", is_flag=True, help="Detect contacts anew, even where those of a cleaning lie beside the clip.")
@click.option("--junit", type=click.Path(dir_okay=False, path_type=Path), help="Write the results as JUnit XML.")
@click.option("--format", "style", type=click.Choice(["text", "github"]), default="text", show_default=True,
              help="How results are told.")  # fmt: skip
@many
@shared
def check(
    src: tuple[str, ...], most: tuple[str, ...], labels: Path | None, anew: bool, junit: Path | None, style: str,
    many: Many, common: Common,
) -> int:  # fmt: skip
    """Measure clips and hold them against gates; change nothing.

    A clip that footfix cleaned is measured against the contacts that lie beside it, others are looked through.
    Exits with 1 where a clip is over a gate, given by --max or by `gates:` in the config.
    """
    from footfix import cli_runs

    return cli_runs.check(
        src, most=most, junit=junit, labels=labels, style=style, anew=anew, many=many, common=common
    )


@cli.command()
@click.argument("src", nargs=-1)
@click.option("--repair", is_flag=True, help="Write what a strict reader wants, and say what was changed.")
@click.option("-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder for repaired files.")
@click.option("--force", is_flag=True, help="Overwrite outputs that are there.")
@many
@shared
def inspect(
    src: tuple[str, ...], repair: bool, output: Path | None, force: bool, many: Many, common: Common
) -> int:
    """Say what is in a file: rig, units, floor, and everything odd about it."""
    from footfix import cli_runs

    if repair:
        return cli_runs.repair(src, output=output, force=force, many=many, common=common)
    return cli_runs.inspect(src, many=many, common=common)


@cli.command()
@click.argument("src", nargs=-1)
@shared
def settings(src: tuple[str, ...], common: Common) -> int:
    """Print the settings that hold, each with its origin, as YAML that --config takes."""
    from footfix import cli_common
    from footfix import settings as composed

    chosen = cli_common.config_near(src or (".",), common, {})
    path = Path(src[0]) if src else None
    if common.as_json:
        cli_common.print_json(composed.plain(chosen.settings(path)))
    else:
        click.echo(composed.as_yaml(chosen.stack(path)), nl=False)
    return 0


@cli.command()
@click.argument("reports", nargs=-1, required=True, metavar="CLIP.report.json...")
@click.option("--source", type=click.Path(exists=True, path_type=Path),
              help="The clip that was cleaned, or its folder, where it is not beside the report.")  # fmt: skip
@click.option("--png", is_flag=True, help="Draw a picture of the worst plants, too.")
@click.option("--no-html", is_flag=True, help="Draw the picture only.")
@click.option("-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder for what is drawn.")
@click.option("--force", is_flag=True, help="Draw over what is there.")
def report(
    reports: tuple[str, ...], source: Path | None, png: bool, no_html: bool, output: Path | None, force: bool
) -> int:
    """Draw the pages of cleaned clips anew, from their report files."""
    from footfix import cli_runs

    return cli_runs.report(
        reports, source=source, kind="none" if no_html else "html", png=png or no_html, output=output, force=force
    )

"""`footfix report`: redraw pages from report files, contacts and clips."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import click

from footfix.cli.stderr import say
from footfix.errors import ExitCode


@click.command()
@click.argument("reports", nargs=-1, required=True, metavar="CLIP.report.json...")
@click.option("--source", type=click.Path(exists=True, path_type=Path),
              help="The clip that was cleaned, or its folder, where it is not beside the report.")  # fmt: skip
@click.option("--png", is_flag=True, help="Draw a picture of the worst plants, too.")
@click.option("--no-html", is_flag=True, help="Draw the picture only.")
@click.option("-o", "--output", type=click.Path(file_okay=False, path_type=Path), help="Folder for what is drawn.")
@click.option("--force", is_flag=True, help="Overwrite existing pages and pictures.")
def report(
    reports: tuple[str, ...], source: Path | None, png: bool, no_html: bool, output: Path | None, force: bool
) -> int:
    """Draw the pages of cleaned clips anew, from their report files."""
    return run_report(
        reports, source=source, kind="none" if no_html else "html", png=png or no_html, output=output, force=force
    )


def run_report(
    named: tuple[str, ...], *, source: Path | None, kind: Literal["none", "html"], png: bool, output: Path | None,
    force: bool,
) -> int:  # fmt: skip
    """Run `footfix report`."""
    from footfix.batch.redraw import redraw_one
    from footfix.settings import ReportParams

    params = ReportParams(kind=kind, png=png)
    failed = False
    for name in named:
        result = redraw_one(Path(name), source, params, output, force=force)
        failed |= bool(result.error)
        say(f"footfix: {result.error}" if result.error else f"{name} -> {', '.join(result.written)}")
    return ExitCode.FAILED if failed else 0

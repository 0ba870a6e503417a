"""`footfix loop`: a seamless cycle out of each clip; inputs, outputs and exit codes are those of `clean`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from footfix.batch.one_file import loop_one
from footfix.cli.clean import run_clips
from footfix.cli.options import Common, Given, Many, Writing, given, many, shared, writing
from footfix.errors import UsageError


@click.command()
@click.argument("src", nargs=-1, type=click.Path(allow_dash=True))
@click.option("-o", "--output", type=click.Path(path_type=Path), metavar="PATH",
              help="Folder for the outputs; with one clip also the name of the loop's file, ending as it does.")
@click.option("--strides", type=click.IntRange(1), metavar="N", help="Strides of one round; by default as few as tell "
              "the style of the walk.")  # fmt: skip
@click.option("--start", type=click.IntRange(0), metavar="FRAME", help="The frame that becomes the first.")
@click.option("--end", type=click.IntRange(1), metavar="FRAME", help="The frame that becomes the last: its pose is "
              "that of the first, one round on.")  # fmt: skip
@click.option("--method", type=click.Choice(["offset", "kim-neff"]), help="How the gap at the seam is closed: it "
              "decays from both ends, or frames are blended as Kim and Neff do (loop.method).")  # fmt: skip
@click.option("--in-place", is_flag=True, help="Take travel and turn out: the figure walks on the spot.")
@click.option("--open", "open_", is_flag=True, help="Leave out the last frame, which repeats the first.")
@click.option("--straighten", is_flag=True, help="Take the mean turn of a round out: the figure walks straight on.")
@given("Contacts of the captured clips to use in place of detection")
@click.option("--report", type=click.Choice(["none", "json", "html"]), help="What is written beside the loop.")
@writing
@many
@shared
def loop(
    src: tuple[str, ...], output: Path | None, strides: int | None, start: int | None, end: int | None,
    method: str | None, in_place: bool, open_: bool, straighten: bool, given: Given, report: str | None,
    writing: Writing, many: Many, common: Common,
) -> int:  # fmt: skip
    """Cut a seamless cycle out of captured walks and runs.

    SRC is a BVH or glTF file, a folder, or - for standard input. walk.bvh becomes walk.loop.bvh beside it, or keeps
    its name in the folder of -o; -o NAME.bvh gives the loop of one clip a name of its own. Of a glTF file every
    animation that holds a cycle is cut. The loop is closed: its last frame is its first one, moved on by one round.
    """
    if start is not None and end is not None and start >= end:
        raise UsageError(f"--start {start} is not before --end {end}")
    values = {"strides": strides, "start": start, "end": end, "method": method}
    flags = {"in_place": in_place, "open": open_, "straighten": straighten}
    asked: dict[str, Any] = {key: value for key, value in values.items() if value is not None}
    asked |= {key: True for key, value in flags.items() if value}
    options: dict[str, Any] = {"loop": asked} if asked else {}
    if report:
        options["report"] = {"kind": report}
    return run_clips(
        src, output=output, in_place=False, options=options, given=given, writing=writing, many=many, common=common,
        work=loop_one, ending="loop",
    )  # fmt: skip

"""`footfix follow`: captured walks along a path, one handed over to the next."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import click

from footfix.cli.options import Common, shared
from footfix.errors import UsageError

_SPEED = re.compile(r"(\d+\.?\d*|\.\d+)\s*(x|m/s)?", re.IGNORECASE)


@click.command()
@click.argument("path", metavar="PATH")
@click.argument("clips", nargs=-1, required=True, metavar="CLIP[@AT]...")
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path, dir_okay=False), metavar="OUT.bvh",
              help="The file of the walk.")  # fmt: skip
@click.option("--speed", metavar="SPEED", help="Times as fast, as 1.1x, or metres a second, as 1.4; time and length of "
              "strides share it (follow.speed).")  # fmt: skip
@click.option("--seconds", type=click.FloatRange(min=0.0, min_open=True), metavar="S", help="How long; a closed path "
              "is walked round and round. By default as long as the path takes (follow.seconds).")  # fmt: skip
@click.option("--no-stride", is_flag=True, help="Strides stay as long as captured in curves (follow.stride).")
@click.option("--no-lean", is_flag=True, help="The figure stays upright in curves (follow.lean).")
@click.option("--report", type=click.Choice(["none", "json", "html"]), help="What is written beside the clip.")
@click.option("--dry-run", is_flag=True, help="Do everything but write.")
@click.option("--force", is_flag=True, help="Overwrite existing outputs.")
@shared
def follow(
    path: str, clips: tuple[str, ...], output: Path, speed: str | None, seconds: float | None, no_stride: bool,
    no_lean: bool, report: str | None, dry_run: bool, force: bool, common: Common,
) -> int:  # fmt: skip
    """Lead captured walks along a path, one style handed over to the next.

    PATH is a CSV file of points (columns x and z, in metres; or lon and lat), an SVG file or path, or a shape that
    begins where the walk does: line:10, circle:2 (to the left; circle:-2 to the right), sine:1x6.

    CLIP is a captured walk, which is looped and repeated. A further one takes over AT some seconds, or metres on the
    path: walk.bvh tired.bvh@3s jog.bvh@8m.
    """
    from footfix.batch.follow import named, run_follow
    from footfix.cli.closing_message import print_result
    from footfix.cli.running import config_near

    parts = [named(each) for each in clips]
    asked: dict[str, Any] = {} if seconds is None else {"seconds": seconds}
    asked |= _speed(speed) | ({"stride": False} if no_stride else {}) | ({"lean": False} if no_lean else {})
    options: dict[str, Any] = {"follow": asked} if asked else {}
    if report:
        options["report"] = {"kind": report}
    config = config_near([name for name, _ in parts], common, options)
    result = run_follow(path, parts, output, config.settings(Path(parts[0][0])), force=force, dry_run=dry_run)
    return print_result(result, common)


def _speed(text: str | None) -> dict[str, Any]:
    if text is None:
        return {}
    found = _SPEED.fullmatch(text.strip())
    if not found or not 0.0 < float(found[1]) < 100.0:
        raise UsageError(f"--speed {text!r} is no speed; 1.1x and 1.4 (metres a second) are")
    times = (found[2] or "").lower() == "x"
    return {"speed": float(found[1])} if times else {"speed_to": float(found[1])}

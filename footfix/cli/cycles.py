"""`footfix cycles`: fit a model to the walks and runs of a figure, and make locomotion of any speed from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from footfix.cli.options import Common, Many, many, shared
from footfix.errors import ExitCode, UsageError

if TYPE_CHECKING:
    from footfix.batch.task import FileResult
    from footfix.jobs.fit_cycles import Fitted


@click.group()
def cycles() -> None:
    """Learn how a figure walks and runs from its clips, and make locomotion of any speed from that."""


@cycles.command()
@click.argument("src", nargs=-1, type=click.Path(), metavar="FOLDER...")
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path, dir_okay=False), metavar="MODEL.npz",
              help="The file of the model.")  # fmt: skip
@click.option("--style", "styles", multiple=True, metavar="NAME=GLOB", help="Files that match have this style, such as "
              "tired='*tired*'. May be repeated. By default a file's style is the folder it lies in.")  # fmt: skip
@click.option("--components", type=click.IntRange(1, 200), metavar="N",
              help="The most principal components that a gait keeps; 20 by default.")  # fmt: skip
@click.option("--force", is_flag=True, help="Overwrite an existing model.")
@many
@shared
def fit(
    src: tuple[str, ...], output: Path, styles: tuple[str, ...], components: int | None, force: bool, many: Many,
    common: Common,
) -> int:  # fmt: skip
    """Fit a model to the straight walks and runs in clips of one skeleton.

    A gait needs 20 cycles, of two speeds at least; 100 over a range of speeds are better. Clips of other motion are
    skipped. The model holds the names of its files, but none of their motion.
    """
    from footfix.batch.cycles import check_output, fit_and_write, style_of
    from footfix.batch.journal import Journal
    from footfix.batch.multi_clip_files import spread
    from footfix.batch.one_file import sample_one
    from footfix.cli.running import code, config_for, found_inputs, print_json, reading, run_tasks, tasks_for
    from footfix.cli.stderr import say
    from footfix.jobs.fit_cycles import fit_entry
    from footfix.report.text import printable

    found = found_inputs(src, many)
    check_output(output, (".npz",), [each.path for each in found], force=force)
    globs = dict(_glob(each) for each in styles)
    tasks = tasks_for([reading(each) for each in found], found, config_for(src, many, common, {}))
    tasks = [replace(task, extra={"style": style_of(each, globs)}) for task, each in zip(tasks, found, strict=True)]

    def print_cycles(result: FileResult, say: Callable[[str], None]) -> None:
        for each in spread(result):
            if common.verbose and each.report:
                say(f"{printable(each.source)}: {printable(each.report['cycles'].summary)}")

    outcome = run_tasks(sample_one, tasks, many, common, "text", Journal(), print_cycles)
    if outcome.interrupted:
        return ExitCode.INTERRUPTED
    clips = [each for result in outcome.results for each in spread(result)]
    failed = [each.source for each in clips if each.status == "failed"]
    files = [each.report["cycles"] for each in clips if each.status != "failed"]
    fitted = fit_and_write(files, output, components=components)
    if common.as_json:
        print_json({"format": "footfix-cycles-fit", "version": 1, "model": str(output), **fit_entry(fitted),
                    "failed": failed})  # fmt: skip
    elif not common.quiet:
        say(_fitted(fitted, output, common.verbose))
    return code(outcome)


def _glob(text: str) -> tuple[str, str]:
    name, sign, glob = text.partition("=")
    if not sign or not name.strip() or not glob:
        raise UsageError(f"--style {text!r} is not NAME=GLOB, such as tired='*tired*'")
    return glob, name.strip()


def _fitted(fitted: Fitted, output: Path, verbose: bool) -> str:
    """Describe a fit in a few lines."""
    from footfix.report.text import printable

    model, error = fitted.model, fitted.error
    cycles = sum(each.cycles for each in model.spaces)
    lines = [f"{cycles} cycles of {len(model.origins)} files, {len(model.skeleton)} joints, "
             f"legs of {model.rig.leg_length:.2f} m"]  # fmt: skip
    for each in model.spaces:
        low, high = (speed * model.froude for speed in (each.ramp.low, each.ramp.high))
        lines.append(
            f"  {each.gait}: {each.cycles} cycles, {low:.2f} to {high:.2f} m/s; {len(each.components)} components hold "
            f"{100.0 * float(each.variance.sum()):.0f} % of the variance"
        )
    if model.styles:
        lines.append(f"  styles: {', '.join(map(printable, model.styles))}")
    if error.cycles:
        lines.append(
            f"  a file left out: {1000.0 * error.predicted:.1f} mm mean joint error (nearest real cycle "
            f"{1000.0 * error.nearest:.1f}, mean cycle {1000.0 * error.mean:.1f}), frequency "
            f"{100.0 * error.frequency:.1f} %"
        )
    shown = list(fitted.skipped.items())
    lines += [f"  {printable(name)}: {printable(why)}" for name, why in (shown if verbose else shown[:3])]
    if len(shown) > 3 and not verbose:
        lines.append(f"  and {len(shown) - 3} more; -v names all")
    return "\n".join([*lines, f"wrote {printable(str(output))}"])


@cycles.command()
@click.argument("model", type=click.Path(exists=True, dir_okay=False), metavar="MODEL.npz")
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path, dir_okay=False), metavar="OUT.bvh",
              help="The file of the motion.")  # fmt: skip
@click.option("--seconds", type=click.FloatRange(min=0.0, min_open=True, max=3600.0), metavar="S",
              help="How long; by default as long as the plan or the path, or 10.")  # fmt: skip
@click.option("--speed", type=click.FloatRange(0.0, 100.0), metavar="M/S", help="Metres a second.")
@click.option("--plan", type=click.Path(exists=True, dir_okay=False), metavar="PLAN.yaml",
              help="Speed, run, turn and style at some times; linear in between.")  # fmt: skip
@click.option("--run", "run_", type=click.FloatRange(0.0, 1.0), metavar="0..1",
              help="0 to walk, 1 to run, or between; by default what people do at that speed.")  # fmt: skip
@click.option("--turn", type=click.FloatRange(-720.0, 720.0), metavar="DEG/S", help="Degrees a second to the left.")
@click.option("--style", metavar="NAME", help="One of the model's styles.")
@click.option("--path", metavar="PATH", help="Go along a path: a CSV or SVG file, or line:10, circle:2, sine:1x6.")
@click.option("--fps", type=click.FloatRange(1.0, 1000.0), default=60.0, show_default=True, help="Frames a second.")
@click.option("--report", type=click.Choice(["none", "json", "html"]), help="What is written beside the clip.")
@click.option("--dry-run", is_flag=True, help="Do everything but write.")
@click.option("--force", is_flag=True, help="Overwrite existing outputs.")
@shared
def make(
    model: str, output: Path, seconds: float | None, speed: float | None, plan: str | None, run_: float | None,
    turn: float | None, style: str | None, path: str | None, fps: float, report: str | None, dry_run: bool,
    force: bool, common: Common,
) -> int:  # fmt: skip
    """Make locomotion from a model: BVH, contacts and report, as of `clean`."""
    from footfix.batch.cycles import load_plan, run_make
    from footfix.cli.closing_message import print_result
    from footfix.cli.running import config_near
    from footfix.formats.locomotion_plans import PlanRow

    single = {"--speed": speed, "--run": run_, "--turn": turn, "--style": style}
    given = [name for name, value in single.items() if value is not None]
    if plan is not None and given:
        raise UsageError(f"{given[0]} and --plan say the same; leave one out")
    if path is not None and turn is not None:
        raise UsageError("--path says where to turn; leave --turn out")
    if plan is not None:
        rows = load_plan(plan)
    else:
        rows = (PlanRow(0.0, speed, run_, turn, None if style is None else {style: 1.0}),)
    options: dict[str, Any] = {"report": {"kind": report}} if report else {}
    settings = config_near([model], common, options).settings(Path(model))
    result = run_make(
        model, rows, output, settings, seconds=seconds, fps=fps, path=path, force=force, dry_run=dry_run
    )  # fmt: skip
    return print_result(result, common)

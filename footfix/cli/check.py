"""`footfix check`: measures and gates; changes nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from footfix.batch.journal import Journal
from footfix.batch.multi_clip_files import spread
from footfix.batch.one_file import check_one
from footfix.cli.options import Common, Given, Many, given, many, shared
from footfix.cli.running import (
    code,
    config_for,
    found_inputs,
    print_json,
    reading,
    run_tasks,
    tasks_for,
    write_file,
)
from footfix.errors import ExitCode


@click.command()
@click.argument("src", nargs=-1, type=click.Path(allow_dash=True))
@click.option("--max", "most", multiple=True, metavar="NAME=VALUE",
              help="The most a measure may be, such as slide_mm=21. May be repeated.")  # fmt: skip
@given("Contacts to measure against")
@click.option("--anew", is_flag=True, help="Detect contacts anew, even where those of a cleaning lie beside the clip.")
@click.option("--junit", type=click.Path(dir_okay=False, path_type=Path), help="Write the results as JUnit XML.")
@click.option("--format", "style", type=click.Choice(["text", "csv", "json", "github"]), default="text",
              show_default=True, help="How results are shown: a table, a row a clip, one document, or annotations.")
@click.option("--list", "listed", is_flag=True, help="List every measure with unit and meaning; measure nothing.")
@many
@shared
def check(
    src: tuple[str, ...], most: tuple[str, ...], given: Given, anew: bool, junit: Path | None, style: str, listed: bool,
    many: Many, common: Common,
) -> int:  # fmt: skip
    """Measure clips and compare them with gates, which are upper bounds of measures; change nothing.

    A clip that footfix cleaned is measured on the contacts that lie beside it; in other clips contacts are detected.
    Exits with 1 where a clip is over a gate, given by --max or by `gates:` in the config. Where neither gives one,
    share_over_21mm, skating_ratio and penetration_mm have default gates, which --list shows with their reasons.
    Plants that cleaning let go are counted apart, as let_go; held_slide_mm and held_over_21mm are of the others.
    """
    from footfix.batch import gates
    from footfix.report import check_text

    if listed:
        defaults = {name: (gate.most, gate.why) for name, gate in gates.DEFAULTS.items()}
        click.echo(check_text.listing(gates.MEASURES, defaults), nl=False)
        return ExitCode.DONE
    if style == "json":
        common = replace(common, as_json=True)
    return run_check(src, most=most, junit=junit, given=given, style=style, anew=anew, many=many, common=common)


def run_check(
    src: tuple[str, ...], *, most: tuple[str, ...], junit: Path | None, given: Given, style: str, anew: bool,
    many: Many, common: Common,
) -> int:  # fmt: skip
    """Run `footfix check`."""
    from footfix.batch import gates
    from footfix.report import check_text

    limits = gates.parse(most)
    found = found_inputs(src, many, own_outputs=True)
    config = config_for(src, many, common, {})
    jobs = [reading(source) for source in found]
    tasks = [replace(task, extra={"gates": limits, "anew": anew}) for task in tasks_for(jobs, found, config, given)]
    for task in tasks:
        gates.known(task.settings.gates)
    outcome = run_tasks(check_one, tasks, many, common, style, Journal(), lambda result, say: None)
    clips = [each for result in outcome.results for each in spread(result)]
    rows = [check_text.row(each.source, each.status, each.report, each.error, each.seconds) for each in clips]
    if common.as_json:
        print_json(check_text.document(rows))
    elif style == "csv":
        click.echo(check_text.as_csv(rows), nl=False)
    elif style == "github":
        for line in check_text.workflow_commands(rows):
            click.echo(line)
    else:
        click.echo(check_text.text(rows, quiet=common.quiet, verbose=common.verbose), nl=False)
    if outcome.interrupted:
        return ExitCode.INTERRUPTED
    if junit is not None:
        write_file(junit, check_text.junit(rows))
    ended = code(outcome)
    return ExitCode.OVER_BUDGET if not ended and any(each.status == "over" for each in clips) else ended

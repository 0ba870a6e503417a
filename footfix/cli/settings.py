"""`footfix settings`: the effective settings, each with its origin."""

from __future__ import annotations

from pathlib import Path

import click

from footfix import config
from footfix import settings as composed
from footfix.cli.options import Common, shared
from footfix.cli.running import config_near, print_json


@click.command()
@click.argument("src", nargs=-1, type=click.Path(allow_dash=True))
@click.option("--presets", is_flag=True, help="List the presets instead: what each is for, what it changes and why.")
@shared
def settings(src: tuple[str, ...], presets: bool, common: Common) -> int:
    """Print the settings in effect, each with its origin, meaning and unit, as YAML that --config takes.

    With SRC, those in effect for this file, since footfix.yaml may give some files settings of their own.
    """
    if presets:
        return list_presets(common)
    chosen = config_near(src or (".",), common, {})
    path = Path(src[0]) if src else None
    if common.as_json:
        print_json(composed.plain(chosen.settings(path)))
    else:
        click.echo(config.as_yaml(chosen.stack(path)), nl=False)
    return 0


def list_presets(common: Common) -> int:
    """Run `footfix settings --presets`."""
    if common.as_json:
        print_json({
            name: {
                "for": config.preset_summary(name),
                "settings": {each.path: composed.plain(each.value) for each in config.preset_changes(name)},
            }
            for name in config.presets()
        })  # fmt: skip
    else:
        click.echo(config.describe_presets(), nl=False)
    return 0

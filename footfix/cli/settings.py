"""`footfix settings`: the settings that hold, each with its origin."""

from __future__ import annotations

from pathlib import Path

import click

from footfix import settings as composed
from footfix.cli.options import Common, shared
from footfix.cli.running import (
    config_near,
    print_json,
)


@click.command()
@click.argument("src", nargs=-1)
@shared
def settings(src: tuple[str, ...], common: Common) -> int:
    """Print the settings that hold, each with its origin, as YAML that --config takes."""
    chosen = config_near(src or (".",), common, {})
    path = Path(src[0]) if src else None
    if common.as_json:
        print_json(composed.plain(chosen.settings(path)))
    else:
        click.echo(composed.as_yaml(chosen.stack(path)), nl=False)
    return 0

"""Messages go to stderr; stdout is for results."""

import click


def say(text: str) -> None:
    """Print a message on stderr."""
    click.echo(text, err=True)

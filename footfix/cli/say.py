"""What is told to a person goes to stderr; stdout is for what was asked for."""

import click


def say(text: str) -> None:
    """Tell a person something."""
    click.echo(text, err=True)

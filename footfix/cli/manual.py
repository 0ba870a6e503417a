"""The manual page, from the help of the commands: `python -m footfix.cli.manual > footfix.1`."""

from __future__ import annotations

import click

from footfix.cli import COMMANDS, cli
from footfix.version import __version__

_ENDINGS = {
    "0": "done",
    "1": "check found a clip over a gate",
    "2": "wrong usage or settings; nothing was done",
    "3": "at least one input failed; the others are done",
    "4": "a bug in footfix",
    "130": "interrupted; what was finished is kept",
}


def page() -> str:
    """Write the page in the language of man(7): every command with its text and its options."""
    lines = [f'.TH FOOTFIX 1 "" "footfix {__version__}" "User Commands"', ".SH NAME",
             "footfix \\- take the foot skate out of motion\\-capture clips",
             ".SH SYNOPSIS", ".B footfix", ".I COMMAND", "[OPTIONS] [SRC...]", ".SH DESCRIPTION",
             *_paragraphs(cli.help or "")]  # fmt: skip
    top = click.Context(cli, info_name="footfix")
    for name in COMMANDS:
        command = cli.get_command(top, name)
        assert command is not None
        lines += [f".SH FOOTFIX {name.upper()}", *_paragraphs(command.help or ""), *_options(command, top)]
        for sub, inner in getattr(command, "commands", {}).items():
            heading = f".SS FOOTFIX {name.upper()} {sub.upper()}"
            lines += [heading, *_paragraphs(inner.help or ""), *_options(inner, top)]
    lines.append(".SH EXIT STATUS")
    for code, meaning in _ENDINGS.items():
        lines += [".TP", f".B {code}", _plain(meaning)]
    return "\n".join(lines) + "\n"


def _options(command: click.Command, top: click.Context) -> list[str]:
    lines: list[str] = []
    context = click.Context(command, info_name=command.name, parent=top)
    for option in command.get_params(context):
        record = option.get_help_record(context) if isinstance(option, click.Option) else None
        if record is not None:
            lines += [".TP", f".B {_plain(record[0])}", _plain(record[1])]
    return lines


def _paragraphs(text: str) -> list[str]:
    lines: list[str] = []
    for paragraph in text.strip().split("\n\n"):
        lines += [".PP", _plain(" ".join(paragraph.split()))]
    return lines


def _plain(text: str) -> str:
    """Escape text so that roff reads no part of it as a request."""
    shown = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + shown if shown.startswith((".", "'")) else shown


if __name__ == "__main__":
    click.echo(page(), nl=False)

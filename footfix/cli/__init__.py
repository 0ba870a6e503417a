"""The command line: one module a command. No mathematics, no file formats.

A command's module is imported when it is called, so that `footfix --help` answers at once.
"""

from __future__ import annotations

import difflib
import gc
import os
import shlex
import signal
import sys
from contextlib import suppress
from importlib import import_module

import click

from footfix.cli.stderr import say
from footfix.errors import ExitCode, FootfixError, UsageError
from footfix.formats.suffixes import is_motion
from footfix.version import __version__

# Each command is the function of its name in the module of its name.
COMMANDS = {
    "clean": "Take the foot skate out of clips.",
    "loop": "Cut a seamless cycle out of a captured walk or run.",
    "stream": "Take the foot skate out of a live figure, row by row, with a fixed look-ahead.",
    "follow": "Lead captured walks along a path, one style handed over to the next.",
    "cycles": "Learn how a figure walks and runs from its clips; make locomotion of any speed.",
    "detect": "Find contacts only, as labels.",
    "check": "Measure clips and compare them with gates; change nothing.",
    "inspect": "Say what is in a file: rig, units, floor, and everything odd about it.",
    "settings": "Print the settings in effect, each with origin, meaning and unit; list the presets.",
    "report": "Draw the pages of cleaned clips anew, from their report files.",
}


class Commands(click.Group):
    """The group of commands; each is imported when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = getattr(import_module(f"footfix.cli.{cmd_name}"), cmd_name)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command by its name; for a clip in its place, the error suggests `footfix clean`."""
        name = args[0] if args else ""
        if name and name not in COMMANDS and not name.startswith("-"):
            if is_motion(name) or os.path.lexists(name):
                ctx.fail(f"a command comes first: footfix clean {shlex.join(args)}")
            near = difflib.get_close_matches(name, COMMANDS, n=1)
            ctx.fail(f"there is no command {name!r}" + (f"; did you mean footfix {near[0]}?" if near else ""))
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


def main() -> None:
    """Run the command line and end the process: the entry point."""
    try:
        code = run()
        _ignore_interrupts()
    except KeyboardInterrupt:  # a further interrupt while ending
        _ignore_interrupts()
        code = ExitCode.INTERRUPTED
    # Python itself would end as killed, had it been at code from a string, as dataclasses are.
    if code == ExitCode.INTERRUPTED:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        os._exit(code)
    sys.exit(code)


def _ignore_interrupts() -> None:
    """Ignore interrupts: all is written, and during Python's shutdown one would only change the exit code."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def run() -> int:
    """Run the command line and return its exit code."""
    _open_streams()
    _escape_what_consoles_lack()
    # One thread a process: batches run as many processes, and sums come out the same to the last bit.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    try:
        code = cli.main(standalone_mode=False)
        sys.stdout.flush()
    except click.exceptions.Abort:
        return ExitCode.INTERRUPTED
    except click.ClickException as error:
        error.show()
        return UsageError.exit_code
    except FootfixError as error:
        say(f"footfix: {error}")
        return error.exit_code
    except KeyboardInterrupt:
        say("footfix: interrupted")
        return ExitCode.INTERRUPTED
    except (BrokenPipeError, SystemExit):  # what click makes of a pipe whose reader has gone
        # Otherwise Python reports the error again when it closes stdout.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        say(f"footfix: can't write what was asked for: {error.strerror or error}")
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FootfixError.exit_code
    except Exception as error:
        say(f"footfix: a bug in footfix, not in your file: {type(error).__name__}: {error}")
        if os.environ.get("FOOTFIX_DEBUG"):
            raise
        say("footfix: please report it; FOOTFIX_DEBUG=1 shows where it happened")
        return ExitCode.BUG
    finally:
        gc.freeze()  # saves Python a last garbage collection of 20 ms before it ends
    return code if isinstance(code, int) else 0


def _open_streams() -> None:
    """Open streams that the shell closed (`>&-`) to the null device, so that no other file gets their numbers."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            nowhere = os.open(os.devnull, os.O_RDWR)
            if nowhere != number:
                os.dup2(nowhere, number)
                os.close(nowhere)
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115


def _escape_what_consoles_lack() -> None:
    """Make output streams escape characters that the console can't encode, such as in file names, and never fail."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="footfix")
def cli() -> None:
    """Clean motion-capture clips: find footplants and take the foot skate out.

    footfix clean walk.bvh   writes walk.clean.bvh, contact labels and a report beside it.
    """

"""The one exception root of the package, and what each kind means to a caller and to a shell.

An error is written for a person: where (file, line, frames, joint), what is wrong, what to do next.
"""

from __future__ import annotations

from enum import IntEnum


class ExitCode(IntEnum):
    """What the end of a command means to a shell."""

    DONE = 0
    OVER_BUDGET = 1  # `check` found a clip over a gate
    USAGE = 2  # the command line or the settings make no sense; nothing has been done
    FAILED = 3  # at least one input failed; the others are done
    BUG = 4  # ours, not the file's
    INTERRUPTED = 130  # what was finished is kept


class FootfixError(Exception):
    """Root of all errors that footfix raises on purpose."""

    exit_code = ExitCode.FAILED


class UsageError(FootfixError):
    """The command line or the settings make no sense; nothing has been done."""

    exit_code = ExitCode.USAGE


class ArgumentError(UsageError, ValueError):
    """A value handed to a function of the Python interface can't be what is meant; the text says what is expected."""


class InputError(FootfixError):
    """An input can't be used: it is no motion file, is damaged, or holds nothing this tool can work on."""

    def __init__(
        self, what: str, *, file: str = "", line: int | None = None, column: int | None = None, hint: str = ""
    ) -> None:
        self.what, self.file, self.line, self.column, self.hint = what, file, line, column, hint
        super().__init__(what, file, line, column, hint)  # all of them, so that it survives pickling

    def __reduce__(self) -> tuple[object, ...]:
        return _rebuild, (type(self), self.what, self.file, self.line, self.column, self.hint)

    def __str__(self) -> str:
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part not in ("", None))
        return (f"{place}: " if place else "") + self.what + (f"; {self.hint}" if self.hint else "")

    def within(self, file: str) -> InputError:
        """Name the file that the error is about."""
        return type(self)(self.what, file=file, line=self.line, column=self.column, hint=self.hint)


class NoLegsError(InputError):
    """The skeleton has no legs that could be found, so there are no feet to plant."""


class OutputError(FootfixError):
    """A result could not be written; whatever stood in its place still does."""


def _rebuild(
    kind: type[InputError], what: str, file: str, line: int | None, column: int | None, hint: str
) -> InputError:
    return kind(what, file=file, line=line, column=column, hint=hint)

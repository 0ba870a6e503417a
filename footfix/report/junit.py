"""JUnit XML, which every CI server shows: one test case a clip."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

# XML 1.0 can't hold these characters, not even escaped; file names can.
_UNWRITABLE = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass(frozen=True)
class Case:
    """One clip as a test case.

    Args:
        name: the clip.
        failures: the measures over their gates, a line each; any makes it a failed case.
        error: why the clip could not be read or cleaned; any makes it a case with an error.
        output: further lines, such as notes.
        seconds: [s] it took.
    """

    name: str
    failures: tuple[str, ...] = ()
    error: str = ""
    output: tuple[str, ...] = ()
    seconds: float = 0.0


def junit(suite: str, cases: Sequence[Case]) -> bytes:
    """Write the cases as one test suite, each with its time; the suite's time is their sum."""
    counts = (
        f'tests="{len(cases)}" failures="{sum(bool(case.failures) for case in cases)}" '
        f'errors="{sum(bool(case.error) for case in cases)}"'
    )
    total = sum(case.seconds for case in cases)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<testsuites name="footfix" {counts}>',
        f'  <testsuite name={_quoted(suite)} {counts} skipped="0" time="{total:.3f}">',
    ]
    for case in cases:
        lines.append(f'    <testcase name={_quoted(case.name)} classname={_quoted(suite)} time="{case.seconds:.3f}">')
        if case.error:
            lines.append(f"      <error message={_quoted(case.error)}/>")
        if case.failures:
            message = "; ".join(case.failures)
            lines.append(f"      <failure message={_quoted(message)}>{_text(chr(10).join(case.failures))}</failure>")
        if case.output:
            lines.append(f"      <system-out>{_text(chr(10).join(case.output))}</system-out>")
        lines.append("    </testcase>")
    lines += ["  </testsuite>", "</testsuites>", ""]
    return "\n".join(lines).encode("utf-8")


def _clear(text: str) -> str:
    return _UNWRITABLE.sub("\N{REPLACEMENT CHARACTER}", text)


def _quoted(text: str) -> str:
    return quoteattr(_clear(text).replace("\n", " "))


def _text(text: str) -> str:
    return escape(_clear(text))

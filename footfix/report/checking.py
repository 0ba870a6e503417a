"""What `footfix check` found: text for people, a document for programs, JUnit and annotations for CI."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from footfix.report.annotations import annotation, of_note
from footfix.report.junit import Case
from footfix.report.junit import junit as junit_xml
from footfix.report.text import printable
from footfix.version import __version__

FORMAT, VERSION = "footfix-check", 1


@dataclass(frozen=True)
class Row:
    """One clip that was checked.

    Args:
        source: its path as it was named.
        status: "done", "over" or "failed".
        measures: of the clip as it is; None where there is nothing to measure.
        gates: the most that some of them may be.
        over: those that are more: {"measure", "value", "most"}.
        notes: what is odd about the file.
        error: why it could not be measured.
    """

    source: str
    status: str
    measures: Mapping[str, float | None] = field(default_factory=dict)
    gates: Mapping[str, float] = field(default_factory=dict)
    over: Sequence[Mapping[str, Any]] = ()
    notes: Sequence[Mapping[str, Any]] = ()
    error: str = ""


def row(source: str, status: str, report: Mapping[str, Any], error: str) -> Row:
    """A row from the result of a clip."""
    found = {key: report[key] for key in ("measures", "gates", "over", "notes") if key in report}
    return Row(source, status, error=error, **found)


def document(rows: Sequence[Row]) -> dict[str, Any]:
    """The check document, version 1."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "footfix": __version__,
        "passed": all(each.status == "done" for each in rows),
        "files": [
            {
                "source": each.source,
                "status": {"done": "passed"}.get(each.status, each.status),
                **({"error": each.error} if each.error else {}),
                "measures": dict(each.measures),
                "gates": dict(each.gates),
                "over": [dict(one) for one in each.over],
                "notes": [dict(one) for one in each.notes],
            }
            for each in rows
        ],
    }


def text(rows: Sequence[Row], *, quiet: bool, verbose: bool) -> str:
    """A line for each clip that is over or odd, for all of them where that is asked for; then the count."""
    lines = []
    for each in rows:
        if each.status == "over":
            lines.append(f"over    {printable(each.source)}: {'; '.join(_failures(each))}")
        elif each.status == "failed":
            lines.append(f"failed  {printable(each.source)}")
        elif verbose or (len(rows) == 1 and not quiet):
            lines.append(f"passed  {printable(each.source)}")
        if verbose:
            lines += [f"  {name} {'–' if value is None else f'{value:g}'}" for name, value in each.measures.items()]
        if not quiet:
            where = printable(each.source)
            lines += [f"{note['severity']:<7} {where}: {printable(str(note['text']))}" for note in _doubts(each)]
    if not quiet:
        passed = sum(each.status == "done" for each in rows)
        counts = [f"{passed} passed"]
        for status, word in (("over", "over budget"), ("failed", "failed")):
            count = sum(each.status == status for each in rows)
            counts += [f"{count} {word}"] if count else []
        lines.append(f"{len(rows)} {'clip' if len(rows) == 1 else 'clips'}: {', '.join(counts)}")
    return "".join(line + "\n" for line in lines)


def workflow_commands(rows: Sequence[Row]) -> Iterator[str]:
    """Workflow commands for gates and oddities; failures were told as they came."""
    for each in rows:
        for message in _failures(each):
            yield annotation("error", each.source, message, title="footfix check")
        for note in _doubts(each):
            yield of_note(each.source, note)


def junit(rows: Sequence[Row]) -> bytes:
    """The rows as a JUnit test suite."""
    cases = [
        Case(each.source, _failures(each), each.error, tuple(f"{n['severity']}: {n['text']}" for n in _doubts(each)))
        for each in rows
    ]
    return junit_xml("footfix check", cases)


def _failures(each: Row) -> tuple[str, ...]:
    return tuple(f"{one['measure']} is {one['value']:g}, at most {one['most']:g}" for one in each.over)


def _doubts(each: Row) -> list[Mapping[str, Any]]:
    return [note for note in each.notes if note.get("severity") != "note"]

"""What `footfix check` found: text for people, a document for programs, JUnit and annotations for CI."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from footfix.report.annotations import annotation, of_note
from footfix.report.junit import Case
from footfix.report.junit import junit as junit_xml
from footfix.report.text import printable
from footfix.settings import Meaning
from footfix.version import __version__

FORMAT, VERSION = "footfix-check", 1


@dataclass(frozen=True)
class Row:
    """One clip that was checked.

    Args:
        source: its path as given on the command line.
        status: "done", "over" or "failed".
        measures: of the clip as it is; None where there is nothing to measure.
        gates: upper bound of each measure that is gated.
        over: the measures over their bound: {"measure", "value", "most"}, and for slides {"why"}.
        notes: what is odd about the file.
        error: why it could not be measured.
        seconds: [s] it took to measure.
    """

    source: str
    status: str
    measures: Mapping[str, float | None] = field(default_factory=dict)
    gates: Mapping[str, float] = field(default_factory=dict)
    over: Sequence[Mapping[str, Any]] = ()
    notes: Sequence[Mapping[str, Any]] = ()
    error: str = ""
    seconds: float = 0.0


def row(source: str, status: str, report: Mapping[str, Any], error: str, seconds: float) -> Row:
    """Make a row of the result of a clip."""
    found = {key: report[key] for key in ("measures", "gates", "over", "notes") if key in report}
    return Row(source, status, error=error, seconds=seconds, **found)


def document(rows: Sequence[Row]) -> dict[str, Any]:
    """Make the check document, version 1."""
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
    """Write a table of the gated measures, which are over their gates and why, what is odd; then the counts.

    Args:
        rows: the clips.
        quiet: only clips that are over a gate.
        verbose: all measures of each clip.
    """
    lines = [] if quiet else _table(rows)
    for each in rows:
        where = printable(each.source)
        if each.status == "over":
            lines += [f"over    {where}: {printable(failure)}" for failure in _failures(each)]
        elif each.status == "failed" and quiet:
            lines.append(f"failed  {where}")
        if verbose and each.measures:
            lines.append(f"{where}:")
            lines += [f"  {name} {_shown(value)}" for name, value in each.measures.items()]
        if not quiet:
            lines += [f"{note['severity']:<7} {where}: {printable(str(note['text']))}" for note in _doubts(each)]
    if not quiet:
        passed = sum(each.status == "done" for each in rows)
        counts = [f"{passed} passed"]
        for status, word in (("over", "over budget"), ("failed", "failed")):
            count = sum(each.status == status for each in rows)
            counts += [f"{count} {word}"] if count else []
        lines.append(f"{len(rows)} {'clip' if len(rows) == 1 else 'clips'}: {', '.join(counts)}")
    return "".join(line + "\n" for line in lines)


def _table(rows: Sequence[Row]) -> list[str]:
    """Write a row a clip: its gated measures (* if over), its plants, and the plants that cleaning let go."""
    width = max((len(printable(each.source)) for each in rows), default=0)
    lines: list[str] = []
    shown: Mapping[str, float] = {}
    for each in rows:
        status = "passed" if each.status == "done" else each.status
        head = f"{status:<7} {printable(each.source):<{width}}"
        if not each.measures:
            lines.append(head)
            continue
        names = [*each.gates, "plants", "let_go"]
        if dict(each.gates) != shown:
            shown = dict(each.gates)
            bounds = [*(f"max {most:g}" for most in each.gates.values()), "", ""]
            lines.append(f"{'':<7} {'':<{width}}  " + "   ".join(names))
            below = (f"{bound:>{len(name)}}" for bound, name in zip(bounds, names, strict=True))
            lines.append((f"{'':<7} {'':<{width}}  " + "   ".join(below)).rstrip())
        beyond = {one["measure"] for one in each.over}
        cells = [f"{_shown(each.measures.get(n)):>{len(n)}}{' *' if n in beyond else '  '} " for n in names]
        lines.append(f"{head}  {''.join(cells)}".rstrip())
    return lines


def _shown(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"


def as_csv(rows: Sequence[Row]) -> str:
    """Write CSV, one row a clip: its status, every measure, and the names of those over their gates."""
    names = list(dict.fromkeys(name for each in rows for name in each.measures))
    out = io.StringIO(newline="")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["source", "status", *names, "over", "error"])
    for each in rows:
        figures = ["" if (value := each.measures.get(name)) is None else value for name in names]
        over = " ".join(str(one["measure"]) for one in each.over)
        writer.writerow([each.source, {"done": "passed"}.get(each.status, each.status), *figures, over, each.error])
    return out.getvalue()


def listing(meanings: Mapping[str, Meaning], gates: Mapping[str, tuple[float, str]]) -> str:
    """List every measure with its unit and meaning, then the default gates with their reasons.

    Args:
        meanings: of the measures, by name.
        gates: name -> (the most it may be, why).
    """
    width = max(map(len, meanings))
    units = max(len(each.unit) for each in meanings.values())
    lines = [f"{name:<{width}}  {each.unit:<{units}}  {each.text}" for name, each in meanings.items()]
    lines += ["", "Held against where no gate is given:"]
    lines += [f"  {name:<{width}}  at most {most:g}: {why}" for name, (most, why) in gates.items()]
    return "".join(line + "\n" for line in lines)


def workflow_commands(rows: Sequence[Row]) -> Iterator[str]:
    """Write GitHub annotations for gates and oddities; those for failures were written during the run."""
    for each in rows:
        for message in _failures(each):
            yield annotation("error", each.source, message, title="footfix check")
        for note in _doubts(each):
            yield of_note(each.source, note)


def junit(rows: Sequence[Row]) -> bytes:
    """Write the rows as a JUnit test suite."""
    cases = [
        Case(
            each.source, _failures(each), each.error,
            tuple(f"{note['severity']}: {note['text']}" for note in _doubts(each)), each.seconds,
        )
        for each in rows
    ]  # fmt: skip
    return junit_xml("footfix check", cases)


def _failures(each: Row) -> tuple[str, ...]:
    return tuple(
        f"{one['measure']} is {one['value']:.4g}, at most {one['most']:g}" + (f": {one['why']}" if "why" in one else "")
        for one in each.over
    )


def _doubts(each: Row) -> list[Mapping[str, Any]]:
    return [note for note in each.notes if note.get("severity") != "note"]

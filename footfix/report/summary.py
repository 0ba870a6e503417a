"""The summary of a run over many clips as data: `summary.json`, and what the index shows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from footfix.report.document import rounded
from footfix.report.verdict import Report, judge, number
from footfix.version import __version__

FORMAT, VERSION = "footfix-summary", 1


@dataclass(frozen=True)
class Entry:
    """One clip of a run.

    Args:
        source: its path below the folder that was named, with forward slashes.
        status: "cleaned", "unchanged" or "failed".
        error: why it failed.
        line: of the file, where the error is about one.
        report: its report document, or a digest of it.
        outputs: what was written for it: kind ("bvh", "contacts", "report", "page") -> path relative to the
            summary, with forward slashes.
    """

    source: str
    status: str
    error: str = ""
    line: int | None = None
    report: Report = field(default_factory=dict)
    outputs: Mapping[str, str] = field(default_factory=dict)


def summarize_run(entries: Sequence[Entry]) -> dict[str, Any]:
    """Make the summary document, version 1: totals, then every clip in the order of the run.

    It says nothing of the machine, the hour or how long it took: the same run makes the same bytes.
    """
    counts = Counter(entry.status for entry in entries)
    verdicts = [judge(entry.report) for entry in entries if entry.report]
    return {
        "format": FORMAT,
        "version": VERSION,
        "footfix": __version__,
        "clips": {"total": len(entries), **{key: counts[key] for key in ("cleaned", "unchanged", "failed")}},
        "plants": {
            "total": sum(verdict.plants for verdict in verdicts),
            "over_21mm_before": sum(verdict.over_before for verdict in verdicts),
            "over_21mm_after": sum(verdict.over_after for verdict in verdicts),
        },
        "worst": {
            "slide_before_mm": rounded(max((verdict.worst_before for verdict in verdicts), default=0.0)),
            "slide_after_mm": rounded(max((verdict.worst_after for verdict in verdicts), default=0.0)),
        },
        "files": [_file(entry) for entry in entries],
    }


def _file(entry: Entry) -> dict[str, Any]:
    plain: dict[str, Any] = {"source": entry.source, "status": entry.status}
    if entry.error:
        plain["error"] = entry.error
        if entry.line is not None:
            plain["line"] = entry.line
        return plain
    plain["outputs"] = dict(entry.outputs)
    verdict = judge(entry.report)
    plain["verdict"] = {"tone": verdict.tone, "word": verdict.word, "text": verdict.text}
    plain["plants"] = {
        "total": verdict.plants,
        "over_21mm_before": verdict.over_before,
        "over_21mm_after": verdict.over_after,
        "worst": _worst(entry.report.get("plants") or ()),
    }
    plain["before"] = dict(entry.report.get("before") or {})
    plain["after"] = dict(entry.report.get("after") or {})
    plain["notes"] = [
        {key: note[key] for key in ("id", "severity", "text", "line") if key in note}
        for note in entry.report.get("notes") or ()
        if note.get("severity") != "note"
    ]
    return plain


def _worst(plants: Sequence[Report]) -> dict[str, Any] | None:
    """Find the plant that slides most after cleaning."""
    worst = max(plants, key=lambda plant: number(plant.get("slide_after_mm")) or 0.0, default=None)
    if worst is None:
        return None
    return {key: worst.get(key) for key in ("effector", "start", "end", "slide_before_mm", "slide_after_mm", "outcome")}


def table(entries: Sequence[Entry], *, most: int = 10) -> str:
    """Write the closing table for a terminal: counts of the run, and the clips to look at first."""
    counts = Counter(entry.status for entry in entries)
    said = ", ".join(f"{counts[key]} {key}" for key in ("cleaned", "unchanged", "failed") if counts[key])
    lines = [f"{len(entries)} {'clip' if len(entries) == 1 else 'clips'}: {said}"]
    judged = [(entry, verdict) for entry in entries if entry.report and (verdict := judge(entry.report)).plants]
    judged.sort(key=lambda pair: (-pair[1].worst_after, -pair[1].worst_before, pair[0].source))
    if judged:
        lines.append("  longest slide   plants over 21 mm")
        for entry, verdict in judged[:most]:
            slide = f"{verdict.worst_before:5.0f} -> {verdict.worst_after:3.0f} mm"
            lines.append(f"  {slide}   {verdict.over_before:4d} -> {verdict.over_after:<3d} of {verdict.plants:<5d}"
                         f"{entry.source}")  # fmt: skip
        if len(judged) > most:
            lines.append(f"  and {len(judged) - most} that slide less")
    return "\n".join(lines)

"""The verdict on a clip for a terminal: a few lines of plain text."""

from __future__ import annotations

import re
from collections.abc import Sequence

from footfix.measure.plants import NOTICED_MM
from footfix.report.follow_text import follow_lines
from footfix.report.loop_text import loop_lines
from footfix.report.verdict import (
    Report,
    Row,
    entries,
    floor_taken,
    judge,
    largest_change,
    measure_rows,
    number,
    section,
    source_name,
)

_SEVERITIES = ("error", "warning")
_FATES = {"released": "let go", "partly": "held only in part", "kept": "left alone", "pinned": "pinned"}
_PLAIN_UNITS = {"10² m/s³": "x 100 m/s^3", "°": "deg", "°/s": "deg/s", "m/s²": "m/s^2"}  # for terminals without Unicode
_FIGURE = re.compile(r"\d+(?:\.\d+)?")
_FRAMES = re.compile(r"at frame (\d+-\d+)")


def summarize(report: Report, *, verbose: bool = False) -> str:
    """Describe one clip in a few lines, ending without a newline.

    Args:
        report: the report document.
        verbose: all measures and all notes, not only those that ask for a look.

    Returns:
        The name and the verdict, the numbers behind it, what was let go and why, and the notes.
    """
    verdict = judge(report)
    lines = [f"{printable(source_name(report))}: {verdict.text}"]
    lines += [f"  {line}" for line in (*loop_lines(report), *follow_lines(report))]
    rows = [row for row in measure_rows(report) if row.headline or verbose]
    if max(verdict.worst_before, verdict.worst_after) >= 0.5:
        lines.append(f"  longest slide {verdict.worst_before:.0f} -> {verdict.worst_after:.0f} mm{_travel(report)}")
    if verbose:
        width = max((len(row.label) for row in rows), default=0)
        lines += [f"  {row.label:<{width}}  {row.before:>8} -> {row.after:>8} {_unit(row)}" for row in rows]
    elif rows:
        figures = (f"{row.headline.lower()} {row.before} -> {row.after} {_unit(row)}" for row in rows)
        lines.append("  " + ", ".join(figures))
    change = largest_change(report)
    if change:
        turn = f"{printable(change.joint)} {change.degrees:.0f} degrees"
        lines.append(f"  largest joint change: {turn}, frame {change.frame}")
    drift = number(section(report, "correction").get("root_path_drift_m"))
    if drift is not None and drift >= 0.0005:
        lines.append(f"  path of the root drifts by {100.0 * drift:.1f} cm")
    floor = floor_taken(report)
    if floor:
        lines.append(f"  floor at {printable(floor)}")
    lines += [f"  {line}" for line in released(report)]
    for note in entries(report, "notes"):
        severity = str(note.get("severity", "note"))
        if verbose or severity in _SEVERITIES:
            lines.append(f"  {severity}: {printable(str(note.get('text', '')))}")
    return "\n".join(lines)


def released(report: Report) -> list[str]:
    """Count by reason the plants that were let go, wholly or in part, or kept though they slide; a line for each.

    Reasons that differ only in their numbers are one line, with the range of the numbers.
    """
    groups: dict[tuple[str, str], list[str]] = {}
    for plant in entries(report, "plants"):
        outcome, reason = str(plant.get("outcome")), str(plant.get("reason") or "")
        noticed = (number(plant.get("slide_after_mm")) or 0.0) > NOTICED_MM
        if outcome in _FATES and (noticed or outcome in ("released", "partly")):
            groups.setdefault((outcome, _FIGURE.sub("#", reason)), []).append(reason)
    lines = []
    for (outcome, _), reasons in sorted(groups.items(), key=lambda group: -len(group[1])):
        count = len(reasons)
        line = f"{count} {'plant' if count == 1 else 'plants'} {_FATES[outcome]}"
        lines.append(line + (f": {printable(_ranged(reasons))}" if reasons[0] else ""))
    return lines


def _ranged(reasons: Sequence[str]) -> str:
    """Join sentences that differ only in their numbers into one, with the range of each number."""
    columns = [sorted(set(column), key=float) for column in zip(*map(_FIGURE.findall, reasons), strict=True)]
    ranges = iter(column[0] if len(column) == 1 else f"{column[0]}-{column[-1]}" for column in columns)
    return _FRAMES.sub(r"at frames \1", _FIGURE.sub(lambda _: next(ranges), reasons[0]))


def _unit(row: Row) -> str:
    return _PLAIN_UNITS.get(row.unit, row.unit)


def printable(text: str) -> str:
    """Strip control characters from text of unknown origin, so that it can't control a terminal."""
    return "".join(char if char.isprintable() else "\N{REPLACEMENT CHARACTER}" for char in text)


def _travel(report: Report) -> str:
    """Describe the plants' travel from first to last frame, which a drift makes longer than the slides."""
    far = [
        max((number(plant.get(f"travel_{when}_mm")) or 0.0 for plant in entries(report, "plants")), default=0.0)
        for when in ("before", "after")
    ]
    return f", longest travel first to last {far[0]:.0f} -> {far[1]:.0f} mm" if any(far) else ""

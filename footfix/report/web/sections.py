"""The parts of the page that are plain HTML: they stand there without any script."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from footfix.measure.plants import NOTICED_MM
from footfix.report.loops import loop_lines
from footfix.report.text import released
from footfix.report.verdict import (
    Report,
    Tone,
    Verdict,
    entries,
    floor_taken,
    largest_change,
    measure_rows,
    number,
    section,
    worst_first,
)
from footfix.report.web.markup import name, text
from footfix.report.web.motion import side_of

MOST_PLANTS = 1000  # rows of the table; a clip of an hour has tens of thousands

# The badges differ by shape and word, not by colour alone.
_MARKS: Mapping[Tone, str] = {
    "good": '<path d="M3 8.5l3.2 3.2L13 5"/>',
    "fair": '<path d="M8 3v6M8 12.2v.3"/>',
    "bad": '<path d="M4 4l8 8M12 4l-8 8"/>',
    "quiet": '<path d="M4 8h8"/>',
}


def badge(tone: Tone, word: str) -> str:
    """A mark and a word: how a clip came out."""
    return (
        f'<span class="badge {tone}"><svg viewBox="0 0 16 16" aria-hidden="true">{_MARKS[tone]}</svg>'
        f"{text(word)}</span>"
    )


def tiles(report: Report, verdict: Verdict) -> str:
    """The numbers of the first screen."""
    parts = []
    if verdict.plants:
        parts.append(tile("Footplants", "", str(verdict.plants)))
        parts.append(tile(f"Slide over {NOTICED_MM:g} mm", "", str(verdict.over_before), str(verdict.over_after)))
        parts.append(tile("Longest slide", "mm", f"{verdict.worst_before:.0f}", f"{verdict.worst_after:.0f}"))
    parts += [
        tile(row.headline, row.unit, row.before, row.after, row.worse) for row in measure_rows(report) if row.headline
    ]
    change = largest_change(report)
    if change:
        where = f"{name(change.joint)}, frame {change.frame}"
        figure = f'<b>{change.degrees:.0f}</b> <small class="where">{where}</small>'
        parts.append(f"<div><dt>Largest joint change <small>°</small></dt><dd>{figure}</dd></div>")
    drift = number(section(report, "correction").get("root_path_drift_m"))
    if drift is not None:
        parts.append(tile("Drift of the path", "cm", f"{100.0 * drift:.1f}"))
    return "".join(parts)


def tile(label: str, unit: str, before: str, after: str = "", worse: bool = False) -> str:
    """One number, or one before and one after; a triangle where it got worse."""
    figure = f"<b>{text(before)}</b>"
    if after:
        figure = (
            f'<span class="was">{text(before)}</span><span class="to" aria-hidden="true">→</span>'
            f'<span class="unseen"> before, </span><b>{text(after)}</b><span class="unseen"> after</span>'
        )
    if worse:
        figure += '<span class="worse" title="more than before">▲<span class="unseen"> more than before</span></span>'
    return f"<div><dt>{text(label)}{f' <small>{text(unit)}</small>' if unit else ''}</dt><dd>{figure}</dd></div>"


_FATES = (
    ("pinned", "pinned to their places"),
    ("kept", "kept as they were, still enough"),
    ("partly", "held in part"),
    ("released", "let go"),
)


def fate(report: Report) -> str:
    """What became of the plants, in a line."""
    counts = Counter(str(plant.get("outcome")) for plant in entries(report, "plants"))
    return ", ".join(f"{counts[key]} {words}" for key, words in _FATES if counts[key])


def loop_list(report: Report) -> str:
    """A loop in words."""
    return "".join(f"<li>{text(line)}</li>" for line in loop_lines(report))


def released_list(report: Report) -> str:
    """What was let go, and why."""
    return "".join(f"<li>{text(line)}</li>" for line in released(report))


def measures_table(report: Report) -> str:
    """The measures before and after, as table rows."""
    return "\n".join(
        f'<tr><th scope="row">{text(row.label)}</th><td>{row.before}</td>'
        f"<td>{'▲ ' if row.worse else ''}{row.after}</td>"
        f"<td>{text(row.unit)}</td></tr>"
        for row in measure_rows(report)
    )


def plants_table(plants: Sequence[Report]) -> str:
    """The plants, as table rows, the worst first."""
    longest = max((number(plant.get("slide_before_mm")) or 0.0 for plant in plants), default=0.0)
    return "\n".join(_plant_row(plant, max(longest, NOTICED_MM)) for plant in worst_first(plants)[:MOST_PLANTS])


def _plant_row(plant: Report, longest: float) -> str:
    effector = str(plant.get("effector", ""))
    start, end = (int(number(plant.get(key)) or 0) for key in ("start", "end"))
    before, after = (number(plant.get(f"slide_{when}_mm")) for when in ("before", "after"))
    outcome, reason = str(plant.get("outcome") or ""), str(plant.get("reason") or "")
    side = side_of(effector) or "left"
    return (
        f'<tr data-effector="{text(effector)}" data-start="{start}" data-end="{end}">'
        f'<th scope="row" class="{side}"><button type="button">{name(effector.replace("_", " "))}</button></th>'
        f'<td data-value="{start}">{start}–{end}</td>'
        f"<td>{_figure(before)}</td><td>{_figure(after)}</td>"
        f'<td data-value="{after or 0.0:.3f}">{bars(before, after, longest)}</td>'
        f'<td class="word">{text(outcome)}</td>'
        f"<td>{_figure(number(plant.get('penetration_after_mm')))}</td>"
        f"<td>{_figure(number(plant.get('residual_mm')))}</td>"
        f"<td>{text(reason)}</td></tr>"
    )


def _figure(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}"


def bars(before: float | None, after: float | None, longest: float) -> str:
    """The slides as two bars, with the mark of what viewers notice."""
    wide = [44.0 * min((value or 0.0) / longest, 1.0) for value in (before, after)]
    mark = 44.0 * NOTICED_MM / longest
    return (
        f'<svg class="bars" viewBox="0 0 44 12" aria-hidden="true"><rect class="was" y="1" width="{wide[0]:.1f}" '
        f'height="4"/><rect class="now" y="7" width="{wide[1]:.1f}" height="4"/><path d="M{mark:.1f} 0V12"/></svg>'
    )


def plants_caption(plants: Sequence[Report]) -> str:
    """Says so where the table does not hold every plant."""
    if len(plants) <= MOST_PLANTS:
        return "How far each plant slides, the worst first. Click one to see it in a loop; the ring is 21 mm."
    return f"The worst {MOST_PLANTS} of {len(plants)} plants, by how far they slide. Click one to see it in a loop."


def notes_list(notes: Sequence[Report]) -> str:
    """The notes, as list items, the pressing ones first."""
    order = {"error": 0, "warning": 1}
    items = []
    for note in sorted(notes, key=lambda note: order.get(str(note.get("severity")), 2)):
        severity = str(note.get("severity") or "note")
        where = _where(note)
        items.append(
            f'<li class="{severity if severity in order else "note"}"><b>{text(severity)}</b> '
            f"{text(note.get('text', ''))}{f' <small>{where}</small>' if where else ''}</li>"
        )
    return "\n".join(items)


def _where(note: Report) -> str:
    parts = []
    if note.get("start") is not None:
        parts.append(f"frames {text(note['start'])}–{text(note.get('end', ''))}")
    if note.get("line") is not None:
        parts.append(f"line {text(note['line'])}")
    joints = note.get("joints")
    if joints and isinstance(joints, list | tuple):
        parts.append("joints " + ", ".join(name(joint) for joint in joints))
    return "; ".join(parts)


def details_table(report: Report) -> str:
    """How it was done: rig, settings and times, as rows of dotted keys and values."""
    floor = floor_taken(report)
    rows = [f'<tr><th scope="row">floor</th><td>{text(floor)}</td></tr>'] if floor else []
    for part in ("method", "output", "rig", "correction", "settings", "seconds"):
        for key, value in _leaves(part, report.get(part)):
            rows.append(f'<tr><th scope="row">{text(key)}</th><td>{text(value)}</td></tr>')
    return "\n".join(rows)


def _leaves(key: str, value: Any) -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping):
        for inner, item in value.items():
            yield from _leaves(f"{key}.{inner}", item)
    elif isinstance(value, float):
        yield key, f"{value:.6g}"
    elif value is not None:
        yield key, ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)

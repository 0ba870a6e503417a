"""The parts of the page that are plain HTML and need no script."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from footfix.measure.plants import NOTICED_MM
from footfix.report import words
from footfix.report.follow_text import follow_lines
from footfix.report.loop_text import loop_lines
from footfix.report.text import released
from footfix.report.verdict import (
    Report,
    Tone,
    Verdict,
    entries,
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


def badge(tone: Tone, word: str, told: str = "") -> str:
    """Write the badge of a clip: a mark and the word of its verdict, with the sentence as a tooltip."""
    title = f' title="{text(told)}"' if told else ""
    return (
        f'<span class="badge {tone}"{title}><svg viewBox="0 0 16 16" aria-hidden="true">{_MARKS[tone]}</svg>'
        f"{text(word)}</span>"
    )


def tiles(report: Report, verdict: Verdict) -> str:
    """Write the numbers of the first screen: slides, changes and costs, but none that are zero before and after."""
    parts = []
    if verdict.plants:
        parts.append(tile("Footplants", "", str(verdict.plants), meaning=words.PLANT))
        over = str(verdict.over_before), str(verdict.over_after)
        parts.append(tile(f"Slide over {NOTICED_MM:g} mm", "", *over, meaning=words.MEASURES["share_over_21mm"]))
        longest = f"{verdict.worst_before:.0f}", f"{verdict.worst_after:.0f}"
        parts.append(tile("Longest slide", "mm", *longest, meaning=words.MEASURES["slide_mm"]))
    change = largest_change(report)
    if change:
        parts.append(placed_tile("Largest joint change", "°", f"{change.degrees:.0f}",
                                 f"{name(change.joint)}, {_at(change.frame)}", words.CHANGE))  # fmt: skip
    if verdict.worse:
        parts.append(tile("Plants that got worse", "", str(verdict.worse), meaning=words.WORSE))
    parts += [
        tile(row.headline, row.unit, row.before, row.after, row.worse, words.MEASURES.get(row.key, ""))
        for row in measure_rows(report)
        if row.headline
    ]
    drift = number(section(report, "correction").get("root_path_drift_m"))
    if drift is not None and drift >= 0.0005:
        parts.append(tile("Drift of the path", "cm", f"{100.0 * drift:.1f}", meaning=words.DRIFT))
    return "".join(parts)


def tile(label: str, unit: str, before: str, after: str = "", worse: bool = False, meaning: str = "") -> str:
    """Write one number, or one before and one after, with a triangle if it got worse; nothing if both are zero."""
    if after and _is_zero(before) and _is_zero(after):
        return ""
    figure = f"<b>{text(before)}</b>"
    if after == before:
        figure += ' <small>as before</small>'
    elif after:
        figure = (
            f'<span class="was">{text(before)}</span><span class="to" aria-hidden="true">→</span>'
            f'<span class="unseen"> before, </span><b>{text(after)}</b><span class="unseen"> after</span>'
        )
    if worse:
        figure += '<span class="worse" title="more than before">▲<span class="unseen"> more than before</span></span>'
    return f"{_label(label, unit, meaning)}<dd>{figure}</dd></div>"


def placed_tile(label: str, unit: str, figure: str, where: str, meaning: str) -> str:
    """Write one number and the place where it occurs; `where` is HTML."""
    return f'{_label(label, unit, meaning)}<dd><b>{text(figure)}</b> <small class="where">{where}</small></dd></div>'


def _at(frame: int) -> str:
    """Write a frame number as a link that shows the frame."""
    return f'<a href="#f={max(frame, 0)}">frame {frame}</a>'


def _label(label: str, unit: str, meaning: str) -> str:
    told = f' title="{text(meaning)}"' if meaning else ""
    return f"<div{told}><dt>{text(label)}{f' <small>{text(unit)}</small>' if unit else ''}</dt>"


def _is_zero(figure: str) -> bool:
    return not figure.strip("0.–")


_FATES = (
    ("pinned", "pinned to their places"),
    ("kept", "left alone"),
    ("partly", "held in part"),
    ("released", "let go"),
)


def outcomes(report: Report) -> str:
    """Count the plants by outcome, in a line."""
    counts = Counter(str(plant.get("outcome")) for plant in entries(report, "plants"))
    return ", ".join(f"{counts[key]} {words}" for key, words in _FATES if counts[key])


def loop_list(report: Report) -> str:
    """Describe a loop or a walk along a path in words."""
    return "".join(f"<li>{text(line)}</li>" for line in (*loop_lines(report), *follow_lines(report)))


def released_list(report: Report) -> str:
    """List why plants were let go: the commonest reasons; the table of plants has all of them."""
    return "".join(f"<li>{text(line)}</li>" for line in shortened(released(report), 3))


def shortened(lines: Sequence[str], most: int) -> list[str]:
    """Keep the first lines, and say how many more there are."""
    rest = len(lines) - most
    return [*lines[:most], *([f"and {rest} more {'reason' if rest == 1 else 'reasons'}"] if rest > 0 else [])]


def measures_table(report: Report) -> str:
    """Write the measures before and after, as table rows."""
    return "\n".join(
        f'<tr><th scope="row">{text(row.label)}</th><td>{row.before}</td>'
        f"<td>{'▲ ' if row.worse else ''}{row.after}</td>"
        f'<td class="unit">{text(row.unit)}</td><td class="word">{text(words.MEASURES.get(row.key, ""))}</td></tr>'
        for row in measure_rows(report)
    )


def plants_table(plants: Sequence[Report]) -> str:
    """Write the plants as table rows, the worst first."""
    longest = max((number(plant.get("slide_before_mm")) or 0.0 for plant in plants), default=0.0)
    return "\n".join(_plant_row(plant, max(longest, NOTICED_MM)) for plant in worst_first(plants)[:MOST_PLANTS])


def _plant_row(plant: Report, longest: float) -> str:
    effector = str(plant.get("effector", ""))
    start, end = (int(number(plant.get(key)) or 0) for key in ("start", "end"))
    before, after = (number(plant.get(f"slide_{when}_mm")) for when in ("before", "after"))
    outcome, reason = str(plant.get("outcome") or ""), str(plant.get("reason") or "")
    side = side_of(effector) or "left"
    meaning = words.OUTCOMES[outcome][1] if outcome in words.OUTCOMES else ""
    return (
        f'<tr data-effector="{text(effector)}" data-start="{start}" data-end="{end}">'
        f'<th scope="row" class="{side}"><button type="button">{name(effector.replace("_", " "))}</button></th>'
        f'<td data-value="{start}">{start}–{end}</td>'
        f"<td{_travel(plant, 'before')}>{_figure(before)}</td><td{_travel(plant, 'after')}>{_figure(after)}</td>"
        f'<td class="slide" data-value="{after or 0.0:.3f}">{bars(before, after, longest)}</td>'
        f'<td class="target">{_figure(number(plant.get("residual_mm")))}</td>'
        f'<td class="floor">{_figure(number(plant.get("penetration_after_mm")))}</td>'
        f'<td class="word became" title="{text(meaning)}">{text(words.outcome(outcome))}'
        f"{f'<small>{text(reason)}</small>' if reason else ''}</td></tr>"
    )


def _travel(plant: Report, when: str) -> str:
    """Write the tooltip of a slide: the travel from the first frame to the last."""
    far = number(plant.get(f"travel_{when}_mm"))
    return "" if far is None else f' title="{far:.1f} mm from its first frame to its last"'


def _figure(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}"


def bars(before: float | None, after: float | None, longest: float) -> str:
    """Draw the slides as two bars, with a mark at 21 mm, which viewers notice."""
    wide = [44.0 * min((value or 0.0) / longest, 1.0) for value in (before, after)]
    mark = 44.0 * NOTICED_MM / longest
    return (
        f'<svg class="bars" viewBox="0 0 44 12" aria-hidden="true"><rect class="was" y="1" width="{wide[0]:.1f}" '
        f'height="4"/><rect class="now" y="7" width="{wide[1]:.1f}" height="4"/><path d="M{mark:.1f} 0V12"/></svg>'
    )


def plants_caption(plants: Sequence[Report]) -> str:
    """Write the caption of the table of plants, which says so if it does not list all of them."""
    if len(plants) <= MOST_PLANTS:
        return "How far each plant slides, the worst first. Click one to see it in a loop; the ring is 21 mm."
    return f"The worst {MOST_PLANTS} of {len(plants)} plants, by how far they slide. Click one to see it in a loop."


def notes_list(notes: Sequence[Report]) -> str:
    """Write the notes as list items: errors first, then warnings."""
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
        start, span = number(note["start"]), f"{text(note['start'])}–{text(note.get('end', ''))}"
        parts.append(f"frames {span}" if start is None else f'<a href="#f={max(int(start), 0)}">frames {span}</a>')
    if note.get("line") is not None:
        parts.append(f"line {text(note['line'])}")
    joints = note.get("joints")
    if joints and isinstance(joints, list | tuple):
        parts.append("joints " + ", ".join(name(joint) for joint in joints))
    return "; ".join(parts)

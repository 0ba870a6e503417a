"""The report of a clip as one HTML file that opens anywhere and loads nothing."""

from __future__ import annotations

import base64
import hashlib
import pkgutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from string import Template
from typing import Any

from footfix.report.chart import chart
from footfix.report.markup import name, text
from footfix.report.motion import Motion
from footfix.report.verdict import Report, judge, measure_rows, source_name


@dataclass(frozen=True, eq=False)
class PageData:
    """All that a page shows.

    Args:
        report: the report document (the contract's report file).
        contacts: the contacts document (the contract's contacts file); what the page hands back after
            editing is this document with other contacts.
        motion: the figure before and after; None where there is none to show (a clip that failed).
        thresholds: lines to draw into the curves, by name: `height_m`, `speed_m_s`.
    """

    report: Report
    contacts: Mapping[str, Any] = field(default_factory=dict)
    motion: Motion | None = None
    thresholds: Mapping[str, float] = field(default_factory=dict)


@cache
def asset(file: str) -> str:
    """A template, style sheet or script that lies beside this module."""
    data = pkgutil.get_data("footfix.report", file)
    assert data is not None
    return data.decode("utf-8").replace("\r\n", "\n")


@cache
def fingerprint(source: str) -> str:
    """The hash by which a content security policy lets a script or style sheet in."""
    return "sha256-" + base64.b64encode(hashlib.sha256(source.encode()).digest()).decode("ascii")


def render(data: PageData) -> str:
    """The page, as one HTML document."""
    report = data.report
    verdict = judge(report)
    style = asset("report.css")
    return Template(asset("page.html")).substitute(
        style=style,
        style_hash=fingerprint(style),
        title=text(source_name(report)),
        name=name(source_name(report)),
        tone=verdict.tone,
        word=text(verdict.word),
        verdict=text(verdict.text),
        method=text(report.get("method") or "–"),
        measures=measures_table(report),
        picture=chart(data.motion, data.contacts) if data.motion else "",
        plants=plants_table(report.get("plants") or ()),
        notes=notes_list(report.get("notes") or ()),
    )


def measures_table(report: Report) -> str:
    """The measures before and after, as table rows."""
    return "\n".join(
        f"<tr><th scope=row>{text(row.label)}</th><td>{row.before}</td><td>{row.after}</td>"
        f"<td>{text(row.unit)}</td></tr>"
        for row in measure_rows(report)
    )


def plants_table(plants: Sequence[Report]) -> str:
    """The plants, as table rows."""
    columns = ("slide_before_mm", "slide_after_mm", "penetration_after_mm", "residual_mm")
    rows = []
    for plant in plants:
        figures = "".join(f"<td>{_figure(plant.get(key))}</td>" for key in columns)
        rows.append(
            f"<tr><th scope=row>{name(plant.get('effector', ''))}</th><td>{_figure(plant.get('start'), 0)}</td>"
            f"<td>{_figure(plant.get('end'), 0)}</td>{figures}<td>{text(plant.get('outcome', ''))}</td>"
            f"<td>{text(plant.get('reason') or '')}</td></tr>"
        )
    return "\n".join(rows)


def _figure(value: Any, digits: int = 1) -> str:
    return f"{value:.{digits}f}" if isinstance(value, int | float) else "–"


def notes_list(notes: Sequence[Report]) -> str:
    """The notes, as list items."""
    return "\n".join(
        f"<li class={'warning' if note.get('severity') != 'note' else 'note'}>"
        f"<b>{text(note.get('severity', 'note'))}</b> {text(note.get('text', ''))}</li>"
        for note in notes
    )

"""The report of a clip as one HTML file, which opens anywhere and loads no other files."""

from __future__ import annotations

import base64
import hashlib
import math
import pkgutil
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from string import Template
from typing import Any

from footfix.formats.suffixes import in_file, is_motion
from footfix.report import words
from footfix.report.follow_text import path_of
from footfix.report.loop_text import round_of
from footfix.report.rerun_command import RerunCommand, quoted
from footfix.report.verdict import Report, entries, judge, number, source_name
from footfix.report.web import sections
from footfix.report.web.chart import chart
from footfix.report.web.details import details_table
from footfix.report.web.markup import embedded_json, name, text
from footfix.report.web.motion import Lines, Motion, packed
from footfix.version import __version__

_SCRIPTS = (
    "codec.js", "canvas.js", "words.js", "player.js", "loop_playback.js", "camera.js", "figure.js",
    "measured_points.js", "mesh.js", "floor.js", "stage.js", "orbit.js", "contacts.js", "bars.js", "curves.js",
    "knees.js", "timeline.js", "pointer.js", "editor.js", "table.js", "plants.js", "paths.js", "address.js", "keys.js",
    "viewer.js",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class PageData:
    """All that a page shows.

    Args:
        report: the report document (the contract's report file).
        contacts: the contacts document (the contract's contacts file); the page saves edited contacts as this
            document with other intervals.
        motion: the figure before and after; None where there is none to show (a clip that failed).
        lines: drawn into the curves of height and speed.
        again: how the clip is cleaned again from edited contacts; None where that is not known.
    """

    report: Report
    contacts: Mapping[str, Any] = field(default_factory=dict)
    motion: Motion | None = None
    lines: Lines = field(default_factory=Lines)
    again: RerunCommand | None = None


@cache
def asset(file: str) -> str:
    """Read a template, style sheet or script that lies beside this module."""
    data = pkgutil.get_data("footfix.report.web", file)
    assert data is not None
    return data.decode("utf-8").replace("\r\n", "\n")


@cache
def script(*files: str) -> str:
    """Join a page's script: its parts one after the other, in a scope of their own."""
    return '(() => {\n"use strict";\n' + "\n".join(asset(file) for file in files) + "})();\n"


@cache
def fingerprint(source: str) -> str:
    """Compute the hash by which a content security policy allows a script or a style sheet."""
    return "sha256-" + base64.b64encode(hashlib.sha256(source.encode()).digest()).decode("ascii")


def head(title: str, code: str) -> str:
    """Write the beginning of a page: its title, its style, and the one script that its security policy allows."""
    style = asset("report.css")
    return Template(asset("head.html")).substitute(
        title=text(title), style=style, style_hash=fingerprint(style), script_hash=fingerprint(code)
    )


def render(data: PageData) -> str:
    """Render the page as one HTML document."""
    report = data.report
    verdict = judge(report)
    plants = entries(report, "plants")
    return Template(asset("page.html")).substitute(
        head=head(source_name(report), script(*_SCRIPTS)),
        name=name(source_name(report)),
        badge=sections.badge(verdict.tone, verdict.word),
        verdict=text(verdict.text),
        method=text(report.get("method") or "none"),
        length=_length(data.motion),
        tiles=sections.tiles(report, verdict),
        outcomes=text(sections.outcomes(report)),
        released=sections.loop_list(report) + sections.released_list(report),
        notes=sections.notes_list(entries(report, "notes")),
        viewer=_viewer(data),
        above=asset("top_view.html") if data.motion else "",
        plants=sections.plants_table(plants),
        slide_meaning=text(words.MEASURES["slide_mm"]),
        target_meaning=text(words.OFF_TARGET),
        floor_meaning=text(words.BELOW_FLOOR),
        plants_caption=sections.plants_caption(plants),
        measures=sections.measures_table(report),
        details=details_table(report),
        version=text(__version__),
        data=_data(data),
    )


def _length(motion: Motion | None) -> str:
    if motion is None:
        return ""
    seconds = motion.frames * motion.frame_time
    shown = "" if motion.step == 1 else f"; one frame in {motion.step} is shown"
    return f"{motion.frames} frames, {seconds:.1f} s at {1.0 / motion.frame_time:.4g} fps{shown}"


def _viewer(data: PageData) -> str:
    """Write the 3D view, the timeline and the editor, with a still picture of the feet where no script runs."""
    if data.motion is None:
        return ""
    file = source_name(data.report).replace("\\", "/").rsplit("/", 1)[-1]
    stem = in_file(file)[0]
    stem = stem.rpartition(".")[0] if is_motion(stem) else stem
    return Template(asset("viewer.html")).substitute(
        chart=chart(data.motion, data.contacts),
        file=text(f"{stem}.contacts.json"),
        contacts=name(data.again.contacts if data.again else f"{stem}.contacts.json"),
        command=text(data.again.command if data.again else _command(file, stem)),
        lines=text(f"{100.0 * data.lines.height:g} cm and {data.lines.speed:g} m/s, {data.lines.meaning}"),
    )


def _command(file: str, stem: str) -> str:
    """Write a command to clean the clip again, for where the folders are not known."""
    return quoted(["footfix", "clean", file, "-o", "cleaned", "--labels", f"{stem}.contacts.json", "--force"])


def _data(data: PageData) -> str:
    """Write the script and its data as elements of the page."""
    if data.motion is None:
        return ""
    document = {
        "contacts": _finite(data.contacts),
        "motion": {**packed(data.motion, data.lines), "round": round_of(data.report), "path": path_of(data.report)},
        "plants": [_outcome(plant) for plant in entries(data.report, "plants")],
    }
    values = f'<script type="application/json" id="data">{embedded_json(document)}</script>'
    return f"{values}\n<script>{script(*_SCRIPTS)}</script>"


def _outcome(plant: Report) -> list[Any]:
    """List what the timeline shows of a plant: effector, start, slides and outcome."""
    slides = (number(plant.get(f"slide_{when}_mm")) for when in ("before", "after"))
    return [str(plant.get("effector", "")), plant.get("start"), *slides, str(plant.get("outcome") or "")]


def _finite(value: Any) -> Any:
    """Replace NaN and infinity in a document, which JSON can't hold, by None."""
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value

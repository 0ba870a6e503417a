"""The index of a batch: every clip with its verdict, the worst first, and small pictures of the worst plants."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from string import Template
from urllib.parse import quote

from footfix.measure.plants import NOTICED_MM
from footfix.report import words
from footfix.report.offenders import Offender, Path
from footfix.report.text import released
from footfix.report.thumbnail import LAYERS, SIZE, Thumbnail
from footfix.report.verdict import Report, Verdict, judge, largest_change, measure_rows, number, section
from footfix.report.web import sections
from footfix.report.web.markup import name, path_name, text
from footfix.report.web.page import asset, head, script
from footfix.version import __version__

MOST_OFFENDERS, MOST_FIGURES = 24, 200
_SIZE = 120  # of a small picture from above, in its own units
_PATH = re.compile(r"[ML0-9 .-]*")


@dataclass(frozen=True, eq=False)
class IndexRow:
    """One clip of a batch.

    Args:
        source: its name, as people know it.
        page: path of its page relative to the index, with forward slashes; "" where it has none.
        report: its report document; `{"status": "failed"}` where there is none.
        error: why it failed.
        offenders: its worst plants.
    """

    source: str
    page: str = ""
    report: Report = field(default_factory=dict)
    error: str = ""
    offenders: tuple[Offender, ...] = ()


def render_index(rows: Sequence[IndexRow]) -> str:
    """Render the index of a batch as one HTML document."""
    judged = sorted(((row, judge(row.report)) for row in rows), key=_badness, reverse=True)
    clips, code = f"{len(rows)} {'clip' if len(rows) == 1 else 'clips'}", script("table.js", "index.js")
    verdicts = [verdict for _, verdict in judged]
    return Template(asset("index.html")).substitute(
        head=head(clips, code),
        script=code,
        clips=clips,
        verdict=text(_verdict(verdicts)),
        badges=" ".join(_badges(verdicts)),
        tiles=_tiles(judged),
        offenders="\n".join(_offenders(rows)),
        rows="\n".join(_row(row, verdict, k < MOST_FIGURES) for k, (row, verdict) in enumerate(judged)),
        version=text(__version__),
    )


def _badness(pair: tuple[IndexRow, Verdict]) -> tuple[bool, float, float]:
    verdict = pair[1]
    return verdict.word == "failed", verdict.worst_after, verdict.worst_before


def _verdict(verdicts: Sequence[Verdict]) -> str:
    plants = sum(verdict.plants for verdict in verdicts)
    before = sum(verdict.over_before for verdict in verdicts)
    after = sum(verdict.over_after for verdict in verdicts)
    if not plants:
        return "No footplants were found"
    if not before and not after:
        return f"None of {plants} footplants slides more than {NOTICED_MM:g} mm"
    now = f"{after} still {'do' if after > 1 else 'does'}" if after else "now none does"
    return f"{before} of {plants} footplants slid more than {NOTICED_MM:g} mm; {now}"


def _badges(verdicts: Sequence[Verdict]) -> Iterator[str]:
    counts = Counter((verdict.tone, verdict.word) for verdict in verdicts)
    for (tone, word), count in counts.most_common():
        yield sections.badge(tone, f"{count} {word}")


def _tiles(judged: Sequence[tuple[IndexRow, Verdict]]) -> str:
    verdicts = [verdict for _, verdict in judged]
    worst = [max((getattr(each, key) for each in verdicts), default=0.0) for key in ("worst_before", "worst_after")]
    sums = [sum(getattr(verdict, key) for verdict in verdicts) for key in ("plants", "over_before", "over_after")]
    failed = sum(verdict.word == "failed" for verdict in verdicts)
    came_worse = sum(_came_worse(row.report, verdict) for row, verdict in judged)
    changes = [(change, row) for row, _ in judged if (change := largest_change(row.report))]
    change, where = max(changes, key=lambda pair: pair[0].degrees, default=(None, None))
    return (
        sections.tile("Clips", "", str(len(verdicts)))
        + (sections.tile("Clips that failed", "", str(failed)) if failed else "")
        + sections.tile("Footplants", "", str(sums[0]), meaning=words.PLANT)
        + sections.tile(f"Slide over {NOTICED_MM:g} mm", "", str(sums[1]), str(sums[2]))
        + sections.tile("Longest slide", "mm", f"{worst[0]:.0f}", f"{worst[1]:.0f}")
        + sections.tile("Clips that got worse", "", str(came_worse), meaning=words.CLIP_WORSE)
        + (
            sections.placed_tile(
                "Largest joint change", "°", f"{change.degrees:.0f}",
                f"{_link(where, change.frame)}, {name(change.joint)}, frame {change.frame}", words.CHANGE,
            )
            if change and where
            else ""
        )
    )  # fmt: skip


def _came_worse(report: Report, verdict: Verdict) -> bool:
    """Tell whether a plant slides farther than before, or a measure of the first screen grew."""
    return bool(verdict.worse) or any(row.worse for row in measure_rows(report) if row.headline)


def _link(row: IndexRow, frame: int | None = None) -> str:
    """Write the name of a clip, as a link to a frame on its page where it has one."""
    if not row.page:
        return path_name(row.source)
    return f'<a href="{_address(row.page)}{"" if frame is None else f"#f={frame}"}">{path_name(row.source)}</a>'


def _row(row: IndexRow, verdict: Verdict, pictured: bool) -> str:
    after = section(row.report, "after")
    below, jitter = (number(after.get(key)) for key in ("penetration_mm", "jitter_100m_s3"))
    change = largest_change(row.report)
    offender = row.offenders[0] if row.offenders and pictured else None
    picture = _figure(offender.figure) if offender else ""
    figures = (
        (str(verdict.plants), str(verdict.over_before), str(verdict.over_after),
         f"{verdict.worst_before:.1f}", f"{verdict.worst_after:.1f}")
        if verdict.plants
        else ("–",) * 5
    )  # fmt: skip
    worse = str(verdict.worse) if verdict.worse else "▲" if _came_worse(row.report, verdict) else ""
    told = _without_path(row.error, row.source) if row.error else "; ".join(sections.shortened(released(row.report), 2))
    bars = sections.bars(verdict.worst_before, verdict.worst_after, 5 * NOTICED_MM) if verdict.plants else ""
    return (
        f'<tr><td class="figure">{picture}</td><th scope="row">{_link(row)}</th>'
        f'<td class="word">{sections.badge(verdict.tone, verdict.word, verdict.text)}</td>'
        f"{''.join(f'<td>{figure}</td>' for figure in figures)}"
        f'<td data-value="{verdict.worst_after:.3f}">{bars}</td><td>{worse}</td>'
        f"<td>{'–' if change is None else f'{change.degrees:.0f}'}</td>"
        f"<td>{'–' if below is None else f'{below:.1f}'}</td><td>{'–' if jitter is None else f'{jitter:.2f}'}</td>"
        f'<td class="word remark">{text(told)}</td></tr>'
    )


def _without_path(error: str, source: str) -> str:
    """Cut the path from the beginning of an error, since the clip's name is shown beside it."""
    at = error.find(f"{source}:")
    return error[at + len(source) + 1 :].strip() if at >= 0 else error


def _address(page: str) -> str:
    """Write a relative address so that it can't be read as one with a scheme or a host."""
    try:
        raw = page.encode("utf-8", "surrogateescape")  # a name that is not UTF-8 keeps its bytes
    except UnicodeEncodeError:
        raw = page.encode("utf-8", "surrogatepass")
    return text("./" + quote(raw, safe="/").lstrip("/"))


def _offenders(rows: Sequence[IndexRow]) -> Iterator[str]:
    pairs = [(row, offender) for row in rows for offender in row.offenders[:2]]  # one clip must not fill the list
    pairs = [pair for pair in pairs if max(pair[1].before_mm, pair[1].after_mm) >= 1.0]  # others hardly slide
    pairs.sort(key=lambda pair: (pair[1].after_mm, pair[1].before_mm), reverse=True)
    for row, offender in pairs[:MOST_OFFENDERS]:
        title = f"{offender.effector.replace('_', ' ')}, frames {offender.start}–{offender.end}"
        yield (
            f'<li><div class="pair">{_figure(offender.figure)}{_picture(offender)}</div>'
            f"<p>{_link(row, offender.frame)}</p><p>{text(title)}</p>"
            f'<p><span class="was">{offender.before_mm:.0f}</span> → <b>{offender.after_mm:.0f}</b> mm</p></li>'
        )


def _figure(drawing: Thumbnail) -> str:
    """Draw a figure before and after, small; nothing if its data is invalid (from a journal of another version)."""
    if len(drawing) != len(LAYERS) or not all(isinstance(path, str) and _PATH.fullmatch(path) for path in drawing):
        return ""
    paths = "".join(f'<path class="{layer}" d="{path}"/>' for layer, path in zip(LAYERS, drawing, strict=True) if path)
    return f'<svg class="thumb" viewBox="0 0 {SIZE} {SIZE}" aria-hidden="true">{paths}</svg>'


def _picture(offender: Offender) -> str:
    """Draw the path of a plant from above, before and after, with the 21 mm circle that viewers notice."""
    reach = 1.3 * NOTICED_MM
    places = [(-reach, -reach), (reach, reach), *offender.path_before, *offender.path_after]
    (x0, x1), (z0, z1) = ((min(axis), max(axis)) for axis in zip(*places, strict=True))
    scale = _SIZE / (1.1 * max(x1 - x0, z1 - z0))
    left, top = (scale * (low + high) / 2 - _SIZE / 2 for low, high in ((x0, x1), (z0, z1)))

    def line(path: Path) -> str:
        # A single point becomes a line of zero length, whose round ends show as a dot.
        return "M" + " ".join(f"{x * scale:.1f} {z * scale:.1f}" for x, z in (path if len(path) > 1 else path * 2))

    return (
        f'<svg class="plant" viewBox="{left:.1f} {top:.1f} {_SIZE} {_SIZE}" aria-hidden="true">'
        f'<circle r="{NOTICED_MM * scale:.1f}"/><path class="was" d="{line(offender.path_before)}"/>'
        f'<path class="now" d="{line(offender.path_after)}"/></svg>'
    )

"""A still picture of a clip's worst plants, as a PNG: for pull requests and terminals without a browser."""

from __future__ import annotations

from footfix.measure.plants import NOTICED_MM
from footfix.report.offenders import Offender, worst_plants
from footfix.report.raster import Raster, color, fitted
from footfix.report.text import printable
from footfix.report.thumbnail import LAYERS, Thumbnail
from footfix.report.verdict import Report, Tone, judge, source_name
from footfix.report.web.motion import Motion, side_of

_PAPER, _INK, _MUTED, _LINE = color("#fffefb"), color("#1a2027"), color("#5b6570"), color("#dfdcd4")
_WAS, _LEFT, _RIGHT = color("#8450a6"), color("#0069a8"), color("#b34800")
_TONES: dict[Tone, str] = {"good": "#146c43", "fair": "#8a5a00", "bad": "#a8201a", "quiet": "#5b6570"}

_SMALL = 0.75  # [pixels] one unit of the small figure
_PANEL, _GAP, _HEAD, _FOOT, _COLUMNS = 220, 16, 96, 48, 4  # [pixels]


def picture(motion: Motion | None, report: Report, most: int = 8) -> bytes:
    """Draw a PNG of the verdict and of the worst plants from above, before and after.

    Args:
        motion: the figure before and after; None to draw the verdict alone.
        report: the report document.
        most: how many plants, at most.
    """
    found = worst_plants(motion, report, most) if motion is not None else ()
    rows = -(-len(found) // _COLUMNS)
    width = _GAP + _COLUMNS * (_PANEL + _GAP)
    raster = Raster(width, _HEAD + rows * (_PANEL + _FOOT + _GAP) + (30 if found else 0), _PAPER)
    _head(raster, report, width - 2 * _GAP)
    for k, offender in enumerate(found):
        left = _GAP + (k % _COLUMNS) * (_PANEL + _GAP)
        _panel(raster, offender, left, _HEAD + (k // _COLUMNS) * (_PANEL + _FOOT + _GAP))
    if found:
        _legend(raster, raster.pixels.shape[0] - 24)
    return raster.png()


def _head(raster: Raster, report: Report, width: float) -> None:
    verdict = judge(report)
    raster.write(fitted(printable(source_name(report)), 10, width), _GAP, 16, 10, _MUTED)
    raster.write(fitted(verdict.text, 15, width), _GAP, 38, 15, _INK, bold=True)
    line = verdict.word
    if max(verdict.worst_before, verdict.worst_after) >= 0.5:
        line += f": longest slide {verdict.worst_before:.0f} → {verdict.worst_after:.0f} mm"
    raster.write(line, _GAP, 68, 11, color(_TONES[verdict.tone]), bold=True)


def _panel(raster: Raster, offender: Offender, left: float, top: float) -> None:
    frame = [(0, 0), (_PANEL, 0), (_PANEL, _PANEL), (0, _PANEL), (0, 0)]
    raster.line([(left + x, top + y) for x, y in frame], 1.0, _LINE)
    _figure(raster, offender.figure, left + 4, top + 4)
    reach = 1.3 * NOTICED_MM
    places = [(-reach, -reach), (reach, reach), *offender.path_before, *offender.path_after]
    (x0, x1), (z0, z1) = ((min(axis), max(axis)) for axis in zip(*places, strict=True))
    scale = _PANEL / (1.12 * max(x1 - x0, z1 - z0))
    ox, oy = left + (_PANEL - scale * (x0 + x1)) / 2.0, top + (_PANEL - scale * (z0 + z1)) / 2.0
    side = _RIGHT if side_of(offender.effector) == "right" else _LEFT
    raster.circle(ox, oy, scale * NOTICED_MM, 1.0, _MUTED, dashes=24)
    raster.line([(ox + scale * x, oy + scale * z) for x, z in offender.path_before], 4.5, _WAS, 0.75)
    raster.line([(ox + scale * x, oy + scale * z) for x, z in offender.path_after], 2.4, side)
    title = f"{offender.effector.replace('_', ' ')} {offender.start}–{offender.end}"
    raster.write(fitted(printable(title), 9, _PANEL), left, top + _PANEL + 9, 9, side, bold=True)
    raster.write(f"{offender.before_mm:.1f} → {offender.after_mm:.1f} mm", left, top + _PANEL + 27, 9, _INK)


def _figure(raster: Raster, drawing: Thumbnail, left: float, top: float) -> None:
    """Draw the figure, at the frame where its foot is farthest from its place, in the corner of a panel."""
    inks = dict(zip(LAYERS, (_WAS, _MUTED, _LEFT, _RIGHT), strict=True))
    for layer, path in zip(LAYERS, drawing, strict=False):
        for line in path.split("M")[1:]:
            numbers = [float(number) for number in line.replace("L", " ").split()]
            places = [(left + _SMALL * x, top + _SMALL * y) for x, y in zip(numbers[::2], numbers[1::2], strict=True)]
            raster.line(places, 1.2 if layer == "was" else 1.8, inks[layer], 0.8)


def _legend(raster: Raster, y: float) -> None:
    raster.line([(_GAP, y + 4), (_GAP + 22, y + 4)], 4.5, _WAS, 0.75)
    raster.write("before", _GAP + 30, y, 8, _MUTED)
    raster.line([(_GAP + 92, y + 4), (_GAP + 114, y + 4)], 2.4, _LEFT)
    raster.line([(_GAP + 118, y + 4), (_GAP + 140, y + 4)], 2.4, _RIGHT)
    told = f"after, left and right; toe joint or ankle from above, the ring is {NOTICED_MM:g} mm"
    raster.write(told, _GAP + 148, y, 8, _MUTED)

"""A still picture of the feet: heights over time with contact bars, as SVG within the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from footfix.motion.clip import Floats
from footfix.motion.segments import distinct
from footfix.report.web.markup import text
from footfix.report.web.motion import Motion, side_of

_WIDTH, _LEFT, _ROW, _BAR, _POINTS = 960, 96, 84, 9, 480


def chart(motion: Motion, contacts: Mapping[str, Any]) -> str:
    """Draw the height of every sole point over time, before and after, with its contacts under it."""
    effectors = contacts.get("effectors") or ()
    rows = []
    heights = np.stack([motion.soles_before[..., 1], motion.soles_after[..., 1]]) - motion.floor  # (2, D, E) [m]
    top = max(float(heights.max(initial=0.0)), 0.01)
    bottom = min(float(heights.min(initial=0.0)), 0.0)
    scale = (_ROW - _BAR - 22) / (top - bottom)
    for e, effector in enumerate(effectors):
        if e >= heights.shape[2]:
            break
        base = e * _ROW + _ROW - _BAR - 10 + bottom * scale
        side = side_of(str(effector.get("name", ""))) or "left"
        rows.append(f'<text x="0" y="{base - 4:.1f}">{text(str(effector.get("name", "")).replace("_", " "))}</text>')
        rows.append(f'<path class="floor" d="M{_LEFT} {base:.1f}H{_WIDTH}"/>')
        rows.append(f'<path class="bars {side}" d="{_bars(effector, motion.frames, e * _ROW + _ROW - _BAR)}"/>')
        for when, series in zip(("before", "after"), heights[..., e], strict=True):
            rows.append(f'<path class="{when} {side}" d="{_path(series, motion, base, scale)}"/>')
    height = max(len(effectors), 1) * _ROW
    return (
        f'<svg class="chart" viewBox="0 0 {_WIDTH} {height}" role="img" '
        f'aria-label="Height of heels and toes over time, with contact bars">{"".join(rows)}</svg>'
    )


def _x(frame: Any, frames: int) -> Any:
    return _LEFT + (_WIDTH - _LEFT) * frame / max(frames, 1)


def _bars(effector: Mapping[str, Any], frames: int, y: float) -> str:
    """Draw the contacts of an effector as strokes; those closer than half a unit run together."""
    spans: list[list[float]] = []
    for contact in effector.get("contacts") or ():
        a, b = _x(contact["start"], frames), _x(contact["end"], frames)
        if spans and a - spans[-1][1] < 0.5:
            spans[-1][1] = b
        else:
            spans.append([a, b])
    return "".join(f"M{a:.1f} {y:.1f}H{b:.1f}" for a, b in spans)


def _path(series: Floats, motion: Motion, base: float, scale: float) -> str:
    pick = distinct(np.linspace(0, len(series) - 1, min(_POINTS, len(series))).astype(np.intp))
    points = np.stack([_x(pick * motion.step, motion.frames), base - scale * series[pick]], axis=1)
    # all at once: half the time of one by one
    return "M" + " ".join(["%.1f %.1f"] * len(points)) % tuple(points.ravel().tolist())

"""What `footfix inspect` found in a file, as text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from footfix.report.text import printable


def describe(found: Mapping[str, Any], *, quiet: bool = False) -> str:
    """Describe the file in a few lines, then everything odd about it; with `quiet` only what is odd."""
    source, rig = found["source"], found["rig"]
    name = printable(str(source["file"]))
    lines = []
    if not quiet:
        duration = source["frames"] * source["frame_time"]
        lines.append(
            f"{name}: {source['frames']} frames at {found['fps']:.4g} fps ({duration:.2f} s), {found['joints']} joints"
        )
        if rig is not None:
            lines.append(f"  1 unit is {rig['unit_m']:g} m, {rig['up']} is up")
            figures = found.get("figures") or [rig]
            for k, figure in enumerate(figures):
                lines += _figure(figure, f"figure {k + 1}: " if len(figures) > 1 else "")
    for each in found["notes"]:
        place = ":".join(str(each[key]) for key in ("line", "column") if key in each)
        where = f"{name}:{place}" if place else name
        lines.append(f"  {each['severity']} [{each['id']}] {where}: {printable(each['text'])}")
    return "\n".join(lines)


def _figure(rig: Mapping[str, Any], which: str) -> list[str]:
    """Describe legs, floor and root of a figure, a line each."""
    count = len(rig["legs"])
    head = (
        f"  {which}{count} {'leg' if count == 1 else 'legs'} of {rig['leg_length_m']:.3f} m, floor at "
        f"{rig['floor_m']:.3f} m, travels by {printable(rig['root'])}"
    )
    legs = []
    for leg in rig["legs"]:
        chain = " > ".join(printable(str(leg[key])) for key in ("hip", "knee", "ankle", "toe") if leg[key])
        legs.append(f"  {leg['name']} leg: {chain}")
    return [head, *legs]

"""The worst plants of a clip, as small pictures from above: for the batch index and the PNG."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Floats
from footfix.motion.segments import distinct
from footfix.report.thumbnail import Thumbnail, thumbnail
from footfix.report.verdict import Report, entries, number, worst_first
from footfix.report.web.motion import Motion, seen_tracks

Path = tuple[tuple[float, float], ...]

_PLACES = 40  # points of a drawn path, at most


@dataclass(frozen=True)
class Offender:
    """A plant that slides, with what a small picture of it needs; picklable.

    Args:
        effector: name of the sole point.
        start, end: frames `[start, end)`.
        before_mm, after_mm: its slide before and after cleaning [mm].
        path_before, path_after: [mm] the horizontal path of what is measured (the toe joint, or the ankle of a flat
            foot), x to the right and z downwards, relative to its median place after cleaning.
        frame: when it was farthest from its place before cleaning.
        figure: the figure at that frame; empty where it is not drawn.
    """

    effector: str
    start: int
    end: int
    before_mm: float
    after_mm: float
    path_before: Path
    path_after: Path
    frame: int = 0
    figure: Thumbnail = ()


def worst_plants(motion: Motion, report: Report, most: int = 3) -> tuple[Offender, ...]:
    """List the plants of a clip that slide most, the worst first.

    Args:
        motion: the figure before and after.
        report: the report document.
        most: how many, at most.
    """
    plants = worst_first(entries(report, "plants"))
    known = [plant for plant in plants if plant.get("effector") in motion.sole_names]
    tracks = seen_tracks(motion)
    return tuple(_offender(motion, tracks, plant) for plant in known[:most])


def _offender(motion: Motion, tracks: tuple[Floats, Floats], plant: Report) -> Offender:
    sole = motion.sole_names.index(str(plant["effector"]))
    start, end = int(plant["start"]), int(plant["end"])
    last = len(motion.soles_before) - 1
    first = min(-(-start // motion.step), last)
    span = np.arange(first, max(first + 1, min(-(-end // motion.step), last + 1)))
    counting = span[motion.counts[span, sole]]
    looked_at = counting if len(counting) else span
    before, after = (1000.0 * each[looked_at, sole][:, [0, 2]] for each in tracks)
    place = np.median(after, axis=0)
    farthest = int(looked_at[np.argmax(np.linalg.norm(before - np.median(before, axis=0), axis=1))])
    return Offender(
        str(plant["effector"]), start, end,
        number(plant.get("slide_before_mm")) or 0.0, number(plant.get("slide_after_mm")) or 0.0,
        _path(before - place), _path(after - place),
        farthest * motion.step, thumbnail(motion, farthest),
    )  # fmt: skip


def _path(places: Floats) -> Path:
    pick = distinct(np.linspace(0, len(places) - 1, min(_PLACES, len(places))).astype(np.intp))
    return tuple((round(float(x), 1) + 0.0, round(float(z), 1) + 0.0) for x, z in places[pick])

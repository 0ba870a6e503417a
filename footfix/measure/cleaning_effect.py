"""Measures of a cleaned clip: held plants, released plants, and the cost of cleaning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from footfix.measure.plants import NOTICED_MM


@dataclass(frozen=True)
class Held:
    """The plants that cleaning held, and those it released.

    A plant is released, wholly or in part, where holding it would be worse than its slide: the leg would have to be too
    long, or the knee too fast. The report gives the reason for each. In a clip never cleaned all plants count as held.

    Args:
        held_slide_mm: slide of the worst plant that is held [mm].
        held_over_21mm: plants that slide farther than viewers notice, of those that are held [share].
        let_go: plants that were released, wholly or in part [count].
    """

    held_slide_mm: float
    held_over_21mm: float
    let_go: int


@dataclass(frozen=True)
class Costs:
    """The cost of cleaning: measures of the clip divided by those before cleaning; 1 where those are not known.

    Args:
        jitter_ratio: jitter_100m_s3 now, over what it was [factor].
        acceleration_ratio: peak_acceleration_m_s2 now, over what it was [factor].
        knee_speed_ratio: peak_knee_speed_deg_s now, over what it was [factor].
    """

    jitter_ratio: float
    acceleration_ratio: float
    knee_speed_ratio: float


# Cost -> the measure that it compares.
COST_OF: Mapping[str, str] = {
    "jitter_ratio": "jitter_100m_s3",
    "acceleration_ratio": "peak_acceleration_m_s2",
    "knee_speed_ratio": "peak_knee_speed_deg_s",
}


def held(slides: Sequence[float], let_go: Sequence[bool]) -> Held:
    """Measure the held plants of a clip, and count the others.

    Args:
        slides: (N,) [mm] of each plant.
        let_go: (N,) whether each was released, wholly or in part.
    """
    kept = [slide for slide, gone in zip(slides, let_go, strict=True) if not gone]
    over = sum(slide > NOTICED_MM for slide in kept)
    return Held(max(kept, default=0.0), over / len(kept) if kept else 0.0, sum(let_go))


def costs(now: Mapping[str, float | None], before: Mapping[str, float | None]) -> Costs:
    """Compare measures of a clip, by name, with those before cleaning."""
    ratios = {}
    for name, measure in COST_OF.items():
        was = before.get(measure) or 0.0
        ratios[name] = float(f"{(now.get(measure) or 0.0) / was:.6g}") if was > 0.0 else 1.0
    return Costs(**ratios)

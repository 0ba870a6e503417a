"""Footplant: one contact of one effector, where it stands, and what became of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from footfix.motion.contacts import Part

Outcome = Literal["pinned", "partly", "released", "kept"]


@dataclass(frozen=True)
class Footplant:
    """A contact, the same value from detection to the report.

    Args:
        id: its place among the plants of a clip, by effector, then time.
        effector: index among `Rig.soles`.
        name: name of the sole point, `left_heel`.
        leg: index among `Rig.legs`.
        part: "heel" or "toe".
        start, end: frames `[start, end)` of the whole contact.
        confidence: of the detection, 0 to 1.
        force: it is held whatever it costs.
        asked: (x, y, z) [m] where the labels ask for it to stand.
        target: (x, y, z) [m] where it stands after all.
        outcome: "kept" (it stood well enough), "pinned" (it stands), "partly" (it stands in some of its frames,
            and slides in others), "released" (it slides in most of them, for the reason given).
        reason: for a person, where it does not stand throughout.
        residual: [m] farthest horizontal distance from its target over the whole contact.
        held: the frames in which it stands, as stretches `[start, end)`.
    """

    id: int
    effector: int
    name: str
    leg: int
    part: Part
    start: int
    end: int
    confidence: float = 1.0
    force: bool = False
    asked: tuple[float, float, float] | None = None
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    outcome: Outcome = "kept"
    reason: str = ""
    residual: float = 0.0
    held: tuple[tuple[int, int], ...] = ()

    @property
    def frames(self) -> slice:
        """Its frames as a slice."""
        return slice(self.start, self.end)

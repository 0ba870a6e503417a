"""Footplant: one contact of one effector, where it is to stand, and what became of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Outcome = Literal["pinned", "partly", "released", "kept"]


@dataclass(frozen=True)
class Footplant:
    """A contact on its way through enforcement.

    Args:
        effector: name of the sole point, `left_heel`.
        start, end: frames `[start, end)` in which it is held: the contact's, less what of it is still landing or
            already leaving; the contact's own where it was released.
        confidence: of the detection, 0 to 1.
        target: (x, y, z) [m] where it is to stand.
        outcome: "pinned" (stands on its target), "partly" (as near as reach allows), "released" (left as it
            was, for the reason given), "kept" (it stood well enough already).
        reason: for a person, when it is not plainly pinned.
        residual: [m] the farthest it stays from its target.
    """

    effector: str
    start: int
    end: int
    confidence: float
    target: tuple[float, float, float]
    outcome: Outcome = "pinned"
    reason: str = ""
    residual: float = 0.0

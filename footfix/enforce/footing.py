"""Footing: the plants of a clip, the floors they stand on, and which of them need no correction."""

from __future__ import annotations

from dataclasses import dataclass

from footfix.enforce.footplant import Footplant
from footfix.enforce.standing_heights import Floors
from footfix.motion.clip import Floats


@dataclass(frozen=True, eq=False)
class Footing:
    """The plants of a clip of F frames, and what they stand on.

    Args:
        plants: the plants to hold.
        floors: the heights that joints stand at.
        ground: (F, 3) [m] displacement of the ground.
        keep: for each plant whether it needs no correction.
        by_hand: for each plant whether it was given, not detected, so that its ends are certain.
    """

    plants: tuple[Footplant, ...]
    floors: Floors
    ground: Floats
    keep: tuple[bool, ...]
    by_hand: tuple[bool, ...]

    def of_leg(self, k: int) -> list[Footplant]:
        """List the plants of a leg's heel and toe."""
        return [plant for plant in self.plants if plant.leg == k]

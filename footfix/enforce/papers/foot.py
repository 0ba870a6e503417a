"""The way of a foot whose heel and toe are held: two effectors, one rigid foot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.footplant import Footplant
from footfix.enforce.papers.ease import Span
from footfix.enforce.papers.leg import CapturedLeg
from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import Part

PARTS: tuple[Part, Part] = ("heel", "toe")


@dataclass(frozen=True, eq=False)
class Displacement:
    """How far one effector is moved from where it was captured.

    Args:
        shift: (F, 3) [m].
        share: (F,) how much the effector is held, 1 in its contacts, 0 away from them.
    """

    shift: Floats
    share: Floats


@dataclass(frozen=True, eq=False)
class FootGoal:
    """Where a foot is to be, in the world.

    Args:
        ankle: (F, 3) [m].
        turn: (F, 4) the ankle's frame.
        moves: (F,) the frames in which it is not simply where it was captured.
    """

    ankle: Floats
    turn: Floats
    moves: Bools

    def place(self, in_foot: Floats) -> Floats:
        """(F, 3) [m] of a point of the foot, given in the ankle's frame (F, 3) [m]."""
        return self.ankle + rotation.rotate(self.turn, in_foot)


def foot_goal(leg: CapturedLeg, heel: Displacement, toe: Displacement) -> FootGoal:
    """Move a foot by the displacements of its two effectors, rigid as it is.

    A held effector is at its place C_p. One that nothing holds is driven by the captured motion (G §5.1), and goes
    along with the displacement of the other end of its foot: else that would turn the foot by it.
    """
    d_heel, d_toe, w_heel, w_toe = heel.shift, toe.shift, heel.share, toe.share
    heel_goal = leg.heel + d_heel + (1.0 - w_heel)[:, None] * d_toe  # (F, 3) [m]
    toe_goal = leg.toe + d_toe + (1.0 - w_toe)[:, None] * d_heel
    # the foot lies along the line of both; between the two eases it is placed by the end that is held more
    turn = rotation.between(leg.toe - leg.heel, toe_goal - heel_goal)
    by_toe, by_heel = w_toe * (1.0 - w_heel), w_heel * (1.0 - w_toe)
    share = np.where(by_toe > 0.0, by_toe / np.maximum(by_toe + by_heel, 1e-300), 0.0)[:, None]
    pivot, goal = ((1.0 - share) * a + share * b for a, b in ((leg.heel, leg.toe), (heel_goal, toe_goal)))
    ankle = goal + rotation.rotate(turn, leg.ankle - pivot)
    moves = np.any((d_heel != 0.0) | (d_toe != 0.0), axis=1)
    return FootGoal(ankle, rotation.multiply(turn, leg.turn), moves)


def held(
    leg: CapturedLeg, part: Part, plants: Sequence[Footplant], places: Sequence[Floats], ground: Floats
) -> tuple[list[Span], Floats]:
    """Find how far one effector has to be moved while it is held.

    Args:
        leg: as captured.
        part: which effector.
        plants: those of its foot, in any order.
        places: for each its place C_p (3,) [m] where the ground is undisplaced.
        ground: (F, 3) [m] displacement of the ground.

    Returns:
        The frames `[start, end)` of the effector's plants, and C_p - E_0(t) (F, 3) [m] in these.
    """
    own = [(plant, place) for plant, place in zip(plants, places, strict=True) if plant.part == part]
    own.sort(key=lambda pair: pair[0].start)
    needed = np.zeros((len(leg), 3))
    for plant, place in own:
        needed[plant.frames] = (place + ground - leg.effector(part))[plant.frames]
    return [(plant.start, plant.end) for plant, _ in own], needed

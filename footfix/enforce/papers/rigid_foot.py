"""The motion of a rigid foot whose heel and toe are held."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.easing import Span, eased, gamma
from footfix.enforce.footplant import Footplant
from footfix.enforce.two_bone_ik import CapturedLeg
from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import Part, runs

PARTS: tuple[Part, Part] = ("heel", "toe")


@dataclass(frozen=True, eq=False)
class Displacement:
    """How far one effector is moved from where it was captured.

    Args:
        shift: (F, 3) [m].
        planted: (F,) the frames of its contacts.
    """

    shift: Floats
    planted: Bools


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
        """Compute the place (F, 3) [m] of a point of the foot, given in the ankle's frame (F, 3) [m]."""
        return self.ankle + rotation.rotate(self.turn, in_foot)


def foot_goal(leg: CapturedLeg, heel: Displacement, toe: Displacement, sigma: int) -> FootGoal:
    """Move a foot by the displacements of its two effectors, rigid as it is.

    A planted effector is at its place C_p. While both are planted, the foot lies along the line between both places,
    and that turn is eased in and out like a displacement. The foot is placed by the end that is planted, or is nearer
    in time to a plant. G also drives the free end by the captured motion (§5.1); here it follows the captured
    *orientation* of the foot: a free heel at its captured place, having the higher priority, would pull a planted toe
    away.

    Args:
        leg: as captured.
        heel, toe: the displacements of its effectors.
        sigma: frames of an ease.
    """
    along = leg.toe - leg.heel
    flat = rotation.to_rotation_vector(rotation.between(along, along + toe.shift - heel.shift))  # (F, 3) [rad]
    vector = eased(runs(heel.planted & toe.planted), flat, sigma)
    turn = rotation.from_rotation_vector(vector)
    by_heel, by_toe = (_closeness(each.planted, sigma) for each in (heel, toe))
    by_heel, by_toe = by_heel * (1.0 - by_toe), by_toe * (1.0 - by_heel)
    share = np.where(by_toe > 0.0, by_toe / np.maximum(by_toe + by_heel, 1e-300), 0.0)[:, None]
    pivot = leg.heel + share * along
    goal = pivot + (1.0 - share) * heel.shift + share * toe.shift
    ankle = goal + rotation.rotate(turn, leg.ankle - pivot)
    moves = np.any((heel.shift != 0.0) | (toe.shift != 0.0) | (vector != 0.0), axis=1)
    return FootGoal(ankle, rotation.multiply(turn, leg.turn), moves)


def _closeness(planted: Bools, sigma: int) -> Floats:
    """Measure how near each frame is to a contact, (F,): 1 in contacts, falling to 0 within sigma frames."""
    frames = np.arange(len(planted))
    far = len(planted) + sigma
    before = np.maximum.accumulate(np.where(planted, frames, -far))
    after = np.minimum.accumulate(np.where(planted, frames, 2 * far)[::-1])[::-1]
    return gamma(np.minimum(frames - before, after - frames) / sigma)


def planted(spans: Sequence[Span], frames: int) -> Bools:
    """Mark the frames of contacts `[start, end)`, (F,)."""
    mask = np.zeros(frames, dtype=np.bool_)
    for start, end in spans:
        mask[start:end] = True
    return mask


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

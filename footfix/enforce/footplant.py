"""Footplants: one contact of one effector, and, after the solution, where and how well it was held."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from footfix.enforce.leg import POINTS, LegTracks
from footfix.motion.clip import Bools
from footfix.motion.contacts import Contacts, Part
from footfix.notes import Note
from footfix.rig.rig import Rig

Outcome = Literal["pinned", "partly", "released", "kept"]

_BY_HAND = ("labels", "known")  # methods whose contacts were given, not detected
FEWEST = 3  # frames of a plant; fewer may be a foot that only passes


@dataclass(frozen=True)
class Footplant:
    """A contact to be held, with its target and outcome.

    Args:
        id: its index among the plants of a clip, by effector, then time.
        effector: index among `Rig.soles`.
        name: name of the sole point, `left_heel`.
        leg: index among `Rig.legs`.
        part: "heel" or "toe".
        start, end: frames `[start, end)` of the whole contact.
        confidence: confidence of the contact, 0 to 1.
        force: whether it is held at any cost.
        asked: (x, y, z) [m] the place requested by labels.
        target: (x, y, z) [m] the place where it is held.
        outcome: "kept" (left as captured), "pinned" (held throughout), "partly" (held in some of its frames, sliding
            in others), "released" (sliding in most of them, for the reason given).
        reason: in words, where it is not held throughout.
        residual: [m] farthest horizontal distance from its target over the whole contact.
        held: the frames in which it is held, as stretches `[start, end)`.
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
        """Get its frames as a slice."""
        return slice(self.start, self.end)

    @property
    def point(self) -> int:
        """Get its index among the points of a foot (`leg.POINTS`)."""
        return POINTS.index(self.part)


def footplants(
    contacts: Contacts, rig: Rig, legs: Sequence[LegTracks], farthest: float
) -> tuple[tuple[Footplant, ...], tuple[Note, ...]]:
    """Make a footplant of each contact, except forbidden ones.

    Requested places that the foot can't reach are ignored: labels may come from another version of the clip, with
    another path or a figure of another size.

    Args:
        contacts: as detected or given, the effectors in the order of `rig.soles`.
        rig: its sole points.
        legs: as captured.
        farthest: [leg lengths] a requested place farther away than this is ignored, unless forced.

    Returns:
        The footplants by effector, then time, and a note where a place was left out.
    """
    made: list[Footplant] = []
    asked = taken = 0
    for e, (sole, effector) in enumerate(zip(rig.soles, contacts.effectors, strict=True)):
        for c in effector.contacts:
            if c.wish == "forbid" or c.end <= c.start:
                continue
            place, force = c.position, c.wish == "force"
            if place is not None and not force:
                own = np.median(legs[sole.leg].place(POINTS.index(sole.part))[:, c.start : c.end], axis=1)
                near = float(np.hypot(*(own - np.array(place))[[0, 2]])) <= farthest * rig.leg_length
                asked, taken = asked + 1, taken + near
                place = place if near else None
            made.append(Footplant(
                len(made), e, sole.name, sole.leg, sole.part, c.start, c.end, c.confidence, force, place
            ))  # fmt: skip
    if asked == taken:
        return tuple(made), ()
    text = f"{asked - taken} of {asked} positions in the labels are too far from the motion and were ignored"
    return tuple(made), (Note("places-not-taken", text),)


def given(contacts: Contacts, plant: Footplant) -> bool:
    """Tell whether a contact was given, not detected, so that its ends are certain."""
    return plant.force or (contacts.method in _BY_HAND and plant.confidence >= 1.0)


def stands(plants: Sequence[Footplant], frames: int, legs: int) -> Bools:
    """Mark the frames in which heel and toe of each leg are planted, (legs, 2, F)."""
    on = np.zeros((legs, 2, frames), dtype=np.bool_)
    for plant in plants:
        on[plant.leg, plant.point, plant.frames] = True
    return on

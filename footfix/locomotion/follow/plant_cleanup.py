"""Hold the plants of walks along a path that still slide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant
from footfix.enforce.params import EnforceParams
from footfix.enforce.run import Enforcement, enforce
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.rig.rig import Rig

_KEEP = 1e-3  # [leg lengths] plants that slide no farther are unchanged
_HEEL = 6e-3  # [leg lengths] slide allowed for a heel while its toe is planted: invisible, since heels are round
_EDGE = 0.015  # [s] at both ends of a contact in which a foot may still land or leave


def held_on(
    clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams, *, needed: bool = True
) -> Enforcement:  # fmt: skip
    """Hold the plants of walks along a path.

    Args:
        clip: F frames.
        rig: its legs.
        contacts: which sole points are planted when.
        params: of enforcement.
        needed: whether anything may slide more than in the walks, and must be held.
    """
    needed = needed and not stands(clip, rig, contacts)
    keep = min(params.pins.keep_slide, _KEEP)
    strict = replace(params, cycle="no", pins=replace(params.pins, keep_slide=keep, keep_rested=False))
    found = enforce(clip, rig, contacts, strict, leave=not needed)
    if needed:
        return found
    still = Correction(rig.root, np.zeros((len(clip), 3)), (), np.zeros((len(clip), 0, 4)))
    return replace(found, correction=still)


def as_straight(
    plants: Sequence[Footplant], clip: Clip, straight: Clip, gone: Floats, rig: Rig
) -> tuple[Footplant, ...]:  # fmt: skip
    """Mark plants that slide no farther than in the straight walk as kept.

    Args:
        plants: as they were held.
        clip: F frames along the path.
        straight: the same walk on the spot, along z.
        gone: (F,) [m] that it has gone.
        rig: its legs.
    """
    if all(plant.outcome in ("kept", "pinned") for plant in plants):
        return tuple(plants)
    on = np.outer(gone, [0.0, 0.0, 1.0])
    bent, ahead = rig.held(rig.pose(clip)), rig.held(rig.pose(straight))
    edge, more = max(1, round(_EDGE / clip.frame_time)), _KEEP * rig.leg_length

    def no_farther(plant: Footplant) -> bool:
        some = slice(plant.start + edge, max(plant.end - edge, 0))
        then, now = (_strays(track[some]) for track in (ahead[plant.effector] + on, bent[plant.effector]))
        return now <= then + more

    return tuple(
        replace(plant, outcome="kept") if plant.outcome in ("partly", "released") and no_farther(plant) else plant
        for plant in plants
    )


def _strays(track: Floats) -> float:
    """Measure how far a track (n, 3) gets from its mean place over the floor [m]."""
    own = track[:, [0, 2]]
    return float(np.hypot(*(own - np.median(own, axis=0)).T).max()) if len(own) > 2 else 0.0


def stands(clip: Clip, rig: Rig, contacts: Contacts, slack: float = 1.0) -> bool:
    """Tell whether all plants slide at most `slack` times an invisible slide."""
    edge = max(1, round(_EDGE / clip.frame_time))
    for sole, track, effector in zip(rig.soles, rig.held(rig.pose(clip)), contacts.effectors, strict=True):
        most = slack * (_HEEL if sole.part == "heel" else _KEEP) * rig.leg_length
        for contact in effector.contacts:
            if _strays(track[contact.start + edge : max(contact.end - edge, 0)]) > most:
                return False
    return True

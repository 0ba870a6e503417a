"""Footplants out of contacts, for the tests of enforcement."""

from __future__ import annotations

import numpy as np

from footfix.enforce.footplant import Footplant
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.rig.rig import Rig


def plants_of(rig: Rig, contacts: Contacts) -> list[Footplant]:
    """Every contact as a footplant."""
    pairs = [
        (e, contact) for e, effector in enumerate(contacts.effectors) for contact in effector.contacts
    ]  # fmt: skip
    return [
        Footplant(k, e, rig.soles[e].name, rig.soles[e].leg, rig.soles[e].part, contact.start, contact.end)
        for k, (e, contact) in enumerate(pairs)
    ]


def strays(clip: Clip, rig: Rig, plants: list[Footplant], ground: Floats | None = None) -> Floats:
    """(P,) [m] how far each planted effector, heel or toe joint, is at most from its median place."""
    tracks = rig.held(rig.pose(clip))
    moved = np.zeros((len(clip), 3)) if ground is None else ground
    places = [(tracks[plant.effector] - moved)[plant.frames] for plant in plants]
    return np.array([np.linalg.norm(each - np.median(each, axis=0), axis=1).max() for each in places])


def near_plants(plants: list[Footplant], leg: int, frames: int, ease: int) -> Floats:
    """(F,) True within `ease` frames of a plant of a leg."""
    mask = np.zeros(frames, dtype=bool)
    for plant in plants:
        if plant.leg == leg:
            mask[max(plant.start - ease, 0) : plant.end + ease] = True
    return mask

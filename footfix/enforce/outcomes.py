"""What became of each contact: how far from its target it stayed, and what a person is told about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.footplant import Footplant, Outcome
from footfix.enforce.judge import JERK
from footfix.enforce.plants import Plant, Stance, turns_about
from footfix.motion.clip import Floats
from footfix.motion.contacts import Contacts
from footfix.motion.vectors import norm
from footfix.rig.rig import Rig


def residual(rig: Rig, stands: Sequence[Stance], points: Sequence[Floats]) -> Floats:
    """(F, E) [m] how far each sole point is from its target while it is held."""
    residual = np.zeros((len(points[0]), len(rig.soles)))
    for stance in stands:
        if stance.pivots and not stance.released:  # the end that moves around has no place of its own
            stance = replace(stance, plants=tuple(stance.parts(stance.pivots)))
        for plant in stance.plants:
            off = points[plant.effector][plant.frames] - plant.target
            residual[plant.frames, plant.effector] = norm(off)
    return residual


def footplants(
    rig: Rig,
    stands: Sequence[Stance],
    residual: Floats,
    soft: Sequence[Floats],
    offset: Floats,
    limit: str,
    noticed: float,
) -> tuple[Footplant, ...]:
    """What became of each contact, by effector and time.

    `limit` says what keeps a plant off its target; one farther than `noticed` [m] from it is not held.
    """
    made = []
    softened = [bool(np.any(each)) for each in soft]
    for stance in stands:
        for plant in stance.plants:
            far = float(residual[plant.frames, plant.effector].max())
            why = JERK if softened[stance.leg] and np.any(soft[stance.leg][plant.frames]) else limit
            outcome, reason = _outcome(stance, plant, far, why, rig.leg_length, noticed)
            middle = (plant.start + plant.end) // 2
            x, y, z = (float(v) for v in plant.target - offset[middle] * [1.0, 0.0, 1.0])
            name, (start, end) = rig.soles[plant.effector].name, _span(plant)
            made.append((plant.effector, Footplant(
                name, start, end, plant.contact.confidence, (x, y, z), outcome, reason, far,
            )))  # fmt: skip
    made.sort(key=lambda pair: (pair[0], pair[1].start))
    return tuple(plant for _, plant in made)


def _outcome(
    stance: Stance, plant: Plant, far: float, why: str, leg_length: float, noticed: float
) -> tuple[Outcome, str]:
    if plant.reason:
        return "released", plant.reason
    if stance.pivots and plant.part != stance.pivots:
        return "released", turns_about(stance.pivots)
    if plant.kept:
        return "kept", ""
    if far <= 0.002 * leg_length:
        return "pinned", ""
    stays = f"stays up to {1000.0 * far:.0f} mm away: {why}"
    return ("released" if far > noticed and not plant.given else "partly"), stays


def _span(plant: Plant) -> tuple[int, int]:
    """The frames that a plant was held in; those it was detected in, where it was released."""
    return (plant.contact.start, plant.contact.end) if plant.reason else (plant.start, plant.end)


def held(contacts: Contacts, rig: Rig, stands: Sequence[Stance]) -> Contacts:
    """The contacts as they were held; those released or forbidden as they were given."""
    held = {(p.effector, p.contact.start): _span(p) for stance in stands for p in stance.plants}
    effectors = []
    for e, effector in enumerate(contacts.effectors):
        kept = []
        for contact in effector.contacts:
            start, end = held.get((e, contact.start), (contact.start, contact.end))
            kept.append(replace(contact, start=start, end=end))
        effectors.append(replace(effector, contacts=tuple(kept)))
    return replace(contacts, effectors=tuple(effectors))

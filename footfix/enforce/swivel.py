"""Feet that swivel while they stand: the end that goes around has a place before and after, and none meanwhile.

A detector calls heel and ball planted all the while, and so they are; but a ball held at the mean of two places, or
let go for three seconds because of a turn of one, is neither.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.ease import ease_frames, running_mean
from footfix.enforce.foot import Foot
from footfix.enforce.plants import Plant, PlantParams, Stance, stiller, turns_about
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import Contact, Contacts, runs

_SMOOTH = 0.1  # [s] over which the heading is averaged
_FAST, _SLOW = 45.0, 15.0  # [degrees/s] a swivel is somewhere faster than this, and begins and ends with that
_LEAST = 10.0  # [degrees] that a swivel turns
_MOST_OF_IT = 0.6  # of what the flat foot turns, its swivels do; a foot that turns all the time is no such


def swivelled(
    contacts: Contacts, stands: Sequence[Stance], feet: Sequence[Foot], params: PlantParams
) -> tuple[Contacts, list[Stance]]:
    """The contacts and stances with the end that goes around let go while it does.

    Args:
        contacts: all of them; the effectors in the order of the rig's soles.
        stands: from `plants.stances`.
        feet: their tracks.
        params: measures.

    Returns:
        The contacts, those cut that are, and the stances: what is let go stands in stances of its own.
    """
    found: list[Stance] = []
    cuts: dict[tuple[int, int], list[Contact]] = {}
    for stance in stands:
        if stance.cleaned or stance.released or any(plant.given for plant in stance.plants):
            found.append(stance)
            continue
        held, gone = list(stance.plants), list[Plant]()
        for part, span in _swivels(stance, feet[stance.leg], contacts.frame_time, params):
            held, away = _cut(held, part, span, ease_frames(contacts.frame_time, params.shortest))
            gone += away
        if not gone or not held:
            found.append(stance)
            continue
        found.append(replace(stance, plants=tuple(held)))
        found.append(replace(stance, plants=tuple(gone)))
        for plant in stance.plants:
            pieces = [p.contact for p in (*held, *gone) if _of(p, plant)]
            cuts[plant.effector, plant.contact.start] = sorted(pieces, key=lambda contact: contact.start)
    if not cuts:
        return contacts, found
    effectors = []
    for e, effector in enumerate(contacts.effectors):
        pieces = [piece for contact in effector.contacts for piece in cuts.get((e, contact.start), [contact])]
        effectors.append(replace(effector, contacts=tuple(pieces)))
    return replace(contacts, effectors=tuple(effectors)), found


def _of(piece: Plant, plant: Plant) -> bool:
    inside = plant.contact.start <= piece.contact.start and piece.contact.end <= plant.contact.end
    return piece.effector == plant.effector and inside


def _swivels(
    stance: Stance, foot: Foot, frame_time: float, params: PlantParams
) -> list[tuple[str, tuple[int, int]]]:
    """Which end goes around in which frames `[start, end)`."""
    first = stance.frames.start
    along = foot.ball[stance.frames] - foot.heel[stance.frames]
    found = []
    for start, end in runs(stance.flat):
        heading = np.unwrap(np.arctan2(along[start:end, 0], along[start:end, 2]))
        if end - start < 3 or np.ptp(heading) < np.radians(params.pivot):
            continue
        spans = _quick(heading, frame_time)
        turned = sum(float(np.ptp(heading[a:b])) for a, b in spans)
        if turned < _MOST_OF_IT * float(np.ptp(heading)):
            continue
        for a, b in spans:
            span = first + start + a, first + start + b
            found.append(("toe" if stiller(foot, slice(*span)) == "heel" else "heel", span))
    return found


def _quick(heading: Floats, frame_time: float) -> list[tuple[int, int]]:
    """The frames `[start, end)` in which a heading (N,) [rad] swivels."""
    half = max(1, round(0.5 * _SMOOTH / frame_time))
    speed = np.degrees(np.abs(np.gradient(running_mean(heading, half)))) / frame_time
    moves: Bools = speed > _SLOW
    return [
        (start, end)
        for start, end in runs(moves)
        if speed[start:end].max() > _FAST and np.ptp(heading[start:end]) >= np.radians(_LEAST)
    ]


def _cut(
    plants: Sequence[Plant], part: str, span: tuple[int, int], shortest: int
) -> tuple[list[Plant], list[Plant]]:
    """The plants without those frames of one end, and what was taken from them; pieces that are too short go along."""
    held, gone = [], []
    why = turns_about("toe" if part == "heel" else "heel")
    for plant in plants:
        start, end = max(span[0], plant.start), min(span[1], plant.end)
        if plant.part != part or end <= start:
            held.append(plant)
            continue
        start = plant.contact.start if start - plant.start <= shortest else start
        end = plant.contact.end if plant.end - end <= shortest else end
        if start > plant.contact.start:
            first = replace(plant.contact, end=start)
            held.append(replace(plant, contact=first, end=start))
        taken = replace(plant.contact, start=start, end=end)
        gone.append(replace(plant, contact=taken, start=start, end=end, reason=why))
        if end < plant.contact.end:
            last = replace(plant.contact, start=end)
            held.append(replace(plant, contact=last, start=end))
    return held, gone

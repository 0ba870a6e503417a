"""A closed cycle laid end to end, so that what stands over the seam is held as one plant; and its middle round again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.correction import Correction, apply
from footfix.enforce.footplant import Footplant
from footfix.enforce.run import Enforcement, EnforceParams, enforce
from footfix.locomotion.closing import decay
from footfix.locomotion.travel import Travel, root_in_world, with_root
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contact, Contacts, Effector
from footfix.notes import Note
from footfix.rig.rig import Rig

_BESIDE = 1.5  # [s] of rounds on either side of the middle one: a correction dies out in less
_KEEP = 1e-4  # [leg lengths] only what slides no farther stays as it is: a loop is seen again and again


@dataclass(frozen=True, eq=False)
class Held:
    """A closed cycle whose plants are held.

    Args:
        clip: L + 1 frames, the last of which is the first moved by the travel.
        found: plants, correction, notes and ground of the cycle.
    """

    clip: Clip
    found: Enforcement


def hold(clip: Clip, rig: Rig, contacts: Contacts, travel: Travel, params: EnforceParams) -> Held:
    """Hold the plants of a closed cycle, over its seam too.

    Args:
        clip: L + 1 frames, the last of which is the first moved by `travel`.
        rig: its legs, soles and floor.
        contacts: of the cycle; what stands at its last frame stands at its first.
        travel: of one round.
        params: how footplants are enforced.
    """
    length = len(clip) - 1
    beside = max(1, int(np.ceil(_BESIDE / (length * clip.frame_time))))
    count = 2 * beside + 1
    laid = lay(clip, rig, travel, range(-beside, beside + 1))
    keep = min(params.pins.keep_slide, _KEEP)
    strict = replace(params, cycle="no", pins=replace(params.pins, keep_slide=keep))
    found = enforce(laid, rig, lay_contacts(contacts, count), strict)
    middle = slice(beside * length, (beside + 1) * length + 1)
    done = found.correction
    own = Correction(done.root, done.root_shift[middle], done.joints, done.rotations[middle])
    own = _closed(own, travel, clip)
    plants = _plants(found.plants, contacts, rig, middle.start, length)
    ground = found.ground[middle] - found.ground[middle.start]
    return Held(apply(clip, own), Enforcement(plants, own, _notes(found.notes, middle, length), ground))


def lay(clip: Clip, rig: Rig, travel: Travel, rounds: range) -> Clip:
    """Rounds of a closed cycle end to end; round 0 is where the cycle is.

    Args:
        clip: L + 1 frames.
        rig: its root.
        travel: of one round.
        rounds: R of them.

    Returns:
        R L + 1 frames.
    """
    length = len(clip) - 1
    frames = np.append(np.tile(np.arange(length), len(rounds)), 0)
    place, turn = (np.array(each, order="F")[frames] for each in root_in_world(clip, rig))
    for k, number in enumerate([*rounds, rounds.stop]):
        span = slice(k * length, min((k + 1) * length, len(frames)))
        for _ in range(abs(number)):
            if number > 0:
                place[span] = travel.places(place[span])
                turn[span] = rotation.multiply(travel.turn, turn[span])
            else:
                place[span] = travel.places_back(place[span])
                turn[span] = rotation.multiply(rotation.inverse(travel.turn), turn[span])
    return with_root(clip.frames(frames), rig, place, turn)


def lay_contacts(contacts: Contacts, count: int) -> Contacts:
    """Contacts of a closed cycle over some rounds; what goes on over a seam is one contact.

    Args:
        contacts: of L + 1 frames.
        count: rounds.
    """
    length = contacts.frames - 1
    effectors = tuple(replace(e, contacts=_laid(e, length, count)) for e in contacts.effectors)
    return replace(contacts, frames=count * length + 1, effectors=effectors)


def _laid(effector: Effector, length: int, count: int) -> tuple[Contact, ...]:
    ends = [c for c in effector.contacts if c.start == 0 or c.end == length + 1]
    inner = [c for c in effector.contacts if c not in ends]
    whole = [c for c in ends if c.start == 0 and c.end == length + 1]
    if whole:
        return (replace(whole[0], end=count * length + 1, position=None),)
    found = [_once_placed(c, k, count, length) for k in range(count) for c in inner]
    first, last = (next((c for c in ends if test(c)), None) for test in (lambda c: c.start == 0, lambda c: c.start > 0))
    for k in range(count + 1):  # the seam before round k
        start = k * length - (length - last.start if last is not None else 0)
        end = k * length + (first.end if first is not None else 1)
        start, end = max(start, 0), min(end, count * length + 1)
        like = first or last
        if like is not None and end > start:
            sure = max(c.confidence for c in (first, last) if c is not None)
            found.append(replace(like, start=start, end=end, confidence=sure, position=None))
    return tuple(sorted(found, key=lambda c: c.start))


def _once_placed(contact: Contact, k: int, count: int, length: int) -> Contact:
    """A contact in round k; places are asked for on the clip's own ground, in the middle round."""
    place = contact.position if k == count // 2 else None
    return replace(contact, start=contact.start + k * length, end=contact.end + k * length, position=place)


def _closed(found: Correction, travel: Travel, clip: Clip) -> Correction:
    """The correction of a round so that its end is its start: what is left of a difference decays from both ends."""
    time = np.arange(len(clip)) * clip.frame_time
    tau = 0.5 * time[-1]
    still = np.zeros(3)
    ahead, behind = decay(np.ones(3), still, tau, time), decay(np.ones(3), still, tau, time[-1] - time)
    shift, turns = found.root_shift.copy(), found.rotations.copy()
    gap = rotation.rotate(rotation.inverse(travel.turn), shift[-1]) - shift[0]
    shift += 0.5 * ahead * gap - 0.5 * behind * rotation.rotate(travel.turn, gap)
    shift[-1] = rotation.rotate(travel.turn, shift[0])
    for k in range(len(found.joints)):
        own = turns[:, k]
        off = rotation.to_rotation_vector(rotation.multiply(own[-1], rotation.inverse(own[0])))
        own = rotation.multiply(rotation.from_rotation_vector(0.5 * (ahead - behind) * off), own)
        own[-1] = own[0]
        turns[:, k] = own
    return replace(found, root_shift=shift, rotations=turns)


def _plants(
    found: Sequence[Footplant], contacts: Contacts, rig: Rig, start: int, length: int
) -> tuple[Footplant, ...]:  # fmt: skip
    """The plants of the middle round, one for each contact of the cycle, in their order."""
    plants: list[Footplant] = []
    for e, effector in enumerate(contacts.effectors):
        own = [plant for plant in found if plant.effector == e]
        for c in effector.contacts:
            if c.wish == "forbid":
                continue
            a, b = c.start + start, c.end + start
            plant = next(p for p in own if p.start <= a and b <= p.end)
            held = [(max(s, a) - start, min(t, b) - start) for s, t in plant.held if s < b and t > a]
            plants.append(replace(
                plant, id=len(plants), start=c.start, end=c.end, held=tuple(h for h in held if h[1] > h[0])
            ))  # fmt: skip
    return tuple(plants)


def _notes(notes: Sequence[Note], middle: slice, length: int) -> tuple[Note, ...]:
    """The notes about the middle round."""
    found = []
    for note in notes:
        if note.start is None or note.end is None:
            found.append(note)
        elif note.start < middle.stop and note.end > middle.start:
            a, b = max(note.start - middle.start, 0), min(note.end - middle.start, length + 1)
            found.append(replace(note, start=a, end=b))
    return tuple(found)

"""Hold the plants of a closed cycle on several rounds end to end, so that plants across the seam are one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.correction import Correction, apply
from footfix.enforce.footplant import Footplant
from footfix.enforce.ground import GroundParams
from footfix.enforce.params import EnforceParams
from footfix.enforce.run import Enforcement, enforce
from footfix.enforce.task import ground_of
from footfix.locomotion.loop.closing import decay
from footfix.locomotion.loop.root_motion import Travel, carrier, root_in_world, with_root
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints
from footfix.motion.contacts import Contact, Contacts, Effector
from footfix.motion.kinematics import forward
from footfix.notes import Note
from footfix.rig.rig import Rig

_BESIDE = 1.5  # [s] of rounds on each side of the middle one: end effects of a correction fade in less
_RATE = 60.0  # [Hz] frame rate at which places of plants are found first
_OPEN = 4e-5  # [leg lengths] neighbouring rounds that differ less are equal
_KEEP = 1e-4  # [leg lengths] plants that slide no farther are unchanged; small, since a loop is seen repeatedly


@dataclass(frozen=True, eq=False)
class Held:
    """A closed cycle with held plants.

    Args:
        clip: L + 1 frames, the last of which is the first moved by the travel.
        found: plants, correction, notes and ground of the cycle.
    """

    clip: Clip
    found: Enforcement


def hold(clip: Clip, rig: Rig, contacts: Contacts, travel: Travel, params: EnforceParams) -> Held:
    """Hold the plants of a closed cycle, also across its seam.

    Places of plants are nearly, but not exactly, the same in the middle round and in its neighbours, since the
    outermost rounds have no continuation. So plants are held twice, the second time with the places of the middle round
    requested in all rounds. For the first time a lower frame rate is enough.

    Args:
        clip: L + 1 frames, the last of which is the first moved by `travel`.
        rig: its legs, soles and floor.
        contacts: of the cycle; the same at its last frame as at its first.
        travel: of one round.
        params: how footplants are enforced.
    """
    length, beside = len(clip) - 1, round(_BESIDE / clip.frame_time)
    rounds = max(1, -(-beside // length))  # on each side
    start = max(rounds * length - beside, 0)  # the outermost rounds are trimmed
    middle = slice(rounds * length - start, (rounds + 1) * length + 1 - start)
    long = lay(clip, carrier(clip, rig), travel, range(-rounds, rounds + 1))
    long = long.frames(slice(start, len(long) - start))
    keep = min(params.pins.keep_slide, _KEEP)
    strict = replace(params, cycle="no", pins=replace(params.pins, keep_slide=keep, keep_rested=False))
    planted = cropped(laid_contacts(contacts, 2 * rounds + 1), start, len(long))
    every = max(1, round(1.0 / (_RATE * clip.frame_time)))
    which = np.arange(middle.start % every, len(long), every)
    found = enforce(
        replace(long.frames(which), frame_time=every * clip.frame_time), rig,
        _as_contacts(contacts, thinned(planted, which), len(which), every), strict,
    )  # fmt: skip
    again = every > 1
    if not np.any(found.ground) and (again or _open(clip, rig, found, middle, travel) > _OPEN * rig.leg_length):
        planted, again = _placed(planted, found.plants, rounds, travel), True
    if again:
        found = enforce(long, rig, _as_contacts(contacts, planted, len(long)), strict)
    own = _closed(_cut(found.correction, middle), travel, clip)
    plants = _plants(found.plants, contacts, middle.start)
    ground = found.ground[middle] - found.ground[middle.start]
    notes = _notes(found.notes, middle, length)
    return Held(apply(clip, own), Enforcement(plants, own, notes, ground))


def ground_under(clip: Clip, rig: Rig, contacts: Contacts, travel: Travel, params: GroundParams) -> Floats:
    """Find the motion of the ground under the planted feet of a closed cycle (a treadmill), (L + 1, 3) [m].

    Args:
        clip: L + 1 frames, the last of which is the first moved by `travel`.
        rig: its legs and soles.
        contacts: of the cycle.
        travel: of one round.
        params: when the ground is a belt.
    """
    length = len(clip) - 1
    long = lay(clip, carrier(clip, rig), travel, range(-1, 2))
    found = ground_of(long, rig, _as_contacts(contacts, laid_contacts(contacts, 3), len(long)), params)
    return np.asarray(found[length : 2 * length + 1] - found[length])


def _cut(found: Correction, middle: slice) -> Correction:
    return Correction(found.root, found.root_shift[middle], found.joints, found.rotations[middle])


def _open(clip: Clip, rig: Rig, found: Enforcement, middle: slice, travel: Travel) -> float:
    """Measure the largest distance [m] of a leg joint from its place one round before, where rounds meet."""
    ends = apply(clip, _cut(found.correction, middle)).frames(np.array([0, len(clip) - 1]))
    places = forward(ends, rig.joints()).positions
    return float(np.linalg.norm(places[1] - travel.places(places[0]), axis=1).max())


def lay(clip: Clip, root: int, travel: Travel, rounds: range) -> Clip:
    """Lay rounds of a closed cycle end to end; round 0 is the cycle itself.

    Args:
        clip: L + 1 frames.
        root: the joint that carries the figure (`carrier`).
        travel: of one round.
        rounds: R of them.

    Returns:
        R L + 1 frames.
    """
    length = len(clip) - 1
    frames = np.append(np.tile(np.arange(length), len(rounds)), 0)
    place, turn = (np.array(each, order="F")[frames] for each in root_in_world(clip, root))
    for k, number in enumerate([*rounds, rounds.stop]):
        span = slice(k * length, min((k + 1) * length, len(frames)))
        for _ in range(abs(number)):
            if number > 0:
                place[span] = travel.places(place[span])
                turn[span] = rotation.multiply(travel.turn, turn[span])
            else:
                place[span] = travel.places_back(place[span])
                turn[span] = rotation.multiply(rotation.inverse(travel.turn), turn[span])
    return with_root(clip.frames(frames), root, place, turn)


@dataclass(frozen=True)
class Laid:
    """A contact in one of several rounds.

    Args:
        contact: in the frames of all rounds.
        round: its index from 0; for a contact across a seam the later round.
        key: the start frame of the cycle's contact that it repeats; -1 for one across the seam.
    """

    contact: Contact
    round: int
    key: int


def laid_contacts(contacts: Contacts, count: int) -> tuple[tuple[Laid, ...], ...]:
    """Repeat each effector's contacts of a closed cycle over some rounds; one across a seam is a single contact.

    Args:
        contacts: of L + 1 frames.
        count: rounds.
    """
    return tuple(_laid(effector, contacts.frames - 1, count) for effector in contacts.effectors)


def _laid(effector: Effector, length: int, count: int) -> tuple[Laid, ...]:
    ends = [c for c in effector.contacts if c.start == 0 or c.end == length + 1]
    inner = [c for c in effector.contacts if c not in ends]
    whole = [c for c in ends if c.start == 0 and c.end == length + 1]
    if whole:
        return (Laid(replace(whole[0], end=count * length + 1, position=None), 0, 0),)
    found = [
        Laid(replace(c, start=c.start + k * length, end=c.end + k * length, position=None), k, c.start)
        for k in range(count)
        for c in inner
    ]
    first = next((c for c in ends if c.start == 0), None)
    last = next((c for c in ends if c.start > 0), None)
    like = first or last
    for k in range(count + 1) if like is not None else ():  # the seam before round k
        start = max(k * length - (length - last.start if last is not None else 0), 0)
        end = min(k * length + (first.end if first is not None else 1), count * length + 1)
        sure = max(c.confidence for c in (first, last) if c is not None)
        if like is not None and end > start:
            found.append(Laid(replace(like, start=start, end=end, confidence=sure, position=None), k, -1))
    return tuple(sorted(found, key=lambda each: each.contact.start))


def cropped(planted: Sequence[Sequence[Laid]], start: int, frames: int) -> tuple[tuple[Laid, ...], ...]:
    """Crop contacts to some frames, counted from the first of these."""
    out = []
    for own in planted:
        spans = [(max(each.contact.start - start, 0), min(each.contact.end - start, frames)) for each in own]
        out.append(tuple(
            replace(each, contact=replace(each.contact, start=a, end=b))
            for each, (a, b) in zip(own, spans, strict=True)
            if b > a
        ))  # fmt: skip
    return tuple(out)


def thinned(planted: Sequence[Sequence[Laid]], which: Ints) -> tuple[tuple[Laid, ...], ...]:
    """Convert contacts to a subset of frames, each with at least one frame.

    Args:
        planted: in the frames of a clip.
        which: (n,) the frames, in order.
    """
    out = []
    for own in planted:
        spans = [np.searchsorted(which, (each.contact.start, each.contact.end)).tolist() for each in own]
        spans = [(min(a, len(which) - 1), b) for a, b in spans]
        out.append(tuple(
            replace(each, contact=replace(each.contact, start=a, end=max(b, a + 1)))
            for each, (a, b) in zip(own, spans, strict=True)
        ))  # fmt: skip
    return tuple(out)


def _as_contacts(contacts: Contacts, planted: Sequence[Sequence[Laid]], frames: int, every: int = 1) -> Contacts:
    """Make contacts from laid ones, for every frame or for a subset of frames."""
    effectors = tuple(
        replace(effector, contacts=tuple(each.contact for each in own))
        for effector, own in zip(contacts.effectors, planted, strict=True)
    )
    return replace(contacts, frames=frames, frame_time=every * contacts.frame_time, effectors=effectors)


def _placed(
    planted: Sequence[Sequence[Laid]], plants: Sequence[Footplant], middle: int, travel: Travel
) -> tuple[tuple[Laid, ...], ...]:  # fmt: skip
    """Request the places of the middle round's plants in all rounds, moved by the travel."""
    out, stood = [], iter(plants)
    for own in planted:
        targets = {}
        for each in own:
            if each.contact.wish != "forbid":
                plant = next(stood)
                if each.round == middle:
                    targets[each.key] = np.array(plant.target)
        placed = []
        for each in own:
            place = targets.get(each.key)
            if place is None or each.contact.wish == "forbid":
                placed.append(each)
                continue
            for _ in range(abs(each.round - middle)):
                place = travel.places(place) if each.round > middle else travel.places_back(place)
            x, y, z = place.tolist()
            placed.append(replace(each, contact=replace(each.contact, position=(x, y, z))))
        out.append(tuple(placed))
    return tuple(out)


def _closed(found: Correction, travel: Travel, clip: Clip) -> Correction:
    """Close the correction of a round: the remaining difference of its ends fades out from both."""
    half = 0.5 * (len(clip) - 1) * clip.frame_time
    fade = decay(len(clip), clip.frame_time, half, half)
    still = np.zeros(3)
    shift, turns = found.root_shift.copy(), found.rotations.copy()
    gap = rotation.rotate(rotation.inverse(travel.turn), shift[-1]) - shift[0]
    shift += fade.ahead(gap, still) + rotation.rotate(travel.turn, fade.behind(gap, still))
    shift[-1] = rotation.rotate(travel.turn, shift[0])
    for k in range(len(found.joints)):
        own = turns[:, k]
        gap = rotation.to_rotation_vector(rotation.multiply(own[-1], rotation.inverse(own[0])))
        off = rotation.from_rotation_vector(fade.ahead(gap, still) + fade.behind(gap, still))
        turns[:, k] = rotation.multiply(off, own)
        turns[-1, k] = turns[0, k]
    return replace(found, root_shift=shift, rotations=turns)


def _plants(found: Sequence[Footplant], contacts: Contacts, start: int) -> tuple[Footplant, ...]:
    """Get the plants of the middle round, one for each contact of the cycle, in order."""
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
                plant, asked=None, id=len(plants), start=c.start, end=c.end, held=tuple(h for h in held if h[1] > h[0])
            ))  # fmt: skip
    return tuple(plants)


def _notes(notes: Sequence[Note], middle: slice, length: int) -> tuple[Note, ...]:
    """Keep the notes about the middle round."""
    found = []
    for note in notes:
        if note.start is None or note.end is None:
            found.append(note)
        elif note.start < middle.stop and note.end > middle.start:
            a, b = max(note.start - middle.start, 0), min(note.end - middle.start, length + 1)
            found.append(replace(note, start=a, end=b))
    return tuple(found)

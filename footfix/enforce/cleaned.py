"""A clip that was cleaned before comes through as it is, but for what was put into it since."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce import outcomes
from footfix.enforce.foot import Foot
from footfix.enforce.legs import Held, enforced
from footfix.enforce.plants import PlantParams, Stance
from footfix.enforce.rest import EXACTLY, LEFT, SHARE, as_cleaned, locked, new_since, off_their_floor, resting
from footfix.enforce.solve import LegParams
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose
from footfix.notes import Note
from footfix.rig.rig import Rig

_MOST = 0.3  # of the stands: a clip of which more rest was cleaned as a whole; of captured ones hardly any do
_ROWS, _LOCKED = 3, 0.05  # and so was one with so many rows of frames at rest, in so much of the contacts' time
_GIVES = 0.25  # of stances that were put in together: where more give way, they were let go when the clip was cleaned
_ROUNDS = 3  # in which stances that give way are left out, before all are


def set_aside(
    pose: Pose, rig: Rig, contacts: Contacts, legs: Sequence[Foot], ride: Floats, stands: Sequence[Stance],
    notes: list[Note], method: str, params: PlantParams,
) -> tuple[list[Stance], bool]:  # fmt: skip
    """The stances, those that were cleaned before left as they are; and whether the whole clip was cleaned.

    None are where the cleaned ones rest a little off their floor: those have to be moved all the same. Where the clip
    was cleaned as a whole, stances that do not rest were let go then, and are let go again; but for several in a row,
    which were put in since.

    Args:
        pose: of the clip, from `foot.posed`.
        rig: its legs and soles.
        contacts: all of them.
        legs: their tracks.
        ride: (F, 3) [m] what takes the ground's own motion out.
        stands: from `plants.stances`.
        notes: one is added for a clip that was cleaned.
        method: of enforcement; by the root alone nothing can be held that is new.
        params: measures.
    """
    mask = contacts.mask()
    rests, exact = (
        {
            e: resting(
                pose.position(sole.joint) + ride, pose.rotation(sole.joint), np.asarray(sole.offset), mask[:, e],
                rig.leg_length, rest, share,
            )
            for e, sole in enumerate(rig.soles)
        }
        for rest, share in ((params.rest, SHARE), (EXACTLY * params.rest, 0.0))
    )  # fmt: skip
    if not any(np.any(each) for each in (*rests.values(), *exact.values())):
        return list(stands), False
    found = [as_cleaned(stance, legs[stance.leg], rests, params) for stance in stands]
    if off_their_floor(found, rig.floor, rig.leg_length, params):
        return list(stands), False
    cleaned = sum(stance.cleaned for stance in found)
    held = {
        e: locked(exact[e], foot.hip, contacts.frame_time, rig.leg_length) for foot in legs for e in foot.effectors
    }
    rows = [row for stance in found for row in _at_rest(stance, held)]
    time = sum(end - start for start, end in rows)
    if cleaned <= _MOST * len(found) and not (len(rows) >= _ROWS and time >= _LOCKED * np.count_nonzero(mask)):
        return found, False
    in_part = [stance.cleaned or bool(_at_rest(stance, held)) for stance in found]
    at_rest = f"{sum(in_part)} of {len(found)} stands rest already"
    notes.append(Note("cleaned-before", f"{at_rest}: this clip was cleaned before, and they stay as they are"))
    new = [0] * len(found) if method == "root" else new_since(found, in_part)
    left = []
    for stance, row in zip(found, new, strict=True):
        looked_at = stance.cleaned or row or any(plant.given for plant in stance.plants)
        left.append(replace(stance, row=row) if looked_at else stance.let_go(LEFT))
    return left, True


def _at_rest(stance: Stance, held: Mapping[int, Sequence[tuple[int, int]]]) -> list[tuple[int, int]]:
    """Those rows of frames `[start, end)` at rest, of each sole point, that the stance's found contacts have."""
    return [
        (start, end)
        for plant in stance.plants
        for start, end in held[plant.effector]
        if not plant.given and start < plant.contact.end and end > plant.contact.start
    ]


def as_rows(stands: Sequence[Stance]) -> list[Stance]:
    """The stances, those of a row let go of which many were: they were let go when the clip was cleaned."""
    hopeless = _hopeless(stands, [stance.released for stance in stands])
    return [stance.let_go(LEFT) if stance.row in hopeless else stance for stance in stands]


def _hopeless(stands: Sequence[Stance], gives: Sequence[bool]) -> set[int]:
    """The rows of which more than a few give way."""
    gone = Counter(stance.row for stance, each in zip(stands, gives, strict=True) if each)
    whole = Counter(stance.row for stance in stands)
    return {row for row in gone if row and gone[row] > _GIVES * whole[row]}


def easily(
    clip: Clip, rig: Rig, pose: Pose, legs: Sequence[Foot], stands: Sequence[Stance], params: LegParams
) -> tuple[Held, list[Stance]]:
    """What holds of a clip that was cleaned before, and the stances that are left as they are.

    A stance that gives way in the least was let go then, too.
    """
    held, left = list(stands), list[Stance]()
    for _ in range(_ROUNDS):
        done = enforced(clip, rig, pose, legs, held, params)
        easy = [_holds(old, new, done, rig, params.plants) for old, new in zip(held, done.stands, strict=True)]
        hopeless = _hopeless(held, [not each for each in easy])
        easy = [each and stance.row not in hopeless for stance, each in zip(held, easy, strict=True)]
        if all(easy):
            return done, left
        left += [stance.let_go(LEFT) for stance, each in zip(held, easy, strict=True) if not each]
        held = [stance for stance, each in zip(held, easy, strict=True) if each]
    left += [stance.let_go(LEFT) for stance in held if not _stays(stance)]
    return enforced(clip, rig, pose, legs, [stance for stance in held if _stays(stance)], params), left


def _stays(stance: Stance) -> bool:
    """Whether the stance is held however it goes."""
    return stance.cleaned or all(plant.kept or plant.given for plant in stance.plants)


def _holds(before: Stance, after: Stance, done: Held, rig: Rig, params: PlantParams) -> bool:
    """Whether the stance is held as it was asked for."""
    if _stays(before):
        return True
    if after is not before or np.any(done.soft[before.leg][before.frames]):
        return False
    off = outcomes.residual(rig, [after], done.points)
    return float(off.max()) <= params.holds * rig.leg_length

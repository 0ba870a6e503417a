"""A clip that was cleaned before comes through as it is, but for what was put into it since."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.enforce import outcomes
from footfix.enforce.foot import Foot
from footfix.enforce.legs import Held, enforced
from footfix.enforce.plants import PlantParams, Stance
from footfix.enforce.rest import LEFT, as_cleaned, new_since, off_their_floor, resting
from footfix.enforce.solve import LegParams
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose
from footfix.notes import Note
from footfix.rig.rig import Rig

_MOST = 0.3  # of the stands: a clip of which more rest was cleaned as a whole; of captured ones hardly any do
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
    rests = {
        e: resting(
            pose.position(sole.joint) + ride, pose.rotation(sole.joint), np.asarray(sole.offset), mask[:, e],
            rig.leg_length, params.rest,
        )
        for e, sole in enumerate(rig.soles)
    }  # fmt: skip
    if not any(np.any(each) for each in rests.values()):
        return list(stands), False
    found = [as_cleaned(stance, legs[stance.leg], rests, params) for stance in stands]
    if off_their_floor(found, rig.floor, rig.leg_length, params):
        return list(stands), False
    cleaned = sum(stance.cleaned for stance in found)
    if cleaned <= _MOST * len(found):
        return found, False
    text = f"{cleaned} of {len(found)} stands rest already: this clip was cleaned before, and they stay as they are"
    notes.append(Note("cleaned-before", text))
    new = [method != "root" and each for each in new_since(found)]
    return [
        stance if stance.cleaned or each or any(plant.given for plant in stance.plants) else stance.let_go(LEFT)
        for stance, each in zip(found, new, strict=True)
    ], True


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

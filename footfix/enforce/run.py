"""Enforce contacts: from contacts to footplants and a correction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.correction import Correction, apply
from footfix.enforce.cyclic_clip import correction_back, cycle_note, plants_back
from footfix.enforce.footplant import Footplant
from footfix.enforce.leg import tracks
from footfix.enforce.outcomes import CorrectedLeg, outcomes
from footfix.enforce.papers.glardon import GlardonParams
from footfix.enforce.papers.kim_neff import KimNeffParams
from footfix.enforce.papers.lyard import LyardRootParams
from footfix.enforce.params import EnforceParams
from footfix.enforce.style import StyleParams
from footfix.enforce.task import Task, pose_of, task_of
from footfix.enforce.whole_clip import correct_whole_clip
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.notes import Note
from footfix.rig.followers import Follower, find_followers, left_behind
from footfix.rig.repeated_rounds import Rounds, rounds_of
from footfix.rig.rig import Rig


@dataclass(frozen=True, eq=False)
class Enforcement:
    """The result of enforcement.

    Args:
        plants: every contact with its target place and outcome.
        correction: the changes to the clip.
        notes: for the user.
        ground: (F, 3) [m] intended motion of the ground under planted feet, as on a treadmill.
    """

    plants: tuple[Footplant, ...]
    correction: Correction
    notes: tuple[Note, ...]
    ground: Floats


def enforce(
    clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams, *, cut: tuple[bool, bool] = (False, False),
    leave: bool = False,
) -> Enforcement:  # fmt: skip
    """Hold the plants of a clip where they are planted.

    Args:
        clip: F frames, metres, y up, all of them motion.
        rig: its legs, soles and floor.
        contacts: when each sole point is planted; the effectors in the order of `rig.soles`.
        params: method and parameters.
        cut: whether frames of a T-pose were cut off before the first frame, and after the last.
        leave: whether to change nothing, because the clip is already the result of enforcement.

    Returns:
        The footplants, the correction, and notes. A clip that needs nothing gets a correction of zeros.
    """
    if leave:
        params = replace(params, method="ik", solver="whole_clip", heights="keep", style=StyleParams())
    by_paper = params.method == "root" or params.solver != "whole_clip"
    rounds = None if by_paper or any(cut) else rounds_of(clip, rig, params.cycle)
    if rounds:
        return _as_cycle(rounds, rig, contacts, params, leave)
    task = task_of(clip, rig, contacts, params)
    if leave:
        stays = tuple(replace(plant, asked=None, force=False) for plant in task.footing.plants)
        task = replace(task, footing=replace(task.footing, plants=stays, keep=(True,) * len(stays)))
    done, after = (_by_paper if by_paper else correct_whole_clip)(clip, rig, task, params, cut)
    followers = find_followers(clip, rig)
    done = replace(done, followers=followers)
    task = replace(task, notes=(*task.notes, *_followers_note(followers, clip), *left_behind(clip, rig, followers)))
    plants = outcomes(task.footing, task.legs, after, rig, clip.frame_time)
    return Enforcement(plants, done, task.notes, task.footing.ground)


def _followers_note(followers: Sequence[Follower], clip: Clip) -> tuple[Note, ...]:
    names = tuple(clip.skeleton.names[each.joint] for each in followers)
    if not names:
        return ()
    be = "a joint outside the legs is" if len(names) == 1 else f"{len(names)} joints outside the legs are"
    return (Note("followers", f"{be} where the feet are, and will go along: {', '.join(names)}", joints=names),)


def _by_paper(
    clip: Clip, rig: Rig, task: Task, params: EnforceParams, cut: tuple[bool, bool]
) -> tuple[Correction, list[CorrectedLeg]]:
    """Compute the correction by a paper's method, and the corrected legs."""
    way: Callable[..., Correction]
    own: GlardonParams | KimNeffParams | LyardRootParams
    if params.method == "root":
        from footfix.enforce.papers.lyard import correct as way

        own = params.root
    elif params.solver == "glardon":
        from footfix.enforce.papers.glardon import correct as way

        own = params.glardon
    else:
        from footfix.enforce.papers.kim_neff import correct as way

        own = params.kim_neff
    ground = task.footing.ground if np.any(task.footing.ground) else None
    lift = np.tile([0.0, task.lift, 0.0], (len(clip), 1))
    raised = apply(clip, Correction(rig.root, lift, (), np.zeros((len(clip), 0, 4))))
    done = way(raised, rig, task.footing.plants, own, ground=ground)
    done = _weakened(replace(done, root_shift=done.root_shift + lift), clip, params.strength)
    after = apply(clip, done)
    legs = tracks(after, rig, pose_of(after, rig), task.calibration)
    return done, [CorrectedLeg.of_tracks(leg) for leg in legs]


def _weakened(done: Correction, clip: Clip, strength: float) -> Correction:
    """Scale a correction by 0 to 1."""
    if strength == 1.0:
        return done
    captured = [clip.rotation(joint) for joint in done.joints]
    turned = [rotation.slerp(a, done.rotations[:, k], np.full(len(a), strength)) for k, a in enumerate(captured)]
    rotations = np.stack(turned, axis=1) if turned else done.rotations
    return replace(done, root_shift=strength * done.root_shift, rotations=rotations)


def _as_cycle(rounds: Rounds, rig: Rig, contacts: Contacts, params: EnforceParams, leave: bool) -> Enforcement:
    """Enforce the contacts of a cycle on repeated rounds of it."""
    found = enforce(rounds.clip, rig, rounds.contacts(contacts), replace(params, cycle="no"), leave=leave)
    return Enforcement(
        plants_back(found.plants, rounds, contacts, rig),
        correction_back(found.correction, rounds),
        (*rounds.notes_back(found.notes), cycle_note(rounds)),
        rounds.track_back(found.ground),
    )

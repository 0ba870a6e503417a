"""Enforcement: contacts in, footplants and a correction out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from footfix.enforce import ground as grounds
from footfix.enforce import mesh as meshes
from footfix.enforce import pins as pinning
from footfix.enforce.correction import Correction, apply
from footfix.enforce.cycle import correction_back, cycle_note, plants_back
from footfix.enforce.footplant import Footplant
from footfix.enforce.ground import GroundParams
from footfix.enforce.kept import faults, kept
from footfix.enforce.leg import (
    LegCalibration,
    LegTracks,
    Noise,
    calibrate,
    noise_of,
    raise_leg,
    tracks,
)
from footfix.enforce.outcomes import CorrectedLeg, outcomes
from footfix.enforce.papers.glardon import GlardonParams
from footfix.enforce.papers.kim_neff import KimNeffParams
from footfix.enforce.papers.lyard import LyardRootParams
from footfix.enforce.pins import Floors, PinParams
from footfix.enforce.posed import local_rotations
from footfix.enforce.problem import CostParams, Problem
from footfix.enforce.solve import solve
from footfix.enforce.style import StyleParams, styled
from footfix.enforce.vertices import Vertices
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose, forward
from footfix.notes import Note
from footfix.rig.followers import Follower, find_followers, left_behind
from footfix.rig.rig import Rig
from footfix.rig.rounds import Rounds, rounds_of

_FADE = (1e-5, 4e-5)  # [rad, leg lengths] a correction smaller than the first is none, and whole from the second on
_SHARED = 5.0  # times as far, and as fast, as otherwise the root goes where it shares the correction with the legs
_FEWEST = 4  # frames, of which accelerations can be told


@dataclass(frozen=True, kw_only=True)
class EnforceParams:
    """How footplants are enforced.

    Args:
        method: "ik" bends the legs, "root" moves the root alone, "both" gives the root what planted feet share and
            the legs the rest.
        solver: "whole_clip" is one least squares, "glardon" and "kim_neff" the papers' own ways.
        cycle: whether the last frame leads to the first, over a closed seam: "find", "yes" or "no"; "likely" is content
            with ends that nearly meet, in place, as in animations of games. For glTF files "find" means that.
        heights: "floor" draws plants to their floor, "keep" leaves them the height they have.
        strength: how much of the correction is applied, 0 to 1 [share].
        pins: when a plant is corrected, and what of it is held.
        costs: what each departure from the capture costs.
        ground: belts, and figures that float or are sunk.
        style: how planted feet stand otherwise than captured.
        glardon: the solver of that name.
        kim_neff: the solver of that name.
        root: method "root".
    """

    method: Literal["ik", "root", "both"] = "ik"
    solver: Literal["whole_clip", "glardon", "kim_neff"] = "whole_clip"
    cycle: Literal["find", "likely", "yes", "no"] = "find"
    heights: Literal["floor", "keep"] = "floor"
    strength: float = 1.0
    pins: PinParams = field(default_factory=PinParams)
    costs: CostParams = field(default_factory=CostParams)
    ground: GroundParams = field(default_factory=GroundParams)
    style: StyleParams = field(default_factory=StyleParams)
    glardon: GlardonParams = field(default_factory=GlardonParams)
    kim_neff: KimNeffParams = field(default_factory=KimNeffParams)
    root: LyardRootParams = field(default_factory=LyardRootParams)


@dataclass(frozen=True, eq=False)
class Enforcement:
    """What enforcement yields.

    Args:
        plants: every contact, where it stands and what became of it.
        correction: what is to change in the clip.
        notes: what a person should know.
        ground: (F, 3) [m] how far the ground under planted feet has moved on purpose, as on a treadmill.
    """

    plants: tuple[Footplant, ...]
    correction: Correction
    notes: tuple[Note, ...]
    ground: Floats


@dataclass(frozen=True, eq=False)
class Task:
    """What is to stand where.

    Args:
        pose: of the clip, from `pose_of`.
        calibration: what was measured of each leg on the whole clip.
        legs: as captured, raised by `lift`.
        plants: what is to stand.
        keep: for each plant whether it stands well enough.
        by_hand: for each plant whether its ends are certain.
        floors: the heights that joints stand at.
        ground: (F, 3) [m] displacement of the ground.
        lift: [m] by which the whole figure is raised.
        notes: what a person should know.
    """

    pose: Pose
    calibration: tuple[LegCalibration, ...]
    legs: tuple[LegTracks, ...]
    plants: tuple[Footplant, ...]
    keep: tuple[bool, ...]
    by_hand: tuple[bool, ...]
    floors: Floors
    ground: Floats
    lift: float
    notes: tuple[Note, ...]


def enforce(
    clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams, *, cut: tuple[bool, bool] = (False, False),
    leave: bool = False,
) -> Enforcement:  # fmt: skip
    """Hold the plants of a clip where they are planted.

    Args:
        clip: F frames, metres, y up, all of them motion.
        rig: its legs, soles and floor.
        contacts: when each sole point is planted; the effectors in the order of `rig.soles`.
        params: method and measures.
        cut: whether frames of a T-pose were cut off before the first frame, and after the last.
        leave: whether every plant stays as it is: the clip is what enforcement made of another.

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
        stays = tuple(replace(plant, asked=None, force=False) for plant in task.plants)
        task = replace(task, plants=stays, keep=(True,) * len(stays))
    done, after = (_by_paper if by_paper else _by_least_squares)(clip, rig, task, params, cut)
    followers = find_followers(clip, rig)
    done = replace(done, followers=followers)
    task = replace(task, notes=(*task.notes, *_followers_note(followers, clip), *left_behind(clip, rig, followers)))
    plants = outcomes(task.plants, task.legs, after, task.ground, task.keep, task.floors, rig, clip.frame_time)
    return Enforcement(plants, done, task.notes, task.ground)


def _followers_note(followers: Sequence[Follower], clip: Clip) -> tuple[Note, ...]:
    names = tuple(clip.skeleton.names[each.joint] for each in followers)
    if not names:
        return ()
    be = "a joint outside the legs is" if len(names) == 1 else f"{len(names)} joints outside the legs are"
    return (Note("followers", f"{be} where the feet are, and will go along: {', '.join(names)}", joints=names),)


def pose_of(clip: Clip, rig: Rig) -> Pose:
    """Compute forward kinematics of all that enforcement looks at: the rig's joints and what its legs hang from."""
    joints = set(rig.joints())
    for leg in rig.legs:
        hinged = [leg.hip, leg.knee, leg.ankle] + ([] if leg.toe is None else [leg.toe])
        joints.update(int(clip.skeleton.parents[joint]) for joint in hinged)
    return forward(clip, sorted(joints - {-1}))


def ground_of(clip: Clip, rig: Rig, contacts: Contacts, params: GroundParams) -> Floats:
    """Find how far the ground under planted feet has moved on purpose, (F, 3) [m]; zeros on a floor at rest."""
    return grounds.belt(rig, rig.pose(clip), contacts, clip.frame_time, params)


def task_of(clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams) -> Task:
    """What is to stand where in a clip of F frames, by its contacts."""
    pose = pose_of(clip, rig)
    calibration = calibrate(rig, pose, clip)
    legs = tracks(clip, rig, pose, calibration)
    plants, notes = pinning.footplants(contacts, rig, legs, params.pins)
    ground = grounds.belt(rig, pose, contacts, clip.frame_time, params.ground)
    notes += grounds.belt_notes(ground, clip.frame_time)
    lift = 0.0
    if params.heights == "floor" and params.method != "root" and clip.skeleton.translates[rig.root]:
        lift = grounds.lift(pinning.lacks(plants, legs, rig), rig.leg_length, params.ground)
    if lift:
        legs = tuple(raise_leg(leg, lift) for leg in legs)
        text = f"the whole figure is {'raised' if lift > 0 else 'lowered'} by {1000.0 * abs(lift):.0f} mm to its floor"
        notes += (Note("height-moved", text),)
    floors = pinning.floors(plants, legs, rig, params.pins)
    plants = styled(plants, legs, rig, floors, params.style)
    keep = kept(
        plants, legs, ground, floors, clip.frame_time, rig.leg_length,
        heights=params.heights == "floor", params=params.pins,
    )  # fmt: skip
    if rig.meshes and params.heights == "floor":
        deep = meshes.sunk(plants, rig, pose, lift, floors, params.pins.near * rig.leg_length)
        keep = tuple(stays and not sinks for stays, sinks in zip(keep, deep.tolist(), strict=True))
    by_hand = tuple(pinning.given(contacts, plant) for plant in plants)
    return Task(pose, calibration, legs, plants, keep, by_hand, floors, ground, lift, notes)


def _by_paper(
    clip: Clip, rig: Rig, task: Task, params: EnforceParams, cut: tuple[bool, bool]
) -> tuple[Correction, list[CorrectedLeg]]:
    """The correction by a paper's own way, and the legs as it leads them."""
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
    ground = task.ground if np.any(task.ground) else None
    lift = np.tile([0.0, task.lift, 0.0], (len(clip), 1))
    raised = apply(clip, Correction(rig.root, lift, (), np.zeros((len(clip), 0, 4))))
    done = way(raised, rig, task.plants, own, ground=ground)
    done = _weakened(replace(done, root_shift=done.root_shift + lift), clip, params.strength)
    after = apply(clip, done)
    legs = tracks(after, rig, pose_of(after, rig), task.calibration)
    return done, [CorrectedLeg.of_tracks(leg) for leg in legs]


def _weakened(done: Correction, clip: Clip, strength: float) -> Correction:
    """A share of a correction, 0 to 1."""
    if strength == 1.0:
        return done
    captured = [clip.turn(joint) for joint in done.joints]
    turned = [rotation.slerp(a, done.rotations[:, k], np.full(len(a), strength)) for k, a in enumerate(captured)]
    rotations = np.stack(turned, axis=1) if turned else done.rotations
    return replace(done, root_shift=strength * done.root_shift, rotations=rotations)


def _by_least_squares(
    clip: Clip, rig: Rig, task: Task, params: EnforceParams, cut: tuple[bool, bool]
) -> tuple[Correction, list[CorrectedLeg]]:
    """The correction by one least squares over the whole clip, and the legs as it leads them."""
    problem = problem_of(clip, rig, task, params, cut)
    columns = [problem.columns(k) for k in range(len(task.legs))]
    x = np.zeros((problem.unknowns, len(clip)))
    wanted = any(plant.asked for plant in task.plants) or not all(task.keep)
    wanted = wanted or meshes.too_deep(problem.skins, task.legs, rig.leg_length)
    if wanted and len(clip) >= _FEWEST:
        x = faded(solve(problem), problem)
    x = params.strength * x
    less = (params.strength - 1.0) * task.lift * np.array([[0.0], [1.0], [0.0]])  # the legs are raised by all of it
    after = [CorrectedLeg.of_state(leg, x[:3] + less, x[own]) for leg, own in zip(task.legs, columns, strict=True)]
    shift = x[:3].T + np.array([0.0, params.strength * task.lift, 0.0])
    return correction(clip, rig, task.pose, task.legs, x, columns, shift), after


def _as_cycle(rounds: Rounds, rig: Rig, contacts: Contacts, params: EnforceParams, leave: bool) -> Enforcement:
    """The enforcement of a cycle, on rounds of it laid end to end."""
    found = enforce(rounds.clip, rig, rounds.contacts(contacts), replace(params, cycle="no"), leave=leave)
    return Enforcement(
        plants_back(found.plants, rounds, contacts, rig),
        correction_back(found.correction, rounds),
        (*rounds.notes_back(found.notes), cycle_note(rounds)),
        rounds.track_back(found.ground),
    )


def problem_of(clip: Clip, rig: Rig, task: Task, params: EnforceParams, cut: tuple[bool, bool]) -> Problem:
    """Lay out the objective of a clip."""
    costs, heights = costs_of(params), params.heights == "floor"
    pins = tuple(
        pinning.pins(
            task.plants, leg, k, rig, task.ground, task.floors, task.keep, task.by_hand, clip.frame_time,
            heights=heights, params=params.pins,
        )
        for k, leg in enumerate(task.legs)
    )  # fmt: skip
    skins: dict[int, Vertices] = {}
    if rig.meshes and heights:
        steps = meshes.steps_of(rig, [_step(task, k, rig, params.pins) for k in range(len(pins))])
        pins = meshes.over_floor(pins, rig, task.pose, steps)
        skins = meshes.skins_of(rig, task.legs, task.pose, task.lift, steps, clip.skeleton)
    noise, white = noises(task, rig)
    moves = bool(clip.skeleton.translates[rig.root])
    fault = faults(
        task.plants, task.legs, task.ground, task.floors, task.keep, clip.frame_time, heights=heights,
        edge=params.pins.edge,
    )  # fmt: skip
    fault = meshes.deeper(fault, skins, task.legs, clip.frame_time)
    return Problem(
        task.legs, pins, clip.frame_time, rig.leg_length, costs, noise, white, fault, moves, cut, skins=skins
    )


def _step(task: Task, number: int, rig: Rig, params: PinParams) -> Floats:
    """(F,) [m] how much higher than the rig's the floor under the foot of a leg is."""
    own = [plant for plant in task.plants if plant.leg == number]
    return pinning.floor_steps(own, task.floors, len(task.pose.positions), params.near * rig.leg_length)


def costs_of(params: EnforceParams) -> CostParams:
    """What departures cost: less of the root where it shares the correction with the legs."""
    if params.method != "both":
        return params.costs
    wider = ("root", "root_height", "root_acceleration", "root_farthest")
    return replace(params.costs, **{name: _SHARED * getattr(params.costs, name) for name in wider})


def noises(task: Task, rig: Rig) -> tuple[Floats, Bools]:
    """(U,) [m, rad] noise of the capture in each unknown, and (U,) whether it is all of the quickest changes."""
    own = [noise_of(task.pose.position(rig.root))] * 3
    for each in task.calibration:
        line, knee, foot = each.noise
        own += [line, line, line, knee, foot, foot, foot, Noise(0.0, False)]
    return np.array([each.sigma for each in own]), np.array([each.white for each in own])


def faded(x: Floats, problem: Problem) -> Floats:
    """(U, F) a state without what is too small to be seen, so that frames which nothing needs keep their numbers."""
    out = x.copy()
    blocks = [(slice(0, 3), problem.leg_length), *((problem.columns(k), 1.0) for k in range(len(problem.legs)))]
    for rows, size in blocks:
        large = np.abs(x[rows]).max(axis=0) / size
        u = np.clip((large - _FADE[0]) / (_FADE[1] - _FADE[0]), 0.0, 1.0)
        out[rows] *= (3.0 - 2.0 * u) * u * u
    return out


def correction(
    clip: Clip, rig: Rig, pose: Pose, legs: Sequence[LegTracks], x: Floats, columns: Sequence[slice], shift: Floats
) -> Correction:
    """Turn a state (U, F), and a shift of the root (F, 3) [m], into a correction of the clip."""
    joints: list[int] = []
    rotations: list[Floats] = []
    for leg, own in zip(legs, columns, strict=True):
        changed = np.any(x[own] != 0.0, axis=0)
        if not np.any(changed):
            continue
        for joint, turn in local_rotations(clip, pose, leg, x[own]).items():
            joints.append(joint)
            rotations.append(np.where(changed[:, None], turn, clip.turn(joint)))
    stacked = np.stack(rotations, axis=1) if rotations else np.zeros((len(clip), 0, 4))
    return Correction(rig.root, shift, tuple(joints), stacked)

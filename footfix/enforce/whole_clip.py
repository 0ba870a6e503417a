"""The solver `whole_clip`: one least-squares problem over all frames, and its solution as a correction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from footfix.enforce import mesh_floor as meshes
from footfix.enforce.correction import Correction
from footfix.enforce.costs import CostParams
from footfix.enforce.leg import LegTracks, Noise, noise_of
from footfix.enforce.leg_state import local_rotations
from footfix.enforce.outcomes import CorrectedLeg
from footfix.enforce.params import EnforceParams
from footfix.enforce.pins import PinParams
from footfix.enforce.pins import pins as pins_of
from footfix.enforce.plant_faults import faults
from footfix.enforce.problem import Problem
from footfix.enforce.slow_feet import slow_toes
from footfix.enforce.solve import solve
from footfix.enforce.standing_heights import floor_steps
from footfix.enforce.task import Task
from footfix.enforce.vertices import Vertices
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.kinematics import Pose
from footfix.motion.threads import at_once
from footfix.rig.rig import Rig

_FADE = (1e-5, 4e-5)  # [rad, leg lengths] corrections below the first are dropped; above the second they are full
_SHARED = 5.0  # factor on the root's standard deviations and bound where it shares the correction with the legs
_FEWEST = 4  # least number of frames, for accelerations


def correct_whole_clip(
    clip: Clip, rig: Rig, task: Task, params: EnforceParams, cut: tuple[bool, bool]
) -> tuple[Correction, list[CorrectedLeg]]:
    """Correct a clip by one least squares over all of it.

    Args:
        clip: F frames.
        rig: its legs and soles.
        task: the plants of the clip and where they stand.
        params: the costs, and how much of the correction is applied.
        cut: whether frames of a T-pose were cut off before the first frame, and after the last.

    Returns:
        The correction, and the corrected legs.
    """
    problem = problem_of(clip, rig, task, params, cut)
    columns = [problem.columns(k) for k in range(len(task.legs))]
    x = np.zeros((problem.unknowns, len(clip)))
    wanted = any(plant.asked for plant in task.footing.plants) or not all(task.footing.keep)
    wanted = wanted or meshes.too_deep(problem.skins, task.legs, rig.leg_length)
    if wanted and len(clip) >= _FEWEST:
        x = faded(solve(problem), problem)
    x = params.strength * x
    less = (params.strength - 1.0) * task.lift * np.array([[0.0], [1.0], [0.0]])  # the legs are raised by all of it
    after = [CorrectedLeg.of_state(leg, x[:3] + less, x[own]) for leg, own in zip(task.legs, columns, strict=True)]
    shift = x[:3].T + np.array([0.0, params.strength * task.lift, 0.0])
    return correction(clip, rig, task.pose, task.legs, x, columns, shift), after


def problem_of(clip: Clip, rig: Rig, task: Task, params: EnforceParams, cut: tuple[bool, bool]) -> Problem:
    """Lay out the objective of a clip."""
    costs, heights = costs_of(params), params.heights == "floor"
    pins = tuple(at_once([
        partial(pins_of, task.footing, leg, k, rig, clip.frame_time, heights=heights, params=params.pins)
        for k, leg in enumerate(task.legs)
    ], len(clip)))  # fmt: skip
    steps = [_step(task, k, rig, params.pins) for k in range(len(pins))]
    pins = tuple(
        slow_toes(own, leg, task.footing.ground, step, clip.frame_time, rig.leg_length)
        for own, leg, step in zip(pins, task.legs, steps, strict=True)
    )
    skins: dict[int, Vertices] = {}
    if rig.meshes and heights:
        steps = meshes.steps_of(rig, steps)
        pins = meshes.over_floor(pins, rig, task.pose, steps)
        skins = meshes.skins_of(rig, task.legs, task.pose, task.lift, steps, clip.skeleton)
    noise, white = noises(task, rig)
    moves = bool(clip.skeleton.translates[rig.root])
    fault = faults(task.footing, task.legs, clip.frame_time, heights=heights, edge=params.pins.edge)
    fault = meshes.deeper(fault, skins, task.legs, clip.frame_time)
    return Problem(
        task.legs, pins, clip.frame_time, rig.leg_length, costs, noise, white, fault, moves, cut, skins=skins
    )


def _step(task: Task, number: int, rig: Rig, params: PinParams) -> Floats:
    """Compute how much higher than the rig's floor the floor under a leg's foot is, (F,) [m]."""
    own = task.footing.of_leg(number)
    return floor_steps(own, task.footing.floors, len(task.pose.positions), params.near * rig.leg_length)


def costs_of(params: EnforceParams) -> CostParams:
    """Choose the costs: lower ones of the root where it shares the correction with the legs."""
    if params.method != "both":
        return params.costs
    wider = ("root", "root_height", "root_acceleration", "root_farthest")
    return replace(params.costs, **{name: _SHARED * getattr(params.costs, name) for name in wider})


def noises(task: Task, rig: Rig) -> tuple[Floats, Bools]:
    """Estimate the noise in each unknown (U,) [m, rad], and whether the fastest changes are all noise (U,)."""
    own = [noise_of(task.pose.position(rig.root))] * 3
    for each in task.calibration:
        line, knee, foot = each.noise
        own += [line, line, line, knee, foot, foot, foot, Noise(0.0, False)]
    return np.array([each.sigma for each in own]), np.array([each.white for each in own])


def faded(x: Floats, problem: Problem) -> Floats:
    """Drop invisibly small parts of a state (U, F), so that frames that need no correction stay unchanged."""
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
            rotations.append(np.where(changed[:, None], turn, clip.rotation(joint)))
    stacked = np.stack(rotations, axis=1) if rotations else np.zeros((len(clip), 0, 4))
    return Correction(rig.root, shift, tuple(joints), stacked)

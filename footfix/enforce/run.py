"""Enforcement: contacts in, footplants and a correction out."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from footfix.enforce import ground as grounds
from footfix.enforce import pins as pinning
from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant
from footfix.enforce.ground import GroundParams
from footfix.enforce.leg import LegTracks, calibrate, local_rotations, noise_of, tracks
from footfix.enforce.outcomes import outcomes
from footfix.enforce.pins import PinParams
from footfix.enforce.problem import CostParams, Problem
from footfix.enforce.solve import solve
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose, forward
from footfix.notes import Note
from footfix.rig.rig import Rig

_FADE = (1e-5, 4e-5)  # [rad, leg lengths] a correction smaller than the first is none, and whole from the second on


@dataclass(frozen=True, kw_only=True)
class EnforceParams:
    """How footplants are enforced."""

    method: Literal["ik", "root", "both"] = "ik"  # the legs, the root's translation alone, or shared between them
    heights: Literal["floor", "keep"] = "floor"  # plants are drawn to their floor, or keep the height they have
    strength: float = 1.0  # 0 to 1: how much of the correction is applied
    pins: PinParams = field(default_factory=PinParams)
    costs: CostParams = field(default_factory=CostParams)
    ground: GroundParams = field(default_factory=GroundParams)


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


def enforce(
    clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams, *, cut: tuple[bool, bool] = (False, False)
) -> Enforcement:
    """Hold the plants of a clip where they are planted.

    Args:
        clip: F frames, metres, y up, all of them motion.
        rig: its legs, soles and floor.
        contacts: when each sole point is planted; the effectors in the order of `rig.soles`.
        params: method and measures.
        cut: whether frames of a T-pose were cut off before the first frame, and after the last.

    Returns:
        The footplants, the correction, and notes. A clip that needs nothing gets a correction of zeros.
    """
    pose = posed(clip, rig)
    calibration = calibrate(rig, pose, clip)
    legs = tracks(clip, rig, pose, calibration)
    plants = pinning.footplants(contacts, rig)
    ground = grounds.belt(rig, pose, contacts, clip.frame_time, params.ground)
    notes = list(_belt_note(ground, clip.frame_time))
    floors = pinning.floors(plants, legs, rig, params.pins)
    heights = params.heights == "floor"
    keep = pinning.kept(
        plants, legs, ground, floors, clip.frame_time, rig.leg_length, heights=heights, params=params.pins
    )
    by_hand = [pinning.given(contacts, plant) for plant in plants]
    pins = tuple(
        pinning.pins(
            plants, leg, k, rig, ground, floors, keep, by_hand, clip.frame_time, heights=heights, params=params.pins
        )
        for k, leg in enumerate(legs)
    )
    noise = np.concatenate([
        np.full(3, noise_of(pose.position(rig.root))),
        *(np.append(np.repeat(each.noise, [3, 1, 3]), 0.0) for each in calibration),
    ])  # fmt: skip
    problem = Problem(
        legs, pins, clip.frame_time, rig.leg_length, params.costs, noise, bool(clip.skeleton.translates[rig.root]), cut
    )
    x = np.zeros((problem.unknowns, len(clip)))
    if not all(keep) or any(plant.asked for plant in plants):
        x = solve(problem)
    columns = [problem.columns(k) for k in range(len(legs))]
    found = outcomes(
        plants, legs, x, columns, ground, keep, floors, rig.floor, clip.frame_time, rig.leg_length
    )
    x = params.strength * _faded(x, problem)
    return Enforcement(found, correction(clip, rig, pose, legs, x, columns), tuple(notes), ground)


def posed(clip: Clip, rig: Rig) -> Pose:
    """Forward kinematics of all that enforcement looks at: the rig's joints and what its legs hang from."""
    joints = set(rig.joints())
    for leg in rig.legs:
        hinged = [leg.hip, leg.knee, leg.ankle] + ([] if leg.toe is None else [leg.toe])
        joints.update(int(clip.skeleton.parents[joint]) for joint in hinged)
    return forward(clip, sorted(joints - {-1}))


def _faded(x: Floats, problem: Problem) -> Floats:
    """(U, F) a state without what is too small to be seen, so that frames which nothing needs keep their numbers."""
    out = x.copy()
    blocks = [(slice(0, 3), problem.leg_length), *((problem.columns(k), 1.0) for k in range(len(problem.legs)))]
    for rows, size in blocks:
        large = np.abs(x[rows]).max(axis=0) / size
        u = np.clip((large - _FADE[0]) / (_FADE[1] - _FADE[0]), 0.0, 1.0)
        out[rows] *= (3.0 - 2.0 * u) * u * u
    return out


def correction(
    clip: Clip, rig: Rig, pose: Pose, legs: tuple[LegTracks, ...], x: Floats, columns: list[slice]
) -> Correction:
    """Turn a state (U, F) into a correction of the clip."""
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
    return Correction(rig.root, x[:3].T, tuple(joints), stacked)


def _belt_note(ground: Floats, frame_time: float) -> list[Note]:
    moves = np.any(np.diff(ground, axis=0) != 0.0, axis=1)
    if not np.any(moves):
        return []
    speed = float(np.median(np.linalg.norm(np.diff(ground, axis=0)[moves], axis=1))) / frame_time
    where = "" if moves.all() else f" for {np.count_nonzero(moves) * frame_time:.1f} s"
    text = f"the figure stays in place{where}: planted feet are taken along at {speed:.2f} m/s, as on a belt"
    return [Note("in-place", text)]

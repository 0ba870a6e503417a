"""Enforcement: contacts in, footplants and a correction out."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from footfix.enforce import ik, reach, root
from footfix.enforce.correction import Correction
from footfix.enforce.ease import EaseParams
from footfix.enforce.foot import Foot, can_turn, feet, posed
from footfix.enforce.footplant import Footplant, Outcome
from footfix.enforce.plants import Plant, PlantParams, Stance, aimed, stances
from footfix.enforce.reach import ReachParams
from footfix.enforce.root import RootParams
from footfix.enforce.targets import goals
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose
from footfix.notes import Note
from footfix.rig.rig import Rig


@dataclass(frozen=True, kw_only=True)
class EnforceParams:
    """How footplants are enforced."""

    method: Literal["ik", "root", "both"] = "ik"  # the legs, the root's translation alone, or shared between them
    strength: float = 1.0  # 0 to 1: how much of the correction is applied
    plants: PlantParams = field(default_factory=PlantParams)
    ease: EaseParams = field(default_factory=EaseParams)
    reach: ReachParams = field(default_factory=ReachParams)
    root: RootParams = field(default_factory=RootParams)


@dataclass(frozen=True, eq=False)
class Enforcement:
    """What enforcement yields.

    Args:
        plants: every contact, where it was to stand and what became of it.
        correction: what is to change in the clip.
        notes: what a person should know.
    """

    plants: tuple[Footplant, ...]
    correction: Correction
    notes: tuple[Note, ...] = ()


def enforce(clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams) -> Enforcement:
    """Hold the plants of a clip where they are planted.

    Args:
        clip: F frames, metres, y up.
        rig: its legs, soles and floor.
        contacts: when each sole point is planted; the effectors in the order of `rig.soles`.
        params: method and measures.

    Returns:
        The footplants, the correction, and notes. A clip that needs nothing gets a correction of zeros.
    """
    pose = posed(clip, rig)
    legs = feet(rig, pose)
    notes: list[Note] = []
    stands = []
    for stance in stances(contacts, legs):
        foot = legs[stance.leg]
        stance = aimed(stance, foot, rig.floor, rig.leg_length, params.plants)
        stands.append(_released_if_far(stance, foot, rig.leg_length, params.plants))
    if params.method == "root":
        shift = _root_shift(rig, pose, legs, stands, clip.frame_time, params)
        return _root_only(rig, legs, stands, shift, clip, notes)
    return _by_legs(clip, rig, pose, legs, stands, params, notes)


def _released_if_far(stance: Stance, foot: Foot, leg_length: float, params: PlantParams) -> Stance:
    """The stance given up as a whole where a plant of it would have to move too far."""
    for plant in stance.plants:
        if plant.contact.wish == "force":
            return stance
        far = float(np.linalg.norm(foot.point(plant.part)[plant.frames] - plant.target, axis=1).max())
        if far > params.max_shift * leg_length:
            reason = f"slides so far that it seems meant: {far:.2f} m from where it would stand"
            return replace(stance, plants=tuple(replace(p, reason=reason) for p in stance.plants))
    return stance


def _by_legs(
    clip: Clip,
    rig: Rig,
    pose: Pose,
    legs: tuple[Foot, ...],
    stands: list[Stance],
    params: EnforceParams,
    notes: list[Note],
) -> Enforcement:
    able = [can_turn(clip, foot.leg) for foot in legs]
    wanted = [
        goals(
            foot,
            [s for s in stands if s.leg == k and able[k] and not s.plants[0].reason],
            clip.frame_time,
            params.ease,
        )
        for k, foot in enumerate(legs)
    ]
    wanted = [replace(g, turn=params.strength * g.turn, shift=params.strength * g.shift) for g in wanted]
    shift = np.zeros((len(clip), 3))
    if params.method == "both":
        planted, shifts = [g.planted for g in wanted], [g.shift for g in wanted]
        shift = root.shared(planted, shifts, clip.frame_time, params.ease, params.root)
    limits = tuple(
        reach.allowed(foot, foot.hip + shift, goal.ankle(foot), params.reach)
        for foot, goal in zip(legs, wanted, strict=True)
    )
    if clip.skeleton.translates[rig.root]:
        shift[:, 1] -= reach.lowering(
            legs,
            tuple(foot.hip + shift for foot in legs),
            tuple(goal.ankle(foot) for foot, goal in zip(legs, wanted, strict=True)),
            limits,
            tuple(goal.planted for goal in wanted),
            clip.frame_time,
            rig.leg_length,
            params.reach,
        )
    residual = np.zeros((len(clip), len(rig.soles)))
    joints: list[int] = []
    columns: list[Floats] = []
    for k, (foot, goal, limit) in enumerate(zip(legs, wanted, limits, strict=True)):
        changed = np.any(goal.shift != 0.0, axis=1) | np.any(goal.turn != 0.0, axis=1) | np.any(shift != 0.0, axis=1)
        ankle = reach.clamp(foot.hip + shift, goal.ankle(foot), limit)
        if able[k] and np.any(changed):
            axis = ik.knee_axis(foot, pose.rotation(foot.leg.hip))
            turns = ik.two_bones(foot, axis, foot.hip + shift, ankle)
            for joint, q in ik.local_rotations(clip, pose, foot, turns, goal.foot_turn(foot)).items():
                joints.append(joint)
                columns.append(np.where(changed[:, None], q, clip.rotations[:, joint]))
        for part, e in zip(("heel", "toe"), foot.effectors, strict=True):
            at_foot = foot.heel_in_foot if part == "heel" else foot.ball_in_foot
            point = ankle + rotation.rotate(goal.foot_turn(foot), at_foot)
            _measure(residual[:, e], point, [p for s in stands if s.leg == k for p in s.parts(part)])
    rotations = np.stack(columns, axis=1) if columns else np.zeros((len(clip), 0, 4))
    correction = Correction(rig.root, shift, tuple(joints), rotations, residual)
    return Enforcement(_footplants(rig, stands, residual, params.strength), correction, tuple(notes))


def _measure(residual: Floats, point: Floats, plants: list[Plant]) -> None:
    """Fill in (F,) [m] how far a sole point stays from its targets."""
    for plant in plants:
        residual[plant.frames] = np.linalg.norm(point[plant.frames] - plant.target, axis=1)


def _root_shift(
    rig: Rig, pose: Pose, legs: tuple[Foot, ...], stands: list[Stance], frame_time: float, params: EnforceParams
) -> Floats:
    """(F, 3) [m] Lyard's correction; zero where everything stands well enough."""
    frames = len(legs[0])
    planted = np.zeros((frames, len(rig.soles)), dtype=np.bool_)
    levels = np.full((frames, len(rig.soles)), rig.floor)
    for stance in stands:
        for plant in stance.plants:
            planted[plant.frames, plant.effector] = True
            levels[plant.frames, plant.effector] = stance.level
    if all(plant.kept for stance in stands for plant in stance.plants):
        return np.zeros((frames, 3))
    shift = root.correction(
        pose.position(rig.root), rig.tracks(pose), planted, levels, frame_time, rig.leg_length, params.root
    )
    return params.strength * shift


def _root_only(
    rig: Rig, legs: tuple[Foot, ...], stands: list[Stance], shift: Floats, clip: Clip, notes: list[Note]
) -> Enforcement:
    residual = np.zeros((len(clip), len(rig.soles)))
    plants = []
    for stance in stands:
        foot = legs[stance.leg]
        for plant in stance.plants:
            track = foot.point(plant.part)[plant.frames] + shift[plant.frames]
            target = np.median(track, axis=0)
            residual[plant.frames, plant.effector] = np.linalg.norm(track - target, axis=1)
            plants.append(replace(plant, target=target, reason="", kept=False))
    correction = Correction(rig.root, shift, (), np.zeros((len(clip), 0, 4)), residual)
    whole = [Stance(0, tuple(plants))] if plants else []
    return Enforcement(_footplants(rig, whole, residual, 1.0), correction, tuple(notes))


def _footplants(
    rig: Rig, stands: list[Stance], residual: Floats, strength: float
) -> tuple[Footplant, ...]:
    """What became of each contact, by effector and time."""
    made = []
    for stance in stands:
        for plant in stance.plants:
            far = float(residual[plant.frames, plant.effector].max())
            outcome: Outcome = "pinned"
            reason = plant.reason
            if plant.reason:
                outcome = "released"
            elif plant.kept:
                outcome = "kept"
            elif far > 0.002 * rig.leg_length:
                outcome = "partly"
                reason = f"stays up to {1000.0 * far:.0f} mm away"
            x, y, z = (float(v) for v in plant.target)
            made.append(
                (
                    plant.effector,
                    Footplant(
                        rig.soles[plant.effector].name, plant.contact.start, plant.contact.end,
                        plant.contact.confidence, (x, y, z), outcome, reason, far,
                    ),
                )
            )  # fmt: skip
    made.sort(key=lambda pair: (pair[0], pair[1].start))
    return tuple(plant for _, plant in made)



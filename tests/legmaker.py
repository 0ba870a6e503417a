"""Legs of all kinds for the tests of enforcement: more joints than three, a split pelvis, feet without toes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import exports
import numpy as np
from walks import rig_of, walk

from footfix.enforce.leg import LegCalibration, LegTracks, calibrate, tracks
from footfix.enforce.task import pose_of
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats, Skeleton
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Leg, Rig, SolePoint

KINDS = ("plain", "twists", "split pelvis", "four bones", "no toes", "long foot", "stiff toes", "bare toes")


@dataclass(frozen=True, eq=False)
class Figure:
    """A walker of some kind with its true contacts, and its legs as enforcement lays them out."""

    clip: Clip
    rig: Rig
    contacts: Contacts
    pose: Pose
    calibration: tuple[LegCalibration, ...]
    legs: tuple[LegTracks, ...]


def figure_of(clip: Clip, rig: Rig, contacts: Contacts) -> Figure:
    pose = pose_of(clip, rig)
    calibration = calibrate(rig, pose, clip)
    return Figure(clip, rig, contacts, pose, calibration, tracks(clip, rig, pose, calibration))


@cache
def figure(kind: str = "plain", name: str = "walk", fps: float = 60.0, duration: float = 3.0) -> Figure:
    """A walker whose legs are of one of `KINDS`; sole points are where the plain walker's are."""
    made = walk(name, fps, duration)
    return figure_of(*changed(kind, made.clip, rig_of(made)), made.contacts)


def changed(kind: str, clip: Clip, plain: Rig) -> tuple[Clip, Rig]:
    """A walker's clip with legs of one of `KINDS`, and its rig."""
    frames = len(clip)
    swing = 0.1 * np.sin(3.0 * np.arange(frames) * clip.frame_time)  # [rad]
    if kind == "twists":
        clip = exports.with_twists(clip)
    for side in ("Left", "Right"):
        if kind == "split pelvis":
            turn = rotation.from_axis_angle(np.array([0.0, 0.6, 0.8]), swing)
            clip = inserted(clip, side + "Pelvis", side + "UpLeg", 0.4, turn)
        if kind == "four bones":  # a hock that bends between knee and ankle
            turn = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), swing - 0.4)
            clip = inserted(clip, side + "Hock", side + "Foot", 0.6, turn)
        if kind == "long foot":
            turn = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), swing)
            clip = inserted(clip, side + "Mid", side + "ToeBase", 0.5, turn)
    if kind == "no toes":
        clip = exports.without_toes(clip)
    if kind == "stiff toes":
        rotates = clip.skeleton.rotates.copy()
        rotates[[j for j, name in enumerate(clip.skeleton.names) if name.endswith("ToeBase")]] = False
        clip = replace(clip, skeleton=replace(clip.skeleton, rotates=rotates))
    if kind == "bare toes":  # nothing beyond the toe joint
        skeleton = clip.skeleton
        keep = [not skeleton.names[int(j)].endswith("ToeBase") for j in skeleton.end_parents]
        ends = replace(skeleton, end_parents=skeleton.end_parents[keep], end_offsets=skeleton.end_offsets[keep])
        clip = replace(clip, skeleton=ends)
    return clip, rig_like(clip, plain)


def inserted(clip: Clip, name: str, below: str, share: float, turn: Floats) -> Clip:
    """The clip with one more joint above another, at a share of its bone, that turns by (F, 4) and the other back."""
    skeleton = clip.skeleton
    at = skeleton.names.index(below)
    later = np.arange(len(skeleton)) + (np.arange(len(skeleton)) >= at)
    parents = np.insert(np.where(skeleton.parents < 0, -1, later[skeleton.parents]), at, later[skeleton.parents[at]])
    parents[at + 1] = at
    bone = skeleton.offsets[at]
    offsets = np.insert(skeleton.offsets, at, share * bone, axis=0)
    offsets[at + 1] = (1.0 - share) * bone
    positions = np.insert(clip.positions, at, share * bone, axis=1)
    positions[:, at + 1] = (1.0 - share) * bone
    rotations = np.insert(clip.rotations, at, turn, axis=1)
    rotations[:, at + 1] = rotation.multiply(rotation.inverse(turn), rotations[:, at + 1])
    larger = Skeleton(
        names=(*skeleton.names[:at], name, *skeleton.names[at:]), parents=parents, offsets=offsets,
        end_parents=later[skeleton.end_parents], end_offsets=skeleton.end_offsets,
    )  # fmt: skip
    return Clip(larger, positions, rotations, clip.frame_time)


def rig_like(clip: Clip, plain: Rig) -> Rig:
    """The rig of a walker with other legs: joints by name, sole points where the plain walker has them."""
    skeleton = clip.skeleton
    at = {name: k for k, name in enumerate(skeleton.names)}
    legs, soles = [], []
    for k, side in enumerate(("Left", "Right")):
        hip, knee, ankle = (at[side + part] for part in ("UpLeg", "Leg", "Foot"))
        chain = [joint for joint in skeleton.ancestors(ankle) if hip in skeleton.ancestors(joint)]
        toe = at.get(side + "ToeBase")
        legs.append(Leg(side.lower(), side.lower(), hip, knee, ankle, toe, tuple(sorted(chain))))
        for sole in plain.soles[2 * k : 2 * k + 2]:
            joint, offset = ankle, np.array(sole.offset)
            if sole.part == "toe" and toe is not None:
                joint = toe
            elif sole.part == "toe":
                offset = offset + walk().clip.skeleton.offsets[walk().clip.skeleton.names.index(side + "ToeBase")]
            soles.append(SolePoint(sole.name, k, sole.part, joint, tuple(offset.tolist())))
    return Rig(0, 0, tuple(legs), tuple(soles), plain.leg_length, plain.floor)


def with_knees(clip: Clip, rig: Rig, flexion: Floats) -> Clip:
    """The clip with all knees bent by (F,) [rad] about the x axis of their frames, below zero hyperextended."""
    turns = {leg.knee: rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), flexion) for leg in rig.legs}
    return clip.with_joints({}, turns)


def changes(before: Clip, after: Clip) -> Bools:
    """(F, J) where a joint's rotation or place differs by a digit."""
    turned = np.any(before.rotations != after.rotations, axis=2)
    return np.asarray(turned | np.any(before.positions != after.positions, axis=2))


def largest_turn(one: Clip, other: Clip, rig: Rig) -> float:
    """[degrees] between two clips, the largest of all joints and frames of the legs."""
    joints = sorted({joint for leg in rig.legs for joint in (*leg.chain, leg.toe) if joint is not None})
    turns = [rotation.multiply(rotation.inverse(one.rotation(j)), other.rotation(j)) for j in joints]
    return float(np.degrees(max(rotation.angle(turn).max() for turn in turns)))

"""A leg as captured, and the closed-form solution of its two bones.

Whatever joints lie between hip and knee or between knee and ankle (twist bones, the third bone of an animal's leg)
stay as they are posed, so that the lengths of the two bones may differ from frame to frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.leg import knee_axis
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.contacts import Part
from footfix.motion.kinematics import Pose
from footfix.motion.vectors import cross, dot, norm, unit
from footfix.rig.rig import Leg, Rig

_BACKWARDS = 0.3  # [rad] a knee captured bent backwards by less is overstretched, by more it is meant
_EXTENSION = 0.9995  # share of a leg's length to which it may be stretched, where it was not captured straighter


@dataclass(frozen=True, eq=False)
class CapturedLeg:
    """A leg as captured, in the world.

    Args:
        leg: its joints.
        hip, knee, ankle: (F, 3) [m] tracks of the joints.
        turn: (F, 4) the ankle's frame.
        heel, toe: (F, 3) [m] tracks of its effectors, see `Rig.held`.
        knee_axis: (F, 3) unit axis about which the knee flexes.
        flexion: (F,) [rad] of the knee; negative where it bends backwards.
    """

    leg: Leg
    hip: Floats
    knee: Floats
    ankle: Floats
    turn: Floats
    heel: Floats
    toe: Floats
    knee_axis: Floats
    flexion: Floats

    def __len__(self) -> int:
        return len(self.ankle)

    def effector(self, part: Part) -> Floats:
        """Get the track of the heel or the toe, (F, 3) [m]."""
        return self.heel if part == "heel" else self.toe

    def in_foot(self, point: Floats) -> Floats:
        """Express a track (F, 3) [m] in the world in the ankle's frame."""
        return rotation.rotate(rotation.inverse(self.turn), point - self.ankle)


def captured_leg(rig: Rig, pose: Pose, number: int, tracks: tuple[Floats, ...]) -> CapturedLeg:
    """Gather one leg of a rig, by its place in `rig.legs`, from `rig.pose` and `Rig.held`."""
    leg = rig.legs[number]
    ends = {sole.part: track for sole, track in zip(rig.soles, tracks, strict=True) if sole.leg == number}
    hip, knee, ankle = (pose.position(joint) for joint in (leg.hip, leg.knee, leg.ankle))
    axis = _knee_axis(knee - hip, ankle - knee, ends["heel"] - ends["toe"], pose.rotation(leg.hip))
    thigh, shank = knee - hip, ankle - knee
    in_plane = shank - dot(shank, axis)[:, None] * axis
    flexion = np.arctan2(dot(axis, cross(thigh, in_plane)), dot(thigh, in_plane))
    return CapturedLeg(
        leg, hip, knee, ankle, pose.rotation(leg.ankle), ends["heel"], ends["toe"], axis, flexion
    )  # fmt: skip


def can_turn(clip: Clip, leg: Leg) -> bool:
    """Tell whether the file can animate the joints that inverse kinematics turns: hip, knee and ankle."""
    return bool(np.all(clip.skeleton.rotates[[leg.hip, leg.knee, leg.ankle]]))


def _knee_axis(thigh: Floats, shank: Floats, backwards: Floats, hip_turn: Floats) -> Floats:
    """Compute the unit axis in the world about which the knee flexes, (F, 3) (see `knee_axis`)."""
    in_thigh = rotation.rotate(rotation.inverse(hip_turn), cross(unit(thigh), unit(shank)))
    usual = in_thigh.sum(axis=0)
    if np.linalg.norm(usual) > 0.01 * len(thigh):
        return knee_axis(thigh, shank, rotation.rotate(hip_turn, unit(usual)))
    # a leg that is never bent: a knee bends so that the shank goes away from the toes
    return knee_axis(thigh, shank, unit(cross(thigh, backwards)))


def within_reach(leg: CapturedLeg, ankle: Floats) -> Floats:
    """Move goals of the ankle (F, 3) [m] towards the hip where the leg would be stretched too far.

    No leg becomes straighter than 99.95 % of its length, or than it was captured in that frame.
    """
    line = ankle - leg.hip
    bones, lever = _hinge(leg)
    limit = np.maximum(_EXTENSION * np.sqrt(bones + lever), norm(leg.ankle - leg.hip))  # (F,) [m]
    share = np.minimum(1.0, limit / np.maximum(norm(line), 1e-300))
    return np.where((share < 1.0)[:, None], leg.hip + share[:, None] * line, ankle)


def flexion_for(leg: CapturedLeg, ankle: Floats) -> Floats:
    """Find the knee's flexion (F,) [rad] with which the leg reaches its goal (F, 3) [m], by the law of cosines.

    A knee that was captured overstretched by some degrees bends forwards; one bent backwards farther stays so. Out of
    reach the leg is as straight or as bent as it goes.
    """
    line = ankle - leg.hip
    bones, lever = _hinge(leg)
    bent = np.arccos(np.clip((dot(line, line) - bones) / lever, -1.0, 1.0))
    return np.where(leg.flexion < -_BACKWARDS, -bent, bent)


def _hinge(leg: CapturedLeg) -> tuple[Floats, Floats]:
    """Split the squared distance from hip to ankle in a fixed part and one of cos(flexion), (F,) [m^2] each."""
    thigh, shank = leg.knee - leg.hip, leg.ankle - leg.knee
    in_plane = shank - dot(shank, leg.knee_axis)[:, None] * leg.knee_axis
    # |line|^2 = |thigh|^2 + |shank|^2 + 2 |thigh| |in_plane| cos(flexion)
    bones, lever = dot(thigh, thigh) + dot(shank, shank), 2.0 * norm(thigh) * norm(in_plane)
    return bones, np.maximum(lever, 1e-300)


@dataclass(frozen=True, eq=False)
class LegTurns:
    """The rotations that turn a leg into its new pose, in the world.

    Args:
        swing: (F, 4) turns the whole leg about the hip.
        bend: (F, 4) turns the shank about the knee, before the swing.
    """

    swing: Floats
    bend: Floats


def two_bones(leg: CapturedLeg, ankle: Floats, swivel: Floats | None = None) -> LegTurns:
    """Solve a leg for a goal of its ankle.

    The knee stays in the captured leg's plane, carried along by the smallest turn that takes the captured line from
    hip to ankle to the new one.

    Args:
        leg: as captured.
        ankle: (F, 3) [m] the goal; `within_reach` makes sure that it can be met.
        swivel: (F,) [rad] by which the leg turns about its own line, counted about the direction from ankle to hip.
    """
    thigh, shank = leg.knee - leg.hip, leg.ankle - leg.knee
    bend = rotation.from_axis_angle(leg.knee_axis, flexion_for(leg, ankle) - leg.flexion)
    swing = rotation.between(thigh + rotation.rotate(bend, shank), ankle - leg.hip)
    if swivel is not None:
        swing = rotation.multiply(rotation.from_axis_angle(unit(leg.hip - ankle), swivel), swing)
    return LegTurns(swing, bend)


def local_rotations(clip: Clip, pose: Pose, leg: CapturedLeg, turns: LegTurns, foot: Floats) -> dict[int, Floats]:
    """Convert a solved leg to local rotations (F, 4) of hip, knee and ankle; joints between them keep theirs.

    Args:
        clip: as captured.
        pose: from `rig.pose`.
        leg: as captured.
        turns: from `two_bones`.
        foot: (F, 4) the ankle's new frame in the world.
    """
    joints = (leg.leg.hip, leg.leg.knee, leg.leg.ankle)
    above_hip, above_knee, above_ankle = (_frame_above(clip, pose, joint) for joint in joints)
    hip = rotation.multiply(turns.swing, pose.rotation(leg.leg.hip))
    # the swing is above both the knee and its parent, and cancels out
    knee = rotation.multiply(turns.bend, pose.rotation(leg.leg.knee))
    carried = rotation.multiply(turns.swing, rotation.multiply(turns.bend, above_ankle))
    return {
        leg.leg.hip: rotation.multiply(rotation.inverse(above_hip), hip),
        leg.leg.knee: rotation.multiply(rotation.inverse(above_knee), knee),
        leg.leg.ankle: rotation.multiply(rotation.inverse(carried), foot),
    }


def _frame_above(clip: Clip, pose: Pose, joint: int) -> Floats:
    """Compute the frame in the world that a joint hangs in, (F, 4)."""
    parent = int(clip.skeleton.parents[joint])
    return pose.rotation(parent) if parent >= 0 else rotation.identity((len(clip),))


def where_moved(clip: Clip, new: Mapping[int, Floats], moves: Bools) -> dict[int, Floats]:
    """Keep new local rotations (F, 4) where a leg moves (F,), and the clip's exact values elsewhere."""
    out = {}
    for joint, turn in new.items():
        old = clip.rotation(joint)
        turn = rotation.normalize(turn) * np.where(dot(turn, old) < 0.0, -1.0, 1.0)[:, None]  # q and -q are one
        out[joint] = np.where(moves[:, None], turn, old)
    return out


def correction_of(clip: Clip, rig: Rig, new: Mapping[int, Floats]) -> Correction:
    """Gather new local rotations (F, 4) by joint in a correction that leaves the root where it is."""
    turns = np.stack(list(new.values()), axis=1) if new else np.zeros((len(clip), 0, 4))
    return Correction(rig.root, np.zeros((len(clip), 3)), tuple(new), turns)

"""The leg in closed form: thigh and shank as two bones, the knee kept in its own plane.

Whatever joints lie between hip and knee or between knee and ankle (twist bones, the extra bone of an
animal's leg) stay as they are posed, so that the two bones' lengths may differ from frame to frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.enforce.ease import gamma
from footfix.enforce.foot import Foot
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats, Ints, some
from footfix.motion.contacts import runs
from footfix.motion.kinematics import Pose
from footfix.motion.vectors import cross, dot, norm, unit

# Up to which bend the captured leg is too straight to say about which axis its knee flexes [sine].
_STRAIGHT = 0.4
_BACKWARDS = 0.3  # a knee that was captured bent backwards by less [rad] is overstretched, by more it is meant
_ROUND = 0.08  # [rad] on either side of the least flexion over which a knee's way is rounded off


@dataclass(frozen=True, eq=False)
class LegTurns:
    """What turns a leg into its new pose, in the world.

    Args:
        swing: (F, 4) turns the whole leg about the hip.
        bend: (F, 4) turns the shank about the knee, before the swing.
    """

    swing: Floats
    bend: Floats

    def ankle(self, foot: Foot, hip: Floats) -> Floats:
        """(F, 3) [m] where the leg's ankle comes to be, its hip at (F, 3) [m]."""
        thigh, shank = foot.knee - foot.hip, foot.ankle - foot.knee
        return hip + rotation.rotate(self.swing, thigh + rotation.rotate(self.bend, shank))


def knee_axis(foot: Foot, hip_turn: Floats) -> Floats:
    """(F, 3) unit axis in the world about which the knee flexes, at right angles to the thigh.

    Where the leg is bent it is the normal of the captured leg's plane. Where it is straight the normal means
    nothing, and the axis the knee has on the whole, fixed in the thigh, leads over.
    """
    thigh, shank = foot.knee - foot.hip, foot.ankle - foot.knee
    normal = cross(unit(thigh), unit(shank))  # as long as the sine of the flexion
    in_thigh = rotation.rotate(rotation.inverse(hip_turn), normal)
    usual = in_thigh.sum(axis=0)
    if np.linalg.norm(usual) > 0.01 * len(foot):
        usual_in_world = rotation.rotate(hip_turn, unit(usual))
    else:  # a leg that is never bent: a knee bends so that the shank goes away from the toes
        usual_in_world = unit(cross(thigh, foot.heel - foot.ball))
    # through a straight leg the normal swings round: only as much of it counts as lies along the usual axis
    c = dot(normal, usual_in_world)
    aside = normal - c[:, None] * usual_in_world
    square = c * c + _STRAIGHT**2
    axis = np.sqrt(square)[:, None] * usual_in_world + (c * np.abs(c) / square)[:, None] * aside
    along = unit(thigh)
    return unit(axis - dot(axis, along)[:, None] * along)


@dataclass(frozen=True, eq=False)
class Hinge:
    """A knee as captured, over F frames: what does not change however its leg is held.

    Args:
        axis: (F, 3) it flexes about, from `knee_axis`.
        flexion: (F,) [rad] how far it is bent; negative where it bends backwards.
        bones: (F,) [m^2] the squares of thigh and shank, together.
        lever: (F,) [m^2] twice the product of the thigh and the part of the shank that swings about the axis.
        least: [rad] the straightest it may be while its foot is not held; below zero where the clip overstretches it.
    """

    axis: Floats
    flexion: Floats
    bones: Floats
    lever: Floats
    least: float

    def frames(self, which: Ints) -> Hinge:
        """The knee in some frames only; its straightest stays that of the clip."""
        axis, flexion, bones, lever = (
            some(each.reshape(len(each), -1), which) for each in (self.axis, self.flexion, self.bones, self.lever)
        )
        return Hinge(axis, flexion[:, 0], bones[:, 0], lever[:, 0], self.least)

    def length(self, flexion: Floats) -> Floats:
        """(F,) [m] from hip to ankle, the knee bent as said (F,) [rad]."""
        # law of cosines: length^2 = |thigh|^2 + |shank|^2 + 2 |thigh| |in_plane| cos(flexion)
        return np.sqrt(np.maximum(self.bones + self.lever * np.cos(flexion), 1e-300))

    def slope(self, flexion: Floats) -> Floats:
        """(F,) [m/rad] how the length changes with the knee's bend (F,) [rad]."""
        return np.asarray(-0.5 * self.lever * np.sin(flexion) / self.length(flexion))


def hinge(foot: Foot, axis: Floats, straighter: float = 1.0) -> Hinge:
    """The knee of a leg that flexes about an axis (F, 3).

    While its foot is not held it may bend as little as `straighter` times what it does where it is straightest.
    """
    thigh, shank = foot.knee - foot.hip, foot.ankle - foot.knee
    in_plane = shank - dot(shank, axis)[:, None] * axis
    flexion = np.arctan2(dot(axis, cross(thigh, in_plane)), dot(thigh, in_plane))
    lever = np.maximum(2.0 * norm(thigh) * norm(in_plane), 1e-300)
    captured = float(flexion.min(initial=np.inf))
    least = min(captured, straighter * captured) if captured > -_BACKWARDS else 0.0
    return Hinge(axis, flexion, dot(thigh, thigh) + dot(shank, shank), lever, least)


def flexion(hinge: Hinge, hip: Floats, ankle: Floats, held: Bools) -> Floats:
    """(F,) [rad] how far the knee of the leg that reaches from `hip` (F, 3) to `ankle` (F, 3) [m] is bent.

    Out of reach, the leg is as straight or as bent as it goes. Many clips overstretch a straight knee by some
    degrees: such a one bends forwards; one that is bent backwards farther stays on its side. As long as the foot is
    held (F,) it does not change sides.
    """
    line = ankle - hip
    bent = np.arccos(np.clip((dot(line, line) - hinge.bones) / hinge.lever, -1.0, 1.0))
    backwards = hinge.flexion < -_BACKWARDS
    for start, end in runs(held) if np.any(backwards) else []:
        backwards[start:end] = np.median(hinge.flexion[start:end]) < -_BACKWARDS
    return np.where(backwards, -bent, bent)


def staying(hinge: Hinge, bent: Floats) -> Floats:
    """(F,) [rad] by how much more a knee bends whose foot stays while its hip comes or goes.

    `bent` (F,) [rad], of either sign, is how much it has to be bent for that. An overstretched knee comes through
    straight as far as it has to; one that is bent backwards goes on backwards, and one on its way there is between.
    """
    size = np.abs(hinge.flexion)
    more = np.abs(bent) - size
    through = np.where(more > 0.0, more * (1.0 + 2.0 * size / np.maximum(np.abs(bent), 1e-300)), -more)
    out = np.where(hinge.flexion < 0.0, through, more)
    for start, end in runs(hinge.flexion < 0.0):
        if hinge.flexion[start:end].min() < -2.0 * _BACKWARDS:
            side = 1.0 - 2.0 * gamma(1.0 + hinge.flexion[start:end] / (2.0 * _BACKWARDS))
            out[start:end] = side * more[start:end]
    return out


def not_too_straight(hinge: Hinge, more: Floats, share: Floats) -> Floats:
    """(F,) [rad] a knee's flexion with so much more (F,), but no straighter than it may be.

    It is rounded off where it would be; `share` (F,) says how much, from 0, where it goes on from a foot that is
    held, to 1.
    """
    captured = hinge.flexion
    least = np.minimum(captured, hinge.least)

    def rounded(over: Floats) -> Floats:  # a parabola leads over from the bound to what is wanted
        part = (over + _ROUND) ** 2 / (4.0 * _ROUND)
        return np.where(over >= _ROUND, over, np.where(over <= -_ROUND, 0.0, part))

    now, wanted = rounded(captured - least), rounded(captured + more - least)
    # what the rounding itself adds to a knee of which nothing is asked is taken off again
    added = (now - (captured - least)) * np.minimum(wanted / now, 1.0)
    plain = captured + more
    return np.maximum(plain + share * (least + wanted - added - plain), least)


def two_bones(foot: Foot, hinge: Hinge, bent: Floats, hip: Floats, ankle: Floats) -> LegTurns:
    """The leg from `hip` (F, 3) towards `ankle` (F, 3) [m], its knee bent as said (F,) [rad].

    The knee stays in the captured leg's plane, carried along by the smallest turn that takes the captured line from
    hip to ankle to the new one.
    """
    thigh, shank = foot.knee - foot.hip, foot.ankle - foot.knee
    bend = rotation.from_axis_angle(hinge.axis, bent - hinge.flexion)
    swing = rotation.between(thigh + rotation.rotate(bend, shank), ankle - hip)
    return LegTurns(swing, bend)


def local_rotations(
    clip: Clip, pose: Pose, foot: Foot, turns: LegTurns, ankle_turn: Floats
) -> dict[int, Floats]:
    """New local rotations of hip, knee and ankle, (F, 4) each.

    `ankle_turn` (F, 4) is the ankle's new frame in the world. What hangs between the three keeps its own.
    """
    leg, parents = foot.leg, clip.skeleton.parents
    new = {}
    above_hip = _frame(pose, int(parents[leg.hip]), len(foot))
    new[leg.hip] = rotation.multiply(
        rotation.inverse(above_hip), rotation.multiply(turns.swing, pose.rotation(leg.hip))
    )
    above_knee = _frame(pose, int(parents[leg.knee]), len(foot))
    # the swing is above both the knee and its parent: it cancels out
    new[leg.knee] = rotation.multiply(
        rotation.inverse(above_knee), rotation.multiply(turns.bend, pose.rotation(leg.knee))
    )
    above_ankle = _frame(pose, int(parents[leg.ankle]), len(foot))
    carried = rotation.multiply(turns.swing, rotation.multiply(turns.bend, above_ankle))
    new[leg.ankle] = rotation.multiply(rotation.inverse(carried), ankle_turn)
    return {joint: rotation.normalize(q) for joint, q in new.items()}


def _frame(pose: Pose, joint: int, frames: int) -> Floats:
    return pose.rotation(joint) if joint >= 0 else rotation.identity((frames,))

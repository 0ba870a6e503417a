"""One leg of a model in the world, and its knee and hip turned so that its ankle is where it is wanted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.locomotion.model import CycleModel
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.motion.vectors import cross, dot, norm, unit

_LONGEST = 0.9998  # share of a leg's length to which it is stretched at most


@dataclass(frozen=True, eq=False)
class LegPose:
    """One leg at T times, in the world.

    Args:
        number: index among the rig's legs.
        places: joint -> (T, 3) [m].
        turns: joint -> (T, 4) its frame.
        heel, toe: (T, 3) [m] its effectors: the sole point of the heel, and the toe joint or the ball of the sole.
    """

    number: int
    places: dict[int, Floats]
    turns: dict[int, Floats]
    heel: Floats
    toe: Floats


def leg_pose(model: CycleModel, number: int, place: Floats, turn: Floats, turns: Floats) -> LegPose:
    """Pose a leg by forward kinematics.

    Args:
        model: the figure.
        number: which leg.
        place, turn: (T, 3) [m] and (T, 4) the root in the world.
        turns: (T, J, 4) all joints' rotations in their parents' frames; the root's is not looked at.
    """
    skeleton, leg, root = model.skeleton, model.rig.legs[number], model.rig.root
    last = leg.ankle if leg.toe is None else leg.toe
    down = [joint for joint in reversed(skeleton.ancestors(last)) if root in skeleton.ancestors(joint)[1:]]
    places, frames = {root: place}, {root: turn}
    for joint in down:
        parent = int(skeleton.parents[joint])
        places[joint] = places[parent] + rotation.rotate(frames[parent], skeleton.offsets[joint])
        frames[joint] = rotation.multiply(frames[parent], turns[:, joint])
    heel = places[leg.ankle] + rotation.rotate(frames[leg.ankle], heel_offset(model, number))
    toe = places[leg.toe] if leg.toe is not None else None
    if toe is None:
        toe = places[leg.ankle] + rotation.rotate(frames[leg.ankle], _sole(model, number, "toe"))
    return LegPose(number, places, frames, heel, toe)


def heel_offset(model: CycleModel, number: int) -> Floats:
    """(3,) [m] the heel's sole point in the ankle's frame."""
    return _sole(model, number, "heel")


def _sole(model: CycleModel, number: int, part: str) -> Floats:
    return next(np.array(sole.offset) for sole in model.rig.soles if (sole.leg, sole.part) == (number, part))


def reach_of(model: CycleModel, pose: LegPose) -> Floats:
    """(T,) [m] how far from its hip the ankle of a leg can be: not farther than the leg is long, nor than it was posed."""
    leg = model.rig.legs[pose.number]
    bones = norm(pose.places[leg.knee] - pose.places[leg.hip]) + norm(pose.places[leg.ankle] - pose.places[leg.knee])
    return np.maximum(_LONGEST * bones, norm(pose.places[leg.ankle] - pose.places[leg.hip]))


def bent_to(
    model: CycleModel, pose: LegPose, hip: Floats, ankle: Floats, foot: Floats, toes: Floats | None
) -> dict[int, Floats]:
    """Turn hip, knee and ankle so that the ankle is at a place, by the law of cosines; bones keep their lengths.

    The knee flexes about its axis; the leg then swings about the hip by the smallest turn.

    Args:
        model: the figure.
        pose: the leg as the cycle has it.
        hip: (T, 3) [m] where the hip joint is.
        ankle: (T, 3) [m] where the ankle is to be; beyond its reach the leg points there.
        foot: (T, 4) the ankle's frame as it is to be, in the world.
        toes: (T, 4) the same of the toe joint, if there is one.

    Returns:
        joint -> (T, 4) rotations in the parents' frames.
    """
    leg = model.rig.legs[pose.number]
    parents = model.skeleton.parents
    thigh, shank = pose.places[leg.knee] - pose.places[leg.hip], pose.places[leg.ankle] - pose.places[leg.knee]
    axis = rotation.rotate(pose.turns[leg.hip], model.knees[pose.number])
    along = unit(thigh)
    axis = unit(axis - dot(axis, along)[:, None] * along)
    in_plane = shank - dot(shank, axis)[:, None] * axis
    flexion = np.arctan2(dot(axis, cross(thigh, in_plane)), dot(thigh, in_plane))
    line = ankle - hip
    far = np.minimum(norm(line), reach_of(model, pose))
    lever = np.maximum(2.0 * norm(thigh) * norm(in_plane), 1e-12)
    cosine = np.clip((far * far - dot(thigh, thigh) - dot(shank, shank)) / lever, -1.0, 1.0)
    wanted = np.where(flexion < -0.3, -1.0, 1.0) * np.arccos(cosine)
    bend = rotation.from_axis_angle(axis, wanted - flexion)
    swing = rotation.between(thigh + rotation.rotate(bend, shank), line)
    turned_hip = rotation.multiply(swing, pose.turns[leg.hip])
    turned_knee = rotation.multiply(bend, pose.turns[leg.knee])
    above_ankle = rotation.multiply(swing, rotation.multiply(bend, pose.turns[int(parents[leg.ankle])]))
    found = {
        leg.hip: rotation.multiply(rotation.inverse(pose.turns[int(parents[leg.hip])]), turned_hip),
        leg.knee: rotation.multiply(rotation.inverse(pose.turns[int(parents[leg.knee])]), turned_knee),
        leg.ankle: rotation.multiply(rotation.inverse(above_ankle), foot),
    }
    if int(parents[leg.knee]) != leg.hip:
        pass  # the swing is above both the knee and what it hangs from, and cancels out
    if toes is not None and leg.toe is not None:
        above = foot
        between = [j for j in reversed(model.skeleton.ancestors(int(parents[leg.toe]))) if j not in
                   model.skeleton.ancestors(leg.ankle)]  # fmt: skip
        for joint in between:
            local = rotation.multiply(rotation.inverse(pose.turns[int(parents[joint])]), pose.turns[joint])
            above = rotation.multiply(above, local)
        found[leg.toe] = rotation.multiply(rotation.inverse(above), toes)
    return found

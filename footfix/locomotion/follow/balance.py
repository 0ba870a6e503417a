"""Balance in curves: body masses, zero-moment point, and lean."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from footfix.locomotion.follow.stride import averaged, smoothed
from footfix.motion.clip import Clip, Floats, Skeleton
from footfix.motion.kinematics import Pose, forward
from footfix.rig.names import bare, read
from footfix.rig.rig import Rig

GRAVITY = 9.81  # [m/s^2]
_SPAN = 0.5  # [s] of K's 4th-order difference
_MOST = np.radians(0.45)  # greatest change of the lean in one Newton step on the zero-moment point
_SMALL = 0.08  # [leg lengths] a shorter bone is not an arm bone

# de Leva 1996, mean of men and women: share of the body's mass, and where its centre is between a segment's ends
_HEAD, _TRUNK = (0.0681, 0.5), (0.43015, 0.55)
_UPPER_ARM, _FOREARM, _HAND = (0.0263, 0.5763), (0.0150, 0.4567), (0.00585, 0.0)
_THIGH, _SHANK, _FOOT = (0.1447, 0.3854), (0.0457, 0.4374), (0.0133, 0.5)

_WRIST = re.compile(r"hand|wrist|手首", re.IGNORECASE)
_FINGER = re.compile(r"thumb|index|middle|ring|pink|finger|palm|meta|end|site|nub|tip|prop|weapon|\d$", re.IGNORECASE)
_NECK = re.compile(r"neck|首", re.IGNORECASE)
_CRANE = re.compile(r"head|頭", re.IGNORECASE)


@dataclass(frozen=True)
class Segment:
    """A part of a body.

    Args:
        mass: share of the body's.
        ends: joints at either end; the mean of several.
        centre: how far from the first end to the second its mass lies.
    """

    mass: float
    ends: tuple[tuple[int, ...], tuple[int, ...]]
    centre: float


def neck_of(skeleton: Skeleton, rig: Rig) -> int | None:
    """Find the joint below which the head hangs: the first neck joint, or the head where there is none."""
    mine = [j for j in range(len(skeleton)) if rig.root in skeleton.ancestors(j)]
    for pattern in (_NECK, _CRANE):
        for joint in mine:
            name = bare(skeleton.names[joint])
            if pattern.search(name) and not read(name).tip and not read(name).side:
                return joint
    return None


def head_of(skeleton: Skeleton, rig: Rig) -> int | None:
    """Find the head's joint, or the neck where none is called a head."""
    mine = [j for j in range(len(skeleton)) if rig.root in skeleton.ancestors(j)]
    heads = [j for j in mine if _CRANE.search(bare(skeleton.names[j])) and not read(skeleton.names[j]).side]
    return heads[0] if heads else neck_of(skeleton, rig)


def arms_of(skeleton: Skeleton, rig: Rig) -> tuple[tuple[int, int, int], ...]:
    """Find shoulder, elbow and wrist of each arm by joint names."""
    found: dict[str, tuple[int, int, int]] = {}
    legs = {joint for leg in rig.legs for joint in leg.chain}
    for joint in range(len(skeleton)):
        name = bare(skeleton.names[joint])
        side = read(name).side
        if not side or side in found or not _WRIST.search(name) or _FINGER.search(name):
            continue
        above = [joint]
        for parent in skeleton.ancestors(joint)[1:]:
            bone = float(np.linalg.norm(skeleton.offsets[above[-1]]))
            if bone > _SMALL * rig.leg_length and not read(skeleton.names[parent]).helper:
                above.append(parent)
            if len(above) == 3:
                break
        if len(above) == 3 and rig.root in skeleton.ancestors(joint) and not legs & set(above):
            found[side] = (above[2], above[1], above[0])
    return tuple(found.values())


def end_effectors(skeleton: Skeleton, rig: Rig) -> tuple[int, ...]:
    """Find head, hands and feet, as far as they are known (K 6.2)."""
    head = head_of(skeleton, rig)
    feet = [leg.ankle for leg in rig.legs]
    return (*([] if head is None else [head]), *(arm[2] for arm in arms_of(skeleton, rig)), *feet)


def segments(skeleton: Skeleton, rig: Rig) -> tuple[Segment, ...]:
    """Make the segments of a body by de Leva 1996; those not found in the skeleton are added to the trunk."""
    found = []
    for leg in rig.legs:
        toe = leg.ankle if leg.toe is None else leg.toe
        for (mass, centre), ends in (
            (_THIGH, (leg.hip, leg.knee)), (_SHANK, (leg.knee, leg.ankle)), (_FOOT, (leg.ankle, toe))
        ):  # fmt: skip
            found.append(Segment(mass * 2.0 / len(rig.legs), ((ends[0],), (ends[1],)), centre))
    arms = arms_of(skeleton, rig)
    for shoulder, elbow, wrist in arms:
        for (mass, centre), ends in (
            (_UPPER_ARM, (shoulder, elbow)), (_FOREARM, (elbow, wrist)), (_HAND, (wrist, wrist))
        ):  # fmt: skip
            found.append(Segment(mass, ((ends[0],), (ends[1],)), centre))
    hips = tuple(leg.hip for leg in rig.legs)
    neck, head = neck_of(skeleton, rig), head_of(skeleton, rig)
    top = tuple(arm[0] for arm in arms) or ((rig.pelvis,) if neck is None else (neck,))
    if neck is not None and head is not None:
        found.append(Segment(_HEAD[0], ((neck,), (head,)), 1.0))
    found.append(Segment(1.0 - sum(each.mass for each in found), (hips, top), _TRUNK[1]))
    return tuple(found)


def centres(clip: Clip, body: tuple[Segment, ...]) -> Floats:
    """Compute the centres of mass of a body's segments in the world, (S, F, 3) [m]."""
    joints = sorted({joint for each in body for end in each.ends for joint in end})
    pose = forward(clip, joints)
    return np.stack([_between(pose, each) for each in body])


def _between(pose: Pose, part: Segment) -> Floats:
    first, second = (np.mean([pose.position(joint) for joint in end], axis=0) for end in part.ends)
    return np.asarray((1.0 - part.centre) * first + part.centre * second)


def acceleration(track: Floats, frame_time: float) -> Floats:
    """Differentiate tracks (..., F, 3) [m] twice, to [m/s^2], by K 7.2's 4th-order difference over half a second.

    a = (-f(t - 2h) + 16 f(t - h) - 30 f(t) + 16 f(t + h) - f(t + 2h)) / 12 h^2; beyond its ends a track goes straight.
    """
    n = max(1, round(_SPAN / 4.0 / frame_time))
    reach = 2 * n
    F = track.shape[-2]
    count = np.arange(1, reach + 1)[:, None]
    first, last = track[..., :1, :], track[..., -1:, :]
    before = first - count[::-1] * (track[..., 1:2, :] - first)
    after = last + count * (last - track[..., -2:-1, :])
    around = np.concatenate([before, track, after], axis=-2)
    f = [around[..., k * n : k * n + F, :] for k in range(5)]
    return np.asarray((-f[0] + 16.0 * f[1] - 30.0 * f[2] + 16.0 * f[3] - f[4]) / (12.0 * (n * frame_time) ** 2))


def zero_moment_point(clip: Clip, rig: Rig, body: tuple[Segment, ...]) -> tuple[Floats, Floats]:
    """Find the zero-moment point on the floor, x and z (F, 2) [m], and how hard the body presses on it, (F,) [m/s^2].

    x = sum m ((y'' + g) x - y x'') / sum m (y'' + g), with heights y over the floor; z alike.
    """
    centre = centres(clip, body)
    second = acceleration(centre, clip.frame_time)
    mass = np.array([each.mass for each in body])[:, None]
    weight = mass * (second[..., 1] + GRAVITY)
    height = (centre[..., 1] - rig.floor) * mass
    total = np.maximum(weight.sum(axis=0), 0.1 * GRAVITY)  # nothing presses on the floor in free flight
    sides = ((weight * centre[..., k]).sum(axis=0) - (height * second[..., k]).sum(axis=0) for k in (0, 2))
    return np.stack([side / total for side in sides], axis=1), total


def lean_for(speed: Floats, curvature: Floats, stride: float) -> Floats:
    """Compute the lean to the left, (F,) [rad]: atan(v^2 kappa / g), averaged over a stride.

    Args:
        speed: (F,) [m/s] along the path.
        curvature: (F,) [rad/m] to the left.
        stride: [frames].
    """
    if not np.any(curvature):
        return np.zeros(len(curvature))
    v, k = (smoothed(each, round(2.0 * stride)) for each in (speed, curvature))
    return np.asarray(np.arctan(v * v * k / GRAVITY))


def corrected_lean(lean: Floats, off: Floats, height: float, stride: float) -> Floats:
    """Correct a lean (F,) [rad] by one Newton step on the zero-moment point (Shin, Kovar & Gleicher 2003).

    Args:
        lean: (F,) [rad] to the left.
        off: (F,) [m] mean distance of the zero-moment point to the left of that in the straight walk.
        height: [m] of the body's centre: the distance that it moves per radian.
        stride: [frames].
    """
    step = -averaged(off, stride) / height
    return np.asarray(lean + np.clip(step, -_MOST, _MOST) * (lean != 0.0))

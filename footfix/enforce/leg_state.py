"""A leg in a state: the places of its sole points, their derivatives, and the turns of its joints.

Arrays have their components first and frames last, as in `leg`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.enforce.leg import B, K, LegTracks, Q, W
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import Pose


@dataclass(frozen=True, eq=False)
class LegState:
    """Sole points of a leg in a state, and their derivatives.

    A point p moves by  dp = dd + ankle (dq, dk) + (turn dw) x arm + hinge db,  the last for the tip alone.

    Args:
        places: for each point (3, F) [m] in the world.
        arms: for each point (3, F) [m] from the ankle; none for the ankle itself.
        ankle: (3, 4, F) [m/rad] derivative of the ankle with respect to q and k.
        turn: (3, 3, F) [rad/rad] derivative of the foot's turn in the world with respect to w.
        hinge: (3, F) [m/rad] derivative of the tip with respect to b; none where the toes have no tip.
    """

    places: tuple[Floats, ...]
    arms: tuple[Floats | None, ...]
    ankle: Floats
    turn: Floats
    hinge: Floats | None


def state_of(leg: LegTracks, root: Floats, x: Floats) -> LegState:
    """Compute the sole points of a leg in a state, and their derivatives.

    ankle = hip + d + exp(q) line D(k),   point = ankle + exp(w) p,   tip = ankle + exp(w) (p + R(hinge, b) t)

    Args:
        leg: as captured, F frames.
        root: (3, F) [m] shift of the root.
        x: (8, F) [rad] the leg's unknowns.
    """
    k, (c0, c1, c2) = x[K], leg.reach
    cos, sin = np.cos(k), np.sin(k)
    square = np.maximum(c0 + c1 * cos + c2 * sin, 1e-12)  # D^2
    line = rotated(exponential(x[Q]), leg.line) * np.sqrt(square)
    foot = exponential(x[W])
    arms, toes = _arms(leg, foot, x[B])
    swept = left_jacobian(x[Q])
    ankle = np.empty((3, 4, len(k)))
    for j in range(3):
        ankle[:, j] = cross(swept[:, j], line)
    ankle[:, 3] = line * ((c2 * cos - c1 * sin) / (2.0 * square))  # dD/dk along the line
    hinge = None if toes is None else cross(rotated(foot, leg.toe_hinge), toes)
    at = leg.hip + root + line
    return LegState(tuple(at if arm is None else at + arm for arm in arms), arms, ankle, left_jacobian(x[W]), hinge)


def places_of(leg: LegTracks, root: Floats, x: Floats) -> tuple[Floats, ...]:
    """Compute the sole points of a leg in a state, (3, F) [m] each; arguments as of `state_of`."""
    k, (c0, c1, c2) = x[K], leg.reach
    distance = np.sqrt(np.maximum(c0 + c1 * np.cos(k) + c2 * np.sin(k), 1e-12))
    at = leg.hip + root + rotated(exponential(x[Q]), leg.line) * distance
    arms, _ = _arms(leg, exponential(x[W]), x[B])
    return tuple(at if arm is None else at + arm for arm in arms)


def _arms(leg: LegTracks, foot: Floats, b: Floats) -> tuple[tuple[Floats | None, ...], Floats | None]:
    """Compute vectors from ankle to points, and from toe joint to tip, (3, F) [m], of a foot turned by (3, 3, F)."""
    heel, toe = (rotated(foot, each) for each in leg.points[:2])
    if len(leg.points) == 2:
        return (heel, toe, None), None
    toes = rotated(foot, rotated(exponential(b * leg.toe_hinge), leg.points[2]))
    return (heel, toe, None, toe + toes), toes


def cross(a: Floats, b: Floats) -> Floats:
    """Compute vector products (3, ...)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def exponential(vector: Floats) -> Floats:
    """Convert rotation vectors (3, ...) [rad] to matrices (3, 3, ...) (Rodrigues).

    R = I + sin x / x [v] + (1 - cos x) / x^2 [v]^2,  x = |v|
    """
    square = vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2
    angle = np.sqrt(square)
    # (1 - cos x) / x^2 = (sin(x/2) / (x/2))^2 / 2
    return _series(vector, square, np.sinc(angle / np.pi), 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2)


def left_jacobian(vector: Floats) -> Floats:
    """Compute how the rotations of rotation vectors (3, ...) [rad] turn in the world as these change, (3, 3, ...).

    J = I + (1 - cos x) / x^2 [v] + (x - sin x) / x^3 [v]^2,  x = |v|
    """
    square = vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2
    angle = np.sqrt(square)
    first = 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2
    second = np.where(angle > 1e-3, (1.0 - np.sinc(angle / np.pi)) / np.maximum(square, 1e-12), 1.0 / 6.0)
    return _series(vector, square, first, second)


def _series(v: Floats, square: Floats, first: Floats, second: Floats) -> Floats:
    """Evaluate I + first [v] + second [v]^2, (3, 3, ...); [v] w = v x w, and [v]^2 = v v' - |v|^2 I."""
    out = np.empty((3, *v.shape))
    diagonal = 1.0 - second * square
    once, twice = first * v, second * v
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i, i] = diagonal + twice[i] * v[i]
        both = twice[i] * v[j]
        out[i, j], out[j, i] = both - once[k], both + once[k]
    return out


def rotated(matrix: Floats, v: Floats) -> Floats:
    """Multiply matrices (3, 3, ...) by vectors (3, ...)."""
    return np.asarray(matrix[:, 0] * v[0] + matrix[:, 1] * v[1] + matrix[:, 2] * v[2])


def local_rotations(clip: Clip, pose: Pose, leg: LegTracks, x: Floats) -> dict[int, Floats]:
    """Compute new local rotations (F, 4) of hip, knee, ankle and toe joint; joints between them keep theirs.

    Args:
        clip: as captured.
        pose: of the clip.
        leg: as captured.
        x: (8, F) [rad] the leg's unknowns.
    """
    joints, parents = leg.leg, clip.skeleton.parents
    swing, bend = leg_turns(leg, x)
    thigh = swing  # T1, of everything from the hip down to the knee
    shank = rotation.multiply(swing, bend)  # T2, from the knee down to the ankle
    foot = rotation.from_rotation_vector(x[W].T)
    new = {}
    for joint, above, turn in ((joints.hip, None, thigh), (joints.knee, thigh, shank), (joints.ankle, shank, foot)):
        new[joint] = _local(pose, joint, int(parents[joint]), above, turn)
    if joints.toe is not None and leg.bends:
        toes = rotation.multiply(foot, rotation.from_rotation_vector((x[B] * leg.toe_hinge).T))
        new[joints.toe] = _local(pose, joints.toe, int(parents[joints.toe]), foot, toes)
    return new


def leg_turns(leg: LegTracks, x: Floats) -> tuple[Floats, Floats]:
    """Compute the turn of the leg about the hip, and that of the shank about the knee before it, both (F, 4)."""
    bend = rotation.from_rotation_vector((x[K] * leg.axis).T)
    reached = leg.thigh.T + rotation.rotate(bend, leg.shank.T)
    # the line from hip to ankle keeps its direction while the knee bends
    back = rotation.between(reached, leg.line.T)
    return rotation.multiply(rotation.from_rotation_vector(x[Q].T), back), bend


def _local(pose: Pose, joint: int, parent: int, above: Floats | None, turn: Floats) -> Floats:
    """Compute the local rotation (F, 4) of a joint turned in the world, whose parent is turned by `above`."""
    world = rotation.multiply(turn, pose.rotation(joint))
    if parent < 0:
        return rotation.normalize(world)
    frame = pose.rotation(parent) if above is None else rotation.multiply(above, pose.rotation(parent))
    return rotation.normalize(rotation.multiply(rotation.inverse(frame), world))

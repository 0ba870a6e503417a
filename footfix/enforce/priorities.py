"""Prioritised damped least squares: inverse kinematics for chains of any length, with joint limits.

The ankle comes first; the toe gets what freedom that leaves; nearness to the captured pose gets the rest
(G §5.1). Source of the solver: P. Baerlocher, R. Boulic, An inverse kinematics architecture enforcing an arbitrary
number of strict priority levels, The Visual Computer 20 (2004). All frames of a clip are solved at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.foot import Foot
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats, Ints
from footfix.motion.kinematics import Pose

_BENDS = 0.05  # a joint whose bones' angle changes by more than this over the clip [sine] is one that bends


@dataclass(frozen=True, kw_only=True)
class SolverParams:
    """How the solver steps."""

    iterations: int = 60  # at most
    tolerance: float = 1e-5  # leg lengths: a goal nearer than this is met
    damping: float = 0.02  # leg lengths: what is out of reach is approached no more nervously than this
    step: float = 0.3  # [rad] that a joint turns in one iteration at most
    nearness: float = 0.5  # of the way back to the captured pose in one iteration, in the freedom left over


@dataclass(frozen=True, eq=False)
class Chain:
    """A chain of joints as captured, over F frames.

    Args:
        base: (F, 3) [m] place of the first joint.
        base_turn: (F, 4) the frame above it, in the world.
        bones: for each of J joints the place of the next one in its frame (F, 3) [m]; of the last joint, the
            place of the second effector (the ball) in its frame.
        locals_: (F, J, 4) the joints' rotations as captured.
        free: for each joint, the axes of its own frame, (3,) or (F, 3), about which it may turn; none for a joint
            that stays as it is.
        limits: for each joint how far it may turn about each of these from the captured pose [rad]; None for any.
    """

    base: Floats
    base_turn: Floats
    bones: tuple[Floats, ...]
    locals_: Floats
    free: tuple[tuple[Floats, ...], ...]
    limits: tuple[tuple[float, ...] | None, ...]


@dataclass(frozen=True, eq=False)
class Solution:
    """What the solver found.

    Args:
        locals_: (F, J, 4) the joints' rotations.
        first, second: (F, 3) [m] where the two effectors are.
        iterations: how many it took.
    """

    locals_: Floats
    first: Floats
    second: Floats
    iterations: int


def leg_chain(clip: Clip, pose: Pose, foot: Foot, axis: Floats, which: Bools) -> Chain:
    """The chain from hip to ball of a leg as captured.

    The hip and the ankle are free; each joint between them that bends flexes about the leg's own axis, and one that
    does not (a twist bone) stays as it is.

    Args:
        clip: the clip.
        pose: its joints in the world.
        foot: the leg.
        axis: (F, 3) about which its knee flexes, in the world.
        which: (F,) the frames that are to be solved.
    """
    joints = foot.leg.chain
    above = int(clip.skeleton.parents[joints[0]])
    turn = pose.rotation(above)[which] if above >= 0 else rotation.identity((int(which.sum()),))
    bones = [clip.place(joint)[which] for joint in joints[1:]]
    every = tuple(np.eye(3))
    free: list[tuple[Floats, ...]] = [every]
    for k, joint in enumerate(joints[1:-1]):
        before = pose.position(joint) - pose.position(joints[k])
        after = pose.position(joints[k + 2]) - pose.position(joint)
        straight = np.linalg.norm(np.cross(before, after), axis=1)
        lengths = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
        bends = joint == foot.leg.knee or float(np.ptp(straight / np.maximum(lengths, 1e-12))) > _BENDS
        hinge = rotation.rotate(rotation.inverse(pose.rotation(joint)), axis)[which]
        free.append((hinge,) if bends else ())
    return Chain(
        foot.hip[which], turn, (*bones, foot.ball_in_foot[which]),
        np.stack([clip.turn(joint)[which] for joint in joints], axis=1), (*free, every), (None,) * len(joints),
    )  # fmt: skip


def solve(chain: Chain, first: Floats, second: Floats, length: float, params: SolverParams | None = None) -> Solution:
    """The chain's pose for two goals in order of priority.

    Args:
        chain: as captured.
        first: (F, 3) [m] goal of the chain's last joint (the ankle).
        second: (F, 3) [m] goal of the point beyond it (the ball), met as far as the first one allows.
        length: [m] of the chain, against which the tolerances are measured.
        params: how it steps.

    Returns:
        The pose.
    """
    params = params or SolverParams()
    axes = [np.asarray(axis, dtype=np.float64) for joint in chain.free for axis in joint]
    owner = np.array([j for j, joint in enumerate(chain.free) for _ in joint], dtype=np.intp)
    bounds: list[float] = []
    for joint, limit in zip(chain.free, chain.limits, strict=True):
        bounds.extend([np.inf] * len(joint) if limit is None else limit)
    bound = np.array(bounds)
    q = np.zeros((len(first), len(axes)))  # turned so far, as a rotation vector of each joint from the captured pose
    rounds = 0
    while rounds < params.iterations:
        rounds += 1
        locals_ = _turned(chain, q, axes, owner)
        places, turns = _places(chain, locals_)
        e1, e2 = first - places[-2], second - places[-1]
        step, settled = _step(chain, q, axes, owner, bound, places, turns, e1, e2, length, params)
        q = np.clip(q + step, -bound, bound)
        if settled:
            break
    locals_ = _turned(chain, q, axes, owner)
    places, _ = _places(chain, locals_)
    return Solution(locals_, places[-2], places[-1], rounds)


def _turned(chain: Chain, q: Floats, axes: Sequence[Floats], owner: Ints) -> Floats:
    """(F, J, 4) the captured rotations, each followed in its own frame by the turn that q describes."""
    out = chain.locals_.copy()
    for j in range(out.shape[1]):
        columns = np.flatnonzero(owner == j)
        if len(columns):
            vector = np.sum([q[:, [k]] * axes[k] for k in columns.tolist()], axis=0)
            out[:, j] = rotation.multiply(out[:, j], rotation.from_rotation_vector(vector))
    return out


def _places(chain: Chain, locals_: Floats) -> tuple[list[Floats], list[Floats]]:
    """Places of the joints and of the second effector, and the joints' frames in the world."""
    places, turns = [chain.base], []
    turn = chain.base_turn
    for j in range(locals_.shape[1]):
        turn = rotation.multiply(turn, locals_[:, j])
        turns.append(turn)
        places.append(places[-1] + rotation.rotate(turn, chain.bones[j]))
    return places, turns


def _step(
    chain: Chain, q: Floats, axes: Sequence[Floats], owner: Ints, bound: Floats, places: list[Floats],
    turns: list[Floats], e1: Floats, e2: Floats, length: float, params: SolverParams,
) -> tuple[Floats, bool]:  # fmt: skip
    """One iteration: (F, N) [rad], and whether every frame has settled.

    A joint that would leave its limits is put on it and taken out of the chain, and the step is found again without
    it, as Baerlocher and Boulic do.
    """
    frames, count = q.shape
    # d(place) / d(q_k) = axis_k x (place - joint_k), with the axis carried into the world by the turn so far
    j1, j2 = np.empty((frames, 3, count)), np.empty((frames, 3, count))
    for k in range(count):
        j = int(owner[k])
        column = _derivative(q, axes, owner, k)
        axis = rotation.rotate(turns[j], column)
        j1[:, :, k] = np.cross(axis, places[-2] - places[j])
        j2[:, :, k] = np.cross(axis, places[-1] - places[j])
    cap = params.step * length
    e1, e2 = _shortened(e1, cap), _shortened(e2, cap)
    # nearness: the chain as a whole swings no farther than it has to, then each joint
    root = np.flatnonzero(owner == 0)
    near = length * np.eye(count)[root]
    fixed = np.zeros((frames, count), dtype=np.bool_)
    step = np.zeros((frames, count))
    for _ in range(count):
        free = ~fixed[:, None, :]
        tasks = [(j1 * free, e1), (j2 * free, e2), (near * free, -params.nearness * length * q[:, root])]
        step = _prioritised([*tasks, (length * np.eye(count) * free, -params.nearness * length * q)], length, params)
        step = np.where(fixed, 0.0, step)
        largest = np.abs(step).max(axis=1, keepdims=True)
        step *= np.minimum(1.0, params.step / np.maximum(largest, 1e-300))
        leaves = ~fixed & (np.abs(q + step) > bound + 1e-12)
        if not np.any(leaves):
            break
        fixed |= leaves
        step = np.where(leaves, np.clip(q + step, -bound, bound) - q, step)
        moved = np.where(fixed, step, 0.0)
        e1 = e1 - np.einsum("fij,fj->fi", j1, np.where(leaves, moved, 0.0))
        e2 = e2 - np.einsum("fij,fj->fi", j2, np.where(leaves, moved, 0.0))
        q = np.where(leaves, q + moved, q)
    return step, bool(np.abs(step).max() < 1e-3 * params.tolerance)


def _derivative(q: Floats, axes: Sequence[Floats], owner: Ints, k: int) -> Floats:
    """(F, 3) the axis in the joint's new frame about which a change of q_k turns it: the right Jacobian of exp."""
    columns = np.flatnonzero(owner == owner[k])
    vector = np.sum([q[:, [c]] * axes[c] for c in columns.tolist()], axis=0)
    angle = np.linalg.norm(vector, axis=1)[:, None]
    small = angle < 1e-6
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 0.5, (1.0 - np.cos(safe)) / safe**2)
    b = np.where(small, 1.0 / 6.0, (safe - np.sin(safe)) / safe**3)
    once = np.cross(vector, axes[k])
    return np.asarray(axes[k] - a * once + b * np.cross(vector, once))


def _shortened(error: Floats, cap: float) -> Floats:
    distance = np.linalg.norm(error, axis=1, keepdims=True)
    return np.asarray(error * np.minimum(1.0, cap / np.maximum(distance, 1e-300)))


def _prioritised(tasks: Sequence[tuple[Floats, Floats]], length: float, params: SolverParams) -> Floats:
    """(F, N) [rad] the step that serves each task (its Jacobian, its error) in the freedom that those before leave.

    dq_k = dq_k-1 + (J_k N_k-1)+ (e_k - J_k dq_k-1),  N_k = N_k-1 - (J_k N_k-1)+ (J_k N_k-1), from dq = 0, N = I
    (Baerlocher and Boulic, section 3).
    """
    frames, _, count = tasks[0][0].shape
    dq, null = np.zeros((frames, count)), np.broadcast_to(np.eye(count), (frames, count, count))
    for jacobian, error in tasks:
        within = jacobian @ null
        rest = error - _times(jacobian, dq)
        inverse, rows = _inverse(within, rest, length, params)
        dq = dq + _times(inverse, rest)
        null = null - rows
    return dq


def _times(m: Floats, v: Floats) -> Floats:
    return np.asarray(np.einsum("fij,fj->fi", m, v))


def _inverse(j: Floats, error: Floats, length: float, params: SolverParams) -> tuple[Floats, Floats]:
    """Damped inverse (F, N, 3) of j (F, 3, N), and the projector (F, N, N) on the space its rows span.

    The damping fades with the error: before a goal out of reach the step is calm, near one in reach it is exact.
    """
    u, s, vt = np.linalg.svd(j, full_matrices=False)
    far = np.minimum(np.linalg.norm(error, axis=1) / length, 1.0)[:, None]
    damped = s / (s * s + (params.damping * length) ** 2 * far + (1e-9 * length) ** 2)
    spans = np.where(s > 1e-4 * length, 1.0, 0.0)
    v = vt.transpose(0, 2, 1)
    inverse: Floats = (v * damped[:, None, :]) @ u.transpose(0, 2, 1)
    rows: Floats = (v * spans[:, None, :]) @ vt
    return inverse, rows

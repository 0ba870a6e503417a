"""Prioritised damped least squares: inverse kinematics for a chain of any length.

Of several goals the first is met as well as the chain can, each further one in the freedom that those before leave
(its null space), and what is left brings the chain back to its captured pose (G section 5.1). All frames are solved
at once. Source: P. Baerlocher, R. Boulic, An inverse kinematics architecture enforcing an arbitrary number of strict
priority levels, The Visual Computer 20 (2004).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.two_bone_ik import CapturedLeg
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints, take_frames
from footfix.motion.kinematics import Pose
from footfix.motion.vectors import cross, dot, norm

_BENDS = 0.05  # [sine] a joint whose bones' angle changes by more than this over the clip is one that bends


@dataclass(frozen=True, kw_only=True)
class SolverParams:
    """Parameters of the iterative solver.

    Args:
        iterations: most iterations for a frame [count].
        tolerance: a frame is solved when no joint turns by more in an iteration [rad].
        damping: damping of the steps towards goals out of reach [leg lengths].
        step: greatest turn of a joint in one iteration [rad].
        approach: greatest motion towards a goal in one iteration, less than a foot's length [leg lengths].
    """

    iterations: int = 60
    tolerance: float = 1e-9
    damping: float = 0.02
    step: float = 0.3
    approach: float = 0.05


@dataclass(frozen=True, eq=False)
class Chain:
    """A chain of J joints as captured, over F frames, and the axes about which they may turn.

    Args:
        base: (F, 3) [m] place of the first joint.
        base_turn: (F, 4) the frame above it, in the world.
        bones: for each joint but the last the place of the next one in its frame, (F, 3) [m].
        effectors: points fixed in the frame of the last joint, (F, 3) [m] each, in order of priority.
        locals_: (F, J, 4) the joints' rotations as captured.
        axes: (N, F, 3) unit axes about which joints may turn, each in its joint's frame.
        owner: (N,) the joint that each axis belongs to, ascending.
    """

    base: Floats
    base_turn: Floats
    bones: tuple[Floats, ...]
    effectors: tuple[Floats, ...]
    locals_: Floats
    axes: Floats
    owner: Ints

    def frames(self, which: Ints) -> Chain:
        """Take the chain in some frames only."""
        bones, effectors = (tuple(each[which] for each in group) for group in (self.bones, self.effectors))
        above, axes = self.base_turn[which], self.axes[:, which]
        return Chain(self.base[which], above, bones, effectors, self.locals_[which], axes, self.owner)


@dataclass(frozen=True, eq=False)
class ChainPose:
    """A chain in a pose, in the world.

    Args:
        places: of each joint, (F, 3) [m].
        turns: each joint's frame, (F, 4).
        effectors: of each effector, (F, 3) [m].
    """

    places: tuple[Floats, ...]
    turns: tuple[Floats, ...]
    effectors: tuple[Floats, ...]


def leg_chain(clip: Clip, pose: Pose, leg: CapturedLeg, effectors: Sequence[Floats], which: Ints) -> Chain:
    """Make a leg's chain from hip to ankle.

    The hip and the ankle turn freely; the knee, and any other joint between them that bends in the clip, flexes about
    the knee's axis; one that does not (a twist bone) stays as it is.

    Args:
        clip: the clip.
        pose: from `rig.pose`.
        leg: as captured.
        effectors: tracks (F, 3) [m] in the world of points of its foot, in order of priority.
        which: (N,) the frames that are to be solved.
    """
    joints = leg.leg.chain
    above = int(clip.skeleton.parents[joints[0]])
    base_turn = pose.rotation(above)[which] if above >= 0 else rotation.identity((len(which),))
    free = np.broadcast_to(np.eye(3)[:, None], (3, len(which), 3))
    axes, owner = [free], [0, 0, 0]
    for k, joint in enumerate(joints[1:-1], start=1):
        if joint == leg.leg.knee or (clip.skeleton.rotates[joint] and _bends(pose, joints[k - 1 : k + 2])):
            hinge = rotation.rotate(rotation.inverse(pose.rotation(joint)), leg.knee_axis)
            axes.append(hinge[None, which])
            owner.append(k)
    last = len(joints) - 1
    return Chain(
        base=leg.hip[which],
        base_turn=base_turn,
        bones=tuple(take_frames(clip.position(joint), which) for joint in joints[1:]),
        effectors=tuple(leg.in_foot(point)[which] for point in effectors),
        locals_=np.stack([take_frames(clip.rotation(joint), which) for joint in joints], axis=1),
        axes=np.concatenate([*axes, free]),
        owner=np.array([*owner, last, last, last], dtype=np.intp),
    )


def _bends(pose: Pose, three: tuple[int, ...]) -> bool:
    """Say whether the angle at the middle one of three joints changes over the clip."""
    a, b, c = (pose.position(joint) for joint in three)
    lengths = norm(b - a) * norm(c - b)
    return float(np.ptp(norm(cross(b - a, c - b)) / np.maximum(lengths, 1e-12))) > _BENDS


def solve(
    chain: Chain, goals: Sequence[Floats], length: float, params: SolverParams, start: Floats | None = None
) -> Floats:
    """Find the chain's pose for goals in order of priority.

    Args:
        chain: as captured.
        goals: for each effector (F, 3) [m].
        length: [m] of the chain, against which errors are measured.
        params: how it steps.
        start: (F, N) [rad] turned about each axis at first; nothing by default.

    Returns:
        (F, N) [rad] how far each axis is turned from the captured pose: together the rotation vectors of the joints.
    """
    q = np.zeros((len(chain.base), len(chain.owner))) if start is None else start.copy()
    left = np.arange(len(q))  # the frames that are not solved yet
    part = chain
    for _ in range(params.iterations):
        step = _step(part, q[left], [goal[left] for goal in goals], length, params)
        q[left] += step
        moves = np.abs(step).max(axis=1) > params.tolerance
        if not np.any(moves):
            break
        if not np.all(moves):
            left = left[moves]
            part = chain.frames(left)
    return q


def turned(chain: Chain, q: Floats) -> Floats:
    """Follow each captured rotation, in its own frame, by the turn that q (F, N) [rad] describes: (F, J, 4)."""
    out = chain.locals_.copy()
    for j in sorted(set(chain.owner.tolist())):
        out[:, j] = rotation.multiply(out[:, j], rotation.from_rotation_vector(_vector(chain, q, j)))
    return out


def _vector(chain: Chain, q: Floats, joint: int) -> Floats:
    """Compute the rotation vector by which a joint is turned, in its own frame, (F, 3) [rad]."""
    own = chain.owner == joint
    return np.asarray(np.einsum("fn,nfi->fi", q[:, own], chain.axes[own]))


def posed(chain: Chain, locals_: Floats) -> ChainPose:
    """Place the chain with local rotations (F, J, 4) in the world."""
    places, turns = [chain.base], []
    turn = chain.base_turn
    for j in range(locals_.shape[1]):
        turn = rotation.multiply(turn, locals_[:, j])
        turns.append(turn)
        if j < len(chain.bones):
            places.append(places[-1] + rotation.rotate(turn, chain.bones[j]))
    ends = tuple(places[-1] + rotation.rotate(turn, effector) for effector in chain.effectors)
    return ChainPose(tuple(places), tuple(turns), ends)


def jacobians(chain: Chain, q: Floats, pose: ChainPose) -> list[Floats]:
    """Derive each effector's place by q (F, N) [rad]: (F, 3, N) [m/rad] each."""
    out = [np.empty((*q.shape[:1], 3, q.shape[1])) for _ in pose.effectors]
    for k, j in enumerate(chain.owner.tolist()):
        # d(place) / d(q_k) = axis_k x (place - joint), the axis carried into the world by the joint's new frame
        axis = rotation.rotate(pose.turns[j], _moving_axis(chain.axes[k], _vector(chain, q, j)))
        for jacobian, place in zip(out, pose.effectors, strict=True):
            jacobian[:, :, k] = cross(axis, place - pose.places[j])
    return out


def _moving_axis(axis: Floats, vector: Floats) -> Floats:
    """Find the axis (F, 3), in the joint's new frame, about which more of `axis` in its rotation vector turns it.

    The right Jacobian of the exponential map: a - (1 - cos v) / v^2 (v x a) + (v - sin v) / v^3 v x (v x a).
    """
    angle = norm(vector)[:, None]
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    first = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    second = np.where(small, 1.0 / 6.0, (safe - np.sin(safe)) / safe**3)
    once = cross(vector, axis)
    return np.asarray(axis - first * once + second * cross(vector, once))


def _step(chain: Chain, q: Floats, goals: Sequence[Floats], length: float, params: SolverParams) -> Floats:
    """Compute one iteration, (F, N) [rad]: the step that serves each goal in the freedom that those before it leave.

    dq_k = dq_k-1 + (J_k N_k-1)+ (e_k - J_k dq_k-1),  N_k = N_k-1 - (J_k N_k-1)+ (J_k N_k-1),  dq_0 = 0, N_0 = 1
    (Baerlocher and Boulic, section 3).
    """
    frames, count = q.shape
    pose = posed(chain, turned(chain, q))
    tasks = [
        (jacobian, _shortened(goal - place, params.approach * length))
        for jacobian, goal, place in zip(jacobians(chain, q, pose), goals, pose.effectors, strict=True)
    ]
    # stay near the capture: the chain as a whole turns no farther than necessary
    whole = np.broadcast_to(length * np.eye(count)[chain.owner == 0], (frames, 3, count))
    tasks.append((whole, -length * q[:, chain.owner == 0]))
    dq, null = np.zeros((frames, count)), np.broadcast_to(np.eye(count), (frames, count, count))
    for jacobian, error in tasks:
        within = jacobian @ null
        rest = error - _times(jacobian, dq)
        inverse, spanned = _damped_inverse(within, rest, length, params.damping)
        dq = dq + _times(inverse, rest)
        null = null - spanned
    # and then each joint turns no farther: J = 1, e = -q
    dq = dq + _times(null, -q - dq)
    largest = np.abs(dq).max(axis=1, keepdims=True)
    return np.asarray(dq * np.minimum(1.0, params.step / np.maximum(largest, 1e-300)))


def _shortened(error: Floats, most: float) -> Floats:
    return np.asarray(error * np.minimum(1.0, most / np.maximum(norm(error), 1e-300))[:, None])


def _times(m: Floats, v: Floats) -> Floats:
    return np.asarray((m @ v[:, :, None])[:, :, 0])


def _damped_inverse(j: Floats, error: Floats, length: float, damping: float) -> tuple[Floats, Floats]:
    """Invert j (F, 3, N) with damping, (F, N, 3); give the projector (F, N, N) on the space its rows span, too.

    The damping fades with the error: near a goal within reach the step is exact, towards one out of reach it is small.
    """
    # j = U diag(s) V^T, of which s^2 and U are found from j j^T
    square, u = np.linalg.eigh(j @ j.transpose(0, 2, 1))
    spans = square > (1e-4 * length) ** 2
    far = np.minimum(np.sqrt(dot(error, error)) / length, 1.0)[:, None]
    damped = np.where(spans, 1.0 / np.where(spans, square + (damping * length) ** 2 * far, 1.0), 0.0)
    plain = np.where(spans, 1.0 / np.where(spans, square, 1.0), 0.0)
    su = j.transpose(0, 2, 1) @ u  # V diag(s), (F, N, 3)
    inverse: Floats = (su * damped[:, None, :]) @ u.transpose(0, 2, 1)
    spanned: Floats = (su * plain[:, None, :]) @ su.transpose(0, 2, 1)
    return inverse, spanned

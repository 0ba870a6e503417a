"""Glardon's enforcement: eased effectors, solved by inverse kinematics with priorities.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), section 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.easing import Span, ease_frames, eased
from footfix.enforce.footplant import Footplant
from footfix.enforce.papers.priorities import Chain, SolverParams, leg_chain, solve, turned
from footfix.enforce.papers.rigid_foot import PARTS, Displacement, FootGoal, foot_goal, held, planted
from footfix.enforce.papers.targets import TargetParams, legs_to_hold, targets
from footfix.enforce.two_bone_ik import (
    CapturedLeg,
    captured_leg,
    correction_of,
    flexion_for,
    local_rotations,
    two_bones,
    where_moved,
    within_reach,
)
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig


@dataclass(frozen=True, kw_only=True)
class GlardonParams:
    """How Glardon's method holds plants.

    Args:
        ease: how long before a contact its correction begins, and after it ends (sigma) [s].
        targets: where plants stand.
        solver: how it steps.
    """

    ease: float = 0.3
    targets: TargetParams = field(default_factory=TargetParams)
    solver: SolverParams = field(default_factory=SolverParams)


def correct(
    clip: Clip, rig: Rig, plants: Sequence[Footplant], params: GlardonParams, *, ground: Floats | None = None
) -> Correction:
    """Hold plants by Glardon's method (G §5): the root stays as captured, the legs turn.

    Each plant's effector stays at its C_p from the first to the last frame of its contact, and its displacement is
    eased in before and out after it. A goal out of a leg's reach is moved into it.

    Args:
        clip: F frames, metres, y up.
        rig: its legs, soles and floor.
        plants: what is to stand; where they end up is read from the corrected clip.
        params: of the method.
        ground: (F, 3) [m] displacement of the ground under planted feet, as of a belt; none by default.

    Returns:
        The correction. Legs whose hip, knee or ankle has no rotation channels are left alone.
    """
    pose = rig.pose(clip)
    ground = np.zeros((len(clip), 3)) if ground is None else ground
    tracks = rig.held(pose)
    places = targets(rig, rig.tracks(pose), tracks, plants, ground, params.targets)
    sigma = ease_frames(params.ease, clip.frame_time)
    new: dict[int, Floats] = {}
    for number, own in legs_to_hold(clip, rig, plants):
        leg = captured_leg(rig, pose, number, tracks)
        heel, toe = (
            _eased(*held(leg, part, [plants[k] for k in own], [places[k] for k in own], ground), sigma)
            for part in PARTS
        )
        goal = foot_goal(leg, heel, toe, sigma)
        if np.any(goal.moves):
            new.update(where_moved(clip, _solved(clip, pose, leg, goal, rig.leg_length, params.solver), goal.moves))
    return correction_of(clip, rig, new)


def _eased(spans: Sequence[Span], needed: Floats, sigma: int) -> Displacement:
    """Ease the displacement of an effector around its contacts (G eq. 9)."""
    return Displacement(eased(spans, needed, sigma), planted(spans, len(needed)))


def _solved(
    clip: Clip, pose: Pose, leg: CapturedLeg, goal: FootGoal, leg_length: float, params: SolverParams
) -> dict[int, Floats]:
    """Solve the local rotations (F, 4) of the joints of a leg, in the frames in which its goal moves.

    The heel comes first, then the toe (G §5.1: the ankle's effectors have the highest priority); the ankle, which
    says how the foot lies about the line of both, belongs to nearness.
    """
    which = np.flatnonzero(goal.moves)
    effectors = (leg.heel, leg.toe, leg.ankle)
    reached = within_reach(leg, goal.ankle)
    drawn = reached - goal.ankle
    goals = [(goal.place(leg.in_foot(point)) + drawn)[which] for point in effectors]
    chain = leg_chain(clip, pose, leg, effectors, which)
    start = _two_bones_start(clip, pose, leg, FootGoal(reached, goal.turn, goal.moves), chain, which)
    found = turned(chain, solve(chain, goals, leg_length, params, start))
    new = {}
    for k, joint in enumerate(leg.leg.chain):
        if k in chain.owner:
            new[joint] = np.array(clip.rotation(joint))
            new[joint][which] = found[:, k]
    return new


def _two_bones_start(
    clip: Clip, pose: Pose, leg: CapturedLeg, goal: FootGoal, chain: Chain, which: Ints
) -> Floats:  # fmt: skip
    """Compute the closed-form solution of the leg as two bones, (N, axes) [rad], from which the solver starts.

    From the captured pose it would not know which way a straight knee bends, nor a foot turns that points backwards.
    """
    start = np.zeros((len(which), len(chain.owner)))
    new = local_rotations(clip, pose, leg, two_bones(leg, goal.ankle), goal.turn)
    for joint in (leg.leg.hip, leg.leg.ankle):
        turn = rotation.multiply(rotation.inverse(clip.rotation(joint)), new[joint])[which]
        start[:, chain.owner == leg.leg.chain.index(joint)] = rotation.to_rotation_vector(turn)
    knee = leg.leg.chain.index(leg.leg.knee)
    start[:, chain.owner == knee] = (flexion_for(leg, goal.ankle) - leg.flexion)[which, None]
    return start

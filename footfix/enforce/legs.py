"""Enforcement by the legs: goals of the feet, a root that gives way, two bones a leg; and its judgement.

What holding a plant would do to the joints is looked at before it is done: where a joint would have to turn much
faster than it was captured to, the foot is held there only as far as it slides slowly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footfix.enforce import ik, reach, root
from footfix.enforce.correction import Correction
from footfix.enforce.ease import EaseParams, presence, within_reach
from footfix.enforce.foot import Foot, can_turn
from footfix.enforce.judge import JudgeParams, hurry_of, let_go, peeled
from footfix.enforce.plants import Stance
from footfix.enforce.priorities import leg_chain, solve
from footfix.enforce.reach import ReachParams
from footfix.enforce.root import RootParams
from footfix.enforce.targets import Goals, goals, lifted, rolled
from footfix.enforce.toe import Toe, bend, local_rotation, on_ground, toe_of, with_toe_bent
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig


@dataclass(frozen=True, eq=False)
class Solved:
    """One solution for all legs.

    Args:
        shift: (F, 3) [m] of the root.
        rotations: new local rotations (F, 4) by joint.
        points: (F, 3) [m] track of each sole point.
        hurry: for each leg (F,) [deg/s] by which its joints turn faster than captured.
    """

    shift: Floats
    rotations: dict[int, Floats]
    points: tuple[Floats, ...]
    hurry: tuple[Floats, ...]


@dataclass(frozen=True, kw_only=True)
class LegParams:
    """The parts of the settings that the legs need."""

    solver: str = "closed"
    shares: bool = False  # the root takes what all planted feet share
    strength: float = 1.0
    sink: float = 0.003
    toe_sink: float = 0.008
    ease: EaseParams = field(default_factory=EaseParams)
    reach: ReachParams = field(default_factory=ReachParams)
    root: RootParams = field(default_factory=RootParams)
    judge: JudgeParams = field(default_factory=JudgeParams)


@dataclass(frozen=True, eq=False)
class Held:
    """What became of the legs.

    Args:
        correction: without residuals.
        points: (F, 3) [m] for each sole point the track that it leads to.
        stands: the stances with the frames in which they are held after all.
        soft: for each leg (F,) [s] how softly.
    """

    correction: Correction
    points: tuple[Floats, ...]
    stands: tuple[Stance, ...]
    soft: tuple[Floats, ...]


def enforced(
    clip: Clip, rig: Rig, pose: Pose, legs: Sequence[Foot], stands: Sequence[Stance], params: LegParams
) -> Held:
    """The correction by the legs.

    Args:
        clip: as captured.
        rig: its legs.
        pose: of the clip, from `foot.posed`.
        legs: their tracks, on the floor's own ground (see `ground`).
        stands: the stances that are to hold.
        params: measures.

    Returns:
        The correction and what it holds. Where holding would make a joint hurry, a plant first gives up frames at
        its edges, whose labels are the least certain, then lets go of what slides quickly.
    """
    judge = params.judge
    judges = params.ease.method == "smooth" and judge.speed > 0.0
    stands = tuple(stands)
    soft = [np.zeros(len(clip)) for _ in legs]
    forced = [np.zeros(len(clip), dtype=np.bool_) for _ in legs]  # held whatever it costs
    for stance in stands:
        for plant in stance.plants:
            forced[stance.leg][plant.frames] |= plant.contact.wish == "force"
    levels = (0.0, *judge.softness)
    solved = _solve(clip, rig, pose, legs, stands, soft, params)
    rounds = [None, None, *range(len(judge.softness))] if judges else []
    for level in rounds:
        bound = judge.speed * (1.0 if level is None else judge.soften)
        hurried = [hurry > bound for hurry in solved.hurry]
        if not any(np.any(each) for each in hurried):
            if level is None:
                continue
            break
        if level is None:
            shorter = tuple(peeled(stance, hurried[stance.leg], clip.frame_time, judge) for stance in stands)
            if all(new is old for new, old in zip(shorter, stands, strict=True)):
                continue
            stands = shorter
        else:
            for k, each in enumerate(hurried):
                around = within_reach(each, clip.frame_time, judge.around) & ~forced[k]
                soft[k] = np.where(around & (soft[k] <= levels[level]), levels[level + 1], soft[k])
        solved = _solve(clip, rig, pose, legs, stands, soft, params)
    if judges and any(np.any(each) for each in soft):
        fewer = tuple(let_go(stance, solved.points, soft[stance.leg], rig.leg_length, judge) for stance in stands)
        if any(new is not old for new, old in zip(fewer, stands, strict=True)):
            stands = fewer
            solved = _solve(clip, rig, pose, legs, stands, soft, params)
    joints = tuple(sorted(solved.rotations))
    columns = [solved.rotations[joint] for joint in joints]
    rotations = np.stack(columns, axis=1) if columns else np.zeros((len(clip), 0, 4))
    nothing = np.zeros((len(clip), len(rig.soles)))
    correction = Correction(rig.root, solved.shift, joints, rotations, nothing)
    return Held(correction, solved.points, stands, tuple(soft))


def _solve(
    clip: Clip,
    rig: Rig,
    pose: Pose,
    legs: Sequence[Foot],
    stands: Sequence[Stance],
    soft: Sequence[Floats],
    params: LegParams,
) -> Solved:
    able = [can_turn(clip, foot.leg) for foot in legs]
    new: dict[int, Floats] = {}
    wanted = []
    bends: list[tuple[Toe, Floats] | None] = []
    legs = list(legs)
    for k, foot in enumerate(legs):
        own = [stance for stance in stands if stance.leg == k and able[k]]
        goal = goals(foot, own, clip.frame_time, params.ease, soft[k])
        toe = toe_of(clip, rig, pose, foot)
        bends.append(None)
        if toe is not None:
            toe = on_ground(toe, foot, pose)
            vector = bend(toe, foot, goal, params.toe_sink * rig.leg_length, clip.frame_time, params.ease)
            if np.any(vector):
                bends[k] = (toe, params.strength * vector)
                legs[k] = foot = with_toe_bent(foot, toe, goal, params.strength * vector)
                goal = goals(foot, own, clip.frame_time, params.ease, soft[k])
        goal = lifted(goal, foot, params.sink * rig.leg_length, clip.frame_time, params.ease, soft[k])
        wanted.append(replace(goal, turn=params.strength * goal.turn, shift=params.strength * goal.shift))
    shift = np.zeros((len(clip), 3))
    movable = bool(clip.skeleton.translates[rig.root])
    if params.shares and movable:
        planted, shifts = [goal.planted for goal in wanted], [goal.shift for goal in wanted]
        shift = root.shared(planted, shifts, clip.frame_time, params.ease, params.root)
    ankles = [goal.ankle(foot) for foot, goal in zip(legs, wanted, strict=True)]
    hips = [foot.hip + shift for foot in legs]
    limits = [reach.allowed(foot, hip, at, params.reach) for foot, hip, at in zip(legs, hips, ankles, strict=True)]
    if movable:
        planted = [goal.planted for goal in wanted]
        lower = reach.lowering(hips, ankles, limits, planted, clip.frame_time, rig.leg_length, params.reach)
        shift[:, 1] -= lower
    points: list[Floats] = [np.zeros((0, 3))] * len(rig.soles)
    hurry = []
    for k, (foot, goal) in enumerate(zip(legs, wanted, strict=True)):
        goal, ankle = _reached(foot, goal, foot.hip + shift, limits[k], clip.frame_time, params, soft[k])
        turn = goal.foot_turn(foot)
        changed = np.any(np.concatenate([goal.shift, goal.turn, shift], axis=1) != 0.0, axis=1)
        turned = _turned(clip, pose, foot, turn, shift, ankle, changed, params) if able[k] else {}
        new.update(turned)
        bent = bends[k]
        if bent is not None and turned:
            new[bent[0].joint] = local_rotation(clip, bent[0], turn, foot, bent[1])
        hurry.append(hurry_of(clip, turned))
        for e, at in zip(foot.effectors, (foot.heel_in_foot, foot.ball_in_foot), strict=True):
            points[e] = ankle + rotation.rotate(turn, at)
    return Solved(shift, new, tuple(points), tuple(hurry))


def _reached(
    foot: Foot, goal: Goals, hip: Floats, limit: Floats, frame_time: float, params: LegParams, soft: Floats
) -> tuple[Goals, Floats]:
    """The goals, and the ankle (F, 3) [m], within reach: the foot rolls on the end it stands on, then gives way."""
    in_foot = np.where(goal.on_ball[:, None], foot.ball_in_foot, foot.heel_in_foot)
    pivot = goal.ankle(foot) + rotation.rotate(goal.foot_turn(foot), in_foot)
    roll = reach.rolled(hip, goal.ankle(foot), pivot, limit, goal.planted, np.radians(params.reach.roll))
    goal = rolled(goal, foot, roll, frame_time, params.ease, soft)
    return goal, reach.clamp(hip, goal.ankle(foot), limit)


def _turned(
    clip: Clip, pose: Pose, foot: Foot, turn: Floats, shift: Floats, ankle: Floats, changed: Bools, params: LegParams
) -> dict[int, Floats]:
    """New local rotations of one leg's joints; the clip's own numbers where nothing changes."""
    if not np.any(changed):
        return {}
    axis = ik.knee_axis(foot, pose.rotation(foot.leg.hip))
    share = presence(changed, clip.frame_time, params.ease.lead)
    if params.solver == "priorities":
        return _by_priorities(clip, pose, foot, axis, foot.hip + shift, ankle, turn, changed)
    turns = ik.two_bones(foot, axis, foot.hip + shift, ankle, share)
    local = ik.local_rotations(clip, pose, foot, turns, turn)
    return {joint: np.where(changed[:, None], q, clip.rotations[:, joint]) for joint, q in local.items()}


def _by_priorities(
    clip: Clip, pose: Pose, foot: Foot, axis: Floats, hip: Floats, ankle: Floats, turn: Floats, changed: Bools
) -> dict[int, Floats]:
    """The same from the prioritised solver: every joint of the chain that bends takes its part."""
    chain = leg_chain(clip, pose, foot, axis, changed)
    chain = replace(chain, base=hip[changed])
    goal, foot_turn = ankle[changed], turn[changed]
    ball = goal + rotation.rotate(foot_turn, foot.ball_in_foot[changed])
    thigh, shank = foot.knee - foot.hip, foot.ankle - foot.knee
    length = float(np.median(np.linalg.norm(thigh, axis=1) + np.linalg.norm(shank, axis=1)))
    found = solve(chain, goal, ball, length)
    above = chain.base_turn
    for k in range(len(foot.leg.chain) - 1):
        above = rotation.multiply(above, found.locals_[:, k])
    new = {}
    for k, joint in enumerate(foot.leg.chain):
        local = found.locals_[:, k]
        if joint == foot.leg.ankle:  # what is left of the foot's turn, about the line from ankle to ball
            local = rotation.multiply(rotation.inverse(above), foot_turn)
        new[joint] = clip.rotations[:, joint].copy()
        new[joint][changed] = rotation.normalize(local)
    return new

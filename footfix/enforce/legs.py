"""Enforcement by the legs: goals of the feet, a root that gives way, two bones a leg; and its judgement.

What holding a plant would do to the joints is looked at before it is done: where a joint would have to turn much
faster than it was captured to, the foot is held there only as far as it slides slowly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce import ik, reach, root
from footfix.enforce.correction import Correction
from footfix.enforce.ease import EaseParams, covered, displacement, ease_frames, presence, within_reach
from footfix.enforce.foot import Foot, can_turn
from footfix.enforce.judge import JudgeParams, hurry_of, let_go, peeled
from footfix.enforce.plants import PlantParams, Stance
from footfix.enforce.priorities import leg_chain, solve
from footfix.enforce.reach import ReachParams
from footfix.enforce.root import RootParams
from footfix.enforce.targets import Goals, goals, lacks, lifted, rolled
from footfix.enforce.toe import Toe, bend, firm, local_rotation, toe_of, with_toe_bent
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.kinematics import Pose
from footfix.motion.vectors import norm
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
    """The parts of the settings that the legs need; `shares`: the root takes what all planted feet share."""

    solver: str
    shares: bool
    strength: float
    plants: PlantParams
    ease: EaseParams
    reach: ReachParams
    root: RootParams
    judge: JudgeParams


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

    @property
    def let_go(self) -> int:
        """How many stances have plants that were let go."""
        return sum(stance.released for stance in self.stands)


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
        The correction and what it holds, judged (see `judge`).
    """
    stands = tuple(stands)
    soft = tuple(np.zeros(len(clip)) for _ in legs)
    solved = _solve(clip, rig, pose, legs, stands, soft, params)
    wide = replace(params.judge, peel_most=2.0 * params.judge.peel_most, peel_share=0.5)
    if params.ease.method == "smooth" and params.judge.speed > 0.0:
        for level in (None, None, *range(len(params.judge.softness))):
            changed = _given_way(clip, solved, stands, soft, level, params.judge)
            if changed is not None:
                stands, soft = changed
                solved = _solve(clip, rig, pose, legs, stands, soft, params)
        for last in (False, True, True):
            hurried = [hurry > params.judge.most * params.judge.speed for hurry in solved.hurry]
            fewer = tuple(
                let_go(s, solved.points, soft[s.leg], hurried[s.leg], rig.leg_length, params.plants, params.judge)
                if last else peeled(s, hurried[s.leg], clip.frame_time, wide) for s in stands
            )
            if all(new is old for new, old in zip(fewer, stands, strict=True)):
                continue
            stands = fewer
            solved = _solve(clip, rig, pose, legs, stands, soft, params)
    joints = tuple(sorted(solved.rotations))
    columns = [solved.rotations[joint] for joint in joints]
    rotations = np.stack(columns, axis=1) if columns else np.zeros((len(clip), 0, 4))
    nothing = np.zeros((len(clip), len(rig.soles)))
    correction = Correction(rig.root, solved.shift, joints, rotations, nothing)
    return Held(correction, solved.points, stands, soft)


def _given_way(
    clip: Clip,
    solved: Solved,
    stands: tuple[Stance, ...],
    soft: tuple[Floats, ...],
    level: int | None,
    judge: JudgeParams,
) -> tuple[tuple[Stance, ...], tuple[Floats, ...]] | None:
    """Stances and softness where joints hurry: plants without their edges, or (at a `level`) holds that are softer.

    None where nothing changes.
    """
    bound = judge.speed * (1.0 if level is None else judge.soften)
    hurried = [hurry > bound for hurry in solved.hurry]
    if not any(np.any(each) for each in hurried):
        return None
    if level is None:
        shorter = tuple(peeled(stance, hurried[stance.leg], clip.frame_time, judge) for stance in stands)
        return None if all(new is old for new, old in zip(shorter, stands, strict=True)) else (shorter, soft)
    forced = [np.zeros(len(clip), dtype=np.bool_) for _ in soft]  # held whatever it costs
    for stance in stands:
        for plant in stance.plants:
            forced[stance.leg][plant.frames] |= plant.contact.wish == "force"
    before = (0.0, *judge.softness)[level]
    softer = []
    for each, free, now in zip(hurried, forced, soft, strict=True):
        around = within_reach(each, clip.frame_time, judge.around) & ~free
        softer.append(np.where(around & (now <= before), judge.softness[level], now))
    return stands, tuple(softer)


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
    aims = [
        _aim(clip, rig, pose, foot, [s for s in stands if s.leg == k and able[k]], soft[k], params)
        for k, foot in enumerate(legs)
    ]
    shift, limits = _root_shift(clip, rig, aims, params)
    new: dict[int, Floats] = {}
    points: list[Floats] = [np.zeros((0, 3))] * len(rig.soles)
    hurry = []
    for k, aim in enumerate(aims):
        foot = aim.foot
        goal, ankle = _reached(foot, aim.goal, foot.hip + shift, limits[k], clip.frame_time, params, soft[k])
        turn = goal.foot_turn(foot)
        turned: dict[int, Floats] = {}
        if able[k] and (np.any(goal.planted) or np.any(shift)):
            bent, ankle, changed = _bent(
                pose, foot, goal, foot.hip + shift, ankle, clip.frame_time, rig.leg_length, params
            )
            turned = _turned(clip, pose, foot, turn, shift, bent, ankle, changed, params)
        new.update(turned)
        if aim.toe is not None and turned:
            new[aim.toe.joint] = local_rotation(clip, aim.toe, turn, foot, aim.bend)
        hurry.append(hurry_of(clip, turned))
        for e, at in zip(foot.effectors, (foot.heel_in_foot, foot.ball_in_foot), strict=True):
            points[e] = ankle + rotation.rotate(turn, at)
    return Solved(shift, new, tuple(points), tuple(hurry))


@dataclass(frozen=True, eq=False)
class _Aim:
    """What one leg is to do: the foot, its toes if they bend and by which rotation vector (F, 3), and its goals."""

    foot: Foot
    toe: Toe | None
    bend: Floats
    goal: Goals


def _aim(
    clip: Clip, rig: Rig, pose: Pose, foot: Foot, own: list[Stance], soft: Floats, params: LegParams
) -> _Aim:
    toe, vector = toe_of(clip, rig, pose, foot), np.zeros((len(clip), 3))
    if toe is not None and params.strength > 0.0:
        quiver = params.plants.quiver * rig.leg_length
        toe, foot = firm(toe, foot, own, quiver, clip.frame_time, params.ease)
    goal = goals(foot, own, clip.frame_time, params.ease, soft)
    if toe is not None:
        depth = params.plants.toe_sink * rig.leg_length
        vector = params.strength * bend(toe, foot, goal, depth, clip.frame_time, params.ease)
        if np.any(vector):
            foot = with_toe_bent(foot, toe, vector)
            goal = goals(foot, own, clip.frame_time, params.ease, soft)
    goal = lifted(goal, foot, params.plants.sink * rig.leg_length, clip.frame_time, params.ease, soft)
    goal = replace(goal, turn=params.strength * goal.turn, shift=params.strength * goal.shift)
    return _Aim(foot, toe if toe is not None and (np.any(vector) or np.any(toe.moved)) else None, vector, goal)


def _root_shift(clip: Clip, rig: Rig, aims: Sequence[_Aim], params: LegParams) -> tuple[Floats, list[Floats]]:
    """(F, 3) [m] of the root, and for each leg (F,) [m] how far its ankle may be from its hip."""
    shift = np.zeros((len(clip), 3))
    movable = bool(clip.skeleton.translates[rig.root])
    planted = [aim.goal.planted for aim in aims]
    if movable:
        shift = root.shared(planted, [aim.goal.shift for aim in aims], clip.frame_time, params.ease, params.root)
        if not params.shares:
            shift[:, [0, 2]] = 0.0
    ankles = [aim.goal.ankle(aim.foot) for aim in aims]
    hips = [aim.foot.hip + shift for aim in aims]
    limits = [reach.allowed(aims[k].foot, hips[k], ankles[k], params.reach) for k in range(len(aims))]
    if movable:
        shift[:, 1] -= reach.lowering(hips, ankles, limits, planted, clip.frame_time, rig.leg_length, params.reach)
    return shift, limits


def _reached(
    foot: Foot, goal: Goals, hip: Floats, limit: Floats, frame_time: float, params: LegParams, soft: Floats
) -> tuple[Goals, Floats]:
    """The goals, and the ankle (F, 3) [m], within reach: the foot rolls on the end it stands on, then gives way."""
    in_foot = np.where(goal.on_ball[:, None], foot.ball_in_foot, foot.heel_in_foot)
    pivot = goal.ankle(foot) + rotation.rotate(goal.foot_turn(foot), in_foot)
    roll = reach.rolled(hip, goal.ankle(foot), pivot, limit, goal.planted, np.radians(params.reach.roll))
    goal = rolled(goal, foot, roll, frame_time, params.ease, soft)
    return goal, reach.clamp(hip, goal.ankle(foot), limit)


def _bent(
    pose: Pose, foot: Foot, goal: Goals, hip: Floats, ankle: Floats, frame_time: float, leg_length: float,
    params: LegParams,
) -> tuple[ik.Knee, Floats, Bools]:  # fmt: skip
    """The knee, the ankle (F, 3) [m] that it leads to, and the frames (F,) in which anything changes.

    Where the foot is held, the knee is bent as that needs. Elsewhere not the place of the foot leads over but the
    bend of the knee: of a straight leg, some millimetres of the foot are many degrees of the knee.
    """
    bent = ik.knee(foot, ik.knee_axis(foot, pose.rotation(foot.leg.hip)), hip, ankle, goal.planted)
    moved = np.any((hip != foot.hip) | (goal.turn != 0.0) | (goal.shift != 0.0), axis=1)
    if params.ease.method != "smooth":
        return bent, ankle, moved
    more = np.where(moved, bent.flexion - bent.captured, 0.0)
    eased = displacement(goal.planted, more[:, None], goal.near, frame_time, params.ease)[:, 0]
    free = ~goal.planted
    bent = replace(bent, flexion=np.where(free, ik.not_too_straight(bent.captured, eased), bent.flexion))
    led = ik.two_bones(foot, bent, hip, ankle).ankle(foot, hip)
    low = lacks(goal, foot, led, params.plants.sink * leg_length)
    if not np.any(low):
        return bent, led, moved
    # raised along the leg, and as much around as keeps the knee's way smooth
    line = hip - led
    raised = led + line * (low / np.maximum(line[:, 1], 0.5 * norm(line)))[:, None]
    lacking = np.where(low > 0.0, ik.knee(foot, bent.axis, hip, raised, goal.planted).flexion - bent.flexion, 0.0)
    cover = covered(np.maximum(lacking, 0.0), ease_frames(frame_time, 0.5 * params.ease.lead))
    cover *= presence(goal.near & free, frame_time, 0.5 * params.ease.lead)
    bent = replace(bent, flexion=bent.flexion + cover)
    return bent, ik.two_bones(foot, bent, hip, led).ankle(foot, hip), moved | (cover > 0.0)


def _turned(
    clip: Clip,
    pose: Pose,
    foot: Foot,
    turn: Floats,
    shift: Floats,
    bent: ik.Knee,
    ankle: Floats,
    changed: Bools,
    params: LegParams,
) -> dict[int, Floats]:
    """New local rotations of one leg's joints; the clip's own numbers where nothing changes."""
    if params.solver == "priorities":
        return _by_priorities(clip, pose, foot, bent.axis, foot.hip + shift, ankle, turn, changed)
    turns = ik.two_bones(foot, bent, foot.hip + shift, ankle)
    local = ik.local_rotations(clip, pose, foot, turns, turn)
    return {joint: np.where(changed[:, None], q, clip.turn(joint)) for joint, q in local.items()}


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
        new[joint] = clip.turn(joint).copy()
        new[joint][changed] = rotation.normalize(local)
    return new

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
from footfix.enforce.plants import Stance
from footfix.enforce.reach import ReachParams
from footfix.enforce.root import RootParams
from footfix.enforce.targets import Goals, goals
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig


@dataclass(frozen=True, kw_only=True)
class JudgeParams:
    """What holding a foot may do to the joints of its leg."""

    speed: float = 200.0  # [deg/s] by which a joint may turn faster than captured before the hold softens
    softness: tuple[float, ...] = (0.04, 0.08, 0.16)  # [s] the hold's steps: slower slides than this are still held
    around: float = 0.06  # [s] on either side of such a frame


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

    shares: bool = False  # the root takes what all planted feet share
    strength: float = 1.0
    ease: EaseParams = field(default_factory=EaseParams)
    reach: ReachParams = field(default_factory=ReachParams)
    root: RootParams = field(default_factory=RootParams)
    judge: JudgeParams = field(default_factory=JudgeParams)


def enforced(
    clip: Clip, rig: Rig, pose: Pose, legs: Sequence[Foot], stands: Sequence[Stance], params: LegParams
) -> tuple[Correction, tuple[Floats, ...], tuple[Floats, ...]]:
    """The correction by the legs.

    Args:
        clip: as captured.
        rig: its legs.
        pose: of the clip, from `foot.posed`.
        legs: their tracks, on the floor's own ground (see `ground`).
        stands: the stances that are to hold.
        params: measures.

    Returns:
        The correction without residuals, the (F, 3) tracks of the sole points that it leads to, and for each leg
        how softly (F,) [s] it was held.
    """
    soft = [np.zeros(len(clip)) for _ in legs]
    steps = (0.0, *params.judge.softness)
    for step, following in zip(steps, (*steps[1:], None), strict=True):
        solved = _solve(clip, rig, pose, legs, stands, soft, params)
        if following is None or params.ease.method != "smooth" or params.judge.speed <= 0.0:
            break
        hurried = [hurry > params.judge.speed for hurry in solved.hurry]
        if not any(np.any(each) for each in hurried):
            break
        for k, each in enumerate(hurried):
            around = within_reach(each, clip.frame_time, params.judge.around)
            soft[k] = np.where(around & (soft[k] <= step), following, soft[k])
    joints = tuple(sorted(solved.rotations))
    columns = [solved.rotations[joint] for joint in joints]
    rotations = np.stack(columns, axis=1) if columns else np.zeros((len(clip), 0, 4))
    nothing = np.zeros((len(clip), len(rig.soles)))
    return Correction(rig.root, solved.shift, joints, rotations, nothing), solved.points, tuple(soft)


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
    wanted = []
    for k, foot in enumerate(legs):
        own = [stance for stance in stands if stance.leg == k and able[k]]
        goal = goals(foot, own, clip.frame_time, params.ease, soft[k])
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
    new: dict[int, Floats] = {}
    points: list[Floats] = [np.zeros((0, 3))] * len(rig.soles)
    hurry = []
    for k, (foot, goal) in enumerate(zip(legs, wanted, strict=True)):
        ankle = reach.clamp(foot.hip + shift, ankles[k], limits[k])
        changed = np.any(np.concatenate([goal.shift, goal.turn, shift], axis=1) != 0.0, axis=1)
        turned = _turned(clip, pose, foot, goal, shift, ankle, changed, params.ease) if able[k] else {}
        new.update(turned)
        hurry.append(_hurry(clip, turned))
        still_in_foot = (foot.heel_in_foot, foot.ball_in_foot)
        for e, at in zip(foot.effectors, still_in_foot, strict=True):
            points[e] = ankle + rotation.rotate(goal.foot_turn(foot), at)
    return Solved(shift, new, tuple(points), tuple(hurry))


def _turned(
    clip: Clip, pose: Pose, foot: Foot, goal: Goals, shift: Floats, ankle: Floats, changed: Bools, ease: EaseParams
) -> dict[int, Floats]:
    """New local rotations of one leg's joints; the clip's own numbers where nothing changes."""
    if not np.any(changed):
        return {}
    axis = ik.knee_axis(foot, pose.rotation(foot.leg.hip))
    forward = presence(changed, clip.frame_time, ease.seconds)
    turns = ik.two_bones(foot, axis, foot.hip + shift, ankle, forward)
    local = ik.local_rotations(clip, pose, foot, turns, goal.foot_turn(foot))
    return {joint: np.where(changed[:, None], q, clip.rotations[:, joint]) for joint, q in local.items()}


def _hurry(clip: Clip, turned: dict[int, Floats]) -> Floats:
    """(F,) [deg/s] by which a joint turns faster, to or from each frame, than it did thereabouts as captured."""
    fastest = np.zeros(len(clip))
    for joint, q in turned.items():
        before, after = _steps(clip.rotations[:, joint]), _steps(q)
        around = np.maximum(before, np.maximum(np.append(before[1:], 0.0), np.append(0.0, before[:-1])))
        more = np.degrees(after - around) / clip.frame_time
        fastest[1:] = np.maximum(fastest[1:], more)
        fastest[:-1] = np.maximum(fastest[:-1], more)
    return fastest


def _steps(q: Floats) -> Floats:
    """(F - 1,) [rad] how far rotations (F, 4) turn from frame to frame."""
    return rotation.angle(rotation.multiply(q[1:], rotation.inverse(q[:-1])))

"""One solution for all legs: goals of the feet, a root that gives way, two bones a leg."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce import ik, reach, root
from footfix.enforce.ease import EaseParams, covered, ease_frames, presence
from footfix.enforce.foot import Foot, can_turn
from footfix.enforce.judge import JudgeParams, dart_of, hurry_of
from footfix.enforce.plants import PlantParams, Stance
from footfix.enforce.reach import ReachParams
from footfix.enforce.root import RootParams
from footfix.enforce.swing import more_bent, within_bounds
from footfix.enforce.targets import Goals, calmed, eased, goals, lacks, levels, lifted, low_down, rolled
from footfix.enforce.toe import Toe, bend, firm, local_rotation, toe_of, with_toe_bent
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats, Ints
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
        hurry: for each leg (F,) [deg/s] by which its joints turn faster than captured; its foot counts along with them.
        sunk: for each leg (F,) [m] how much deeper its knee is below the floor than captured.
    """

    shift: Floats
    rotations: dict[int, Floats]
    points: tuple[Floats, ...]
    hurry: tuple[Floats, ...]
    sunk: tuple[Floats, ...]


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
class Limb:
    """A leg as captured, with all that is measured on the whole clip.

    Args:
        foot: its tracks.
        hinge: its knee.
        toe: its toes, if they can bend.
        straightest: the least share of its length that it lacks to being straight.
        able: whether the file can turn it.
    """

    foot: Foot
    hinge: ik.Hinge
    toe: Toe | None
    straightest: float
    able: bool

    def frames(self, which: Ints) -> Limb:
        """The leg in some frames only; what was measured on the whole clip stays."""
        toe = None if self.toe is None else self.toe.frames(which)
        return replace(self, foot=self.foot.frames(which), hinge=self.hinge.frames(which), toe=toe)


def limbs(
    clip: Clip, rig: Rig, pose: Pose, legs: Sequence[Foot], stands: Sequence[Stance], params: LegParams
) -> tuple[Limb, ...]:
    """The legs of a clip, measured with the stances that are to hold."""
    return tuple(
        Limb(
            foot,
            ik.hinge(foot, ik.knee_axis(foot, pose.rotation(foot.leg.hip)), params.reach.swing),
            toe_of(
                clip, rig, pose, foot, [s for s in stands if s.leg == k], params.plants.quiver * rig.leg_length
            ),
            float(reach.reserve(foot).min()),
            can_turn(clip, foot.leg),
        )
        for k, foot in enumerate(legs)
    )  # fmt: skip


def floors(legs: Sequence[Limb], stands: Sequence[Stance], frames: int) -> tuple[Floats, ...]:
    """For each leg (F,) [m] the height of the floor below it."""
    return tuple(levels([s for s in stands if s.leg == k and leg.able], frames) for k, leg in enumerate(legs))


def solution(
    clip: Clip,
    rig: Rig,
    pose: Pose,
    legs: Sequence[Limb],
    stands: Sequence[Stance],
    floor: Sequence[Floats],
    soft: Sequence[Floats],
    params: LegParams,
) -> Solved:
    """The pose of all legs in which these stances hold.

    Args:
        clip: as captured.
        rig: its legs.
        pose: of the clip, from `foot.posed`.
        legs: from `limbs`.
        stands: the stances that are to hold.
        floor: from `floors`.
        soft: for each leg (F,) [s] how softly.
        params: measures.
    """
    aims = [
        _aim(rig, leg, [s for s in stands if s.leg == k and leg.able], floor[k], soft[k], clip.frame_time, params)
        for k, leg in enumerate(legs)
    ]
    shift, limits = _root_shift(clip, rig, legs, aims, params)
    new: dict[int, Floats] = {}
    points: list[Floats] = [np.zeros((0, 3))] * len(rig.soles)
    hurry, sunk = [], []
    most = max(params.judge.dart, 1e-9) * rig.leg_length  # [m/s]
    for k, (leg, aim) in enumerate(zip(legs, aims, strict=True)):
        foot = aim.foot
        goal, ankle = _reached(
            foot, aim.goal, foot.hip + shift, limits[k], leg.straightest, clip.frame_time, params, soft[k]
        )
        turn = goal.foot_turn(foot)
        turned: dict[int, Floats] = {}
        deeper = np.zeros(len(clip))
        if leg.able and (np.any(goal.planted) or np.any(shift)):
            turns, ankle, changed = _bent(
                leg.hinge, foot, goal, foot.hip + shift, ankle, clip.frame_time, rig.leg_length, params
            )
            knee = foot.hip + shift + rotation.rotate(turns.swing, foot.knee - foot.hip)
            deeper = _below(knee, goal.level) - _below(foot.knee, goal.level)
            if params.solver == "priorities":
                turned = _by_priorities(clip, pose, foot, leg.hinge.axis, foot.hip + shift, ankle, turn, changed)
            else:
                local = ik.local_rotations(clip, pose, foot, turns, turn)
                turned = {joint: np.where(changed[:, None], q, clip.turn(joint)) for joint, q in local.items()}
        if aim.toe is not None and turned:
            turned[aim.toe.joint] = local_rotation(clip, aim.toe, turn, foot, aim.bend)
        new.update(turned)
        dart = dart_of(foot.ankle, ankle, clip.frame_time) / most if turned else np.zeros(len(clip))
        hurry.append(np.maximum(hurry_of(clip, turned), params.judge.speed * dart))
        sunk.append(deeper)
        for e, at in zip(foot.effectors, (foot.heel_in_foot, foot.ball_in_foot), strict=True):
            points[e] = ankle + rotation.rotate(turn, at)
    return Solved(shift, new, tuple(points), tuple(hurry), tuple(sunk))


def _below(place: Floats, level: Floats) -> Floats:
    """(F,) [m] how far a place (F, 3) is below the floor (F,); nothing where nobody knows the floor."""
    return np.maximum(level - place[:, 1], 0.0)  # `levels` are -inf there


@dataclass(frozen=True, eq=False)
class _Aim:
    """What one leg is to do: the foot, its toes if they bend and by which rotation vector (F, 3), and its goals."""

    foot: Foot
    toe: Toe | None
    bend: Floats
    goal: Goals


def _aim(
    rig: Rig, leg: Limb, own: list[Stance], level: Floats, soft: Floats, frame_time: float, params: LegParams
) -> _Aim:
    foot, toe, ease = leg.foot, leg.toe, params.ease
    vector = np.zeros((len(foot), 3))
    if toe is not None and params.strength > 0.0:
        toe, foot = firm(toe, foot, own, frame_time, ease)
    goal = goals(foot, own, level, frame_time, ease, soft)
    if toe is not None:
        depth = params.plants.toe_sink * rig.leg_length
        vector = params.strength * bend(toe, foot, goal, depth, frame_time, ease)
        if np.any(vector):
            foot = with_toe_bent(foot, toe, vector)
            goal = goals(foot, own, level, frame_time, ease, soft)
    goal = lifted(calmed(goal, foot, frame_time, ease), foot, params.plants.sink * rig.leg_length)
    goal = replace(goal, turn=params.strength * goal.turn, shift=params.strength * goal.shift)
    return _Aim(foot, toe if toe is not None and (np.any(vector) or np.any(toe.moved)) else None, vector, goal)


def _root_shift(
    clip: Clip, rig: Rig, legs: Sequence[Limb], aims: Sequence[_Aim], params: LegParams
) -> tuple[Floats, list[Floats]]:
    """(F, 3) [m] of the root, and for each leg (F,) [m] how far its ankle may be from its hip while it is planted."""
    shift = np.zeros((len(clip), 3))
    movable = bool(clip.skeleton.translates[rig.root])
    planted = [aim.goal.planted for aim in aims]
    if movable:
        shift = root.shared(planted, [aim.goal.shift for aim in aims], clip.frame_time, params.ease, params.root)
        if not params.shares:
            shift[:, [0, 2]] = 0.0
    ankles = [aim.goal.ankle(aim.foot) for aim in aims]
    hips = [aim.foot.hip + shift for aim in aims]
    limits = [
        reach.allowed(aim.foot, hip, ankle, params.reach, leg.straightest)
        for leg, aim, hip, ankle in zip(legs, aims, hips, ankles, strict=True)
    ]
    if movable:
        shift[:, 1] -= reach.lowering(hips, ankles, limits, planted, clip.frame_time, rig.leg_length, params.reach)
    return shift, limits


def _reached(
    foot: Foot, goal: Goals, hip: Floats, limit: Floats, straightest: float, frame_time: float, params: LegParams,
    soft: Floats,
) -> tuple[Goals, Floats]:  # fmt: skip
    """The goals, and the ankle (F, 3) [m], within reach: the foot rolls on the end it stands on, then gives way."""
    pivot = goal.ankle(foot) + rotation.rotate(goal.foot_turn(foot), goal.carrier(foot))
    roll = reach.rolled(hip, goal.ankle(foot), pivot, limit, goal.planted, np.radians(params.reach.roll))
    goal = eased(rolled(goal, foot, roll), foot, frame_time, params.ease, soft)
    if params.ease.method != "smooth":
        free = reach.allowed(foot, hip, goal.ankle(foot), params.reach, straightest)
        limit = np.where(goal.planted, limit, free)
    return goal, reach.clamp(hip, goal.ankle(foot), limit)


def _bent(
    hinge: ik.Hinge, foot: Foot, goal: Goals, hip: Floats, ankle: Floats, frame_time: float, leg_length: float,
    params: LegParams,
) -> tuple[ik.LegTurns, Floats, Bools]:  # fmt: skip
    """What turns the leg, the ankle (F, 3) [m] that it leads to, and the frames (F,) in which anything changes.

    Where the foot is held, the knee is bent as that needs. Elsewhere not the place of the foot leads over but the
    bend of the knee: of a straight leg, some millimetres of the foot are many degrees of the knee.
    """
    known = goal.planted | ~goal.near
    bent = ik.flexion(hinge, hip, ankle, goal.planted)
    moved = np.any((hip != foot.hip) | (goal.turn != 0.0) | (goal.shift != 0.0), axis=1)
    if params.ease.method != "smooth":
        return ik.two_bones(foot, hinge, bent, hip, ankle), ankle, moved
    free = ~goal.planted
    more = np.where(moved, bent - hinge.flexion, 0.0)
    away = moved & ~goal.near
    if np.any(away):  # the figure comes down to its other feet: one that nothing holds stays where it is, if it is low
        width = ease_frames(frame_time, params.ease.lead)
        stirred = np.any(norm(hip - foot.hip)[away] > 0.002 * leg_length)
        stays = stirred * low_down(goal, foot, params.plants.low * leg_length, width)
        more[away] = (stays * ik.staying(hinge, bent))[away]
    more = more_bent(hinge, more, known, goal.near | moved, frame_time, params.ease)
    share = presence(goal.near & free, frame_time, params.ease.lead)
    bent = np.where(free, within_bounds(hinge, more, share, free, frame_time, params.ease), bent)
    turns = ik.two_bones(foot, hinge, bent, hip, ankle)
    led = turns.ankle(foot, hip)
    low = lacks(goal, foot, led, params.plants.sink * leg_length)
    if not np.any(low):
        return turns, led, moved
    # raised along the leg, and as much around as keeps the knee's way smooth
    line = hip - led
    raised = led + line * (low / np.maximum(line[:, 1], 0.5 * norm(line)))[:, None]
    lacking = np.where(low > 0.0, ik.flexion(hinge, hip, raised, goal.planted) - bent, 0.0)
    cover = covered(np.maximum(lacking, 0.0), ease_frames(frame_time, 0.5 * params.ease.lead))
    # soon beside a plant, where the foot was lifted to the floor anyway; gently where the leg begins to be moved
    cover *= presence(goal.near & free, frame_time, 0.5 * params.ease.lead)
    cover *= params.strength * presence(goal.near, frame_time, 2.0 * params.ease.lead)
    turns = ik.two_bones(foot, hinge, bent + cover, hip, led)
    return turns, turns.ankle(foot, hip), moved | (cover > 0.0)


def _by_priorities(
    clip: Clip, pose: Pose, foot: Foot, axis: Floats, hip: Floats, ankle: Floats, turn: Floats, changed: Bools
) -> dict[int, Floats]:
    """The same from the prioritised solver: every joint of the chain that bends takes its part."""
    from footfix.enforce.priorities import leg_chain, solve  # seldom asked for

    if not np.any(changed):
        return {joint: clip.turn(joint) for joint in foot.leg.chain}
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

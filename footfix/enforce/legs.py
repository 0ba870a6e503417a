"""Enforcement by the legs, and its judgement.

What holding a plant would do to the joints is looked at before it is done: where a joint would have to turn much
faster than it was captured to, the foot is held there only as far as it slides slowly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.again import again
from footfix.enforce.correction import Correction
from footfix.enforce.ease import ease_frames, within_reach
from footfix.enforce.foot import Foot
from footfix.enforce.judge import JudgeParams, let_go, peeled
from footfix.enforce.plants import Stance
from footfix.enforce.solve import LegParams, Solved, floors, limbs, solution
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig


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
    whole = limbs(clip, rig, pose, legs, stands, params)
    solved = solution(clip, rig, pose, whole, stands, floors(whole, stands, len(clip)), soft, params)
    usual = _allowance(stands, len(clip), len(legs), clip.frame_time, params.judge)
    wide = replace(params.judge, peel_most=2.0 * params.judge.peel_most, peel_share=0.5)
    if params.ease.method == "smooth" and params.judge.speed > 0.0:
        for level in (None, None, *range(len(params.judge.softness))):
            changed = _given_way(clip, solved, stands, soft, level, usual, params.judge)
            if changed is not None:
                where = _differ(stands, changed[0], soft, changed[1])
                stands, soft = changed
                solved = again(clip, rig, pose, whole, stands, soft, where, solved, params)
        most = [params.judge.most * each for each in usual]
        cut, beside = (ease_frames(clip.frame_time, each) for each in (params.judge.around, params.judge.beside))
        settled = None
        for step in ((False, 0), *[(True, cut)] * 3, (True, 0), (True, 0)):
            if step == settled:  # it changed nothing the time before
                continue
            last, around = step
            hurried = [hurry > each for hurry, each in zip(solved.hurry, most, strict=True)]
            fewer = tuple(
                let_go(
                    s, solved.points, soft[s.leg], solved.hurry[s.leg], most[s.leg], rig.leg_length, params.plants,
                    beside, around, solved.sunk[s.leg],
                )
                if last else peeled(s, hurried[s.leg], clip.frame_time, wide) for s in stands
            )  # fmt: skip
            if all(new is old for new, old in zip(fewer, stands, strict=True)):
                if last and not any(np.any(each) for each in hurried):
                    break
                settled = step
                continue
            where = _differ(stands, fewer, soft, soft)
            stands = fewer
            solved = again(clip, rig, pose, whole, stands, soft, where, solved, params)
    joints = tuple(sorted(solved.rotations))
    columns = [solved.rotations[joint] for joint in joints]
    rotations = np.stack(columns, axis=1) if columns else np.zeros((len(clip), 0, 4))
    nothing = np.zeros((len(clip), len(rig.soles)))
    correction = Correction(rig.root, solved.shift, joints, rotations, nothing)
    return Held(correction, solved.points, stands, soft)


def _allowance(
    stands: Sequence[Stance], frames: int, legs: int, frame_time: float, judge: JudgeParams
) -> list[Floats]:
    """For each leg (F,) [deg/s] by which its joints may turn faster than captured: more about plants that are given."""
    given = np.zeros((legs, frames), dtype=np.bool_)
    for stance in stands:
        for plant in (plant for plant in stance.plants if plant.given):
            given[stance.leg][plant.frames] = True
    return [
        np.where(within_reach(each, frame_time, judge.around), judge.given, 1.0) * judge.speed for each in given
    ]


def _differ(
    old: Sequence[Stance], new: Sequence[Stance], soft: Sequence[Floats], softer: Sequence[Floats]
) -> Bools:
    """(F,) the frames in which stances, or how softly they hold, are no longer what they were."""
    differ = np.zeros(len(soft[0]), dtype=np.bool_)
    for one, other in zip(soft, softer, strict=True):
        differ |= one != other
    for before, after in zip(old, new, strict=True):
        if before is not after:
            differ[before.frames] = True
    return differ


def _given_way(
    clip: Clip,
    solved: Solved,
    stands: tuple[Stance, ...],
    soft: tuple[Floats, ...],
    level: int | None,
    usual: Sequence[Floats],
    judge: JudgeParams,
) -> tuple[tuple[Stance, ...], tuple[Floats, ...]] | None:
    """Stances and softness where joints hurry: plants without their edges, or (at a `level`) holds that are softer.

    None where nothing changes.
    """
    times = 1.0 if level is None else judge.soften
    hurried = [hurry > times * most for hurry, most in zip(solved.hurry, usual, strict=True)]
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



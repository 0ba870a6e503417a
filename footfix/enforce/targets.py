"""From targets of plants to goals of a leg: where its ankle is to be, and how its foot is to be turned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.ease import HELD, EaseParams, covered, displacement, fit, gamma, within_reach
from footfix.enforce.foot import Foot
from footfix.enforce.plants import Stance
from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.motion.vectors import cross, dot, norm


@dataclass(frozen=True, eq=False)
class Goals:
    """What one leg is to do.

    Args:
        planted: (F,) some end of the foot is held.
        near: (F,) frames in which the foot may move.
        flat: (F,) both ends are.
        on_ball: (F,) of heel and ball, the ball carries.
        level: (F,) [m] height of the floor below the foot.
        kept: (F,) it stands well enough as it is.
        turn: (F, 3) [rad] rotation vector in the world, to be applied to the foot.
        shift: (F, 3) [m] displacement of the ankle. Both are known while the foot is planted; `eased` finds the rest.
    """

    planted: Bools
    near: Bools
    flat: Bools
    on_ball: Bools
    level: Floats
    kept: Bools
    turn: Floats
    shift: Floats

    def ankle(self, foot: Foot) -> Floats:
        """(F, 3) [m] where the ankle is to be."""
        return foot.ankle + self.shift

    def carrier(self, foot: Foot) -> Floats:
        """(F, 3) [m] in the ankle's frame the end that the foot stands on, or rolls about."""
        return np.where(self.on_ball[:, None], foot.ball_in_foot, foot.heel_in_foot)

    def foot_turn(self, foot: Foot) -> Floats:
        """(F, 4) how the ankle's frame is to stand in the world."""
        return rotation.multiply(rotation.from_rotation_vector(self.turn), foot.turn)


def goals(
    foot: Foot, stands: Sequence[Stance], level: Floats, frame_time: float, params: EaseParams, soft: Floats
) -> Goals:
    """The goals of one leg from its stances; released ones are not among them.

    `level` (F,) [m] is the height of the floor, from `levels`; `soft` (F,) [s] says where the foot is held only as
    far as its slide is slower than that.
    """
    frames = len(foot)
    on = {part: np.zeros(frames, dtype=np.bool_) for part in ("heel", "toe")}
    at = {part: np.zeros((frames, 3)) for part in ("heel", "toe")}
    kept = np.zeros(frames, dtype=np.bool_)
    for stance in stands:
        for plant in (plant for plant in stance.plants if not plant.reason):
            on[plant.part][plant.frames] = True
            at[plant.part][plant.frames] = plant.target
            kept[plant.frames] |= plant.kept
        if stance.pivots:
            other = "heel" if stance.pivots == "toe" else "toe"
            both = on["heel"][stance.frames] & on["toe"][stance.frames]
            on[other][stance.frames] = both  # it has no place of its own while the end that it goes around is not held
            at[other][stance.frames][both] = _carried(foot, at, stance, other)[both]
    planted = on["heel"] | on["toe"]
    near = within_reach(planted & ~kept, frame_time, params.seconds)
    flat = on["heel"] & on["toe"]
    # 1. the foot's turn: known where both ends stand; a foot that never lies flat is not turned
    known = flat | kept
    for stance in stands:
        if not np.any(flat[stance.frames]):
            known[stance.frames] = planted[stance.frames]
    turn = np.zeros((frames, 3))
    aligned = rotation.between(foot.ball[flat] - foot.heel[flat], at["toe"][flat] - at["heel"][flat])
    turn[flat] = rotation.to_rotation_vector(aligned)
    turn[kept] = 0.0
    turn = displacement(known, turn, near, frame_time, params, soft)
    # 2. the ankle's place: on the end that stands; from heel to ball over the time both do
    turned = rotation.multiply(rotation.from_rotation_vector(turn), foot.turn)
    from_heel = at["heel"] - rotation.rotate(turned, foot.heel_in_foot)
    from_ball = at["toe"] - rotation.rotate(turned, foot.ball_in_foot)
    roll = _roll(on["heel"], on["toe"])[:, None]
    shift = (1.0 - roll) * from_heel + roll * from_ball - foot.ankle
    shift[kept] = 0.0
    on_ball = roll[:, 0] > 0.5
    shift = np.where(planted[:, None], shift, 0.0)
    return Goals(planted, near, flat, on_ball, level, kept, turn, shift)


def calmed(goal: Goals, foot: Foot, frame_time: float, params: EaseParams) -> Goals:
    """The goals with the foot rolled so that its ankle stays calm while it stands on one end.

    Whatever turns a captured foot about its ankle from one frame to the next would swing the ankle about the end
    that stands now. So the ankle is displaced smoothly, and the foot's roll takes up what is quicker; by as much as
    the captured ankle goes more calmly than the captured foot turns.
    """
    on_one = goal.planted & ~goal.flat & ~goal.kept
    if params.method != "smooth" or not np.any(on_one):
        return goal
    weights = np.where(on_one, 1.0, np.where(goal.planted, HELD, 0.0))
    smooth = fit(weights, goal.shift, goal.near, frame_time, params.roll_settle, params.slack)
    as_turned, as_moved = _quickness(goal.ankle(foot), goal.planted), _quickness(foot.ankle + smooth, goal.planted)
    share = np.zeros(len(foot))
    for start, end in runs(on_one):
        turned, moved = (quick[max(start - 3, 0) : end].sum() for quick in (as_turned, as_moved))
        share[start:end] = turned / (turned + moved) if turned + moved > 0.0 else 1.0  # too short to tell
    arm = -rotation.rotate(goal.foot_turn(foot), goal.carrier(foot))
    roll = rotation.between(arm, arm + share[:, None] * (smooth - goal.shift))
    return rolled(goal, foot, roll)


def _quickness(track: Floats, planted: Bools) -> Floats:
    """(F - 3,) squares of a track's third differences, where all four frames are planted."""
    all_four = planted[:-3] & planted[1:-2] & planted[2:-1] & planted[3:]
    third = np.diff(track, n=3, axis=0)
    return np.where(all_four, dot(third, third), 0.0)


def levels(stands: Sequence[Stance], frames: int) -> Floats:
    """(F,) [m] height of the floor: that of the stance, and before and after it of the lower of its neighbours."""
    order = sorted(stands, key=lambda stance: stance.frames.start)
    level = np.full(frames, -np.inf)
    for k, stance in enumerate(order):
        level[stance.frames] = stance.level
        before = order[k - 1].frames.stop if k else 0
        after, beyond = frames, stance.level
        if k + 1 < len(order):
            after, beyond = order[k + 1].frames.start, order[k + 1].level
        level[before : stance.frames.start] = min(stance.level, order[k - 1].level if k else stance.level)
        level[stance.frames.stop : after] = min(stance.level, beyond)
    return level


def lifted(goal: Goals, foot: Foot, tolerance: float) -> Goals:
    """The goals with no end of the foot deeper than `tolerance` [m] in the floor where the foot moves.

    A foot that stands on one end rolls on it until the other is out of the floor.
    """
    turned, ankle = goal.foot_turn(foot), goal.ankle(foot)
    heel = ankle + rotation.rotate(turned, foot.heel_in_foot)
    ball = ankle + rotation.rotate(turned, foot.ball_in_foot)
    on_one = goal.planted & ~goal.flat
    stands, hangs = (np.where(goal.on_ball[:, None], a, b) for a, b in ((ball, heel), (heel, ball)))
    deep = np.where(on_one & goal.near, np.maximum(goal.level - hangs[:, 1] - tolerance, 0.0), 0.0)
    arm = hangs - stands
    up = np.array([0.0, 1.0, 0.0])
    axis = cross(arm, up)
    length = norm(arm)
    angle = np.arcsin(np.clip(deep / np.maximum(length, 1e-300), 0.0, 1.0))
    roll = rotation.from_axis_angle(axis / np.maximum(norm(axis), 1e-300)[:, None], angle)
    return rolled(goal, foot, roll)


def low_down(goal: Goals, foot: Foot, height: float, width: int) -> Floats:
    """(F,) from 1 for a captured foot at the floor to 0 for one that is `height` [m] over it.

    It changes smoothly, over some widths [frames], also where the floor has a step.
    """
    low = np.minimum(foot.heel[:, 1], foot.ball[:, 1])
    return covered(gamma((low - np.where(np.isfinite(goal.level), goal.level, low)) / height), width)


def lacks(goal: Goals, foot: Foot, ankle: Floats, tolerance: float) -> Floats:
    """(F,) [m] how much deeper than `tolerance` a swinging foot, its ankle at (F, 3) [m], is in the floor.

    A foot that is deeper than it is long is on its way to another floor; before the first and after the last plant,
    where nobody knows what the floor is, one that gets two fifths as deep.
    """
    turned = goal.foot_turn(foot)
    heel, ball = (rotation.rotate(turned, each) for each in (foot.heel_in_foot, foot.ball_in_foot))
    deep = goal.level - tolerance - ankle[:, 1] - np.minimum(heel[:, 1], ball[:, 1])
    length = norm(ball - heel)
    deep = np.where(goal.near & ~goal.planted & (deep < length), deep, 0.0)
    planted = np.flatnonzero(goal.planted)
    if len(planted):
        for open_end in (slice(0, int(planted[0])), slice(int(planted[-1]) + 1, len(foot))):
            if np.any(deep[open_end] > 0.4 * length[open_end]):
                deep[open_end] = 0.0
    return np.maximum(deep, 0.0)


def rolled(goal: Goals, foot: Foot, roll: Floats) -> Goals:
    """The goals with the foot rolled by `roll` (F, 4) in the world about the end it stands on."""
    rolls = (goal.planted & (np.abs(roll[:, 3]) < 1.0 - 1e-12))[:, None]
    if not np.any(rolls):
        return goal
    in_foot = goal.carrier(foot)
    pivot = goal.ankle(foot) + rotation.rotate(goal.foot_turn(foot), in_foot)
    turn = rotation.multiply(roll, rotation.from_rotation_vector(goal.turn))
    ankle = pivot - rotation.rotate(rotation.multiply(turn, foot.turn), in_foot)
    return replace(
        goal,
        turn=np.where(rolls, rotation.to_rotation_vector(turn), goal.turn),
        shift=np.where(rolls, ankle - foot.ankle, goal.shift),
    )


def eased(goal: Goals, foot: Foot, frame_time: float, params: EaseParams, soft: Floats) -> Goals:
    """The goals between plants, too; where the foot is held softly, only as far as that is slow (see `goals`)."""
    if params.method == "hermite":
        turn = displacement(goal.planted, goal.turn, goal.near, frame_time, params, soft)
        shift = displacement(goal.planted, goal.shift, goal.near, frame_time, params, soft, foot.ankle)
    else:
        both = np.concatenate([goal.turn, goal.shift], axis=1)
        turn, shift = np.split(displacement(goal.planted, both, goal.near, frame_time, params, soft), 2, axis=1)
    return replace(goal, turn=turn, shift=shift)


def _carried(foot: Foot, at: dict[str, Floats], stance: Stance, other: str) -> Floats:
    """Where the end that moves goes while a flat foot pivots: around the end that stands, as captured."""
    span = foot.point(other)[stance.frames] - foot.point(stance.pivots)[stance.frames]
    level = span * np.array([1.0, 0.0, 1.0])
    length = norm(span) / np.maximum(norm(level), 1e-300)
    return np.asarray(at[stance.pivots][stance.frames] + length[:, None] * level)


def _roll(heel: Bools, ball: Bools) -> Floats:
    """(F,) 0 where the heel carries, 1 where the ball does, and between them where both do."""
    roll = np.where(ball, 1.0, 0.0)
    frames = len(heel)
    for start, end in runs(heel & ball):
        first = 0.0 if start > 0 and heel[start - 1] else 1.0 if start > 0 and ball[start - 1] else 0.5
        last = 0.0 if end < frames and heel[end] else 1.0 if end < frames and ball[end] else first
        first = last if start == 0 or not (heel[start - 1] or ball[start - 1]) else first
        roll[start:end] = np.linspace(first, last, end - start)
    return roll

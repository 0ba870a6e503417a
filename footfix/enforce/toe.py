"""The toes of a planted foot bend rather than enter the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footfix.enforce.ease import EaseParams, fit, sloped, within_reach
from footfix.enforce.foot import Foot
from footfix.enforce.plants import Stance
from footfix.enforce.targets import Goals
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats, Ints, some
from footfix.motion.contacts import runs
from footfix.motion.kinematics import Pose
from footfix.motion.segments import segments
from footfix.motion.vectors import cross, norm
from footfix.rig.rig import Rig

_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Toe:
    """The toes of one leg as captured, in the world.

    Args:
        joint: the toe joint.
        above: the joint it hangs from.
        place: (F, 3) [m] of the joint.
        turn, above_turn: (F, 4) frames of the two.
        tip: (F, 3) [m] their end.
        carries_ball: whether the foot's ball moves with them.
        hinge: (3,) the axis in the ankle's frame about which they turn up.
        lies: [m] how much lower than the ball their end is while the foot is flat; negative, or zero.
        quiver: whether they carry the ball to and fro in a foot that stands on it.
        moved: (F,) or () where they are no longer as captured.
    """

    joint: int
    above: int
    place: Floats
    turn: Floats
    above_turn: Floats
    tip: Floats
    carries_ball: bool
    hinge: Floats
    lies: float
    quiver: bool
    moved: Bools = field(default_factory=lambda: np.zeros((), dtype=np.bool_))

    def frames(self, which: Ints) -> Toe:
        """The toes in some frames only; what was measured on the whole clip stays."""
        place, turn, above, tip = (some(each, which) for each in (self.place, self.turn, self.above_turn, self.tip))
        return replace(self, place=place, turn=turn, above_turn=above, tip=tip)


def toe_of(
    clip: Clip, rig: Rig, pose: Pose, foot: Foot, stands: Sequence[Stance], tolerance: float
) -> Toe | None:
    """The toes of a leg; None where the file has none that could bend.

    Toes that carry the ball of a foot that stands on it no farther than `tolerance` [m] are still.
    """
    joint, skeleton = foot.leg.toe, clip.skeleton
    if joint is None or not skeleton.rotates[joint]:
        return None
    ends = np.flatnonzero(skeleton.end_parents == joint)
    above = int(skeleton.parents[joint])
    if above < 0 or foot.leg.ankle not in skeleton.ancestors(above):
        return None
    offset = skeleton.end_offsets[ends[0]] if len(ends) else np.zeros(3)
    carries_ball = rig.soles[foot.effectors[1]].joint == joint
    if np.linalg.norm(offset) < 0.02 * rig.leg_length and not carries_ball:
        return None
    ground = foot.ankle - pose.position(foot.leg.ankle)  # (F, 3) [m] the leg's tracks may stand on one of their own
    place, tip = pose.position(joint) + ground, pose.point(joint, offset) + ground
    on, flat, kept = _stood_on(stands, len(foot))
    some_on = on if np.any(on) else np.ones_like(on)
    axes = rotation.rotate(rotation.inverse(foot.turn[some_on]), cross((tip - place)[some_on], _UP[None])).sum(axis=0)
    lies = min(float(np.median((tip - foot.ball)[flat, 1])), 0.0) if np.any(flat) else 0.0
    return Toe(
        joint, above, place, pose.rotation(joint), pose.rotation(above), tip, carries_ball,
        axes / max(float(np.linalg.norm(axes)), 1e-300), lies,
        carries_ball and _quivers(_in_ankle(foot, place), on & ~kept, flat, tolerance),
    )  # fmt: skip


def _in_ankle(foot: Foot, place: Floats) -> Floats:
    """(F, 3) [m] from the toe joint at (F, 3) to the ball, in the ankle's frame."""
    return rotation.rotate(rotation.inverse(foot.turn), foot.ball - place)


def _quivers(at: Floats, held: Bools, flat: Bools, tolerance: float) -> bool:
    wriggle = np.abs(at[held & flat] - _usual(at, flat)[held & flat]).max(initial=0.0)
    from_neighbours = np.abs(at[1:-1] - 0.5 * (at[2:] + at[:-2])).max(axis=1)[held[1:-1]]
    return bool(wriggle > tolerance or (len(from_neighbours) and np.median(from_neighbours) > 0.2 * tolerance))


def _usual(at: Floats, flat: Bools) -> Floats:
    """(F, 3) [m] places, but where the foot is flat the median of as long as it is."""
    usual, parts = at.copy(), segments(runs(flat))
    for axis in range(3):
        usual[parts.frames, axis] = parts.median(at[parts.frames, axis])[parts.owner]
    return usual


def firm(toe: Toe, foot: Foot, stands: Sequence[Stance], frame_time: float, ease: EaseParams) -> tuple[Toe, Foot]:
    """Toes and foot with the ball held firmly in the foot as long as that stands on it.

    Heel and ball of a flat foot stand still only if they are one rigid body; and a foot that rolls over its ball
    shakes with each quiver of its toes. Toes that wriggle carry the ball to and fro in the foot, by some
    millimetres: while it is flat the ball stays where it usually is, and later on it goes its way smoothly.
    """
    on, flat, kept = _stood_on(stands, len(foot))
    if not toe.quiver or not np.any(on & ~kept):
        return toe, foot
    at, held = _in_ankle(foot, toe.place), on & ~kept
    want = _usual(at, flat)
    everywhere = np.ones(len(foot), dtype=np.bool_)
    smooth = fit(on + 99.0 * flat, want, everywhere, frame_time, ease.toe_settle, ease.slack)
    want = np.where(flat[:, None], want, smooth)
    vector = np.zeros((len(foot), 3))
    vector[held] = rotation.to_rotation_vector(rotation.between(at[held], want[held]))
    near = within_reach(held, frame_time, ease.seconds)
    eased = fit(on + 99.0 * flat, vector, near, frame_time, ease.toe_settle, 2.0 * ease.toe_settle)
    eased = np.where(near[:, None] & (np.abs(eased) > 1e-7), eased, 0.0)
    vector = _no_faster(vector, eased, flat & ~kept, 0.9 * np.radians(ease.toe_speed) * frame_time)
    q = rotation.from_rotation_vector(rotation.rotate(foot.turn, vector))
    tip = toe.place + rotation.rotate(q, toe.tip - toe.place)
    moved = np.any(vector != 0.0, axis=1)
    turned = replace(toe, turn=rotation.multiply(q, toe.turn), tip=tip, moved=moved)
    return turned, with_toe_bent(foot, toe, vector)


def _no_faster(held: Floats, eased: Floats, exact: Bools, most: float) -> Floats:
    """(F, 3) `held` where that is exact (F,), elsewhere `eased`, but no faster away from `held` than `most` a frame."""
    out = np.where(exact[:, None], held, eased)
    lowest, highest = float(out.min()), float(out.max())
    for axis in range(3):
        low = sloped(np.where(exact, held[:, axis], lowest), most)
        high = -sloped(np.where(exact, -held[:, axis], -highest), most)
        out[:, axis] = np.where(exact, held[:, axis], np.clip(eased[:, axis], low, high))
    return out


def _stood_on(stands: Sequence[Stance], frames: int) -> tuple[Bools, Bools, Bools]:
    """(F,) each: the ball is planted; the foot is flat; and it stands well enough as it is."""
    heel, on, kept = (np.zeros(frames, dtype=np.bool_) for _ in range(3))
    for stance in stands:
        for plant in (plant for plant in stance.plants if not plant.reason):
            (heel if plant.part == "heel" else on)[plant.frames] = True
            kept[plant.frames] |= plant.kept
    return on, heel & on, kept


def bend(
    toe: Toe, foot: Foot, goal: Goals, tolerance: float, frame_time: float, ease: EaseParams
) -> Floats:
    """(F, 3) [rad] the rotation vector in the ankle's frame by which the toes bend; zero where they need not.

    Toes lie as deep as they do when the foot is flat; deeper by more than `tolerance` [m], they turn up about the
    toe joint until they don't. They begin as early and come back as late as the speed of toes asks for.
    """
    turned = rotation.from_rotation_vector(goal.turn)
    joint = goal.ankle(foot) + rotation.rotate(turned, toe.place - foot.ankle)
    reach = rotation.rotate(turned, toe.tip - toe.place)
    over = joint[:, 1] + reach[:, 1] - goal.level
    length = np.maximum(norm(reach), 1e-300)
    deep = np.where(goal.planted & goal.near, np.maximum(toe.lies - over - tolerance, 0.0), 0.0)
    sines = np.clip(np.stack([reach[:, 1] + deep, reach[:, 1]]) / length, -1.0, 1.0)
    angle = np.where(deep > 0.0, np.arcsin(sines[0]) - np.arcsin(sines[1]), 0.0)
    if not np.any(angle):
        return np.zeros((len(foot), 3))
    speed = np.radians(ease.toe_speed)
    angle = np.minimum(angle, 0.9 * speed * ease.seconds)  # no more than they come back from while they may move
    eased = np.where(goal.near, sloped(angle, speed * frame_time), 0.0)
    return np.asarray(eased[:, None] * toe.hinge)


def with_toe_bent(foot: Foot, toe: Toe, vector: Floats) -> Foot:
    """The foot with its ball where bent toes carry it."""
    if not toe.carries_ball:
        return foot
    q = rotation.from_rotation_vector(rotation.rotate(foot.turn, vector))
    ball = toe.place + rotation.rotate(q, foot.ball - toe.place)
    bent = np.any(vector != 0.0, axis=1)[:, None]
    in_foot = rotation.rotate(rotation.inverse(foot.turn), ball - foot.ankle)
    return replace(
        foot, ball=np.where(bent, ball, foot.ball), ball_in_foot=np.where(bent, in_foot, foot.ball_in_foot)
    )


def local_rotation(clip: Clip, toe: Toe, foot_turn: Floats, foot: Foot, vector: Floats) -> Floats:
    """The toe joint's new local rotation (F, 4); the clip's own numbers where it does not bend."""
    bent = toe.moved | np.any(vector != 0.0, axis=1)
    turned = rotation.multiply(foot_turn, rotation.inverse(foot.turn))
    above = rotation.multiply(turned, toe.above_turn)
    now = rotation.multiply(
        rotation.from_rotation_vector(rotation.rotate(foot_turn, vector)), rotation.multiply(turned, toe.turn)
    )
    local = rotation.normalize(rotation.multiply(rotation.inverse(above), now))
    return np.asarray(np.where(bent[:, None], local, clip.turn(toe.joint)))

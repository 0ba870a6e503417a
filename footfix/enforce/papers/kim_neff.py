"""Kim and Neff's enforcement: rooted feet of one direction, joined to the free motion by Hermite splines.

Source: Y. Kim, M. Neff, Automating expressive locomotion generation, Transactions on Edutainment VII (2012),
section 7.1. The paper roots the ankle for as long as a foot is planted. A foot that rolls from heel to toe has no
ankle at rest, so its heel and toe are rooted and joined in the paper's way, each for itself, and the ankle follows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.easing import Span, ease_frames, gamma, led_over
from footfix.enforce.footplant import Footplant
from footfix.enforce.papers.rigid_foot import PARTS, Displacement, foot_goal, held, planted
from footfix.enforce.papers.targets import TargetParams, legs_to_hold, targets
from footfix.enforce.two_bone_ik import (
    CapturedLeg,
    captured_leg,
    correction_of,
    local_rotations,
    two_bones,
    where_moved,
    within_reach,
)
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints
from footfix.motion.contacts import Part, runs
from footfix.motion.vectors import norm
from footfix.rig.rig import Rig

_UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, kw_only=True)
class KimNeffParams:
    """How Kim and Neff's method holds plants.

    Args:
        longest: longest curve that joins the free motion to a plant [s].
        targets: where plants stand.
    """

    longest: float = 0.1
    targets: TargetParams = field(default_factory=TargetParams)


@dataclass(frozen=True, eq=False)
class Join:
    """The frames between a plant and the free motion.

    Args:
        edge: the plant's frame next to them, F_c.
        frames: (N_b,) these frames, from the plant to the free motion.
        weight: (N_b,) w(i) of the free motion, from 0 at the plant to 1, as in K's eq. 1, w R_a + (1 - w) R_b: a foot
            leaves its plant slowly and joins the free motion quickly.
        free: the frame F_u; -1 where the clip ends before it, and the displacement goes on to that end.
        beyond: the neighbour of F_u that is farther from the plant.
    """

    edge: int
    frames: Ints
    weight: Floats
    free: int
    beyond: int


def correct(
    clip: Clip, rig: Rig, plants: Sequence[Footplant], params: KimNeffParams, *, ground: Floats | None = None
) -> Correction:
    """Hold plants by Kim and Neff's method (K §7.1): the root stays as captured, the legs turn.

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
    tracks, soles = rig.held(pose), rig.tracks(pose)
    most = ease_frames(params.longest, clip.frame_time)
    new: dict[int, Floats] = {}
    for number, which in legs_to_hold(clip, rig, plants):
        own = [plants[k] for k in which]
        leg = captured_leg(rig, pose, number, tracks)
        stances = runs(planted([(plant.start, plant.end) for plant in own], len(clip)))
        swivel = mean_swivel(leg, stances, most)
        straight = _swivelled(leg, swivel)
        ends = [straight.effector(sole.part) for sole in rig.soles]  # those of other legs are not asked for
        places = targets(rig, soles, ends, own, ground, params.targets)
        heel, toe = (_joined(straight, part, *held(straight, part, own, places, ground), most) for part in PARTS)
        goal = foot_goal(straight, heel, toe, most)
        turns = two_bones(leg, within_reach(leg, goal.ankle), swivel)
        moves = goal.moves | (swivel != 0.0)
        new.update(where_moved(clip, local_rotations(clip, pose, leg, turns, goal.turn), moves))
    return correction_of(clip, rig, new)


def mean_swivel(leg: CapturedLeg, spans: Sequence[Span], most: int) -> Floats:
    """Find the swivel (F,) [rad] of a leg that gives its planted foot the mean direction of the plant.

    The leg's turn about the line from hip to ankle is what spins a rooted foot on the ground; so it is counted as the
    foot's heading there. It fades in and out over `most` frames around the plants `spans`, with the weights of a join;
    and it fades out as the foot comes to stand upright, pitched by more than 60 degrees, when it has no heading.
    """
    turn = np.zeros(len(leg))
    x, z = leg.toe[:, 0] - leg.heel[:, 0], leg.toe[:, 2] - leg.heel[:, 2]
    flat = np.hypot(x, z) / np.maximum(norm(leg.toe - leg.heel), 1e-12)  # cosine of the foot's pitch
    for start, end in spans:
        # the mean direction: that of the sum of the vectors over the floor, whatever the angles' turns
        off = np.arctan2(x[start:end].sum(), z[start:end].sum()) - np.arctan2(x[start:end], z[start:end])
        lies = 1.0 - gamma(2.0 * flat[start:end])
        turn[start:end] = lies * np.arctan2(np.sin(off), np.cos(off))
    out = led_over(spans, turn[:, None], most)
    for join in joins(spans, np.full(len(leg), most), most):
        out[join.frames] = (1.0 - join.weight)[:, None] * turn[join.edge]
    return out[:, 0]


def _swivelled(leg: CapturedLeg, swivel: Floats) -> CapturedLeg:
    """Turn the foot of a leg about the vertical through its ankle by `swivel` (F,) [rad]."""
    turn = rotation.about_vertical(swivel)
    heel, toe = (leg.ankle + rotation.rotate(turn, point - leg.ankle) for point in (leg.heel, leg.toe))
    return replace(leg, turn=rotation.multiply(turn, leg.turn), heel=heel, toe=toe)


def _joined(leg: CapturedLeg, part: Part, spans: Sequence[Span], needed: Floats, most: int) -> Displacement:
    """Join the displacement of an effector, `needed` (F, 3) [m] in its plants, to the free motion."""
    track = leg.effector(part)
    shift = led_over(spans, needed, most)
    # N_b: the distance between F_u and F_c, over the average way of the ankle from frame to frame in the plant
    count = np.zeros(len(leg), dtype=np.intp)
    for start, end in spans:
        usual = float(norm(np.diff(leg.ankle[start:end], axis=0)).sum()) / max(end - start - 1, 1)
        count[[start, end - 1]] = np.rint(np.minimum(norm(needed[[start, end - 1]]) / max(usual, 1e-6), most))
    for join in joins(spans, count, most):
        shift[join.frames] = spline(track, needed, join) - track[join.frames] if join.free >= 0 else needed[join.edge]
    return Displacement(shift, planted(spans, len(leg)))


def joins(spans: Sequence[Span], count: Ints, most: int) -> list[Join]:
    """Lay out the frames between plants and free motion.

    Plants closer than two of the longest joins have none between them, see `led_over`. Where the clip ends before
    F_u, the displacement goes on to its end.

    Args:
        spans: the plants.
        count: (F,) N_b, in the first and last frame of each.
        most: frames of the longest join.
    """
    found = []
    for k, (start, end) in enumerate(spans):
        before = spans[k - 1][1] if k else -2 * most
        after = spans[k + 1][0] if k + 1 < len(spans) else len(count) + 2 * most
        for edge, away, room in ((start, -1, start - before), (end - 1, 1, after - end)):
            if room >= 2 * most and count[edge] > 0:
                found.append(_join(edge, away, int(count[edge]), len(count)))
    return found


def _join(edge: int, away: int, count: int, frames: int) -> Join:
    free = edge + away * (count + 1)
    if not 0 <= free + away < frames:
        rest = np.arange(0, edge) if away < 0 else np.arange(edge + 1, frames)
        return Join(edge, rest, np.zeros(len(rest)), -1, -1)
    # w(i) = 1 - cos(0.5 (i + 0.5) / N_b pi)
    weight = 1.0 - np.cos(0.5 * np.pi * (np.arange(count) + 0.5) / count)
    return Join(edge, edge + away * np.arange(1, count + 1), weight, free, free + away)


def spline(track: Floats, needed: Floats, join: Join) -> Floats:
    """Place an effector (N_b, 3) [m] in the frames of a join, on the Hermite spline between F_u and F_c.

    Args:
        track: (F, 3) [m] as captured.
        needed: (F, 3) [m] how far it is displaced in its plants.
        join: the frames.
    """
    F_u, F_c = track[join.free], track[join.edge] + needed[join.edge]
    T = F_u - track[join.beyond]  # as the free motion runs there, towards the plant
    # T_Fu = 0.5 |F_u - F_c| T / |T|,  T_Fc = 0.1 |F_u - F_c| T_y / |T|
    size = float(norm(F_u - F_c)) / max(float(norm(T)), 1e-12)
    at_free, at_plant = 0.5 * size * T, 0.1 * size * T * _UP
    s = 1.0 - join.weight  # along the spline, from F_u to F_c
    s2, s3 = s**2, s**3
    basis = np.stack([2.0 * s3 - 3.0 * s2 + 1.0, s3 - 2.0 * s2 + s, -2.0 * s3 + 3.0 * s2, s3 - s2], axis=1)
    return np.asarray(basis @ np.stack([F_u, at_free, F_c, at_plant]))

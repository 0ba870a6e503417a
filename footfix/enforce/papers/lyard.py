"""Lyard's root-only correction: the root moves so that one planted point at a time is static; no limb is touched.

Source: E. Lyard, N. Magnenat-Thalmann, A simple footskate removal method for virtual reality applications, The
Visual Computer 23 (2007), sections 3.2 and 3.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant
from footfix.enforce.papers.static_point_switch import hand_over, offset_at
from footfix.enforce.papers.targets import TargetParams, near_floor, usual_place
from footfix.motion.clip import Bools, Clip, Floats, Ints
from footfix.motion.kinematics import Pose
from footfix.motion.vectors import norm
from footfix.rig.rig import Rig


@dataclass(frozen=True, kw_only=True)
class LyardRootParams:
    """How the root alone holds plants.

    Args:
        speed_window: time over which the speeds of points are averaged before they are compared [s].
        hand_over: motion that a hand-over from point to point must save; 0 as in the paper [leg lengths].
        calm: time over which changes of the root's steps are averaged; 0 as in the paper [s].
        vertical: whether the root's height gets one offset and one scale that put planted soles on their floors.
        keep_slide: the root is unchanged if no plant slides farther than this over its contact [leg lengths].
        keep_height: and none is farther from its floor than this [leg lengths].
        pin_end: whether the path's drift is brought back to zero at the last frame, evenly over the clip.
        targets: where plants stand.
    """

    speed_window: float = 0.1
    hand_over: float = 0.01
    calm: float = 0.03
    vertical: bool = True
    keep_slide: float = 0.004
    keep_height: float = 0.012
    pin_end: bool = False
    targets: TargetParams = field(default_factory=TargetParams)


def correct(
    clip: Clip, rig: Rig, plants: Sequence[Footplant], params: LyardRootParams, *, ground: Floats | None = None
) -> Correction:
    """Hold plants by the root's translation alone (L §3.2, 3.3).

    Horizontally the root moves so that one planted point at a time is static; in flight it keeps its own velocity. The
    path therefore drifts: it is as long as the feet say. The root's height gets one offset and one scale. With a skin
    the points are the vertices of its soles, as in the paper. Places requested by labels are ignored: the method
    determines when a foot stands, not where it stands.

    Args:
        clip: F frames, metres, y up.
        rig: its legs, soles and floor.
        plants: what is to stand; where they end up is read from the corrected clip.
        params: of the method.
        ground: (F, 3) [m] displacement of the ground under planted feet, as of a belt; none by default.

    Returns:
        The correction: no rotations; no shift where all plants stand well enough, or the root has no position channels.
    """
    pose = rig.pose(clip)
    moved = np.zeros((len(clip), 3)) if ground is None else ground
    points = np.stack(rig.held(pose), axis=1) - moved[:, None]  # (F, E, 3) [m]
    soles = [track - moved for track in rig.tracks(pose)]
    levels = _levels(rig, soles, plants, params.targets)
    shift = np.zeros((len(clip), 3))
    if clip.skeleton.translates[rig.root] and not _stand_well(points, soles, plants, levels, rig.leg_length, params):
        root = pose.position(rig.root) - moved
        vertices, owners = _vertices(rig, pose, moved)
        heights = [sole[:, 1] for sole in soles]
        if len(owners):
            points, heights = vertices, list(vertices[..., 1].T)
        else:
            owners = np.arange(len(soles))
        shift = _shift(root, points, heights, owners, plants, levels, clip.frame_time, rig.leg_length, params)
    return Correction(rig.root, shift, (), np.zeros((len(clip), 0, 4)))


def _vertices(rig: Rig, pose: Pose, moved: Floats) -> tuple[Floats, Ints]:
    """Track (F, V, 3) [m] the vertices of all soles over the ground, and say which sole point each belongs to (V,)."""
    effector = {(sole.leg, sole.part): e for e, sole in enumerate(rig.soles)}
    tracked, owners = [np.zeros((len(moved), 0, 3))], [np.zeros(0, np.intp)]
    for mesh in rig.meshes:
        which = np.flatnonzero(mesh.sole)
        tracked.append(mesh.tracks(pose, which) - moved[:, None])
        heel, toe = effector[mesh.leg, "heel"], effector[mesh.leg, "toe"]
        owners.append(np.where(mesh.toe[which], toe, heel))
    return np.concatenate(tracked, axis=1), np.concatenate(owners)


def _levels(rig: Rig, soles: Sequence[Floats], plants: Sequence[Footplant], params: TargetParams) -> list[float]:
    """Find the height of the floor under each plant [m]: the rig's, or its own on stairs."""
    on_floor = near_floor(rig, soles, plants, params)
    return [
        rig.floor if near else float(np.median(soles[plant.effector][plant.frames, 1]))
        for plant, near in zip(plants, on_floor, strict=True)
    ]


def _stand_well(
    points: Floats, soles: Sequence[Floats], plants: Sequence[Footplant], levels: Sequence[float], leg_length: float,
    params: LyardRootParams,
) -> bool:  # fmt: skip
    """Tell whether all plants stand as well as the root alone could make them stand."""
    for plant, level in zip(plants, levels, strict=True):
        places = points[plant.frames, plant.effector]
        slide = float(norm((places - usual_place(places))[:, [0, 2]]).max())
        height = float(np.abs(soles[plant.effector][plant.frames, 1] - level).max())
        if slide > params.keep_slide * leg_length or height > params.keep_height * leg_length:
            return False
    return True


def _shift(
    root: Floats, points: Floats, heights: Sequence[Floats], owners: Ints, plants: Sequence[Footplant],
    levels: Sequence[float], frame_time: float, leg_length: float, params: LyardRootParams,
) -> Floats:  # fmt: skip
    """Compute the shift (F, 3) [m] of the root (F, 3) [m] from points, their heights, and their effectors."""
    planted = np.zeros(points.shape[:2], dtype=np.bool_)
    above = np.stack(heights, axis=1)  # (F, E) [m] over each one's floor
    for plant, level in zip(plants, levels, strict=True):
        own = np.flatnonzero(owners == plant.effector)
        planted[plant.start : plant.end, own] = True
        above[plant.start : plant.end, own] -= level
    smooth = _speeds(points, frame_time, params.speed_window)
    static = static_points(smooth, planted, frame_time, params.hand_over * leg_length)
    shift = np.zeros_like(root)
    shift[:, [0, 2]] = _over_floor(root, points, static, frame_time, params)
    t = np.flatnonzero(static >= 0)
    if params.vertical and len(t):
        shift[:, 1] = height_shift(root[:, 1], t, above[t, static[t]])
    return shift


def _over_floor(root: Floats, points: Floats, static: Ints, frame_time: float, params: LyardRootParams) -> Floats:
    """Compute the root's shift over the floor, (F, 2) [m], none in the first frame."""
    frames = len(root)
    steps = np.diff(root, axis=0)[:, [0, 2]]
    # one static point, or two in turn; in flight the root's own velocity stays
    t = np.flatnonzero((static[:-1] >= 0) & (static[1:] >= 0))
    sharp = _speeds(points, frame_time, 0.0)
    more = root_steps(t, static[t], static[t + 1], points - root[:, None], sharp)[:, [0, 2]] - steps[t]
    gained = np.zeros((frames, 2))
    gained[t + 1] = _calmed(more, t, frames, round(params.calm / frame_time / 2))
    shift = np.cumsum(gained, axis=0)
    if params.pin_end and frames > 1:
        u = np.linspace(0.0, 1.0, frames)[:, None]
        shift -= (3.0 - 2.0 * u) * u * u * shift[-1]
    return np.asarray(shift)


def root_steps(t: Ints, i: Ints, j: Ints, offsets: Floats, speeds: Floats) -> Floats:
    """Step the root from t to t + 1 so that point i is static at first, and j from t + q on (L eq. 1 with delta = q).

    Args:
        t: (N,) frames.
        i, j: (N,) points, which may be the same.
        offsets: (F, E, 3) [m] o(v, t) from the root, in world axes.
        speeds: (F, E) [m/s].

    Returns:
        (N, 3) [m], of which L applies the part over the floor.
    """
    q = hand_over(t, i, j, speeds)
    at_i, at_j = (offset_at(offsets, speeds, t, v, q) for v in (i, j))
    # dR' = o(v_i, t) - o(v_i, t + q) + o(v_j, t + q) - o(v_j, t + 1)
    handed = offsets[t, i] - at_i + at_j - offsets[t + 1, j]
    return np.where((i == j)[:, None], offsets[t, i] - offsets[t + 1, i], handed)


def _calmed(more: Floats, t: Ints, frames: int, half: int) -> Floats:
    """Average what the steps t (N,) gain, (N, 2) [m], over the planted steps within `half` frames of each.

    One point at a time is held, so that its noise would shake the whole figure.
    """
    total = np.zeros((frames + 2 * half, 3))
    total[t + half, :2], total[t + half, 2] = more, 1.0
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(total, axis=0)])
    window = sums[t + 2 * half + 1] - sums[t]
    return np.asarray(window[:, :2] / window[:, 2:])


def _speeds(points: Floats, frame_time: float, window: float) -> Floats:
    """Compute the speeds (F, E) [m/s] of points (F, E, 3) [m], averaged over the window [s] (L §3.1.2)."""
    if len(points) < 2:
        return np.zeros(points.shape[:2])
    speed = norm(np.gradient(points, frame_time, axis=0))
    half = round(window / frame_time / 2)
    if half == 0:
        return speed
    padded = np.concatenate([np.repeat(speed[:1], half + 1, axis=0), speed, np.repeat(speed[-1:], half, axis=0)])
    total = np.cumsum(padded, axis=0)
    return np.asarray((total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1))


def static_points(speeds: Floats, planted: Bools, frame_time: float, cost: float) -> Ints:
    """Choose the static point of each frame among those in contact (L §3.1.2).

    L takes the slowest point in each frame; under noise the choice alternates, and each change adds a little drift. So
    the sequence of points that moves least in total is chosen, a hand-over counting as a motion of `cost` (Viterbi,
    over stretches in which the same points are planted and the same one is slowest).

    Args:
        speeds: (F, E) [m/s].
        planted: (F, E).
        frame_time: [s].
        cost: [m]; 0 is the paper's own choice.

    Returns:
        (F,) points, -1 in flight.
    """
    slowest = np.where(planted.any(axis=1), np.argmin(np.where(planted, speeds, np.inf), axis=1), -1)
    changes = np.any(planted[1:] != planted[:-1], axis=1) | (slowest[1:] != slowest[:-1])
    starts = np.concatenate([[0], np.flatnonzero(changes) + 1])
    moved = np.where(planted[starts], np.add.reduceat(speeds * frame_time, starts, axis=0), np.inf)
    best = np.zeros(planted.shape[1])
    came = np.zeros(moved.shape, dtype=np.intp)
    for k, move in enumerate(moved):
        if slowest[starts[k]] < 0:  # in flight: whatever comes next is free to choose
            came[k], best = int(np.argmin(best)), np.full_like(best, best.min())
            continue
        cheapest = int(np.argmin(best))
        stay = best <= best[cheapest] + cost
        came[k] = np.where(stay, np.arange(len(best)), cheapest)
        best = np.where(stay, best, best[cheapest] + cost) + move
    chosen = np.empty(len(starts), dtype=np.intp)
    state = int(np.argmin(best))
    for k in range(len(starts) - 1, -1, -1):
        chosen[k] = state
        state = int(came[k, state])
    static = np.repeat(chosen, np.diff(np.concatenate([starts, [len(planted)]])))
    return np.asarray(np.where(slowest >= 0, static, -1))


def height_shift(root: Floats, t: Ints, above: Floats) -> Floats:
    """Shift the root's height by one offset and one scale, so that static points are at their floors (L §3.3).

    Args:
        root: (F,) [m] height of the root.
        t: (N,) the frames that have a static point.
        above: (N,) [m] its height over its floor there, h.

    Returns:
        (F,) [m].
    """
    # dH = -mean(h)
    offset = -above.mean()
    r = root - root.mean()
    relative = above - root[t]  # l: the static point, seen from the root
    # alpha = -sum(r (H + l)) / sum(r^2),  H the mean height of the root with the offset
    spread = float(np.sum(r[t] ** 2))
    alpha = -float(np.sum(r[t] * (root.mean() + offset + relative))) / spread if spread > 1e-12 else 1.0
    return np.asarray(offset + (alpha - 1.0) * r)

"""Lyard & Magnenat-Thalmann's detector: one static sole point at a time (L §3.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.detect.tracks import GRAVITY, Finding, Tracks
from footfix.motion.clip import Bools, Floats, Ints
from footfix.motion.smoothing import savgol

_MOST_PAIRS = 1 << 18  # pairs of points evaluated at a time, which bounds memory


@dataclass(frozen=True, kw_only=True)
class LyardParams:
    """Values that L §3.1 does not give, and limits of its assumption that a foot is on the ground.

    Args:
        step: [s] over which the root's motion is compared; L's one frame of motion at "no more than 25 Hz".
        smooth: [s] window of the speeds by which the point is picked (L §3.1.2: 5 frames).
        still: [sqrt(g leg)] below this speed the root stands still and the dot product means nothing; then
            every point slower than this is static.
        fall: [g] in flight the pelvis falls faster than this, and no sole point is low.
        low: [leg lengths] above the lowest place nearby; what is higher is not on the floor.
        nearby: [s] how far before and after that place is searched.
    """

    step: float = 0.04
    smooth: float = 0.2
    still: float = 0.03
    fall: float = 0.4
    low: float = 0.02
    nearby: float = 0.6


def lyard(tracks: Tracks, params: LyardParams) -> Finding:
    """Detect one static sole point at a time (L §3.1), none in flight, all slow ones where the root stands still.

    With a skin the points are the vertices of its soles, as in the paper; heel and toe of each foot stand in for them
    without one. A vertex that is static plants the heel or the toe, whichever part of the foot it belongs to.
    """
    points, effectors = _points(tracks)  # (E, F, 3), (E,)
    speeds = _smooth_speeds(points, tracks, params)  # (E, F)
    hop = min(max(round(params.step / tracks.frame_time), 1), len(tracks) - 1)
    frames = np.arange(len(tracks))
    first = np.clip(frames - (hop - 1) // 2, 0, len(tracks) - 1 - hop)
    best, way = _best_next(points, tracks.pelvis, first, hop)
    static = _follow(best, speeds, effectors // 2)  # (F,)
    columns = np.arange(2 * len(tracks.feet))
    mask = effectors[static][:, None] == columns
    still = way < params.still * tracks.froude_speed * hop * tracks.frame_time
    least = np.stack([speeds[effectors == column].min(axis=0, initial=np.inf) for column in columns], axis=1)
    mask = np.where(still[:, None], least < params.still * tracks.froude_speed, mask)
    return Finding(mask & ~_in_flight(points, tracks, params)[:, None])


def _points(tracks: Tracks) -> tuple[Floats, Ints]:
    """Get the sole points (E, F, 3) [m], and the effector (E,) of each: 2 x foot, + 1 for the toe."""
    points, effectors = [], []
    for k, foot in enumerate(tracks.feet):
        if foot.mesh is None or foot.of_toe is None:
            points.append(np.stack(foot.soles))
            effectors.append(2 * k + np.arange(2))
        else:
            points.append(foot.mesh)
            effectors.append(2 * k + foot.of_toe.astype(np.intp))
    return np.concatenate(points), np.concatenate(effectors)


def _smooth_speeds(points: Floats, tracks: Tracks, params: LyardParams) -> Floats:
    """Average the points' speeds over a window, (E, F) [m/s]."""
    speeds = np.linalg.norm(np.gradient(points, tracks.frame_time, axis=1), axis=-1)
    return savgol(speeds.T, tracks.frame_time, seconds=params.smooth, degree=0).T


def _agreement(points: Floats, root: Floats, first: Ints, hop: int) -> tuple[Floats, Floats]:
    """Compute L eq. 1 and the dot product p for every pair of points, (F, E, E) by i and j, and |dR| (F,) [m]."""
    offset = points - root  # o(v, t), in world axes
    now, then = offset[:, first], offset[:, first + hop]
    half = 0.5 * (now + then)  # o(v, t + delta), delta = 1/2, by linear interpolation
    # eq. 1: dR' = o(vi, t) - o(vi, t + delta) + o(vj, t + delta) - o(vj, t + 1)
    leave, arrive = (now - half).transpose(1, 0, 2), (half - then).transpose(1, 0, 2)  # (F, E, 3)
    moved = leave[:, :, None] + arrive[:, None, :]
    way = root[first + hop] - root[first]
    lengths = np.linalg.norm(way, axis=-1)[:, None, None] * np.linalg.norm(moved, axis=-1)
    dots = np.einsum("fijk,fk->fij", moved, way) / np.maximum(lengths, 1e-12)
    return dots, np.linalg.norm(way, axis=-1)


def _best_next(points: Floats, root: Floats, first: Ints, hop: int) -> tuple[Ints, Floats]:
    """Find the best next static point (F, E) for each present one (L §3.1.1), and |dR| (F,) [m]; block by block."""
    size = max(1, _MOST_PAIRS // len(points) ** 2)
    best, ways = [], []
    for k in range(0, len(first), size):
        dots, way = _agreement(points, root, first[k : k + size], hop)
        best.append(np.argmax(dots, axis=2))
        ways.append(way)
    return np.concatenate(best), np.concatenate(ways)


def _follow(best: Ints, speeds: Floats, feet: Ints) -> Ints:
    """Find the static point (F,) of each frame: the first by speed alone, each later one from the one before.

    The dot product says which foot it is on (L §3.1.1); of that foot it is the slowest point (L §3.1.2), from which
    the next one is found.
    """
    own = [np.where((feet == k)[:, None], speeds, np.inf) for k in range(int(feet.max()) + 1)]
    slowest = np.stack([np.argmin(each, axis=0) for each in own])  # (feet, F)
    on = feet[best]  # (F, E)
    static = np.empty(len(best), dtype=np.intp)
    point = static[0] = int(np.argmin(speeds[:, 0]))
    for t, foot in enumerate(on[:-1].tolist(), start=1):
        static[t] = point = int(slowest[foot[point], t])
    return static


def _in_flight(points: Floats, tracks: Tracks, params: LyardParams) -> Bools:
    """Mark flight (F,): no sole point is low, and the pelvis falls freely or all points are high up."""
    lowest = points[:, :, 1].min(axis=0)
    reach = max(round(params.nearby / tracks.frame_time), 1)
    padded = np.pad(lowest, reach, mode="edge")
    floor = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1).min(axis=1)
    height = (lowest - floor) / tracks.leg_length
    fall = savgol(tracks.pelvis[:, 1], tracks.frame_time, seconds=0.12, degree=2, derivative=2)
    return np.asarray((height > params.low) & ((fall < -params.fall * GRAVITY) | (height > 5.0 * params.low)))

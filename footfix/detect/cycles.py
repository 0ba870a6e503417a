"""Gait cycles of a clip: from one right strike to the next, and whether it walks or runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.detect.tracks import FootTracks, Tracks
from footfix.motion.clip import Floats
from footfix.motion.smoothing import savgol

_AROUND = 0.5  # [s] before and after a moment, in which a foot that stands then is not lower
_HALF = 0.52  # of a cycle: where feet stand for less than half there is a flight; one just over the floor counts, too


@dataclass(frozen=True, kw_only=True)
class CycleParams:
    """What counts as a cycle.

    Args:
        smooth: [s] window over the feet's distance.
        stride: [leg lengths] by which one foot must pass the other, and back.
        shortest, longest: [s] a cycle lasts, at the least and at most.
        lopsided: how far from the middle of the cycle the left foot may strike, of its length [share].
        uneven: how much longer a cycle may be than the one before it [factor].
        low: [leg lengths] over its lowest, up to which a foot may stand.
    """

    smooth: float = 0.15
    stride: float = 0.25
    shortest: float = 0.35
    longest: float = 2.2
    lopsided: float = 0.2
    uneven: float = 1.5
    low: float = 0.05


@dataclass(frozen=True)
class Cycle:
    """One stride.

    Args:
        start, end: frames of a right strike and of the next.
        run: whether it is run: each foot stands for less than half of it.
        step: [leg lengths] from the one foot to the other, where they are farthest apart.
    """

    start: float
    end: float
    run: bool
    step: float


def find_cycles(tracks: Tracks, left: FootTracks, right: FootTracks, params: CycleParams) -> list[Cycle]:
    """Find the cycles of a pair of legs.

    A foot strikes about when it is farthest from the pelvis in the direction of travel (J. A. Zeni et al.,
    Gait & Posture 27, 2008), which needs no floor, and no root that tells the truth.
    """
    forward = _travel(tracks, left, right)
    apart = np.sum((right.ankle - left.ankle)[:, ::2] * forward, axis=1) / tracks.leg_length
    apart = savgol(apart, tracks.frame_time, seconds=params.smooth, degree=2)
    turns = zigzag(apart, params.stride)
    standing = [_standing(tracks, foot, forward, params.low) for foot in (left, right)]
    cycles: list[Cycle] = []
    for a, b, c in zip(turns[:-2], turns[1:-1], turns[2:], strict=True):
        period = (c - a) * tracks.frame_time
        centred = abs((b - a) / (c - a) - 0.5) <= params.lopsided
        if apart[a] > apart[b] and params.shortest <= period <= params.longest and centred:
            step = 0.5 * (apart[a] - apart[b])
            duty = float(np.mean([each[a:c].mean() for each in standing]))
            cycles.append(Cycle(float(a), float(c), duty < _HALF, float(step)))
    return _even(cycles, params.uneven)


def _even(cycles: list[Cycle], uneven: float) -> list[Cycle]:
    """Without those much longer than a neighbour that touches them: a pause is in there."""

    def paused(k: int) -> bool:
        length = cycles[k].end - cycles[k].start
        beside = [cycles[j] for j in (k - 1, k + 1) if 0 <= j < len(cycles)]
        touching = [near for near in beside if near.end == cycles[k].start or near.start == cycles[k].end]
        return any(length > uneven * (near.end - near.start) for near in touching)

    return [cycle for k, cycle in enumerate(cycles) if not paused(k)]


def _travel(tracks: Tracks, left: FootTracks, right: FootTracks) -> Floats:
    """(F, 2) unit vectors in the ground plane: where the figure goes, forwards or backwards."""
    across = savgol((left.hip - right.hip)[:, ::2], tracks.frame_time, seconds=0.3, degree=1)
    forward = np.stack([-across[:, 1], across[:, 0]], axis=1)
    forward /= np.maximum(np.linalg.norm(forward, axis=1)[:, None], 1e-12)
    # a foot is low while it goes against the way of the pelvis, whatever the root says
    backing = 0.0
    for foot in (left, right):
        past = np.gradient(np.sum((foot.ankle - tracks.pelvis)[:, ::2] * forward, axis=1))
        height = np.minimum(foot.heel[:, 1], foot.toe[:, 1])
        backing += float(np.sum(past * (height - height.mean())))
    return forward if backing >= 0.0 else -forward


def zigzag(curve: Floats, least: float) -> list[int]:
    """Find frames of highs and lows by turns, each at least `least` away from the one before."""
    slope = np.sign(np.diff(curve))
    extremes = np.flatnonzero(slope[1:] * slope[:-1] < 0.0) + 1
    candidates = [0, *extremes.tolist(), len(curve) - 1]
    turns: list[int] = []
    high = low = candidates[0]
    rising: bool | None = None
    for frame in candidates:
        high = frame if curve[frame] > curve[high] else high
        low = frame if curve[frame] < curve[low] else low
        if rising is not False and curve[high] - curve[frame] > least:
            turns, rising, low = [*turns, high], False, frame
        elif rising is not True and curve[frame] - curve[low] > least:
            turns, rising, high = [*turns, low], True, frame
    inside = (frame for frame in turns if 0 < frame < len(curve) - 1)
    return list(inside)


def _standing(tracks: Tracks, foot: FootTracks, forward: Floats, low: float) -> Floats:
    """(F,) 1 where a foot stands: it goes backwards under the pelvis, and is about as low as it gets around then.

    This needs no floor, and no root that tells the truth: on a treadmill, or under a root that is pinned, a foot that
    stands moves.
    """
    ahead = np.sum((foot.ankle - tracks.pelvis)[:, ::2] * forward, axis=1)
    backwards = np.gradient(savgol(ahead, tracks.frame_time, seconds=0.05, degree=2)) < 0.0
    height = np.minimum(foot.heel[:, 1], foot.toe[:, 1]) / tracks.leg_length
    around = max(1, round(_AROUND / tracks.frame_time))
    padded = np.pad(height, around, mode="edge")
    lowest = np.lib.stride_tricks.sliding_window_view(padded, 2 * around + 1).min(axis=1)
    return np.asarray(backwards & (height - lowest <= low), dtype=np.float64)

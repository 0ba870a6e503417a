"""Gait cycles of a clip: from one right strike to the next, and whether it walks or runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.detect.tracks import FootTracks, Tracks
from footfix.motion.clip import Floats
from footfix.motion.smoothing import savgol

_AROUND = 0.5  # [s] a planted foot is about as low as it gets within this time before and after
_HALF = 0.52  # [share] of a cycle: feet planted for less than this are running (0.5 and a margin for low flight)


@dataclass(frozen=True, kw_only=True)
class CycleParams:
    """What counts as a cycle.

    Args:
        smooth: [s] smoothing window of the distance between the feet.
        stride: [leg lengths] by which one foot must pass the other, and back.
        shortest, longest: [s] least and greatest duration of a cycle.
        lopsided: how far from the middle of the cycle the left foot may strike, as a share of the cycle [share].
        uneven: how much longer a cycle may be than the one before it [factor].
        low: [leg lengths] greatest height of a planted foot over its lowest height.
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
        run: whether the figure runs: each foot is planted for less than half of the cycle.
        step: [leg lengths] greatest distance between the feet.
    """

    start: float
    end: float
    run: bool
    step: float


def find_cycles(tracks: Tracks, left: FootTracks, right: FootTracks, params: CycleParams) -> list[Cycle]:
    """Find the cycles of a pair of legs.

    A foot strikes about when it is farthest from the pelvis in the direction of travel (J. A. Zeni et al.,
    Gait & Posture 27, 2008), which works without a known floor and with a wrong root path.
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
    """Leave out cycles that are much longer than an adjoining one: they contain a pause."""

    def paused(k: int) -> bool:
        length = cycles[k].end - cycles[k].start
        beside = [cycles[j] for j in (k - 1, k + 1) if 0 <= j < len(cycles)]
        touching = [near for near in beside if near.end == cycles[k].start or near.start == cycles[k].end]
        return any(length > uneven * (near.end - near.start) for near in touching)

    return [cycle for k, cycle in enumerate(cycles) if not paused(k)]


def _travel(tracks: Tracks, left: FootTracks, right: FootTracks) -> Floats:
    """Find the direction of travel, (F, 2) unit vectors in the ground plane, walking forwards or backwards."""
    across = savgol((left.hip - right.hip)[:, ::2], tracks.frame_time, seconds=0.3, degree=1)
    forward = np.stack([-across[:, 1], across[:, 0]], axis=1)
    forward /= np.maximum(np.linalg.norm(forward, axis=1)[:, None], 1e-12)
    # a foot is low while it moves backwards relative to the pelvis, whatever the root does
    backing = 0.0
    for foot in (left, right):
        past = np.gradient(np.sum((foot.ankle - tracks.pelvis)[:, ::2] * forward, axis=1))
        height = np.minimum(foot.heel[:, 1], foot.toe[:, 1])
        backing += float(np.sum(past * (height - height.mean())))
    return forward if backing >= 0.0 else -forward


def zigzag(curve: Floats, least: float) -> list[int]:
    """Find the frames of alternating maxima and minima, each at least `least` from the one before."""
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
    """Mark with 1 (F,) where a foot is planted: it moves backwards under the pelvis and is about at its lowest.

    This works without a known floor and with a wrong root path: on a treadmill, or under a fixed root, a planted foot
    moves.
    """
    ahead = np.sum((foot.ankle - tracks.pelvis)[:, ::2] * forward, axis=1)
    backwards = np.gradient(savgol(ahead, tracks.frame_time, seconds=0.05, degree=2)) < 0.0
    height = np.minimum(foot.heel[:, 1], foot.toe[:, 1]) / tracks.leg_length
    around = max(1, round(_AROUND / tracks.frame_time))
    padded = np.pad(height, around, mode="edge")
    lowest = np.lib.stride_tricks.sliding_window_view(padded, 2 * around + 1).min(axis=1)
    return np.asarray(backwards & (height - lowest <= low), dtype=np.float64)

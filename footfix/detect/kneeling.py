"""Feet that bear no weight: a figure that kneels, crawls or lies drags them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.detect.tracks import FootTracks, Tracks
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.motion.smoothing import savgol


@dataclass(frozen=True, kw_only=True)
class KneelingParams:
    """When a knee is on the floor, and when the foot behind it is still in contact.

    Args:
        low: [leg lengths] a knee less than this over the lowest sole point is on the floor.
        still: [leg lengths/s] a sole point of such a leg that is slower than this is still in contact.
        least: [s] if it stays that slow for at least this long.
        smooth: [s] smoothing window of that speed.
    """

    low: float = 0.18
    still: float = 0.15
    least: float = 0.3
    smooth: float = 0.2


def carrying(mask: Bools, tracks: Tracks, foot: FootTracks, point: Floats, params: KneelingParams) -> Bools:
    """Remove from a sole point's contacts (F,) those in which the knee is on the floor and the point moves."""
    if foot.knee is None or not mask.any():
        return mask
    lowest = np.min([sole[:, 1] for each in tracks.feet for sole in each.soles], axis=0)
    down: Bools = foot.knee[:, 1] - lowest < params.low * tracks.leg_length
    if not down.any():
        return mask
    velocity = savgol(point, tracks.frame_time, seconds=params.smooth, degree=1, derivative=1)
    moves = np.linalg.norm(velocity, axis=1) > params.still * tracks.leg_length
    left: Bools = mask & ~(down & moves)
    for a, b in runs(left):
        if down[a:b].all() and (b - a) * tracks.frame_time < params.least:
            left[a:b] = False
    return left

"""Feet that carry nothing: who kneels, crawls or lies drags them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.detect.tracks import Foot, Tracks
from footfix.motion.clip import Bools, Floats
from footfix.motion.smoothing import savgol


@dataclass(frozen=True, kw_only=True)
class KneelingParams:
    """When a knee is down, and what a foot behind it may still do.

    Args:
        low: [leg lengths] a knee this little over the lowest sole point is down.
        still: [leg lengths/s] a sole point slower than this rests all the same.
        smooth: [s] window of that speed.
    """

    low: float = 0.18
    still: float = 0.15
    smooth: float = 0.2


def dragged(tracks: Tracks, foot: Foot, point: Floats, params: KneelingParams) -> Bools:
    """(F,) where a sole point moves while its leg's knee is down, so that it can't be planted."""
    if foot.knee is None:
        return np.zeros(len(point), dtype=np.bool_)
    lowest = np.min([sole[:, 1] for each in tracks.feet for sole in each.soles], axis=0)
    down: Bools = foot.knee[:, 1] - lowest < params.low * tracks.leg_length
    if not down.any():
        return down
    velocity = savgol(point, tracks.frame_time, seconds=params.smooth, degree=1, derivative=1)
    moves = np.linalg.norm(velocity, axis=1) > params.still * tracks.leg_length
    return np.asarray(down & moves)

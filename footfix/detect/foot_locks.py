"""Feet locked by another program and released with a jump: the contact ends with the lock."""

from __future__ import annotations

import numpy as np

from footfix.detect.tracks import Tracks
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import PUT_TO_REST, runs

_SHARE, _FEWEST = 0.5, 5  # frames at rest in a locked contact: this share of it, and at least this many
_SNAP = 0.0114  # [leg lengths] jump in one frame beside the lock: 1 cm for an adult; a foot that lifts is slower


def let_go(mask: Bools, tracks: Tracks) -> Bools:
    """Shorten contacts to the frames of a foot lock where the foot jumps into or out of the lock.

    Args:
        mask: (F, 2 legs) heel, then toe of each foot.
        tracks: of the clip.
    """
    out = mask.copy()
    points = [point for foot in tracks.feet for point in (foot.heel, foot.toe)]
    for column, point in enumerate(points):
        for start, end in runs(mask[:, column]):
            first, last = _rest(point[start:end] / tracks.leg_length, tracks.frame_time)
            out[start : start + first, column] = False
            out[start + last : end, column] = False
    return out


def _rest(place: Floats, frame_time: float) -> tuple[int, int]:
    """Find the frames `[first, last)` of a contact (n, 3) [leg lengths] that are kept; all where nothing jumps."""
    step = np.linalg.norm(np.diff(place, axis=0), axis=1)
    rests = np.flatnonzero(step <= PUT_TO_REST * frame_time)
    if len(rests) < max(_FEWEST, _SHARE * len(step)):
        return 0, len(place)
    first, last = int(rests[0]), int(rests[-1]) + 2
    comes, goes = (step[at].max(initial=0.0) > _SNAP for at in (slice(max(first - 1, 0), first), slice(last - 1, last)))
    return first if comes else 0, last if goes else len(place)

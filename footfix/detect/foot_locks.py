"""Feet that a program put to rest and let go with a snap: the contact is as long as the rest."""

from __future__ import annotations

import numpy as np

from footfix.detect.tracks import Tracks
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import PUT_TO_REST, runs

_SHARE, _FEWEST = 0.5, 5  # of a contact's steps, and at least so many
_SNAP = 0.0114  # [leg lengths] in the one frame beside the rest: 1 cm of a grown-up; a foot that lifts is slower


def let_go(mask: Bools, tracks: Tracks) -> Bools:
    """End contacts where a foot that rests to the digit snaps away, or comes with a snap.

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
    """The frames of a contact (n, 3) [leg lengths] that are left of it, as a stretch; all where nothing snaps."""
    step = np.linalg.norm(np.diff(place, axis=0), axis=1)
    rests = np.flatnonzero(step <= PUT_TO_REST * frame_time)
    if len(rests) < max(_FEWEST, _SHARE * len(step)):
        return 0, len(place)
    first, last = int(rests[0]), int(rests[-1]) + 2
    comes, goes = (step[at].max(initial=0.0) > _SNAP for at in (slice(max(first - 1, 0), first), slice(last - 1, last)))
    return first if comes else 0, last if goes else len(place)

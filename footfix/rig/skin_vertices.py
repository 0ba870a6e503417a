"""Which vertices of a foot are kept: all that can be its lowest, some of its sole, and lines around it."""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Bools, Floats, Ints
from footfix.rig.skin import SkinFoot

LOW = 0.03  # [leg lengths] up to this height over the sole a foot's outline is looked at
_MOST_SOLE = 64  # vertices of a sole that are looked at one by one
_ALL = 160  # vertices of a foot up to which all are kept


def toes(sole: SkinFoot) -> Bools:
    """Tell (V,) which vertices belong to the toe's sole point: those nearer to the ball than to the heel, ahead."""
    along = sole.vertices @ sole.ahead
    heel, ball = float(sole.heel @ sole.ahead), float(sole.ball @ sole.ahead)
    return np.asarray(along > 0.5 * (heel + ball))


def kept(sole: SkinFoot, part: Bools) -> Ints:
    """Choose the vertices that are kept: all of a few; of many those of the sole, and of the convex hull of each part.

    Of vertices that move with one joint the lowest is always one of their hull.
    """
    count = len(sole.vertices)
    if count <= _ALL:
        return np.arange(count)
    found = set(spread(sole).tolist())
    groups = np.clip(np.round(4.0 * sole.share), 0, 4)
    for group in range(5):
        for own in (part, ~part):
            found |= set(_hull(sole.vertices, np.flatnonzero((groups == group) & own)).tolist())
    low = sole.vertices @ sole.up - sole.level < LOW * sole.length
    for own in (sole.share <= 0.5, sole.share > 0.5):
        found |= set(outline(sole, np.flatnonzero(low & own)))
    return np.array(sorted(found), np.intp)


def _hull(points: Floats, which: Ints) -> Ints:
    from scipy.spatial import ConvexHull, QhullError

    if len(which) < 5:
        return which
    try:
        return np.asarray(which[ConvexHull(points[which]).vertices])
    except QhullError:
        return which


def outline(sole: SkinFoot, which: Ints) -> list[int]:
    """List the vertices around some of them, seen from below."""
    from scipy.spatial import ConvexHull, QhullError

    if len(which) < 3:
        return []
    flat = np.stack([sole.vertices[which] @ sole.ahead, sole.vertices[which] @ sole.left], axis=1)
    try:
        return [int(v) for v in which[ConvexHull(flat).vertices]]
    except QhullError:
        return []


def spread(sole: SkinFoot) -> Ints:
    """Choose up to `_MOST_SOLE` vertices of the sole, spread over it: always the one farthest from those chosen."""
    own = np.flatnonzero(sole.sole)
    if len(own) <= _MOST_SOLE:
        return own
    points = sole.vertices[own]
    chosen = [int(np.argmin(points @ sole.up))]
    away = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < _MOST_SOLE:
        chosen.append(int(np.argmax(away)))
        away = np.minimum(away, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.asarray(own[np.sort(chosen)])

"""Choose the vertices of a foot to keep: all that can be its lowest, some of its sole, and its outlines."""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Bools, Floats, Ints
from footfix.rig.skin import SkinFoot

LOW = 0.03  # [leg lengths] height over the sole up to which vertices belong to a foot's outline
_MOST_SOLE = 64  # most vertices kept of a sole
_ALL = 160  # all vertices of a foot are kept if there are no more than this


def toes(sole: SkinFoot) -> Bools:
    """Mark the vertices (V,) of the toe's sole point: nearer to the ball than to the heel, along the foot."""
    along = sole.vertices @ sole.ahead
    heel, ball = float(sole.heel @ sole.ahead), float(sole.ball @ sole.ahead)
    return np.asarray(along > 0.5 * (heel + ball))


def kept(sole: SkinFoot, part: Bools) -> Ints:
    """Choose the vertices to keep: all if they are few, else those of the sole and of the convex hull of each part.

    The lowest of vertices that move with one joint is always on their convex hull.
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
    """List the vertices of the outline of some of them, seen from below."""
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

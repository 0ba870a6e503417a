"""Leading round where a path turns back on itself: who walks there swings out and comes back."""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Floats

_AHEAD = 0.8  # of the smallest radius: how far ahead one looks
_SWINGS = 0.5  # of that radius: the way in which a curve becomes as sharp as it gets
_LONGER = 3.0  # times as long as the path the way may be


def pursued(points: Floats, step: float, sharpest: float) -> Floats:
    """The way of somebody who looks ahead on a path, goes there, and turns no more sharply than allowed.

    Source: R. C. Coulter, Implementation of the pure pursuit path tracking algorithm, CMU-RI-TR-92-01 (1992):
    the arc to a point at an angle a and a distance d has the curvature 2 sin(a) / d.

    Args:
        points: (N, 2) [m] of the path, evenly spaced.
        step: [m] from one to the next.
        sharpest: [rad/m].

    Returns:
        (M, 2) [m] as evenly spaced.
    """
    ahead = max(2, round(_AHEAD / sharpest / step))
    change = sharpest * step * sharpest / _SWINGS
    end = points[-1] - points[-2]
    far = np.concatenate([points, points[-1] + np.arange(1, ahead + 1)[:, None] * end])
    here, heading = points[0], float(np.arctan2(*(points[1] - points[0])))
    way, at, bent = [here], 0, 0.0
    while at < len(points) - 1 and len(way) < _LONGER * len(points) + ahead:
        near = np.linalg.norm(far[at : at + ahead] - here, axis=1)
        at = min(at + int(np.argmin(near)), len(points) - 1)
        line = far[at + ahead] - here
        angle = float(np.arctan2(*line)) - heading
        angle -= 2.0 * np.pi * round(angle / (2.0 * np.pi))
        wanted = 2.0 * np.sin(angle) / max(float(np.hypot(*line)), step)
        if abs(angle) > 0.5 * np.pi:  # it lies behind: round, on the side on which one turns already
            wanted = np.copysign(sharpest, bent if abs(angle) > 0.75 * np.pi and bent else angle)
        bent += float(np.clip(np.clip(wanted, -sharpest, sharpest) - bent, -change, change))
        heading += bent * step
        here = here + step * np.array([np.sin(heading), np.cos(heading)])
        way.append(here)
    return np.array(way)

"""Pure-pursuit path following with a curvature limit, for paths that turn back."""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Floats

_AHEAD = 0.8  # look-ahead distance, as a share of the smallest radius
_SWINGS = 0.5  # distance over which curvature builds up, as a share of the smallest radius
_LONGER = 3.0  # greatest length of the result, as a multiple of the path's


def pursued(points: Floats, step: float, sharpest: float) -> Floats:
    """Follow a path by steering towards a point ahead on it, with a limit on curvature.

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
        if abs(angle) > 0.5 * np.pi:  # it lies behind: keep turning to the same side
            wanted = np.copysign(sharpest, bent if abs(angle) > 0.75 * np.pi and bent else angle)
        bent += float(np.clip(np.clip(wanted, -sharpest, sharpest) - bent, -change, change))
        heading += bent * step
        here = here + step * np.array([np.sin(heading), np.cos(heading)])
        way.append(here)
    return np.array(way)

"""Convert a few rotations to Euler angles in few operations, as `rotation.to_euler` does for a clip."""

from __future__ import annotations

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Floats

_LOCKED = 1e-6  # of the cosine of the middle angle


def to_euler(q: Floats, order: tuple[int, ...], near: Floats) -> Floats:
    """Convert rotations (..., 4) to intrinsic angles (..., 3) [rad] about three different axes, nearest to others.

    Args:
        q: unit quaternions.
        order: the axes.
        near: (..., 3) [rad].
    """
    i, j, k = order
    parity = 1.0 if (j - i) % 3 == 1 else -1.0
    p = np.moveaxis(q, -1, 0)
    p = 2.0 * p[:, None] * p[None]  # twice the products of all components
    cos_a, cos_c = 1.0 - (p[i, i] + p[j, j]), 1.0 - (p[j, j] + p[k, k])
    sin_a, sin_c = p[i, 3] - parity * p[j, k], p[k, 3] - parity * p[i, j]
    cos_b = np.hypot(cos_c, sin_c)
    if np.any(cos_b < _LOCKED):
        return rotation.to_euler(q, "".join("XYZ"[axis] for axis in order), near=near)
    both = np.empty((2, *near.shape))  # every rotation has two solutions
    first, second = both
    first[..., 0], first[..., 2] = np.arctan2(sin_a, cos_a), np.arctan2(sin_c, cos_c)
    first[..., 1] = np.arctan2(p[j, 3] + parity * p[i, k], cos_b)
    np.add(first, np.pi, out=second)
    np.subtract(np.pi, first[..., 1], out=second[..., 1])
    both -= 2.0 * np.pi * np.round((both - near) / (2.0 * np.pi))
    far = np.add.reduce(np.abs(both - near), axis=-1)
    return np.asarray(np.where((far[1] < far[0])[..., None], second, first))

"""Arithmetic of vectors along the last axis of arrays of any shape."""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Floats


def dot(a: Floats, b: Floats) -> Floats:
    """Compute the scalar products (...) of (..., D)."""
    return np.asarray(np.einsum("...i,...i->...", a, b))


def norm(a: Floats) -> Floats:
    """Compute the lengths (...) of (..., D)."""
    return np.sqrt(dot(a, a))


def unit(a: Floats) -> Floats:
    """Scale (..., D) to length 1; zero stays zero."""
    return a / np.maximum(norm(a), 1e-300)[..., None]


def cross(a: Floats, b: Floats) -> Floats:
    """Compute vector products (..., 3) of (..., 3); faster than `np.cross` on small arrays."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0], out[..., 1], out[..., 2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return out

"""Rotations and vectors of a few legs at a few times, in as few operations as possible.

A live engine makes some frames of some legs at once. Arrays are small then, and what counts is the number of operations
on them, not their size: matrices are multiplied rather than their components one by one.
"""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Floats, Ints, frozen
from footfix.motion.rotation import multiply, to_matrix

_STILL = frozen(np.eye(3))


def _squares_to_matrix() -> Floats:
    """Make the map (16, 9) from the products of a quaternion's components, xyzw, to its matrix, row by row."""
    table = np.zeros((4, 4, 3, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        table[i, i, i, i] = table[3, 3, i, i] = 1.0
        table[j, j, i, i] = table[k, k, i, i] = -1.0
        table[i, j, i, j] = table[i, j, j, i] = 2.0
        table[3, k, i, j], table[3, k, j, i] = -2.0, 2.0
    return frozen(table.reshape(16, 9))


def _matrix_to_squares() -> Floats:
    """Make the map (9, 16) from a matrix to four times the products of its quaternion's components, less a constant."""
    table = np.zeros((3, 3, 4, 4))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        table[i, i] = np.diag([-1.0, -1.0, -1.0, 1.0])
        table[i, i, i, i] = 1.0
        table[i, j, i, j] = table[j, i, i, j] = table[i, j, j, i] = table[j, i, j, i] = 1.0
        table[j, i, 3, k] = table[j, i, k, 3] = 1.0
        table[i, j, 3, k] = table[i, j, k, 3] = -1.0
    return frozen(table.reshape(9, 16))


def _vector_to_cross() -> Floats:
    """Make the map (3, 9) from a vector to the matrix of its cross product, row by row."""
    table = np.zeros((3, 3, 3))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        table[k, i, j], table[k, j, i] = -1.0, 1.0
    return frozen(table.reshape(3, 9))


_TO_MATRIX, _TO_SQUARES, _TO_CROSS = _squares_to_matrix(), _matrix_to_squares(), _vector_to_cross()
_ONES = frozen(np.eye(4).ravel())


def dot(a: Floats, b: Floats) -> Floats:
    """Compute the scalar products (...) of vectors (..., 3)."""
    return np.asarray(np.add.reduce(a * b, axis=-1))


def norm(a: Floats) -> Floats:
    """Compute the lengths (...) of vectors (..., 3)."""
    return np.asarray(np.sqrt(np.add.reduce(a * a, axis=-1)))


def unit(a: Floats) -> Floats:
    """Scale (..., 3) to length 1; zero stays zero."""
    return np.asarray(a / np.maximum(np.sqrt(np.add.reduce(a * a, axis=-1, keepdims=True)), 1e-300))


def crosswise(v: Floats) -> Floats:
    """Make the matrices (..., 3, 3) whose products with w are the cross products v x w."""
    return (v @ _TO_CROSS).reshape(*v.shape, 3)


def cross(a: Floats, b: Floats) -> Floats:
    """Compute the cross products (..., 3) of vectors (..., 3)."""
    return applied(crosswise(a), b)


def applied(m: Floats, v: Floats) -> Floats:
    """Multiply matrices (..., 3, 3) by vectors (..., 3)."""
    return np.asarray((m @ v[..., None])[..., 0])


def back(m: Floats) -> Floats:
    """Invert rotation matrices (..., 3, 3)."""
    return m.swapaxes(-1, -2)


def matrices(q: Floats) -> Floats:
    """Convert unit quaternions xyzw (..., 4) to matrices (..., 3, 3)."""
    return (squares(q) @ _TO_MATRIX).reshape(*q.shape[:-1], 3, 3)


def quaternions(m: Floats) -> Floats:
    """Convert rotation matrices (..., 3, 3) to quaternions xyzw (..., 4), each by its largest component.

    Source: S. W. Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1 (1978).
    """
    four = m.reshape(-1, 9) @ _TO_SQUARES + _ONES
    best: Ints = np.argmax(four[:, ::5], axis=1)
    q = four.reshape(-1, 4, 4)[np.arange(len(best)), best]
    q /= np.sqrt(np.add.reduce(q * q, axis=1, keepdims=True))
    return np.asarray(q.reshape(*m.shape[:-2], 4))


def about_up(angle: Floats) -> Floats:
    """Make the matrices (T, 3, 3) of turns about the vertical by angles (T,) [rad]."""
    angle = angle[:, None, None]
    return np.asarray(_UPRIGHT + np.cos(angle) * _ALONG + np.sin(angle) * _ASIDE)


def turned_about_up(angle: Floats, q: Floats) -> Floats:
    """Turn rotations xyzw (T, 4) about the vertical by angles (T,) [rad]."""
    half = 0.5 * angle[:, None]
    return np.asarray(np.cos(half) * q + np.sin(half) * (q @ _UP))


_UPRIGHT, _ALONG = frozen(np.diag([0.0, 1.0, 0.0])), frozen(np.diag([1.0, 0.0, 1.0]))
_ASIDE = frozen([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
_UP = frozen([[0.0, 0.0, -1.0, 0.0], [0.0, 0.0, 0.0, -1.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]])


def exponentials(vector: Floats) -> Floats:
    """Convert rotation vectors (..., 3) [rad] to quaternions xyzw (..., 4)."""
    half = np.maximum(0.5 * np.sqrt(np.add.reduce(vector * vector, axis=-1, keepdims=True)), 1e-9)
    q = np.empty((*vector.shape[:-1], 4))
    np.multiply(vector, 0.5 * np.sin(half) / half, out=q[..., :3])
    np.cos(half, out=q[..., 3:])
    return q


def products(left: Floats) -> Floats:
    """Make the matrices (J, 4, 4) that multiply quaternions (as rows) by `left` (J, 4) from the left."""
    return np.ascontiguousarray(multiply(left[:, None], np.eye(4)))


def matrix_products(left: Floats) -> Floats:
    """Make the maps (J, 16, 9) from `squares` of quaternions q to the matrices of `left` (J, 4) times q."""
    own = _TO_MATRIX.reshape(16, 3, 3)
    return np.ascontiguousarray((to_matrix(left)[:, None] @ own).reshape(len(left), 16, 9))


def squares(q: Floats) -> Floats:
    """Compute the products (..., 16) of the components of quaternions (..., 4)."""
    return (q[..., :, None] * q[..., None, :]).reshape(*q.shape[:-1], 16)


def turned_by(vector: Floats) -> Floats:
    """Convert rotation vectors (..., 3) [rad] to matrices (..., 3, 3) (Rodrigues)."""
    half = np.maximum(0.5 * norm(vector), 1e-9)[..., None, None]
    sine = np.sin(half) / half
    k = crosswise(vector)
    return np.asarray(_STILL + (sine * np.cos(half)) * k + (0.5 * sine * sine) * (k @ k))


def between(a: Floats, b: Floats) -> Floats:
    """Find the smallest rotations (..., 3, 3) that take directions (..., 3) to others."""
    a, b = unit(a), unit(b)
    product = b[..., :, None] * a[..., None, :]
    k = product - product.swapaxes(-1, -2)  # of the cross product of both
    return np.asarray(_STILL + k + (k @ k) / np.maximum(1.0 + dot(a, b), 1e-9)[..., None, None])


def turns_between(a: Floats, b: Floats) -> Floats:
    """Compute the rotation vectors (..., 3) [rad] from frames (..., 3, 3) to others, accurate for small ones."""
    m = b @ back(a)
    flat = m.reshape(*m.shape[:-2], 9)
    axis = flat @ _TO_CROSS.T
    twice = norm(axis)  # the sine of the angle, twice
    angle = np.arctan2(twice, np.add.reduce(flat[..., ::4], axis=-1) - 1.0)
    tiny = twice < 2e-9
    axis *= (np.where(tiny, 0.5, angle) / np.where(tiny, 1.0, twice))[..., None]
    return np.asarray(axis)

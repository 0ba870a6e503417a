"""Rotation and vector arithmetic for a few frames in few operations; results as of the functions for clips.

Vectors and matrices have their components first, quaternions last.
"""

from __future__ import annotations

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Floats

_LEAST = 1e-9  # [rad] below which sin(x) / x rounds to 1
_NEXT, _AFTER = np.array([1, 2, 0]), np.array([2, 0, 1])
_ABOVE, _BELOW = np.array([1, 5, 6]), np.array([3, 7, 2])  # places in a matrix, laid out as a row, and their mirrors

# A quaternion product a b is the sum of w, x, y, z of a, each times the components of b in this order with this sign.
_OWN = np.array([3, 0, 1, 2])
_OTHER = np.array([[0, 1, 2, 3], [3, 2, 1, 0], [2, 3, 0, 1], [1, 0, 3, 2]])
_SIGN = np.array([[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0], [-1.0, 1.0, 1.0, -1.0]])
_INVERSE = np.array([-1.0, -1.0, -1.0, 1.0])
_OPPOSITE = 1e-9  # 1 + the cosine of directions between which any axis turns
_AT = np.argsort(_OWN)
_BACK = _SIGN * np.array([[1.0], [-1.0], [-1.0], [-1.0]])


def product(a: Floats, b: Floats) -> Floats:
    """Compose rotations (..., 4): `b` followed by `a`; see `rotation.multiply`."""
    return np.asarray(np.add.reduce(a[..., _OWN, None] * (b[..., _OTHER] * _SIGN), axis=-2))


def after(b: Floats) -> Floats:
    """Make the matrices (..., 4, 4) that compose rotations a (4,) with rotations b (..., 4): `b` followed by `a`."""
    return np.asarray((b[..., _OTHER] * _SIGN).swapaxes(-1, -2)[..., _AT])


def product_back(a: Floats, b: Floats) -> Floats:
    """Compose rotations (..., 4): `b` followed by the inverse of `a`."""
    return np.asarray(np.add.reduce(a[..., _OWN, None] * (b[..., _OTHER] * _BACK), axis=-2))


def turned(q: Floats, v: Floats) -> Floats:
    """Turn vectors (..., 3) by rotations (..., 4); see `rotation.rotate`."""
    point = np.zeros((*v.shape[:-1], 4))
    point[..., :3] = v
    return product(product(q, point), q * _INVERSE)[..., :3]


def from_rotation_vector(vector: Floats) -> Floats:
    """Convert rotation vectors (3, ...) [rad] to quaternions (..., 4)."""
    half = np.maximum(0.5 * np.sqrt(np.add.reduce(vector * vector, axis=0)), _LEAST)
    out = np.empty((*half.shape, 4))
    out[..., :3] = np.moveaxis(vector * (0.5 * np.sin(half) / half), 0, -1)
    out[..., 3] = np.cos(half)
    return out


def between(a: Floats, b: Floats) -> Floats:
    """Find the shortest rotations (..., 4) that take directions (3, ...) to others; see `rotation.between`."""
    out = np.empty((*a.shape[1:], 4))
    out[..., :3] = np.moveaxis(cross(a, b), 0, -1)
    size = np.sqrt(np.add.reduce(a * a, axis=0) * np.add.reduce(b * b, axis=0))
    out[..., 3] = size + np.add.reduce(a * b, axis=0)
    if np.any(out[..., 3] <= _OPPOSITE * size):
        return rotation.between(np.moveaxis(a, 0, -1), np.moveaxis(b, 0, -1))
    return np.asarray(out / np.sqrt(np.add.reduce(out * out, axis=-1))[..., None])


def cross(a: Floats, b: Floats) -> Floats:
    """Compute vector products (3, ...); the shapes broadcast."""
    return np.asarray(a[_NEXT] * b[_AFTER] - a[_AFTER] * b[_NEXT])


def rotated(matrix: Floats, v: Floats) -> Floats:
    """Multiply matrices (3, 3, ...) by vectors (3, ...)."""
    return np.asarray(np.add.reduce(matrix * v, axis=1))


def exponential(vector: Floats) -> Floats:
    """Convert rotation vectors (3, ...) [rad] to matrices (3, 3, ...); see `enforce.leg_state.exponential`."""
    square, _, sines, halves = _sines(vector)
    return _series(vector, square, sines, halves)


def exponential_and_jacobian(vector: Floats) -> Floats:
    """Compute `exponential` and `left_jacobian` of rotation vectors (3, ...) [rad], (3, 3, 2, ...)."""
    square, angle, sines, halves = _sines(vector)
    both = np.empty((3, *square.shape))
    both[0], both[1] = sines, halves
    both[2] = np.where(angle > 1e-3, (1.0 - sines) / np.maximum(square, 1e-12), 1.0 / 6.0)
    return _series(vector[:, None], square, both[:2], both[1:])


def _sines(vector: Floats) -> tuple[Floats, ...]:
    """Compute x^2, x = |v|, sin(x) / x, and (1 - cos x) / x^2, each (...)."""
    square = np.add.reduce(vector * vector, axis=0)
    angle = np.sqrt(square)
    half = np.maximum(0.5 * angle, _LEAST)
    sine = np.sin(half) / half  # of x / 2
    return square, angle, sine * np.cos(half), 0.5 * sine * sine


def _series(v: Floats, square: Floats, first: Floats, second: Floats) -> Floats:
    """Evaluate I + first [v] + second [v]^2, (3, 3, ...); [v] w = v x w, and [v]^2 = v v' - |v|^2 I."""
    once, twice = first * v, second * v
    flat = np.empty((9, *once.shape[1:]))
    flat[::4] = (1.0 - second * square) + twice * v
    both, skew = twice * v[_NEXT], once[_AFTER]
    flat[_ABOVE], flat[_BELOW] = both - skew, both + skew
    return flat.reshape(3, 3, *once.shape[1:])


def median(values: Floats) -> Floats:
    """Get the middle of the numbers (..., n) of each row."""
    ordered, half = np.sort(values, axis=-1), values.shape[-1] // 2
    if values.shape[-1] % 2:
        return np.asarray(ordered[..., half])
    return np.asarray(0.5 * (ordered[..., half - 1] + ordered[..., half]))

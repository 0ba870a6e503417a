"""Symmetric positive definite systems that are five diagonals wide, over whole clips."""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Floats

_DENSE = 16  # blocks at which the system is small enough to be solved as it stands


def solve(bands: Floats, right: Floats) -> Floats:
    """Solves A x = b for a symmetric positive definite A with two diagonals on either side of the main one.

    Pairs of rows are taken as one, which makes A block tridiagonal, and every second block row is eliminated until
    a few are left (block cyclic reduction; G. Golub, C. Van Loan, Matrix Computations §4.5): some fifteen rounds of
    whole-array arithmetic for an hour of motion. A library's banded solver is as fast, but takes longer to import
    than a usual clip takes to clean.

    Args:
        bands: (3, F) the main diagonal and the two below it, each from its first row on.
        right: (F, K).

    Returns:
        (F, K).
    """
    frames = len(right)
    blocks = -(-frames // 2)
    wide = np.zeros((3, 2 * blocks))
    wide[:, :frames] = bands
    wide[0, frames:] = 1.0
    wide[1, frames - 1 :] = 0.0
    wide[2, max(frames - 2, 0) :] = 0.0
    main, one, two = wide
    diagonal = np.empty((2, 2, blocks))
    diagonal[0, 0], diagonal[1, 1] = main[0::2], main[1::2]
    diagonal[0, 1] = diagonal[1, 0] = one[0::2]
    below = np.zeros((2, 2, blocks))  # what ties each block to the one before it
    below[0, 0, 1:], below[0, 1, 1:], below[1, 1, 1:] = two[0:-2:2], one[1:-2:2], two[1:-2:2]
    padded = np.zeros((2 * blocks, right.shape[1]))
    padded[:frames] = right
    solution = _reduced(diagonal, below, np.ascontiguousarray(padded.reshape(blocks, 2, -1).transpose(1, 2, 0)))
    return solution.transpose(2, 0, 1).reshape(2 * blocks, -1)[:frames]


def product(bands: Floats, x: Floats) -> Floats:
    """(F,) A x for a matrix as `solve` takes it and x (F,)."""
    out = bands[0] * x
    for k in (1, 2):
        out[k:] += bands[k, :-k] * x[:-k]
        out[:-k] += bands[k, :-k] * x[k:]
    return np.asarray(out)


def _times(a: Floats, b: Floats) -> Floats:
    """Products of matrices (2, 2, B) and (2, K, B), block by block; blocks last, so that each line runs over all."""
    return np.asarray(a[:, 0, None] * b[0] + a[:, 1, None] * b[1])


def _reduced(diagonal: Floats, below: Floats, right: Floats) -> Floats:
    """The solution (2, K, B) of a block tridiagonal system of B blocks; `below` k ties block k to k - 1."""
    blocks = diagonal.shape[-1]
    if blocks <= _DENSE:
        return _dense(diagonal, below, right)
    # x of an odd block k is P_k (b_k - L_k x_(k-1) - L_(k+1)^T x_(k+1)), P_k the inverse of its diagonal
    above = np.zeros_like(below)  # what ties each block to the one after it
    above[..., :-1] = below[..., 1:].transpose(1, 0, 2)
    inverse = _inverse(diagonal[..., 1::2])
    odd = inverse.shape[-1]
    even = blocks - odd
    to_left, to_right, own = (_times(inverse, each[..., 1::2]) for each in (below, above, right))
    kept_diagonal, kept_right = diagonal[..., 0::2].copy(), right[..., 0::2].copy()
    kept_below = np.zeros((2, 2, even))
    after, before = above[..., 0::2][..., :odd], below[..., 0::2][..., 1:]  # from an even block to its odd neighbours
    kept_diagonal[..., :odd] -= _times(after, to_left)
    kept_right[..., :odd] -= _times(after, own)
    kept_diagonal[..., 1:] -= _times(before, to_right[..., : even - 1])
    kept_right[..., 1:] -= _times(before, own[..., : even - 1])
    kept_below[..., 1:] = -_times(before, to_left[..., : even - 1])
    solved = _reduced(kept_diagonal, kept_below, kept_right)
    out = np.empty_like(right)
    out[..., 0::2] = solved
    out[..., 1::2] = own - _times(to_left, solved[..., :odd])
    out[..., 1::2][..., : even - 1] -= _times(to_right[..., : even - 1], solved[..., 1:])
    return out


def _inverse(matrices: Floats) -> Floats:
    """The inverses of symmetric matrices (2, 2, B)."""
    (a, b), (_, d) = matrices
    determinant = a * d - b * b
    return np.asarray(np.stack([np.stack([d, -b]), np.stack([-b, a])]) / determinant)


def _dense(diagonal: Floats, below: Floats, right: Floats) -> Floats:
    blocks = diagonal.shape[-1]
    matrix = np.zeros((blocks, 2, blocks, 2))
    k = np.arange(blocks)
    matrix[k, :, k, :] = diagonal.transpose(2, 0, 1)
    matrix[k[1:], :, k[:-1], :] = below[..., 1:].transpose(2, 0, 1)
    matrix[k[:-1], :, k[1:], :] = below[..., 1:].transpose(2, 1, 0)
    flat = right.transpose(2, 0, 1).reshape(2 * blocks, -1)
    solution = np.linalg.solve(matrix.reshape(2 * blocks, 2 * blocks), flat)
    return np.asarray(solution.reshape(blocks, 2, -1).transpose(1, 2, 0))

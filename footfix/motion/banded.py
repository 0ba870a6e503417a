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
    diagonal = np.empty((blocks, 2, 2))
    diagonal[:, 0, 0], diagonal[:, 1, 1] = main[0::2], main[1::2]
    diagonal[:, 0, 1] = diagonal[:, 1, 0] = one[0::2]
    below = np.zeros((blocks, 2, 2))  # what ties each block to the one before it
    below[1:, 0, 0], below[1:, 0, 1], below[1:, 1, 1] = two[0:-2:2], one[1:-2:2], two[1:-2:2]
    padded = np.zeros((2 * blocks, right.shape[1]))
    padded[:frames] = right
    return _reduced(diagonal, below, padded.reshape(blocks, 2, -1)).reshape(2 * blocks, -1)[:frames]


def _reduced(diagonal: Floats, below: Floats, right: Floats) -> Floats:
    """The solution (B, 2, K) of a block tridiagonal system of B blocks; `below[k]` ties k to k - 1."""
    blocks = len(diagonal)
    if blocks <= _DENSE:
        return _dense(diagonal, below, right)
    # x of odd block k is P_k (b_k - L_k x_(k-1) - L_(k+1)^T x_(k+1)), P the inverse of its diagonal
    above = np.zeros_like(below)  # what ties each block to the one after it
    above[:-1] = below[1:].transpose(0, 2, 1)
    inverse = _inverse(diagonal[1::2])
    to_left, to_right, own = inverse @ below[1::2], inverse @ above[1::2], inverse @ right[1::2]
    odd, even = len(inverse), blocks - len(inverse)
    kept_diagonal, kept_right = diagonal[0::2].copy(), right[0::2].copy()
    kept_below = np.zeros((even, 2, 2))
    after, before = above[0::2][:odd], below[0::2][1:]  # from an even block to the odd one after, and before it
    kept_diagonal[:odd] -= after @ to_left
    kept_right[:odd] -= after @ own
    kept_diagonal[1:] -= before @ to_right[: even - 1]
    kept_right[1:] -= before @ own[: even - 1]
    kept_below[1:] = -before @ to_left[: even - 1]
    out = np.empty_like(right)
    out[0::2] = solved = _reduced(kept_diagonal, kept_below, kept_right)
    out[1::2] = own - to_left @ solved[:odd]
    out[1::2][: even - 1] -= to_right[: even - 1] @ solved[1:]
    return out


def _inverse(matrices: Floats) -> Floats:
    """The inverses of symmetric matrices (B, 2, 2)."""
    a, b, d = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
    out = np.empty_like(matrices)
    determinant = a * d - b * b
    out[:, 0, 0], out[:, 1, 1] = d / determinant, a / determinant
    out[:, 0, 1] = out[:, 1, 0] = -b / determinant
    return out


def _dense(diagonal: Floats, below: Floats, right: Floats) -> Floats:
    blocks = len(diagonal)
    matrix = np.zeros((blocks, 2, blocks, 2))
    k = np.arange(blocks)
    matrix[k, :, k, :] = diagonal
    matrix[k[1:], :, k[:-1], :] = below[1:]
    matrix[k[:-1], :, k[1:], :] = below[1:].transpose(0, 2, 1)
    solution = np.linalg.solve(matrix.reshape(2 * blocks, 2 * blocks), right.reshape(2 * blocks, -1))
    return np.asarray(solution.reshape(right.shape))

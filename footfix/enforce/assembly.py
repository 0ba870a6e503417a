"""Assembly of the linear system at a state: derivatives by points converted to unknowns, J' W J and J' f."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from footfix.enforce.leg import LEG, TIP, B, K, Q, W
from footfix.enforce.leg_state import LegState
from footfix.motion.clip import Floats, Ints
from footfix.motion.threads import at_once, halves

_CACHE = 2048  # frames times unknowns whose arrays fit the cache


@dataclass(frozen=True, eq=False)
class System:
    """Gradient and Gauss-Newton matrix of an objective at a state: block tridiagonal but for NEAR's second differences.

    Args:
        rows: (n,) which unknowns.
        gradient: (n, F).
        bands: (F, n (2 n + 1)) the blocks, in the memory in which the solver completes them (`blocks_of`).
        near: (3, n, F) the main diagonal, and the first and second one below it, in frames, of NEAR.
        cost: the objective there.
    """

    rows: Ints
    gradient: Floats
    bands: Floats
    near: Floats
    cost: float

    @property
    def blocks(self) -> Floats:
        """Get the second derivatives (F, n, 2 n) by each frame's unknowns (rows), and its own and its successor's."""
        return blocks_of(self.bands, len(self.rows))

    @property
    def main(self) -> Floats:
        """Get the blocks (F, n, n) of each frame with itself."""
        return self.blocks[:, :, : len(self.rows)]

    @property
    def next(self) -> Floats:
        """Get the blocks (F - 1, n, n) of each frame (rows) with its successor (columns)."""
        return self.blocks[:-1, :, len(self.rows) :]


def blocks_of(bands: Floats, n: int) -> Floats:
    """Get the blocks (F, n, 2 n) that begin in the memory of bands (F, n (2 n + 1)).

    LAPACK takes a symmetric banded matrix by columns, 2 n + 1 numbers of each from its diagonal down. So the columns of
    a frame, one after the other, are the rows of its blocks as they are, but for what is left of the diagonal.
    """
    return bands[:, : 2 * n * n].reshape(len(bands), n, 2 * n)


def product(bands: Floats, x: Floats) -> Floats:
    """Multiply NEAR's matrix (3, n, F) by a state, (n, F)."""
    out = bands[0] * x
    for k in (1, 2):
        out[:, k:] += bands[k, :, :-k] * x[:, :-k]
        out[:, :-k] += bands[k, :, :-k] * x[:, k:]
    return np.asarray(out)


@dataclass(frozen=True, eq=False)
class Pull:
    """Derivatives of a point's terms with respect to its place.

    Args:
        cost: of the point.
        force: (3, F) [1/m] gradient.
        stiff: (3, F) [1/m^2] second derivative in each frame.
        step: (3, F - 1) [1/m^2] minus the second derivative between each frame and the next.
    """

    cost: float
    force: Floats
    stiff: Floats
    step: Floats


@dataclass(frozen=True, eq=False)
class Pulled:
    """A leg in a state, and the derivatives of its points' terms.

    Args:
        at: the leg.
        pulls: of its P points.
        columns: the leg's eight unknowns in the system.
    """

    at: LegState
    pulls: Sequence[Pull]
    columns: slice


def assembled(legs: Sequence[Pulled], n: int) -> tuple[Floats, Floats]:
    """Convert derivatives by points of some legs to derivatives by n unknowns: J' f and J' W J.

    Args:
        legs: each in a state; of one system.
        n: how many unknowns it has: those of the root, if they are there, come first.

    Returns:
        Gradient (n, F) and bands (F, n (2 n + 1)), as of `System`.
    """
    force, stiff, step = (
        np.concatenate([getattr(pull, name) for leg in legs for pull in leg.pulls])
        for name in ("force", "stiff", "step")
    )  # (3 P, F), the last one frame shorter
    step = -np.pad(step, ((0, 0), (0, 1)))
    F = force.shape[1]
    gradient, bands = np.empty((n, F)), np.empty((F, n * (2 * n + 1)))
    blocks = blocks_of(bands, n)

    def some(part: slice) -> None:
        _assemble(legs, force, stiff, step, part, gradient, blocks)

    at_once([partial(some, part) for part in halves(F)], F)
    return gradient, bands


def _assemble(
    legs: Sequence[Pulled], force: Floats, stiff: Floats, step: Floats, part: slice, gradient: Floats, blocks: Floats
) -> None:
    """Assemble gradient and blocks of some frames into those of all."""
    n, F = gradient.shape
    some = max(1, _CACHE // n)
    J, right = _constant(legs, n, some + 1), np.zeros((some, len(force), 2, n))
    by_leg = [np.zeros((LEG, len(leg.pulls), 3, some + 1)) for leg in legs]
    for start in range(part.start, part.stop, some):  # in the same memory, so that it stays in the cache
        end = min(start + some, part.stop)
        frames, after = slice(start, end), slice(start, min(end + 1, F))
        count, row = end - start, 0
        for leg, own in zip(legs, by_leg, strict=True):
            moved = _of_leg(leg.at, after, own[..., : after.stop - start])  # (8, 3 P, f)
            J[: after.stop - start, row : row + len(moved[0]), leg.columns] = moved.transpose(2, 1, 0)
            row += len(moved[0])
        now, then = J[:count], J[1 : count + 1]  # after the clip's last frame there is none: its step counts as zero
        gradient[:, frames] = (force[:, frames].T[:, None] @ now)[:, 0].T
        np.multiply(stiff[:, frames].T[..., None], now, out=right[:count, :, 0])
        np.multiply(step[:, frames].T[..., None], then, out=right[:count, :, 1])
        np.matmul(now.swapaxes(1, 2), right[:count].reshape(count, -1, 2 * n), out=blocks[frames])


def _constant(legs: Sequence[Pulled], n: int, frames: int) -> Floats:
    """Make the part of the points' Jacobian that is constant, (f, 3 P, n): that of the root's shift."""
    points, first = sum(len(leg.pulls) for leg in legs), legs[0].columns.start
    out = np.zeros((frames, points, 3, n))
    out[..., :first] = np.eye(3)[:, :first]
    return out.reshape(frames, 3 * points, n)


def _of_leg(at: LegState, frames: slice, out: Floats) -> Floats:
    """Compute the Jacobian of a leg's points by its unknowns, (8, 3 P, f), into `out` (8, P, 3, f)."""
    ankle = at.ankle[..., frames]
    out[Q], out[K] = ankle[:, :3].swapaxes(0, 1)[:, None], ankle[:, 3]
    (a0, a1, a2), by_turn = at.turn[..., frames], out[W]
    for point, arm in enumerate(at.arms):
        if arm is not None:  # (turn dw) x arm
            b0, b1, b2 = arm[:, frames]
            for c, (u, v, s, t) in enumerate(((a1, b2, a2, b1), (a2, b0, a0, b2), (a0, b1, a1, b0))):
                np.subtract(u * v, s * t, out=by_turn[:, point, c])
    if at.hinge is not None:
        out[B, TIP] = at.hinge[:, frames]
    return out.reshape(LEG, -1, out.shape[-1])

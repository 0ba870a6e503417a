"""Assembly of the linear system at a state: derivatives by points converted to unknowns, J' W J and J' f."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.leg import LEG, TIP, B, K, Q, W
from footfix.enforce.leg_state import LegState
from footfix.motion.clip import Floats, Ints

_CACHE = 2048  # frames times unknowns whose arrays fit the cache


@dataclass(frozen=True, eq=False)
class System:
    """Gradient and Gauss-Newton matrix of an objective at a state: block tridiagonal but for NEAR's second differences.

    Args:
        rows: (n,) which unknowns.
        gradient: (n, F).
        blocks: (F, n, 2 n) second derivatives by each frame's unknowns (rows), and by its own and its successor's.
        near: (3, n, F) the main diagonal, and the first and second one below it, in frames, of NEAR.
        cost: the objective there.
    """

    rows: Ints
    gradient: Floats
    blocks: Floats
    near: Floats
    cost: float

    @property
    def main(self) -> Floats:
        """Get the blocks (F, n, n) of each frame with itself."""
        return self.blocks[:, :, : len(self.rows)]

    @property
    def next(self) -> Floats:
        """Get the blocks (F - 1, n, n) of each frame (rows) with its successor (columns)."""
        return self.blocks[:-1, :, len(self.rows) :]


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


def linearised(legs: Sequence[Pulled], n: int) -> tuple[Floats, Floats]:
    """Convert derivatives by points of some legs to derivatives by n unknowns: J' f and J' W J.

    Args:
        legs: each in a state; of one system.
        n: how many unknowns it has: those of the root, if they are there, come first.

    Returns:
        Gradient (n, F) and blocks (F, n, 2 n), as of `System`.
    """
    force, stiff, step = (
        np.concatenate([getattr(pull, name) for leg in legs for pull in leg.pulls])
        for name in ("force", "stiff", "step")
    )  # (3 P, F), the last one frame shorter
    step = -np.pad(step, ((0, 0), (0, 1)))
    F, some = force.shape[1], max(1, _CACHE // n)
    gradient, blocks = np.empty((n, F)), np.empty((F, n, 2 * n))
    J, right = _constant(legs, n, some + 1), np.zeros((some, len(force), 2, n))
    by_leg = [np.zeros((LEG, len(leg.pulls), 3, some + 1)) for leg in legs]
    for start in range(0, F, some):  # some frames at a time, in the same memory, so that it stays in the cache
        frames, after = slice(start, min(start + some, F)), slice(start, min(start + some + 1, F))
        count, row = frames.stop - start, 0
        for leg, own in zip(legs, by_leg, strict=True):
            moved = _of_leg(leg.at, after, own[..., : after.stop - start])  # (8, 3 P, f)
            J[: after.stop - start, row : row + len(moved[0]), leg.columns] = moved.transpose(2, 1, 0)
            row += len(moved[0])
        now, then = J[:count], J[1 : count + 1]  # after the clip's last frame there is none: its step counts as zero
        gradient[:, frames] = (force[:, frames].T[:, None] @ now)[:, 0].T
        np.multiply(stiff[:, frames].T[..., None], now, out=right[:count, :, 0])
        np.multiply(step[:, frames].T[..., None], then, out=right[:count, :, 1])
        np.matmul(now.swapaxes(1, 2), right[:count].reshape(count, -1, 2 * n), out=blocks[frames])
    return gradient, blocks


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

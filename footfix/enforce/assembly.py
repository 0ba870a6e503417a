"""The linear system at a state, and what pulls at a leg's points, carried over to the unknowns.

All points hang from one ankle on one foot: so their pulls are added up there first, by places and by turns of the
foot in the world, and carried to the unknowns once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.leg import ROOT, TIP, B
from footfix.enforce.posed import Posed, cross
from footfix.motion.clip import Floats, Ints

_QK, _W = slice(0, 4), slice(4, 7)  # of a leg's unknowns: what moves the ankle, and what turns the foot


@dataclass(frozen=True, eq=False)
class System:
    """Gradient and Gauss-Newton matrix of an objective at a state: block tridiagonal but for NEAR's second differences.

    Args:
        rows: (n,) which unknowns.
        gradient: (n, F).
        main: (n, n, F) blocks of each frame with itself; what is above their diagonal is left out.
        next: (n, n, F - 1) blocks of each frame's successor (rows) with it (columns).
        near: (3, n, F) the main diagonal, and the first and second one below it, in frames, of NEAR.
        cost: the objective there.
    """

    rows: Ints
    gradient: Floats
    main: Floats
    next: Floats
    near: Floats
    cost: float


def product(bands: Floats, x: Floats) -> Floats:
    """Multiply NEAR's matrix (3, n, F) by a state, (n, F)."""
    out = bands[0] * x
    for k in (1, 2):
        out[:, k:] += bands[k, :, :-k] * x[:, :-k]
        out[:, :-k] += bands[k, :, :-k] * x[:, k:]
    return np.asarray(out)


@dataclass(frozen=True, eq=False)
class Pull:
    """What a point's terms ask of it, as derivatives by its place.

    Args:
        cost: of the point.
        force: (3, F) [1/m] gradient.
        stiff: (3, F) [1/m^2] second derivatives in each frame.
        step: (3, F - 1) [1/m^2] and between each frame and the next, with the sign turned round.
    """

    cost: float
    force: Floats
    stiff: Floats
    step: Floats


@dataclass(frozen=True, eq=False)
class _Block:
    """A symmetric or one-sided second derivative by the ankle's place a, the foot's turn t, and the toes' bend b.

    Args:
        aa: (3, n) its diagonal; places along different axes have nothing to do with each other.
        at, ta, tt: (3, 3, n).
        ab, ba, tb, bt: (3, n).
        bb: (n,).
    """

    aa: Floats
    at: Floats
    ta: Floats
    tt: Floats
    ab: Floats
    ba: Floats
    tb: Floats
    bt: Floats
    bb: Floats


def add_points(at: Posed, pulls: Sequence[Pull], gradient: Floats, main: Floats, next_: Floats, *, root: bool) -> None:
    """Add what pulls at a leg's points to its gradient (n, F), and its blocks (n, n, F) and (n, n, F - 1).

    Args:
        at: the leg in a state.
        pulls: of its points.
        gradient: by the root's three unknowns, if it has them, and the leg's eight.
        main: each frame with itself; the lower triangles.
        next_: each frame's successor (rows) with it (columns).
        root: whether the root's unknowns are there.
    """
    first = ROOT if root else 0
    _add_forces(at, pulls, gradient, first)
    now = slice(None)
    block = _block(at, [pull.stiff for pull in pulls], now, now)
    _carry(main, block, at, now, now, first, 1.0)
    later, before = slice(1, None), slice(None, -1)
    block = _block(at, [pull.step for pull in pulls], later, before)
    _carry(next_, block, at, later, before, first, -1.0)


def _add_forces(at: Posed, pulls: Sequence[Pull], gradient: Floats, first: int) -> None:
    force, torque = np.zeros_like(at.places[0]), np.zeros_like(at.places[0])
    for arm, pull in zip(at.arms, pulls, strict=True):
        force += pull.force
        if arm is not None:
            torque += cross(arm, pull.force)
    leg = gradient[first:]
    if first:
        gradient[:first] += force
    leg[_QK] += np.einsum("cif,cf->if", at.ankle, force)
    leg[_W] += np.einsum("cif,cf->if", at.turn, torque)
    if at.hinge is not None:
        leg[B] += np.einsum("cf,cf->f", at.hinge, pulls[TIP].force)


def _lever(arm: Floats) -> Floats:
    """(3, 3, F) how a point moves while the foot turns about the ankle: turn x arm."""
    out = np.zeros((3, 3, arm.shape[1]))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i, j], out[j, i] = arm[k], -arm[k]
    return out


def _block(at: Posed, weights: Sequence[Floats], rows: slice, columns: slice) -> _Block:
    """Add up the points' second derivatives (3, n), between some frames (rows) and others (columns)."""
    n = weights[0].shape[1]
    aa = np.sum(weights, axis=0)
    a_t, ta, tt = (np.zeros((3, 3, n)) for _ in range(3))
    ab, ba, tb, bt = (np.zeros((3, n)) for _ in range(4))
    bb = np.zeros(n)
    same = rows == columns
    for point, (arm, weight) in enumerate(zip(at.arms, weights, strict=True)):
        if arm is None or not np.any(weight):
            continue
        right = _lever(arm[:, columns])
        left = right if same else _lever(arm[:, rows])
        weighted = weight[:, None] * right
        a_t += weighted
        ta += weighted.swapaxes(0, 1) if same else (weight[:, None] * left).swapaxes(0, 1)
        tt += np.einsum("cif,cjf->ijf", left, weighted)
        if point == TIP and at.hinge is not None:
            before, behind = weight * at.hinge[:, columns], weight * at.hinge[:, rows]
            ab += before
            ba += behind
            tb += np.einsum("cif,cf->if", left, before)
            bt += np.einsum("cif,cf->if", right, behind)
            bb += np.einsum("cf,cf->f", at.hinge[:, rows], before)
    return _Block(aa, a_t, ta, tt, ab, ba, tb, bt, bb)


def _carry(out: Floats, block: _Block, at: Posed, rows: slice, columns: slice, first: int, sign: float) -> None:
    """Add a block, times a sign, to one by the unknowns (n, n, F): derivatives on both of its sides."""
    A, J = sign * at.ankle[..., rows], sign * at.turn[..., rows]  # of the rows
    a, j = at.ankle[..., columns], at.turn[..., columns]  # of the columns
    leg = out[first:, first:]
    square = rows == columns  # then only what is below the diagonal counts
    leg[_QK, _QK] += np.einsum("cif,cjf->ijf", A, block.aa[:, None] * a)
    leg[_W, _QK] += np.einsum("tif,tjf->ijf", J, np.einsum("tcf,cjf->tjf", block.ta, a))
    leg[_W, _W] += np.einsum("tif,tjf->ijf", J, np.einsum("tuf,ujf->tjf", block.tt, j))
    if at.hinge is not None:
        leg[B, _QK] += sign * np.einsum("cf,cjf->jf", block.ba, a)
        leg[B, _W] += sign * np.einsum("tf,tjf->jf", block.bt, j)
        leg[B, B] += sign * block.bb
    if not square:
        leg[_QK, _W] += np.einsum("cif,cjf->ijf", A, np.einsum("ctf,tjf->cjf", block.at, j))
        if at.hinge is not None:
            leg[_QK, B] += np.einsum("cif,cf->if", A, block.ab)
            leg[_W, B] += np.einsum("tif,tf->if", J, block.tb)
    if first:
        d = np.arange(ROOT)
        out[d, d] += sign * block.aa
        below = out[first:, :first]
        below[_QK] += (A * block.aa[:, None]).swapaxes(0, 1)
        below[_W] += np.einsum("tif,tcf->icf", J, block.ta)
        below[B] += sign * block.ba
        if not square:
            beside = out[:first, first:]
            beside[:, _QK] += sign * block.aa[:, None] * a
            beside[:, _W] += sign * np.einsum("ctf,tjf->cjf", block.at, j)
            beside[:, B] += sign * block.ab

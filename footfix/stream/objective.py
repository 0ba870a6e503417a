"""The objective of `enforce.terms` for all legs and points of a short window together.

Terms and derivatives are the same as for a whole clip, but arranged for few frames: there arrays are long, and each
leg, point and bound is computed separately; here they are short, so that time depends on the number of operations.

Arrays have components first, then points, legs and frames: (3, P, L, F).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.enforce.assembly import product
from footfix.enforce.costs import FLOOR, KNEE, LIFTED, PLACE, RATE, RISE, SPEED, STATIC, UPRIGHT
from footfix.enforce.leg import LEG, POINTS, ROOT, TIP, TOE, B, K, Q, W
from footfix.enforce.problem import Problem
from footfix.enforce.terms import near, root_bound, smooth, sticks
from footfix.motion.clip import Floats
from footfix.stream.legs import Legs, LegStates, own_of, states_of
from footfix.stream.pins import Stacked


@dataclass(frozen=True, eq=False)
class Normal:
    """Gradient (U, F) and Gauss-Newton matrix of the objective, but NEAR's second differences apart.

    Args:
        gradient: (F, U).
        main: (F, U, U) blocks of each frame with itself.
        next: (F - 1, U, U) of each frame's successor (rows) with it (columns).
        near: (3, U, F) as of `enforce.assembly.System`.
    """

    gradient: Floats
    main: Floats
    next: Floats
    near: Floats


def normal(
    problem: Problem, legs: Legs, pins: Stacked, x: Floats, eps: float, static: float, bands: Floats | None = None,
    at: LegStates | None = None,
) -> Normal:  # fmt: skip
    """Linearise the objective of a window at a state (U, F); see `enforce.objective.systems`.

    Args:
        problem: the window's.
        legs, pins: its, stacked.
        x: (U, F) a state.
        eps: [m] of slip below which SLIP is a parabola.
        static: static over kinetic friction.
        bands: (3, U, F) of NEAR, where they are known.
        at: the legs' points in that state, where they are known.
    """
    F, L = x.shape[1], legs.flexion.shape[0]
    own = own_of(x)  # (8, L, F)
    at = states_of(legs, x[:ROOT], own) if at is None else at
    force, stiff, step = _pull(problem, pins, at.places, eps, static)
    J = at.jacobian  # (L, F, 12, 11)
    by_place = force.transpose(2, 3, 0, 1).reshape(L, F, -1, 1)
    gradient = (J.swapaxes(2, 3) @ by_place)[..., 0]  # (L, F, 11)
    main = J.swapaxes(2, 3) @ (stiff.transpose(2, 3, 0, 1).reshape(L, F, -1, 1) * J)
    steps = step.transpose(2, 3, 0, 1).reshape(L, F - 1, -1, 1)
    next_ = -(J[:, 1:].swapaxes(2, 3) @ (steps * J[:, :-1]))
    _rises(problem, pins, at, gradient, main)
    _knees(problem, legs, own, gradient, main)
    _fast(problem, legs, own, gradient, main, next_)
    _far(problem, own, gradient, main)
    return _together(problem, x, gradient, main, next_, bands)


def _together(
    problem: Problem, x: Floats, gradient: Floats, main: Floats, next_: Floats, bands: Floats | None
) -> Normal:
    """Combine the legs' systems into one, with the root's own terms and NEAR."""
    U, F = x.shape
    whole, blocks, nexts = np.zeros((F, U)), np.zeros((F, U, U)), np.zeros((F - 1, U, U))
    whole[:, :ROOT] = gradient[..., :ROOT].sum(axis=0)
    blocks[:, :ROOT, :ROOT] = main[..., :ROOT, :ROOT].sum(axis=0)
    nexts[:, :ROOT, :ROOT] = next_[..., :ROOT, :ROOT].sum(axis=0)
    for k in range(len(gradient)):
        rows = problem.columns(k)
        whole[:, rows] = gradient[k, :, ROOT:]
        for out, each in ((blocks, main[k]), (nexts, next_[k])):
            out[:, rows, rows] = each[:, ROOT:, ROOT:]
            out[:, rows, :ROOT] = each[:, ROOT:, :ROOT]
            out[:, :ROOT, rows] = each[:, :ROOT, ROOT:]
    far, sigma = root_bound(problem)
    weight = RATE * problem.frame_time / sigma**2
    pull, bend = _beyond(x[:ROOT], far, weight)
    if pull is not None and bend is not None:
        whole[:, :ROOT] += pull.T
        blocks[:, :ROOT, :ROOT] += bend.transpose(2, 0, 1)
    if bands is None:
        bands, _ = near(problem, x, np.arange(U))
    return Normal(whole + product(bands, x).T, blocks, nexts, bands)


def _pull(problem: Problem, pin: Stacked, place: Floats, eps: float, static: float) -> tuple[Floats, Floats, Floats]:
    """SLIP, LEVEL, FLOOR and PLACE: gradient and second derivatives by place (3, P, L, F), and between frames."""
    size, per_frame = problem.leg_length, RATE * problem.frame_time
    slip = place[..., 1:] - place[..., :-1] - pin.slip
    flat = slip[0] ** 2 + slip[2] ** 2
    long = np.sqrt(flat + (UPRIGHT * slip[1]) ** 2)
    c = problem.costs.slide / size * pin.hold
    step = c / (long + eps) * np.array([1.0, UPRIGHT**2, 1.0]).reshape(3, 1, 1, 1)
    if static > 1.0:
        flat, still = np.sqrt(flat), STATIC * size * problem.frame_time
        step[::2] += c * (static - 1.0) * sticks(smooth(flat, eps) / still) / (flat + eps)
    asked = per_frame / (PLACE * size) ** 2 * pin.placed
    stiff = np.repeat(asked[None], 3, axis=0)
    force = asked * (place - pin.place)
    pulled = step * slip
    force[..., 1:] += pulled
    force[..., :-1] -= pulled
    stiff[..., 1:] += step
    stiff[..., :-1] += step
    off, low, straight = place[1] - pin.level, np.maximum(pin.lowest - place[1], 0.0), LIFTED * size
    level = per_frame / (problem.costs.level * size) ** 2 * pin.draw * (straight / np.maximum(off, straight))
    floor = per_frame / (FLOOR * size) ** 2
    force[1] += level * off - floor * low
    stiff[1] += level + floor * (low > 0.0)
    return force, stiff, step


def _rises(problem: Problem, pins: Stacked, at: LegStates, gradient: Floats, main: Floats) -> None:
    """RISE: no tip is high over its toe joint."""
    over = at.places[1, TIP] - at.places[1, TOE] - pins.rise
    if not np.any(over > 0.0):
        return
    weight = RATE * problem.frame_time / (RISE * problem.leg_length) ** 2
    upwards = len(POINTS)  # the first row of heights
    row = at.jacobian[..., upwards + TIP, :] - at.jacobian[..., upwards + TOE, :]  # (L, F, 11)
    bent = weight * (over > 0.0)[..., None] * row
    gradient += np.maximum(over, 0.0)[..., None] * bent
    main += bent[..., :, None] * row[..., None, :]


def _knees(problem: Problem, legs: Legs, x: Floats, gradient: Floats, main: Floats) -> None:
    """KNEE: no knee is straighter than the figure's own."""
    weight = RATE * problem.frame_time / np.radians(KNEE) ** 2
    lacks = np.maximum(legs.least - legs.flexion - x[K], 0.0)
    if not lacks.any():
        return
    gradient[..., ROOT + K] -= weight * lacks
    main[..., ROOT + K, ROOT + K] += weight * (lacks > 0.0)


def _far(problem: Problem, x: Floats, gradient: Floats, main: Floats) -> None:
    """FAR of line, knee, ankle and toes."""
    foot = x[W] - x[Q]
    squares, lengths = x * x, np.empty((4, *x.shape[1:]))
    np.add.reduce(squares[Q], axis=0, out=lengths[0])
    np.add.reduce(foot * foot, axis=0, out=lengths[2])
    lengths[1], lengths[3] = squares[K], squares[B]
    bounds = np.stack(problem.farthest)
    if not np.any(lengths > (bounds**2)[:, None]):
        return
    kinds = (
        (x[Q], ((Q, 1.0),)),
        (x[K : K + 1], ((slice(K, K + 1), 1.0),)),
        (foot, ((W, 1.0), (Q, -1.0))),
        (x[B : B + 1], ((slice(B, B + 1), 1.0),)),
    )
    weight = RATE * problem.frame_time / problem.beyond**2
    for (turn, parts), bound in zip(kinds, bounds, strict=True):
        pull, bend = _beyond(turn, bound, weight)
        if pull is None or bend is None:
            continue
        pull, bend = pull.transpose(1, 2, 0), bend.transpose(2, 3, 0, 1)
        for rows, share in parts:
            at = slice(ROOT + rows.start, ROOT + rows.stop)
            gradient[..., at] += share * pull
            for columns, other in parts:
                main[..., at, ROOT + columns.start : ROOT + columns.stop] += share * other * bend


def _beyond(turn: Floats, far: Floats, weight: Floats) -> tuple[Floats | None, Floats | None]:
    """Compute the one-sided cost of turns (m, ..., F) beyond `far` (F,): gradient, second derivatives (m, m, ..., F).
    """
    size = np.sqrt(np.sum(turn**2, axis=0))
    over = size > far
    if not over.any():
        return None, None
    long = np.where(over, size, 1.0)
    along, beyond = turn / long, np.where(over, size - far, 0.0)
    aside = beyond / long
    bend = (over - aside) * along[:, None] * along[None]
    for i in range(len(turn)):
        bend[i, i] += aside
    return weight * beyond * along, weight * bend


def _fast(problem: Problem, legs: Legs, x: Floats, gradient: Floats, main: Floats, next_: Floats) -> None:
    """SPEED of hip, knee and ankle."""
    most, sigma = np.radians(problem.costs.speed) * problem.frame_time, np.radians(SPEED)
    half = 0.5 * legs.axis
    bent = half * x[K]
    turns = np.empty((7, *bent.shape[1:]))
    np.subtract(x[Q], bent, out=turns[:3])
    np.subtract(x[W] - x[Q], bent, out=turns[3:6])
    turns[6] = x[K]
    steps = turns[..., 1:] - turns[..., :-1]
    squares = steps * steps
    sizes = np.empty((3, *steps.shape[1:]))
    np.add.reduce(squares[:3], axis=0, out=sizes[0])
    np.add.reduce(squares[3:6], axis=0, out=sizes[2])
    sizes[1] = squares[6]
    if not np.any(sizes > most * most):
        return
    sizes = np.sqrt(sizes)
    kinds = (
        (steps[:3], half, ((Q, 1.0),)),
        (steps[6:], None, ((slice(K, K + 1), 1.0),)),
        (steps[3:6], half, ((W, 1.0), (Q, -1.0))),
    )
    for (step, axis, parts), size in zip(kinds, sizes, strict=True):
        over = size > most
        if not over.any():
            continue
        along = np.where(over, step / np.where(over, size, 1.0), 0.0) / sigma  # (m, L, F - 1)
        beyond = np.where(over, size - most, 0.0) / sigma
        ends = []
        for at in (slice(None, -1), slice(1, None)):
            by = np.zeros((LEG, *beyond.shape))
            for rows, share in parts:
                by[rows] += share * along
            if axis is not None:
                by[K] -= np.sum(along * axis[..., at], axis=0)
            ends.append(by.transpose(1, 2, 0))  # (L, F - 1, 8)
        before, after = ends
        gradient[:, :-1, ROOT:] -= beyond[..., None] * before
        gradient[:, 1:, ROOT:] += beyond[..., None] * after
        main[:, :-1, ROOT:, ROOT:] += before[..., :, None] * before[..., None, :]
        main[:, 1:, ROOT:, ROOT:] += after[..., :, None] * after[..., None, :]
        next_[..., ROOT:, ROOT:] -= after[..., :, None] * before[..., None, :]

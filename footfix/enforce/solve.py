"""Gauss-Newton with reweighting on the block-banded normal matrix: the objective's minimum over a whole clip."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from footfix.enforce.assembly import System, blocks_of
from footfix.enforce.costs import RATE
from footfix.enforce.leg import ROOT
from footfix.enforce.leg_state import LegState, places_of
from footfix.enforce.objective import linearised, objective, posture
from footfix.enforce.pins import Pins
from footfix.enforce.problem import Problem
from footfix.motion.banded import solve_banded
from footfix.motion.clip import Bools, Floats, Ints
from footfix.motion.spline import spline
from footfix.motion.threads import at_once

EPS = 2e-4  # [m/s] of slip at which a pinned point counts as standing
_EPS_FIRST = 0.06  # [m/s] the same in the first round
_SHRINK = 0.35  # factor by which it shrinks from round to round
_COARSE, _MIDDLE = 30.0, 60.0  # [Hz] frame rates at which the root is solved for: many rounds, then one
_FIRST_ROUNDS, _ROUNDS, _FINE_ROUNDS = 4, 3, 3  # on every other coarse frame, on each, on all before the last rounds
_ALONE_ROUNDS = 10  # rounds where the clip's own frame rate is no higher than the coarse one
_FINE_FIRST = 40.0  # slip threshold in the first of the finer rounds, as a multiple of `EPS`
STATIC, _LAST = 8.0, 3  # static over kinetic friction, and in how many final rounds
_STANDS, _SETTLED = 0.03, 0.3  # [leg lengths/s] a plant is held if it slips less than this in this share of its frames
_HALVINGS = 3  # most halvings of a step that would raise the objective
_BLOCK = 256  # frames handled at a time, so that they stay in the cache
DAMPING = 1.0  # damping of each step, as a multiple of NEAR's weight


def solve(problem: Problem) -> Floats:
    """Find the state (U, F) with the least objective: first on few frames a second, then on more, then on all.

    The root's correction changes slowly: it is solved for on the coarse frames, together with the legs. On all frames
    it is fixed, and each leg is solved for by itself.
    """
    coarse, first = _every(problem, _COARSE), _FINE_FIRST * EPS
    if problem.frames <= 8 * coarse or coarse == 1:
        x = np.zeros((problem.unknowns, problem.frames))
        return descend(problem, x, _ALONE_ROUNDS + _LAST, first=_EPS_FIRST, last=_LAST)
    x, at = np.zeros((problem.unknowns, 2)), np.array([0, problem.frames - 1])
    for every, rounds, eps in (
        (2 * coarse, _FIRST_ROUNDS, _EPS_FIRST),
        (coarse, _ROUNDS, _SHRINK**_FIRST_ROUNDS * _EPS_FIRST),
        (_every(problem, _MIDDLE), 1, first),
    ):
        which = np.arange(0, problem.frames, every)
        x, at = descend(thinned(problem, which), interpolated(x, at, which), rounds, first=eps), which
    x = interpolated(x, at, np.arange(problem.frames))
    alone = partial(descend, problem, x, _FINE_ROUNDS + _LAST, first=_SHRINK * first, last=_LAST)
    legs = range(len(problem.legs))
    found = at_once([partial(alone, leg=k) for k in legs], problem.frames)
    return np.concatenate([x[:ROOT], *(each[problem.columns(k)] for k, each in zip(legs, found, strict=True))])


def _every(problem: Problem, rate: float) -> int:
    """Compute how many frames apart samples at a rate [Hz] are."""
    return max(1, round(1.0 / problem.frame_time / rate))


def interpolated(x: Floats, at: Ints, wanted: Ints) -> Floats:
    """Interpolate a state (U, n) on some frames by natural cubic splines; what lies beyond keeps the last."""
    found = spline(at.astype(np.float64), x.T)(np.minimum(wanted, at[-1]).astype(np.float64))
    return np.ascontiguousarray(found.T)


def thinned(problem: Problem, which: Ints) -> Problem:
    """Thin the problem to some frames; a pin's slip is then that from each kept frame to the next."""
    every = int(which[1] - which[0])
    if every == 1:
        return problem

    def thin(pin: Pins) -> Pins:
        moved = np.concatenate([np.zeros((3, 1)), np.cumsum(pin.slip, axis=1)], axis=1)[:, which]
        hold = np.stack([pin.hold[k : k + len(which) * every - every : every][: len(which) - 1] for k in range(every)])
        return Pins(
            hold.min(axis=0), np.diff(moved, axis=1), pin.stands[which], pin.level[which], pin.draw[which],
            pin.lowest[which], pin.place[:, which], pin.placed[which],
            rise=None if pin.rise is None else pin.rise[which],
        )  # fmt: skip

    return replace(
        problem, legs=tuple(leg.frames(which) for leg in problem.legs),
        pins=tuple(tuple(thin(pin) for pin in each) for each in problem.pins), frame_time=problem.frame_time * every,
        fault=problem.fault[which], skins={k: own.frames(which) for k, own in problem.skins.items()},
    )  # fmt: skip


def descend(
    problem: Problem, x: Floats, rounds: int, *, first: float, last: int = 0, leg: int | None = None,
    fixed: Bools | None = None,
) -> Floats:  # fmt: skip
    """Take some rounds of Gauss-Newton from a state.

    Args:
        problem: the clip's.
        x: (U, F) where to begin.
        rounds: how many.
        first: [m/s] slip below which SLIP is a parabola in the first round; it shrinks to `EPS`.
        last: how many of the rounds are with static friction, which is more than that of a sliding foot.
        leg: the only leg that is an unknown, if it is; else all are, and the root.
        fixed: (F,) frames whose state is fixed, such as a stream's past.
    """
    eps, at = first, posture(problem, x, leg)
    for n in range(rounds):
        static = STATIC if n >= rounds - last else 1.0
        if last and n == rounds - last:
            problem = settled(problem, x, leg)
        x, at = _descended(problem, x, at, max(eps, EPS) * problem.frame_time, static, leg, fixed)
        eps *= _SHRINK
    return x


def _descended(
    problem: Problem, x: Floats, at: Sequence[LegState], eps: float, static: float, leg: int | None,
    fixed: Bools | None,
) -> tuple[Floats, list[LegState]]:  # fmt: skip
    """Take one round from a state, in which the legs are `at`; return the new state, and the legs in it."""
    system = linearised(problem, x, eps, static=static, leg=leg, at=at)
    step = _step(problem, system, fixed)
    for _ in range(_HALVINGS):  # one-sided terms may become active along the step
        then = posture(problem, x + step, leg)
        if objective(problem, x + step, eps, static=static, leg=leg, at=then) <= system.cost:
            return x + step, then
        step = 0.5 * step
    return x + step, posture(problem, x + step, leg)


def settled(problem: Problem, x: Floats, leg: int | None = None) -> Problem:
    """Release plants, of one leg or all, that slide in most of their frames: static friction holds those that stand."""
    most = _STANDS * problem.leg_length * problem.frame_time
    pins = list(problem.pins)
    for k in problem.unknown_legs(leg):
        places = places_of(problem.legs[k], x[:ROOT], x[problem.columns(k)])
        left = []
        for place, pin in zip(places, problem.pins[k], strict=True):
            slip = np.diff(place, axis=1) - pin.slip
            still = np.hypot(slip[0], slip[2]) <= most
            left.append(pin.let_slide([s for s in pin.spans if still[s[0] : s[1] - 1].mean() < _SETTLED]))
        pins[k] = tuple(left)
    return problem.with_pins(pins)


def _step(problem: Problem, system: System, fixed: Bools | None) -> Floats:
    """Compute the step (U, F) to where a system has its minimum, damped; it uses up the system."""
    own = np.flatnonzero(problem.free()[system.rows])
    step = np.zeros((problem.unknowns, problem.frames))
    if len(own):
        rows = system.rows[own]
        columns = _columns(system, own, DAMPING * RATE * problem.frame_time / problem.near()[0][rows] ** 2)
        right = -system.gradient[own].T
        if fixed is not None:
            _hold(columns, right, fixed)
        found = solve_banded(columns.reshape(-1, columns.shape[-1]), right.ravel())
        step[rows] = found.reshape(right.shape).T
    return step


def _columns(system: System, own: Ints, damping: Floats) -> Floats:
    """Complete the lower triangle of the matrix of a system's free unknowns, column by column, (F, n, 2 n + 1).

    Below the diagonal of a frame's own block there is the block with its successor, and then NEAR's last diagonal.
    """
    U, F = len(own), system.gradient.shape[1]
    bands, blocks, near = system.bands, system.blocks, system.near
    if len(system.rows) > U:
        bands, near = np.empty((F, U * (2 * U + 1))), near[:, own]
        blocks_of(bands, U)[...] = blocks[:, own][:, :, np.concatenate([own, len(system.rows) + own])]
        blocks = blocks_of(bands, U)
    columns = bands.reshape(F, U, 2 * U + 1)
    for start in range(0, F, _BLOCK):  # some frames at a time, so that they stay in the cache
        some = slice(start, start + _BLOCK)
        bands[some, 2 * U * U :] = 0.0
        for row in range(1, U):
            blocks[some, row, :row] = 0.0  # left of the diagonal
        columns[some, :, 0] += near[0, :, some].T + damping
        columns[some, :, U] += near[1, :, some].T
        columns[some, :, 2 * U] = near[2, :, some].T
    return columns


def _hold(bands: Floats, right: Floats, fixed: Bools) -> None:
    """Remove the frames with a fixed state from a system."""
    F, U, width = bands.shape
    row = np.arange(F * U)[:, None] + np.arange(width)[None]
    of = np.minimum(row // U, F - 1)
    gone = fixed[:, None].repeat(U, 1).reshape(-1, 1) | fixed[of]
    flat = bands.reshape(F * U, width)
    flat[gone] = 0.0
    flat[fixed.repeat(U), 0] = 1.0
    right[fixed] = 0.0

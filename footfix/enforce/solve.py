"""Gauss-Newton with reweighting on the block-banded normal matrix: the objective's minimum over a whole clip."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footfix.enforce.leg import ROOT, posed
from footfix.enforce.pins import Pins
from footfix.enforce.problem import Problem, System, objective, system
from footfix.motion.clip import Bools, Floats, Ints

EPS = 2e-4  # [m/s] of slip at which a pinned point counts as standing
_EPS_FIRST = 0.06  # [m/s] in the first round
_SHRINK = 0.35  # of it from round to round
_COARSE = 30.0  # [Hz] of the first pass
_ROUNDS, _FINE_ROUNDS = 10, 8
_FINE_FIRST = 40.0  # times `EPS` in the first of the fine rounds
_STATIC, _LAST = 8.0, 3  # times as much as kinetic friction static friction is, in so many last rounds
_STANDS, _SETTLED = 0.03, 0.3  # [leg lengths/s] of slip that stands, in this share of a plant's frames at least
_HALVINGS = 3  # of a step that would raise the objective
_DAMPING = 1.0  # of NEAR's own weight, on each step


def solve(problem: Problem) -> Floats:
    """Find the state (U, F) with the least objective: first on every third or fourth frame, then on all."""
    every = max(1, round(1.0 / problem.frame_time / _COARSE))
    if every == 1 or problem.frames <= 8 * every:
        return descend(problem, np.zeros((problem.unknowns, problem.frames)), _ROUNDS + _LAST, first=_EPS_FIRST, last=_LAST)
    which = np.arange(0, problem.frames, every)
    rough = descend(thinned(problem, which), np.zeros((problem.unknowns, len(which))), _ROUNDS, first=_EPS_FIRST)
    from scipy.interpolate import CubicSpline

    x = CubicSpline(which, rough, axis=1)(np.minimum(np.arange(problem.frames), which[-1]))
    return descend(problem, x, _FINE_ROUNDS, first=_FINE_FIRST * EPS, last=_LAST)


def thinned(problem: Problem, which: Ints) -> Problem:
    """The problem on some frames only: pins hold from each to the next of them."""
    every = int(which[1] - which[0])

    def thin(pin: Pins) -> Pins:
        moved = np.concatenate([np.zeros((3, 1)), np.cumsum(pin.slip, axis=1)], axis=1)[:, which]
        hold = np.stack([pin.hold[k : k + len(which) * every - every : every][: len(which) - 1] for k in range(every)])
        return Pins(
            hold.min(axis=0), np.diff(moved, axis=1), pin.stands[which], pin.level[which], pin.draw[which],
            pin.lowest[which], pin.place[:, which], pin.placed[which],
        )  # fmt: skip

    return replace(
        problem, legs=tuple(leg.frames(which) for leg in problem.legs),
        pins=tuple(tuple(thin(pin) for pin in each) for each in problem.pins), frame_time=problem.frame_time * every,
    )  # fmt: skip


def descend(problem: Problem, x: Floats, rounds: int, *, first: float, last: int = 0, fixed: Bools | None = None) -> Floats:
    """Take some rounds of Gauss-Newton from a state.

    Args:
        problem: the clip's.
        x: (U, F) where to begin.
        rounds: how many.
        first: [m/s] slip below which SLIP is a parabola in the first round; it shrinks to `EPS`.
        last: how many of the rounds are with static friction, which is more than that of a sliding foot.
        fixed: (F,) frames that keep their state, as a stream's past does.
    """
    eps = first
    free = problem.free()
    for n in range(rounds):
        here = max(eps, EPS) * problem.frame_time
        static = _STATIC if n >= rounds - last else 1.0
        if last and n == rounds - last:
            problem = settled(problem, x)
        found = system(problem, x, here, static)
        step = _step(problem, found, free, fixed)
        for _ in range(_HALVINGS if static == 1.0 else 0):  # one-sided terms may come in along the way
            if objective(problem, x + step, here) <= found.cost:
                break
            step = 0.5 * step
        x = x + step
        eps *= _SHRINK
    return x


def settled(problem: Problem, x: Floats) -> Problem:
    """Let go of what slides in most of its frames: static friction holds what stands, and nothing else."""
    most = _STANDS * problem.leg_length * problem.frame_time
    pins = []
    for k, (leg, own) in enumerate(zip(problem.legs, problem.pins, strict=True)):
        places = posed(leg, x[:ROOT], x[problem.columns(k)], derive=False).places
        left = []
        for place, pin in zip(places, own, strict=True):
            slip = np.diff(place, axis=1) - pin.slip
            still = np.hypot(slip[0], slip[2]) <= most
            left.append(pin.let_slide([s for s in pin.spans if still[s[0] : s[1] - 1].mean() < _SETTLED]))
        pins.append(tuple(left))
    return replace(problem, pins=tuple(pins))


def _step(problem: Problem, found: System, free: Bools, fixed: Bools | None) -> Floats:
    """(U, F) the Gauss-Newton step, by a banded Cholesky decomposition."""
    from scipy.linalg import solveh_banded

    rows = np.flatnonzero(free)
    U, F = len(rows), problem.frames
    s0, _ = problem.near()
    near = found.near[:, rows]
    stay = _DAMPING * 60.0 * problem.frame_time / s0[rows] ** 2
    bands = np.zeros((F, U, 2 * U + 1))  # of the lower triangle, column by column
    main, next_ = found.main[np.ix_(rows, rows)], found.next[np.ix_(rows, rows)]
    for b in range(U):
        for a in range(b, U):
            bands[:, b, a - b] = main[a, b]
        for a in range(U):
            bands[: F - 1, b, U + a - b] = next_[a, b]
    bands[..., 0] += near[0].T + stay
    bands[..., U] += near[1].T
    bands[..., 2 * U] += near[2].T
    right = -found.gradient[rows].T
    if fixed is not None:
        _hold(bands, right, fixed)
    ab = bands.reshape(F * U, 2 * U + 1).T
    solved = solveh_banded(ab, right.ravel(), lower=True, overwrite_ab=True, check_finite=False)
    step = np.zeros(found.gradient.shape)
    step[rows] = solved.reshape(F, U).T
    return step


def _hold(bands: Floats, right: Floats, fixed: Bools) -> None:
    """Take the frames that keep their state out of a system."""
    F, U, width = bands.shape
    row = np.arange(F * U)[:, None] + np.arange(width)[None]
    of = np.minimum(row // U, F - 1)
    gone = fixed[:, None].repeat(U, 1).reshape(-1, 1) | fixed[of]
    flat = bands.reshape(F * U, width)
    flat[gone] = 0.0
    flat[fixed.repeat(U), 0] = 1.0
    right[fixed] = 0.0

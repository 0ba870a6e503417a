"""The objective of a clip, linearised at a state: the terms of all its points, joints and unknowns put together."""

from __future__ import annotations

import numpy as np

from footfix.enforce.assembly import System, add_points, product
from footfix.enforce.leg import ANKLE, LEG, ROOT
from footfix.enforce.posed import places_of, posed
from footfix.enforce.problem import Problem
from footfix.enforce.terms import joint_terms, near, point_terms, root_term
from footfix.enforce.vertices import add_floor, floor_cost, floor_weight
from footfix.motion.clip import Floats


def systems(problem: Problem, x: Floats, eps: float, *, static: float = 1.0, root: bool = True) -> tuple[System, ...]:
    """Linearise the objective.

    Args:
        problem: the clip's.
        x: (U, F) a state.
        eps: [m] of slip below which SLIP is a parabola.
        static: times as much as sliding what hardly moves is held.
        root: whether the root is an unknown. Where it is not, the legs have nothing to do with each other.

    Returns:
        One system of all unknowns; or one a leg.
    """
    legs = [_leg(problem, k, x, eps, static, root) for k in range(len(problem.legs))]
    if not root:
        return tuple(legs)
    U, F = x.shape
    out = System(np.arange(U), *_empty(U, F), *near(problem, x, np.arange(U)))
    cost = out.cost + root_term(problem, x[:ROOT], out)
    for k, each in enumerate(legs):
        parts = (slice(0, ROOT), slice(0, ROOT)), (problem.columns(k), slice(ROOT, ROOT + LEG))
        for rows, own in parts:
            out.gradient[rows] += each.gradient[own]
            for columns, theirs in parts:
                out.main[rows, columns] += each.main[own, theirs]
                out.next[rows, columns] += each.next[own, theirs]
        cost += each.cost
    return (System(out.rows, out.gradient + product(out.near, x), out.main, out.next, out.near, cost),)


def objective(problem: Problem, x: Floats, eps: float, *, static: float = 1.0, root: bool = True) -> float:
    """Evaluate the objective at a state (U, F), with SLIP a parabola below `eps` [m].

    Args:
        problem: the clip's.
        x: (U, F) a state.
        eps: [m] of slip below which SLIP is a parabola.
        static: times as much as sliding what hardly moves is held.
        root: whether what the root costs by itself counts.
    """
    rows = np.arange(0 if root else ROOT, len(x))
    cost = near(problem, x, rows)[1]
    if root:
        cost += root_term(problem, x[:ROOT], None)
    for k, leg in enumerate(problem.legs):
        own = x[problem.columns(k)]
        places = places_of(leg, x[:ROOT], own)
        pulls = (point_terms(problem, pin, p, eps, static) for p, pin in zip(places, problem.pins[k], strict=True))
        cost += sum(pull.cost for pull in pulls)
        cost += joint_terms(problem, k, own, 0, None)
        if k in problem.skins:
            weight = floor_weight(problem.frame_time, problem.leg_length)
            cost += floor_cost(problem.skins[k], leg, places[ANKLE], own, weight)
    return cost


def _empty(n: int, frames: int) -> tuple[Floats, Floats, Floats]:
    return np.zeros((n, frames)), np.zeros((n, n, frames)), np.zeros((n, n, frames - 1))


def _leg(problem: Problem, k: int, x: Floats, eps: float, static: float, root: bool) -> System:
    """What one leg adds: with the root's unknowns, but without their NEAR; or by itself, with its own."""
    leg, own = problem.legs[k], problem.columns(k)
    at = posed(leg, x[:ROOT], x[own])
    first = 0 if root else ROOT
    rows = np.concatenate([np.arange(first, ROOT), np.arange(own.start, own.stop)])
    out = System(rows, *_empty(len(rows), problem.frames), np.zeros((3, 0, 0)), 0.0)
    cost = joint_terms(problem, k, x[own], ROOT - first, out)
    pulls = [point_terms(problem, pin, p, eps, static) for p, pin in zip(at.places, problem.pins[k], strict=True)]
    cost += sum(pull.cost for pull in pulls)
    add_points(at, pulls, out.gradient, out.main, out.next, root=root)
    if k in problem.skins:
        weight = floor_weight(problem.frame_time, problem.leg_length)
        cost += add_floor(problem.skins[k], leg, at, x[own], weight, out.gradient, out.main)
    if root:
        return System(rows, out.gradient, out.main, out.next, out.near, cost)
    bands, stays = near(problem, x, rows)
    return System(rows, out.gradient + product(bands, x[rows]), out.main, out.next, bands, cost + stays)

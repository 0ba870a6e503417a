"""The objective of a clip, linearised at a state: the sum of the terms of all points, joints and unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.assembly import Pulled, System, linearised, product
from footfix.enforce.leg import ANKLE, LEG, ROOT
from footfix.enforce.leg_state import LegState, places_of, state_of
from footfix.enforce.problem import Problem
from footfix.enforce.terms import joint_terms, near, point_cost, point_terms, root_term
from footfix.enforce.vertices import add_floor, floor_cost, floor_weight
from footfix.motion.clip import Floats


def posture(problem: Problem, x: Floats) -> tuple[LegState, ...]:
    """Compute all legs in a state (U, F)."""
    return tuple(state_of(leg, x[:ROOT], x[problem.columns(k)]) for k, leg in enumerate(problem.legs))


def systems(
    problem: Problem, x: Floats, eps: float, *, static: float = 1.0, root: bool = True,
    at: Sequence[LegState] | None = None,
) -> tuple[System, ...]:  # fmt: skip
    """Linearise the objective.

    Args:
        problem: the clip's.
        x: (U, F) a state.
        eps: [m] of slip below which SLIP is a parabola.
        static: static over kinetic friction.
        root: whether the root is an unknown. Where it is not, the legs are independent of each other.
        at: the legs in that state, from `posture`, where they are known.

    Returns:
        One system of all unknowns; or one a leg.
    """
    legs, at = range(len(problem.legs)), at or posture(problem, x)
    return tuple(_system(problem, own, x, at, eps, static, root) for own in ([legs] if root else [[k] for k in legs]))


def objective(
    problem: Problem, x: Floats, eps: float, *, static: float = 1.0, root: bool = True,
    at: Sequence[LegState] | None = None,
) -> float:  # fmt: skip
    """Evaluate the objective at a state (U, F), with SLIP a parabola below `eps` [m].

    Args:
        problem: the clip's.
        x: (U, F) a state.
        eps: [m] of slip below which SLIP is a parabola.
        static: static over kinetic friction.
        root: whether to include the root's own cost.
        at: the legs in that state, from `posture`, where they are known.
    """
    rows = np.arange(0 if root else ROOT, len(x))
    cost = near(problem, x, rows)[1]
    if root:
        cost += root_term(problem, x[:ROOT], None)
    for k, leg in enumerate(problem.legs):
        own = x[problem.columns(k)]
        places = places_of(leg, x[:ROOT], own) if at is None else at[k].places
        cost += sum(point_cost(problem, pin, p, eps, static) for p, pin in zip(places, problem.pins[k], strict=True))
        cost += joint_terms(problem, k, own, 0, None)
        if k in problem.skins:
            weight = floor_weight(problem.frame_time, problem.leg_length)
            cost += floor_cost(problem.skins[k], leg, places[ANKLE], own, weight)
    return cost


def _system(
    problem: Problem, legs: Sequence[int], x: Floats, at: Sequence[LegState], eps: float, static: float, root: bool
) -> System:
    """Assemble the system of some legs, with the root's unknowns or without."""
    rows = np.concatenate([np.arange(ROOT if root else 0), *(np.arange(len(x))[problem.columns(k)] for k in legs)])
    first, pulled = len(rows) - LEG * len(legs), []
    for n, k in enumerate(legs):
        points = zip(at[k].places, problem.pins[k], strict=True)
        pulls = [point_terms(problem, pin, place, eps, static) for place, pin in points]
        pulled.append(Pulled(at[k], pulls, slice(first + LEG * n, first + LEG * (n + 1))))
    gradient, blocks = linearised(pulled, len(rows))
    bands, cost = near(problem, x, rows)
    out = System(rows, gradient + product(bands, x[rows]), blocks, bands, 0.0)
    if root:
        cost += root_term(problem, x[:ROOT], out)
    for k, each in zip(legs, pulled, strict=True):
        own, base = x[problem.columns(k)], each.columns.start
        cost += joint_terms(problem, k, own, base, out) + sum(pull.cost for pull in each.pulls)
        if k in problem.skins:
            weight = floor_weight(problem.frame_time, problem.leg_length)
            cost += add_floor(problem.skins[k], problem.legs[k], each.at, own, weight, out, base)
    return replace(out, cost=cost)

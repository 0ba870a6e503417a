"""The objective of a clip, linearised at a state: the sum of the terms of all points, joints and unknowns.

The unknowns are those of the root and of all legs; or, with the root fixed, those of one leg alone: then no leg depends
on another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from footfix.enforce.assembly import Pull, Pulled, System, assembled, product
from footfix.enforce.leg import ANKLE, LEG, ROOT
from footfix.enforce.leg_state import LegState, state_of
from footfix.enforce.problem import Problem
from footfix.enforce.terms import joint_terms, near, point_cost, point_terms, rise_term, root_term
from footfix.enforce.vertices import add_floor, floor_cost, floor_weight
from footfix.motion.clip import Floats
from footfix.motion.threads import at_once


def posture(problem: Problem, x: Floats, leg: int | None = None) -> list[LegState]:
    """Compute all legs, or one alone, in a state (U, F)."""
    legs = problem.unknown_legs(leg)
    return at_once([partial(state_of, problem.legs[k], x[:ROOT], x[problem.columns(k)]) for k in legs], x.shape[1])


def objective(
    problem: Problem, x: Floats, eps: float, *, static: float = 1.0, leg: int | None = None,
    at: Sequence[LegState] | None = None,
) -> float:  # fmt: skip
    """Evaluate the objective at a state.

    Args:
        problem: the clip's.
        x: (U, F) the state.
        eps: [m] of slip below which SLIP is a parabola.
        static: static over kinetic friction.
        leg: the only leg whose unknowns they are; by default they are those of all legs and of the root.
        at: the legs in that state, from `posture`, where they are known.
    """
    legs, at = problem.unknown_legs(leg), at or posture(problem, x, leg)

    def of_leg(k: int, now: LegState) -> float:
        places = now.places
        own = x[problem.columns(k)]
        cost = sum(point_cost(problem, pin, p, eps, static) for p, pin in zip(places, problem.pins[k], strict=True))
        cost += joint_terms(problem, k, own, 0, None) + rise_term(problem, k, now, slice(0, LEG), None)
        if k in problem.skins:
            weight = floor_weight(problem.frame_time, problem.leg_length)
            cost += floor_cost(problem.skins[k], problem.legs[k], places[ANKLE], own, weight)
        return cost

    cost = near(problem, x, problem.rows(leg))[1] + (root_term(problem, x[:ROOT], None) if leg is None else 0.0)
    return cost + sum(at_once([partial(of_leg, k, a) for k, a in zip(legs, at, strict=True)], x.shape[1]))


def linearised(
    problem: Problem, x: Floats, eps: float, *, static: float = 1.0, leg: int | None = None,
    at: Sequence[LegState] | None = None,
) -> System:  # fmt: skip
    """Linearise the objective at a state; arguments as of `objective`."""
    legs, at = problem.unknown_legs(leg), at or posture(problem, x, leg)
    rows = problem.rows(leg)
    first = len(rows) - LEG * len(legs)  # the root's unknowns, if they are there, come before

    def pulls(k: int, places: Sequence[Floats]) -> list[Pull]:
        return [point_terms(problem, pin, p, eps, static) for p, pin in zip(places, problem.pins[k], strict=True)]

    found = at_once([partial(pulls, k, each.places) for k, each in zip(legs, at, strict=True)], x.shape[1])
    pulled = [
        Pulled(each, pull, slice(first + LEG * n, first + LEG * (n + 1)))
        for n, (each, pull) in enumerate(zip(at, found, strict=True))
    ]
    gradient, bands = assembled(pulled, len(rows))
    diagonals, cost = near(problem, x, rows)
    out = System(rows, gradient + product(diagonals, x[rows]), bands, diagonals, 0.0)
    if leg is None:
        cost += root_term(problem, x[:ROOT], out)
    for k, each in zip(legs, pulled, strict=True):
        own, base = x[problem.columns(k)], each.columns.start
        cost += joint_terms(problem, k, own, base, out) + sum(pull.cost for pull in each.pulls)
        cost += rise_term(problem, k, each.at, each.columns, out)
        if k in problem.skins:
            weight = floor_weight(problem.frame_time, problem.leg_length)
            cost += add_floor(problem.skins[k], problem.legs[k], each.at, own, weight, out, base)
    return replace(out, cost=cost)

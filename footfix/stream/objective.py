"""The objective of `enforce.terms`, for all legs and points of a short window together.

The same terms and derivatives as for a whole clip, laid out for few frames: there the arrays are long and each leg,
point and bound is worked on by itself; here they are short, and what takes the time is the number of operations.

Arrays have components first, then points, legs and frames: (3, P, L, F).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.assembly import product
from footfix.enforce.costs import FAR_TURN, FLOOR, KNEE, PLACE, RATE, SPEED, STATIC, TOES, UPRIGHT
from footfix.enforce.leg import LEG, ROOT, TIP, B, K, LegTracks, Q, W
from footfix.enforce.pins import Pins
from footfix.enforce.posed import cross, exponential, left_jacobian, rotated
from footfix.enforce.problem import Problem
from footfix.enforce.terms import friction, near, root_bound, smooth
from footfix.motion.clip import Floats

POINTS = 4


@dataclass(frozen=True, eq=False)
class Legs:
    """The legs of a window, stacked; a leg without a tip has one at its toe joint.

    Args:
        hip, line, axis, toe_hinge, reach: (3, L, F) as of `LegTracks`.
        soles: (3, 2, L, F) [m] heel and toe from the ankle.
        tip: (3, L, F) [m] from the toe.
        flexion, least: (L, F) [rad].
    """

    hip: Floats
    line: Floats
    axis: Floats
    toe_hinge: Floats
    reach: Floats
    soles: Floats
    tip: Floats
    flexion: Floats
    least: Floats

    @classmethod
    def of(cls, legs: Sequence[LegTracks]) -> Legs:
        """Stack the legs."""
        some = {
            name: np.stack([getattr(leg, name) for leg in legs], axis=1)
            for name in ("hip", "line", "axis", "toe_hinge", "reach")
        }
        soles = np.stack([np.stack(leg.points[:2], axis=1) for leg in legs], axis=2)
        tip = np.stack([leg.points[2] if len(leg.points) > 2 else np.zeros_like(leg.hip) for leg in legs], axis=1)
        flexion, least = (np.stack([getattr(leg, name) for leg in legs]) for name in ("flexion", "least"))
        return cls(**some, soles=soles, tip=tip, flexion=flexion, least=least)


@dataclass(frozen=True, eq=False)
class Stacked:
    """The pins of a window, stacked: as of `Pins`, of P points of L legs."""

    hold: Floats
    slip: Floats
    level: Floats
    draw: Floats
    lowest: Floats
    place: Floats
    placed: Floats

    @classmethod
    def of(cls, pins: Sequence[Sequence[Pins]]) -> Stacked:
        """Stack the pins; a point that a leg does not have asks for nothing."""

        def stack(name: str) -> Floats:
            by_leg = []
            for own in pins:
                tracks = [getattr(pin, name) for pin in own]
                empty = np.full_like(tracks[0], -np.inf if name == "lowest" else 0.0)
                by_leg.append(np.stack(tracks + [empty] * (POINTS - len(tracks)), axis=-2))
            return np.stack(by_leg, axis=-2)

        names = ("hold", "slip", "level", "draw", "lowest", "place", "placed")
        return cls(**{name: stack(name) for name in names})


@dataclass(frozen=True, eq=False)
class Posed:
    """Points (3, P, L, F) [m] of a state, and their derivatives (L, F, 3 P, 11) by the root and the leg's unknowns."""

    places: Floats
    jacobian: Floats


@dataclass(frozen=True, eq=False)
class Reached:
    """What a leg's points were worked out from: (3, L, F) thrust from the hip and its change by the knee's flexion.

    Args:
        thrust: [m] from hip to ankle.
        bent: [m/rad] its derivative by the flexion.
        arms: (3, P, L, F) [m] of the points from the ankle.
        hinge: of the toes.
        toes: [m] from the toe joint to the tip.
    """

    thrust: Floats
    bent: Floats
    arms: Floats
    hinge: Floats
    toes: Floats


def places_of(legs: Legs, root: Floats, x: Floats) -> tuple[Floats, Reached]:
    """Put the points (3, P, L, F) [m] where a state has them: root (3, F) [m], and the legs' unknowns (8, L, F)."""
    q, k, w, b = x[Q], x[K], x[W], x[B]
    c0, c1, c2 = legs.reach
    cos, sin = np.cos(k), np.sin(k)
    distance = np.sqrt(np.maximum(c0 + c1 * cos + c2 * sin, 1e-12))
    line = rotated(exponential(q), legs.line)
    thrust = line * distance
    ankle = legs.hip + root[:, None] + thrust
    tip = rotated(exponential(b * legs.toe_hinge), legs.tip)
    in_foot = np.concatenate([legs.soles, legs.toe_hinge[:, None], tip[:, None]], axis=1)
    by_foot = rotated(exponential(w)[:, :, None], in_foot)
    arms = np.empty((3, POINTS, *k.shape))
    arms[:, :2], arms[:, 2], arms[:, TIP] = by_foot[:, :2], 0.0, by_foot[:, 1] + by_foot[:, 3]
    bent = line * ((c2 * cos - c1 * sin) / (2.0 * distance))
    return ankle[:, None] + arms, Reached(thrust, bent, arms, by_foot[:, 2], by_foot[:, 3])


def posed(legs: Legs, root: Floats, x: Floats) -> Posed:
    """The same, with derivatives."""
    places, at = places_of(legs, root, x)
    n = at.thrust.shape[1:]
    out = np.zeros((*n, 3, POINTS, ROOT + LEG))
    for c in range(3):
        out[..., c, :, c] = 1.0
    rest = out[..., ROOT:]
    rest[..., Q] = _swept(x[Q], at.thrust).transpose(2, 3, 0, 1)[..., None, :]
    rest[..., K] = at.bent.transpose(1, 2, 0)[..., None]
    rest[..., W] = _swept(x[W], at.arms).transpose(3, 4, 0, 2, 1)
    rest[..., TIP, B] = cross(at.hinge, at.toes).transpose(1, 2, 0)
    return Posed(places, out.reshape(*n, 3 * POINTS, ROOT + LEG))


def _swept(vector: Floats, v: Floats) -> Floats:
    """(3, 3, ...) how vectors v (3, ..., L, F) move while what turned them (3, L, F) changes."""
    turn = left_jacobian(vector)
    return cross(turn.reshape(3, 3, *(1,) * (v.ndim - vector.ndim), *vector.shape[1:]), v[:, None])


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


def normal(problem: Problem, legs: Legs, pins: Stacked, x: Floats, eps: float, static: float) -> Normal:
    """Linearise the objective of a window at a state (U, F); see `enforce.objective.systems`."""
    F, L = x.shape[1], len(problem.legs)
    own = x[ROOT:].reshape(L, LEG, F).swapaxes(0, 1)  # (8, L, F)
    at = posed(legs, x[:ROOT], own)
    force, stiff, step = _pull(problem, pins, at.places, eps, static)
    J = at.jacobian  # (L, F, 12, 11)
    by_place = force.transpose(2, 3, 0, 1).reshape(L, F, -1, 1)
    gradient = (J.swapaxes(2, 3) @ by_place)[..., 0]  # (L, F, 11)
    main = J.swapaxes(2, 3) @ (stiff.transpose(2, 3, 0, 1).reshape(L, F, -1, 1) * J)
    steps = step.transpose(2, 3, 0, 1).reshape(L, F - 1, -1, 1)
    next_ = -(J[:, 1:].swapaxes(2, 3) @ (steps * J[:, :-1]))
    _knees(problem, legs, own, gradient, main)
    _fast(problem, legs, own, gradient, main, next_)
    _far(problem, own, gradient, main)
    return _together(problem, x, gradient, main, next_)


def _together(problem: Problem, x: Floats, gradient: Floats, main: Floats, next_: Floats) -> Normal:
    """The legs' systems as one, with the root's own terms and NEAR."""
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
    bands, _ = near(problem, x, np.arange(U))
    return Normal(whole + product(bands, x).T, blocks, nexts, bands)


def _pull(problem: Problem, pin: Stacked, place: Floats, eps: float, static: float) -> tuple[Floats, Floats, Floats]:
    """SLIP, LEVEL, FLOOR and PLACE: gradient and second derivatives by place (3, P, L, F), and between frames."""
    size, per_frame = problem.leg_length, RATE * problem.frame_time
    slip = np.diff(place, axis=-1) - pin.slip
    flat = slip[0] ** 2 + slip[2] ** 2
    long = np.sqrt(flat + (UPRIGHT * slip[1]) ** 2)
    c = problem.costs.slide / size * pin.hold
    step = c / (long + eps) * np.array([1.0, UPRIGHT**2, 1.0]).reshape(3, 1, 1, 1)
    if static > 1.0:
        flat, still = np.sqrt(flat), STATIC * size * problem.frame_time
        more, _ = friction(smooth(flat, eps) / still)
        step[::2] += c * (static - 1.0) * more / (flat + eps)
    asked = per_frame / (PLACE * size) ** 2 * pin.placed
    stiff = np.repeat(asked[None], 3, axis=0)
    force = asked * (place - pin.place)
    pulled = step * slip
    force[..., 1:] += pulled
    force[..., :-1] -= pulled
    stiff[..., 1:] += step
    stiff[..., :-1] += step
    level = per_frame / (problem.costs.level * size) ** 2 * pin.draw
    low = np.maximum(pin.lowest - place[1], 0.0)
    floor = per_frame / (FLOOR * size) ** 2
    force[1] += level * (place[1] - pin.level) - floor * low
    stiff[1] += level + floor * (low > 0.0)
    return force, stiff, step


def _knees(problem: Problem, legs: Legs, x: Floats, gradient: Floats, main: Floats) -> None:
    """KNEE: no knee is straighter than the figure's own."""
    weight = RATE * problem.frame_time / np.radians(KNEE) ** 2
    lacks = np.maximum(legs.least - legs.flexion - x[K], 0.0)
    gradient[..., ROOT + K] -= weight * lacks
    main[..., ROOT + K, ROOT + K] += weight * (lacks > 0.0)


def _far(problem: Problem, x: Floats, gradient: Floats, main: Floats) -> None:
    """FAR of line, knee, ankle and toes."""
    c = problem.costs
    weight = RATE * problem.frame_time / np.radians(FAR_TURN) ** 2
    kinds = (
        (x[Q], c.line_farthest, ((Q, 1.0),)),
        (x[K : K + 1], c.ankle_farthest, ((slice(K, K + 1), 1.0),)),
        (x[W] - x[Q], c.ankle_farthest, ((W, 1.0), (Q, -1.0))),
        (x[B : B + 1] / TOES, c.toes_farthest, ((slice(B, B + 1), 1.0 / TOES),)),
    )
    for turn, most, parts in kinds:
        pull, bend = _beyond(turn, problem.farthest(most), weight)
        if pull is None or bend is None:
            continue
        pull, bend = pull.transpose(1, 2, 0), bend.transpose(2, 3, 0, 1)
        for rows, share in parts:
            at = slice(ROOT + rows.start, ROOT + rows.stop)
            gradient[..., at] += share * pull
            for columns, other in parts:
                main[..., at, ROOT + columns.start : ROOT + columns.stop] += share * other * bend


def _beyond(turn: Floats, far: Floats, weight: float) -> tuple[Floats | None, Floats | None]:
    """One-sided cost of a turn (m, ..., F) longer than `far` (F,): gradient, and second derivatives (m, m, ..., F)."""
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
    kinds = (
        (x[Q] - bent, half, ((Q, 1.0),)),
        (x[K : K + 1], None, ((slice(K, K + 1), 1.0),)),
        (x[W] - x[Q] - bent, half, ((W, 1.0), (Q, -1.0))),
    )
    for turn, axis, parts in kinds:
        step = np.diff(turn, axis=-1)
        size = np.sqrt(np.sum(step**2, axis=0))
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

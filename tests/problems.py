"""Small problems for the tests of enforcement, and their terms written down a second time, residual by residual.

`residuals` follows the table of `footfix.enforce.terms` line by line and shares nothing with its arithmetic but the
places of the sole points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np
from legmaker import figure
from scipy.spatial.transform import Rotation

from footfix.enforce import costs, vertices
from footfix.enforce.assembly import System
from footfix.enforce.costs import CostParams
from footfix.enforce.leg import ANKLE, LEG, ROOT, TIP, TOE, B, K, LegTracks, W
from footfix.enforce.leg_state import places_of
from footfix.enforce.objective import linearised
from footfix.enforce.pins import Pins
from footfix.enforce.problem import Problem
from footfix.motion.clip import Floats

# Everything away from its capture is free: what a term costs is all there is.
FREE = CostParams(**{
    each.name: (1e9 if each.name not in ("slide", "level") else getattr(CostParams(), each.name))
    for each in fields(CostParams)
})  # fmt: skip


def idle(frames: int) -> Pins:
    """A pin of a point that has nothing to do."""
    zero = np.zeros(frames)
    return Pins(
        np.zeros(frames - 1), np.zeros((3, frames - 1)), np.zeros(frames, dtype=bool), zero, zero,
        np.full(frames, -np.inf), np.zeros((3, frames)), zero,
    )  # fmt: skip


def problem(
    pins: dict[tuple[int, int], Pins] | None = None, *, frames: int = 7, legs: int = 1, first: int = 20, every: int = 3,
    costs: CostParams = FREE, kind: str = "plain", **changes: object,
) -> Problem:  # fmt: skip
    """A walker's few frames, with pins by leg and point."""
    which = np.arange(first, first + every * frames, every)
    tracks = tuple(leg.frames(which) for leg in figure(kind).legs[:legs])
    given = pins or {}
    all_pins = tuple(
        tuple(given.get((k, point), idle(frames)) for point in range(len(leg.points) + 1))
        for k, leg in enumerate(tracks)
    )  # fmt: skip
    made = Problem(
        legs=tracks, pins=all_pins, frame_time=every / 60.0, leg_length=figure(kind).rig.leg_length, costs=costs,
        noise=np.zeros(ROOT + LEG * legs), white=np.zeros(ROOT + LEG * legs, dtype=bool),
        fault=np.full(frames, np.inf),
    )  # fmt: skip
    return replace(made, **changes)  # type: ignore[arg-type]


def state(of: Problem, size: float = 0.05, seed: int = 0) -> Floats:
    """(U, F) a random state."""
    return size * np.random.default_rng(seed).normal(size=(of.unknowns, of.frames))


def places(of: Problem, x: Floats) -> list[list[Floats]]:
    """For each leg its points, (3, F) [m] each."""
    return [
        list(places_of(leg, x[:ROOT], x[of.columns(k)])) for k, leg in enumerate(of.legs)
    ]  # fmt: skip


def residuals(
    of: Problem, x: Floats, *, near_at: list[list[Floats]] | None = None, eps: float = 1e-3, static: float = 1.0
) -> Floats:
    """(N,) the residuals r whose 1/2 r'r is the objective's quadratic part around a state.

    SLIP is weighted by the slip of the places `near_at`, if not its own (Weiszfeld), and LEVEL by their height;
    one-sided terms are what they are.
    """
    c, size, dt, deg = of.costs, of.leg_length, of.frame_time, np.pi / 180.0
    frames, per_frame = of.frames, np.sqrt(costs.RATE * of.frame_time)
    out: list[Floats] = []
    # NEAR, CUT
    s0, s2 = of.near()
    out.append(per_frame * x / s0[:, None])
    out.append(per_frame * np.diff(x, n=2, axis=1) / dt**2 / s2[:, None])
    for end, frame in zip(of.cut, (0, frames - 1), strict=True):
        if end:
            sc = np.array([costs.CUT_ROOT * size] * ROOT + [costs.CUT * deg] * (len(x) - ROOT))
            out.append(x[:, frame] / (sc * dt / (1.0 / 120.0)))
    here = places(of, x)
    before = here if near_at is None else near_at
    for k, points in enumerate(here):
        leg, own = of.legs[k], x[of.columns(k)]
        for point, place in enumerate(points):
            pin = of.pins[k][point]
            out += _slips(of, pin, place, before[k][point], eps, static)
            # LEVEL, FLOOR, PLACE
            on = pin.stands.astype(float) * np.sqrt(pin.draw)
            off, then = place[1] - pin.level, np.maximum(before[k][point][1] - pin.level, costs.LIFTED * size)
            out.append(per_frame * on * np.sqrt(costs.LIFTED * size / then) * off / (c.level * size))
            out.append(per_frame * np.maximum(0.0, pin.lowest - place[1]) / (costs.FLOOR * size))
            out.append(per_frame * np.sqrt(pin.placed) * (place - pin.place) / (costs.PLACE * size))
        # RISE
        rise = of.pins[k][-1].rise
        if rise is not None:
            above = points[TIP][1] - points[TOE][1]
            out.append(per_frame * np.maximum(0.0, above - rise) / (costs.RISE * size))
        # KNEE
        flexion = leg.flexion + own[K]
        out.append(per_frame * np.maximum(0.0, leg.least - flexion) / (costs.KNEE * deg))
        out += _speeds(of, leg, own)
        if k in of.skins:
            low = np.maximum(0.0, of.skins[k].lowest - heights(of, x, k))
            out.append(per_frame * low / (vertices._SIGMA * size))
    for turn, far, sigma in bounds(of):
        out.append(per_frame * np.maximum(0.0, np.linalg.norm(turn @ x, axis=0) - far) / sigma)
    return np.concatenate([each.ravel() for each in out])


def heights(of: Problem, x: Floats, k: int) -> Floats:
    """(N, F) [m] of the vertices of a leg's foot, by rotations of the house next door."""
    leg, own, skin = of.legs[k], x[of.columns(k)], of.skins[k]
    foot, bend = (Rotation.from_rotvec(turn.T) for turn in (own[W], own[B] * leg.toe_hinge))
    ankle = places_of(leg, x[:ROOT], own)[ANKLE]
    toes = np.zeros_like(skin.base) if skin.toes is None else skin.toes
    return np.stack([
        ankle[1] + foot.apply(base.T + bend.apply(tip.T))[:, 1] for base, tip in zip(skin.base, toes, strict=True)
    ])  # fmt: skip


def bounds(of: Problem) -> list[tuple[Floats, Floats, Floats]]:
    """FAR: for each bounded turn its matrix (m, U), how far it goes freely, and the standard deviation beyond, (F,)."""
    c, size, deg = of.costs, of.leg_length, np.pi / 180.0
    one = np.eye(of.unknowns)
    found = [(one[:ROOT], np.full(of.frames, c.root_farthest * size), np.full(of.frames, costs.FAR_ROOT * size))]
    seen = np.maximum(of.fault / (c.noticed * size), 1.0)
    small, least, most = c.unnoticed_turn * seen, min(costs.TOES * c.unnoticed_turn, c.toes_farthest), c.toes_farthest
    firm = np.clip((costs.UNNOTICED - seen) / (costs.UNNOTICED - 1.0), 0.0, 1.0)
    sigma = deg * (costs.FAR_TURN + firm * (costs.FIRM_TURN - costs.FAR_TURN))
    some = min(costs.UNNOTICED * least, most)  # from here on toes go to their limit
    share = np.clip((seen - costs.UNNOTICED) / (2.0 - costs.UNNOTICED), 0.0, 1.0)
    toes = np.where(share > 0.0, some + share * (most - some), np.minimum(least * seen, most))
    for k in range(len(of.legs)):
        own = one[of.columns(k)]
        joints = (own[:3], c.line_farthest), (own[3:4], c.ankle_farthest), (own[4:7] - own[:3], c.ankle_farthest)
        found += [(turn, np.minimum(small, far) * deg, sigma) for turn, far in joints]
        found.append((own[7:8], toes * deg, sigma))
    return found


def curvature(of: Problem, x: Floats) -> Floats:
    """(U F, U F) what FAR's second derivatives have beyond J'J: (1 - far / |y|) (1 - y y' / |y|^2) across y."""
    out = np.zeros((of.frames, of.unknowns, of.frames, of.unknowns))
    for turn, far, sigma in bounds(of):
        for f, y in enumerate((turn @ x).T):
            long = float(np.linalg.norm(y))
            if long > far[f]:
                across = (1.0 - far[f] / long) * (np.eye(len(y)) - np.outer(y, y) / long**2)
                out[f, :, f] += costs.RATE * of.frame_time / sigma[f] ** 2 * turn.T @ across @ turn
    return out.reshape(of.frames * of.unknowns, -1)


def _slips(of: Problem, pin: Pins, place: Floats, before: Floats, eps: float, static: float) -> list[Floats]:
    less = np.array([[1.0], [costs.UPRIGHT], [1.0]])
    slip, then = (less * (each[:, 1:] - each[:, :-1] - pin.slip) for each in (place, before))
    long = np.linalg.norm(then, axis=0)
    weight = of.costs.slide / of.leg_length * pin.hold / (long + eps)
    flat = np.hypot(then[0], then[2])
    rounded = flat - eps * np.log(1.0 + flat / eps)
    more = (static - 1.0) / (1.0 + (rounded / of.frame_time / (costs.STATIC * of.leg_length)) ** 4)
    static_weight = of.costs.slide / of.leg_length * pin.hold / (flat + eps) * more
    return [np.sqrt(weight + np.stack([static_weight, 0.0 * flat, static_weight])) * slip]


def _speeds(of: Problem, leg: LegTracks, own: Floats) -> list[Floats]:
    """SPEED: hip q - k / 2 axis, knee k, ankle w - q - k / 2 axis, each from frame to frame."""
    out, most = [], np.radians(of.costs.speed) * of.frame_time
    half = 0.5 * own[K] * leg.axis
    for turn in (own[:3] - half, own[K : K + 1], own[4:7] - own[:3] - half):
        step = np.linalg.norm(np.diff(turn, axis=1), axis=0)
        out.append(np.maximum(0.0, step - most) / np.radians(costs.SPEED))
    return out


def slip_cost(of: Problem, x: Floats, eps: float) -> float:
    """SLIP: c h |s|, round at its foot: what the reweighted parabolas descend on."""
    cost = 0.0
    for pins, points in zip(of.pins, places(of, x), strict=True):
        for pin, place in zip(pins, points, strict=True):
            slip = (np.diff(place, axis=1) - pin.slip) * [[1.0], [costs.UPRIGHT], [1.0]]
            long = np.linalg.norm(slip, axis=0)
            cost += of.costs.slide / of.leg_length * float(pin.hold @ (long - eps * np.log(1.0 + long / eps)))
    return cost


def lifted_cost(of: Problem, x: Floats) -> float:
    """What LEVEL costs beyond its reweighted parabola where a point is lifted by h: a (l h - l^2 / 2) in all."""
    cost, most = 0.0, costs.LIFTED * of.leg_length
    for pins, points in zip(of.pins, places(of, x), strict=True):
        for pin, place in zip(pins, points, strict=True):
            high = np.maximum(place[1] - pin.level, most)
            weight = costs.RATE * of.frame_time * pin.stands * pin.draw / (of.costs.level * of.leg_length) ** 2
            cost += float(np.sum(weight * (most * high - 0.5 * most**2 - 0.5 * most * high)))
    return cost


def differences(function: object, x: Floats, frames: Sequence[int], h: float = 1e-6) -> Floats:
    """(N, U f) derivatives of a function of a state by each unknown of some frames, frames slowest."""
    U = len(x)
    columns = []
    for f in frames:
        for u in range(U):
            step = np.zeros_like(x)
            step[u, f] = h
            columns.append((function(x + step) - function(x - step)) / (2.0 * h))  # type: ignore[operator]
    return np.stack(columns, axis=-1)


def system(of: Problem, x: Floats, eps: float, static: float = 1.0) -> System:
    """The objective linearised in all unknowns."""
    found = linearised(of, x, eps, static=static)
    assert np.array_equal(found.rows, np.arange(of.unknowns))
    return found


def dense(of: System) -> Floats:
    """(n F, n F) the matrix of a system, frames slowest."""
    n, F = of.gradient.shape
    out = np.zeros((F, n, F, n))
    for f in range(F):
        out[f, :, f] += of.main[f] + np.diag(of.near[0, :, f])
        if f + 1 < F:
            block = of.next[f] + np.diag(of.near[1, :, f])
            out[f, :, f + 1] += block
            out[f + 1, :, f] += block.T
        if f + 2 < F:
            out[f + 2, :, f] += np.diag(of.near[2, :, f])
            out[f, :, f + 2] += np.diag(of.near[2, :, f])
    return out.reshape(F * n, F * n)

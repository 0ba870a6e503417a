"""The terms of the objective, each with its weight and its derivative: their sum over the whole clip is minimised.

Unknowns of frame t (see `leg`):  x = (d, q, k, w, b, q, k, w, b, ...):  d the root's shift; of each leg q the turn of
the line from hip to ankle, k the knee's flexion, w the foot's turn, b the bend of the toes.  p is the place of a
planted point, dt the frame time, r a rate (`costs.RATE`); h and a are weights of a pin (`pins`), s.. standard
deviations (`costs`).

Minimised:   1/2 sum_t r dt ( |x / s0|^2 + |x'' / s2|^2 )     NEAR    stay near the capture, and near its accelerations
           + c sum_t h |p(t + 1) - p(t) - slip|               SLIP    planted points do not move: friction, c a metre
           + 1/2 sum_t r dt a ((p_y - level) / sl)^2          LEVEL   planted points are at their floor's height (*)
           + 1/2 sum_t r dt (max(0, lowest - p_y) / sf)^2     FLOOR   nothing is below the floor (see `vertices`, too)
           + 1/2 sum_t r dt (max(0, y - rise) / su)^2         RISE    no tip is high over its toe joint; y, how high
           + 1/2 sum_t r dt (max(0, least - flexion) / sk)^2  KNEE    no knee is straighter than the clip's own
           + 1/2 sum_t (max(0, |y(t + 1) - y(t)| - v dt) / sv)^2   SPEED   no joint turns much faster than captured
           + 1/2 sum_t r dt (max(0, |y| - far) / sd)^2        FAR     joints stay within bounds; y = d, q, k, w - q, b
           + 1/2 sum_t r dt |(p - place) / sp|^2              PLACE   requested places
           + 1/2 |x / sc|^2 at a cut                          CUT     beside a cut-off T-pose the correction is small

(*) A point more than l above its level, l = `costs.LIFTED`, is drawn down as by l, no harder: the cost goes on as a
straight line (Huber). What is far above its floor within a contact is being lifted, or has not landed yet; a parabola
would pull the whole figure down to plant it. What is below the floor has no such excuse.

SLIP is an L1 norm: where holding costs more than sliding, the foot slides there, and only there. It is solved by
reweighting (Weiszfeld): 1/2 c h |s|^2 / (|s_before| + eps), a bound from above that touches at s_before.
"""

from __future__ import annotations

import numpy as np

from footfix.enforce.assembly import Pull, System, product
from footfix.enforce.costs import (
    FAR_ROOT,
    FLOOR,
    KNEE,
    LIFTED,
    PLACE,
    RATE,
    RISE,
    SPEED,
    STATIC,
    UPRIGHT,
)
from footfix.enforce.leg import LEG, ROOT, TIP, TOE, B, K, Q, W
from footfix.enforce.leg_state import LegState
from footfix.enforce.pins import Pins
from footfix.enforce.problem import Problem
from footfix.motion.clip import Floats, Ints


def near(problem: Problem, x: Floats, rows: Ints) -> tuple[Floats, float]:
    """Evaluate NEAR and CUT of some unknowns: (3, n, F) the bands of their matrix, and what they cost.

    Their derivative by x is that matrix times x (`assembly.product`).

    Args:
        problem: the clip's.
        x: (U, F) a state.
        rows: (n,) which unknowns, one after the other.
    """
    own = slice(int(rows[0]), int(rows[-1]) + 1)
    bands = problem.near_bands[:, own]
    return bands, 0.5 * float(np.sum(x[own] * product(bands, x[own])))


def point_terms(problem: Problem, pin: Pins, place: Floats, eps: float, static: float) -> Pull:
    """Evaluate SLIP, LEVEL, FLOOR and PLACE of a point, and their derivatives with respect to its place.

    Args:
        problem: the clip's.
        pin: the constraints on the point.
        place: (3, F) [m] where it is.
        eps: [m] of slip below which SLIP is a parabola.
        static: static over kinetic friction.
    """
    slipped, slip, step = _slip(problem, pin, place, eps, static)
    raised, push, stiffer = _level_and_floor(problem, pin, place[1])
    force, stiff = np.zeros_like(place), np.zeros_like(place)
    drawn = step * slip
    force[:, 1:] += drawn
    force[:, :-1] -= drawn
    stiff[:, 1:] += step
    stiff[:, :-1] += step
    force[1] += push
    stiff[1] += stiffer
    cost, away, asked = _asked(problem, pin, place)
    return Pull(slipped + raised + cost, force + asked * away, stiff + asked, step)


def point_cost(problem: Problem, pin: Pins, place: Floats, eps: float, static: float) -> float:
    """Evaluate SLIP, LEVEL, FLOOR and PLACE of a point alone; arguments as of `point_terms`."""
    slipped, raised = _slip(problem, pin, place, eps, static)[0], _level_and_floor(problem, pin, place[1])[0]
    return slipped + raised + _asked(problem, pin, place)[0]


def _asked(problem: Problem, pin: Pins, place: Floats) -> tuple[float, Floats, Floats]:
    """PLACE, |p - place|^2: its cost, how far the point is away, and its stiffness."""
    stiff = RATE * problem.frame_time * pin.placed / (PLACE * problem.leg_length) ** 2
    away = place - pin.place
    return 0.5 * float(np.sum(stiff * away**2)), away, stiff


def _slip(problem: Problem, pin: Pins, place: Floats, eps: float, static: float) -> tuple[float, Floats, Floats]:
    """SLIP, c h |s| with s = p(t + 1) - p(t) - slip, less of it up and down: its cost, s, and its stiffness by s.

    Reweighted, its derivative by p(t + 1) is c h s / (|s| + eps), by p(t) the same with the sign turned round.
    """
    size = problem.leg_length
    slip = np.diff(place, axis=1) - pin.slip  # (3, F - 1) [m]
    long = np.sqrt(slip[0] ** 2 + (UPRIGHT * slip[1]) ** 2 + slip[2] ** 2)
    c = problem.costs.slide / size * pin.hold
    cost = float(np.sum(c * smooth(long, eps)))  # what the reweighting descends on
    step = c / (long + eps) * np.array([[1.0], [UPRIGHT**2], [1.0]])
    if static > 1.0:  # over the floor only
        flat, still = np.hypot(slip[0], slip[2]), STATIC * size * problem.frame_time
        more, total = friction(smooth(flat, eps) / still)
        further = (static - 1.0) * problem.costs.slide / size * pin.sticking()
        cost += float(np.sum(further * still * total))
        step[::2] += further * more / (flat + eps)
    return cost, slip, step


def _level_and_floor(problem: Problem, pin: Pins, height: Floats) -> tuple[float, Floats, Floats]:
    """LEVEL, a (p_y - level)^2, and FLOOR, max(0, lowest - p_y)^2: their cost, force and stiffness by the height.

    Above `costs.LIFTED`, LEVEL is a straight line; its stiffness is that of a parabola from above that touches it.
    """
    size, per_frame = problem.leg_length, RATE * problem.frame_time
    level = np.where(pin.stands, per_frame * pin.draw / (problem.costs.level * size) ** 2, 0.0)
    off, low = height - pin.level, np.maximum(pin.lowest - height, 0.0)
    floor = per_frame / (FLOOR * size) ** 2 * (low > 0.0)
    straight = LIFTED * size
    high = np.maximum(off, straight)
    level *= straight / high  # reweighted, as SLIP is
    cost = 0.5 * float(np.sum(level * (off**2 + high * (high - straight)) + floor * low**2))
    return cost, level * off - floor * low, level + floor


def smooth(slip: Floats, eps: float) -> Floats:
    """Round the corner of |slip| at zero, so that its derivative is slip / (slip + eps)."""
    return np.asarray(slip - eps * np.log1p(slip / eps))


def friction(slip: Floats) -> tuple[Floats, Floats]:
    """Compute the weight of static friction and its integral, by slip in units of the greatest slip that it holds.

    The weight 1 / (1 + u^4) is nearly 1 for a point that stands and nearly 0 for one that slides.
    """
    root, u = np.sqrt(2.0), slip
    logs = np.log((u * u + root * u + 1.0) / (u * u - root * u + 1.0))
    turns = 2.0 * (np.arctan(root * u + 1.0) + np.arctan(root * u - 1.0))
    return sticks(u), (logs + turns) / (4.0 * root)


def sticks(slip: Floats) -> Floats:
    """Compute the weight of static friction alone; see `friction`."""
    return np.asarray(1.0 / (1.0 + slip**4))


def joint_terms(problem: Problem, k: int, x: Floats, base: int, out: System | None) -> float:
    """Evaluate KNEE, SPEED and FAR of a leg, and add their derivatives to a system.

    While the knee bends by k, thigh and shank turn by k / 2 to either side of the line from hip to ankle: so the hip
    turns by about q - k / 2 axis in its parent's frame, the ankle by w - q - k / 2 axis.

    Args:
        problem: the clip's.
        k: which leg.
        x: (8, F) its unknowns.
        base: the row at which they begin in the system.
        out: the system, if the derivatives are wanted.
    """
    leg, own, c = problem.legs[k], slice(base, base + LEG), problem.costs
    cost = _knee(problem, leg.least - leg.flexion - x[K], base + K, out)
    q, w, one = np.zeros((3, LEG)), np.zeros((3, LEG)), np.eye(3)
    q[:, Q], w[:, W] = one, one
    knee = np.zeros((1, LEG))
    knee[0, K] = 1.0
    half = 0.5 * leg.axis * x[K]  # (3, F)
    axis = np.zeros((3, LEG, problem.frames))
    axis[:, K] = 0.5 * leg.axis
    most, sv = np.radians(c.speed) * problem.frame_time, np.radians(SPEED)
    for turn, bend, off in ((q, axis, half), (knee, None, 0.0), (w - q, axis, half)):
        cost += _speed(turn, bend, turn @ x - off, own, most, sv, out)
    toes = np.zeros((1, LEG))
    toes[0, B] = 1.0
    for turn, far in zip((q, knee, w - q, toes), problem.farthest, strict=True):
        cost += _far(turn, x, own, far, problem.beyond, problem, out)
    return cost


def _knee(problem: Problem, lacking: Floats, row: int, out: System | None) -> float:
    """Add KNEE: one-sided cost of flexion below the least allowed, (F,) [rad]; the knee is unknown `row`."""
    weight = RATE * problem.frame_time / np.radians(KNEE) ** 2
    lacks = np.maximum(lacking, 0.0)
    if out is not None:
        out.gradient[row] -= weight * lacks
        out.main[:, row, row] += weight * (lacks > 0.0)
    return float(0.5 * weight * np.sum(lacks**2))


def _speed(
    turn: Floats, bend: Floats | None, turned: Floats, own: slice, most: float, sigma: float, out: System | None
) -> float:
    """Add SPEED: one-sided cost of the step of a turn, (turn - bend) x = turned (m, F), beyond `most`."""
    step = np.diff(turned, axis=1)
    size = np.sqrt(np.sum(step**2, axis=0))
    over = np.flatnonzero(size > most)
    if not len(over):
        return 0.0
    along, beyond = step[:, over] / size[over], (size[over] - most) / sigma
    if out is not None:
        before, after = (
            (turn.T @ along - (0.0 if bend is None else np.einsum("cf,cif->if", along, bend[..., at]))) / sigma
            for at in (over, over + 1)
        )
        out.gradient[own, over] -= beyond * before
        out.gradient[own, over + 1] += beyond * after
        main, next_ = out.main[:, own, own], out.next[:, own, own]
        main[over] += np.einsum("if,jf->fij", before, before)
        main[over + 1] += np.einsum("if,jf->fij", after, after)
        next_[over] -= np.einsum("if,jf->fij", before, after)
    return 0.5 * float(np.sum(beyond**2))


def rise_term(problem: Problem, k: int, at: LegState, own: slice, out: System | None) -> float:
    """Evaluate RISE of a foot, and add its derivatives to a system.

    Args:
        problem: the clip's.
        k: which leg.
        at: that leg in a state.
        own: the rows of its unknowns in the system.
        out: the system, if the derivatives are wanted.
    """
    rise = problem.pins[k][-1].rise
    if rise is None or at.hinge is None:
        return 0.0
    toes = at.places[TIP] - at.places[TOE]
    over = np.flatnonzero(toes[1] > rise)
    if not len(over):
        return 0.0
    weight, beyond = RATE * problem.frame_time / (RISE * problem.leg_length) ** 2, (toes[1] - rise)[over]
    if out is not None:
        row = np.zeros((LEG, len(over)))
        row[W] = at.turn[2][:, over] * toes[0, over] - at.turn[0][:, over] * toes[2, over]  # (turn dw) x toes, along y
        row[B] = at.hinge[1, over]
        out.gradient[own, over] += weight * beyond * row
        main = out.main[:, own, own]
        main[over] += weight * np.einsum("if,jf->fij", row, row)
    return float(0.5 * weight * np.sum(beyond**2))


def root_term(problem: Problem, x: Floats, out: System | None) -> float:
    """Evaluate FAR of the root (3, F) [m], and add its derivatives to a system."""
    return _far(np.eye(3), x, slice(0, ROOT), *root_bound(problem), problem, out)


def root_bound(problem: Problem) -> tuple[Floats, Floats]:
    """Compute the bound on the root's shift, and the standard deviation of the excess, (F,) [m] each."""
    size, every = problem.leg_length, np.ones(problem.frames)
    return problem.costs.root_farthest * size * every, FAR_ROOT * size * every


def _far(
    turn: Floats, x: Floats, own: slice, far: Floats, sigma: Floats, problem: Problem, out: System | None
) -> float:
    """Add FAR: one-sided cost of turn x, (3, n) times some unknowns (n, F), beyond `far`; `sigma` is the excess's."""
    turned = turn @ x
    size = np.sqrt(np.sum(turned**2, axis=0))
    over = np.flatnonzero(size > far)
    if not len(over):
        return 0.0
    weight = RATE * problem.frame_time / sigma[over] ** 2
    along, beyond = turned[:, over] / size[over], size[over] - far[over]
    row = turn.T @ along
    if out is not None:
        out.gradient[own, over] += weight * beyond * row
        # also at right angles to the turn: its length is curved, and a step aside would leave the bounds again
        aside = beyond / size[over]
        main = out.main[:, own, own]
        block = (1.0 - aside) * np.einsum("if,jf->ijf", row, row) + aside * (turn.T @ turn)[..., None]
        main[over] += (weight * block).transpose(2, 0, 1)
    return 0.5 * float(np.sum(weight * beyond**2))

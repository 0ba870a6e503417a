"""The objective of enforcement: a sum of terms over the whole clip, each with its weight and its derivative.

Unknowns of frame t (see `leg`):  d of the root;  q, k, w, b of each leg;  x = (d, q, k, w, b, q, k, w, b, ...).

Minimised:   1/2 sum_t r dt ( |x / s0|^2 + |x'' / s2|^2 )     NEAR    stay near the capture, and near its accelerations
           + c sum_t h |p(t + 1) - p(t) - slip|               SLIP    what stands does not move: friction, c a metre
           + 1/2 sum_t r dt a ((p_y - level) / sl)^2          LEVEL   what stands is drawn to its floor
           + 1/2 sum_t r dt (max(0, lowest - p_y) / sf)^2     FLOOR   nothing is below the floor
           + FLOOR of a skin's vertices, see `vertices`
           + 1/2 sum_t r dt (max(0, least - flexion) / sk)^2  KNEE    no knee is straighter than the clip's own
           + 1/2 sum_t (max(0, |y(t + 1) - y(t)| - v dt) / sv)^2   SPEED   no joint turns much faster than captured
           + 1/2 sum_t r dt (max(0, |y| - far) / sd)^2        FAR     joints stay near; y = d, q, k, w - q, b
           + 1/2 sum_t r dt |(p - place) / sp|^2              PLACE   what was asked for
           + 1/2 |x / sc|^2 at a cut                          CUT     after a T-pose the correction starts small

SLIP is an L1 norm: where holding costs more than sliding, the foot slides there, and only there. It is solved by
reweighting (Weiszfeld): 1/2 c h |s|^2 / (|s_before| + eps), a bound from above that touches at s_before.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from footfix.enforce.assembly import Pull, add_points
from footfix.enforce.leg import ANKLE, LEG, ROOT, B, K, LegTracks, Q, W
from footfix.enforce.pins import Pins
from footfix.enforce.posed import places_of, posed
from footfix.enforce.vertices import Vertices, add_floor, floor_cost, floor_weight
from footfix.motion.clip import Bools, Floats, Ints

# r: the standard deviations below are those of independent frames, so many a second
_RATE = 60.0
_UPRIGHT = 0.05  # weight of slip up and down against slip over the floor: a foot rolls
_NOISY = 3.0  # times a cost's acceleration that noise may add to it, if it may be quick motion, too
_STATIC = 0.03  # [leg lengths/s] of slip up to which static friction holds
_GROWN = 0.9  # [m] leg length of the figure whose accelerations the defaults are


@dataclass(frozen=True, kw_only=True)
class CostParams:
    """What each departure from the capture costs: standard deviations, each of which costs as much as another.

    Args:
        slide: cost of slide; more holds more, at the price of the joints' speed [1/leg length].
        root: of the root over the floor [leg lengths].
        root_height: of the root up and down [leg lengths].
        root_acceleration: of the root's acceleration [leg lengths/s^2].
        root_farthest: beyond this the root hardly goes [leg lengths].
        line: of the line from hip to ankle [degrees].
        knee: of the knee's flexion [degrees].
        foot: of the foot in the world [degrees].
        toes: of the toes' bend [degrees].
        line_acceleration: of that line's acceleration [degrees/s^2].
        knee_acceleration: of that of the knee's flexion [degrees/s^2].
        foot_acceleration: of that of the foot [degrees/s^2].
        toes_acceleration: of that of the toes' bend [degrees/s^2].
        line_farthest: beyond this the line from hip to ankle hardly turns [degrees].
        ankle_farthest: beyond this the foot hardly turns against the shank, and the knee hardly bends [degrees].
        toes_farthest: beyond this the toes hardly bend [degrees].
        noticed: a fault that viewers notice: 21 mm of a grown-up (Prazak & O'Sullivan 2011) [leg lengths].
        unnoticed_turn: farther than this a joint hardly turns for a smaller fault; for more, in proportion [degrees].
        speed: by which a joint may turn faster than captured [degrees/s].
        level: of a plant from its floor, in a tenth of a second [leg lengths].
    """

    slide: float = 11000.0
    root: float = 0.09
    root_height: float = 0.055
    root_acceleration: float = 1.1
    root_farthest: float = 0.06
    line: float = 5.0
    knee: float = 3.0
    foot: float = 4.5
    toes: float = 10.0
    line_acceleration: float = 200.0
    knee_acceleration: float = 200.0
    foot_acceleration: float = 300.0
    toes_acceleration: float = 500.0
    line_farthest: float = 12.0
    ankle_farthest: float = 25.0
    toes_farthest: float = 40.0
    noticed: float = 0.023
    unnoticed_turn: float = 2.0
    speed: float = 130.0
    level: float = 0.0045


# Bounds, as standard deviations of what is beyond them.
_FLOOR, _PLACE, _FAR_ROOT = 0.0033, 0.0011, 0.003  # [leg lengths]
_KNEE, _SPEED, _FAR_TURN = 0.3, 0.15, 0.5  # [degrees]
_TOES = 1.3  # times as far as other joints toes bend for what is not noticed
_CUT, _CUT_ROOT = 0.3, 0.001  # [degrees], [leg lengths] in 1/120 s


@dataclass(frozen=True, eq=False)
class Problem:
    """One clip's objective.

    Args:
        legs: as captured, F frames.
        pins: for each leg those of its points.
        frame_time: [s].
        leg_length: [m].
        costs: the standard deviations.
        noise: (U,) [m, rad] how much of each unknown's capture is new in every frame,
        white: (U,) and whether that is all there is to its quickest changes.
        root_moves: whether the root may.
        fault: (F,) [m] how far what is to stand nearby slides, or is from its floor.
        cut: whether a T-pose was cut off before the first frame, and after the last.
        onward: whether the motion goes on after the last frame, in a stream.
        skins: vertices of the foot of some legs, by the leg's index.
    """

    legs: tuple[LegTracks, ...]
    pins: tuple[tuple[Pins, ...], ...]
    frame_time: float
    leg_length: float
    costs: CostParams
    noise: Floats
    white: Bools
    fault: Floats
    root_moves: bool = True
    cut: tuple[bool, bool] = (False, False)
    onward: bool = False
    skins: Mapping[int, Vertices] = field(default_factory=dict)

    @property
    def frames(self) -> int:
        return len(self.legs[0].flexion)

    @property
    def unknowns(self) -> int:
        return ROOT + LEG * len(self.legs)

    def columns(self, leg: int) -> slice:
        """Get the place of a leg's eight unknowns in a state."""
        return slice(ROOT + LEG * leg, ROOT + LEG * (leg + 1))

    def free(self) -> Bools:
        """Mark the unknowns that may differ from zero, (U,)."""
        free = np.ones(self.unknowns, dtype=np.bool_)
        free[:ROOT] = self.root_moves
        for k, leg in enumerate(self.legs):
            own = free[self.columns(k)]
            own[:] = leg.turns
            own[B] = leg.bends and leg.turns
        return free

    def farthest(self, most: float) -> Floats:
        """Bound how far a joint goes freely, (F,) [rad]: in proportion to the fault, at most `most` [degrees]."""
        seen = np.maximum(self.fault / (self.costs.noticed * self.leg_length), 1.0)
        return np.radians(np.minimum(self.costs.unnoticed_turn * seen, most))

    def near(self) -> tuple[Floats, Floats]:
        """Compute the standard deviations of NEAR: s0 [m, rad] and s2 [m/s^2, rad/s^2], both (U,)."""
        c, size = self.costs, self.leg_length
        deg = np.pi / 180.0
        s0 = np.concatenate([
            size * np.array([c.root, c.root_height, c.root]),
            *[deg * np.repeat([c.line, c.knee, c.foot, c.toes], [3, 1, 3, 1])] * len(self.legs),
        ])  # fmt: skip
        accelerations = [c.line_acceleration, c.knee_acceleration, c.foot_acceleration, c.toes_acceleration]
        s2 = np.concatenate([
            np.full(3, size * c.root_acceleration),
            *[deg * np.repeat(accelerations, [3, 1, 3, 1])] * len(self.legs),
        ])  # fmt: skip
        # motions of similar figures: accelerations of joints go with 1 / size, those of places are the same
        s2 *= _GROWN / size
        # what the capture's own noise accelerates is not held to: second differences have 1 + 4 + 1 times its variance
        noise = np.sqrt(6.0) * self.noise / self.frame_time**2
        return s0, np.hypot(s2, np.where(self.white, noise, np.minimum(noise, _NOISY * s2)))


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
    out = System(np.arange(U), *_empty(U, F), *_near(problem, x, np.arange(U)))
    cost = out.cost + _beyond(np.eye(3), x[:ROOT], slice(0, ROOT), *_root_bound(problem), problem, out)
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
    cost = _near(problem, x, rows)[1]
    if root:
        cost += _beyond(np.eye(3), x[:ROOT], slice(0, ROOT), *_root_bound(problem), problem, None)
    for k, leg in enumerate(problem.legs):
        own = x[problem.columns(k)]
        places = places_of(leg, x[:ROOT], own)
        pulls = (_pull(problem, pin, p, eps, static) for p, pin in zip(places, problem.pins[k], strict=True))
        cost += sum(pull.cost for pull in pulls)
        cost += _bounds(problem, k, own, 0, None)
        if k in problem.skins:
            weight = floor_weight(problem.frame_time, problem.leg_length, _RATE)
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
    cost = _bounds(problem, k, x[own], ROOT - first, out)
    pulls = [_pull(problem, pin, p, eps, static) for p, pin in zip(at.places, problem.pins[k], strict=True)]
    cost += sum(pull.cost for pull in pulls)
    add_points(at, pulls, out.gradient, out.main, out.next, root=root)
    if k in problem.skins:
        weight = floor_weight(problem.frame_time, problem.leg_length, _RATE)
        cost += add_floor(problem.skins[k], leg, at, x[own], weight, out.gradient, out.main)
    if root:
        return System(rows, out.gradient, out.main, out.next, out.near, cost)
    near, stays = _near(problem, x, rows)
    return System(rows, out.gradient + product(near, x[rows]), out.main, out.next, near, cost + stays)


def _pull(problem: Problem, pin: Pins, place: Floats, eps: float, static: float) -> Pull:
    """SLIP, LEVEL, FLOOR and PLACE of a point at (3, F) [m]."""
    size, per_frame = problem.leg_length, _RATE * problem.frame_time
    force, stiff = np.zeros_like(place), np.zeros_like(place)
    # SLIP: c h |s|, s = p(t + 1) - p(t) - slip, less of it up and down
    slip = np.diff(place, axis=1) - pin.slip  # (3, F - 1) [m]
    long = np.sqrt(slip[0] ** 2 + (_UPRIGHT * slip[1]) ** 2 + slip[2] ** 2)
    c = problem.costs.slide / size * pin.hold
    cost = float(np.sum(c * _smooth(long, eps)))  # what the reweighting descends on
    step = c / (long + eps) * np.array([[1.0], [_UPRIGHT**2], [1.0]])
    if static > 1.0:  # over the floor only
        flat, still = np.hypot(slip[0], slip[2]), _STATIC * size * problem.frame_time
        more, total = _friction(_smooth(flat, eps) / still)
        cost += float(np.sum(c * (static - 1.0) * still * total))
        step += c * (static - 1.0) * more / (flat + eps) * np.array([[1.0], [0.0], [1.0]])
    force[:, 1:] += step * slip
    force[:, :-1] -= step * slip
    stiff[:, 1:] += step
    stiff[:, :-1] += step
    # LEVEL, FLOOR
    level = np.where(pin.stands, per_frame * pin.draw / (problem.costs.level * size) ** 2, 0.0)
    off, low = place[1] - pin.level, np.maximum(pin.lowest - place[1], 0.0)
    floor = per_frame / (_FLOOR * size) ** 2 * (low > 0.0)
    cost += 0.5 * float(np.sum(level * off**2 + floor * low**2))
    force[1] += level * off - floor * low
    stiff[1] += level + floor
    # PLACE
    asked = per_frame * pin.placed / (_PLACE * size) ** 2
    away = place - pin.place
    cost += 0.5 * float(np.sum(asked * away**2))
    return Pull(cost, force + asked * away, stiff + asked, step)


def _smooth(slip: Floats, eps: float) -> Floats:
    """Round the corner of |slip| at zero, so that its derivative is slip / (slip + eps)."""
    return np.asarray(slip - eps * np.log1p(slip / eps))


def _friction(slip: Floats) -> tuple[Floats, Floats]:
    """Tell how much more static friction holds than kinetic, and its integral, by slip in units of what it holds.

    1 / (1 + u^4) is nearly 1 for what stands and nearly 0 for what slides.
    """
    root, u = np.sqrt(2.0), slip
    logs = np.log((u * u + root * u + 1.0) / (u * u - root * u + 1.0))
    turns = 2.0 * (np.arctan(root * u + 1.0) + np.arctan(root * u - 1.0))
    return 1.0 / (1.0 + u**4), (logs + turns) / (4.0 * root)


def _near(problem: Problem, x: Floats, rows: Ints) -> tuple[Floats, float]:
    """NEAR and CUT of some unknowns: their bands (3, n, F), and what they cost."""
    s0, s2 = (each[rows] for each in problem.near())
    dt, F = problem.frame_time, problem.frames
    stay = _RATE * dt / s0**2  # (n,)
    calm = _RATE * dt / s2**2 / dt**4
    near = np.zeros((3, len(rows), F))
    near[0] += stay[:, None]
    if F > 2:  # D2' D2
        for offset, weight in ((0, 1.0), (1, 4.0), (2, 1.0)):
            near[0, :, offset : F - 2 + offset] += weight * calm[:, None]
        for offset in (0, 1):
            near[1, :, offset : F - 2 + offset] -= 2.0 * calm[:, None]
        near[2, :, : F - 2] += calm[:, None]
    sigma = np.where(rows < ROOT, _CUT_ROOT * problem.leg_length, np.radians(_CUT)) * 120.0 * dt
    for end, frame in zip(problem.cut, (0, F - 1), strict=True):
        if end:
            near[0, :, frame] += 1.0 / sigma**2
    if problem.onward and F > 2:
        _go_on(near, s0, s2, dt)
    return near, 0.5 * float(np.sum(x[rows] * product(near, x[rows])))


def _go_on(near: Floats, s0: Floats, s2: Floats, dt: float) -> None:
    """Add what the way back from the last frame's state x and speed v costs, where nothing is planted any more.

    The least integral of r ((x / s0)^2 + (x'' / s2)^2) from then on is r (s2/s0 p x^2 + 2 x v / (s0 s2) + p v^2),
    p = sqrt(2 / (s0 s2)) / s2. Source: the linear-quadratic regulator of a double integrator (Riccati's equation).
    """
    both, fast = 1.0 / (s0 * s2) / dt, np.sqrt(2.0 / (s0 * s2)) / s2 / dt**2
    near[0, :, -1] += _RATE * (s2 / s0 * fast * dt**2 + 2.0 * both + fast)
    near[0, :, -2] += _RATE * fast
    near[1, :, -2] -= _RATE * (both + fast)


def product(bands: Floats, x: Floats) -> Floats:
    """Multiply NEAR's matrix (3, n, F) by a state, (n, F)."""
    out = bands[0] * x
    for k in (1, 2):
        out[:, k:] += bands[k, :, :-k] * x[:, :-k]
        out[:, :-k] += bands[k, :, :-k] * x[:, k:]
    return np.asarray(out)


def _bounds(problem: Problem, k: int, x: Floats, base: int, out: System | None) -> float:
    """KNEE, SPEED and FAR of a leg with unknowns x (8, F), which begin at row `base` of a system.

    While the knee bends by k, thigh and shank turn by k / 2 to either side of the line from hip to ankle: so the hip
    turns by about q - k / 2 axis in its parent's frame, the ankle by w - q - k / 2 axis.
    """
    leg, own, c = problem.legs[k], slice(base, base + LEG), problem.costs
    weight = _RATE * problem.frame_time / np.radians(_KNEE) ** 2
    lacks = np.maximum(leg.least - leg.flexion - x[K], 0.0)
    cost = float(0.5 * weight * np.sum(lacks**2))
    if out is not None:
        out.gradient[base + K] -= weight * lacks
        out.main[base + K, base + K] += weight * (lacks > 0.0)
    q, w, one = np.zeros((3, LEG)), np.zeros((3, LEG)), np.eye(3)
    q[:, Q], w[:, W] = one, one
    knee = np.zeros((1, LEG))
    knee[0, K] = 1.0
    half = 0.5 * leg.axis * x[K]  # (3, F)
    axis = np.zeros((3, LEG, problem.frames))
    axis[:, K] = 0.5 * leg.axis
    most, sv = np.radians(c.speed) * problem.frame_time, np.radians(_SPEED)
    for turn, bend, off in ((q, axis, half), (knee, None, 0.0), (w - q, axis, half)):
        cost += _fast(turn, bend, turn @ x - off, own, most, sv, out)
    toes = np.zeros((1, LEG))
    toes[0, B] = 1.0 / _TOES
    bounds = ((q, c.line_farthest), (knee, c.ankle_farthest), (w - q, c.ankle_farthest), (toes, c.toes_farthest))
    for turn, most in bounds:
        cost += _beyond(turn, x, own, problem.farthest(most), np.radians(_FAR_TURN), problem, out)
    return cost


def _fast(
    turn: Floats, bend: Floats | None, turned: Floats, own: slice, most: float, sigma: float, out: System | None
) -> float:
    """One-sided cost of the step of some turn, (turn - bend) x = turned (m, F), where it is longer than `most`."""
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
        main, next_ = out.main[own, own], out.next[own, own]
        main[..., over] += np.einsum("if,jf->ijf", before, before)
        main[..., over + 1] += np.einsum("if,jf->ijf", after, after)
        next_[..., over] -= np.einsum("if,jf->ijf", after, before)
    return 0.5 * float(np.sum(beyond**2))


def _root_bound(problem: Problem) -> tuple[Floats, float]:
    """(F,) [m], [m] how far the root goes freely, and the standard deviation beyond."""
    far = problem.costs.root_farthest * problem.leg_length
    return np.full(problem.frames, far), _FAR_ROOT * problem.leg_length


def _beyond(
    turn: Floats, x: Floats, own: slice, far: Floats, sigma: float, problem: Problem, out: System | None
) -> float:
    """FAR: one-sided cost of turn x, (3, n) times some unknowns (n, F), where it is longer than `far`."""
    turned = turn @ x
    size = np.sqrt(np.sum(turned**2, axis=0))
    over = np.flatnonzero(size > far)
    if not len(over):
        return 0.0
    weight = _RATE * problem.frame_time / sigma**2
    along, beyond = turned[:, over] / size[over], size[over] - far[over]
    row = turn.T @ along
    if out is not None:
        out.gradient[own, over] += weight * beyond * row
        # across the turn, too: its length is curved, and a step aside would lead out of bounds again
        aside = beyond / size[over]
        main = out.main[own, own]
        block = (1.0 - aside) * np.einsum("if,jf->ijf", row, row) + aside * (turn.T @ turn)[..., None]
        main[..., over] += weight * block
    return 0.5 * weight * float(np.sum(beyond**2))

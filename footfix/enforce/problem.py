"""The objective of enforcement: a sum of terms over the whole clip, each with its weight and its derivative.

Unknowns of frame t (see `leg`):  d of the root;  q, k, w, b of each leg;  x = (d, q, k, w, b, q, k, w, b, ...).

Minimised:   1/2 sum_t r dt ( |x / s0|^2 + |x'' / s2|^2 )     NEAR    stay near the capture, and near its accelerations
           + c sum_t h |p(t + 1) - p(t) - slip|               SLIP    what stands does not move: friction, c a metre
           + 1/2 sum_t r dt a ((p_y - level) / sl)^2          LEVEL   what stands is drawn to its floor
           + 1/2 sum_t r dt (max(0, lowest - p_y) / sf)^2     FLOOR   nothing is below the floor
           + 1/2 sum_t r dt (max(0, least - flexion) / sk)^2  KNEE    no knee is straighter than the clip's own
           + 1/2 sum_t (max(0, |x(t + 1) - x(t)| - v dt) / sv)^2   SPEED   no joint turns much faster than captured
           + 1/2 sum_t r dt (max(0, |d| - far) / sd)^2        ROOT    the root stays where it was
           + 1/2 sum_t r dt |(p - place) / sp|^2              PLACE   what was asked for
           + 1/2 |x / sc|^2 at a cut                          CUT     where a T-pose was cut off, the correction starts small

SLIP is an L1 norm: where holding costs more than sliding, the foot slides there, and only there. It is solved by
reweighting (Weiszfeld): 1/2 c h |s|^2 / (|s_before| + eps), a bound from above that touches at s_before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.leg import LEG, ROOT, B, K, LegTracks, Q, W, posed
from footfix.enforce.pins import Pins
from footfix.motion.clip import Bools, Floats, Ints

# r: the standard deviations below are those of independent frames, so many a second
_RATE = 60.0
_UPRIGHT = 0.05  # weight of slip up and down against slip over the floor: a foot rolls
_NOISY = 3.0  # times a cost's acceleration that noise may add to it, if it may be quick motion, too
_STATIC = 0.03  # [leg lengths/s] of slip up to which static friction holds
_GROWN = 0.9  # [m] leg length of the figure whose accelerations the defaults are


@dataclass(frozen=True, kw_only=True)
class CostParams:
    """What each departure from the capture costs: standard deviations. A turn of one of them costs as much as another."""

    slide: float = 11000.0  # cost of a leg length of slide; more holds more, at the price of the joints' speed
    root: float = 0.09  # [leg lengths] of the root over the floor
    root_height: float = 0.055  # [leg lengths] of the root up and down
    root_acceleration: float = 1.1  # [leg lengths/s^2]
    root_farthest: float = 0.06  # [leg lengths] beyond this the root hardly goes
    line: float = 5.0  # [degrees] of the line from hip to ankle
    knee: float = 3.0  # [degrees] of the knee's flexion
    foot: float = 4.5  # [degrees] of the foot in the world
    toes: float = 10.0  # [degrees] of the toes' bend
    line_acceleration: float = 200.0  # [degrees/s^2]
    knee_acceleration: float = 200.0  # [degrees/s^2]
    foot_acceleration: float = 300.0  # [degrees/s^2]
    toes_acceleration: float = 500.0  # [degrees/s^2]
    line_farthest: float = 12.0  # [degrees] beyond this the line from hip to ankle hardly turns
    ankle_farthest: float = 25.0  # [degrees] beyond this the foot hardly turns against the shank
    speed: float = 130.0  # [degrees/s] by which a joint may turn faster than captured
    level: float = 0.0045  # [leg lengths] of a plant from its floor, in a tenth of a second


# Bounds, as standard deviations of what is beyond them.
_FLOOR, _PLACE, _FAR_ROOT = 0.0033, 0.0011, 0.005  # [leg lengths]
_KNEE, _SPEED, _FAR_TURN = 0.3, 0.15, 2.0  # [degrees]
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
        cut: whether a T-pose was cut off before the first frame, and after the last.
    """

    legs: tuple[LegTracks, ...]
    pins: tuple[tuple[Pins, ...], ...]
    frame_time: float
    leg_length: float
    costs: CostParams
    noise: Floats
    white: Bools
    root_moves: bool = True
    cut: tuple[bool, bool] = (False, False)

    @property
    def frames(self) -> int:
        return len(self.legs[0].flexion)

    @property
    def unknowns(self) -> int:
        return ROOT + LEG * len(self.legs)

    def columns(self, leg: int) -> slice:
        """Where a leg's eight unknowns stand in a state."""
        return slice(ROOT + LEG * leg, ROOT + LEG * (leg + 1))

    def free(self) -> Bools:
        """(U,) which unknowns may differ from zero."""
        free = np.ones(self.unknowns, dtype=np.bool_)
        free[:ROOT] = self.root_moves
        for k, leg in enumerate(self.legs):
            own = free[self.columns(k)]
            own[:] = leg.turns
            own[B] = leg.bends and leg.turns
        return free

    def near(self) -> tuple[Floats, Floats]:
        """(U,), (U,) the standard deviations s0 [m, rad] and s2 [m/s^2, rad/s^2] of NEAR."""
        c, size = self.costs, self.leg_length
        deg = np.pi / 180.0
        s0 = np.concatenate([
            size * np.array([c.root, c.root_height, c.root]),
            *[deg * np.repeat([c.line, c.knee, c.foot, c.toes], [3, 1, 3, 1])] * len(self.legs),
        ])  # fmt: skip
        s2 = np.concatenate([
            np.full(3, size * c.root_acceleration),
            *[deg * np.repeat([c.line_acceleration, c.knee_acceleration, c.foot_acceleration, c.toes_acceleration], [3, 1, 3, 1])]
            * len(self.legs),
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
        gradient: (U, F).
        main: (U, U, F) blocks of each frame with itself.
        next: (U, U, F - 1) blocks of each frame's successor (rows) with it (columns).
        near: (3, U, F) the main diagonal, and the first and second one below it, in frames, of NEAR.
        cost: the objective there.
    """

    gradient: Floats
    main: Floats
    next: Floats
    near: Floats
    cost: float


def system(problem: Problem, x: Floats, eps: float, static: float = 1.0) -> System:
    """Linearise the objective.

    Args:
        problem: the clip's.
        x: (U, F) a state.
        eps: [m] of slip below which SLIP is a parabola.
        static: times as much as sliding what hardly moves is held.
    """
    U, F = x.shape
    main, next_, gradient = np.zeros((U, U, F)), np.zeros((U, U, F - 1)), np.zeros((U, F))
    out = System(gradient, main, next_, np.zeros((3, U, F)), 0.0)
    cost = _near(problem, x, out) + _speed(problem, x, out) + _far(problem, x, out)
    for k in range(len(problem.legs)):
        cost += _points(problem, k, x, eps, static, out) + _knee(problem, k, x, out)
    return System(gradient, main, next_, out.near, cost)


def objective(problem: Problem, x: Floats, eps: float) -> float:
    """Evaluate the objective at a state (U, F), with SLIP a parabola below `eps` [m]."""
    return system(problem, x, eps).cost


def _near(problem: Problem, x: Floats, out: System) -> float:
    s0, s2 = problem.near()
    dt, F = problem.frame_time, problem.frames
    stay = _RATE * dt / s0**2  # (U,)
    calm = _RATE * dt / s2**2 / dt**4
    out.near[0] += stay[:, None]
    if F > 2:  # D2' D2
        for offset, weight in ((0, 1.0), (1, 4.0), (2, 1.0)):
            out.near[0, :, offset : F - 2 + offset] += weight * calm[:, None]
        for offset in (0, 1):
            out.near[1, :, offset : F - 2 + offset] -= 2.0 * calm[:, None]
        out.near[2, :, : F - 2] += calm[:, None]
    for end, frame in zip(problem.cut, (0, F - 1), strict=True):
        if end:
            s = np.full(len(x), np.radians(_CUT))
            s[:ROOT] = _CUT_ROOT * problem.leg_length
            out.near[0, :, frame] += 1.0 / (s * 120.0 * dt) ** 2
    ax = product(out.near, x)
    out.gradient[:] += ax
    return 0.5 * float(np.sum(x * ax))


def product(bands: Floats, x: Floats) -> Floats:
    """(U, F) NEAR's matrix (3, U, F) times a state."""
    out = bands[0] * x
    for k in (1, 2):
        out[:, k:] += bands[k, :, :-k] * x[:, :-k]
        out[:, :-k] += bands[k, :, :-k] * x[:, k:]
    return np.asarray(out)


def _speed(problem: Problem, x: Floats, out: System) -> float:
    """SPEED: one-sided, on the turn of hip, knee and ankle from frame to frame, in their parents' frames.

    While the knee bends by k, thigh and shank turn by k / 2 to either side of the line from hip to ankle: so the hip
    turns by about q - k / 2 axis, the ankle by w - q - k / 2 axis.
    """
    most, sv = np.radians(problem.costs.speed) * problem.frame_time, np.radians(_SPEED)
    one = np.eye(3)
    cost = 0.0
    for k, leg in enumerate(problem.legs):
        q, w = np.zeros((3, LEG)), np.zeros((3, LEG))
        q[:, Q], w[:, W] = one, one
        half = np.zeros((3, LEG, problem.frames))
        half[:, K] = 0.5 * leg.axis
        knee = np.zeros((1, LEG, 1))
        knee[0, K] = 1.0
        for turn in (q[..., None] - half, knee, (w - q)[..., None] - half):
            cost += _hinge(np.broadcast_to(turn, (*turn.shape[:2], problem.frames)), x, problem.columns(k), most, sv, out)
    return cost


def _far(problem: Problem, x: Floats, out: System) -> float:
    """FAR: one-sided, on how far the root goes, each leg's line turns, and each foot turns against its shank."""
    size, c = problem.leg_length, problem.costs
    one = np.eye(3)
    cost = _beyond(one, x, slice(0, ROOT), c.root_farthest * size, _FAR_ROOT * size, problem, out)
    line, ankle = np.zeros((3, LEG)), np.zeros((3, LEG))
    line[:, Q], ankle[:, W], ankle[:, Q] = one, one, -one
    for k in range(len(problem.legs)):
        own = problem.columns(k)
        for turn, far in ((line, c.line_farthest), (ankle, c.ankle_farthest)):
            cost += _beyond(turn, x, own, np.radians(far), np.radians(_FAR_TURN), problem, out)
    return cost


def _beyond(
    turn: Floats, x: Floats, own: slice, far: float, sigma: float, problem: Problem, out: System
) -> float:
    """One-sided cost of turn x, (3, n) times some unknowns, where it is longer than `far`."""
    turned = turn @ x[own]
    size = np.sqrt(np.sum(turned**2, axis=0))
    over = np.flatnonzero(size > far)
    if not len(over):
        return 0.0
    weight = _RATE * problem.frame_time / sigma**2
    row, beyond = turn.T @ (turned[:, over] / size[over]), size[over] - far
    out.gradient[own, over] += weight * beyond * row
    main = out.main[own, own]
    main[..., over] += weight * np.einsum("if,jf->ijf", row, row)
    return 0.5 * weight * float(np.sum(beyond**2))


def _hinge(turn: Floats, x: Floats, own: slice, most: float, sigma: float, out: System) -> float:
    """One-sided cost of the step of turn x, (n, LEG, F) times a leg's unknowns, where it is longer than `most`."""
    turned = np.einsum("cif,if->cf", turn, x[own])
    step = np.diff(turned, axis=1)
    size = np.sqrt(np.sum(step**2, axis=0))
    over = np.flatnonzero(size > most)
    if not len(over):
        return 0.0
    along, beyond = step[:, over] / size[over], (size[over] - most) / sigma
    before, after = (np.einsum("cf,cif->if", along, turn[..., at]) / sigma for at in (over, over + 1))
    out.gradient[own, over] -= beyond * before
    out.gradient[own, over + 1] += beyond * after
    main, next_ = out.main[own, own], out.next[own, own]
    main[..., over] += np.einsum("if,jf->ijf", before, before)
    main[..., over + 1] += np.einsum("if,jf->ijf", after, after)
    next_[..., over] -= np.einsum("if,jf->ijf", after, before)
    return 0.5 * float(np.sum(beyond**2))


def _knee(problem: Problem, k: int, x: Floats, out: System) -> float:
    """KNEE: one-sided, on the knee's flexion."""
    leg, row = problem.legs[k], problem.columns(k).start + K
    weight = _RATE * problem.frame_time / np.radians(_KNEE) ** 2
    lacks = np.maximum(leg.least - leg.flexion - x[row], 0.0)
    out.gradient[row] -= weight * lacks
    out.main[row, row] += weight * (lacks > 0.0)
    return float(0.5 * weight * np.sum(lacks**2))


def _points(problem: Problem, k: int, x: Floats, eps: float, static: float, out: System) -> float:
    """SLIP, LEVEL, FLOOR and PLACE of all points of a leg."""
    leg, own = problem.legs[k], problem.columns(k)
    at = posed(leg, x[:ROOT], x[own])
    n = ROOT + LEG
    main, next_, gradient = np.zeros((n, n, problem.frames)), np.zeros((n, n, problem.frames - 1)), np.zeros((n, problem.frames))
    size, cost = problem.leg_length, 0.0
    per_frame = _RATE * problem.frame_time
    for place, J, pin in zip(at.places, at.jacobians, problem.pins[k], strict=True):
        # SLIP
        s = np.diff(place, axis=1) - pin.slip  # (3, F - 1) [m]
        s[1] *= _UPRIGHT
        long = np.sqrt(np.sum(s**2, axis=0))
        c = problem.costs.slide / size * pin.hold
        cost += float(np.sum(c * (long - eps * np.log1p(long / eps))))  # what the reweighting descends on
        some = np.flatnonzero(c)
        if len(some):
            slow = 1.0 + (static - 1.0) / (1.0 + (long[some] / (_STATIC * size * problem.frame_time)) ** 4)
            w = c[some] / (long[some] + eps) * np.stack([slow, np.full(len(some), _UPRIGHT), slow])  # (3, f)
            s, Ja, Jb = s[:, some], J[..., some], J[..., some + 1]
            s[1] /= _UPRIGHT
            w[1] *= _UPRIGHT
            wa, wb = w[:, None] * Ja, w[:, None] * Jb
            _add(main, some, wa, Ja)
            _add(main, some + 1, wb, Jb)
            next_[..., some] -= np.einsum("cif,cjf->ijf", wb, Ja)
            gradient[:, some] -= np.einsum("cif,cf->if", wa, s)
            gradient[:, some + 1] += np.einsum("cif,cf->if", wb, s)
        # LEVEL, FLOOR
        low = np.maximum(pin.lowest - place[1], 0.0)
        w = np.where(pin.stands, per_frame * pin.draw / (problem.costs.level * size) ** 2, 0.0)
        wf = per_frame / (_FLOOR * size) ** 2 * (low > 0.0)
        off = np.where(pin.draw > 0.0, place[1] - pin.level, 0.0)
        cost += 0.5 * float(np.sum(w * off**2 + wf * low**2))
        some = np.flatnonzero(w + wf)
        if len(some):
            Jy = J[1][:, some]
            _add(main, some, ((w + wf)[some] * Jy)[None], Jy[None])
            gradient[:, some] += (w * off - wf * low)[some] * Jy
        # PLACE
        some = np.flatnonzero(pin.placed)
        if len(some):
            w = per_frame * pin.placed[some] / (_PLACE * size) ** 2
            off3, Ja = place[:, some] - pin.place[:, some], J[..., some]
            cost += 0.5 * float(np.sum(w * off3**2))
            _add(main, some, w * Ja, Ja)
            gradient[:, some] += np.einsum("cif,cf->if", w * Ja, off3)
    for here, there in ((slice(0, ROOT), slice(0, ROOT)), (slice(ROOT, n), own)):
        out.gradient[there] += gradient[here]
        for here2, there2 in ((slice(0, ROOT), slice(0, ROOT)), (slice(ROOT, n), own)):
            out.main[there, there2] += main[here, here2]
            out.next[there, there2] += next_[here, here2]
    return cost


def _add(main: Floats, frames: Ints, left: Floats, right: Floats) -> None:
    """Add left' right, (C, n, f) each, to the blocks (n, n, F) of some frames."""
    main[..., frames] += np.einsum("cif,cjf->ijf", left, right)

"""Footsteps and the tracks of feet that take them: heel and ball stand exactly where and when the steps say.

A foot is a rigid sole that pitches about one of two points. While it is planted, a pitch below zero (toe up)
turns about the heel, a pitch above zero (heel up) about the toe joint, under which the ball and the toe stay
flat. So the pitch alone says which points are in contact, and the planted ones rest exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from walker_body import Body, X, Y

from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats

SLACK = 1e-9  # [s] slack in comparing frame times with contact times


@dataclass(frozen=True)
class Knot:
    """What a curve does at one time: its value, first and second derivative there."""

    time: float
    value: float
    rate: float = 0.0
    bend: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Footstep:
    """One plant of one foot, and the swing that leads to it.

    Args:
        place: (x, y, z) [m] on the floor, below the ankle of the flat foot.
        heading: [rad] where the foot points, about +y from +z.
        pitch: knots of the foot's pitch [rad] from strike to toe-off, positive with the heel up.
        hump: [m] how high the sole rises early in the swing to this step.
        clearance: [m] how high over the floor its lowest point passes in mid swing.
        touchdown: [m/s] (along the way, up) speed of the foot when it lands; what stops it is the floor.
        brake: [m/s^2] against the way, just before it lands.
        push: [m/s^2] along the way, when the foot leaves the floor towards this step.
        pivot: knots of a turn of the planted foot about its ball [rad]; allowed while the heel is up.
    """

    place: tuple[float, float, float]
    heading: float
    pitch: tuple[Knot, ...]
    hump: float = 0.05
    clearance: float = 0.02
    touchdown: tuple[float, float] = (0.0, 0.0)
    brake: float = 0.0
    push: float = 0.0
    pivot: tuple[Knot, ...] = ()

    @property
    def strike(self) -> float:
        """[s] when the foot lands."""
        return self.pitch[0].time

    @property
    def off(self) -> float:
        """[s] when it leaves."""
        return self.pitch[-1].time


@dataclass(frozen=True, eq=False)
class FootTrack:
    """One foot over F times: ankle (F, 3) [m], turn (F, 4), heading, pitch and toe bend (F,) [rad], contacts (F,)."""

    ankle: Floats
    turn: Floats
    heading: Floats
    pitch: Floats
    toe_bend: Floats
    heel_down: Bools
    ball_down: Bools


def quintic(a: Knot, b: Knot, t: Floats) -> Floats:
    """The polynomial of degree five that meets two knots in value, rate and bend, at times t."""
    T = b.time - a.time
    u = (t - a.time) / T
    p, v, w = a.value, a.rate * T, 0.5 * a.bend * T * T
    dp, dv, dw = b.value - p - v - w, b.rate * T - v - 2.0 * w, b.bend * T * T - 2.0 * w
    c3 = 10.0 * dp - 4.0 * dv + 0.5 * dw
    c4 = -15.0 * dp + 7.0 * dv - dw
    c5 = 6.0 * dp - 3.0 * dv + 0.5 * dw
    return np.asarray(p + u * (v + u * (w + u * (c3 + u * (c4 + u * c5)))))


def curve(knots: tuple[Knot, ...], t: Floats) -> Floats:
    """The piecewise quintic through knots; it keeps its first and last value outside."""
    out = np.full(t.shape, knots[0].value)
    for a, b in pairwise(knots):
        inside = t >= a.time
        if b.time > a.time:
            out[inside] = quintic(a, b, np.minimum(t[inside], b.time))
    return out


def track(body: Body, steps: tuple[Footstep, ...], t: Floats) -> FootTrack:
    """The foot that takes these steps, at times t [s], in order."""
    ball = np.zeros((len(t), 3))
    pitch, heading, toe_bend = np.zeros(len(t)), np.zeros(len(t)), np.zeros(len(t))
    heel_down, ball_down = np.zeros(len(t), np.bool_), np.zeros(len(t), np.bool_)
    for before, step in pairwise((None, *steps)):
        assert step is not None
        # times are sorted: each plant and each swing is one slice
        start = 0 if before is None else int(np.searchsorted(t, step.strike - SLACK))
        end = len(t) if step is steps[-1] else int(np.searchsorted(t, step.off + SLACK, side="right"))
        here = slice(start, end)
        rolled = curve(step.pitch, t[here])
        pitch[here] = np.where(np.abs(rolled) < 1e-12, 0.0, rolled)
        ball[here], heading[here] = _planted_ball(body, step, pitch[here], t[here])
        heel_down[here], ball_down[here] = pitch[here] <= 0.0, pitch[here] >= 0.0
        toe_bend[here] = -np.maximum(pitch[here], 0.0)
        if before is not None:
            away = slice(int(np.searchsorted(t, before.off + SLACK, side="right")), start)
            ball[away], pitch[away], heading[away], toe_bend[away] = _swing(body, before, step, t[away])
    turn = rotation.multiply(rotation.from_axis_angle(Y, heading), rotation.from_axis_angle(X, pitch))
    ankle = ball - rotation.rotate(turn, body.ball_in_foot())
    return FootTrack(ankle, turn, heading, pitch, toe_bend, heel_down, ball_down)


def _planted_ball(body: Body, step: Footstep, pitch: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Track of the toe joint (n, 3) and heading (n,) of a planted foot."""
    level = np.array([0.0, body.leg * body.ankle_height, 0.0])
    yaw = rotation.from_axis_angle(Y, np.array(step.heading))
    flat = np.array(step.place) + level + rotation.rotate(yaw, body.ball_in_foot())
    rise, ahead = _about_heel(body, np.minimum(pitch, 0.0))
    rest_rise, rest_ahead = _about_heel(body, np.zeros(1))
    forward = np.array([np.sin(step.heading), 0.0, np.cos(step.heading)])
    ball = flat + (ahead - rest_ahead)[:, None] * forward
    ball[:, 1] += rise - rest_rise
    heading = np.full(len(pitch), step.heading)
    if step.pivot:
        heading += curve(step.pivot, t)
    return ball, heading


def _about_heel(body: Body, pitch: Floats) -> tuple[Floats, Floats]:
    """Height and forward distance [m] of the toe joint from the heel's point, the foot pitched about it."""
    _, up, ahead = body.ball_in_foot() - body.heel_in_foot()
    return up * np.cos(pitch) - ahead * np.sin(pitch), up * np.sin(pitch) + ahead * np.cos(pitch)


def _edge(body: Body, step: Footstep, knot: Knot) -> tuple[Floats, Floats, Floats, float]:
    """Place, velocity, acceleration of the toe joint at one end of a plant, and the foot's heading there."""
    pitch = np.array([knot.value])
    ball, heading = _planted_ball(body, step, pitch, np.array([knot.time]))
    forward = np.array([np.sin(heading[0]), 0.0, np.cos(heading[0])])
    if knot.value >= 0.0:
        return ball[0], np.zeros(3), np.zeros(3), float(heading[0])
    rise, ahead = (float(each[0]) for each in _about_heel(body, pitch))
    up = np.array([0.0, 1.0, 0.0])
    # d/dt and d2/dt2 of (rise, ahead): the pitch turns ahead into -up
    velocity = knot.rate * (rise * forward - ahead * up)
    acceleration = knot.bend * (rise * forward - ahead * up) - knot.rate**2 * (ahead * forward + rise * up)
    return ball[0], velocity, acceleration, float(heading[0])


def _swing(body: Body, before: Footstep, step: Footstep, t: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Toe joint (n, 3), pitch, heading and toe bend (n,) between two plants."""
    a, b = before.pitch[-1], step.pitch[0]
    p0, v0, a0, h0 = _edge(body, before, a)
    p1, v1, a1, h1 = _edge(body, step, b)
    way = (p1 - p0) * [1.0, 0.0, 1.0]
    distance = float(np.linalg.norm(way))
    along = way / distance if distance > 1e-9 else np.zeros(3)
    a0 = a0 + step.push * along
    v1 = v1 + step.touchdown[0] * along
    a1 = a1 - step.brake * along
    ball = np.empty((len(t), 3))
    T = b.time - a.time
    for axis in (0, 2):
        start, end = Knot(a.time, p0[axis], v0[axis], a0[axis]), Knot(b.time, p1[axis], v1[axis], a1[axis])
        middle = Knot(a.time + 0.55 * T, p0[axis] + 0.55 * way[axis], 1.45 * way[axis] / T)
        ball[:, axis] = curve((start, middle, end), t)
    pitch = quintic(a, b, t)
    ball[:, 1] = _lift(body, before, step, np.array([p0[1], v0[1], a0[1]]), np.array([p1[1], v1[1], a1[1]]), t, pitch)
    heading = quintic(Knot(a.time, h0), Knot(b.time, h1), t)
    soft = 0.45 * T
    bend = -curve((Knot(a.time, max(a.value, 0.0), a.rate * (a.value > 0.0)), Knot(a.time + soft, 0.0)), t)
    bend -= curve((Knot(b.time - soft, 0.0), Knot(b.time, max(b.value, 0.0), b.rate * (b.value > 0.0))), t)
    return ball, pitch, heading, bend


def _lift(
    body: Body, before: Footstep, step: Footstep, start: Floats, end: Floats, t: Floats, pitch: Floats
) -> Floats:
    """Height of the toe joint (n,) [m] in the swing; `start` and `end` hold it at the plants, its rate and bend.

    What is shaped is the height of the sole's lowest point: up with the rolling foot, low past the standing
    leg, down to land. With the toe up the lowest point is the heel, and the toe joint is as much higher.
    """
    a, b = before.pitch[-1], step.pitch[0]
    T = b.time - a.time
    climb = step.place[1] - before.place[1]
    at_hump = before.place[1] + step.hump + 0.55 * max(climb, 0.0)
    at_low = before.place[1] + step.clearance + (climb if climb > 0.0 else 0.45 * climb)
    bend = 0.5 * abs(at_hump - at_low) * (np.pi / (0.36 * T)) ** 2
    (h0, v0, a0), (h1, v1, a1) = _over_lowest(body, a), _over_lowest(body, b)
    knots = (
        Knot(a.time, start[0] - h0, start[1] - v0, start[2] - a0),
        Knot(a.time + 0.24 * T, at_hump, 0.0, -bend),
        Knot(a.time + 0.60 * T, at_low, 0.0, bend),
        Knot(b.time, end[0] - h1, end[1] - v1 + step.touchdown[1], end[2] - a1),
    )
    rise, _ = _about_heel(body, _toe_up(pitch))
    return curve(knots, t) + rise


TOE_UP = 0.05  # [rad] over which the lowest point goes from the ball to the heel


def _toe_up(pitch: Floats) -> Floats:
    """The pitch where it is negative, zero where it is positive, and smooth in between (softplus)."""
    return -TOE_UP * np.logaddexp(0.0, -pitch / TOE_UP)


def _over_lowest(body: Body, knot: Knot) -> tuple[float, float, float]:
    """How far the toe joint is above the sole's lowest point, its rate and its second derivative."""
    pitch = np.array([knot.value])
    up_down, along = (float(each[0]) for each in _about_heel(body, _toe_up(pitch)))
    share = 1.0 / (1.0 + np.exp(knot.value / TOE_UP))  # d toe_up / d pitch
    rate = share * knot.rate
    bend = share * knot.bend - share * (1.0 - share) / TOE_UP * knot.rate**2
    # d rise / d pitch = -along, d along / d pitch = rise
    return up_down, -along * rate, -along * bend - up_down * rate**2

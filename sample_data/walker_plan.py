"""From what a gait is called to where and when each foot stands, and the way the pelvis goes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from walker_body import Body
from walker_feet import Footstep, Knot
from walker_gaits import GRID, MARGIN, Plan, smooth, stance_height
from walker_gaits import STYLES as STYLES
from walker_gaits import Gait as Gait
from walker_gaits import Style as Style
from walker_pieces import jump, stand

from footfix.motion.clip import Floats


@dataclass(frozen=True, eq=False)
class Way:
    """The pelvis's way over the floor: path (n, 3) [m] and heading (n,) [rad] at times on a grid (n,) [s]."""

    grid: Floats
    path: Floats
    heading: Floats

    def at(self, time: float) -> tuple[Floats, float]:
        """Place (3,) [m] and heading [rad] at one time."""
        place = np.array([np.interp(time, self.grid, self.path[:, axis]) for axis in range(3)])
        return place, float(np.interp(time, self.grid, self.heading))


def plan(body: Body, gait: Gait) -> Plan:
    """Where and when the feet stand."""
    style = STYLES[gait.name]
    grid = np.arange(-MARGIN, gait.duration + MARGIN, GRID)
    scale = body.leg / 0.88
    speed = (style.speed if gait.speed is None else np.copysign(gait.speed, style.speed)) * np.sqrt(scale)
    if gait.name == "jump":
        return jump(body, gait, style, grid)
    if gait.name == "stand":
        return stand(body, gait, style, grid)
    length = gait.step or np.sqrt(style.walk_ratio * max(abs(speed), 0.35) * scale**1.5)
    period = 2.0 * length / abs(speed) if speed else 1.3 * np.sqrt(scale)
    path, heading = _way(gait, speed, float(_strikes(gait, style, period)[-1]), grid)
    random = np.random.default_rng(gait.seed)
    way = Way(grid, path, heading)
    steps = [_footsteps(body, gait, style, side, period, speed, way, random) for side in (0, 1)]
    floor = _floor_below(steps, grid)
    path[:, 1] = smooth(floor, 0.5 * period) + body.leg * (body.ankle_height + 0.05 + stance_height(style))
    belt = (0.0, 0.0, -float(speed)) if gait.name == "treadmill" else (0.0, 0.0, 0.0)
    return Plan(style, period, (steps[0], steps[1]), grid, path, heading, np.zeros(len(grid)), belt)


def _way(gait: Gait, speed: float, last_strike: float, grid: Floats) -> tuple[Floats, Floats]:
    """The pelvis's path over the floor (n, 3) [m] and where it faces (n,) [rad]."""
    start, end = gait.rest[0], gait.duration - gait.rest[1]
    pace = np.full(len(grid), speed)
    if gait.rest[0] > 0.0:
        pace *= _step((grid - start + 0.3) / 0.9)
    if gait.rest[1] > 0.0:
        pace *= 1.0 - _step((grid - last_strike + 0.7) / 0.9)
    share = (grid - start) / max(end - start, 1e-9)
    if gait.name == "turn":
        heading = gait.turn * _step((share - 0.32) / 0.36)
    elif gait.name == "spot-turn":
        heading = gait.turn * _step((share - 0.1) / 0.8)
    elif gait.name == "curve":
        heading = gait.turn * np.clip(share, -1.0, 2.0)
    else:
        heading = np.zeros(len(grid))
    course = heading + (np.pi / 2 if gait.name == "sideways" else 0.0)
    path = np.zeros((3, len(grid))).T  # each coordinate contiguous, since it is looked up for every step
    for axis, part in ((0, np.sin(course)), (2, np.cos(course))):
        path[:, axis] = np.cumsum(pace * part) * GRID
        path[:, axis] -= np.interp(0.0, grid, path[:, axis])
    return path, heading


def _step(u: Floats) -> Floats:
    """0 to 1 as u goes from 0 to 1, with two derivatives at rest at both ends."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u**3 * (10.0 + u * (6.0 * u - 15.0)))


def _strikes(gait: Gait, style: Style, period: float) -> Floats:
    """When feet land [s], left and right in turn: from margin to margin, or between the two rests."""
    first = gait.rest[0] if gait.rest[0] > 0.0 else -MARGIN + 0.5
    last = gait.duration - gait.rest[1] if gait.rest[1] > 0.0 else gait.duration + MARGIN - 0.5
    swing = (1.0 - style.duty) * period
    count = max(int((last - first - swing) / (0.5 * period)), 2) + 1
    return np.asarray(first + swing + 0.5 * period * np.arange(count))


def _footsteps(
    body: Body, gait: Gait, style: Style, side: int, period: float, speed: float, way: Way, random: np.random.Generator
) -> tuple[Footstep, ...]:
    stance, swing = style.duty * period, (1.0 - style.duty) * period
    strikes = _strikes(gait, style, period)[side::2]
    strikes = strikes + 0.015 * period * gait.variation * random.uniform(-1.0, 1.0, len(strikes))
    offs = np.append(strikes[1:] - swing, strikes[-1] + stance)
    standing = strikes[0] - swing
    times = [(standing - stance, standing), *zip(strikes.tolist(), offs.tolist(), strict=True)]
    steps = []
    for k, (strike, off) in enumerate(times):
        from_rest = k == 0 and gait.rest[0] > 0.0
        to_rest = k == len(times) - 1 and gait.rest[1] > 0.0
        over = strike + style.over * (off - strike)
        over = float(way.grid[0]) if from_rest else float(way.grid[-1]) if to_rest else over
        wobble = gait.variation * random.normal(size=6)
        place, facing = way.at(over)
        place[1] = _stair(body, gait, side, k)
        step = _footstep(body, gait, style, side, place, facing, _roll(style, strike, off, wobble), wobble, speed)
        if from_rest:
            step = replace(step, pitch=step.pitch[2:])
        if to_rest:
            step = replace(step, pitch=step.pitch[:3])
        steps.append(step)
    return tuple(steps)


def _footstep(
    body: Body, gait: Gait, style: Style, side: int, middle: Floats, facing: float, pitch: tuple[Knot, ...],
    wobble: Floats, speed: float,
) -> Footstep:  # fmt: skip
    """A step beside the middle of the way (3,) [m]."""
    sign = 1.0 if side == 0 else -1.0
    out = sign * body.leg * (style.half_width + 0.008 * wobble[0])
    ahead = 0.012 * body.leg * wobble[1]
    at = middle + out * np.array([np.cos(facing), 0.0, -np.sin(facing)])
    at += ahead * np.array([np.sin(facing), 0.0, np.cos(facing)])
    hard = 0.0 if gait.soft else 1.0
    return Footstep(
        place=(float(at[0]), float(at[1]), float(at[2])),
        heading=facing + sign * (style.toe_out + 0.03 * wobble[2]),
        pitch=pitch,
        hump=body.leg * style.hump * float(np.exp(0.08 * wobble[3])),
        clearance=body.leg * style.clearance * float(np.exp(0.1 * wobble[4])),
        touchdown=(hard * style.touchdown[0] * abs(speed), hard * style.touchdown[1] * abs(speed)),
        brake=hard * style.brake,
        push=hard * style.push,
    )


def _roll(style: Style, strike: float, off: float, wobble: Floats) -> tuple[Knot, ...]:
    """The foot's pitch over its stance."""
    stance, mid = off - strike, style.mid_pitch
    land = style.strike_pitch * float(np.exp(0.06 * wobble[5]))
    flat, lift = strike + style.flat_at * stance, strike + style.lift_at * stance
    landing, leaving = land - mid, style.off_pitch - mid
    # the sole settles and leaves briskly, as feet do: no long creep into and out of the flat foot
    settle = np.sign(landing) * min(14.0, 2.0 * abs(landing) / (flat - strike) ** 2)
    peel = np.sign(leaving) * min(10.0, 2.0 * abs(leaving) / (off - lift) ** 2)
    rate = np.sign(leaving) * min(abs(style.off_rate), 2.4 * abs(leaving) / (off - lift))
    return (
        Knot(strike, land, style.strike_rate),
        Knot(flat, mid, 0.0, float(settle)),
        Knot(flat, mid),
        Knot(lift, mid),
        Knot(lift, mid, 0.0, float(peel)),
        Knot(off, style.off_pitch, float(rate)),
    )


def _stair(body: Body, gait: Gait, side: int, k: int) -> float:
    """Height of the floor under the k-th step of a foot: a few steps on the level, then stairs."""
    if not gait.name.startswith("stairs"):
        return 0.0
    rise = 0.19 * body.leg * (-1.0 if gait.name == "stairs-down" else 1.0)
    level = 4 if gait.rest[0] == 0.0 else 2
    return rise * float(max(2 * k + side - level, 0))


def _floor_below(steps: list[tuple[Footstep, ...]], grid: Floats) -> Floats:
    """Mean height of the places where the two feet stand, or are going to (n,) [m]."""
    heights = []
    for foot in steps:
        moments = [(foot[0].strike, foot[0].place[1])]
        for a, b in pairwise(foot):
            moments += [(a.off, a.place[1]), (b.strike, b.place[1])]
        heights.append(np.interp(grid, [t for t, _ in moments], [h for _, h in moments]))
    return np.asarray(0.5 * (heights[0] + heights[1]))

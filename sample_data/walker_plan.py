"""From what a gait is called to where and when each foot stands, and the way the pelvis goes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np
from walker_body import Body
from walker_feet import Footstep, Knot, curve

from footfix.motion.clip import Floats

GRID = 0.001  # [s] of the grid on which the body's way is found
MARGIN = 2.0  # [s] planned before and after the clip

Name = Literal[
    "walk", "run", "sprint", "forefoot-run", "turn", "curve", "backwards", "sideways", "stairs", "stairs-down",
    "jump", "stand", "tiptoe", "spot-turn", "treadmill",
]  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Gait:
    """What to make.

    Args:
        name: the kind of motion.
        speed: [m/s] along the way, for a leg of 0.88 m; None for the usual one.
        step: [m] length of a step; None for the usual one at that speed.
        duration: [s].
        fps: frames a second.
        leg: [m] from hip joint to ankle.
        seed: of the natural differences between steps.
        variation: how large these are; 0 for none, 1 for usual.
        turn: [rad] by which "turn", "curve" and "spot-turn" turn, to the left.
        rest: [s] of standing at the start and at the end.
        soft: True for feet that leave and land without a change of speed (unlike real ones).
    """

    name: Name = "walk"
    speed: float | None = None
    step: float | None = None
    duration: float = 4.0
    fps: float = 60.0
    leg: float = 0.88
    seed: int = 0
    variation: float = 1.0
    turn: float = np.pi / 2
    rest: tuple[float, float] = (0.0, 0.0)
    soft: bool = False


@dataclass(frozen=True, kw_only=True)
class Style:
    """How a gait looks. Angles [rad], lengths in legs, times as shares of the stance unless said."""

    speed: float = 1.3  # [m/s]
    walk_ratio: float = 0.384  # step length^2 / speed [m s], of a 0.88 m leg
    duty: float = 0.575  # share of the cycle that a foot stands
    over: float = 0.44  # when in the stance the pelvis passes over the ankle
    strike_pitch: float = -0.34
    strike_rate: float = 1.0  # [rad/s]
    flat_at: float = 0.17
    lift_at: float = 0.52
    mid_pitch: float = 0.0  # of the foot in mid stance, above zero on tiptoe
    off_pitch: float = 0.82
    off_rate: float = 7.5  # [rad/s]
    hump: float = 0.055
    clearance: float = 0.022
    touchdown: tuple[float, float] = (0.35, -0.10)  # as shares of the speed
    brake: float = 15.0  # [m/s^2]
    push: float = 25.0  # [m/s^2]
    half_width: float = 0.055  # between the feet
    toe_out: float = 0.10
    sway: float = 0.022
    bob: float = 0.0
    flight: float = 0.0  # [m]
    twist: float = 0.09
    tilt: float = 0.03
    list_: float = 0.05
    reach: float = 0.985
    arm_swing: float = 0.45
    elbow: float = 0.35
    lean: float = 0.04


_RUN = Style(
    speed=3.2, walk_ratio=0.36, duty=0.34, over=0.42, strike_pitch=-0.38, strike_rate=1.0, flat_at=0.22, lift_at=0.45,
    off_pitch=0.80, off_rate=9.0, hump=0.20, clearance=0.12, touchdown=(0.30, -0.18), brake=45.0, push=25.0,
    half_width=0.035, sway=0.01, flight=0.05, twist=0.12, tilt=0.12, list_=0.04, reach=0.97, arm_swing=0.8,
    elbow=1.5, lean=0.12,
)  # fmt: skip
_CALM = Style(duty=0.66, hump=0.035, clearance=0.02, push=10.0, brake=8.0, arm_swing=0.15, twist=0.04)
STYLES: dict[str, Style] = {
    "walk": Style(),
    "turn": Style(speed=1.15),
    "curve": Style(speed=1.25),
    "treadmill": Style(speed=1.2),
    "run": _RUN,
    "sprint": replace(
        _RUN, speed=6.5, walk_ratio=0.50, duty=0.23, strike_pitch=0.10, strike_rate=-2.0, mid_pitch=0.03, flat_at=0.3,
        lift_at=0.5, off_rate=14.0, hump=0.34, clearance=0.22, lean=0.2, tilt=0.2, arm_swing=1.1,
    ),
    "forefoot-run": replace(_RUN, strike_pitch=0.16, strike_rate=-3.0, flat_at=0.3),
    "backwards": replace(
        _CALM, speed=-0.9, over=0.5, strike_pitch=0.45, strike_rate=-2.0, flat_at=0.4, lift_at=0.75, off_pitch=-0.25,
        off_rate=-3.0, hump=0.03,
    ),
    "sideways": replace(
        _CALM, speed=0.5, walk_ratio=0.30, over=0.5, strike_pitch=0.25, strike_rate=-1.5, off_pitch=0.35, off_rate=2.5,
        half_width=0.2, sway=0.03, toe_out=0.0,
    ),
    "stairs": replace(
        _CALM, speed=0.5, walk_ratio=0.18, over=0.50, strike_pitch=0.12, strike_rate=-1.0, off_pitch=0.7, off_rate=5.0,
        hump=0.06, clearance=0.045, tilt=0.12, lean=0.2, reach=0.975,
    ),
    "stairs-down": replace(
        _CALM, speed=0.5, walk_ratio=0.18, over=0.42, strike_pitch=0.40, strike_rate=-2.0, flat_at=0.2, lift_at=0.6,
        off_pitch=0.6, off_rate=4.0, hump=0.05, clearance=0.05, reach=0.975,
    ),
    "jump": replace(_CALM, bob=0.0, off_pitch=0.75, off_rate=9.0, strike_pitch=0.40, strike_rate=-4.0, flat_at=0.1),
    "stand": replace(_CALM, speed=0.0, sway=0.07, half_width=0.11),
    "tiptoe": replace(
        _CALM, speed=0.8, strike_pitch=0.75, strike_rate=-1.0, mid_pitch=0.55, off_pitch=0.95, off_rate=4.0,
        hump=0.03,
    ),
    "spot-turn": replace(
        _CALM, speed=0.0, over=0.5, strike_pitch=0.2, strike_rate=-1.5, off_pitch=0.3, off_rate=2.5, half_width=0.09,
        sway=0.04, duty=0.7,
    ),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Plan:
    """Footsteps of the left and the right foot, and the pelvis's way on a fine grid of times [s].

    `path` (n, 3) [m] is the place over which the pelvis is carried, `rise` (n,) [m] what is added to its height.
    """

    style: Style
    period: float
    steps: tuple[tuple[Footstep, ...], tuple[Footstep, ...]]
    grid: Floats
    path: Floats
    heading: Floats
    rise: Floats
    belt: tuple[float, float, float]


def smooth(signal: Floats, width: float) -> Floats:
    """The mean of a signal on the grid, weighted by a raised cosine of `width` [s]."""
    n = max(round(width / GRID / 2.0), 1)
    window = 1.0 + np.cos(np.pi * np.arange(-n, n + 1) / (n + 1))
    padded = np.pad(signal, n, mode="edge")
    return np.convolve(padded, window / window.sum(), mode="valid")


def plan(body: Body, gait: Gait) -> Plan:
    """Where and when the feet stand."""
    style = STYLES[gait.name]
    grid = np.arange(-MARGIN, gait.duration + MARGIN, GRID)
    scale = body.leg / 0.88
    speed = (style.speed if gait.speed is None else np.copysign(gait.speed, style.speed)) * np.sqrt(scale)
    if gait.name == "jump":
        return _jump(body, gait, style, grid)
    if gait.name == "stand":
        return _stand(body, gait, style, grid)
    length = gait.step or np.sqrt(style.walk_ratio * max(abs(speed), 0.35) * scale**1.5)
    period = 2.0 * length / abs(speed) if speed else 1.3 * np.sqrt(scale)
    path, heading = _way(gait, speed, float(_strikes(gait, style, period)[-1]), grid)
    random = np.random.default_rng(gait.seed)
    steps = [_footsteps(body, gait, style, side, period, speed, grid, path, heading, random) for side in (0, 1)]
    floor = _floor_below(steps, grid)
    path[:, 1] = smooth(floor, 0.5 * period) + body.leg * (body.ankle_height + 0.05 + _stance_height(style))
    belt = (0.0, 0.0, -float(speed)) if gait.name == "treadmill" else (0.0, 0.0, 0.0)
    return Plan(style, period, (steps[0], steps[1]), grid, path, heading, np.zeros(len(grid)), belt)


def _stance_height(style: Style) -> float:
    """Height of the hip joints over the ankles in mid stance, in legs."""
    return style.reach - 0.005 + 0.13 * float(np.sin(max(style.mid_pitch, 0.0)))


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
    body: Body, gait: Gait, style: Style, side: int, period: float, speed: float, grid: Floats, path: Floats,
    heading: Floats, random: np.random.Generator,
) -> tuple[Footstep, ...]:  # fmt: skip
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
        over = float(grid[0]) if from_rest else float(grid[-1]) if to_rest else over
        wobble = gait.variation * random.normal(size=6)
        step = _footstep(body, gait, style, side, k, strike, off, over, wobble, speed, grid, path, heading)
        if from_rest:
            step = replace(step, pitch=step.pitch[2:])
        if to_rest:
            step = replace(step, pitch=step.pitch[:3])
        steps.append(step)
    return tuple(steps)


def _footstep(
    body: Body, gait: Gait, style: Style, side: int, k: int, strike: float, off: float, over: float, wobble: Floats,
    speed: float, grid: Floats, path: Floats, heading: Floats,
) -> Footstep:  # fmt: skip
    sign = 1.0 if side == 0 else -1.0
    at = np.array([np.interp(over, grid, path[:, axis]) for axis in range(3)])
    facing = float(np.interp(over, grid, heading))
    out = sign * body.leg * (style.half_width + 0.008 * wobble[0])
    ahead = 0.012 * body.leg * wobble[1]
    at += out * np.array([np.cos(facing), 0.0, -np.sin(facing)])
    at += ahead * np.array([np.sin(facing), 0.0, np.cos(facing)])
    at[1] = _stair(body, gait, side, k)
    hard = 0.0 if gait.soft else 1.0
    return Footstep(
        place=(float(at[0]), float(at[1]), float(at[2])),
        heading=facing + sign * (style.toe_out + 0.03 * wobble[2]),
        pitch=_roll(style, strike, off, wobble),
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


def _stand(body: Body, gait: Gait, style: Style, grid: Floats) -> Plan:
    """Weight goes from foot to foot; the heel of the free one rises a little, and once it takes a small step."""
    random = np.random.default_rng(gait.seed)
    beat = 1.6
    beats = int((gait.duration + 2.0 * MARGIN) / beat)
    onto_left = np.where(np.arange(beats) % 2 == 0, 1.0, -1.0) * random.uniform(0.6, 1.0, beats)
    moments = grid[0] + beat * (np.arange(beats) + 0.5)
    path = np.zeros((len(grid), 3))
    path[:, 0] = style.sway * body.leg * smooth(np.interp(grid, moments, onto_left), beat)
    path[:, 2] = 0.02 * body.leg * smooth(np.interp(grid, moments, random.uniform(-1.0, 1.0, beats)), beat)
    path[:, 1] = body.leg * (body.ankle_height + 0.05 + _stance_height(style))
    place = [(sign * body.leg * style.half_width, 0.0, 0.0) for sign in (1.0, -1.0)]
    left, right = Knot(grid[0], 0.0), Knot(grid[0], 0.0)
    rolls: list[list[Knot]] = [[left], [right]]
    for moment, onto in zip(moments, onto_left, strict=True):
        free, raised = rolls[int(onto > 0.0)], float(random.uniform(0.05, 0.25))
        if random.random() < 0.6:
            start = float(moment) - 0.3
            shape = ((0.0, 0.0), (0.35, raised), (0.6, raised), (1.0, 0.0))
            free += [Knot(start + dt, value) for dt, value in shape]
    second = gait.duration * 0.6
    steps = [
        _shuffle(place[0], 0.12, tuple(rolls[0]), None, style),
        _shuffle(place[1], -0.14, tuple(rolls[1]), second, style),
    ]
    flat = np.zeros(len(grid))
    return Plan(style, beat, (steps[0], steps[1]), grid, path, flat, flat, (0.0, 0.0, 0.0))


def _shuffle(
    place: tuple[float, float, float], heading: float, roll: tuple[Knot, ...], moment: float | None, style: Style
) -> tuple[Footstep, ...]:
    """One long plant, broken by a small step forward at a moment, if one is given."""
    if moment is None:
        return (Footstep(place=place, heading=heading, pitch=roll),)
    before = tuple(knot for knot in roll if knot.time < moment - 1.2)
    after = tuple(knot for knot in roll if knot.time > moment + 1.5)
    before += (Knot(moment - 0.6, 0.0), Knot(moment - 0.3, 0.3, 2.0))
    after = (Knot(moment, 0.1, -1.0), Knot(moment + 0.15, 0.0), *after)
    return (
        Footstep(place=place, heading=heading, pitch=before),
        Footstep(place=(place[0], place[1], place[2] + 0.09), heading=heading - 0.1, pitch=after, clearance=0.02),
    )


def _jump(body: Body, gait: Gait, style: Style, grid: Floats) -> Plan:
    """Jumps forward off both feet, each with a crouch before and after, standing in between."""
    random = np.random.default_rng(gait.seed)
    every, flight = 2.4, 0.45
    length = 0.35 * body.leg if gait.step is None else gait.step
    up = 0.5 * 9.81 * flight  # [m/s] at take-off
    take_offs = np.arange(0.9 + gait.rest[0], max(gait.duration - gait.rest[1] - 1.0, 1.0), every)
    rise, ahead = [Knot(grid[0], 0.0)], [Knot(grid[0], 0.0)]
    steps: list[list[Footstep]] = [[], []]
    since = [float(grid[0]) - every] * 2
    for jump, t in enumerate([*take_offs.tolist(), None]):
        for side, sign in ((0, 1.0), (1, -1.0)):
            place = (sign * body.leg * style.half_width, 0.0, jump * length)
            late = 0.008 * gait.variation * float(random.normal())
            landing = Knot(since[side], style.strike_pitch, style.strike_rate)
            roll: tuple[Knot, ...] = (landing, Knot(since[side] + 0.07, 0.0))
            if jump == 0:
                roll = (Knot(since[side], 0.0),)
            if t is not None:
                roll += (Knot(t - 0.16 + late, 0.0), Knot(t + late, style.off_pitch, style.off_rate))
                since[side] = t + flight + late
            steps[side].append(
                Footstep(
                    place=place, heading=sign * style.toe_out, pitch=roll, hump=0.7 * up * flight / 4.0,
                    clearance=0.8 * up * flight / 4.0, touchdown=(0.3, -1.2), brake=5.0, push=10.0,
                )
            )  # fmt: skip
        if t is not None:
            rise += _leap(body.leg, t, flight, up)
            ahead += [Knot(t - 0.25, jump * length), Knot(t + flight + 0.2, (jump + 1) * length)]
    path = np.zeros((len(grid), 3))
    path[:, 2] = curve(tuple(ahead), grid)
    path[:, 1] = body.leg * (body.ankle_height + 0.05 + _stance_height(style))
    flat = np.zeros(len(grid))
    planned = (tuple(steps[0]), tuple(steps[1]))
    return Plan(style, every, planned, grid, path, flat, curve(tuple(rise), grid), (0.0, 0.0, 0.0))


def _leap(leg: float, t: float, flight: float, up: float) -> list[Knot]:
    """The pelvis's height about a jump: crouch, push, fly, give, stand."""
    return [
        Knot(t - 0.75, 0.0),
        Knot(t - 0.27, -0.24 * leg, 0.0, 8.0),
        Knot(t, 0.05 * leg, up, -9.81),
        Knot(t + flight, 0.05 * leg, -up, -9.81),
        Knot(t + flight + 0.25, -0.26 * leg, 0.0, 6.0),
        Knot(t + flight + 0.95, 0.0),
    ]

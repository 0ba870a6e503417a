"""Walkers that do not walk: jumping, and standing from foot to foot."""

from __future__ import annotations

import numpy as np
from walker_body import Body
from walker_feet import Footstep, Knot, curve
from walker_gaits import MARGIN, Gait, Plan, Style, smooth, stance_height

from footfix.motion.clip import Floats


def stand(body: Body, gait: Gait, style: Style, grid: Floats) -> Plan:
    """Weight goes from foot to foot; the heel of the free one rises a little, and once it takes a small step."""
    random = np.random.default_rng(gait.seed)
    beat = 1.6
    beats = int((gait.duration + 2.0 * MARGIN) / beat)
    onto_left = np.where(np.arange(beats) % 2 == 0, 1.0, -1.0) * random.uniform(0.6, 1.0, beats)
    moments = grid[0] + beat * (np.arange(beats) + 0.5)
    path = np.zeros((len(grid), 3))
    path[:, 0] = style.sway * body.leg * smooth(np.interp(grid, moments, onto_left), beat)
    path[:, 2] = 0.02 * body.leg * smooth(np.interp(grid, moments, random.uniform(-1.0, 1.0, beats)), beat)
    path[:, 1] = body.leg * (body.ankle_height + 0.05 + stance_height(style))
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


def jump(body: Body, gait: Gait, style: Style, grid: Floats) -> Plan:
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
    path[:, 1] = body.leg * (body.ankle_height + 0.05 + stance_height(style))
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

"""Gaits: what can be asked of a walker, how each kind looks, and what a plan of it holds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from walker_feet import Footstep

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
    "sprint": replace(  # on the ball for a tenth of a second, the heel just off the floor
        _RUN, speed=8.5, walk_ratio=0.47, duty=0.235, over=0.38, strike_pitch=0.18, strike_rate=-2.0, mid_pitch=0.10,
        flat_at=0.3, lift_at=0.5, off_rate=18.0, hump=0.42, clearance=0.30, touchdown=(0.25, -0.15), brake=90.0,
        push=60.0, half_width=0.03, bob=-0.18, lean=0.2, tilt=0.2, arm_swing=1.1,
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


def stance_height(style: Style) -> float:
    """Height of the hip joints over the ankles in mid stance, in legs."""
    return style.reach - 0.005 + 0.13 * float(np.sin(max(style.mid_pitch, 0.0)))

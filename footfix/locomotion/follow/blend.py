"""Handing one walk over to another: how long it takes, and how it comes in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.errors import UsageError
from footfix.locomotion.follow.keys import Keys
from footfix.locomotion.follow.walk import Walk
from footfix.motion.clip import Floats
from footfix.motion.kinematics import places

_STEEP = 0.02  # of a clip's 99th percentile of acceleration, that a blend may add
_BEND = 6.0  # of `handed` in unit time: the most that it accelerates
_PHASES = 32  # at which two walks are compared


def ease(u: Floats) -> Floats:
    """A step from 0 to 1 over u from 0 to 1, at rest at both ends: 6 u^5 - 15 u^4 + 10 u^3."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u * u * u * (u * (6.0 * u - 15.0) + 10.0))


def handed(u: Floats) -> Floats:
    """How much of the next walk is there over u from 0 to 1: 3 u^2 - 2 u^3, the least steep step from rest to rest.

    A steeper one hands a foot over in a single swing.
    """
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u * u * (3.0 - 2.0 * u))


@dataclass(frozen=True)
class Transition:
    """One walk handed over to another.

    Args:
        before, after: index of either walk.
        start, end: [s] from the start, of the blend.
        metres: [m] on the path where it starts.
        effector: joint by which its length was told.
        asked: [s] its length by K 6.2.
        clamped: whether that was too short or too long.
    """

    before: int
    after: int
    start: float
    end: float
    metres: float
    effector: str
    asked: float
    clamped: bool


def blend_length(
    one: Walk, other: Walk, keys: tuple[Keys, Keys], at: float, ends: Sequence[int]
) -> tuple[int, float, float]:  # fmt: skip
    """Tell how long the change from one walk to another takes (K 6.2): dD / |T_a - T_b|, at equal phase.

    Args:
        one, other: the walks.
        keys: of either.
        at: generic time [strides] at which it starts.
        ends: the end effectors: head, hands and feet.

    Returns:
        The effector that differs most, the length by it [s], and the least [s] in which the blend itself accelerates
        no joint by much of what the walks do.
    """
    pair = tuple(zip((one, other), keys, strict=True))
    here = [places(walk.at(key.frame(np.array([at]))))[0, list(ends)] for walk, key in pair]
    apart = np.linalg.norm(here[1] - here[0], axis=1)
    most = int(np.argmax(apart))
    speeds = [_speed(walk, ends[most]) for walk in (one, other)]
    differ = abs(speeds[0] - speeds[1])
    asked = float(apart[most] / differ) if differ > 1e-9 else np.inf if apart[most] > 1e-9 else 0.0
    time = np.linspace(0.0, float(np.lcm(one.strides, other.strides)), _PHASES * one.strides, endpoint=False)
    whole = [places(walk.at(key.frame(time))) for walk, key in pair]
    gap = np.linalg.norm(whole[1] - whole[0], axis=2).max(axis=0)
    steep = np.max([_acceleration(walk) for walk in (one, other)], axis=0)
    floor = 0.2 * float(np.median(steep))
    least = float(np.sqrt(_BEND * gap / (_STEEP * np.maximum(steep, max(floor, 1e-6)))).max())
    return ends[most], asked, least


def _speed(walk: Walk, joint: int) -> float:
    """[m/s] of a joint in the world, in the mean."""
    track = places(walk.clip)[:, joint] + np.outer(np.arange(walk.frames + 1), [0.0, 0.0, walk.length / walk.frames])
    return float(np.linalg.norm(np.diff(track, axis=0), axis=1).mean()) / walk.clip.frame_time


def _acceleration(walk: Walk) -> Floats:
    """(J,) [m/s^2] the 99th percentile of each joint's acceleration."""
    tracks = places(walk.clip)
    second = np.diff(np.concatenate([tracks[-2:-1], tracks]), n=2, axis=0) / walk.clip.frame_time**2
    return np.asarray(np.percentile(np.linalg.norm(second, axis=2), 99.0, axis=0))


def check_order(starts: Sequence[float], names: Sequence[str]) -> None:
    """See that walks begin one after the other.

    Raises:
        UsageError: they do not.
    """
    for k in range(1, len(starts)):
        if starts[k] <= starts[k - 1]:
            raise UsageError(f"{names[k]} is to begin before {names[k - 1]} has")

"""Blending one walk into another: duration and weight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.errors import UsageError
from footfix.locomotion.follow.key_times import Keys
from footfix.locomotion.follow.prepared_walk import Walk
from footfix.motion.clip import Floats
from footfix.motion.kinematics import places


def ease(u: Floats) -> Floats:
    """Evaluate a smooth step from 0 to 1 over u from 0 to 1: 6 u^5 - 15 u^4 + 10 u^3."""
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u * u * u * (u * (6.0 * u - 15.0) + 10.0))


def handed(u: Floats) -> Floats:
    """Compute the weight of the next walk: smoothstep 3 u^2 - 2 u^3.

    A steeper step would blend a foot within a single swing.
    """
    u = np.clip(u, 0.0, 1.0)
    return np.asarray(u * u * (3.0 - 2.0 * u))


@dataclass(frozen=True)
class Transition:
    """A blend from one walk to another.

    Args:
        before, after: indices of the walks.
        start, end: [s] of the blend, from the start of the first walk.
        metres: [m] on the path where it starts.
        effector: joint that determined its duration.
        asked: [s] its duration by K 6.2.
        clamped: whether that was limited.
        peak: largest acceleration of a joint in it [times the 99th percentile in the walks],
        asked_peak: and in a blend of the asked duration; None where that was not computed.
    """

    before: int
    after: int
    start: float
    end: float
    metres: float
    effector: str
    asked: float
    clamped: bool
    peak: float | None = None
    asked_peak: float | None = None


def blend_length(
    one: Walk, other: Walk, keys: tuple[Keys, Keys], at: float, ends: Sequence[int]
) -> tuple[int, float]:  # fmt: skip
    """Compute the duration of a blend from one walk to another (K 6.2): dD / |T_a - T_b|, at equal phase.

    Args:
        one, other: the walks.
        keys: of both.
        at: generic time [strides] at which it starts.
        ends: the end effectors: head, hands and feet.

    Returns:
        The effector that differs most, and the length by it [s].
    """
    pair = tuple(zip((one, other), keys, strict=True))
    here = [places(walk.at(key.frame(np.array([at]))))[0, list(ends)] for walk, key in pair]
    apart = np.linalg.norm(here[1] - here[0], axis=1)
    most = int(np.argmax(apart))
    speeds = [_speed(walk, ends[most]) for walk in (one, other)]
    differ = abs(speeds[0] - speeds[1])
    asked = float(apart[most] / differ) if differ > 1e-9 else np.inf if apart[most] > 1e-9 else 0.0
    return ends[most], asked


def _speed(walk: Walk, joint: int) -> float:
    """Compute the mean speed of a joint in the world [m/s]."""
    track = places(walk.clip)[:, joint] + np.outer(np.arange(walk.frames + 1), [0.0, 0.0, walk.length / walk.frames])
    return float(np.linalg.norm(np.diff(track, axis=0), axis=1).mean()) / walk.clip.frame_time


def check_order(starts: Sequence[float], names: Sequence[str]) -> None:
    """Check that walks begin one after the other.

    Raises:
        UsageError: they do not.
    """
    for k in range(1, len(starts)):
        if starts[k] <= starts[k - 1]:
            raise UsageError(f"{names[k]} is to begin before {names[k - 1]} has")

"""Stride length: shorter in curves, and sharing a change of speed with stride time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.locomotion.follow.blend_schedule import Pace
from footfix.locomotion.follow.params import FollowParams
from footfix.locomotion.follow.path import Path
from footfix.locomotion.follow.prepared_walk import Walk
from footfix.motion.clip import Floats
from footfix.motion.spline import spline

_TIME, _STRIDE = -0.42, 0.58  # exponents of the speed factor for a stride's time and length
_STEP = 0.02  # [m]


def pace_of(walk: Walk, params: FollowParams) -> Pace:
    """Compute stride time and length at the requested speed.

    A speed factor k is split into stride time, k^-0.42, and stride length, k^0.58: people who walk k times as fast step
    k^0.42 times as often.

    Args:
        walk: as captured.
        params: with the requested speed.
    """
    k = params.speed if params.speed_to is None else params.speed * params.speed_to / walk.speed
    return Pace() if k == 1.0 else Pace(float(k**_TIME), float(k**_STRIDE))


def paced(paces: Sequence[Pace]) -> bool:
    """Tell whether any walk has another pace than it was captured with."""
    return any(pace != Pace() for pace in paces)


def smoothed(values: Floats, width: int) -> Floats:
    """Smooth values (F,) with a smooth window; constants are preserved.

    Args:
        values: (F,), going on at the ends as they are there.
        width: of the window [frames].
    """
    half = max(1, width // 2)
    window = np.hanning(2 * half + 3)[1:-1]
    around = np.pad(values, half, mode="edge")
    first = values[0]
    return np.asarray(first + np.convolve(around - first, window / window.sum(), mode="valid"))


def averaged(values: Floats, width: float) -> Floats:
    """Average values (F,) over `width` frames about each, which need not be whole."""
    edge = int(np.ceil(width)) + 1
    around = np.pad(values, edge, mode="edge")
    total = np.append(0.0, np.cumsum(around))
    count = np.arange(len(total))
    middle = np.arange(len(values)) + edge + 0.5
    high, low = (np.interp(middle + side * width / 2.0, count, total) for side in (1.0, -1.0))
    return np.asarray((high - low) / width)


def scale_of(curvature: Floats, leg_length: float, params: FollowParams) -> Floats:
    """Compute the factor (F,) on stride length on a curved path, 1 on a straight line.

    K 7.2 takes 1 % for each 0.2 degrees between neighbouring samples of the path, which depends on how densely it is
    sampled; this goes by curvature times leg length, and also ends at half a stride.

    Args:
        curvature: (F,) [rad/m].
        leg_length: [m].
        params: by how much.
    """
    if not params.stride:
        return np.ones(len(curvature))
    return np.clip(1.0 - params.shrink * leg_length * np.abs(curvature), params.shortest, 1.0)


@dataclass(frozen=True, eq=False)
class Way:
    """Converts distances walked to arc lengths on a path, with shorter strides in curves.

    ds = scale(s) du, so u(s) is the integral of 1 / scale.

    Args:
        s: (N,) [m] arc lengths,
        u: (N,) [m] and distances that the walks would cover straight on; 0 at the start. None where they are equal.
    """

    s: Floats
    u: Floats | None

    def arc(self, gone: Floats) -> Floats:
        """Compute the arc lengths (F,) [m] after distances walked (F,) [m]."""
        return gone if self.u is None else spline(self.u, self.s[:, None])(gone)[..., 0]

    def gone(self, s: float) -> float:
        """Compute the distance walked at an arc length [m]."""
        return s if self.u is None else float(spline(self.s, self.u[:, None])(np.array(s))[0])


def way_on(path: Path, stride: float, leg_length: float, until: float, params: FollowParams) -> Way:
    """Compute the progress of walks along a path.

    Args:
        path: the path.
        stride: [m] over which curvature is taken in the mean.
        leg_length: [m].
        until: [m] how far at most.
        params: with the reduction of strides in curves.
    """
    if path.straight or not params.stride:
        return Way(np.zeros(0), None)
    low, high = -4.0 * stride, max(until, path.length) + 4.0 * stride
    s = np.linspace(low, high, int(np.ceil((high - low) / _STEP)) + 1)
    bent = smoothed(np.abs(path.curvature(s)), round(stride / _STEP))
    slow = 1.0 / scale_of(bent, leg_length, params)
    u = np.append(0.0, np.cumsum(0.5 * (slow[1:] + slow[:-1]) * np.diff(s)))
    return Way(s, u - np.interp(0.0, s, u))

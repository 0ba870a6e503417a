"""Velocities over the ground and the facing of the hips on detection's grid, updated for new steps only.

Both are needed for some seconds back, and no longer change once half of their filter's window has followed. Horizontal
vectors are complex numbers: x, and z times i.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footfix.detect.evidence import FACING, STEP
from footfix.detect.stepping import WINDOW
from footfix.motion.clip import Floats
from footfix.motion.smoothing import window_frames
from footfix.stream.filters import filtered
from footfix.stream.ring_buffer import Ring
from footfix.stream.time_grid import FOOT, PAST

Complexes = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Facing:
    """The facing of the hips in the newest n steps.

    Args:
        outward: (n, feet) unit vectors, outward on each foot's side.
        ahead: (n, feet) [leg lengths] how far the toe is ahead of the heel.
        signs: (feet,) 1 where forward is outward turned by a right angle, counted from x to z, else -1.
    """

    outward: Complexes
    ahead: Floats
    signs: Floats


class OverGround:
    """Velocities of a figure in the newest steps."""

    def __init__(self, mates: Sequence[int]) -> None:
        """Begin without steps, of feet each of which has another one as its mate, or itself."""
        feet, capacity = len(mates), round(PAST / STEP) + 40
        self._mates = list(mates)
        self._alone = [k for k, mate in enumerate(mates) if mate == k]
        self._moving = [0, *(1 + FOOT * k + part for part in (2, 3) for k in range(feet))]  # pelvis, heels, toes
        self._velocity = Ring((1 + 2 * feet, 2), capacity)
        self._speed = Ring((feet,), capacity)
        self._outward, self._along = Ring((feet, 2), capacity), Ring((feet,), capacity)

    def follow(self, steps: Ring, changed: int) -> None:
        """Take steps of the grid: those from number `changed` on are new, or not what they were."""
        places, first = _about(steps, changed, WINDOW, 2)
        velocity = filtered(places[:, self._moving, ::2], seconds=WINDOW, degree=2, derivative=1)[first:]
        self._velocity.replace(steps.end - len(velocity), velocity)
        soles = velocity[:, 1:].reshape(len(velocity), 2, -1, 2).view(np.complex128)[..., 0]
        self._speed.replace(steps.end - len(velocity), slowest(soles[:, 0], soles[:, 1]))
        places, first = _about(steps, changed, FACING, 1)
        feet = places[:, 1:].reshape(len(places), -1, FOOT, 3)
        hip, along = feet[:, :, 0, ::2], feet[:, :, 3, ::2] - feet[:, :, 2, ::2]
        outward = hip - hip[:, self._mates]
        if self._alone:
            outward[:, self._alone] = along[:, self._alone, ::-1] * (-1.0, 1.0)
        outward = filtered(outward, seconds=FACING, degree=1)[first:]
        outward /= np.maximum(np.hypot(outward[..., 0], outward[..., 1]), 1e-9)[..., None]
        along = along[first:]
        self._outward.replace(steps.end - len(outward), outward)
        self._along.replace(steps.end - len(outward), along[..., 1] * outward[..., 0] - along[..., 0] * outward[..., 1])

    def velocity(self, count: int) -> Complexes:
        """Get the velocities of pelvis, heels and toes in the newest steps, (n, 1 + 2 feet) [leg lengths/s]."""
        return np.asarray(self._velocity.last(count).view(np.complex128)[..., 0])

    def speed(self, count: int) -> Floats:
        """Get the speed of the slowest point of each sole, (n, feet) [leg lengths/s]."""
        return self._speed.last(count)

    def facing(self) -> Facing:
        """Tell where the hips face, of all steps that are remembered: where feet point for most of the time."""
        along = self._along.last(round(PAST / STEP))
        signs = np.where(np.add.reduce(along, axis=0) < 0.0, -1.0, 1.0)
        outward = self._outward.last(len(along)).view(np.complex128)[..., 0]
        return Facing(outward, along * signs, signs)


def _about(steps: Ring, changed: int, seconds: float, degree: int) -> tuple[Floats, int]:
    """Take the filter's input around changed steps, and the first of its rows whose result is needed."""
    half = window_frames(seconds, STEP, degree) // 2
    low = max(min(changed - 2 * half, steps.end - 2 * half - 1), steps.start)
    return steps.view(low), max(changed - half - low, 0) if low > 0 else 0


def slowest(heel: Complexes, toe: Complexes) -> Floats:
    """Compute the speed of the slowest point between heel and toe, from their velocities; see `detect.stepping`."""
    return to_segment(np.zeros(1, dtype=np.complex128), heel, toe)


def to_segment(point: Complexes, start: Complexes, end: Complexes) -> Floats:
    """Compute the distances of points from segments; the shapes broadcast."""
    along, off = end - start, point - start
    across = along.conj()
    share = np.minimum(np.maximum((off * across).real / np.maximum((along * across).real, 1e-12), 0.0), 1.0)
    return np.asarray(np.abs(off - share * along))

"""Treadmills in a stream: whether the ground under planted feet moves, found as frames come in.

A figure may step on a belt long after its first seconds, and off again. Its latest plants show whether it is on one, by
the rules of `enforce.ground` for a whole clip; the belt's velocity is then used for coming plants.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from footfix.enforce.ground import OUTLIERS, Drift, GroundParams, go_along, usual_step
from footfix.motion.clip import Bools, Floats

_LONGEST = 1.0  # [s] of a plant that are examined; a longer plant means that the figure stands on the floor


@dataclass
class _Plant:
    """A sole point that is planted now: its places since the plant began, and those of the hips."""

    start: int
    hips: Floats
    track: list[Floats] = field(default_factory=list)


class Belt:
    """The ground of one figure in a stream."""

    def __init__(self, velocity: Floats, frame_time: float, leg_length: float, params: GroundParams) -> None:
        """Start with a known velocity.

        Args:
            velocity: (3,) [m/s] that is known beforehand.
            frame_time: [s].
            leg_length: [m].
            params: what makes a belt.
        """
        self.velocity = velocity  # (3,) [m/s] of the ground under plants to come
        self._frame_time, self._leg_length, self._params = frame_time, leg_length, params
        self._longest = round(_LONGEST / frame_time)
        self._plants: dict[int, _Plant] = {}
        self._lately: deque[tuple[Drift, Floats, Floats]] = deque(maxlen=params.belt_plants)

    def follow(self, soles: Floats, hips: Floats, down: Bools, first: int) -> None:
        """Update the belt by the next frames.

        Args:
            soles: (3, 2, L, n) [m] heels and toes as captured.
            hips: (3, n) [m] the middle of the hips.
            down: (n, 2 legs) when heel and toe of each leg are planted.
            first: number of the first of these frames.
        """
        for t in range(len(down)):
            for column in range(down.shape[1]):
                plant = self._plants.get(column)
                if down[t, column]:
                    if plant is None:
                        plant = self._plants[column] = _Plant(first + t, hips[:, t])
                    if len(plant.track) <= self._longest:
                        plant.track.append(soles[:, column % 2, column // 2, t])
                        if len(plant.track) > self._longest:
                            self._stays(plant, column // 2)
                elif plant is not None:
                    del self._plants[column]
                    self._ended(plant, column // 2, hips[:, t])

    def _stays(self, plant: _Plant, leg: int) -> None:
        """Drop the belt where a foot stands for long without moving with it."""
        if self._rests(Drift.of(leg, plant.start, np.stack(plant.track), self._frame_time)):
            self.velocity = np.zeros(3)
            self._lately.clear()

    def _rests(self, drift: Drift) -> bool:
        """Tell whether a plant rests on the floor rather than on the belt."""
        return bool(2.0 * drift.velocity @ self.velocity < self.velocity @ self.velocity)

    def _ended(self, plant: _Plant, leg: int, hips: Floats) -> None:
        """Update the belt by a plant that has ended."""
        if len(plant.track) < 3:
            return
        drift = Drift.of(leg, plant.start, np.stack(plant.track), self._frame_time)
        self._lately.append((drift, plant.hips, hips))
        drifts = [each for each, _, _ in self._lately]
        along = self._along(drifts)
        if along is not None:
            self.velocity = usual_step(drifts, along)
        elif np.any(self.velocity):
            lately = drifts[-OUTLIERS - 1 :]
            if len(lately) > OUTLIERS and all(self._rests(each) for each in lately):
                self.velocity = np.zeros(3)

    def _along(self, drifts: list[Drift]) -> Bools | None:
        """Mark the plants that move with a belt; None where there is none."""
        if len(drifts) < self._params.belt_plants or len({drift.leg for drift in drifts}) < 2:
            return None
        first = min(range(len(drifts)), key=lambda k: drifts[k].start)
        last = max(range(len(drifts)), key=lambda k: drifts[k].end)
        frames = max(drifts[last].end - drifts[first].start, 1)
        travel = (self._lately[last][2] - self._lately[first][1]) / (frames * self._frame_time)
        return go_along(drifts, travel, self._params.belt_walk * self._leg_length, self._params)

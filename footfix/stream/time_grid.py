"""Places of feet and pelvis on detection's time grid, updated as frames come in."""

from __future__ import annotations

import numpy as np

from footfix.detect.evidence import SMOOTH, STEP
from footfix.detect.tracks import Tracks
from footfix.motion.clip import Floats
from footfix.motion.smoothing import window_frames
from footfix.stream.filters import filtered
from footfix.stream.ring_buffer import Ring

FOOT = 4  # tracks of a foot: hip, ankle, heel, toe
PAST = 2.3  # [s] that are kept: resting feet are searched two seconds back


class Grid:
    """Tracks in leg lengths every `STEP` seconds since the stream began, as `detect.evidence.resample` makes them."""

    def __init__(self, feet: int, leg_length: float, frame_time: float) -> None:
        """Begin without frames.

        Args:
            feet: how many.
            leg_length: [m].
            frame_time: [s].
        """
        self._leg_length, self._per_step = leg_length, STEP / frame_time  # frames
        self._frame_time = frame_time
        self._half = window_frames(SMOOTH, frame_time, 2) // 2 if 2.5 * frame_time < SMOOTH else 0
        self._again = int(np.ceil((2 + self._half) / self._per_step)) + 1  # steps that the next frame changes
        self._frames = Ring((1 + FOOT * feet, 3), round(0.3 / frame_time) + 8 * (self._half + 2))
        self.steps = Ring((1 + FOOT * feet, 3), round(PAST / STEP))

    def add(self, tracks: Tracks) -> int:
        """Take the next frames.

        Returns:
            The first step that is new or changed.
        """
        rows = np.stack([tracks.pelvis, *(p for f in tracks.feet for p in (f.hip, f.ankle, f.heel, f.toe))], axis=1)
        longest = max(1, round(0.1 / self._frame_time))
        changed = max(self.steps.end - self._again, self.steps.start)
        for first in range(0, len(rows), longest):
            self._frames.append(rows[first : first + longest] / self._leg_length)
            self._resample()
        return changed

    def _resample(self) -> None:
        first = max(self.steps.end - self._again, self.steps.start)
        last = int((self._frames.end - 1) / self._per_step + 1e-9)
        places: Floats = np.arange(first, last + 1, dtype=np.float64) * self._per_step
        low = max(int(places[0]) - 2 - 2 * self._half, self._frames.start)
        x = self._frames.view(low)
        if self._half:
            x = filtered(x, seconds=SMOOTH, degree=2, step=self._frame_time)
        self.steps.replace(first, _catmull_rom(x, places - low))


def _catmull_rom(x: Floats, places: Floats) -> Floats:
    """Interpolate a track (n, ...) at some places [frames] by Catmull-Rom splines."""
    left = np.minimum(places.astype(np.intp), max(len(x) - 2, 0))
    q = (places - left)[:, None, None]
    right = np.minimum(left + 1, len(x) - 1)
    a, b, c, d = x[np.maximum(left - 1, 0)], x[left], x[right], x[np.minimum(left + 2, len(x) - 1)]
    return np.asarray(b + 0.5 * q * (c - a + q * (2 * a - 5 * b + 4 * c - d + q * (3 * (b - c) + d - a))))

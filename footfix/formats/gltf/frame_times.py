"""The frames of an animation: evenly spaced times that its keys lie on, as far as they lie on any."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from footfix.errors import InputError
from footfix.formats.bvh.text import Limits
from footfix.formats.gltf.tracks import Track
from footfix.motion.clip import Floats

_RATES = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 240.0)  # [Hz] of captures and players
_USUAL = 30.0  # [Hz] where nothing tells
_SLOW = 20.0  # [Hz] lowest frame rate: keys farther apart get frames in between, since feet would slide there
_QUICK = 1000.0  # [Hz] highest frame rate
_OFF = 0.05  # [of a step] by which a key may miss its frame: times are often rounded to a millisecond
_MOST = 0.98  # share of the keys that must lie on frames
_PLENTY = 1_000_000  # values of all moving channels that any file may have,
_PER_KEY = 16  # and this many more for each of its keys


@dataclass(frozen=True)
class Grid:
    """The times of frames.

    Args:
        start: [s] of the first one.
        step: [s] between them.
        frames: how many there are.
        even: whether the keys lie on them.
    """

    start: float
    step: float
    frames: int
    even: bool = True

    @property
    def times(self) -> Floats:
        """Compute the time of each frame, (F,) [s]."""
        return np.asarray(self.start + self.step * np.arange(self.frames), dtype=np.float64)


def grid_of(tracks: Collection[Track], limits: Limits) -> Grid:
    """Find the frames of an animation from the keys of its channels.

    Frames reach from the first to the last key of the channels that move, and are as far apart as their keys. Where
    keys are farther apart than frames may be, the time between two keys is divided evenly.

    Args:
        tracks: the channels, at least one.
        limits: how many frames there may be.

    Raises:
        InputError: it would have more frames than the limits allow, or far more than its keys suggest.
    """
    moving = [track for track in tracks if not track.constant]
    used = moving or list(tracks)
    start = min(float(track.times[0]) for track in used)
    stop = max(float(track.times[-1]) for track in used)
    if stop <= start:
        return Grid(start, 1.0 / _USUAL, 1)
    step, even = _step(used, start)
    if step > 1.0 / _SLOW:
        step /= np.ceil(step * _USUAL - 1e-6)
    count = max(1, round((stop - start) / step))
    _bounded(count + 1, moving, limits)
    return Grid(start, (stop - start) / count, count + 1, even)


def _step(tracks: Collection[Track], start: float) -> tuple[float, bool]:
    """Find the step between frames [s], and whether the keys lie on such frames."""
    dense = max(tracks, key=lambda track: len(track.times)).times
    if len(dense) < 3:
        return 1.0 / _USUAL, True
    steps = np.diff(dense)
    usual = max(float(np.median(steps[steps > 0.0])) if np.any(steps > 0.0) else 0.0, 1.0 / _QUICK)
    keys = np.unique(np.concatenate([track.times for track in {id(t.times): t for t in tracks}.values()]))
    for step in sorted({usual, *(1.0 / rate for rate in _RATES)}, reverse=True):
        places = (keys - start) / step
        if step <= 1.2 * usual and np.mean(np.abs(places - np.round(places)) < _OFF) >= _MOST:
            return step, True
    return usual, False


def _bounded(frames: int, moving: Collection[Track], limits: Limits) -> None:
    if frames > limits.frames:
        raise InputError(f"{frames} frames, more than {limits.frames}", hint="limits.frames allows more")
    keys = sum(len(track.times) for track in moving)
    if frames * (len(moving) + 1) > _PLENTY + _PER_KEY * keys:
        raise InputError(f"its {keys} keys would give {frames} frames, too many to be meant; the times may be wrong")

"""The default detector: all evidence, over the whole clip at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.detect.tracks import Finding, Tracks
from footfix.motion.clip import Bools, Floats
from footfix.motion.smoothing import savgol


@dataclass(frozen=True, kw_only=True)
class AutoParams:
    """What the path through a clip costs.

    Args:
        switch: what a change of state costs, in nats; dearer means fewer and longer contacts.
    """

    switch: float = 3.0


def auto(tracks: Tracks, params: AutoParams) -> Finding:
    """Contacts by height over the local floor and by speed, as the cheapest path through two states."""
    columns, sure = [], []
    for foot in tracks.feet:
        for point in foot.soles:
            score = _score(point, tracks)
            columns.append(_path(score, params.switch))
            sure.append(1.0 / (1.0 + np.exp(-score)))
    return Finding(np.stack(columns, axis=1), np.stack(sure, axis=1))


def _score(point: Floats, tracks: Tracks) -> Floats:
    """(F,) log odds of a contact from height [leg lengths] and speeds [sqrt(g leg)]."""
    place = savgol(point, tracks.frame_time, seconds=0.05, degree=2)
    velocity = savgol(point, tracks.frame_time, seconds=0.05, degree=2, derivative=1) / tracks.froude_speed
    reach = max(round(0.5 / tracks.frame_time), 1)
    height = (place[:, 1] - _lower_envelope(place[:, 1], reach)) / tracks.leg_length
    speed = np.hypot(velocity[:, 0], velocity[:, 2])
    return np.asarray(
        np.clip(1.5 * (1.0 - height / 0.03), -6, 2)
        + np.clip(1.5 * (1.0 - np.abs(velocity[:, 1]) / 0.1), -4, 1.5)
        + np.clip(1.5 * (1.0 - speed / 0.25), -6, 1.5)
    )


def _lower_envelope(height: Floats, reach: int) -> Floats:
    """The higher of the lowest places ahead and behind: on a step up or down, the step stood on."""
    padded = np.pad(height, reach, mode="edge")
    least = np.lib.stride_tricks.sliding_window_view(padded, reach + 1).min(axis=1)
    return np.asarray(np.maximum(least[: len(height)], least[reach : reach + len(height)]))


def _path(score: Floats, switch: float) -> Bools:
    """The two-state path of greatest total score, `switch` nats lost at each change."""
    gain = np.empty((len(score), 2), dtype=np.bool_)
    free = planted = 0.0
    for t, s in enumerate(score.tolist()):
        gain[t] = planted - switch > free, free - switch > planted
        free, planted = max(free, planted - switch), max(planted, free - switch) + s
    state, mask = planted > free, np.empty(len(score), dtype=np.bool_)
    for t in range(len(score) - 1, -1, -1):
        mask[t] = state
        state = bool(state) ^ bool(gain[t, int(state)])
    return mask

"""Kim & Neff's detector: low and slow, then a vote of the neighbours (K §5.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.detect.tracks import Finding, Tracks
from footfix.motion.clip import Bools, Floats, Ints
from footfix.motion.contacts import runs
from footfix.motion.smoothing import savgol


@dataclass(frozen=True, kw_only=True)
class ThresholdParams:
    """What counts as low and slow (K §5.1).

    Args:
        height: height up to which a sole point is low, as a share of its vertical range (K: 0.1 to 0.2) [share].
        speed: speed up to which it is slow, as a share of the body's mean speed (K gives no number) [share].
        least_speed: [sqrt(g leg)] that speed is never less than this, since a standing body has no speed.
        smooth: [s] smoothing window (K: 12 frames at 120 fps).
        degree: degree of the smoothing polynomial (K) [count].
        vote: N_f, as a share of the neighbouring plant's length (K: a quarter) [share].
    """

    height: float = 0.15
    speed: float = 0.5
    least_speed: float = 0.1
    smooth: float = 0.1
    degree: int = 4
    vote: float = 0.25


def threshold(tracks: Tracks, params: ThresholdParams) -> Finding:
    """Detect contacts by height and speed (K §5.1).

    A contact's confidence is the share of its frames that were low and slow before the vote.
    """
    velocity = savgol(tracks.pelvis, tracks.frame_time, seconds=params.smooth, degree=2, derivative=1)
    body_speed = float(np.hypot(velocity[:, 0], velocity[:, 2]).mean())  # [m/s]
    bound = max(params.speed * body_speed, params.least_speed * tracks.froude_speed)
    raw = np.stack(
        [_low_and_slow(point, bound, tracks, params) for foot in tracks.feet for point in foot.soles], axis=1
    )
    mask = np.stack([vote(column, params.vote) for column in raw.T], axis=1)
    return Finding(mask, raw.astype(np.float64))


def _low_and_slow(point: Floats, bound: float, tracks: Tracks, params: ThresholdParams) -> Bools:
    window = {"seconds": params.smooth, "degree": params.degree}
    height = savgol(point[:, 1], tracks.frame_time, **window)  # type: ignore[arg-type]
    velocity = savgol(point, tracks.frame_time, derivative=1, **window)  # type: ignore[arg-type]
    low = height.min() + params.height * np.ptp(height)
    # The vertical range of a foot that never leaves the floor is only noise.
    low = max(low, height.min() + 0.01 * tracks.leg_length)
    return np.asarray((height <= low) & (np.linalg.norm(velocity, axis=1) <= bound))


def vote(raw: Bools, share: float) -> Bools:
    """Join frames to a contact when most of their neighbours are in one (K §5.1).

    A frame not in contact gets 1 / (2 N_f + 1) for each neighbour in contact, N_f frames to both sides,
    and joins when the sum exceeds one half; N_f is a share of the length of the nearest plant.

    Args:
        raw: (F,) in contact.
        share: of the plant's length (K: 0.25).
    """
    plants = runs(raw)
    if len(plants) < 2:
        return raw
    frames = np.arange(len(raw))
    N_f = np.round(share * _nearest_plant_length(plants, frames)).astype(np.intp)
    counted = np.concatenate([[0], np.cumsum(raw)])
    first, last = np.maximum(frames - N_f, 0), np.minimum(frames + N_f + 1, len(raw))
    probability = (counted[last] - counted[first]) / (2 * N_f + 1)
    return np.asarray(raw | (probability > 0.5))


def _nearest_plant_length(plants: list[tuple[int, int]], frames: Ints) -> Ints:
    edges = np.array(plants)  # (plants, 2)
    middles = 0.5 * (edges[:-1, 1] + edges[1:, 0])  # halfway through each gap
    nearest = np.searchsorted(middles, frames)
    return np.asarray((edges[:, 1] - edges[:, 0])[nearest])

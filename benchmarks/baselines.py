"""Common ways to label foot contacts, as their sources describe them, for comparison.

Each is a function of tracks in metres, y up, and gives a mask (F, 2 legs) of heel and toe by turns. Heights are
over the lowest place of each point in the clip.
"""

from __future__ import annotations

import numpy as np

from footfix.detect.gait_cycles import zigzag
from footfix.detect.tracks import FootTracks, Tracks
from footfix.motion.clip import Bools, Floats, Ints
from footfix.motion.smoothing import savgol


def _points(tracks: Tracks) -> list[Floats]:
    return [point for foot in tracks.feet for point in foot.soles]


def _speed(point: Floats, frame_time: float) -> Floats:
    return np.asarray(np.linalg.norm(np.gradient(point, frame_time, axis=0), axis=1))


def fixed(tracks: Tracks, height: float = 0.05, speed: float = 0.4) -> Bools:
    """Under 5 cm and under 0.4 m/s."""
    columns = [
        (p[:, 1] - p[:, 1].min() < height) & (_speed(p, tracks.frame_time) < speed) for p in _points(tracks)
    ]
    return np.stack(columns, axis=1)


def lafan1(tracks: Tracks) -> Bools:
    """Harvey et al. 2020: squared displacement of a frame at 30 fps under 0.02 cm^2, so 4.2 cm/s."""
    return np.stack([_speed(p, tracks.frame_time) < 0.02**0.5 * 0.01 * 30.0 for p in _points(tracks)], axis=1)


def humanml3d(tracks: Tracks) -> Bools:
    """Guo et al. 2022: squared displacement of a frame at 20 fps under 0.002 m^2, so 0.89 m/s."""
    return np.stack([_speed(p, tracks.frame_time) < 0.002**0.5 * 20.0 for p in _points(tracks)], axis=1)


def humor(tracks: Tracks) -> Bools:
    """Rempe et al. 2021: under 0.5 cm a frame at 30 fps, the ankle under 8 cm and the toe under 4 cm."""
    columns = []
    for foot in tracks.feet:
        for p, limit in ((foot.heel, 0.08), (foot.toe, 0.04)):
            columns.append((_speed(p, tracks.frame_time) < 0.15) & (p[:, 1] - p[:, 1].min() < limit))
    return np.stack(columns, axis=1)


def _forward(tracks: Tracks) -> Floats:
    """(F, 2) where the hips face, turned with the way the feet go back in stance."""
    across = savgol((tracks.feet[0].hip - tracks.feet[1].hip)[:, ::2], tracks.frame_time, seconds=0.3, degree=1)
    forward = np.stack([-across[:, 1], across[:, 0]], axis=1)
    forward /= np.maximum(np.linalg.norm(forward, axis=1)[:, None], 1e-12)
    facing = sum(np.sum((foot.toe - foot.heel)[:, ::2] * forward) for foot in tracks.feet)
    return forward if facing >= 0.0 else -forward


def zeni(tracks: Tracks) -> Bools:
    """Zeni et al. 2008: strikes with the heel farthest ahead of the pelvis, offs with the toe farthest behind."""
    forward = _forward(tracks)
    masks = []
    for foot in tracks.feet:
        heel, toe = (np.sum((p - tracks.pelvis)[:, ::2] * forward, axis=1) for p in foot.soles)
        strikes = _extremes(heel, 0.2 * tracks.leg_length, highs=True)
        offs = _extremes(toe, 0.2 * tracks.leg_length, highs=False)
        masks += [_between(strikes, offs, len(tracks))] * 2
    return np.stack(masks, axis=1)


def fva(tracks: Tracks) -> Bools:
    """O'Connor et al. 2007: extremes of the vertical velocity of the foot's centre while the foot is low."""
    masks = []
    for foot in tracks.feet:
        strikes, offs = _fva(foot, tracks.frame_time)
        masks += [_between(strikes, offs, len(tracks))] * 2
    return np.stack(masks, axis=1)


def _fva(foot: FootTracks, frame_time: float) -> tuple[Ints, Ints]:
    height = 0.5 * (foot.heel[:, 1] + foot.toe[:, 1])
    velocity = savgol(height, frame_time, seconds=0.1, degree=2, derivative=1)
    lowest, highest = np.quantile(height, [0.02, 0.99])
    low = height < lowest + 0.35 * (highest - lowest)
    span = 0.1 * np.ptp(velocity)
    falls, rises = _extremes(velocity, span, highs=False), _extremes(velocity, span, highs=True)
    return falls[low[falls]], rises[velocity[rises] > 0.3 * velocity.max()]


def _extremes(curve: Floats, least: float, *, highs: bool) -> Ints:
    """Frames of the highs (or the lows) that stand out by `least`."""
    turns = zigzag(curve, least)
    return np.array([t for k, t in enumerate(turns) if _is_high(curve, turns, k) == highs], dtype=np.intp)


def _is_high(curve: Floats, turns: list[int], k: int) -> bool:
    beside = turns[k - 1] if k else (turns[1] if len(turns) > 1 else 0)
    return bool(curve[turns[k]] > curve[beside])


def _between(strikes: Ints, offs: Ints, frames: int) -> Bools:
    """(F,) from each strike to the next off; what the clip cuts is taken as it stands."""
    events = sorted([(int(t), 1) for t in strikes] + [(int(t), 0) for t in offs])
    state = 0 if not events or events[0][1] else 1
    mask = np.empty(frames, dtype=np.bool_)
    last = 0
    for frame, following in events:
        mask[last:frame] = bool(state)
        last, state = frame, following
    mask[last:] = bool(state)
    return mask


BASELINES = {
    "5 cm, 0.4 m/s": fixed, "LAFAN1": lafan1, "HumanML3D": humanml3d, "HuMoR": humor, "Zeni": zeni, "FVA": fva,
}  # fmt: skip

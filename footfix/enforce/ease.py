"""What happens between plants: a displacement, known while the foot is planted, fades out and in.

Three ways, all with one meaning: `d(t)` is added to what was captured, holds its given values on pinned
frames, and is exactly zero farther than the ease from any contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from footfix.motion import banded
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs


@dataclass(frozen=True, kw_only=True)
class EaseParams:
    """How a correction fades before and after a plant."""

    method: Literal["smooth", "cubic", "hermite"] = "smooth"  # least squares, Glardon eq. 9-10, Kim & Neff
    seconds: float = 0.30  # how long before a plant it begins and after it ends (Glardon's sigma)
    settle: float = 0.012  # [s] what is quicker than this in a plant's correction is not carried beyond it
    roll_settle: float = 0.015  # [s] what is quicker in how the ankle of a foot on one end is moved, its roll takes up
    lead: float = 0.08  # [s] in which a foot that swings comes to be lifted out of the floor
    toe_settle: float = 0.03  # [s] what is quicker in the way of the ball in a foot that stands on it is a quiver
    toe_speed: float = 200.0  # [deg/s] at which toes bend out of the floor and come back
    slack: float = 0.08  # [s] how long the speed that a correction has at a plant's edge goes on beyond it
    edge: float = 0.036  # [s] how long what of it was too quick to be carried goes on
    bound: float = 0.02  # [s] in which a swinging knee comes to its straightest, and leaves it
    foot_first: float = 3.0  # times as much as the knee's acceleration that of its foot counts while neither is held


HELD = 1e4  # times as much as others that frames count which may not give way
_FIRM = 100.0  # times as much as at first that pinned values count when what is left at their edges is led over


def within_reach(contact: Bools, frame_time: float, seconds: float) -> Bools:
    """(F,) True on contact frames and on those nearer than `seconds` to one."""
    near = np.zeros(len(contact) + 1, dtype=np.int64)
    reach = ease_frames(frame_time, seconds)
    for start, end in runs(contact):
        near[max(start - reach, 0)] += 1
        near[min(end + reach, len(contact))] -= 1
    return np.asarray(np.cumsum(near[:-1]) > 0)


def ease_frames(frame_time: float, seconds: float) -> int:
    """Whole frames in an ease, at least one."""
    return max(1, round(seconds / frame_time))


def presence(changed: Bools, frame_time: float, seconds: float) -> Floats:
    """(F,) 0 where nothing changes, rising to 1 within the ease on frames that do; no rise at the clip's own ends."""
    frames, ease = len(changed), ease_frames(frame_time, seconds)
    if not np.any(changed):
        return np.zeros(frames)
    t, still = np.arange(frames), ~changed
    last = np.maximum.accumulate(np.where(still, t, -frames - ease))  # the still frames before and after each
    following = np.minimum.accumulate(np.where(still, t, 2 * frames + ease)[::-1])[::-1]
    return np.where(changed, 1.0 - gamma(np.minimum(t - last, following - t) / ease), 0.0)


def displacement(
    pinned: Bools,
    values: Floats,
    near: Bools,
    frame_time: float,
    params: EaseParams,
    soft: Floats | None = None,
    track: Floats | None = None,
) -> Floats:
    """The displacement at every frame.

    Args:
        pinned: (F,) frames where it is known.
        values: (F, K) what it is there.
        near: (F,) frames where it may differ from zero.
        frame_time: [s].
        params: the way.
        soft: (F,) [s] where above zero, pinned values are followed only as far as they are slower than this.
        track: (F, K) [m] what is displaced, if it is a place: Kim & Neff's spline needs to know it.

    Returns:
        (F, K): `values` on pinned frames that are not soft, zero outside `near`, smooth between.
    """
    if not np.any(pinned):
        return np.zeros(values.shape)
    exact = pinned
    if params.method == "smooth":
        weights = pinned.astype(np.float64)
        if soft is not None:
            exact = pinned & (soft == 0.0)
            weights *= (params.settle / np.maximum(soft, params.settle)) ** 4
        eased = fit(weights, values, near, frame_time, params.settle, params.slack)
        eased += left_at_edges(exact, values - eased, near, frame_time, params)
    elif params.method == "hermite" and track is not None:
        eased = _hermite(pinned, values, track, frame_time, params.seconds)
    else:
        eased = _cubic(pinned, values, frame_time, params.seconds)
    return np.where(exact[:, None], values, np.where(near[:, None], ended(eased), 0.0))


def ended(eased: Floats) -> Floats:
    """The displacement (F, K), ended where it has all but died away: what did not need changing keeps its numbers."""
    return np.where((np.abs(eased).max(axis=1) < 1e-7)[:, None], 0.0, eased)


def left_at_edges(exact: Bools, left: Floats, near: Bools, frame_time: float, params: EaseParams) -> Floats:
    """(F, K) what leads over at the edges of plants, where a smooth displacement left (F, K) of the exact one."""
    return fit(_FIRM * exact.astype(np.float64), left, near, frame_time, params.settle, params.edge)


def fit(
    weights: Floats, values: Floats, near: Bools, frame_time: float, settle: float, slack: float
) -> Floats:
    """Least change of velocity and acceleration, over the whole clip at once.

    Minimises the sum over frames of  w |d - v|^2 + s^4 |d''|^2 + (s^4 / l^2) |d'|^2,  s = settle, l = slack,
    d = 0 outside `near`: a smoothing spline in tension (Schweikert 1966), whose normal equations are symmetric,
    positive definite and five diagonals wide.

    Args:
        weights: (F,) how much each frame's value counts.
        values: (F, K) what is wanted.
        near: (F,) frames where the result may differ from zero.
        frame_time: [s].
        settle: [s] what is quicker than this is smoothed away.
        slack: [s] how long a speed goes on where nothing is wanted.

    Returns:
        (F, K).
    """
    bands = stiffness(len(weights), frame_time, settle, slack)
    bands[0] += weights
    return least(bands, weights[:, None] * values, near)


def stiffness(frames: int, frame_time: float, settle: float, slack: float) -> Floats:
    """(3, F) the matrix of  s^4 |d''|^2 + (s^4 / l^2) |d'|^2  (see `fit`): its main diagonal and the two below it."""
    accel = (settle / frame_time) ** 4
    veloc = accel * (frame_time / slack) ** 2
    bands = np.zeros((3, frames))
    # D2^T D2 and D1^T D1; at the clip's own ends nothing pulls
    if frames > 2:
        for offset, weight in ((0, 1.0), (1, 4.0), (2, 1.0)):
            bands[0, offset : frames - 2 + offset] += weight * accel
        for offset, weight in ((0, -2.0), (1, -2.0)):
            bands[1, offset : frames - 2 + offset] += weight * accel
        bands[2, : frames - 2] += accel
    bands[0, :-1] += veloc
    bands[0, 1:] += veloc
    bands[1, :-1] -= veloc
    return bands


def least(bands: Floats, right: Floats, near: Bools) -> Floats:
    """(F, K) the solution of a system (3, F) with right side (F, K) that is zero outside `near` (F,)."""
    bands = bands.copy()
    bands[0] += 1e-12
    # frames that must not move leave the system: their rows and columns become those of the identity
    away = ~near
    bands[0, away] = 1.0
    bands[1, :-1][away[:-1] | away[1:]] = 0.0
    bands[2, :-2][away[:-2] | away[2:]] = 0.0
    return banded.solve(bands, np.where(near[:, None], right, 0.0))


def sloped(x: Floats, most: float) -> Floats:
    """(F,) the least curve that is nowhere below `x` (F,) and changes by no more than `most` from frame to frame."""
    out = x
    step = 1
    while step < len(x) and step * most < float(x.max() - x.min()):
        later, earlier = out.copy(), out.copy()
        later[step:] = np.maximum(later[step:], out[:-step] - step * most)
        earlier[:-step] = np.maximum(earlier[:-step], out[step:] - step * most)
        out = np.maximum(later, earlier)
        step *= 2
    return out


def covered(need: Floats, width: int) -> Floats:
    """(F,) a smooth curve that is nowhere below `need` (F,), and 0 farther than four widths from where that is not."""
    return _ended_mean(_ended_mean(running_maximum(need, 2 * width), width), width)


def running_maximum(x: Floats, half: int) -> Floats:
    """The largest of each frame's neighbours within `half` frames, by doubling."""
    padded = np.concatenate([np.zeros(half), x, np.zeros(half)])
    size, width = 1, 2 * half + 1
    while 2 * size <= width:
        padded = np.maximum(padded[:-size], padded[size:])
        size *= 2
    return np.asarray(np.maximum(padded[: len(x)], padded[width - size : width - size + len(x)]))


def _ended_mean(x: Floats, half: int) -> Floats:
    """`running_mean`, ended where it has all but died away."""
    mean = running_mean(x, half)
    return np.where(mean > 1e-9, mean, 0.0)


def running_mean(x: Floats, half: int) -> Floats:
    """The mean of each frame's neighbours within `half` frames; the ends go on beyond the clip."""
    padded = np.concatenate([np.full(half, x[0]), x, np.full(half, x[-1])])
    width = 2 * half + 1
    return np.convolve(padded, np.full(width, 1.0 / width), mode="valid")


def gamma(u: Floats) -> Floats:
    """The descending cubic step on [0, 1] (G eq. 10)."""
    u = np.clip(u, 0.0, 1.0)
    return (2.0 * u - 3.0) * u * u + 1.0


def _cubic(pinned: Bools, values: Floats, frame_time: float, seconds: float) -> Floats:
    """Glardon's eases (G eq. 9), which meet in the middle where two contacts are closer than two sigma."""
    sigma = ease_frames(frame_time, seconds)
    out = np.where(pinned[:, None], values, 0.0)
    spans = runs(pinned)
    frames = len(pinned)
    for (_, a), (b, _) in pairwise(spans):
        if b - a < 2 * sigma:  # from one displacement to the other, never through zero, never their sum
            fall = gamma((np.arange(a, b) - (a - 1)) / (b - (a - 1)))[:, None]
            out[a:b] = fall * values[a - 1] + (1.0 - fall) * values[b]
    for k, (start, end) in enumerate(spans):
        before = spans[k - 1][1] if k else -(2 * sigma)
        after = spans[k + 1][0] if k + 1 < len(spans) else frames + 2 * sigma
        if start - before >= 2 * sigma:
            t = np.arange(max(start - sigma, 0), start)
            out[t] = (1.0 - gamma((t - start + sigma) / sigma))[:, None] * values[start]
        if after - end >= 2 * sigma:
            t = np.arange(end, min(end + sigma, frames))
            out[t] = gamma((t - (end - 1)) / sigma)[:, None] * values[end - 1]
    return out


def _hermite(pinned: Bools, values: Floats, track: Floats, frame_time: float, seconds: float) -> Floats:
    """Kim & Neff's joins (K §7.1): between a plant and the free motion the track is a Hermite spline.

    It takes N_b frames, the gap between free and constrained place over the way the joint goes in a frame of the
    plant, at most the ease. Where two plants are closer than two eases their displacements are interpolated as in
    `_cubic`, since both splines would claim the same frames.
    """
    out = _cubic(pinned, values, frame_time, seconds)
    most = ease_frames(frame_time, seconds)
    spans = runs(pinned)
    frames = len(pinned)
    for k, (start, end) in enumerate(spans):
        step = np.linalg.norm(np.diff(track[start:end], axis=0), axis=1)
        usual = float(step.mean()) if len(step) else 0.0
        before = spans[k - 1][1] if k else -2 * most
        after = spans[k + 1][0] if k + 1 < len(spans) else frames + 2 * most
        for edge, outside, room in ((start, -1, start - before), (end - 1, 1, after - end)):
            if room < 2 * most:
                continue
            gap = float(np.linalg.norm(values[edge]))
            count = int(np.clip(np.ceil(gap / max(usual, 1e-12)), 2, most))
            free = edge + outside * (count + 1)
            span = edge + outside * np.arange(1, most + 1)
            span = span[(span >= 0) & (span < frames)]
            out[span] = 0.0
            if not 0 <= free + outside < frames:
                continue
            t = edge + outside * np.arange(1, count + 1)
            out[t] = _spline(track, values, free, edge, outside, count) - track[t]
    return out


def _spline(track: Floats, values: Floats, free: int, edge: int, outside: int, count: int) -> Floats:
    """(count, K) the places between plant and free motion, in the order of frames away from the plant."""
    F_u, F_c = track[free], track[edge] + values[edge]
    T = track[free] - track[free + outside]  # as the free motion runs there, towards the plant
    size = np.linalg.norm(F_u - F_c) / max(float(np.linalg.norm(T)), 1e-12)
    at_free, at_plant = 0.5 * size * T, 0.1 * size * T * np.array([0.0, 1.0, 0.0])
    i = np.arange(count)[::-1]  # K counts from the free frame to the constrained one
    w = 1.0 - np.cos(0.5 * np.pi * (i + 0.5) / count)
    w2, w3 = w**2, w**3
    basis = np.stack([2 * w3 - 3 * w2 + 1, w3 - 2 * w2 + w, -2 * w3 + 3 * w2, w3 - w2], axis=1)
    return np.asarray(basis @ np.stack([F_u, at_free, F_c, at_plant]))

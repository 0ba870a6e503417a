"""Root-only correction: the root moves so that what is planted stands still; no limb is touched.

Source: Lyard and Magnenat-Thalmann, A simple footskate removal method for virtual reality applications,
The Visual Computer 23 (2007), section 3.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.ease import EaseParams, ended, fit, within_reach
from footfix.motion.clip import Bools, Floats, Ints


@dataclass(frozen=True, kw_only=True)
class RootParams:
    """How the root carries the correction."""

    speed_window: float = 0.1  # [s] over which the speeds of sole points are averaged before they are compared
    hand_over: float = 0.01  # leg lengths of movement that a hand-over from point to point counts for
    calm: float = 0.03  # [s] over which what the root's steps gain is averaged; 0 for none, as in the paper
    vertical: bool = True  # one offset and one scale of the root's height, so that planted points are at the floor
    keep_slide: float = 0.004  # leg lengths: where no plant slides farther, nor is farther from its floor than
    keep_height: float = 0.012  # leg lengths, the root stays as it is
    pin_end: bool = False  # bring the path's drift back to zero over the clip
    settle: float = 0.1  # [s] what is quicker in the feet's shared correction is left to the legs (method both)


def shared(
    planted: Sequence[Bools], shifts: Sequence[Floats], frame_time: float, ease: EaseParams, params: RootParams
) -> Floats:
    """(F, 3) [m] the part of the feet's displacements that all planted feet share, smooth over time."""
    weights = np.sum(planted, axis=0).astype(np.float64)
    total = np.sum([np.where(on[:, None], shift, 0.0) for on, shift in zip(planted, shifts, strict=True)], axis=0)
    mean = total / np.maximum(weights, 1.0)[:, None]
    near = within_reach(weights > 0, frame_time, ease.seconds)
    return ended(fit(weights, mean, near, frame_time, params.settle, ease.slack))


def correction(
    root: Floats,
    tracks: Sequence[Floats],
    planted: Bools,
    levels: Floats,
    frame_time: float,
    leg_length: float,
    params: RootParams,
) -> Floats:
    """The shift of the root that lets one planted point at a time stand still.

    Args:
        root: (F, 3) [m] track of the root.
        tracks: for each of E sole points its (F, 3) [m] track.
        planted: (F, E) which points may be static.
        levels: (F, E) [m] height of the floor under each.
        frame_time: [s].
        leg_length: [m].
        params: measures.

    Returns:
        (F, 3) [m], zero in the first frame but for its vertical part.
    """
    frames = len(root)
    points = np.stack(tracks, axis=1)  # (F, E, 3)
    offsets = points - root[:, None]  # o(v, t): from the root, in world axes
    speeds = _speeds(points, frame_time, params.speed_window)
    static = _static(speeds, planted, frame_time, params.hand_over * leg_length)
    shift = np.zeros((frames, 3))
    if not np.any(static >= 0):
        return shift
    steps = np.diff(root, axis=0)[:, [0, 2]]
    # one static point, or two in turn; in flight the root's own velocity stays
    t = np.flatnonzero((static[:-1] >= 0) & (static[1:] >= 0))
    sharp = _speeds(points, frame_time, 0.0)
    more = _steps(t, static[t], static[t + 1], offsets, sharp)[:, [0, 2]] - steps[t]
    steps[t] += _calmed(more, t, frames, round(params.calm / frame_time / 2))
    path = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    shift[:, [0, 2]] = path - (root - root[0])[:, [0, 2]]
    if params.pin_end and frames > 1:
        u = np.linspace(0.0, 1.0, frames)[:, None]
        shift -= (3.0 - 2.0 * u) * u * u * shift[-1]
    if params.vertical:
        shift[:, 1] = _height(root[:, 1], points[..., 1], static, levels)
    return shift


def _calmed(more: Floats, t: Ints, frames: int, half: int) -> Floats:
    """(N, 2) [m] what the steps t (N,) gain, averaged over the planted steps within `half` frames of each.

    One point at a time is held, and with it its noise, which the whole figure would shake with.
    """
    total = np.zeros((frames + 2 * half, 3))
    total[t + half, :2], total[t + half, 2] = more, 1.0
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(total, axis=0)])
    window = sums[t + 2 * half + 1] - sums[t]
    return np.asarray(window[:, :2] / window[:, 2:])


def _speeds(points: Floats, frame_time: float, window: float) -> Floats:
    """(F, E) [m/s] speeds of the sole points, averaged over the window (L §3.1.2)."""
    if len(points) < 2:
        return np.zeros(points.shape[:2])
    speed: Floats = np.linalg.norm(np.gradient(points, frame_time, axis=0), axis=2)
    half = round(window / frame_time / 2)
    if half == 0:
        return np.asarray(speed)
    padded = np.concatenate([np.repeat(speed[:1], half + 1, axis=0), speed, np.repeat(speed[-1:], half, axis=0)])
    total = np.cumsum(padded, axis=0)
    return np.asarray((total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1))


def _static(speeds: Floats, planted: Bools, frame_time: float, cost: float) -> Ints:
    """(F,) the point that moves least of those in contact, -1 in flight.

    L takes the slowest frame by frame; under noise that goes to and fro, and each time leaves a little of the
    way behind. So the path over all frames is taken that moves least in total, a hand-over counting as a move of
    `cost` [m] (Viterbi, over stretches in which the same points are planted and the same one is slowest).
    """
    slowest = np.where(planted.any(axis=1), np.argmin(np.where(planted, speeds, np.inf), axis=1), -1)
    changes = np.any(planted[1:] != planted[:-1], axis=1) | (slowest[1:] != slowest[:-1])
    starts = np.concatenate([[0], np.flatnonzero(changes) + 1])
    moved = np.where(planted[starts], np.add.reduceat(speeds * frame_time, starts, axis=0), np.inf)
    best = np.zeros(planted.shape[1])
    came = np.zeros(moved.shape, dtype=np.intp)
    for k, move in enumerate(moved):
        if slowest[starts[k]] < 0:  # in flight: whatever comes next is free to choose
            came[k], best = int(np.argmin(best)), np.full_like(best, best.min())
            continue
        cheapest = int(np.argmin(best))
        stay = best <= best[cheapest] + cost
        came[k] = np.where(stay, np.arange(len(best)), cheapest)
        best = np.where(stay, best, best[cheapest] + cost) + move
    chosen = np.empty(len(starts), dtype=np.intp)
    state = int(np.argmin(best))
    for k in range(len(starts) - 1, -1, -1):
        chosen[k] = state
        state = int(came[k, state])
    static = np.repeat(chosen, np.diff(np.concatenate([starts, [len(planted)]])))
    return np.asarray(np.where(slowest >= 0, static, -1))


def _steps(t: Ints, i: Ints, j: Ints, offsets: Floats, speeds: Floats) -> Floats:
    """(N, 3) [m] the root's way from t to t + 1 while point i is static, then j (L eq. 1)."""
    q = _hand_over(t, i, j, speeds)
    # o(v, t + q) from a Catmull-Rom spline, at the share of the way that the speed says is gone by then
    at_i = _spline(offsets, t, i, _gone(speeds, t, i, q))
    at_j = _spline(offsets, t, j, _gone(speeds, t, j, q))
    return np.where(
        (i == j)[:, None],
        offsets[t, i] - offsets[t + 1, i],
        offsets[t, i] - at_i + at_j - offsets[t + 1, j],
    )


def _hand_over(t: Ints, i: Ints, j: Ints, speeds: Floats) -> Floats:
    """(N,) q in [0, 1], where the speeds of i and j cross between t and t + 1; half way if they don't."""
    cubic = _catmull_rom(speeds, t, i) - _catmull_rom(speeds, t, j)
    roots = cubic_roots(cubic)
    inside = np.isfinite(roots) & (roots >= 0.0) & (roots <= 1.0)
    # the crossing at which j becomes the slower one; the first if there are several
    rising = 3.0 * cubic[:, :1] * roots**2 + 2.0 * cubic[:, 1:2] * roots + cubic[:, 2:3] >= 0.0
    q = np.min(np.where(inside & rising, roots, np.inf), axis=1)
    return np.where(np.isfinite(q), q, 0.5)


def _catmull_rom(values: Floats, t: Ints, v: Ints) -> Floats:
    """(N, 4, ...) coefficients, highest power first, of the Catmull-Rom spline from t to t + 1."""
    last = len(values) - 1
    p0, p1, p2, p3 = (values[np.clip(t + k, 0, last), v] for k in (-1, 0, 1, 2))
    return np.stack(
        [
            0.5 * (-p0 + 3.0 * p1 - 3.0 * p2 + p3),
            0.5 * (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3),
            0.5 * (p2 - p0),
            p1,
        ],
        axis=1,
    )


def _spline(values: Floats, t: Ints, v: Ints, u: Floats) -> Floats:
    a, b, c, d = np.moveaxis(_catmull_rom(values, t, v), 1, 0)
    w = u[:, None]
    return np.asarray(((a * w + b) * w + c) * w + d)


def _gone(speeds: Floats, t: Ints, v: Ints, q: Floats) -> Floats:
    """(N,) the integral of V over [t, t + q], over that over [t, t + 1]."""
    a, b, c, d = _catmull_rom(speeds, t, v).T

    def integral(x: Floats) -> Floats:
        return np.asarray((((a / 4.0 * x + b / 3.0) * x + c / 2.0) * x + d) * x)

    whole = integral(np.ones_like(q))
    share = integral(q) / np.where(whole > 1e-12, whole, 1.0)
    return np.clip(np.where(whole > 1e-12, share, q), 0.0, 1.0)


def cubic_roots(coefficients: Floats) -> Floats:
    """Real roots of cubics, in closed form.

    Args:
        coefficients: (N, 4), highest power first; leading zeros make it a quadratic or a line.

    Returns:
        (N, 3), NaN where there are fewer. Source: R. W. D. Nickalls, A new approach to solving the cubic:
        Cardan's solution revealed, The Mathematical Gazette 77 (1993).
    """
    a, b, c, d = np.asarray(coefficients, dtype=np.float64).T
    roots = np.full((len(a), 3), np.nan)
    size = np.abs(coefficients).max(axis=1, initial=0.0)
    cubic = np.abs(a) > 1e-9 * size
    square = ~cubic & (np.abs(b) > 1e-9 * size)
    line = ~cubic & ~square & (np.abs(c) > 1e-9 * size)
    with np.errstate(all="ignore"):
        # Nickalls: the point of symmetry (x_n, y_n), delta its distance to the turning points, h their height
        x_n = -b / (3.0 * a)
        y_n = ((a * x_n + b) * x_n + c) * x_n + d
        delta2 = (b * b - 3.0 * a * c) / (9.0 * a * a)
        h2 = 4.0 * a * a * delta2**3
        wide = np.sqrt(np.maximum(y_n * y_n - h2, 0.0))
        one = x_n + np.cbrt((-y_n + wide) / (2.0 * a)) + np.cbrt((-y_n - wide) / (2.0 * a))
        delta = np.sqrt(np.maximum(delta2, 0.0))
        theta = np.arccos(np.clip(-y_n / (2.0 * a * delta**3), -1.0, 1.0)) / 3.0
        three = np.stack([x_n + 2.0 * delta * np.cos(theta + k * 2.0 * np.pi / 3.0) for k in (0, 1, 2)], axis=1)
        single = cubic & (y_n * y_n > h2)
        root = np.sqrt(c * c - 4.0 * b * d)
        both = np.stack([(-c + root) / (2.0 * b), (-c - root) / (2.0 * b)], axis=1)
    roots[single, 0] = one[single]
    triple = cubic & ~single
    # delta = 0: all three roots are one
    roots[triple] = np.where(delta[triple, None] > 0.0, three[triple], x_n[triple, None])
    roots[square, :2] = both[square]
    roots[line, 0] = -d[line] / c[line]
    return roots


def _height(root: Floats, heights: Floats, static: Ints, levels: Floats) -> Floats:
    """(F,) [m] one offset dH and one scale alpha of the root's height (L §3.3)."""
    t = np.flatnonzero(static >= 0)
    above = heights[t, static[t]] - levels[t, static[t]]
    offset = -above.mean()
    mean = float(root.mean() + offset)
    r = root - root.mean()
    relative = above - root[t]  # l: the static point, seen from the root
    spread = float(np.sum(r[t] ** 2))
    alpha = -float(np.sum(r[t] * (mean + relative))) / spread if spread > 1e-12 else 1.0
    return np.asarray(offset + (alpha - 1.0) * r)

"""The instant between two frames at which one static point hands over to the next (L section 3.2.1).

Source: E. Lyard, N. Magnenat-Thalmann, A simple footskate removal method for virtual reality applications, The
Visual Computer 23 (2007).
"""

from __future__ import annotations

import numpy as np

from footfix.motion.clip import Floats, Ints


def hand_over(t: Ints, i: Ints, j: Ints, speeds: Floats) -> Floats:
    """Find when the speeds of two points cross: V_i(q) = V_j(q).

    Args:
        t: (N,) frames, each hand-over between t and t + 1.
        i: (N,) the points that are static until then.
        j: (N,) those that are from then on.
        speeds: (F, E) [m/s] of all points.

    Returns:
        (N,) q in [0, 1]: the first crossing at which j becomes the slower one; 0.5 where there is none.
    """
    cubic = catmull_rom(speeds, t, i) - catmull_rom(speeds, t, j)
    roots = cubic_roots(cubic)
    inside = np.isfinite(roots) & (roots >= 0.0) & (roots <= 1.0)
    rising = 3.0 * cubic[:, :1] * roots**2 + 2.0 * cubic[:, 1:2] * roots + cubic[:, 2:3] >= 0.0
    q = np.min(np.where(inside & rising, roots, np.inf), axis=1)
    return np.where(np.isfinite(q), q, 0.5)


def offset_at(offsets: Floats, speeds: Floats, t: Ints, v: Ints, q: Floats) -> Floats:
    """Place points at t + q, on Catmull-Rom splines at the share of their way that is gone by then.

    Args:
        offsets: (F, E, 3) [m] o(v, t), from the root.
        speeds: (F, E) [m/s].
        t: (N,) frames.
        v: (N,) points.
        q: (N,) in [0, 1].

    Returns:
        (N, 3) [m] o(v, t + q).
    """
    a, b, c, d = np.moveaxis(catmull_rom(offsets, t, v), 1, 0)
    w = share_gone(speeds, t, v, q)[:, None]
    return np.asarray(((a * w + b) * w + c) * w + d)


def share_gone(speeds: Floats, t: Ints, v: Ints, q: Floats) -> Floats:
    """Integrate V over [t, t + q], and divide by the integral over [t, t + 1]: (N,), from 0 to 1."""
    a, b, c, d = catmull_rom(speeds, t, v).T

    def integral(x: Floats) -> Floats:
        return np.asarray((((a / 4.0 * x + b / 3.0) * x + c / 2.0) * x + d) * x)

    whole = integral(np.ones_like(q))
    share = integral(q) / np.where(whole > 1e-12, whole, 1.0)
    return np.clip(np.where(whole > 1e-12, share, q), 0.0, 1.0)


def catmull_rom(values: Floats, t: Ints, v: Ints) -> Floats:
    """Give the Catmull-Rom spline of some columns of `values` (F, E, ...) from t to t + 1.

    Args:
        values: the values at the frames; the first and the last one go on beyond the clip.
        t: (N,) frames.
        v: (N,) columns.

    Returns:
        (N, 4, ...) coefficients, highest power first.
    """
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


def cubic_roots(coefficients: Floats) -> Floats:
    """Find the real roots of cubics in closed form.

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

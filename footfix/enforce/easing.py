"""Easing: how the displacement of a held effector fades in before a contact and out after it.

Source: P. Glardon, R. Boulic, D. Thalmann, Robust on-line adaptive footplant detection and enforcement for
locomotion, The Visual Computer 22 (2006), sections 5.1 and 5.3.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from footfix.motion.clip import Floats

Span = tuple[int, int]  # frames [start, end)


def gamma(u: Floats) -> Floats:
    """Evaluate the descending cubic step: 1 for u <= 0, 0 for u >= 1, flat at both (G eq. 10)."""
    u = np.clip(u, 0.0, 1.0)
    # Gamma(u) = 2 u^3 - 3 u^2 + 1
    return np.asarray((2.0 * u - 3.0) * u * u + 1.0)


def ease_frames(seconds: float, frame_time: float) -> int:
    """Count the whole frames of an ease of `seconds` [s], at least one."""
    return max(1, round(seconds / frame_time))


def led_over(spans: Sequence[Span], values: Floats, sigma: int) -> Floats:
    """Keep a displacement (F, K) in contacts, and interpolate it between any two closer than 2 sigma frames.

    It goes from that at the end of one to that at the start of the next: their eases would neither add up nor come
    back to zero in between.
    """
    out = np.zeros_like(values)
    for start, end in spans:
        out[start:end] = values[start:end]
    for (_, a), (b, _) in pairwise(spans):
        if b - a < 2 * sigma:
            fall = gamma((np.arange(a, b) - (a - 1)) / (b - (a - 1)))[:, None]
            out[a:b] = fall * values[a - 1] + (1.0 - fall) * values[b]
    return out


def eased(spans: Sequence[Span], values: Floats, sigma: int) -> Floats:
    """Extend a displacement known during contacts to the frames around them (G eq. 9).

    Between close contacts it is interpolated, see `led_over`.

    Args:
        spans: frames `[start, end)` of the contacts of one effector, in order of time, not overlapping.
        values: (F, K) the displacement C_p - E_0(t), needed in the frames of the contacts only.
        sigma: frames of an ease.

    Returns:
        (F, K) `values` during contacts, exactly zero farther than sigma from any.
    """
    out = led_over(spans, values, sigma)
    frames, far = len(values), 2 * sigma
    for k, (start, end) in enumerate(spans):
        if k == 0 or start - spans[k - 1][1] >= far:
            # E(t) = E_0(t) + (1 - Gamma((t - t_1 + sigma) / sigma)) (C_p - E_0(t_1)),  t_1 = start
            t = np.arange(max(start - sigma, 0), start)
            out[t] = (1.0 - gamma((t - start + sigma) / sigma))[:, None] * values[start]
        if k + 1 == len(spans) or spans[k + 1][0] - end >= far:
            # E(t) = E_0(t) + Gamma((t - t_2) / sigma) (C_p - E_0(t_2)),  t_2 = end - 1
            t = np.arange(end, min(end + sigma, frames))
            out[t] = gamma((t - (end - 1)) / sigma)[:, None] * values[end - 1]
    return out


def replanned(new: Floats, share: Floats, left_over: Floats) -> Floats:
    """Lead an effector over to a new motion when the plan changes in the middle of an ease (G eq. 11).

    At the time t' of the change the effector is at E(t'), moving to a contact that may be dropped. From then on it
    is to follow N(t), the new motion with its own enforcement, such as E_0'(t) + (1 - Gamma(u)) (C' - E_0'(t_1')) up
    to a contact C' at t_1'. As printed, eq. 11 jumps: at t = t' it is C'. Here what the effector was off the new
    motion fades out:

        E(t) = N(t) + Gamma(u) (E(t') - N(t')),  u = (t - t') / (t_1' - t')

    which is E(t') at t = t' and C' at t = t_1'. The velocity at t' is that of the new motion. Displacements from a free
    motion that goes on are led over alike, and so are angles.

    Args:
        new: (..., K) [m] N(t), at the times asked for.
        share: (...) u, from 0 at t' to 1 when it is over.
        left_over: (..., K) [m] E(t') - N(t').

    Returns:
        (..., K) [m] E(t).
    """
    return np.asarray(new + gamma(share)[..., None] * left_over)

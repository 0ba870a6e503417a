"""No joint jumps: how much quicker than captured joints may turn in frames that are about to be shown.

Two rounds of least squares do not bring down every step, and a strike that is seen late may ask for more than a leg
can do. The legs then follow as fast as they may, and the foot does not stand until they have got there.
"""

from __future__ import annotations

import numpy as np

from footfix.enforce.leg import LEG, ROOT, K, Q, W
from footfix.motion.clip import Bools, Floats
from footfix.stream.legs import Legs

_FASTEST = 185.0  # [degrees/s] by which a joint may turn faster than captured


def limited(legs: Legs, x: Floats, past: int, frame_time: float) -> tuple[Floats, Bools]:
    """Let no joint turn much faster than captured.

    Args:
        legs: as captured, n frames.
        x: (U, n) their state.
        past: of these frames, how many were shown already.
        frame_time: [s].

    Returns:
        (U, n) the state, and (L, n) in which frames a leg was held back.
    """
    L, n = len(legs.kinds.legs), x.shape[1]
    late = np.zeros((L, n), dtype=np.bool_)
    most = np.radians(_FASTEST) * frame_time
    own = x[ROOT:].reshape(L, LEG, n).swapaxes(0, 1)  # (8, L, n)
    turns = _turns(own, legs.axis)
    first = max(past, 1)
    if not np.any(np.sum(np.diff(turns[..., first - 1 :]) ** 2, axis=1) > most**2):
        return x, late
    own = own.copy()
    for t in range(first, n):
        step = _turns(own[..., t - 1 : t + 1], legs.axis[..., t - 1 : t + 1])
        size = np.sqrt(np.sum((step[..., 1] - step[..., 0]) ** 2, axis=1)).max(axis=0)  # (L,)
        late[:, t] = size > most
        share = most / np.maximum(size, most)
        own[..., t] = own[..., t - 1] + share * (own[..., t] - own[..., t - 1])
    return np.concatenate([x[:ROOT], own.swapaxes(0, 1).reshape(-1, n)]), late


def _turns(x: Floats, axis: Floats) -> Floats:
    """(3, 3, L, n) about how hip, knee and ankle are turned: q - k/2 axis, k, w - q - k/2 axis; see `enforce.terms`."""
    bent = 0.5 * axis * x[K]
    return np.stack([x[Q] - bent, 2.0 * bent, x[W] - x[Q] - bent])

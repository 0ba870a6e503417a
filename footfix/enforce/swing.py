"""The way of the knee while its foot is not held.

Of a straight leg some millimetres of the foot are many degrees of the knee, of a bent one hardly any. A correction
that goes on from plant to plant in the foot's place makes straight knees snap; one that goes on in the knee's bend
hands each flutter of a straight knee, which nobody sees, to the foot of the leg that is bent now. So both count.
"""

from __future__ import annotations

import numpy as np

from footfix.enforce.ease import HELD, EaseParams, fit, least, left_at_edges, stiffness
from footfix.enforce.ik import Hinge, not_too_straight
from footfix.motion.banded import product
from footfix.motion.clip import Bools, Floats


def more_bent(
    hinge: Hinge, more: Floats, known: Bools, near: Bools, frame_time: float, params: EaseParams
) -> Floats:
    """(F,) [rad] by how much a knee bends more than captured.

    Least change of velocity and acceleration, of the bend d and of the leg's length e(d) alike:

        w |d - v|^2 + <d, A d> + m <e, A e>,   e(d) = length(captured + d) - length(captured)

    with A of `ease.fit`, in one step of Gauss and Newton from where d alone would lead. A radian of the knee's bend
    moves the knee by a quarter of the leg, so m is the square of `foot_first` over that.

    Args:
        hinge: the knee as captured.
        more: (F,) [rad] how much more it bends, where that is known.
        known: (F,) where it is.
        near: (F,) where it may differ from zero.
        frame_time: [s].
        params: measures.
    """
    weights = known.astype(np.float64)
    if np.all(known | ~near):
        return np.where(known, more, 0.0)
    d = fit(weights, more[:, None], near, frame_time, params.settle, params.slack)[:, 0]
    slope, length = hinge.slope(hinge.flexion + d), hinge.length(hinge.flexion + d)
    rest = length - hinge.length(hinge.flexion) - slope * d  # e(d) is nearly slope d + rest
    foot = (params.foot_first / (0.25 * float(np.median(hinge.length(np.zeros(1)))))) ** 2
    a = stiffness(len(d), frame_time, params.settle, params.slack)
    both = a.copy()
    for k in range(3):
        both[k, : len(d) - k] += foot * slope[: len(d) - k] * slope[k:] * a[k, : len(d) - k]
    both[0] += weights
    right = weights * more - foot * slope * product(a, rest)
    d = least(both, right[:, None], near)[:, 0]
    d += left_at_edges(known, (more - d)[:, None], near, frame_time, params)[:, 0]
    return np.where(known, more, np.where(near, d, 0.0))


def within_bounds(
    hinge: Hinge, more: Floats, share: Floats, free: Bools, frame_time: float, params: EaseParams
) -> Floats:
    """(F,) [rad] a knee bent so much more (F,) than captured, but no straighter than it may be.

    What that takes off comes and goes smoothly, but for frames that are not `free` (F,), where it is nothing;
    `share` (F,) as of `ik.not_too_straight`.
    """
    taken = np.where(free, not_too_straight(hinge, more, share) - hinge.flexion - more, 0.0)
    if np.any(taken):
        weights = np.where(free, 1.0, HELD)
        everywhere = np.ones(len(more), dtype=np.bool_)
        taken = fit(weights, taken[:, None], everywhere, frame_time, params.bound, np.inf)[:, 0]
    return np.maximum(hinge.flexion + more + taken, np.minimum(hinge.flexion, hinge.least))

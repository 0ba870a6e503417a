"""Toe joints that stand put exactly where they stand, in frames that are about to be shown.

Rounds of least squares leave some tenths of a millimetre, more where a foot just landed or is about to leave. What is
left is taken out by the leg alone, at the height there is, in the shortest way: x' = x + W J' (J W J')^-1 r.
"""

from __future__ import annotations

import numpy as np

from footfix.enforce.leg import LEG, ROOT, TOE, K, W
from footfix.motion.clip import Floats
from footfix.stream.legs import POINTS, Legs, posed
from footfix.stream.pins import Stacked

_FARTHEST = 0.02  # [leg lengths] what is farther off than this can't be held, or has another place
_FOOT = 0.1  # share in it of the foot's turn
_TIMES = 2
_LEAST = 1e-4  # [leg lengths^2] added to what can hardly be moved
_TOE = [TOE + POINTS * c for c in range(3)]  # rows of the toe joint in a Jacobian
_MOVED = slice(0, K + 4)  # of a leg's unknowns: line, knee and foot


def exact(legs: Legs, x: Floats, pins: Stacked, shown: slice, leg_length: float) -> Floats:
    """Put the toe joints of planted feet where they stand.

    Args:
        legs: as captured, n frames.
        x: (U, n) a state.
        pins: of the window.
        shown: the frames that are about to be shown.
        leg_length: [m].

    Returns:
        (U, n) the state, changed in those frames alone.
    """
    asked = pins.placed[TOE, :, shown] > 0.0  # (L, m)
    if not asked.any():
        return x
    some, root = legs.frames(shown), x[:ROOT, shown]
    own = np.array(x[ROOT:, shown].reshape(len(asked), LEG, -1).swapaxes(0, 1))  # (8, L, m)
    weights = np.ones(_MOVED.stop)
    weights[W] = _FOOT
    for _ in range(_TIMES):
        at = posed(some, root, own)
        off = pins.place[:, TOE, :, shown] - at.places[:, TOE]  # (3, L, m)
        off[1] = 0.0
        near = asked & (off[0] ** 2 + off[2] ** 2 < (_FARTHEST * leg_length) ** 2)
        jacobian = at.jacobian[:, :, _TOE, ROOT : ROOT + _MOVED.stop]  # (L, m, 3, 7)
        back = weights[:, None] * jacobian.swapaxes(2, 3)
        square = jacobian @ back + (_LEAST * leg_length) ** 2 * np.eye(3)
        step = back @ np.linalg.solve(square, (off * near).transpose(1, 2, 0)[..., None])
        own[_MOVED] += step[..., 0].transpose(2, 0, 1)
    out = x.copy()
    out[ROOT:, shown] = own.swapaxes(0, 1).reshape(-1, own.shape[2])
    return out

"""Lock planted toe joints exactly in place in frames that are about to be shown.

Rounds of least squares leave some tenths of a millimetre, more where a foot is about to leave. The leg alone removes
them, at the present height, by the smallest change: x' = x + W J' (J W J')^-1 r. A plant that begins is locked where
its foot is then, since its planned place may be too far to reach without a jump.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from footfix.enforce.easing import ease_frames, gamma
from footfix.enforce.leg import ROOT, TOE, K, W
from footfix.motion.clip import Bools, Floats, frozen
from footfix.motion.contacts import runs
from footfix.stream.legs import POINTS, Legs, own_of, places_of, states_of

_FARTHEST = 0.02  # [leg lengths] a toe that is farther off than this can't be held
_FOOT = 0.1  # weight of the foot's turn in that change
_ROUNDS = 2
_SHORT = 0.003  # [leg lengths] one round leaves a hundredth of a millimetre of a way as short as that
_LEAST = 1e-4  # [leg lengths] damping, for legs that can hardly move
_EASE = 0.06  # [s] over which the change fades after a foot has left
_TOE = [TOE + POINTS * c for c in range(3)]  # rows of the toe joint in a Jacobian
_MOVED = slice(0, K + 4)  # of a leg's unknowns: line, knee and foot


def exact(
    legs: Legs, x: Floats, place: Floats, asked: Bools, stands: Sequence[bool], leg_length: float, frame_time: float
) -> Floats:
    """Move the toe joints of planted feet to their places.

    Args:
        legs: as captured, in the n frames that are about to be shown.
        x: (U, n) their state.
        place: (3, L, n) [m] where toe joints are to stand,
        asked: (L, n) and when.
        stands: of each leg whether its toe joint has stood already in the frame before these.
        leg_length: [m].
        frame_time: [s].

    Returns:
        (U, n) the state.
    """
    if not asked.any():
        return x
    L, n = asked.shape
    root, own = x[:ROOT], own_of(x)  # (8, L, n)
    weights, change = np.ones(_MOVED.stop), np.zeros((_MOVED.stop, L, n))
    weights[W] = _FOOT
    at = states_of(legs, root, own)
    place, near = _places(place, at.places[:, TOE], asked, stands, _FARTHEST * leg_length)
    jacobian = at.jacobian[:, :, _TOE, ROOT : ROOT + _MOVED.stop]  # (L, n, 3, 7)
    back = weights[:, None] * jacobian.swapaxes(2, 3)
    square = jacobian @ back + (_LEAST * leg_length) ** 2 * np.eye(3)
    back = back @ np.linalg.inv(square)  # (L, n, 7, 3)
    off = place - at.places[:, TOE]
    for k in range(_ROUNDS):
        off *= near
        off[1] = 0.0
        change += (back @ off.transpose(1, 2, 0)[..., None])[..., 0].transpose(2, 0, 1)
        if k == _ROUNDS - 1 or np.abs(off).max() < _SHORT * leg_length:
            break
        moved = own.copy()
        moved[_MOVED] += change
        off = place - places_of(legs, root, moved)[:, TOE]
    _eased(change, asked, ease_frames(_EASE, frame_time))
    out = np.array(own)
    out[_MOVED] += change
    return np.concatenate([root, out.swapaxes(0, 1).reshape(-1, n)])


def _places(place: Floats, now: Floats, asked: Bools, stands: Sequence[bool], most: float) -> tuple[Floats, Bools]:
    """Choose the places (3, L, n) and frames (L, n) of planted toe joints; new plants begin at the present place."""
    place, near = place.copy(), asked & (np.hypot(*(place - now)[::2]) < most)
    for k, own in enumerate(asked):
        for start, end in runs(own):
            if start > 0 or not stands[k]:
                place[:, k, start:end] += (now - place)[:, k, start, None]
                near[k, start:end] = True
    return place, near


def _eased(change: Floats, asked: Bools, frames: int) -> None:
    """Fade a change (7, L, n) over some frames after a foot has left."""
    if asked.all():
        return
    share = _shares(frames)
    for k, own in enumerate(asked):
        for _, end in runs(own):
            after = int(np.argmax(np.append(own[end:], True)[:frames]))
            after = after if own[end:][:frames].any() else min(frames, len(own) - end)
            change[:, k, end : end + after] = change[:, k, end - 1, None] * share[:after]


@lru_cache(maxsize=8)
def _shares(frames: int) -> Floats:
    """Compute the remaining shares (frames,) of a change in the frames after it."""
    return frozen(gamma(np.arange(1, frames + 1) / (frames + 1)))

"""The evidence of the newest grid steps for all feet together, as `detect.evidence` computes for a clip.

A derivative depends on a few steps on both sides, the floor on the last second. So features are computed for the newest
steps alone, and those of a step change until a third of a second of later frames has come.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.detect.evidence import (
    BODY,
    BOTH,
    COLUMNS,
    FLOOR,
    LIFT,
    OTHER,
    OWN,
    OWN_FLOOR,
    SPEED,
)
from footfix.motion.clip import Floats
from footfix.stream.filters import Lowest, filtered
from footfix.stream.ground_velocities import Facing
from footfix.stream.time_grid import FOOT

_MARGIN = 14  # steps before the newest ones, on which their derivatives depend
_UNITS = np.array(list(OWN.values()))
_BODY_UNITS = np.array(list(BODY.values()))
_ASKED = [list(OWN).index(name) for name in OTHER]
_UP, _AHEAD, _ASIDE, _REACH = [1, 4], 6, 7, 8  # of what is differentiated: heel (3), toe (3) and these


def newest_evidence(places: Floats, facing: Facing, count: int, mates: Sequence[int], jitter: float) -> Floats:
    """Compute the features of each foot in the newest steps.

    Args:
        places: (n, 1 + 4 feet, 3) [leg lengths] of pelvis, and hip, ankle, heel and toe of each foot.
        facing: where the hips face, of as many steps at least as are looked at.
        count: how many of the newest steps are wanted.
        mates: for each foot the other one of its pair.
        jitter: noise of the capture, in thousandths of a leg.

    Returns:
        (feet, count, len(COLUMNS)) the curves of each foot.
    """
    feet, count = len(mates), min(count, len(places))
    part = places[-min(count + _MARGIN, len(places)) :]
    pelvis, foot = part[:, 0], part[:, 1:].reshape(len(part), feet, FOOT, 3)
    hip, ankle, soles = foot[:, :, 0], foot[:, :, 1], foot[:, :, 2:]  # (n, feet, 3), soles (n, feet, 2, 3)
    beside = ankle - pelvis[:, None]
    # over the ground as complex numbers: a product has the components along and across
    way = (beside[..., 0] + 1j * beside[..., 2]) * facing.outward[-len(part) :].conj()
    leg = ankle - hip
    x = np.empty((len(part), feet, 9))
    x[..., :6] = soles.reshape(len(part), feet, 6)
    x[..., _AHEAD], x[..., _ASIDE] = way.imag * facing.signs, way.real
    x[..., _REACH] = np.sqrt(np.add.reduce(leg * leg, axis=-1))
    speed = filtered(x, seconds=SPEED, degree=2, derivative=1)[-count:]
    own = np.empty((count, feet, len(OWN)))
    _over_floors(own, places, count, mates)
    own[..., 6:8] = speed[..., _UP]
    lift = filtered(x[..., [*_UP, _AHEAD]], seconds=LIFT, degree=2, derivative=2)[-count:]
    own[..., 8:10], own[..., 16] = lift[..., :2], lift[..., 2]
    own[..., 10:12] = np.hypot(speed[..., 0:6:3], speed[..., 2:6:3])
    own[..., 12:14], own[..., 14:16] = x[-count:, :, _AHEAD:_REACH], speed[..., _AHEAD:_REACH]
    own[..., 17], own[..., 18] = 1.0 - x[-count:, :, _REACH], speed[..., _REACH]
    found = np.empty((feet, count, len(COLUMNS)))
    others = len(OWN) + len(OTHER)
    found[..., : len(OWN)] = np.arcsinh(own / _UNITS).swapaxes(0, 1)
    found[..., len(OWN) : others] = found[list(mates)][..., _ASKED]
    found[..., others:] = _body(part[:, 0, 1], count, jitter)
    return found


def _over_floors(own: Floats, places: Floats, count: int, mates: Sequence[int]) -> None:
    """Fill in heel and toe over the floor ahead and behind, over their own, and the lower of them over its pair's."""
    feet = len(mates)
    height = places[:, 1:, 1].reshape(len(places), feet, FOOT)[..., 2:].T  # (2, feet, n)
    lower = np.minimum(height[0], height[1])
    # tracks (4, feet, n): the lower of heel and toe, the lowest of the pair, and both
    tracks = np.concatenate([lower[None], np.minimum(lower, lower[list(mates)])[None], height])
    lowest = Lowest(tracks.reshape(4 * feet, -1), OWN_FLOOR, count)
    one, pair, each = slice(0, feet), slice(feet, 2 * feet), slice(2 * feet, 4 * feet)
    height = height[..., -count:]
    over = own.T  # (20, feet, count)
    over[0:3:2] = height - lowest.ahead(FLOOR, one)
    over[1:4:2] = height - lowest.behind(FLOOR, one)
    floor = np.maximum(lowest.ahead(OWN_FLOOR, each), lowest.behind(OWN_FLOOR, each))
    over[4:6] = height - floor.reshape(2, feet, count)
    over[19] = lower[:, -count:] - np.minimum(lowest.ahead(BOTH, pair), lowest.behind(BOTH, pair))


def _body(height: Floats, count: int, jitter: float) -> Floats:
    """Compute how fast the pelvis rises, how it is accelerated, and how noisy the capture is, (count, 3)."""
    curves = np.empty((count, len(BODY)))
    curves[:, 0] = filtered(height, seconds=0.11, degree=2, derivative=1)[-count:]
    curves[:, 1] = filtered(height, seconds=0.15, degree=2, derivative=2)[-count:]
    curves[:, 2] = jitter
    return np.asarray(np.arcsinh(curves / _BODY_UNITS))

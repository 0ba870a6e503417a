"""The evidence of the newest steps of the grid, for all feet together: what `detect.evidence` says of a whole clip.

A derivative looks a few steps to both sides, the floor a second back. So curves are made for the newest steps alone,
and what is said of a moment changes until a third of a second of what follows it has come.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.detect.evidence import (
    BODY,
    BOTH,
    FACING,
    FLOOR,
    LIFT,
    OTHER,
    OWN,
    OWN_FLOOR,
    SPEED,
)
from footfix.motion.clip import Floats
from footfix.stream.filters import filtered, floors
from footfix.stream.grid import FOOT

_MARGIN = 14  # steps before the newest ones, on which their derivatives depend
_OWN_UNITS, _BODY_UNITS = (np.array(list(each.values()))[:, None] for each in (OWN, BODY))
_ASKED = [list(OWN).index(name) for name in OTHER]


def weigh(places: Floats, count: int, mates: Sequence[int], jitter: float) -> tuple[tuple[Floats, ...], Floats]:
    """Say what the newest steps show of each foot.

    Args:
        places: (n, 1 + 4 feet, 3) [leg lengths] of pelvis, and hip, ankle, heel and toe of each foot.
        count: how many of the newest steps are wanted.
        mates: for each foot the other one of its pair.
        jitter: noise of the capture, in thousandths of a leg.

    Returns:
        For each foot its curves (count, len(COLUMNS)), and (feet, n, 2) where the hips face.
    """
    feet = len(mates)
    count = min(count, len(places))
    part = places[-min(count + _MARGIN, len(places)) :]
    pelvis, hip, ankle, heel, toe = _apart(part)
    forward, outward = _axes(places, mates)
    ahead, aside = forward[-len(part) :], outward[-len(part) :]
    beside = (ankle - pelvis[:, None])[..., ::2]
    from_pelvis = np.stack([np.sum(beside * ahead, axis=-1), np.sum(beside * aside, axis=-1)], axis=-1)
    reach = np.linalg.norm(ankle - hip, axis=-1)
    fast = np.concatenate([heel, toe, from_pelvis, reach[..., None]], axis=-1)  # (n, feet, 9)
    speed = filtered(fast, seconds=SPEED, degree=2, derivative=1)
    lifted = np.stack([heel[..., 1], toe[..., 1], from_pelvis[..., 0]], axis=-1)
    lift = filtered(lifted, seconds=LIFT, degree=2, derivative=2)
    over = _over_floors(places, count, mates)
    curves = [
        *over[:6], *(speed[..., k] for k in (1, 4)), lift[..., 0], lift[..., 1],
        np.hypot(speed[..., 0], speed[..., 2]), np.hypot(speed[..., 3], speed[..., 5]),
        from_pelvis[..., 0], from_pelvis[..., 1], speed[..., 6], speed[..., 7], lift[..., 2],
        1.0 - reach, speed[..., 8], over[6],
    ]  # fmt: skip
    own = np.arcsinh(np.stack([each[-count:].T for each in curves], axis=1) / _OWN_UNITS)  # (feet, 20, count)
    body = _body(part[:, 0, 1], count, jitter)
    found = tuple(np.concatenate([own[k], own[mates[k]][_ASKED], body]).T for k in range(feet))
    return found, np.ascontiguousarray(forward.swapaxes(0, 1))


def _apart(places: Floats) -> tuple[Floats, ...]:
    """Pelvis (n, 3), and hip, ankle, heel, toe (n, feet, 3) each."""
    return places[:, 0], *(places[:, 1 + k :: FOOT] for k in range(FOOT))


def _axes(places: Floats, mates: Sequence[int]) -> tuple[Floats, Floats]:
    """(n, feet, 2) each: where the hips face over the ground, and outward on a foot's side."""
    _, hip, _, heel, toe = _apart(places)
    facing = (toe - heel)[..., ::2]
    alone = np.array([mate == k for k, mate in enumerate(mates)])
    outward = (hip - hip[:, list(mates)])[..., ::2]
    if alone.any():
        outward = np.where(alone[:, None], np.stack([-facing[..., 1], facing[..., 0]], axis=-1), outward)
    outward = filtered(outward, seconds=FACING, degree=1)
    outward = outward / np.maximum(np.hypot(outward[..., 0], outward[..., 1])[..., None], 1e-9)
    forward = np.stack([-outward[..., 1], outward[..., 0]], axis=-1)
    back = np.sum(forward * facing, axis=(0, 2)) < 0.0
    return forward * np.where(back, -1.0, 1.0)[:, None], outward


def _over_floors(places: Floats, count: int, mates: Sequence[int]) -> list[Floats]:
    """(count, feet) each: heel and toe over the floor ahead and behind, over their own, and the lower of a pair."""
    heel, toe = places[:, 3::FOOT, 1], places[:, 4::FOOT, 1]  # (n, feet)
    lowest = np.minimum(heel, toe)
    pair = np.minimum(lowest, lowest[:, list(mates)])
    ahead, behind = floors(lowest, lowest, FLOOR, count)
    both = np.minimum(*floors(pair, pair, BOTH, count))
    each = np.concatenate([heel, toe], axis=1)
    own = np.maximum(*floors(each, each, OWN_FLOOR, count))
    heel, toe, lowest = heel[-count:], toe[-count:], lowest[-count:]
    feet = heel.shape[1]
    return [
        heel - ahead, heel - behind, toe - ahead, toe - behind, heel - own[:, :feet], toe - own[:, feet:], lowest - both
    ]  # fmt: skip


def _body(height: Floats, count: int, jitter: float) -> Floats:
    """(3, count): how the pelvis rises and is accelerated, and how noisy the capture is."""
    rise = filtered(height, seconds=0.11, degree=2, derivative=1)
    lift = filtered(height, seconds=0.15, degree=2, derivative=2)
    curves = np.stack([rise, lift, np.full(len(height), jitter)])
    return np.asarray(np.arcsinh(curves / _BODY_UNITS)[:, -count:])

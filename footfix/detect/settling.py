"""Feet that have almost landed, or just begun to leave: contacts are extended over these frames.

The tests for slow steps leave the end of a step out of the contact that follows. A foot that looks planted there by
all other evidence, and has almost no distance left to go, counts as in contact already: otherwise the correction of
its place would show as a slide while it lands.

Nine in ten feet that walk onto a force plate have less than 0.02 leg lengths to go when they touch it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs


@dataclass(frozen=True, kw_only=True)
class SettlingParams:
    """How much of a step counts as contact at its start and end.

    Args:
        farthest: [leg lengths] greatest distance left to go, or gone already,
        share: [factor] and at most this share of the distance from one contact to the next, or to the end of the clip,
        within: [s] and for at most this long.
    """

    farthest: float = 0.022
    share: float = 0.15
    within: float = 0.05


def settled(part: Bools, looks: Bools, place: Floats, frame_time: float, params: SettlingParams) -> Bools:
    """Extend contacts of a part of a foot (F,) over adjoining frames in which it looks planted and hardly moves.

    Args:
        part: (F,) heel, or toe, in contact.
        looks: (F,) the same by the evidence of this foot alone.
        place: (F, 2) [leg lengths] over the ground.
        frame_time: [s].
        params: how far contacts are extended.
    """
    out, found, most = part.copy(), runs(part), round(params.within / frame_time)
    for k, (start, end) in enumerate(found):
        before = found[k - 1][1] if k else 1
        after = found[k + 1][0] if k + 1 < len(found) else len(part) - 1
        for at, outwards, other in (
            (start, np.arange(start - 1, before - 1, -1), before - 1),
            (end - 1, np.arange(end, after), after),
        ):
            way = float(np.linalg.norm(place[other] - place[at]))
            far = min(params.farthest, params.share * way)
            stays = looks[outwards] & (np.linalg.norm(place[outwards] - place[at], axis=1) <= far)
            out[outwards[: min(most, int(np.argmin(np.append(stays, False))))]] = True
    return out

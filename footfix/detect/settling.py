"""Feet that have all but landed, or hardly left: a contact is held over the last of the way there, and the first away.

What tells a step from a stand leaves the end of a step out of the contact it leads to. A foot that looks planted there
by all other evidence, and has next to nothing left to go, is held already: else what was found wrong with its place
would come out as a skid of its landing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs


@dataclass(frozen=True, kw_only=True)
class SettlingParams:
    """How much of a step counts as a stand at each of its ends.

    Args:
        farthest: [leg lengths] left to go, or gone, at most,
        share: [factor] no more than this of the way from one contact to the next,
        within: [s] and no longer than this.
    """

    farthest: float = 0.015
    share: float = 0.05
    within: float = 0.05


def settled(part: Bools, looks: Bools, place: Floats, frame_time: float, params: SettlingParams) -> Bools:
    """Hold a part of a foot (F,) in the frames beside its contacts in which it looks planted and hardly moves on.

    Args:
        part: (F,) heel, or toe, in contact.
        looks: (F,) the same as it looks by itself.
        place: (F, 2) [leg lengths] over the ground.
        frame_time: [s].
        params: how much that is.
    """
    out, found, most = part.copy(), runs(part), round(params.within / frame_time)
    for k, (start, end) in enumerate(found):
        before = found[k - 1][1] if k else 0
        after = found[k + 1][0] if k + 1 < len(found) else len(part)
        for at, outwards, other in (
            (start, np.arange(start - 1, before - 1, -1), before - 1 if k else None),
            (end - 1, np.arange(end, after), after if k + 1 < len(found) else None),
        ):
            far = params.farthest
            if other is not None:
                far = min(far, params.share * float(np.linalg.norm(place[other] - place[at])))
            stays = looks[outwards] & (np.linalg.norm(place[outwards] - place[at], axis=1) <= far)
            out[outwards[: min(most, int(np.argmin(np.append(stays, False))))]] = True
    return out

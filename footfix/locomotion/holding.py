"""Plants of walks along a path: what still slides is held, only where it does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.run import Enforcement, EnforceParams, enforce
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contacts
from footfix.rig.rig import Rig

_KEEP = 1e-3  # [leg lengths] only what slides no farther stays as it is


def held_on(
    clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams, *, needed: bool = True
) -> Enforcement:  # fmt: skip
    """Hold the plants of walks along a path.

    Args:
        clip: F frames.
        rig: its legs.
        contacts: which sole points are planted when.
        params: how.
        needed: whether anything may slide otherwise than in the walks.
    """
    keep = min(params.pins.keep_slide, _KEEP)
    strict = replace(params, cycle="no", pins=replace(params.pins, keep_slide=keep, keep_rested=False))
    found = enforce(clip, rig, contacts, strict, leave=not needed)
    if needed:
        return found
    still = Correction(rig.root, np.zeros((len(clip), 3)), (), np.zeros((len(clip), 0, 4)))
    return replace(found, correction=still)

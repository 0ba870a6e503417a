"""Plants of walks along a path: what still slides is held, only where it does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.papers.leg import effector_tracks
from footfix.enforce.params import EnforceParams
from footfix.enforce.run import Enforcement, enforce
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contacts
from footfix.rig.rig import Rig

_KEEP = 1e-3  # [leg lengths] only what slides no farther stays as it is
_HEEL = 6e-3  # [leg lengths] that a heel may slide while its toe stands: a heel is round, and nobody sees it
_EDGE = 0.015  # [s] at both ends of a contact in which a foot may still land or leave


def held_on(
    clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams, *, needed: bool = True
) -> Enforcement:  # fmt: skip
    """Hold the plants of walks along a path.

    Args:
        clip: F frames.
        rig: its legs.
        contacts: which sole points are planted when.
        params: how.
        needed: whether anything may slide otherwise than in the walks; it is seen to where something does.
    """
    needed = needed and not stands(clip, rig, contacts)
    keep = min(params.pins.keep_slide, _KEEP)
    strict = replace(params, cycle="no", pins=replace(params.pins, keep_slide=keep, keep_rested=False))
    found = enforce(clip, rig, contacts, strict, leave=not needed)
    if needed:
        return found
    still = Correction(rig.root, np.zeros((len(clip), 3)), (), np.zeros((len(clip), 0, 4)))
    return replace(found, correction=still)


def stands(clip: Clip, rig: Rig, contacts: Contacts) -> bool:
    """Whether whatever is planted stands as it is."""
    edge = max(1, round(_EDGE / clip.frame_time))
    for sole, track, effector in zip(rig.soles, effector_tracks(rig, rig.pose(clip)), contacts.effectors, strict=True):
        most = (_HEEL if sole.part == "heel" else _KEEP) * rig.leg_length
        for contact in effector.contacts:
            own = track[contact.start + edge : max(contact.end - edge, 0)][:, [0, 2]]
            if len(own) > 2 and np.hypot(*(own - np.median(own, axis=0)).T).max() > most:
                return False
    return True

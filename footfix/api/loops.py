"""Loops: a seamless cycle out of a walk."""

from __future__ import annotations

from footfix import pipeline
from footfix.api.clips import find_rigs
from footfix.api.parameters import check_settings
from footfix.errors import ArgumentError
from footfix.input_checks import check_clip, check_contacts, check_rig
from footfix.jobs.loop import LEAST_FRAMES
from footfix.locomotion.loop.run import Loop
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contacts
from footfix.rig.rig import Rig
from footfix.settings import Settings

__all__ = ["loop"]


def loop(
    clip: Clip, settings: Settings | None = None, *, rig: Rig | None = None, contacts: Contacts | None = None
) -> Loop:
    """Cut a seamless cycle out of a walk, close it, and hold its feet where they are planted.

    Examples:
        >>> from footfix.api.files import load
        >>> cycle = loop(load("sample_data/walk_skate.bvh").clip)
        >>> cycle.strides, len(cycle.clip) == cycle.end - cycle.start + 1
        (1, True)
        >>> cycle.seam.changed_mm <= cycle.seam.gap_mm
        True

    Args:
        clip: the motion, metres, y up; positions parent-local.
        settings: which cycle and how it is closed, as `settings.loop`; and the parameters of all steps.
        rig: legs and soles; found where it is not given.
        contacts: which sole points are planted when, in the frames of `clip`; detected where they are not given.

    Returns:
        The cycle, and what it was cut from.

    Raises:
        ArgumentError: clip, rig, contacts or settings can't be what is meant.
        NoLegsError: no legs were found, and no rig was given.
        InputError: the clip holds several figures and no rig was given, or no cycle, or not the one that is asked for.
    """
    settings = check_settings(settings)
    check_clip(clip)
    if len(clip) < LEAST_FRAMES:
        raise ArgumentError(f"a clip of {len(clip)} frames is too short for a stride")
    if rig is None and (contacts is not None or settings.rig.skin is not None):
        rigs = find_rigs(clip, settings)
        rig = rigs[0] if len(rigs) == 1 else None  # several are refused below
    if rig is not None:
        check_rig(rig, clip)
        if contacts is not None:
            check_contacts(contacts, clip, [sole.name for sole in rig.soles])
    return pipeline.loop(clip, settings, rig=rig, contacts=contacts)

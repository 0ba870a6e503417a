"""The order of the steps, on one screen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.detect.run import detect
from footfix.enforce.correction import Correction, apply
from footfix.enforce.footplant import Footplant
from footfix.enforce.run import Enforcement, enforce
from footfix.measure.clip import Measures, measure
from footfix.measure.plants import PlantMeasure
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.leadin import motion_proper
from footfix.motion.smoothing import smooth_clip
from footfix.notes import Note
from footfix.rig.find import find_rig
from footfix.rig.rig import Rig
from footfix.settings import Settings


@dataclass(frozen=True, eq=False)
class Result:
    """What cleaning a clip gives.

    Args:
        clip: the corrected motion, as a file says it where one was written; the very clip that came in where nothing
            needed changing.
        rig: legs, soles, scale and floor it was cleaned with.
        contacts: which sole points are planted when.
        plants: what became of each contact, and the frames of it that were held. A foot that lands or leaves is in
            contact and moves; before and after are measured over what is held.
        correction: what was changed, as data.
        before, after: measures of the clip that came in and of the corrected one.
        plants_before, plants_after: the same of every plant.
        notes: what the steps have to tell.
    """

    clip: Clip
    rig: Rig
    contacts: Contacts
    plants: tuple[Footplant, ...]
    correction: Correction
    before: Measures
    after: Measures
    plants_before: tuple[PlantMeasure, ...]
    plants_after: tuple[PlantMeasure, ...]
    notes: tuple[Note, ...] = ()


def clean(
    clip: Clip,
    settings: Settings | None = None,
    *,
    rig: Rig | None = None,
    contacts: Contacts | None = None,
    as_written: Callable[[Clip], Clip] | None = None,
) -> Result:
    """Finds the footplants of a clip and takes the foot skate out.

    Args:
        clip: the motion, metres, y up.
        settings: the parameters of all steps.
        rig: legs and soles; found where it is not given.
        contacts: which sole points are planted when; detected where they are not given.
        as_written: what a file makes of the corrected clip; that is the result, and `after` is measured on it.

    Returns:
        The corrected clip and all that was found on the way.

    Raises:
        NoLegsError: no legs were found, and no rig was given.
    """
    settings = settings or Settings()
    rig = rig or find_rig(clip, settings.rig)
    smoothed: Clip = clip
    smoothing_notes: tuple[Note, ...] = ()
    if settings.smooth.channels:
        smoothed, smoothing_notes = smooth_clip(clip, settings.smooth, motion_proper(clip))
    contacts = contacts or detect(smoothed, rig, settings.detect)
    enforcement = enforce(smoothed, rig, contacts, settings.enforce)
    corrected = apply(smoothed, enforcement.correction)
    held, levels, ground = enforcement.contacts, plant_levels(enforcement), enforcement.ground
    before, plants_before = measure(clip, rig, held, levels=levels, belt=ground)
    if as_written:
        corrected = as_written(corrected)
    after, plants_after = before, plants_before
    if corrected is not clip:
        after, plants_after = measure(corrected, rig, held, levels=levels, belt=ground)
    return Result(
        clip=corrected,
        rig=rig,
        contacts=contacts,
        plants=enforcement.plants,
        correction=enforcement.correction,
        before=before,
        after=after,
        plants_before=plants_before,
        plants_after=plants_after,
        notes=(*rig.notes, *smoothing_notes, *contacts.notes, *enforcement.notes),
    )


def measure_plants(clip: Clip, settings: Settings, rig: Rig, contacts: Contacts) -> Measures:
    """Measures a clip as it is, over the frames in which cleaning would hold its plants."""
    enforcement = enforce(clip, rig, contacts, settings.enforce)
    levels, ground = plant_levels(enforcement), enforcement.ground
    return measure(clip, rig, enforcement.contacts, levels=levels, belt=ground)[0]


def clean_figures(
    clip: Clip,
    settings: Settings,
    rigs: Sequence[Rig],
    contacts: Contacts,
    as_written: Callable[[Clip], Clip] | None = None,
) -> tuple[Result, ...]:
    """Cleans every figure of a clip: one after the other, since each has legs and a root of its own.

    Args:
        clip: the motion, metres, y up.
        settings: the parameters of all steps.
        rigs: one a figure.
        contacts: of all figures.
        as_written: what a file makes of the corrected clip.

    Returns:
        A result a figure, each with the clip in which all of them are corrected.
    """
    results: list[Result] = []
    current = clip
    for number, rig in enumerate(rigs, start=1):
        own = contacts.only(sole.name for sole in rig.soles)
        last = number == len(rigs)
        results.append(clean(current, settings, rig=rig, contacts=own, as_written=as_written if last else None))
        current = results[-1].clip
        settings = replace(settings, smooth=replace(settings.smooth, channels=False))  # once is enough for all
    return tuple(replace(result, clip=current) for result in results)


def plant_levels(enforcement: Enforcement) -> tuple[Floats, ...]:
    """For each effector (contacts,) [m] the height its plants are held at: the floor they are measured against."""
    height = {(plant.effector, plant.start): plant.target[1] for plant in enforcement.plants}
    return tuple(
        np.array([height.get((effector.name, c.start), np.nan) for c in effector.contacts])
        for effector in enforcement.contacts.effectors
    )

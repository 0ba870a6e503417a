"""The order of the steps, on one screen: for the command line and for Python alike.

    frame_range = motion_range(clip)                           # without a T-pose that leads in
    rigs = find_rigs(clip, settings.rig, frame_range)
    prepared = prepare(clip, settings, rigs, frame_range)      # smoothed: one motion for all that follows
    contacts = find_contacts(prepared, settings)
    corrected, figures = correct(prepared, contacts, settings)
    results = measure_figures(clip, corrected, figures)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from footfix.detect.run import detect_over
from footfix.enforce.correction import Correction, apply
from footfix.enforce.footplant import Footplant
from footfix.enforce.original_frames import repeated, uncropped
from footfix.enforce.run import enforce
from footfix.enforce.task import ground_of
from footfix.errors import InputError
from footfix.measure.clip import Measures, measure
from footfix.measure.plants import PlantMeasure
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts, joined
from footfix.motion.duplicate_frames import DuplicateFrames, doubled
from footfix.motion.lead_in import motion_range
from footfix.motion.smoothing import smooth_clip
from footfix.motion.threads import at_once
from footfix.notes import Note
from footfix.rig.find import find_rigs
from footfix.rig.motion_crop import Crop, crop
from footfix.rig.repeated_rounds import Rounds, rounds_of
from footfix.rig.rig import Rig
from footfix.settings import Settings

if TYPE_CHECKING:
    from footfix.locomotion.loop.run import Loop


@dataclass(frozen=True, eq=False)
class Result:
    """What cleaning one figure of a clip gives.

    Args:
        clip: the corrected motion, of all figures; the very clip that came in where nothing needed changing.
        rig: legs, soles, scale and floor it was cleaned with.
        contacts: which sole points are planted when.
        plants: what became of each contact, in the order of the contacts; what is forbidden is none.
        correction: what was changed, as data.
        before, after: measures of the clip that came in and of the corrected one.
        plants_before, plants_after: the same of every plant, by its id.
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


@dataclass(frozen=True, eq=False)
class Prepared:
    """A clip on which contacts are detected and enforced.

    Args:
        clip: F frames, smoothed where its channels are to be.
        rigs: legs and soles of each figure.
        crops: the frames in which the legs of each figure move.
        doubles: which of these repeat the one before.
        rounds: of each figure's motion where it is a cycle.
        notes: what smoothing, and frames that are repeated, have to tell.
    """

    clip: Clip
    rigs: tuple[Rig, ...]
    crops: tuple[Crop, ...]
    doubles: tuple[DuplicateFrames, ...]
    rounds: tuple[Rounds | None, ...]
    notes: tuple[Note, ...] = ()


@dataclass(frozen=True, eq=False)
class Figure:
    """What became of one figure, before anything is measured.

    Args:
        rig: its legs and soles.
        contacts: its contacts as they were found or given.
        planted: those of them that lie in the motion.
        plants: what became of each of these.
        correction: what was changed.
        ground: (F, 3) [m] how far the ground under planted feet has moved, as on a treadmill.
        thin: which frames of the clip repeat the one before, and are not measured.
        notes: what the steps have to tell.
    """

    rig: Rig
    contacts: Contacts
    planted: Contacts
    plants: tuple[Footplant, ...]
    correction: Correction
    ground: Floats
    thin: DuplicateFrames
    notes: tuple[Note, ...]


def clean_figures(
    clip: Clip, settings: Settings | None = None, *, rigs: Sequence[Rig] | None = None,
    contacts: Contacts | None = None, most: int | None = None,
) -> tuple[Result, ...]:  # fmt: skip
    """Clean every figure of a clip: two dancers in one file.

    Args:
        clip: the motion, metres, y up.
        settings: the parameters of all steps.
        rigs: legs and soles of each figure; found where they are not given.
        contacts: of the sole points of all figures, in the order of the rigs; detected where they are not given.
        most: figures that are cleaned, the first ones of the file; all by default.

    Returns:
        One result a figure, each with the whole corrected clip.

    Raises:
        NoLegsError: no legs were found, and no rig was given.
    """
    settings = settings or Settings()
    frame_range = motion_range(clip)
    rigs = (find_rigs(clip, settings.rig, frame_range) if rigs is None else tuple(rigs))[:most]
    prepared = prepare(clip, settings, rigs, frame_range)
    contacts = contacts or find_contacts(prepared, settings)
    corrected, figures = correct(prepared, contacts, settings)
    return measure_figures(clip, corrected, figures)


def loop(
    clip: Clip, settings: Settings | None = None, *, rig: Rig | None = None, contacts: Contacts | None = None
) -> Loop:
    """Cut a seamless cycle out of a walk, close it, and hold its feet where they are planted.

    Args:
        clip: the motion, metres, y up.
        settings: the parameters of all steps.
        rig: legs and soles; found where it is not given.
        contacts: which sole points are planted when; detected where they are not given.

    Raises:
        NoLegsError: no legs were found, and no rig was given.
        InputError: the clip holds no cycle, or not the one that is asked for.
    """
    settings = settings or Settings()
    frame_range = motion_range(clip)
    rigs = find_rigs(clip, settings.rig, frame_range) if rig is None else (rig,)
    prepared = prepare(clip, settings, rigs, frame_range)
    return cut_loop(prepared, contacts or find_contacts(prepared, settings), settings)


def cut_loop(prepared: Prepared, contacts: Contacts, settings: Settings) -> Loop:
    """Cut the loop out of a prepared clip of one figure; its frames are counted among all of the clip.

    Args:
        prepared: the clip and its figure.
        contacts: of that.
        settings: which cycle, how it is closed, and how contacts are enforced.

    Raises:
        InputError: the clip holds several figures, or no cycle, or not the one that is asked for.
    """
    from footfix.locomotion.loop.run import make_loop  # most commands cut no loop

    if len(prepared.rigs) > 1:
        text = f"the file holds {len(prepared.rigs)} figures, whose cycles differ; a loop is one figure's"
        raise InputError(text, hint="export each figure to a file of its own")
    rig, motion, asked = prepared.rigs[0], prepared.crops[0], settings.loop
    start, end = (None if frame is None else frame - motion.start for frame in (asked.start, asked.end))
    found = make_loop(
        motion.clip(prepared.clip), rig, motion.contacts(contacts), replace(asked, start=start, end=end),
        settings.enforce,
    )  # fmt: skip
    notes = (*rig.notes, *prepared.notes, *contacts.notes, *found.notes)
    return replace(found.counted_from(motion.start), notes=notes)


def prepare(clip: Clip, settings: Settings, rigs: Sequence[Rig], frame_range: slice) -> Prepared:
    """Smooth a clip where that is wanted, and find the frames in which its figures move.

    Args:
        clip: F frames, metres, y up.
        settings: whether channels are smoothed, and cycles looked for.
        rigs: legs and soles of each figure.
        frame_range: the frames that are motion (`motion_range`).
    """
    notes: tuple[Note, ...] = ()
    crops = tuple(crop(clip, rig, frame_range) for rig in rigs)
    doubles = tuple(doubled(motion.clip(clip)) for motion in crops)
    if settings.smooth.channels:
        clip, notes = smooth_clip(clip, settings.smooth, frame_range)
    rounds = tuple(
        None if any(motion.cut) else rounds_of(thin.clip(clip), rig, settings.enforce.cycle)
        for rig, motion, thin in zip(rigs, crops, doubles, strict=True)
    )
    for thin in doubles:
        notes += thin.notes(clip)
    return Prepared(clip, tuple(rigs), crops, doubles, rounds, notes)


def find_contacts(prepared: Prepared, settings: Settings) -> Contacts:
    """Detect the contacts of all figures; those of cycles on rounds laid end to end."""
    figures = zip(prepared.rigs, prepared.crops, prepared.doubles, prepared.rounds, strict=True)
    return joined([
        motion.contacts_back(detect_over(motion.clip(prepared.clip), rig, settings.detect, thin, rounds))
        for rig, motion, thin, rounds in figures
    ])  # fmt: skip


def correct(
    prepared: Prepared, contacts: Contacts, settings: Settings, *, leave: bool = False
) -> tuple[Clip, tuple[Figure, ...]]:  # fmt: skip
    """Take the foot skate out of every figure: one after the other, since each has legs and a root of its own.

    Args:
        prepared: the clip and its figures.
        contacts: of all figures.
        settings: how contacts are enforced.
        leave: whether every plant stays as it is.

    Returns:
        The clip with all figures corrected, and what became of each.
    """
    clip, figures = prepared.clip, []
    for rig, motion, thin in zip(prepared.rigs, prepared.crops, prepared.doubles, strict=True):
        own = contacts.only(sole.name for sole in rig.soles)
        within = motion.contacts(own)
        moving = motion.clip(clip)
        distinct = thin.clip(moving)
        done = enforce(distinct, rig, thin.contacts(within), settings.enforce, cut=motion.cut, leave=leave)
        found = uncropped(repeated(done, moving, thin), clip, motion)
        notes = (*rig.notes, *prepared.notes, *own.notes, *found.notes)
        planted = motion.contacts_back(within)
        measured = thin.among(motion.start, len(clip))
        figures.append(Figure(rig, own, planted, found.plants, found.correction, found.ground, measured, notes))
        clip = apply(clip, found.correction)
    return clip, tuple(figures)


def measure_figures(before: Clip, after: Clip, figures: Sequence[Figure]) -> tuple[Result, ...]:
    """Measure every figure before and after it was corrected.

    Args:
        before: the clip that came in.
        after: the corrected one, as a file says it where one was written.
        figures: what became of each figure.
    """
    results = []
    for each in figures:
        thin = each.thin
        planted, ground = thin.contacts(each.planted), thin.track(each.ground)
        clips = (before,) if after is before else (before, after)
        ways = [partial(measure, thin.clip(clip), each.rig, planted, belt=ground) for clip in clips]
        found = at_once(ways, len(before))
        was, now = found[0], found[-1]
        results.append(Result(
            clip=after, rig=each.rig, contacts=each.contacts, plants=each.plants, correction=each.correction,
            before=was[0], after=now[0], plants_before=was[1], plants_after=now[1], notes=each.notes,
        ))  # fmt: skip
    return tuple(results)


def measure_as_it_is(
    clip: Clip, prepared: Prepared, contacts: Contacts, settings: Settings
) -> tuple[tuple[Measures, tuple[PlantMeasure, ...]], ...]:
    """Measure every figure of a clip to which nothing is done, and each of its plants.

    Args:
        clip: the clip that came in.
        prepared: the same, with its figures.
        contacts: of all figures.
        settings: how a ground that moves is found.
    """
    found = []
    figures = zip(prepared.rigs, prepared.crops, prepared.doubles, prepared.rounds, strict=True)
    for rig, motion, thin, rounds in figures:
        within = motion.contacts(contacts.only(sole.name for sole in rig.soles))
        params, distinct = settings.enforce.ground, thin.contacts(within)
        if rounds:
            ground = rounds.track_back(ground_of(rounds.clip, rig, rounds.contacts(distinct), params))
        else:
            ground = ground_of(thin.clip(motion.clip(prepared.clip)), rig, distinct, params)
        measured, planted = thin.among(motion.start, len(clip)), motion.contacts_back(within)
        ground = measured.track(motion.track_back(thin.track_back(ground)))
        found.append(measure(measured.clip(clip), rig, measured.contacts(planted), belt=ground))
    return tuple(found)

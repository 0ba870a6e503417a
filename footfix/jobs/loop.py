"""One loop, from the bytes of a clip's file to the bytes of its outputs. No file is read or written here."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from footfix import version
from footfix.errors import InputError
from footfix.formats.contacts import Labels
from footfix.formats.document import Beside, Document, rewrite, select_frames, shown_skin
from footfix.formats.suffixes import in_file
from footfix.jobs.contacts import contacts_json, find_contacts
from footfix.jobs.outputs import Outputs, Status
from footfix.jobs.shared_legs import with_shared_legs
from footfix.jobs.skip_reason import why_left
from footfix.jobs.source import about, opened, source_entry
from footfix.locomotion.loop.run import Loop, as_round
from footfix.motion.contacts import Contacts
from footfix.motion.duplicate_frames import DuplicateFrames
from footfix.notes import Note
from footfix.pipeline import Figure, Prepared, Result, cut_loop, measure_figures, prepare
from footfix.report import document as report_format
from footfix.report.loop_text import in_place_if_written_so
from footfix.report.pages import draw
from footfix.rig.find import find_rigs
from footfix.rig.skin import Skin
from footfix.settings import Settings, plain

if TYPE_CHECKING:
    from footfix.report.rerun_command import RerunCommand

# Fewer frames than this hold no stride.
LEAST_FRAMES = 8


def loop_file(
    data: bytes, name: str, settings: Settings, *, labels: Labels | None = None, output: str | None = None,
    again: RerunCommand | None = None, beside: Beside | None = None, skin: Skin | None = None,
) -> Outputs:  # fmt: skip
    """Cut a seamless cycle out of a clip, and clean it as one.

    Args:
        data: the bytes of the file.
        name: its name, for messages and reports.
        settings: the parameters of all steps.
        labels: contacts of the clip, given by hand.
        output: the name of the loop's file, for the report.
        again: how the loop is cleaned from edited contacts, for its page.
        beside: reads files that this one names.
        skin: the character that `settings.rig.skin` names.

    Raises:
        InputError: the clip can't be used, or holds no cycle; says why.
    """
    settings = with_shared_legs(data, name, settings, beside)
    document, frame_range = opened(data, name, settings, beside)
    clip = document.clip
    if len(clip) < LEAST_FRAMES:
        raise InputError(f"{len(clip)} frames are too few for a stride", file=name)
    with about(name):
        rigs = find_rigs(clip, settings.rig, frame_range, shown_skin(document, settings.rig, skin))
        prepared = prepare(clip, settings, rigs, frame_range)
        loop = _cut(prepared, find_contacts(prepared, settings, labels), settings, why_left(document, rigs))
        some = select_frames(document, loop.frames, limits=settings.limits)
        # the bytes to write, and the clip that reading them again gives
        written, reread = (data, clip) if loop.clip is clip else rewrite(some, loop.clip, limits=settings.limits)
    cycle = as_round(reread, loop.rig, loop.travel, settings.loop)
    every = DuplicateFrames(np.arange(len(cycle)), len(cycle))
    contacts = loop.contacts
    figure = Figure(loop.rig, contacts, contacts, loop.plants, loop.correction, loop.ground, every, loop.notes)
    (result,) = measure_figures(loop.captured, cycle, (figure,))
    status: Status = "unchanged" if written == data else "cleaned"
    source = source_entry(data, name, clip)
    report = _report(document, loop, result, settings, source=source, status=status, output=output)
    contacts = _contacts(contacts, len(reread))
    made = {**source, "sha256": hashlib.sha256(written).hexdigest(), "frames": len(reread)}
    clip_in_it = in_file(name)[1]
    made["file"] = PurePath(output).name + (f"#{clip_in_it}" if clip_in_it else "") if output else source["file"]
    contacts_file = contacts_json(contacts, made, report["rig"], settings)
    before = in_place_if_written_so(loop.captured.frames(slice(0, len(reread))), loop.rig, report["loop"])
    ground = loop.ground[: len(reread)]
    pages, offenders = draw(before, reread, loop.rig, report, contacts_file, settings.report, again, ground)
    return Outputs(status, written, contacts_file, report, pages, offenders)


def _cut(prepared: Prepared, contacts: Contacts, settings: Settings, left: Note | None) -> Loop:
    """Cut the loop; of a clip whose feet are left as they are only one that is a loop as it is.

    Raises:
        InputError: the clip holds no cycle, or its feet are left as they are.
    """
    try:
        loop = cut_loop(prepared, contacts, settings)
    except InputError as error:
        raise error if left is None else InputError(left.text) from error
    if left is not None and loop.clip is not prepared.clip:
        raise InputError(left.text)
    return loop


def _contacts(contacts: Contacts, frames: int) -> Contacts:
    """Take the contacts of the frames that are written: without the last one where that is left out."""
    effectors = []
    for effector in contacts.effectors:
        own = (replace(c, end=min(c.end, frames)) for c in effector.contacts if c.start < frames)
        effectors.append(replace(effector, contacts=tuple(own)))
    return replace(contacts, frames=frames, effectors=tuple(effectors))


def _report(
    document: Document, loop: Loop, result: Result, settings: Settings, *, source: Mapping[str, Any], status: str,
    output: str | None,
) -> dict[str, Any]:  # fmt: skip
    clip = loop.round
    planted = loop.contacts.mask()[:-1].any(axis=1)
    return {
        **report_format.frame(source, version.__version__, status=status, output=output),
        "method": settings.enforce.method,
        "rig": report_format.rig(loop.rig, clip, unit_m=document.unit_m, up=document.up),
        "settings": plain(settings),
        "loop": loop_entry(loop, settings),
        "before": report_format.measures(result.before),
        "after": report_format.measures(result.after),
        "plants": report_format.plants(result.plants, result.plants_before, result.plants_after),
        "correction": report_format.corrections([result.correction], loop.closed),
        "notes": report_format.notes((*document.notes, *loop.notes)),
        "seconds": {
            "clip": report_format.rounded(loop.seconds),
            "in_contact": report_format.rounded(float(planted.sum()) * clip.frame_time),
        },
    }


def loop_entry(loop: Loop, settings: Settings) -> dict[str, Any]:
    """Describe a loop as the report's entry; each key carries its unit."""
    number, seam, asked = report_format.rounded, loop.seam, settings.loop
    return {
        "start": loop.start,
        "end": loop.end,
        "frames": len(loop.clip),
        "closed": not asked.open,
        "in_place": asked.in_place,
        "strides": loop.strides,
        "seconds": number(loop.seconds),
        "travel_m": [number(loop.travel_of_root[0]), number(loop.travel_of_root[1])],
        "distance_m": number(loop.distance),
        "speed_m_s": number(loop.speed),
        "turn_deg": number(float(np.degrees(loop.turn))),
        "gap_mm": number(seam.gap_mm),
        "gap_deg": number(seam.gap_deg),
        "changed_mm": number(seam.changed_mm),
        "changed_deg": number(seam.changed_deg),
        "seam_median_ratio": number(seam.median_ratio),
        "seam_worst_ratio": number(seam.worst_ratio),
        "seam_slide_mm": None if seam.slide_mm is None else number(seam.slide_mm),
        "others": [
            {"start": cut.start, "end": cut.end, "strides": cut.strides, "apart_mm": number(1000.0 * cut.gap)}
            for cut in loop.others
        ],
    }

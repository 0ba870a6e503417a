"""One clip, from the bytes of its file to the bytes of its outputs. Nothing here touches a disk."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from footfix import version
from footfix.formats.contacts import Labels
from footfix.formats.document import Beside, Document, rewrite, shown_skin
from footfix.jobs.contacts import contacts_json, find_contacts
from footfix.jobs.outputs import Outputs, Status
from footfix.jobs.skip_reason import why_left
from footfix.jobs.source import LEAST_FRAMES, about, source_entry, suited
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contacts
from footfix.notes import Note
from footfix.pipeline import Result, correct, measure_figures, prepare
from footfix.report import document as report_format
from footfix.report.pages import draw
from footfix.rig.find import find_rigs
from footfix.rig.rig import joined
from footfix.rig.skin import Skin
from footfix.settings import Settings, plain

if TYPE_CHECKING:
    from footfix.report.rerun_command import RerunCommand


def clean_file(
    data: bytes, name: str, settings: Settings, *, labels: Labels | None = None, output: str | None = None,
    again: RerunCommand | None = None, leave: str = "", beside: Beside | None = None, skin: Skin | None = None,
) -> Outputs:  # fmt: skip
    """Clean one clip.

    Args:
        data: the bytes of the file.
        name: its name, for messages and reports.
        settings: the parameters of all steps.
        labels: contacts given by hand.
        output: the name of the corrected file, for the report.
        again: how the clip is cleaned again from edited contacts, for its page.
        leave: why the clip is left as it is, if it is: it was written by a cleaning, and `labels` are its contacts.
        beside: reads files that this one names.
        skin: the character that `settings.rig.skin` names.

    Raises:
        InputError: the clip can't be used; says why.
    """
    document, frame_range, settings = suited(data, name, settings, beside)
    clip = document.clip
    source = source_entry(data, name, clip)
    if len(clip) < LEAST_FRAMES:
        return _too_short(data, document, source, settings, output)
    with about(name):
        skin = shown_skin(document, settings.rig, skin)
        rigs = find_rigs(clip, settings.rig, frame_range, skin)
        left = Note("cleaned-already", leave) if leave else None if labels else why_left(document, rigs)
        if left:
            settings = replace(settings, smooth=replace(settings.smooth, channels=False))
        prepared = prepare(clip, settings, rigs, frame_range)
        if left:
            prepared = replace(prepared, notes=(*prepared.notes, left))
        contacts = find_contacts(prepared, settings, labels)
        corrected, figures = correct(prepared, contacts, settings, leave=left is not None)
        # the bytes to write, and the clip that reading them again gives
        written, reread = rewrite(document, corrected, limits=settings.limits)
    results = measure_figures(clip, reread, figures)
    status: Status = "unchanged" if written == data else "cleaned"
    report = report_of(
        clip, results, source, settings, unit_m=document.unit_m, up=document.up, notes=document.notes, status=status,
        output=output,
    )  # fmt: skip
    contacts_file = contacts_json(contacts, source, report["rig"], settings)
    ground = figures[0].ground
    pages, offenders = draw(clip, reread, joined(prepared.rigs), report, contacts_file, settings.report, again, ground)
    return Outputs(status, written, contacts_file, report, pages, offenders)


def report_of(
    clip: Clip, results: Sequence[Result], source: Mapping[str, Any], settings: Settings, *, unit_m: float, up: str,
    notes: Sequence[Note], status: Status, output: str | None,
) -> dict[str, Any]:  # fmt: skip
    """Make the report document of a cleaned clip.

    Args:
        clip: the captured motion.
        results: the result of each figure.
        source: the report's entry on the file (`source_entry`).
        settings: the parameters of all steps.
        unit_m, up: unit [m] and up axis of the file.
        notes: those from reading the file.
        status: "cleaned" or "unchanged".
        output: the name of the corrected file.
    """
    rigs = [report_format.rig(each.rig, clip, unit_m=unit_m, up=up) for each in results]
    planted = np.any([each.contacts.mask().any(axis=1) for each in results], axis=0)
    return {
        **report_format.frame(source, version.__version__, status=status, output=output),
        "method": settings.enforce.method,
        "rig": rigs[0],
        **({"figures": rigs} if len(rigs) > 1 else {}),
        "settings": plain(settings),
        "before": report_format.worst([report_format.measures(each.before) for each in results]),
        "after": report_format.worst([report_format.measures(each.after) for each in results]),
        "plants": [
            row for each in results for row in report_format.plants(each.plants, each.plants_before, each.plants_after)
        ],
        "correction": report_format.corrections([each.correction for each in results], clip),
        "notes": report_format.notes((*notes, *(note for each in results for note in each.notes))),
        # Times of the motion, not of the machine: a report is the same on any machine and any number of processes.
        "seconds": {
            "clip": report_format.rounded(len(clip) * clip.frame_time),
            "in_contact": report_format.rounded(float(planted.sum()) * clip.frame_time),
        },
    }


def _too_short(
    data: bytes, document: Document, source: Mapping[str, Any], settings: Settings, output: str | None
) -> Outputs:
    frames = document.frames
    text = f"{frames} {'frame' if frames == 1 else 'frames'}: too short to hold a motion, so nothing was changed"
    report = {
        **report_format.frame(source, version.__version__, status="unchanged", output=output),
        "method": settings.enforce.method,
        "rig": {"unit_m": document.unit_m, "up": document.up, "leg_length_m": None, "floor_m": None},
        "settings": plain(settings),
        "before": {},
        "after": {},
        "plants": [],
        "correction": report_format.NO_CORRECTION,
        "notes": report_format.notes((*document.notes, Note("too-short", text))),
        "seconds": {"clip": report_format.rounded(frames * document.frame_time), "in_contact": 0.0},
    }
    contacts = Contacts(frames, document.frame_time, ())
    contacts_file = contacts_json(replace(contacts, method=settings.detect.method), source, report["rig"], settings)
    pages, _ = draw(None, None, None, report, contacts_file, settings.report)
    return Outputs("unchanged", data, contacts_file, report, pages)

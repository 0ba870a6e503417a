"""One clip, from the bytes of its file to the bytes of its outputs. Nothing here touches a disk."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from footfix import version
from footfix.errors import InputError
from footfix.formats import contacts as labels_format
from footfix.formats.contacts import Labels
from footfix.formats.document import Beside, Document, open_document, rewrite
from footfix.formats.suffixes import bare
from footfix.jobs.legs import with_shared_legs
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contacts
from footfix.motion.contacts import joined as all_contacts
from footfix.motion.leadin import motion_proper
from footfix.notes import Note
from footfix.pipeline import Prepared, Result, correct, measure_as_it_is, measure_figures, prepare
from footfix.pipeline import find_contacts as detected
from footfix.report import document as report_format
from footfix.report.pages import draw
from footfix.rig.find import find_rigs
from footfix.rig.params import RigParams
from footfix.rig.rig import joined
from footfix.rig.skin import Skin
from footfix.rig.units import infer_units
from footfix.settings import Settings, plain

if TYPE_CHECKING:
    from footfix.report.again import Again
    from footfix.report.offenders import Offender

# Fewer frames than this hold no motion: there is no speed to look at.
LEAST_FRAMES = 3

Status = Literal["cleaned", "unchanged", "failed"]


@dataclass(frozen=True)
class Outputs:
    """What came of one clip.

    Args:
        status: "cleaned", or "unchanged" where nothing needed doing.
        motion: the corrected file; the very bytes that came in where nothing changed.
        contacts: the contacts file.
        report: the report file as a document.
        pages: further outputs by suffix (".report.html", ".png").
        offenders: the worst plants as small pictures, where a page is made.
    """

    status: Status
    motion: bytes
    contacts: bytes
    report: Mapping[str, Any]
    pages: Mapping[str, bytes] = field(default_factory=dict)
    offenders: tuple[Offender, ...] = ()


@contextmanager
def about(name: str) -> Iterator[None]:
    """Errors from below, where nothing knows of files, say which file they are about."""
    try:
        yield
    except InputError as error:
        raise error if error.file else error.within(name) from None


def read(data: bytes, name: str, settings: Settings, *, beside: Beside | None = None) -> Document:
    """Read a file as a document in metres, y up; `beside` reads files that it names.

    Raises:
        InputError: it can't be read, or holds numbers that are none.
    """
    return _opened(data, name, settings, beside)[0]


def _opened(data: bytes, name: str, settings: Settings, beside: Beside | None) -> tuple[Document, slice]:
    """A file as a document in metres, y up, and the frames of it that are motion."""
    document = open_document(data, name=name, limits=settings.limits, beside=beside)
    for broken in document.unusable:
        raise InputError(broken.text, file=name, line=broken.line, column=broken.column)
    if document.frames == 0:
        return document, slice(0, 0)
    proper = motion_proper(document.clip)
    with about(name):
        return placed(document, settings.rig, proper)[0], proper


def suited(settings: Settings, document: Document) -> Settings:
    """Suit settings to a file's format: animations of games are likely to be cycles."""
    if not document.metric or settings.enforce.cycle != "find":
        return settings
    return replace(settings, enforce=replace(settings.enforce, cycle="likely"))


def placed(
    document: Document, params: RigParams, proper: slice | None = None
) -> tuple[Document, tuple[Note, ...]]:
    """The document with its unit and up axis as found, and what was doubtful about them."""
    found = infer_units(document.clip, params, proper, metric=document.metric)
    return document.placed(unit_m=found.unit_m, up=found.up), found.notes


def source_entry(data: bytes, name: str, clip: Clip) -> dict[str, Any]:
    """What contacts and report say of the file they are about."""
    return {
        "file": bare(name),
        "sha256": hashlib.sha256(data).hexdigest(),
        "frames": len(clip),
        "frame_time": clip.frame_time,
    }


def find_contacts(prepared: Prepared, settings: Settings, labels: Labels | None) -> Contacts:
    """Contacts of all figures, from the labels where they speak, from the detector elsewhere."""
    if labels is None:
        return detected(prepared, settings)
    blank = all_contacts([rig.no_contacts(prepared.clip) for rig in prepared.rigs])
    given, open_ones = labels_format.fit(labels, blank)
    return labels_format.merge(given, detected(prepared, settings), open_ones) if open_ones else given


def clean_file(
    data: bytes, name: str, settings: Settings, *, labels: Labels | None = None, output: str | None = None,
    again: Again | None = None, leave: str = "", beside: Beside | None = None, skin: Skin | None = None,
) -> Outputs:  # fmt: skip
    """Clean one clip.

    Args:
        data: the bytes of the file.
        name: its name, for messages and reports.
        settings: the parameters of all steps.
        labels: contacts given by hand.
        output: the name of the corrected file, for the report.
        again: how the clip is cleaned again from edited contacts, for its page.
        leave: why the clip stays as it is, if it does: it is what a cleaning made, and `labels` are its contacts.
        beside: reads files that this one names.

    Raises:
        InputError: the clip can't be used; says why.
    """
    settings = with_shared_legs(data, name, settings, beside)
    document, proper = _opened(data, name, settings, beside)
    settings = suited(settings, document)
    clip = document.clip
    source = source_entry(data, name, clip)
    if len(clip) < LEAST_FRAMES:
        return _too_short(data, document, source, settings, output)
    if leave:
        settings = replace(settings, smooth=replace(settings.smooth, channels=False))
    with about(name):
        prepared = prepare(clip, settings, find_rigs(clip, settings.rig, proper, skin), proper)
        if leave:
            prepared = replace(prepared, notes=(*prepared.notes, Note("cleaned-already", leave)))
        contacts = find_contacts(prepared, settings, labels)
        corrected, figures = correct(prepared, contacts, settings, leave=bool(leave))
        # the file, and what it says when it is read again
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


def contacts_json(contacts: Contacts, source: Mapping[str, Any], rig: Mapping[str, Any], settings: Settings) -> bytes:
    """The contacts file of a clip."""
    return labels_format.encode_json(
        contacts,
        source=source,
        rig={key: rig[key] for key in ("unit_m", "up", "leg_length_m", "floor_m")},
        detector={
            "method": contacts.method,
            "version": version.__version__,
            "settings": plain(getattr(settings.detect, contacts.method, None)) or {},
        },
    )


def report_of(
    clip: Clip, results: Sequence[Result], source: Mapping[str, Any], settings: Settings, *, unit_m: float, up: str,
    notes: Sequence[Note], status: Status, output: str | None,
) -> dict[str, Any]:  # fmt: skip
    """Make the report document of a cleaned clip.

    Args:
        clip: the motion that came in.
        results: what became of each figure.
        source: what the report says of the file (`source_entry`).
        settings: the parameters of all steps.
        unit_m, up: unit [m] and up axis of the file.
        notes: what reading the file had to tell.
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
        # Of the motion, not of the machine: a report is the same whoever made it, on however many processes.
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


def measure_file(
    data: bytes, name: str, settings: Settings, *, labels: Labels | None = None, beside: Beside | None = None,
    skin: Skin | None = None,
) -> tuple[dict[str, Any], dict[str, float | None], list[dict[str, Any]], list[dict[str, Any]]]:
    """Measure one clip as it is; nothing is corrected.

    Returns:
        The source entry, the measures, the notes, and each plant with its slide.

    Raises:
        InputError: the clip can't be used; says why.
    """
    document, source, prepared, contacts = _planted(data, name, settings, labels, "measure", beside, skin)
    found = measure_as_it_is(document.clip, prepared, contacts, settings)
    measures = report_format.worst([report_format.measures(each) for each, _ in found])
    plants = [
        {"effector": each.effector, "start": each.start, "end": each.end,
         "slide_mm": report_format.rounded(each.slide_mm)}
        for _, of_figure in found
        for each in of_figure
    ]  # fmt: skip
    return source, measures, _doubts(document, prepared, contacts), plants


def detect_file(
    data: bytes, name: str, settings: Settings, *, labels: Labels | None = None, beside: Beside | None = None,
    skin: Skin | None = None,
) -> tuple[Contacts, dict[str, Any], dict[str, Any], list[dict[str, Any]], float]:
    """Find the contacts of one clip.

    Returns:
        The contacts, its source and rig entries, its notes, and the time of its first frame [s].

    Raises:
        InputError: the clip can't be used; says why.
    """
    document, source, prepared, contacts = _planted(data, name, settings, labels, "find contacts in", beside, skin)
    entry = report_format.rig(prepared.rigs[0], document.clip, unit_m=document.unit_m, up=document.up)
    return contacts, source, entry, _doubts(document, prepared, contacts), document.start


def _planted(
    data: bytes, name: str, settings: Settings, labels: Labels | None, purpose: str, beside: Beside | None,
    skin: Skin | None,
) -> tuple[Document, dict[str, Any], Prepared, Contacts]:
    """A file as a document, its source entry, its figures, and their contacts."""
    settings = with_shared_legs(data, name, settings, beside)
    document, proper = _opened(data, name, settings, beside)
    settings = suited(settings, document)
    clip = document.clip
    if len(clip) < LEAST_FRAMES:
        raise InputError(f"{len(clip)} frames hold no motion to {purpose}", file=name)
    with about(name):
        prepared = prepare(clip, settings, find_rigs(clip, settings.rig, proper, skin), proper)
        return document, source_entry(data, name, clip), prepared, find_contacts(prepared, settings, labels)


def _doubts(document: Document, prepared: Prepared, contacts: Contacts) -> list[dict[str, Any]]:
    notes = (note for rig in prepared.rigs for note in rig.notes)
    return report_format.notes((*document.notes, *notes, *prepared.notes, *contacts.notes))

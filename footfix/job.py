"""One clip, from the bytes of its file to the bytes of its outputs. Nothing here touches a disk."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import PurePath
from typing import Any, Literal

from footfix import version
from footfix.detect.run import detect
from footfix.errors import InputError
from footfix.formats import contacts as labels_format
from footfix.formats.bvh import Document, decode, encode
from footfix.formats.contacts import Labels
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contacts
from footfix.notes import Note
from footfix.pipeline import Result, clean
from footfix.report import document as report_format
from footfix.rig.find import find_rig
from footfix.rig.params import RigParams
from footfix.rig.rig import Rig
from footfix.rig.survey import survey
from footfix.settings import Settings, plain

# Fewer frames than this hold no motion: there is no speed to look at.
LEAST_FRAMES = 3

Status = Literal["cleaned", "unchanged", "failed"]


@dataclass(frozen=True)
class Outputs:
    """What came of one clip.

    Args:
        status: "cleaned", or "unchanged" where nothing needed doing.
        bvh: the corrected file; the very bytes that came in where nothing changed.
        contacts: the contacts file.
        report: the report file as a document.
        pages: further outputs by suffix (".report.html", ".png").
    """

    status: Status
    bvh: bytes
    contacts: bytes
    report: Mapping[str, Any]
    pages: Mapping[str, bytes] = field(default_factory=dict)


@contextmanager
def about(name: str) -> Iterator[None]:
    """Errors from below, where nothing knows of files, say which file they are about."""
    try:
        yield
    except InputError as error:
        raise error if error.file else error.within(name) from None


def read(data: bytes, name: str, settings: Settings) -> Document:
    """A file as a document in metres, y up.

    Raises:
        InputError: it is no BVH, or holds numbers that are none.
    """
    document = decode(data, name=name, limits=settings.limits)
    broken = next((note for note in document.notes if note.severity == "error"), None)
    if broken is not None:
        raise InputError(broken.text, file=name, line=broken.line, column=broken.column)
    if len(document.values) == 0:
        return document
    with about(name):
        return placed(document, settings.rig)[0]


def placed(document: Document, params: RigParams) -> tuple[Document, tuple[Note, ...]]:
    """The document with its unit and up axis as found, and what was doubtful about them."""
    found = survey(document.clip, params)
    return document.placed(unit_m=found.unit_m, up=found.up), found.notes


def source_entry(data: bytes, name: str, clip: Clip) -> dict[str, Any]:
    """What contacts and report say of the file they are about."""
    return {
        "file": PurePath(name).name,
        "sha256": hashlib.sha256(data).hexdigest(),
        "frames": len(clip),
        "frame_time": clip.frame_time,
    }


def find_contacts(clip: Clip, rig: Rig, settings: Settings, labels: Labels | None) -> Contacts:
    """Contacts from the labels where they speak, from the detector elsewhere."""
    if labels is None:
        return detect(clip, rig, settings.detect)
    given, open_ones = labels_format.fit(labels, rig.no_contacts(clip))
    if not open_ones:
        return given
    return labels_format.merge(given, detect(clip, rig, settings.detect), open_ones)


def clean_file(
    data: bytes, name: str, settings: Settings, *, labels: Labels | None = None, output: str | None = None
) -> Outputs:
    """Cleans one clip.

    Args:
        data: the bytes of the file.
        name: its name, for messages and reports.
        settings: the parameters of all steps.
        labels: contacts given by hand.
        output: the name of the corrected file, for the report.

    Raises:
        InputError: the clip can't be used; says why.
    """
    document = read(data, name, settings)
    clip = document.clip
    source = source_entry(data, name, clip)
    if len(clip) < LEAST_FRAMES:
        return _too_short(data, document, source, settings, output)
    written = data

    def as_written(corrected: Clip) -> Clip:
        nonlocal written
        written = encode(document, corrected)
        if written == data:
            return clip
        return decode(written, name=name, limits=settings.limits).placed(unit_m=document.unit_m, up=document.up).clip

    with about(name):
        rig = find_rig(clip, settings.rig)
        contacts = find_contacts(clip, rig, settings, labels)
        result = clean(clip, settings, rig=rig, contacts=contacts, as_written=as_written)
    status: Status = "unchanged" if written == data else "cleaned"
    report = _report(document, result, source, settings, status=status, output=output)
    contacts_file = contacts_json(result.contacts, source, report["rig"], settings)
    pages = _pages(clip, result, report, contacts_file, settings)
    return Outputs(status, written, contacts_file, report, pages)


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


def _report(
    document: Document, result: Result, source: Mapping[str, Any], settings: Settings, *, status: Status,
    output: str | None,
) -> dict[str, Any]:  # fmt: skip
    clip = document.clip
    in_contact = float(result.contacts.mask().any(axis=1).sum()) * clip.frame_time
    return {
        **report_format.frame(source, version.__version__, status=status, output=output),
        "method": settings.enforce.method,
        "rig": report_format.rig(result.rig, clip, unit_m=document.unit_m, up=document.up),
        "settings": plain(settings),
        "before": report_format.measures(result.before),
        "after": report_format.measures(result.after),
        "plants": report_format.plants(result.plants, result.plants_before, result.plants_after),
        "correction": report_format.correction(result.correction, clip),
        "notes": report_format.notes((*document.notes, *result.notes)),
        # Of the motion, not of the machine: a report is the same whoever made it, on however many processes.
        "seconds": {
            "clip": report_format.rounded(len(clip) * clip.frame_time),
            "in_contact": report_format.rounded(in_contact),
        },
    }


def _too_short(
    data: bytes, document: Document, source: Mapping[str, Any], settings: Settings, output: str | None
) -> Outputs:
    frames = len(document.values)
    text = f"{frames} {'frame' if frames == 1 else 'frames'}: too short to hold a motion, so nothing was changed"
    report = {
        **report_format.frame(source, version.__version__, status="unchanged", output=output),
        "method": settings.enforce.method,
        "rig": {"unit_m": document.unit_m, "up": document.up, "leg_length_m": None, "floor_m": None},
        "settings": plain(settings),
        "before": {},
        "after": {},
        "plants": [],
        "correction": {"root_path_drift_m": 0.0, "max_root_shift_mm": 0.0, "max_joint_rotation_deg": 0.0},
        "notes": report_format.notes((*document.notes, Note("too-short", text))),
        "seconds": {"clip": report_format.rounded(frames * document.frame_time), "in_contact": 0.0},
    }
    contacts = Contacts(frames, document.frame_time, ())
    contacts_file = contacts_json(replace(contacts, method=settings.detect.method), source, report["rig"], settings)
    pages: dict[str, bytes] = {}
    if settings.report.kind == "html":
        from footfix.report.page import PageData, render

        pages[".report.html"] = render(PageData(report, json.loads(contacts_file))).encode("utf-8", "replace")
    return Outputs("unchanged", data, contacts_file, report, pages)


def _pages(
    clip: Clip, result: Result, report: Mapping[str, Any], contacts: bytes, settings: Settings
) -> dict[str, bytes]:
    pages: dict[str, bytes] = {}
    if settings.report.kind == "html":
        from footfix.report.motion import film
        from footfix.report.page import PageData, render

        data = PageData(report, json.loads(contacts), film(clip, result.clip, result.rig))
        pages[".report.html"] = render(data).encode("utf-8", "replace")
    return pages


def detect_file(
    data: bytes, name: str, settings: Settings, *, labels: Labels | None = None
) -> tuple[Contacts, dict[str, Any], dict[str, Any], list[dict[str, Any]]]:
    """The contacts of one clip, its source and rig entries, and its notes.

    Raises:
        InputError: the clip can't be used; says why.
    """
    document = read(data, name, settings)
    clip = document.clip
    source = source_entry(data, name, clip)
    if len(clip) < LEAST_FRAMES:
        raise InputError(f"{len(clip)} frames hold no motion to find contacts in", file=name)
    with about(name):
        rig = find_rig(clip, settings.rig)
        contacts = find_contacts(clip, rig, settings, labels)
    entry = report_format.rig(rig, clip, unit_m=document.unit_m, up=document.up)
    return contacts, source, entry, report_format.notes((*document.notes, *rig.notes, *contacts.notes))


def inspect_file(data: bytes, name: str, settings: Settings) -> dict[str, Any]:
    """What there is to say of a file: its frames, joints, rig, unit, axes, and everything odd about it.

    Raises:
        InputError: it is no BVH.
    """
    document = decode(data, name=name, limits=settings.limits)
    found: tuple[Note, ...] = document.notes
    rig: dict[str, Any] | None = None
    if not any(note.severity == "error" for note in found) and len(document.values):
        try:
            document, doubts = placed(document, settings.rig)
            found += doubts
            figure = find_rig(document.clip, settings.rig)
            rig = report_format.rig(figure, document.clip, unit_m=document.unit_m, up=document.up)
            found += figure.notes
        except InputError as error:
            found += (Note("no-legs", error.what, "warning"),)
    elif not len(document.values):
        found += (Note("no-frames", "the file holds no frames", "warning"),)
    return {
        "format": "footfix-inspect",
        "version": 1,
        "source": {
            "file": PurePath(name).name,
            "sha256": hashlib.sha256(data).hexdigest(),
            "frames": len(document.values),
            "frame_time": document.frame_time,
        },
        "fps": report_format.rounded(1.0 / document.frame_time),
        "joints": len(document.skeleton),
        "channels": int(document.values.shape[1]) if document.values.ndim == 2 else 0,
        "rig": rig,
        "notes": report_format.notes(found),
    }

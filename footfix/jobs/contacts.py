"""The contacts of one clip: detected in the bytes of its file, and written as a contacts file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from footfix import version
from footfix.errors import InputError
from footfix.formats import contacts as labels_format
from footfix.formats.contacts import Labels
from footfix.formats.document import Beside, Document, shown_skin
from footfix.jobs.source import LEAST_FRAMES, about, source_entry, suited
from footfix.motion.contacts import Contacts
from footfix.motion.contacts import joined as all_contacts
from footfix.pipeline import Prepared, prepare
from footfix.pipeline import find_contacts as detected
from footfix.report import document as report_format
from footfix.rig.find import find_rigs
from footfix.rig.skin import Skin
from footfix.settings import Settings, plain


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
    document, source, prepared, contacts = planted(data, name, settings, labels, "find contacts in", beside, skin)
    entry = report_format.rig(prepared.rigs[0], document.clip, unit_m=document.unit_m, up=document.up)
    return contacts, source, entry, doubts(document, prepared, contacts), document.start


def planted(
    data: bytes, name: str, settings: Settings, labels: Labels | None, purpose: str, beside: Beside | None,
    skin: Skin | None,
) -> tuple[Document, dict[str, Any], Prepared, Contacts]:
    """Read a file, and find its figures and their contacts.

    Args:
        data: the bytes of the file.
        name: its name, for messages.
        settings: the parameters of all steps.
        labels: contacts given by hand.
        purpose: a verb for the error about a clip that is too short, such as "measure".
        beside: reads files that this one names.
        skin: the character that `settings.rig.skin` names.

    Returns:
        The document, its source entry, the clip with its figures, and their contacts.

    Raises:
        InputError: the clip can't be used; says why.
    """
    document, frame_range, settings = suited(data, name, settings, beside)
    clip = document.clip
    if len(clip) < LEAST_FRAMES:
        raise InputError(f"{len(clip)} frames hold no motion to {purpose}", file=name)
    with about(name):
        skin = shown_skin(document, settings.rig, skin)
        prepared = prepare(clip, settings, find_rigs(clip, settings.rig, frame_range, skin), frame_range)
        return document, source_entry(data, name, clip), prepared, find_contacts(prepared, settings, labels)


def find_contacts(prepared: Prepared, settings: Settings, labels: Labels | None) -> Contacts:
    """Find the contacts of all figures: from the labels where they tell, from the detector elsewhere."""
    if labels is None:
        return detected(prepared, settings)
    blank = all_contacts([rig.no_contacts(prepared.clip) for rig in prepared.rigs])
    given, open_ones = labels_format.fit(labels, blank)
    return labels_format.merge(given, detected(prepared, settings), open_ones) if open_ones else given


def doubts(document: Document, prepared: Prepared, contacts: Contacts) -> list[dict[str, Any]]:
    """List the notes on a file, on the rigs found in it, and on its contacts, as reports have them."""
    notes = (note for rig in prepared.rigs for note in rig.notes)
    return report_format.notes((*document.notes, *notes, *prepared.notes, *contacts.notes))


def contacts_json(contacts: Contacts, source: Mapping[str, Any], rig: Mapping[str, Any], settings: Settings) -> bytes:
    """Write the contacts file of a clip."""
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

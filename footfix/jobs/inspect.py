"""What a file holds, and its repair, from bytes to bytes. No file is read or written here."""

from __future__ import annotations

import hashlib
from typing import Any

from footfix.errors import InputError
from footfix.formats.document import Beside, open_document, repair, separate_numbers, shown_skin
from footfix.formats.suffixes import bare
from footfix.jobs.shared_legs import with_shared_legs
from footfix.jobs.source import placed
from footfix.notes import Note
from footfix.report import document as report_format
from footfix.rig.find import find_rigs
from footfix.rig.skin import Skin
from footfix.settings import Settings


def repair_file(
    data: bytes, name: str, settings: Settings, *, beside: Beside | None = None
) -> tuple[bytes, list[dict[str, Any]]]:  # fmt: skip
    """Repair a file so that strict readers can read it, with a note for each change.

    Raises:
        InputError: it can't be read.
    """
    data, first = separate_numbers(data, name=name)
    mended, notes = repair(open_document(data, name=name, limits=settings.limits, beside=beside))
    return mended, report_format.notes((*first, *notes))


def inspect_file(
    data: bytes, name: str, settings: Settings, *, beside: Beside | None = None, skin: Skin | None = None
) -> dict[str, Any]:
    """Describe a file: its frames, joints, rig, unit, axes, and everything odd about it.

    Raises:
        InputError: it can't be read.
    """
    document = open_document(data, name=name, limits=settings.limits, beside=beside)
    settings = with_shared_legs(data, name, settings, beside)
    found: tuple[Note, ...] = document.notes
    rigs: list[dict[str, Any]] = []
    if not document.unusable and document.frames:
        try:
            document, doubts = placed(document, settings.rig)
            found += doubts
            skin = shown_skin(document, settings.rig, skin)
            for rig in find_rigs(document.clip, settings.rig, skin=skin):
                rigs.append(report_format.rig(rig, document.clip, unit_m=document.unit_m, up=document.up))
                found += rig.notes
        except InputError as error:
            found += (Note("no-legs", error.what, "warning"),)
    elif not document.frames:
        found += (Note("no-frames", "the file holds no frames", "warning"),)
    return {
        "format": "footfix-inspect",
        "version": 1,
        "source": {
            "file": bare(name),
            "sha256": hashlib.sha256(data).hexdigest(),
            "frames": document.frames,
            "frame_time": document.frame_time,
        },
        "fps": report_format.rounded(1.0 / document.frame_time),
        "joints": len(document.clip.skeleton),
        "channels": document.columns,
        "rig": rigs[0] if rigs else None,
        **({"figures": rigs} if len(rigs) > 1 else {}),
        "notes": report_format.notes(found),
    }

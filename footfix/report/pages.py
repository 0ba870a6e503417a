"""The pages of a clip: drawn when it is cleaned, or again from what lies on disk."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from footfix.errors import InputError
from footfix.formats.document import open_document
from footfix.motion.clip import Clip
from footfix.report.loops import captured, seen_as
from footfix.report.offenders import Offender, worst_plants
from footfix.report.web.motion import film
from footfix.report.web.page import PageData, render
from footfix.rig.find import find_rigs
from footfix.rig.params import RigParams
from footfix.rig.rig import Rig, joined
from footfix.settings import Layer, ReportParams, compose

PAGE, PICTURE = ".report.html", ".report.png"


def draw(
    before: Clip | None,
    after: Clip | None,
    rig: Rig | None,
    report: Mapping[str, Any],
    contacts: bytes,
    params: ReportParams,
) -> tuple[dict[str, bytes], tuple[Offender, ...]]:
    """The pages that settings ask for, by suffix, and the worst plants as small pictures for an index.

    Args:
        before, after: the clip as read and as written; None where there is no motion to show.
        rig: its legs and sole points.
        report: the report document.
        contacts: the bytes of the contacts file.
        params: which pages.
    """
    if params.kind != "html" and not params.png:
        return {}, ()
    motion = film(before, after, rig) if before is not None and after is not None and rig is not None else None
    pages: dict[str, bytes] = {}
    if params.kind == "html":
        # A file name that is no UTF-8 keeps its bytes in the document.
        document = json.loads(contacts.decode("utf-8", "surrogateescape"))
        pages[PAGE] = render(PageData(report, document, motion)).encode("utf-8", "replace")
    if params.png:
        from footfix.report.picture import picture

        pages[PICTURE] = picture(motion, report)
    return pages, worst_plants(motion, report) if motion is not None else ()


def redraw(
    report: Mapping[str, Any], contacts: bytes, source: bytes, written: bytes, params: ReportParams
) -> dict[str, bytes]:
    """The pages of a clip that was cleaned before.

    Args:
        report: its report document.
        contacts: the bytes of its contacts file.
        source: the bytes of the clip that came in.
        written: the bytes of the corrected one.
        params: which pages.

    Raises:
        InputError: the files do not belong together.
    """
    rig = report.get("rig") or {}
    try:
        unit_m, up = float(rig["unit_m"]), str(rig["up"])
    except (KeyError, TypeError, ValueError):
        raise InputError("the report does not say the clip's unit and up axis") from None
    name = str((report.get("source") or {}).get("file", ""))
    before, after = (
        open_document(data, name=name).placed(unit_m=unit_m, up=up).clip for data in (source, written)
    )
    whole = before
    if isinstance(report.get("loop"), Mapping):
        before = captured(whole, report["loop"])
    if (len(before), len(before.skeleton)) != (len(after), len(after.skeleton)):
        raise InputError(f"the clip has {len(before)} frames and the corrected one {len(after)}: not the same clip")
    if rig.get("leg_length_m") is None:
        return draw(None, None, None, report, contacts, params)[0]
    rigs = joined(find_rigs(whole, _told(report)))
    if before is not whole:
        before = seen_as(before, rigs, report["loop"])
    return draw(before, after, rigs, report, contacts, params)[0]


def _told(report: Mapping[str, Any]) -> RigParams:
    """What the settings in a report say of the rig, so that it is the same one again."""
    told = (report.get("settings") or {}).get("rig") or {}
    return compose([Layer("report", {"rig": told})]).rig

"""The pages of a clip: drawn when it is cleaned, or redrawn from its files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from footfix.enforce.task import ground_of
from footfix.errors import InputError
from footfix.formats import contacts as labels_format
from footfix.formats.document import Beside, open_document, shown_skin
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.report.loop_text import captured_frames, in_place_if_written_so
from footfix.report.offenders import Offender, worst_plants
from footfix.report.rerun_command import RerunCommand
from footfix.report.web.motion import film
from footfix.report.web.page import PageData, render
from footfix.rig.find import find_rigs
from footfix.rig.rig import Rig, joined
from footfix.rig.skin import Skin
from footfix.settings import Layer, ReportParams, Settings, compose

PAGE, PICTURE = ".report.html", ".report.png"


def draw(
    before: Clip | None,
    after: Clip | None,
    rig: Rig | None,
    report: Mapping[str, Any],
    contacts: bytes,
    params: ReportParams,
    again: RerunCommand | None = None,
    ground: Floats | None = None,
) -> tuple[dict[str, bytes], tuple[Offender, ...]]:
    """Draw the pages that the settings ask for, by suffix, and the worst plants as small pictures for an index.

    Args:
        before, after: the clip as read and as written; None where there is no motion to show.
        rig: its legs and sole points.
        report: the report document.
        contacts: the bytes of the contacts file.
        params: which pages.
        again: how the clip is cleaned again from edited contacts, where that is known.
        ground: (F, 3) [m] how far the ground under planted feet has moved; at rest by default.
    """
    if params.kind != "html" and not params.png:
        return {}, ()
    motion = None
    if before is not None and after is not None and rig is not None:
        motion = film(before, after, rig, _planted(before, rig, contacts), ground)
    pages: dict[str, bytes] = {}
    if params.kind == "html":
        # A file name that is no UTF-8 keeps its bytes in the document.
        document = json.loads(contacts.decode("utf-8", "surrogateescape"))
        pages[PAGE] = render(PageData(report, document, motion, again=again)).encode("utf-8", "replace")
    if params.png:
        from footfix.report.picture import picture

        pages[PICTURE] = picture(motion, report)
    return pages, worst_plants(motion, report) if motion is not None else ()


def redraw(
    report: Mapping[str, Any], contacts: bytes, source: bytes, written: bytes, params: ReportParams,
    again: RerunCommand | None = None, beside: Beside | None = None, skin: Skin | None = None,
) -> dict[str, bytes]:  # fmt: skip
    """Draw the pages of a clip again from its report, its contacts file and the clips before and after.

    Args:
        report: its report document.
        contacts: the bytes of its contacts file.
        source: the bytes of the captured clip.
        written: the bytes of the corrected one.
        params: which pages.
        again: how the clip is cleaned again from edited contacts, where that is known.
        beside: reads files that the clip names.
        skin: the character that the report's `rig.skin` names, where its file was found.

    Raises:
        InputError: the files do not belong together.
    """
    if report.get("follow"):
        raise InputError("a walk along a path is drawn when it is made; footfix follow draws it again")
    rig = report.get("rig") or {}
    try:
        unit_m, up = float(rig["unit_m"]), str(rig["up"])
    except (KeyError, TypeError, ValueError):
        raise InputError("the report does not say the clip's unit and up axis") from None
    name = str((report.get("source") or {}).get("file", ""))
    document, corrected = (
        open_document(data, name=name, beside=beside).placed(unit_m=unit_m, up=up) for data in (source, written)
    )
    clip, after = document.clip, corrected.clip
    loop = report["loop"] if isinstance(report.get("loop"), Mapping) else None
    before = clip if loop is None else captured_frames(clip, loop)
    if (len(before), len(before.skeleton)) != (len(after), len(after.skeleton)):
        raise InputError(f"the clip has {len(before)} frames and the corrected one {len(after)}: not the same clip")
    if rig.get("leg_length_m") is None:
        return draw(None, None, None, report, contacts, params, again)[0]
    settings = _settings(report)
    rigs = find_rigs(clip, settings.rig, skin=shown_skin(document, settings.rig, skin))
    whole = joined(rigs)
    belt = ground_of(before, rigs[0], _planted(before, rigs[0], contacts, whole), settings.enforce.ground)
    if loop is not None:
        before = in_place_if_written_so(before, whole, loop)
    return draw(before, after, whole, report, contacts, params, again, belt)[0]


def _planted(clip: Clip, rig: Rig, contacts: bytes, whole: Rig | None = None) -> Contacts:
    """Take the contacts of one figure from the contacts `whole` of all figures."""
    all_of_them, _ = labels_format.fit(labels_format.decode(contacts), (whole or rig).no_contacts(clip))
    return all_of_them.only(sole.name for sole in rig.soles)


def _settings(report: Mapping[str, Any]) -> Settings:
    """Read the settings of the rig and of moving ground from a report, to find both again as they were."""
    stored = report.get("settings") or {}
    ground = (stored.get("enforce") or {}).get("ground") or {}
    return compose([Layer("report", {"rig": stored.get("rig") or {}, "enforce": {"ground": ground}})])

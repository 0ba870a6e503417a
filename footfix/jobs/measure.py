"""The measures of one clip as it is, from the bytes of its file."""

from __future__ import annotations

from typing import Any

from footfix.formats.contacts import Labels
from footfix.formats.document import Beside
from footfix.jobs.contacts import doubts, planted
from footfix.pipeline import measure_as_it_is
from footfix.report import document as report_format
from footfix.rig.skin import Skin
from footfix.settings import Settings


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
    document, source, prepared, contacts = planted(data, name, settings, labels, "measure", beside, skin)
    found = measure_as_it_is(document.clip, prepared, contacts, settings)
    measures = report_format.worst([report_format.measures(each) for each, _ in found])
    plants = [
        {"effector": each.effector, "start": each.start, "end": each.end,
         "slide_mm": report_format.rounded(each.slide_mm)}
        for _, of_figure in found
        for each in of_figure
    ]  # fmt: skip
    return source, measures, doubts(document, prepared, contacts), plants

"""The report and contacts of an earlier cleaning, found beside the clip that it wrote."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path, PurePath
from typing import Any

from footfix.batch.file_io import STDIN
from footfix.batch.task import REPORT, Task
from footfix.formats.contacts import Labels
from footfix.formats.suffixes import in_file
from footfix.motion.contacts import Contact
from footfix.version import __version__


def contacts_of_cleaning(task: Task, data: bytes) -> Labels | None:
    """Find the contacts of a clip that a cleaning with the same settings and version wrote, identical to the byte.

    Such a clip is left as it is: contacts detected on a cleaned clip end some frames earlier or later, and plants that
    were let go would be tried again.

    Args:
        task: the clip and its settings.
        data: its bytes.

    Returns:
        The contacts, with the report as their source; None for any other clip.
    """
    from footfix.settings import plain

    if task.labels is not None or task.extra.get("anew"):
        return None
    report = report_beside(task)
    if "output_sha256" not in report:
        return None
    same = (
        report["output_sha256"] == hashlib.sha256(data).hexdigest()
        and report.get("footfix") == __version__
        and _that_matter(report.get("settings")) == _that_matter(json.loads(json.dumps(plain(task.settings))))
    )
    return contacts_of(report) if same else None


def _that_matter(settings: Any) -> dict[str, Any]:
    """Keep only the settings that affect the clip."""
    kept = settings if isinstance(settings, dict) else {}
    return {name: each for name, each in kept.items() if name not in ("report", "gates", "limits")}


def report_beside(task: Task) -> Mapping[str, Any]:
    """Read the report, beside a clip, of the cleaning that wrote the clip; an empty one if there is none."""
    if task.job.source == STDIN:
        return {}
    path = Path(task.folder, in_file(task.job.source)[0])
    stem, end = path.name.removesuffix(path.suffix), task.job.end
    for name in dict.fromkeys((stem + end, stem.removesuffix(".clean") + end)):
        try:
            report: Any = json.loads(path.with_name(name + REPORT).read_bytes())
        except (OSError, ValueError):
            continue
        if isinstance(report, dict) and report.get("output") == PurePath(path).name and report.get("before"):
            return {**report, "file": name + REPORT}
    return {}


def contacts_of(report: Mapping[str, Any]) -> Labels | None:
    """Read the plants of each effector from the report of a cleaning, as labels; None where it can't be read."""
    held: dict[str, tuple[Contact, ...]] = {}
    try:
        for plant in report["plants"]:
            contact = Contact(int(plant["start"]), int(plant["end"]))
            held[str(plant["effector"])] = (*held.get(str(plant["effector"]), ()), contact)
    except (KeyError, TypeError, ValueError):
        return None
    rigs = report.get("figures") or [report.get("rig") or {}]
    names = [str(sole["name"]) for rig in rigs for sole in rig.get("soles", ())]
    return Labels({each: held.get(each, ()) for each in names}, source=str(report.get("file", "")))

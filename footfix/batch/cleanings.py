"""What lies beside a clip that footfix cleaned before: its report, and the contacts that it was cleaned by."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path, PurePath
from typing import Any

from footfix.batch.files import STDIN
from footfix.batch.task import REPORT, Task
from footfix.formats.contacts import Labels
from footfix.formats.suffixes import in_file
from footfix.motion.contacts import Contact
from footfix.version import __version__


def contacts_it_was_cleaned_by(task: Task, data: bytes) -> Labels | None:
    """Find the contacts of a clip that is, to the byte, what a cleaning with the same settings and version wrote.

    Such a clip stays as it is: contacts that are found on a cleaned clip end some frames earlier or later, and what
    was let go would be tried again.

    Args:
        task: the clip and its settings.
        data: its bytes.

    Returns:
        The contacts, whose source is the report that says so; None of any other clip.
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
    """Leave the settings that change no clip out."""
    kept = settings if isinstance(settings, dict) else {}
    return {name: each for name, each in kept.items() if name not in ("report", "gates", "limits")}


def report_beside(task: Task) -> Mapping[str, Any]:
    """Find the report of the cleaning that a clip came from, where it lies beside it; nothing elsewhere."""
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
    """Take the plants that a cleaning found of each effector, as labels; None where its report can't be read."""
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

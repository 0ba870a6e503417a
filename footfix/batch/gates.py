"""Gates: the most that measures of a clip may be, and whether it keeps within."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path, PurePath
from typing import Any

from footfix.batch.files import STDIN
from footfix.batch.task import REPORT, FileResult, Task
from footfix.errors import UsageError
from footfix.formats.contacts import Labels
from footfix.measure.clip import WORLD, Measures
from footfix.motion.contacts import Contact
from footfix.settings import suggest

# Measures held against the clip before it was cleaned: what cleaning may cost.
RATIOS: Mapping[str, str] = {
    "jitter_ratio": "jitter_100m_s3",
    "acceleration_ratio": "peak_acceleration_m_s2",
    "knee_speed_ratio": "peak_knee_speed_deg_s",
}
NAMES = tuple(each.name for each in dataclasses.fields(Measures)) + tuple(RATIOS)


def parse(texts: tuple[str, ...]) -> dict[str, float]:
    """Gates from "slide_mm=21" and the like.

    Raises:
        UsageError: no such measure, or no number.
    """
    gates = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            gates[name.strip()] = float(value)
        except ValueError:
            equals = ""
        if not equals or gates[name.strip()] != gates[name.strip()]:
            raise UsageError(f"--max takes NAME=NUMBER, such as slide_mm=21, not {text!r}")
    known(gates)
    return gates


def known(gates: Mapping[str, float]) -> None:
    """Raises UsageError where a gate is on no measure."""
    for name in gates:
        if name not in NAMES:
            raise UsageError(f"there is no measure {name!r} to gate{suggest(name, NAMES)}")


def check(task: Task, data: bytes) -> FileResult:
    """Measures a clip and holds it against its gates.

    Args:
        task: `extra["gates"]` are those of the command line; they lie over the settings' own.
        data: the bytes of the clip.

    Returns:
        Status "over" where a gate is passed, "done" where none is; the report holds measures and gates. A gate on
        what this clip has no measure of is skipped, and a note says so.
    """
    from footfix.job import measure_file

    source = task.job.source
    gates = {**task.settings.gates, **task.extra.get("gates", {})}
    known(gates)
    before, labels = _cleaning(task)
    entry, measures, notes = measure_file(data, source, task.settings, labels=task.labels or labels)
    values = dict(measures)
    wanted = [name for name in gates if name in RATIOS]
    for name in wanted:
        now, was = measures.get(RATIOS[name]) or 0.0, (before or measures).get(RATIOS[name]) or 0.0
        values[name] = float(f"{now / was:.6g}") if was > 0.0 else 1.0
    if wanted and before is None:
        notes = [*notes, _no_reference(wanted)]
    over = [
        {"measure": name, "value": value, "most": most}
        for name, most in gates.items()
        if (value := values[name]) is not None and value > most
    ]
    notes = [*notes, *_not_measured([name for name in gates if values[name] is None])]
    report = {"source": entry, "measures": values, "gates": gates, "over": over, "notes": notes}
    return FileResult(source, "over" if over else "done", report=report)


def _cleaning(task: Task) -> tuple[Mapping[str, float | None] | None, Labels | None]:
    """Measures of the clip before it was cleaned, and its contacts, where its report and labels lie beside it."""
    if task.job.source == STDIN:
        return None, None
    path = Path(task.folder, task.job.source)
    stem = path.name.removesuffix(path.suffix)
    for name in dict.fromkeys((stem, stem.removesuffix(".clean"))):
        try:
            report: Any = json.loads(path.with_name(name + REPORT).read_bytes())
        except (OSError, ValueError):
            continue
        if isinstance(report, dict) and report.get("output") == PurePath(path).name and report.get("before"):
            return report["before"], None if task.extra.get("anew") else _held(report, name + REPORT)
    return None, None


def _held(report: Mapping[str, Any], name: str) -> Labels | None:
    """The plants that cleaning found of each effector, as labels."""
    held: dict[str, tuple[Contact, ...]] = {}
    try:
        for plant in report["plants"]:
            contact = Contact(int(plant["start"]), int(plant["end"]))
            held[str(plant["effector"])] = (*held.get(str(plant["effector"]), ()), contact)
    except (KeyError, TypeError, ValueError):
        return None
    rigs = report.get("figures") or [report.get("rig") or {}]
    names = [str(sole["name"]) for rig in rigs for sole in rig.get("soles", ())]
    return Labels({each: held.get(each, ()) for each in names}, source=name)


def _no_reference(wanted: list[str]) -> dict[str, Any]:
    text = f"{', '.join(wanted)}: no report of its cleaning lies beside this clip, so it is held against itself"
    return {"id": "no-reference", "severity": "warning", "text": text}


def _not_measured(names: list[str]) -> list[dict[str, Any]]:
    """Notes on gates that a clip has no measure for."""
    reasons = {
        "planted feet move with a belt, and these know no ground that moves": [n for n in names if n in WORLD],
        "no planted foot has a tip beyond its toe joint": [n for n in names if n not in WORLD],
    }
    return [
        {"id": "not-measured", "severity": "warning", "text": f"{', '.join(which)}: not gated: {reason}"}
        for reason, which in reasons.items()
        if which
    ]

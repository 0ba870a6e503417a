"""Gates: upper bounds on measures of a clip, and whether it keeps them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from footfix.batch.earlier_results import contacts_of, report_beside
from footfix.batch.task import FileResult, Task
from footfix.errors import UsageError
from footfix.formats.contacts import Labels
from footfix.measure.cleaning_effect import COST_OF, Costs, Held, costs, held
from footfix.measure.clip import WORLD, Measures
from footfix.measure.plants import NOTICED_MM
from footfix.settings import Meaning, meanings, suggest

# Every measure that may be gated, with its meaning and unit, from its definition.
MEASURES: Mapping[str, Meaning] = {**meanings(Measures), **meanings(Held), **meanings(Costs)}
NAMES = tuple(MEASURES)


@dataclass(frozen=True)
class Gate:
    """An upper bound on a measure, and the reason for it."""

    most: float
    why: str


# The gates where neither the command line nor the settings give any. Of 35 real clips, each of another origin, 12 pass
# as captured, and 29 after cleaning.
DEFAULTS: Mapping[str, Gate] = {
    "share_over_21mm": Gate(0.1, "viewers notice a slide of 21 mm (Prazak 2011); one plant in ten may be lost"),
    "skating_ratio": Gate(0.5, "counts low swings, too: captured walks reach 0.4 with feet that stand"),
    "penetration_mm": Gate(50.0, "the height up to which the field takes a foot for being on the floor"),
}


def parse(texts: tuple[str, ...]) -> dict[str, float]:
    """Parse gates from "slide_mm=21" and the like.

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
    """Refuse gates on unknown measures, with a UsageError."""
    for name in gates:
        if name not in NAMES:
            raise UsageError(f"there is no measure {name!r} to gate{suggest(name, NAMES)}")


def check(task: Task, data: bytes) -> FileResult:
    """Measure a clip and compare it with its gates.

    Args:
        task: `extra["gates"]` are those of the command line; they override those of the settings. Without any,
            `DEFAULTS` are used.
        data: the bytes of the clip.

    Returns:
        Status "over" where a measure exceeds its gate, else "done"; the report holds measures and gates. A gate on a
        measure that this clip lacks is skipped, with a note.
    """
    from footfix.batch.multi_clip_files import beside_of
    from footfix.batch.skins import skin_for
    from footfix.jobs.measure import measure_file

    source = task.job.source
    given = {**task.settings.gates, **task.extra.get("gates", {})}
    gates = given or {name: gate.most for name, gate in DEFAULTS.items()}
    known(gates)
    report = report_beside(task)
    before, labels = _cleaning(task, report)
    entry, measures, notes, plants = measure_file(
        data, source, task.settings, labels=task.labels or labels, beside=beside_of(task),
        skin=skin_for(task.settings, task.folder),
    )  # fmt: skip
    plants = [{**plant, **reason} for plant, reason in zip(plants, _reasons(report, plants), strict=True)]
    values = {**measures, **_rounded(held([p["slide_mm"] for p in plants], [bool(p["let_go"]) for p in plants]))}
    wanted = [name for name in gates if name in COST_OF]
    paid = dataclasses.asdict(costs(measures, before or measures))
    values |= {name: paid[name] for name in wanted}
    if wanted and before is None:
        notes = [*notes, _no_reference(wanted)]
    over = [
        {"measure": name, "value": value, "most": most, **_why(name, plants)}
        for name, most in gates.items()
        if (value := values[name]) is not None and value > most
    ]
    notes = [*notes, *_not_measured([name for name in gates if values[name] is None])]
    found = {"source": entry, "measures": values, "gates": gates, "over": over, "notes": notes}
    return FileResult(source, "over" if over else "done", report=found)


def _rounded(found: Held) -> dict[str, float]:
    return {name: float(f"{value:.6g}") if isinstance(value, float) else value for name, value in vars(found).items()}


def _why(measure: str, plants: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Explain a slide over its gate: how many held and let-go plants exceed 21 mm, and the worst with its reason."""
    if measure not in ("share_over_21mm", "plants_over_21mm", "slide_mm", "held_slide_mm", "held_over_21mm"):
        return {}
    some = [plant for plant in plants if not (measure.startswith("held") and plant["let_go"])]
    worst = max(some, key=lambda plant: float(plant["slide_mm"]), default=None)
    if worst is None:
        return {}
    far = [plant for plant in some if plant["slide_mm"] > NOTICED_MM]
    gone = sum(bool(plant["let_go"]) for plant in far)
    counted = f"{len(far)} of {len(some)} plants over 21 mm" + (f", {gone} of them let go when cleaned" if gone else "")
    place = f"farthest {worst['effector']} {worst['start']}-{worst['end']}, {worst['slide_mm']:.0f} mm"
    return {"why": f"{counted}; {place}" + (f", {worst['let_go']}" if worst["let_go"] else "")}


def _cleaning(
    task: Task, report: Mapping[str, Any]
) -> tuple[Mapping[str, float | None] | None, Labels | None]:  # fmt: skip
    """Find the measures of the clip before it was cleaned, and its contacts."""
    if not report:
        return None, None
    return report["before"], None if task.extra.get("anew") else contacts_of(report)


def _reasons(report: Mapping[str, Any], plants: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Find for each plant the reason why cleaning let it go, wholly or in part; "" where it is held."""
    words = {"released": "let go", "partly": "held only in part"}
    reasons: dict[tuple[Any, ...], str] = {}
    for each in report.get("plants") or ():
        if isinstance(each, dict) and each.get("outcome") in words:
            why = f": {each['reason']}" if each.get("reason") else ""
            reasons[each.get("effector"), each.get("start"), each.get("end")] = words[each["outcome"]] + why
    return [{"let_go": reasons.get((p["effector"], p["start"], p["end"]), "")} for p in plants]


def _no_reference(wanted: list[str]) -> dict[str, Any]:
    text = f"{', '.join(wanted)}: no report of its cleaning lies beside this clip, so it is held against itself"
    return {"id": "no-reference", "severity": "warning", "text": text}


def _not_measured(names: list[str]) -> list[dict[str, Any]]:
    """Note the gates that a clip has no measure for."""
    reasons = {
        "planted feet move with a belt, and these know no ground that moves": [n for n in names if n in WORLD],
        "no planted foot has a tip beyond its toe joint": [n for n in names if n not in WORLD],
    }
    return [
        {"id": "not-measured", "severity": "warning", "text": f"{', '.join(which)}: not gated: {reason}"}
        for reason, which in reasons.items()
        if which
    ]

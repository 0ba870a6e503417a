"""The verdict on a clip: what was wrong, is it good now, in one sentence and a few numbers.

Everything here reads the report document (the contract's report file) and nothing else, so that the
terminal, the page and the batch index say the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from footfix.measure.plants import NOTICED_MM

Report = Mapping[str, Any]
Tone = Literal["good", "fair", "bad", "quiet"]

_LIMIT = f"{NOTICED_MM:g} mm"
WORSE_MM = 5.0  # a plant whose slide grew by more than this came out worse


@dataclass(frozen=True)
class Verdict:
    """The main result, for the first line of a report.

    Args:
        tone: "good" (as it should be), "fair" (better, or needs a look), "bad" (could not be helped),
            "quiet" (nothing to judge).
        word: one word for a badge or a table.
        text: one sentence, ending without a full stop.
        plants: contacts judged.
        over_before, over_after: how many of them slide farther than viewers notice.
        worst_before, worst_after: [mm] the longest slide.
        worse: how many came out sliding farther than they went in, by more than `WORSE_MM`.
        helped: how many slide less than they did, by more than that or by half.
    """

    tone: Tone
    word: str
    text: str
    plants: int = 0
    over_before: int = 0
    over_after: int = 0
    worst_before: float = 0.0
    worst_after: float = 0.0
    worse: int = 0
    helped: int = 0


def number(value: Any) -> float | None:
    """Get a finite number of the report, None where there is none."""
    return float(value) if isinstance(value, int | float) and abs(value) < 1e15 else None


def source_name(report: Report) -> str:
    """Get the name of the clip's file."""
    source = report.get("source")
    return str((source.get("file") if isinstance(source, Mapping) else source) or "clip")


def entries(report: Report, key: str) -> list[Report]:
    """Get the objects in a list of the report; anything else in it is left out, for reports may come from anywhere."""
    found = report.get(key)
    return [each for each in found if isinstance(each, Mapping)] if isinstance(found, list | tuple) else []


def section(report: Report, key: str) -> Report:
    """Get an object of the report; an empty one where it has none."""
    found = report.get(key)
    return found if isinstance(found, Mapping) else {}


def slides(plants: Sequence[Report], when: Literal["before", "after"]) -> list[float]:
    """Get the slide of each plant [mm], 0 where it is not known."""
    return [number(plant.get(f"slide_{when}_mm")) or 0.0 for plant in plants]


def worst_first(plants: Sequence[Report]) -> list[Report]:
    """Sort plants, the worst first: by slide after cleaning, and those that hardly slide by slide before it."""

    def slide(plant: Report) -> tuple[float, float]:
        after = number(plant.get("slide_after_mm")) or 0.0
        return (after if after > NOTICED_MM else 0.0), number(plant.get("slide_before_mm")) or 0.0

    return sorted(plants, key=slide, reverse=True)


def judge(report: Report) -> Verdict:
    """Judge a clip from its report document."""
    if report.get("status") == "failed":
        return Verdict("bad", "failed", "This clip could not be worked on")
    plants = entries(report, "plants")
    if not plants:
        return Verdict("quiet", "no plants", "No footplants were found, so there was nothing to hold in place")
    before, after = slides(plants, "before"), slides(plants, "after")
    counted = Verdict(
        "good", "", "", len(plants),
        over_before=sum(slide > NOTICED_MM for slide in before),
        over_after=sum(slide > NOTICED_MM for slide in after),
        worst_before=max(before), worst_after=max(after),
        worse=sum(now > was + WORSE_MM for was, now in zip(before, after, strict=True)),
        helped=sum(_helped(was, now) for was, now in zip(before, after, strict=True)),
    )  # fmt: skip
    tone, word, text = _as_it_was(counted) if report.get("status") == "unchanged" else _words(counted)
    if counted.worse:
        text += f"; {counted.worse} {_slide(counted.worse)} farther than before"
        tone, word = ("fair", "mixed") if tone == "good" else (tone, word)
    return replace(counted, tone=tone, word=word, text=text)


def _helped(was: float, now: float) -> bool:
    """Tell whether a plant slides less than before: by `WORSE_MM`, or by half where the slide was noticeable."""
    return now < was - WORSE_MM or (was > 1.0 and now < was / 2.0)


def _as_it_was(found: Verdict) -> tuple[Tone, str, str]:
    """Choose tone, word and sentence for a clip that was not changed."""
    if found.over_before:
        some = _of(found.over_before, found.plants)
        return "fair", "left alone", f"Left as it was, though {some} {_slide(found.over_before)} more than {_LIMIT}"
    every = "The one footplant stands" if found.plants == 1 else f"All {found.plants} footplants stand"
    return "good", "fine as it was", f"{every} still: nothing needed doing"


def _words(found: Verdict) -> tuple[Tone, str, str]:
    """Choose tone, word and sentence for a clip that was changed, by the plants improved and those still sliding."""
    before, after, plants = found.over_before, found.over_after, found.plants
    if not before and not after:
        longest = [f"{worst:.0f}" for worst in (found.worst_before, found.worst_after)]
        if longest[0] == longest[1]:
            return "good", "tidied", "No footplant slid noticeably, before or after"
        return "good", "tidied", f"No footplant slid noticeably; the longest slide went from {' to '.join(longest)} mm"
    if not after:
        return "good", "fixed", f"{_of(before, plants)} slid more than {_LIMIT}; now none does"
    if after < before:
        return "fair", "better", f"{_of(before, plants)} slid more than {_LIMIT}; {after} still {_do(after)}"
    if found.helped > found.worse:
        less = f"{_of(found.helped, plants)} {_slide(found.helped)} less than before"
        return "fair", "partly better", f"{less}; {after} still {_slide(after)} more than {_LIMIT}"
    if found.worse > found.helped:
        return "bad", "worse", f"{_of(after, plants)} {_slide(after)} more than {_LIMIT}, {before or 'none'} did before"
    return "bad", "not helped", f"{_of(after, plants)} still {_slide(after)} more than {_LIMIT}"


def _of(some: int, plants: int) -> str:
    if plants == 1:
        return "The one footplant"
    return f"{'All' if some == plants else f'{some} of'} {plants} footplants"


def _slide(count: int) -> str:
    return "slides" if count == 1 else "slide"


def _do(count: int) -> str:
    return "does" if count == 1 else "do"


@dataclass(frozen=True)
class Measure:
    """How a measure of the report's `before` and `after` is shown.

    Args:
        key: its key in the report.
        label: its name on the page.
        unit: "" where it has none.
        digits: decimals.
        scale: factor to that unit.
        headline: its label on the first screen, "" where it does not stand there.
        tolerance: how much it may grow, in its unit, before it counts as worse; None where growing is not worse.
    """

    key: str
    label: str
    unit: str
    digits: int
    scale: float = 1.0
    headline: str = ""
    tolerance: float | None = 0.0


MEASURES = (
    Measure("slide_mm", "Longest slide of a plant", "mm", 1),
    Measure("slide_median_mm", "Median slide of the plants", "mm", 1, headline="Median slide", tolerance=0.5),
    Measure("share_over_21mm", "Plants that slide more than 21 mm", "%", 0, 100.0),
    Measure("tip_over_21mm", "Toe tips that slide more than 21 mm", "%", 0, 100.0),
    Measure("yaw_deg", "Largest turn of a planted foot", "°", 1),
    Measure("skate_cm_s", "Mean speed while planted", "cm/s", 1, headline="Planted speed", tolerance=0.5),
    Measure("skate_worst_cm_s", "Highest speed while planted", "cm/s", 1),
    Measure("coverage", "Contact share of the clip", "%", 1, 100.0, tolerance=None),
    Measure("penetration_mm", "Deepest below the floor while planted", "mm", 1, headline="Below floor", tolerance=0.5),
    Measure("float_mm", "Highest above the floor while planted", "mm", 1),
    Measure("skating_ratio", "Foot skating ratio (GMD, OmniControl)", "%", 2, 100.0),
    Measure("weighted_skate_cm_s", "Height-weighted skate (MANN)", "cm/s", 2),
    Measure("phys_penetrate_mm", "Penetrate (PhysDiff)", "mm", 2),
    Measure("phys_float_mm", "Float (PhysDiff)", "mm", 2),
    Measure("phys_skate_mm", "Skate (PhysDiff)", "mm", 2),
    Measure("jitter_100m_s3", "Jitter", "10² m/s³", 2, headline="Jitter", tolerance=0.1),
    Measure("peak_acceleration_m_s2", "Peak leg acceleration", "m/s²", 1),
    Measure("peak_knee_speed_deg_s", "Peak knee speed", "°/s", 0),
)


@dataclass(frozen=True)
class Row:
    """A measure before and after, ready to be printed.

    Args:
        key: of the measure.
        label, unit: of the measure.
        before, after: as text; "–" where it was not measured.
        headline: its label on the first screen, "" where it does not stand there.
        worse: whether it grew so much that a person should know.
    """

    key: str
    label: str
    unit: str
    before: str
    after: str
    headline: str
    worse: bool


def measure_rows(report: Report) -> list[Row]:
    """List the measures that the report holds, in a fixed order."""
    before, after = section(report, "before"), section(report, "after")
    rows = []
    for measure in MEASURES:
        pair = number(before.get(measure.key)), number(after.get(measure.key))
        if measure.key in before or measure.key in after:
            largest = max(value or 0.0 for value in pair) * measure.scale
            digits = 0 if largest >= 100.0 else min(measure.digits, 1) if largest >= 10.0 else measure.digits
            first, second = ("–" if value is None else f"{value * measure.scale:.{digits}f}" for value in pair)
            worse = _is_worse(measure, *pair)
            rows.append(Row(measure.key, measure.label, measure.unit, first, second, measure.headline, worse))
    return rows


def _is_worse(measure: Measure, before: float | None, after: float | None) -> bool:
    """Tell whether a measure grew by more than a tenth and by more than its tolerance."""
    if before is None or after is None or measure.tolerance is None:
        return False
    return after * measure.scale > max(1.1 * before * measure.scale, before * measure.scale + measure.tolerance)


@dataclass(frozen=True)
class Change:
    """The largest change of a joint.

    Args:
        joint: its name in the file.
        degrees: the angle between its rotations before and after, in its parent's frame.
        frame: when.
    """

    joint: str
    degrees: float
    frame: int


def largest_change(report: Report) -> Change | None:
    """Find the largest change that cleaning made to a joint; None where no joint was turned."""
    found = section(report, "correction")
    joint, degrees = found.get("largest_change_joint"), number(found.get("largest_change_deg"))
    frame = number(found.get("largest_change_frame"))
    return None if joint is None or degrees is None or frame is None else Change(str(joint), degrees, int(frame))


def floor_taken(report: Report) -> str:
    """Say which floor was used and how it was found; "" where the report does not tell."""
    rig = section(report, "rig")
    height, origin = number(rig.get("floor_m")), section(rig, "origins").get("floor")
    return "" if height is None or origin is None else f"{height:.3f} m: {origin}"

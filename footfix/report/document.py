"""The report of a clip as data: the contract's report file, version 1."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant
from footfix.measure.clip import Measures
from footfix.measure.plants import NOTICED_MM, PlantMeasure
from footfix.motion import rotation
from footfix.motion.clip import Clip
from footfix.notes import Note
from footfix.rig.rig import Rig

FORMAT, VERSION = "footfix-report", 1


def rounded(value: float) -> float:
    """Round a number to six significant digits, and negative zero to zero."""
    return float(f"{value:.6g}") + 0.0


def measures(found: Measures) -> dict[str, float | None]:
    """Convert measures to a dictionary: None where there is nothing to measure; each key carries its unit."""
    return {
        key: rounded(each) if isinstance(each, float) else each for key, each in dataclasses.asdict(found).items()
    }


def note(each: Note) -> dict[str, Any]:
    """Convert a note to a dictionary without empty fields."""
    plain: dict[str, Any] = {"id": each.id, "severity": each.severity, "text": each.text}
    for key in ("line", "column", "start", "end"):
        if getattr(each, key) is not None:
            plain[key] = getattr(each, key)
    if each.joints:
        plain["joints"] = list(each.joints)
    return plain


def notes(found: Iterable[Note]) -> list[dict[str, Any]]:
    """Convert notes in the order in which they arose, each once."""
    return [note(each) for each in dict.fromkeys(found)]


def rig(found: Rig, clip: Clip, *, unit_m: float, up: str) -> dict[str, Any]:
    """Describe the rig by joint names, with the origin of each guess."""
    names = clip.skeleton.names
    return {
        "unit_m": rounded(unit_m),
        "up": up,
        "leg_length_m": rounded(found.leg_length),
        "floor_m": rounded(found.floor),
        "root": names[found.root],
        "pelvis": names[found.pelvis],
        "legs": [
            {
                "name": leg.name,
                "side": leg.side,
                "hip": names[leg.hip],
                "knee": names[leg.knee],
                "ankle": names[leg.ankle],
                "toe": None if leg.toe is None else names[leg.toe],
                "chain": [names[joint] for joint in leg.chain],
            }
            for leg in found.legs
        ],
        "soles": [
            {
                "name": sole.name,
                "joint": names[sole.joint],
                "offset_m": [rounded(x) for x in sole.offset],
            }
            for sole in found.soles
        ],
        "origins": dict(found.origins),
    }


def plants(
    found: Sequence[Footplant], before: Sequence[PlantMeasure], after: Sequence[PlantMeasure]
) -> list[dict[str, Any]]:
    """Describe each plant: its measures before and after, its outcome and the reason for it.

    Args:
        found: the plants of a figure; a plant's id is its index.
        before, after: the measures of each, in the same order.
    """
    return [_plant(plant, before[plant.id], after[plant.id]) for plant in found]


def _plant(plant: Footplant, was: PlantMeasure, now: PlantMeasure) -> dict[str, Any]:
    return {
        "id": plant.id,
        "effector": plant.name,
        "start": plant.start,
        "end": plant.end,
        "held": [[start, end] for start, end in plant.held],
        "confidence": rounded(plant.confidence),
        "slide_before_mm": rounded(was.slide_mm),
        "slide_after_mm": rounded(now.slide_mm),
        "tip_slide_before_mm": None if was.tip_slide_mm is None else rounded(was.tip_slide_mm),
        "tip_slide_after_mm": None if now.tip_slide_mm is None else rounded(now.tip_slide_mm),
        "sole_slide_before_mm": rounded(was.sole_slide_mm),
        "sole_slide_after_mm": rounded(now.sole_slide_mm),
        "travel_before_mm": rounded(was.travel_mm),
        "travel_after_mm": rounded(now.travel_mm),
        "yaw_before_deg": rounded(was.yaw_deg),
        "yaw_after_deg": rounded(now.yaw_deg),
        "penetration_before_mm": rounded(was.penetration_mm),
        "penetration_after_mm": rounded(now.penetration_mm),
        "float_before_mm": rounded(was.float_mm),
        "float_after_mm": rounded(now.float_mm),
        "residual_mm": rounded(1000.0 * plant.residual),
        "target_m": [rounded(x) for x in plant.target],
        "outcome": plant.outcome,
        "reason": plant.reason or _doubt(plant, now),
    }


def _doubt(plant: Footplant, now: PlantMeasure) -> str:
    """Explain a large number on a plant that is pinned; "" where there is none."""
    if plant.outcome != "pinned":
        return ""
    if now.slide_mm > NOTICED_MM:  # the sole point is pinned, but the slide is that of a joint above it
        seen = "ankle" if plant.part == "heel" else "toe joint"
        return f"the {plant.part} of the sole is held, the {seen} over it moves"
    return "off its place only while it lands or leaves" if 1000.0 * plant.residual > NOTICED_MM else ""


NO_CORRECTION: Mapping[str, Any] = {
    "root_path_drift_m": 0.0,
    "max_root_shift_mm": 0.0,
    "max_joint_rotation_deg": 0.0,
    "largest_change_joint": None,
    "largest_change_deg": 0.0,
    "largest_change_frame": None,
}


def corrections(found: Sequence[Correction], clip: Clip) -> dict[str, Any]:
    """Describe how much was changed: the largest change of all figures, and where.

    Args:
        found: the correction of each figure.
        clip: the captured clip.
    """
    entries = [_correction(each, clip) for each in found]
    most = max(entries, key=lambda each: float(each["largest_change_deg"]))
    numbers = ("root_path_drift_m", "max_root_shift_mm", "max_joint_rotation_deg")
    return {**most, **{key: max(each[key] for each in entries) for key in numbers}}


def _correction(found: Correction, clip: Clip) -> dict[str, Any]:
    """Find the root's drift at the end, its largest shift, and the largest turn of a joint in its parent's frame."""
    shift = found.root_shift  # (F, 3) [m]
    drift = shift[-1, [0, 2]] - shift[0, [0, 2]] if len(shift) else np.zeros(2)
    largest, name, frame = 0.0, None, None
    for k, joint in enumerate(found.joints):
        new, old = found.rotations[:, k], clip.rotation(joint)  # (F, 4)
        changed = np.flatnonzero(np.any(new != old, axis=1))
        if len(changed):
            turns = rotation.apart(old[changed], new[changed])  # [rad]
            at = int(np.argmax(turns))
            if turns[at] > largest:
                largest, name, frame = float(turns[at]), clip.skeleton.names[joint], int(changed[at])
    degrees = rounded(float(np.degrees(largest)))
    return {
        "root_path_drift_m": rounded(float(np.hypot(*drift))),
        "max_root_shift_mm": rounded(1000.0 * float(np.linalg.norm(shift, axis=1).max(initial=0.0))),
        "max_joint_rotation_deg": degrees,
        "largest_change_joint": name,
        "largest_change_deg": degrees,
        "largest_change_frame": frame,
    }


def worst(entries: Sequence[Mapping[str, float | None]]) -> dict[str, float | None]:
    """Join the measures of several figures: the largest value of each measure, and the sum of the plants.

    A measure that one figure lacks (since it is on a belt) is that of the others.
    """
    first, *others = entries
    if not others:
        return dict(first)
    counts = ("plants", "plants_over_21mm")
    numbers = {key: [value for entry in entries if (value := entry[key]) is not None] for key in first}
    return {key: (sum if key in counts else max)(values) if values else None for key, values in numbers.items()}


def frame(source: Mapping[str, Any], version: str, *, status: str, output: str | None) -> dict[str, Any]:
    """Make the entries that every report begins with."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "footfix": version,
        "source": dict(source),
        "output": output,
        "status": status,
    }

"""The report of a clip as data: the contract's report file, version 1."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant
from footfix.measure.clip import Measures
from footfix.measure.plants import PlantMeasure
from footfix.motion import rotation
from footfix.motion.clip import Clip
from footfix.notes import Note
from footfix.rig.rig import Rig

FORMAT, VERSION = "footfix-report", 1


def rounded(value: float) -> float:
    """A number with the digits that mean something: six, and no negative zero."""
    return float(f"{value:.6g}") + 0.0


def measures(found: Measures) -> dict[str, float]:
    """Measures as plain numbers; each key carries its unit."""
    return {key: each if isinstance(each, int) else rounded(each) for key, each in dataclasses.asdict(found).items()}


def note(each: Note) -> dict[str, Any]:
    """A note with what it has to say, and no empty fields."""
    plain: dict[str, Any] = {"id": each.id, "severity": each.severity, "text": each.text}
    for key in ("line", "column", "start", "end"):
        if getattr(each, key) is not None:
            plain[key] = getattr(each, key)
    if each.joints:
        plain["joints"] = list(each.joints)
    return plain


def notes(found: Iterable[Note]) -> list[dict[str, Any]]:
    """Notes in the order in which they arose, each once."""
    return [note(each) for each in dict.fromkeys(found)]


def rig(found: Rig, clip: Clip, *, unit_m: float, up: str) -> dict[str, Any]:
    """The rig by joint names, with where each guess came from."""
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
    """One row a plant: what it did, what was done, what it does now."""
    was = {(each.effector, each.start): each for each in before}
    now = {(each.effector, each.start): each for each in after}
    rows = []
    for plant in found:
        key = (plant.effector, plant.start)
        if key not in was:
            continue
        rows.append(
            {
                "effector": plant.effector,
                "start": plant.start,
                "end": plant.end,
                "confidence": rounded(plant.confidence),
                "slide_before_mm": rounded(was[key].slide_mm),
                "slide_after_mm": rounded(now[key].slide_mm),
                "yaw_before_deg": rounded(was[key].yaw_deg),
                "yaw_after_deg": rounded(now[key].yaw_deg),
                "penetration_before_mm": rounded(was[key].penetration_mm),
                "penetration_after_mm": rounded(now[key].penetration_mm),
                "residual_mm": rounded(1000.0 * plant.residual),
                "target_m": [rounded(x) for x in plant.target],
                "outcome": plant.outcome,
                "reason": plant.reason,
            }
        )
    return rows


def correction(found: Correction, clip: Clip) -> dict[str, float]:
    """How much was changed: the root's drift at the end, its largest shift, the largest turn of a joint."""
    shift = found.root_shift  # (F, 3) [m]
    drift = shift[-1, [0, 2]] - shift[0, [0, 2]] if len(shift) else np.zeros(2)
    turned = 0.0
    for k, joint in enumerate(found.joints):
        new, old = found.rotations[:, k], clip.rotations[:, joint]
        changed = np.any(new != old, axis=1)
        if np.any(changed):
            turn = rotation.multiply(rotation.inverse(old[changed]), new[changed])
            turned = max(turned, float(rotation.angle(turn).max()))
    return {
        "root_path_drift_m": rounded(float(np.hypot(*drift))),
        "max_root_shift_mm": rounded(1000.0 * float(np.linalg.norm(shift, axis=1).max(initial=0.0))),
        "max_joint_rotation_deg": rounded(float(np.degrees(turned))),
    }


def worst(entries: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """One entry for several figures: the largest of each figure's numbers, plants counted together."""
    first, *others = entries
    if not others:
        return dict(first)
    counts = ("plants", "plants_over_21mm")
    return {key: (sum if key in counts else max)(entry[key] for entry in entries) for key in first}


def frame(source: Mapping[str, Any], version: str, *, status: str, output: str | None) -> dict[str, Any]:
    """What every report begins with."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "footfix": version,
        "source": dict(source),
        "output": output,
        "status": status,
    }

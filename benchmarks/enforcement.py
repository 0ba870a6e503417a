"""What enforcement does to a folder of clips, measured on the file that is written.

    python benchmarks/enforcement.py FOLDER [--method ik|root|both] [--worst 10]

One line a clip, then the whole: plants that slide farther than 21 mm before and after, mean and worst speed of
planted points, penetration, the largest jump that the correction puts between two frames (degrees of a leg joint,
scaled to 120 fps), jitter of all joints against the input's, and what became of the plants.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from footfix import api
from footfix.detect.run import detect
from footfix.enforce.correction import apply
from footfix.enforce.footplant import Footplant
from footfix.enforce.run import EnforceParams, enforce
from footfix.errors import FootfixError
from footfix.formats.bvh import decode, encode
from footfix.measure.clip import Measures, measure
from footfix.measure.plants import PlantMeasure
from footfix.motion import rotation
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contacts
from footfix.motion.leadin import motion_proper
from footfix.rig.rig import Rig
from footfix.settings import Settings


@dataclass(frozen=True)
class Row:
    """One clip, before and after."""

    name: str
    before: Measures
    after: Measures
    held: tuple[PlantMeasure, ...]  # after, of the plants that were not released
    plants: tuple[Footplant, ...]
    jump: float  # [deg per 1/120 s]
    moved: float  # [mm] by which a second run moves anything
    root: float  # [mm]
    milliseconds: float
    frames: int
    changed: bool


def jump(before: Clip, after: Clip, rig: Rig) -> float:
    """By how much a leg joint turns farther between two frames than it did thereabouts before [deg per 1/120 s]."""
    proper = motion_proper(before)
    before, after = before.frames(proper), after.frames(proper)
    worst = 0.0
    for joint in {j for leg in rig.legs for j in (*leg.chain, leg.toe) if j is not None}:
        old, new = (
            rotation.angle(rotation.multiply(q[1:], rotation.inverse(q[:-1])))
            for q in (before.rotations[:, joint], after.rotations[:, joint])
        )
        around = np.maximum(old, np.maximum(np.append(old[1:], 0.0), np.append(0.0, old[:-1])))
        worst = max(worst, float((new - around).max(initial=0.0)))
    return float(np.degrees(worst) / (120.0 * before.frame_time))


def run(path: Path, params: EnforceParams) -> Row:
    """Cleans a clip as the tool does, reads what would be written, and measures that."""
    document = api.load(path)
    clip = document.clip
    rig = api.find_rig(clip)
    contacts = detect(clip, rig, Settings().detect)
    start = time.perf_counter()
    found = enforce(clip, rig, contacts, params)
    corrected = apply(clip, found.correction)
    spent = time.perf_counter() - start
    written = decode(encode(document, corrected)).placed(unit_m=document.unit_m, up=document.up).clip
    return _row(path.name, clip, written, rig, found.contacts, found.plants, params, spent, corrected is not clip)


def _row(
    name: str, clip: Clip, written: Clip, rig: Rig, contacts: Contacts, plants: tuple[Footplant, ...],
    params: EnforceParams, spent: float, changed: bool,
) -> Row:  # fmt: skip
    levels = tuple(
        np.array([plant.target[1] for plant in plants if plant.effector == effector.name])
        for effector in contacts.effectors
    )
    before, _ = measure(clip, rig, contacts, levels=levels)
    after, measured = measure(written, rig, contacts, levels=levels)
    outcomes = [plant.outcome for name in contacts.names for plant in plants if plant.effector == name]
    again = enforce(written, rig, contacts, params)
    twice = apply(written, again.correction)
    once, then = rig.tracks(rig.pose(written)), rig.tracks(rig.pose(twice))
    moved = max((float(np.abs(a - b).max()) for a, b in zip(once, then, strict=True)), default=0.0)
    shift = written.positions[:, rig.root] - clip.positions[:, rig.root]
    return Row(
        name, before, after,
        tuple(m for m, outcome in zip(measured, outcomes, strict=True) if outcome != "released"), plants,
        jump(clip, written, rig), 1000.0 * moved, 1000.0 * float(np.linalg.norm(shift, axis=1).max()),
        1000.0 * spent, len(clip), changed,
    )  # fmt: skip


HEAD = (
    f"{'clip':34} {'plants':>6} {'>21mm':>9} {'cm/s':>11} {'worst cm/s':>13} {'slide mm':>13} {'yaw deg':>11} "
    f"{'pen mm':>11} {'jump':>5} {'jitter':>6} {'again':>5} {'root':>5} {'ms':>5}  outcomes"
)


def line(row: Row) -> str:
    """One clip as a line of the table."""
    b, a = row.before, row.after
    slid = sum(m.slide_mm > 21.0 for m in row.held)
    worst = max((m.peak_speed_cm_s for m in row.held), default=0.0)
    slide = max((m.slide_mm for m in row.held), default=0.0)
    yaw = max((m.yaw_deg for m in row.held), default=0.0)
    deep = max((m.penetration_mm for m in row.held), default=0.0)
    counts = Counter(plant.outcome for plant in row.plants)
    outcomes = " ".join(f"{key}:{counts[key]}" for key in ("pinned", "kept", "partly", "released") if counts[key])
    return (
        f"{row.name[:34]:34} {b.plants:6d} {b.plants_over_21mm:4d}>{slid:<4d} {b.skate_cm_s:5.2f}>{speed(row):<5.2f} "
        f"{b.skate_worst_cm_s:6.1f}>{worst:<6.2f} {b.slide_mm:6.1f}>{slide:<6.2f} {b.yaw_deg:5.1f}>{yaw:<5.1f} "
        f"{b.penetration_mm:5.1f}>{deep:<5.2f} {row.jump:5.2f} "
        f"{a.jitter_100m_s3 / max(b.jitter_100m_s3, 1e-9):6.3f} "
        f"{row.moved:5.2f} {row.root:5.0f} {row.milliseconds:5.0f}  {outcomes}"
    )


def speed(row: Row) -> float:
    """Mean speed of the plants that were not released [cm/s]."""
    weights = [max(m.end - m.start - 1, 0) for m in row.held]
    return float(np.average([m.speed_cm_s for m in row.held], weights=weights)) if sum(weights) else 0.0


def summary(rows: Sequence[Row]) -> list[str]:
    """The figures over all clips."""
    plants = sum(row.before.plants for row in rows)
    counts = Counter(plant.outcome for row in rows for plant in row.plants)
    held = [m for row in rows for m in row.held]
    worst = [max((m.peak_speed_cm_s for m in row.held), default=0.0) for row in rows]
    ratio = [row.after.jitter_100m_s3 / max(row.before.jitter_100m_s3, 1e-9) for row in rows]
    return [
        f"{len(rows)} clips, {plants} plants: " + ", ".join(f"{n} {key}" for key, n in counts.most_common()),
        f"sliding over 21 mm: {sum(row.before.plants_over_21mm for row in rows)} before, "
        f"{sum(m.slide_mm > 21.0 for m in held)} of the held after",
        f"mean speed in plants: median of clips {np.median([speed(row) for row in rows]):.3f}, "
        f"worst {max(speed(row) for row in rows):.3f} cm/s",
        f"worst frame: 90 % of clips within {np.percentile(worst, 90):.2f}, worst {max(worst):.2f} cm/s; "
        f"clips over 1 cm/s: {sum(w > 1.0 for w in worst)}",
        f"jump introduced: median {np.median([row.jump for row in rows]):.2f}, "
        f"90 % within {np.percentile([row.jump for row in rows], 90):.2f} deg; "
        f"clips over 2: {sum(row.jump > 2.0 for row in rows)}",
        f"jitter against the input's: {min(ratio):.3f} to {max(ratio):.3f}; "
        f"clips beyond 5 %: {sum(abs(r - 1.0) > 0.05 for r in ratio)}",
        f"a second run moves: 90 % within {np.percentile([row.moved for row in rows], 90):.2f}, "
        f"worst {max(row.moved for row in rows):.2f} mm",
    ]


def main(argv: Sequence[str] | None = None) -> int:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="+", type=Path)
    parser.add_argument("--method", choices=("ik", "root", "both"), default="ik")
    parser.add_argument("--released", action="store_true", help="list the released plants with their reasons")
    options = parser.parse_args(argv)
    files = sorted(
        file for path in options.paths
        for file in (path.rglob("*") if path.is_dir() else [path]) if file.suffix.lower() == ".bvh"
    )  # fmt: skip
    params = EnforceParams(method=options.method)
    rows = []
    print(HEAD)
    for file in files:
        try:
            rows.append(run(file, params))
        except FootfixError as error:
            print(f"{file.name[:34]:34} {error}")
            continue
        print(line(rows[-1]), flush=True)
        if options.released:
            for plant in rows[-1].plants:
                if plant.outcome == "released":
                    print(f"    released {plant.effector} [{plant.start}, {plant.end}): {plant.reason}")
    if rows:
        print("\n".join(["", *summary(rows)]))
    return 0 if rows else 3


if __name__ == "__main__":
    sys.exit(main())

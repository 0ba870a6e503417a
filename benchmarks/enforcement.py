"""What enforcement does to a folder of clips, measured on the file that is written.

    python benchmarks/enforcement.py FOLDER... [--method ik|root|both] [--released]
    python benchmarks/enforcement.py --walkers [--method ik|root|both]

One line a clip, then the whole: plants that slide farther than 21 mm before and after, mean and worst speed of
planted points, penetration, the largest jump that the correction puts between two frames (degrees of a leg joint,
scaled to 120 fps), jitter of all joints against the input's, and what became of the plants.

With `--walkers`: walkers in several gaits whose contacts are exactly known, with artefacts put in; the true contacts
are handed in, the rig is found, and what is measured are the walker's own sole points.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "sample_data"))

import artefacts
from walker import make
from walker_gaits import Gait, Name

from footfix import api
from footfix.enforce.params import EnforceParams
from footfix.errors import FootfixError
from footfix.formats.bvh import compose
from footfix.formats.document import open_document, rewrite
from footfix.measure.clip import Measures, peak_acceleration
from footfix.measure.plants import PlantMeasure
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import forward
from footfix.motion.lead_in import motion_range
from footfix.pipeline import correct, find_contacts, measure_figures, prepare
from footfix.rig.rig import Rig
from footfix.settings import Settings


@dataclass(frozen=True)
class Row:
    """One clip, before and after."""

    name: str
    before: Measures
    after: Measures
    held: tuple[PlantMeasure, ...]  # after, of the plants that were not released
    outcomes: tuple[str, ...]
    jump: float  # [deg per 1/120 s]
    moved: float  # [mm] by which a second run moves anything
    root: float  # [mm]
    milliseconds: float
    frames: int
    in_place: bool  # planted feet ride on a belt: their speed over the floor is none of ours
    released: tuple[str, ...]  # the plants that were let go, with their reasons


def jump(before: Clip, after: Clip, rig: Rig) -> float:
    """By how much a leg joint turns farther between two frames than it did thereabouts before [deg per 1/120 s]."""
    frame_range = motion_range(before)
    before, after = before.frames(frame_range), after.frames(frame_range)
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
    settings = Settings(enforce=params)
    document = api.load(path)
    clip = document.clip
    frame_range = motion_range(clip)
    prepared = prepare(clip, settings, (api.find_rig(clip),), frame_range)
    contacts = find_contacts(prepared, settings)
    start = time.perf_counter()
    corrected, figures = correct(prepared, contacts, settings)
    spent = time.perf_counter() - start
    written = rewrite(document, corrected)[1]
    (result,) = measure_figures(clip, written, figures)
    rig = result.rig
    twice = api.clean(written, settings, rig=rig, contacts=contacts).clip
    once, then = rig.tracks(rig.pose(written)), rig.tracks(rig.pose(twice))
    moved = max((float(np.abs(a - b).max()) for a, b in zip(once, then, strict=True)), default=0.0)
    shift = written.positions[:, rig.root] - clip.positions[:, rig.root]
    held = tuple(result.plants_after[plant.id] for plant in result.plants if plant.outcome != "released")
    return Row(
        path.name, result.before, result.after, held, tuple(plant.outcome for plant in result.plants),
        jump(clip, written, rig), 1000.0 * moved, 1000.0 * float(np.linalg.norm(shift, axis=1).max()),
        1000.0 * spent, len(clip), any(note.id == "in-place" for note in result.notes),
        tuple(f"{p.name} [{p.start}, {p.end}): {p.reason}" for p in result.plants if p.outcome == "released"),
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
    counts = Counter(row.outcomes)
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
    counts = Counter(outcome for row in rows for outcome in row.outcomes)
    still = [row for row in rows if not row.in_place]
    held = [m for row in still for m in row.held]
    worst = [max((m.peak_speed_cm_s for m in row.held), default=0.0) for row in still]
    ratio = [row.after.jitter_100m_s3 / max(row.before.jitter_100m_s3, 1e-9) for row in rows]
    return [
        f"{len(rows)} clips, {plants} plants: " + ", ".join(f"{n} {key}" for key, n in counts.most_common()),
        f"sliding over 21 mm: {sum(row.before.plants_over_21mm for row in rows)} before, "
        f"{sum(m.slide_mm > 21.0 for m in held)} of the held after",
        f"mean speed in plants: median of clips {np.median([speed(row) for row in still]):.3f}, "
        f"worst {max(speed(row) for row in still):.3f} cm/s; {len(rows) - len(still)} in place left out",
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


GAITS: tuple[Name, ...] = ("walk", "run", "turn", "backwards")
ARTEFACTS: dict[str, Callable[[Clip], Clip]] = {
    "drift 5 cm": lambda clip: artefacts.drift(clip, 0.05),
    "wander 5 cm": lambda clip: artefacts.wander(clip, 0.05, slowest=1.0),
    "path x 0.9": lambda clip: artefacts.scale_root(clip, 0.9, height=False),
    "path x 1.1": lambda clip: artefacts.scale_root(clip, 1.1, height=False),
    "root x 0.9": lambda clip: artefacts.scale_root(clip, 0.9),
    "root x 1.1": lambda clip: artefacts.scale_root(clip, 1.1),
    "sunk 3 cm": lambda clip: artefacts.sink(clip, 0.03),
    "floating 3 cm": lambda clip: artefacts.sink(clip, -0.03),
    "joints 0.5 deg": lambda clip: artefacts.shake(clip, 0.5, slowest=0.3),
    "joints 0.2 deg, every frame": lambda clip: artefacts.shake(clip, 0.2),
}


@dataclass(frozen=True)
class WalkerRow:
    """One walker with one artefact, cleaned; lengths in mm."""

    toe: tuple[float, ...]
    heel: tuple[float, ...]
    alone: tuple[float, ...]  # toes, in single support
    heights: tuple[float, ...]
    deep: float
    acceleration: float  # against the clean walker's
    extension: float


def farthest(places: Floats) -> float:
    """[m] of a track (n, 3) from its median place over the floor."""
    return float(np.linalg.norm((places - np.median(places, axis=0))[:, [0, 2]], axis=1).max())


def walker(gait: Name, artefact: str, params: EnforceParams) -> WalkerRow:
    """A walker made, spoilt, written, read, cleaned, written, read and measured."""
    made = make(Gait(name=gait, fps=120.0))
    document = open_document(compose(ARTEFACTS[artefact](made.clip), unit_m=0.01)).placed(unit_m=0.01, up="y")
    clip = document.clip
    rig = api.find_rig(clip)
    found = api.clean(clip, Settings(enforce=params), rig=rig, contacts=replace(made.contacts, method="labels"))
    after = rewrite(document, found.clip)[1]
    pose = forward(after)
    tracks = [pose.point(clip.skeleton.names.index(joint), np.array(offset)) for joint, offset in made.soles]
    mask = made.contacts.mask()
    slides: dict[str, list[float]] = {"toe": [], "heel": [], "alone": []}
    heights: list[float] = []
    for e, (track, effector) in enumerate(zip(tracks, made.contacts.effectors, strict=True)):
        other = np.asarray(mask[:, [k for k in range(4) if k // 2 != e // 2]].any(axis=1))
        for contact in effector.contacts:
            place = track[contact.start : contact.end]
            slides[effector.part].append(1000.0 * farthest(place))
            heights.extend(1000.0 * np.abs(place[:, 1] - rig.floor))
            single = place[~other[contact.start : contact.end]]
            if effector.part == "toe" and len(single) > 2:
                slides["alone"].append(1000.0 * farthest(single))
    deep = max(1000.0 * (rig.floor - float(track[:, 1].min())) for track in tracks)
    clean = peak_acceleration(rig, rig.pose(made.clip), made.clip.frame_time)
    straight = 0.0
    for leg in rig.legs:
        hip, knee, ankle = (pose.position(joint) for joint in (leg.hip, leg.knee, leg.ankle))
        length = np.linalg.norm(knee - hip, axis=1) + np.linalg.norm(ankle - knee, axis=1)
        straight = max(straight, float((np.linalg.norm(ankle - hip, axis=1) / length).max()))
    return WalkerRow(
        tuple(slides["toe"]), tuple(slides["heel"]), tuple(slides["alone"]), tuple(heights), deep,
        peak_acceleration(rig, rig.pose(after), after.frame_time) / clean, straight,
    )  # fmt: skip


def walkers(params: EnforceParams) -> None:
    """Prints the table of walkers."""
    rows = []
    print(f"{'gait':10} {'artefact':28} toe p95  heel p95  worst  alone p90  height p95  deepest  accel  extension")
    for gait in GAITS:
        for artefact in ARTEFACTS:
            row = walker(gait, artefact, params)
            rows.append(row)
            print(f"{gait:10} {artefact:28} {_figures([row])}", flush=True)
    print(f"{'all':10} {'':28} {_figures(rows)}")
    most = np.percentile([row.acceleration for row in rows], 90)
    print(f"peak acceleration against the clean walker's, 90th percentile of clips: {most:.2f}")


def _figures(rows: Sequence[WalkerRow]) -> str:
    toes, heels = [v for row in rows for v in row.toe], [v for row in rows for v in row.heel]
    alone, heights = [v for row in rows for v in row.alone], [v for row in rows for v in row.heights]
    return (
        f"{np.percentile(toes, 95):7.2f} {np.percentile(heels, 95):9.2f} {max(toes + heels):6.2f} "
        f"{np.percentile(alone, 90):10.2f} {np.percentile(heights, 95):11.2f} {max(row.deep for row in rows):8.2f} "
        f"{max(row.acceleration for row in rows):6.2f} {max(row.extension for row in rows):10.4f}"
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="*", type=Path)
    parser.add_argument("--walkers", action="store_true", help="walkers with known contacts in place of files")
    parser.add_argument("--method", choices=("ik", "root", "both"), default="ik")
    parser.add_argument("--released", action="store_true", help="list the released plants with their reasons")
    options = parser.parse_args(argv)
    params = EnforceParams(method=options.method)
    if options.walkers:
        walkers(params)
        return 0
    files = sorted(
        file for path in options.paths
        for file in (path.rglob("*") if path.is_dir() else [path]) if file.suffix.lower() == ".bvh"
    )  # fmt: skip
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
            print("".join(f"    released {each}\n" for each in rows[-1].released), end="")
    if rows:
        print("\n".join(["", *summary(rows)]))
    return 0 if rows else 3


if __name__ == "__main__":
    sys.exit(main())

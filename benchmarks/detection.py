"""How well contacts are found: all detectors and the common baselines, against contacts that are known.

    python benchmarks/detection.py [TRUTH] [--confidence]
    python benchmarks/detection.py --walkers

TRUTH is a folder of clips with a `NAME.truth.json` each, from force plates; these know feet, not heels and toes,
and only some frames. Without it the walkers in sample_data are judged, whose heels and toes are all known.
Printed are frame F1 per kind of motion, the errors of strikes and offs in ms (median / 90th percentile of what
was found within 0.15 s; of grade A plates, and of runners, whose plates came filtered), and with --confidence
whether contacts are as often right as they say.
With --walkers the default detector is judged on walkers of every gait, as made and with what captures suffer.
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from baselines import BASELINES

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "sample_data"))

import artefacts
import walker
import walker_plan

from footfix.detect.run import METHODS, DetectParams, Method, find
from footfix.detect.tracks import Finding, Tracks, tracks_of
from footfix.formats.bvh import decode
from footfix.measure import agreement
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.contacts import runs
from footfix.rig.find import find_rig
from footfix.rig.units import infer_units

SAMPLES = Path(__file__).resolve().parent.parent / "sample_data"
SIDES = ("left", "right")
Detector = Callable[[Tracks], Finding]


@dataclass(frozen=True, eq=False)
class Known:
    """What plates know of one clip.

    Args:
        kind: of motion.
        known, contact: (F, 2) by foot.
        strikes, offs: [s] by foot, of grade A plates, and of runners, whose plates came filtered.
    """

    kind: str
    known: Bools
    contact: Bools
    strikes: tuple[Floats, Floats]
    offs: tuple[Floats, Floats]


@dataclass
class Table:
    """Scores by kind of motion."""

    frames: dict[str, agreement.Frames] = field(default_factory=lambda: defaultdict(agreement.Frames))
    strikes: dict[str, list[agreement.Events]] = field(default_factory=lambda: defaultdict(list))
    offs: dict[str, list[agreement.Events]] = field(default_factory=lambda: defaultdict(list))
    said: list[float] = field(default_factory=list)
    right: list[bool] = field(default_factory=list)

    def add(self, truth: Known, finding: Finding, frame_time: float) -> None:
        """Scores the contacts of one clip."""
        feet = agreement.feet(finding.mask)
        for k in range(2):
            found, known, contact = feet[:, k], truth.known[:, k], truth.contact[:, k]
            counted = agreement.frames(found, contact, known=known)
            self.frames[truth.kind] += counted
            if not truth.kind.startswith("standing") and "as fast" not in truth.kind:
                self.frames["all gait and jump"] += counted
            strikes, offs = agreement.edges(found, frame_time)
            self.strikes[truth.kind].append(agreement.events(strikes, truth.strikes[k]))
            self.offs[truth.kind].append(agreement.events(offs, truth.offs[k]))
            if finding.confidence is not None:
                sure = np.maximum(finding.confidence[:, 2 * k], finding.confidence[:, 2 * k + 1])
                self._calibrate(found, known, contact, sure, frame_time)

    def _calibrate(self, found: Bools, known: Bools, contact: Bools, sure: Floats, frame_time: float) -> None:
        """A contact is right when nowhere within 50 ms of it, or in it, known frames disagree for over 50 ms."""
        slack = round(0.05 / frame_time)
        for a, b in runs(found):
            near = slice(max(a - slack, 0), b + slack)
            if np.count_nonzero(known[a:b]) > 0.5 * (b - a):
                wrong = known[near] & (found[near] != contact[near])
                self.said.append(float(sure[a:b].mean()))
                self.right.append(all(stop - start <= slack for start, stop in runs(wrong)))

    def rows(self) -> Iterator[str]:
        """One line for each kind."""
        for kind in sorted(self.frames):
            strikes = agreement.together(self.strikes.get(kind, []))
            offs = agreement.together(self.offs.get(kind, []))
            yield f"{kind:44} {self.frames[kind].f1:.4f}  {_ms(strikes):>24}  {_ms(offs):>24}"


def _ms(events: agreement.Events) -> str:
    if not len(events.errors):
        return "-"
    errors = f"{1e3 * events.median:.1f} / {1e3 * events.quantile(0.9):.1f}"
    return f"{errors} ({len(events.errors)}, {events.missed} missed)"


def read_clip(path: Path) -> Clip:
    """A BVH file in metres, y up."""
    document = decode(path.read_bytes())
    seen = infer_units(document.clip)
    return document.placed(unit_m=seen.unit_m, up=seen.up).clip


def truths(folder: Path) -> Iterator[tuple[str, str, Known, Tracks]]:
    """The clips of a truth folder: name, subject, what is known, tracks by our own rig."""
    kinds = {}
    if (folder / "manifest.csv").exists():
        with (folder / "manifest.csv").open(newline="", encoding="utf-8") as rows:
            kinds = {row["trial"]: row["category"] for row in csv.DictReader(rows)}
    for path in sorted(folder.glob("*.bvh")):
        truth = json.loads(path.with_suffix(".truth.json").read_text(encoding="utf-8"))
        clip = read_clip(path)
        kind = kinds.get(path.stem, truth["activity"])
        yield path.stem, truth["subject"], known_of(truth, kind), tracks_of(clip, find_rig(clip))


def quicker(truth: Known, tracks: Tracks, factor: float) -> tuple[Known, Tracks]:
    """A clip played so many times as fast: of a run, what comes nearest to a sprint where none was recorded."""
    strikes, offs = ((left / factor, right / factor) for left, right in (truth.strikes, truth.offs))
    kind = f"{truth.kind}, {factor:g} x as fast"
    return replace(truth, kind=kind, strikes=strikes, offs=offs), replace(tracks, frame_time=tracks.frame_time / factor)


def known_of(truth: dict[str, Any], kind: str) -> Known:
    """A truth file as arrays."""

    def mask(key: str) -> Bools:
        out = np.zeros((truth["frames"], 2), dtype=np.bool_)
        for k, side in enumerate(SIDES):
            for a, b in truth[side][key]:
                out[a:b, k] = True
        return out

    graded = truth["grade"] == "A" or kind.startswith("run")

    def times(key: str) -> tuple[Floats, Floats]:
        left, right = (np.array(truth[side][key] if graded else [], dtype=np.float64) for side in SIDES)
        return left, right

    return Known(kind, mask("known"), mask("contact"), times("strike_s"), times("off_s"))


def detectors() -> dict[str, Detector]:
    """All of them by name."""
    ours: dict[str, Detector] = {str(method): partial(_by_method, method) for method in METHODS}
    theirs: dict[str, Detector] = {name: partial(_by_rule, rule) for name, rule in BASELINES.items()}
    return {**ours, **theirs}


def _by_method(method: Method, tracks: Tracks) -> Finding:
    return find(tracks, DetectParams(method=method))


def _by_rule(rule: Callable[[Tracks], Bools], tracks: Tracks) -> Finding:
    return Finding(rule(tracks))


def against_plates(folder: Path) -> dict[str, Table]:
    """A table for each detector."""
    tables: dict[str, Table] = defaultdict(Table)
    for _, _, truth, tracks in truths(folder):
        for name, detector in detectors().items():
            tables[name].add(truth, detector(tracks), tracks.frame_time)
    return tables


def against_samples() -> Iterator[str]:
    """One line for each detector: F1 of each sample's heels and toes, within 30 ms."""
    files = sorted(SAMPLES.glob("*.bvh"))
    yield f"{'':16}" + "".join(f"{path.stem:>14}" for path in files)
    for name, detector in detectors().items():
        cells = []
        for path in files:
            known = json.loads((SAMPLES / "truth" / f"{path.stem}.contacts.json").read_text(encoding="utf-8"))
            clip = read_clip(path)
            mask = detector(tracks_of(clip, find_rig(clip))).mask
            slack = int(0.03 * clip.fps)
            parts = []
            for k, effector in enumerate(known["effectors"]):
                true = np.zeros(len(clip), dtype=np.bool_)
                for contact in effector["contacts"]:
                    true[contact["start"] : contact["end"]] = True
                parts.append(agreement.frames(mask[:, k], true, tolerance=slack).f1)
            cells.append(f"{np.mean(parts):>14.3f}")
        yield f"{name:16}" + "".join(cells)


def _all_of_it(clip: Clip) -> Clip:
    return artefacts.shake(artefacts.drift(artefacts.scale_root(clip, 0.85), 0.05), 0.4)


FAULTS: dict[str, Callable[[Clip], Clip]] = {
    "as made": lambda clip: clip,
    "root x 0.85": lambda clip: artefacts.scale_root(clip, 0.85),
    "root x 1.15": lambda clip: artefacts.scale_root(clip, 1.15),
    "5 cm drift": lambda clip: artefacts.drift(clip, 0.05),
    "0.4 deg noise": lambda clip: artefacts.shake(clip, 0.4),
    "all of it": _all_of_it,
}


def against_walkers() -> Iterator[str]:
    """One line for each gait: mean F1 of heels and toes, within 30 ms, by fault."""
    yield f"{'':16}" + "".join(f"{fault:>15}" for fault in FAULTS)
    for gait in sorted(walker_plan.STYLES):
        cells = []
        for change in FAULTS.values():
            parts = []
            for fps in (30.0, 60.0, 120.0):
                walk = walker.make(walker_plan.Gait(name=gait, fps=fps, seed=1))  # type: ignore[arg-type]
                clip, true = change(walk.clip), walk.contacts.mask()
                mask = find(tracks_of(clip, find_rig(clip)), DetectParams()).mask
                slack = round(0.03 * fps)
                parts += [agreement.frames(mask[:, k], true[:, k], tolerance=slack).f1 for k in range(4)]
            cells.append(f"{np.mean(parts):>15.3f}")
        yield f"{gait:16}" + "".join(cells)


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("truth", nargs="?", type=Path, help="folder of clips with plates")
    parser.add_argument("--confidence", action="store_true", help="are contacts right as often as they say")
    parser.add_argument("--walkers", action="store_true", help="walkers of every gait, with faults")
    asked = parser.parse_args()
    if asked.walkers:
        print("\n".join(against_walkers()))
        return
    if asked.truth is None:
        print("mean F1 of heels and toes, within 30 ms of the walkers' known contacts")
        print("\n".join(against_samples()))
        return
    for name, table in against_plates(asked.truth).items():
        print(f"\n{name:44} F1      strike ms                 off ms")
        print("\n".join(table.rows()))
        if asked.confidence and table.said:
            print("confidence: said, right, contacts")
            for said, right, count in agreement.calibration(np.array(table.said), np.array(table.right)):
                print(f"  {said:.3f}  {right:.3f}  {count}")


if __name__ == "__main__":
    main()

"""Fits the default detector, and says how well it does on people it has not seen.

    python benchmarks/fit_auto.py TRUTH [--cross] [--write]

TRUTH is a folder of clips with a `NAME.truth.json` each (contacts that force plates measured). With --cross the
takes are split by subject into five parts, each judged by what was fitted to the other four; with --write what
was fitted to all of them is written to footfix/detect/weights.txt. Both need some minutes. The result is the
same on every run: all chance comes from fixed seeds.
"""

from __future__ import annotations

import argparse
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from detection import Table, quicker, truths
from fit_network import Batch, FitParams, Moments, fit_by_committee, rounded, table
from fit_takes import Take, made, recorded
from fit_timing import Moments as Events
from fit_timing import fit_timing, moments
from fit_variants import variant

from footfix.detect.auto import AutoParams, auto
from footfix.detect.network import Network
from footfix.detect.timing import Timing

FOLDS = 5
QUICKER = 1.7  # how much faster runs are judged once more: as fast as sprints, 0.12 to 0.18 s a stance
VARIANTS = 8  # of each recorded take; the first is as recorded, and one in six is without toe joints
WALKERS, WALKER_VARIANTS, WALKER_WEIGHT = 300, 2, 0.25
FITTED = Path(__file__).resolve().parent.parent / "footfix" / "detect" / "weights.txt"


@dataclass(frozen=True, eq=False)
class Piece:
    """One foot of one variant of a take: its curves (n, columns), allowed states (n, 4), and how much it counts."""

    subject: str
    curves: Batch
    allowed: Batch
    weight: float


def pieces(folder: Path) -> list[Piece]:
    """All variants of all takes and walkers."""
    takes, bare = recorded(folder), recorded(folder, toes=False)
    all_of: list[Piece] = []
    for take, toeless in zip(takes, bare, strict=True):
        for k in range(VARIANTS):
            random = np.random.default_rng([zlib.crc32(take.name.encode()), k]) if k else None
            all_of += _pieces(toeless if k % 6 == 5 else take, random, 1.0)
    for n, take in enumerate(made(WALKERS, 1)):
        for k in range(WALKER_VARIANTS):
            all_of += _pieces(take, np.random.default_rng([1, n, k]), WALKER_WEIGHT)
    return all_of


def _pieces(take: Take, random: np.random.Generator | None, weight: float) -> list[Piece]:
    clips, share = variant(take, random)
    return [
        Piece(take.subject, curves[k].astype(np.float32), allowed[:, k].astype(np.float32), weight * share)
        for curves, allowed in clips
        for k in (0, 1)
    ]


def events(folder: Path) -> list[tuple[Events, Events]]:
    """Of all variants of all takes in which figures go somewhere, and of walkers."""
    found = []
    for take, toeless in zip(recorded(folder), recorded(folder, toes=False), strict=True):
        if not take.calm:
            found += [moments(toeless if k % 6 == 5 else take, k) for k in range(VARIANTS)]
    return found + [moments(take, 1) for take in made(WALKERS, 1)]


def fold(subject: str) -> int:
    """The part a subject belongs to, by name, so that more takes change no split; walkers are in none."""
    return -1 if subject == "walker" else zlib.crc32(subject.encode()) % FOLDS


def fitted_without(part: int | None, all_of: list[Piece]) -> Network:
    """The network fitted to all subjects but those of one part."""
    moments = Moments()
    for piece in all_of:
        if fold(piece.subject) != part:
            moments.add(piece.curves, piece.allowed, piece.weight)
    return rounded(fit_by_committee(moments, FitParams(), FOLDS if part is None else part))


def timing_without(part: int | None, all_of: list[tuple[Events, Events]]) -> Timing:
    """What tells when feet land and leave, fitted to all subjects but those of one part."""
    return fit_timing([each for each in all_of if fold(each[0].subject) != part])


def cross_validated(folder: Path) -> Table:
    """Each take judged by what has not seen its subject."""
    all_of, all_events = pieces(folder), events(folder)
    scores = Table()
    for part in range(FOLDS):
        network, timing = fitted_without(part, all_of), timing_without(part, all_events)
        for _, subject, truth, tracks in truths(folder):
            if fold(subject) == part:
                scores.add(truth, auto(tracks, AutoParams(), network, timing), tracks.frame_time)
                if truth.kind.startswith("run"):
                    truth, tracks = quicker(truth, tracks, QUICKER)
                    scores.add(truth, auto(tracks, AutoParams(), network, timing), tracks.frame_time)
        print(f"part {part + 1} of {FOLDS} judged", flush=True)
    return scores


def main() -> None:
    """Fits, judges, writes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("truth", type=Path, help="folder of clips with plates")
    parser.add_argument("--cross", action="store_true", help="judge on subjects that were not fitted to")
    parser.add_argument("--write", action="store_true", help="fit to all and write the numbers")
    asked = parser.parse_args()
    if asked.cross:
        print("\n".join(cross_validated(asked.truth).rows()))
    if asked.write:
        all_of = pieces(asked.truth)
        people = {piece.subject for piece in all_of} - {"walker"}
        said = (
            f"Fitted to takes of {len(people)} people over force plates and to {WALKERS} made walkers, each in\n"
            "several variants."
        )
        network, timing = fitted_without(None, all_of), timing_without(None, events(asked.truth))
        FITTED.write_bytes(table(network, timing, said).encode())


if __name__ == "__main__":
    main()

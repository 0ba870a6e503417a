"""Fits the network of the default detector, and says how well it does on people it has not seen.

    python benchmarks/fit_auto.py TRUTH [--cross] [--write]

TRUTH is a folder of clips with a `NAME.truth.json` each (contacts that force plates measured). With --cross the
takes are split by subject into five parts, each judged by a network fitted to the other four; with --write a
network fitted to all of them is written to footfix/detect/fitted.py. Both need some minutes. The result is the
same on every run: all chance comes from fixed seeds.
"""

from __future__ import annotations

import argparse
import zlib
from pathlib import Path

import numpy as np
from detection import Table, truths
from fit_network import FitParams, Moments, fit_by_committee, module, rounded
from fit_takes import Take, made, recorded
from fit_variants import variant

from footfix.detect.auto import AutoParams, auto
from footfix.detect.network import Network

FOLDS = 5
VARIANTS = 8  # of each recorded take; the first is as recorded, and one in six is without toe joints
WALKERS, WALKER_VARIANTS, WALKER_WEIGHT = 300, 2, 0.25
FITTED = Path(__file__).resolve().parent.parent / "footfix" / "detect" / "fitted.py"


def moments(takes: list[Take], bare: list[Take], walkers: list[Take]) -> Moments:
    """All variants of some takes, as what a network is fitted to."""
    all_of = Moments()
    for take, toeless in zip(takes, bare, strict=True):
        for k in range(VARIANTS):
            random = np.random.default_rng([zlib.crc32(take.name.encode()), k]) if k else None
            _add(all_of, toeless if k % 6 == 5 else take, random, 1.0)
    for n, take in enumerate(walkers):
        for k in range(WALKER_VARIANTS):
            _add(all_of, take, np.random.default_rng([1, n, k]), WALKER_WEIGHT)
    return all_of


def _add(all_of: Moments, take: Take, random: np.random.Generator | None, weight: float) -> None:
    curves, allowed, share = variant(take, random)
    for k in (0, 1):
        all_of.add(curves[k].astype(np.float32), allowed[:, k].astype(np.float32), weight * share)


def fold(subject: str) -> int:
    """The part a subject belongs to, by name, so that more takes change no split."""
    return zlib.crc32(subject.encode()) % FOLDS


def fitted_without(part: int | None, takes: list[Take], bare: list[Take], walkers: list[Take]) -> Network:
    """The network fitted to all subjects but those of one part."""
    chosen = [k for k, take in enumerate(takes) if fold(take.subject) != part]
    all_of = moments([takes[k] for k in chosen], [bare[k] for k in chosen], walkers)
    return rounded(fit_by_committee(all_of, FitParams(), FOLDS if part is None else part))


def cross_validated(folder: Path) -> Table:
    """Each take judged by a network that has not seen its subject."""
    takes, bare, walkers = recorded(folder), recorded(folder, toes=False), made(WALKERS, 1)
    subjects = {take.name: take.subject for take in takes}
    table = Table()
    for part in range(FOLDS):
        network = fitted_without(part, takes, bare, walkers)
        for name, truth, tracks in truths(folder):
            if fold(subjects[name]) == part:
                table.add(truth, auto(tracks, AutoParams(), network), tracks.frame_time)
        print(f"part {part + 1} of {FOLDS} judged", flush=True)
    return table


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
        takes, bare, walkers = recorded(asked.truth), recorded(asked.truth, toes=False), made(WALKERS, 1)
        network = fitted_without(None, takes, bare, walkers)
        said = (
            f"Fitted to {len(takes)} takes of {len({take.subject for take in takes})} people over force plates and\n"
            f"{len(walkers)} made walkers, each in several variants."
        )
        FITTED.write_bytes(module(network, said).encode())


if __name__ == "__main__":
    main()

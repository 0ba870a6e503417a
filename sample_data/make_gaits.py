"""Makes a folder of walks and runs of one figure at many speeds, to fit a model to: python make_gaits.py FOLDER."""

from __future__ import annotations

import sys
from pathlib import Path

from exports import Spelling, bvh
from walker import make
from walker_plan import Gait

SPEEDS = {"walk": (0.7, 0.9, 1.1, 1.3, 1.5, 1.8), "run": (1.7, 2.0, 2.3, 2.7, 3.1, 3.6)}  # [m/s]
SECONDS = {"walk": 6.0, "run": 5.0}


def main() -> None:
    """Writes them."""
    if len(sys.argv) != 2:
        sys.exit("say where: python make_gaits.py FOLDER")
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, speeds in SPEEDS.items():
        for seed, speed in enumerate(speeds):
            gait = Gait(name=name, speed=speed, duration=SECONDS[name], fps=60.0, seed=seed)  # type: ignore[arg-type]
            path = folder / f"{name}_{100.0 * speed:.0f}cm_s.bvh"
            path.write_bytes(bvh(make(gait).clip, Spelling(decimals=4)))


if __name__ == "__main__":
    main()

"""A model fitted to made walkers, shared by the tests of cycles; made once."""

from __future__ import annotations

from functools import cache

from exports import Spelling, bvh
from walker import make
from walker_plan import Gait

from footfix.jobs.fit import FileCycles, Fitted, cycles_of_file, fit_files
from footfix.settings import Settings

SPEEDS = {"walk": (0.8, 1.1, 1.4, 1.8), "run": (1.8, 2.3, 2.9, 3.5)}


@cache
def files() -> tuple[FileCycles, ...]:
    found = []
    for name, speeds in SPEEDS.items():
        for k, speed in enumerate(speeds):
            walk = make(Gait(name=name, speed=speed, duration=7.0 if name == "walk" else 5.0, fps=60.0, seed=k))  # type: ignore[arg-type]
            data = bvh(walk.clip, Spelling(decimals=4))
            found.append(cycles_of_file(data, f"{name}_{speed}.bvh", Settings()))
    return tuple(found)


@cache
def fitted() -> Fitted:
    return fit_files(files())

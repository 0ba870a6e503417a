"""A model fitted to made walkers, shared by the tests of cycles; made once."""

from __future__ import annotations

from functools import cache

from exports import Spelling, bvh
from once import once
from walker import make
from walker_plan import Gait

from footfix.jobs.fit_cycles import FileCycles, Fitted, cycles_of_file, fit_files
from footfix.settings import Settings

SPEEDS = {"walk": (0.8, 1.1, 1.4, 1.8), "run": (1.8, 2.3, 2.9, 3.5)}


def walker(name: str, speed: float, seconds: float, seed: int) -> bytes:
    """A file of a made walker."""
    gait = Gait(name=name, speed=speed, duration=seconds, fps=30.0, seed=seed)  # type: ignore[arg-type]
    return bvh(make(gait).clip, Spelling(decimals=4))


def _files() -> tuple[FileCycles, ...]:
    found = []
    for name, speeds in SPEEDS.items():
        for k, speed in enumerate(speeds):
            data = walker(name, speed, 7.0 if name == "walk" else 5.0, k)
            found.append(cycles_of_file(data, f"{name}_{speed}.bvh", Settings()))
    return tuple(found)


@cache
def files() -> tuple[FileCycles, ...]:
    """The cycles of walkers at several speeds."""
    return once("cycles-of-walkers", _files)


@cache
def fitted() -> Fitted:
    """The model fitted to them."""
    return once("model-of-walkers", lambda: fit_files(files()))

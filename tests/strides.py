"""Strides of the walkers, shared by the tests of what is walked along a path; each is made once in a run."""

from __future__ import annotations

from functools import cache

from once import once
from walks import rig_of, walk

from footfix.enforce.params import EnforceParams
from footfix.locomotion.follow.walk import Walk, make_walk
from footfix.locomotion.loop.params import LoopParams
from footfix.locomotion.loop.run import make_loop


def _made(name: str, fps: float) -> Walk:
    made = walk(name, fps)
    loop = make_loop(made.clip, rig_of(made), made.contacts, LoopParams(straighten=True), EnforceParams())
    return make_walk(loop, f"{name}.bvh")


@cache
def stride(name: str = "walk", fps: float = 60.0) -> Walk:
    """The loop of a walker who goes straight on, as a walk."""
    return once(f"stride-{name}-{fps:.0f}", lambda: _made(name, fps))

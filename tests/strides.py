"""Strides of the walkers, shared by the tests of what is walked along a path; each is made once in a run."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

from once import once
from walks import rig_of, walk

from footfix.enforce.params import EnforceParams
from footfix.locomotion.follow.prepared_walk import Walk, make_walk
from footfix.locomotion.follow.run import Follow
from footfix.locomotion.loop.params import LoopParams
from footfix.locomotion.loop.run import make_loop
from footfix.motion.kinematics import Pose, forward
from footfix.rig.rig import Leg


def _made(name: str, fps: float) -> Walk:
    made = walk(name, fps)
    loop = make_loop(made.clip, rig_of(made), made.contacts, LoopParams(straighten=True), EnforceParams())
    return make_walk(loop, f"{name}.bvh")


@cache
def stride(name: str = "walk", fps: float = 60.0) -> Walk:
    """The loop of a walker who goes straight on, as a walk."""
    return once(f"stride-{name}-{fps:.0f}", lambda: _made(name, fps))


def stances(found: Follow) -> Iterator[tuple[Pose, Leg, slice]]:
    """Pose, leg and frames of each whole contact of a toe joint, without 15 ms at both ends."""
    edge = max(1, round(0.015 / found.clip.frame_time))
    for sole, effector in zip(found.rig.soles, found.contacts.effectors, strict=True):
        leg = found.rig.legs[sole.leg]
        if sole.part != "toe" or leg.toe is None:
            continue
        pose = forward(found.clip, [leg.ankle, leg.toe])
        for c in effector.contacts:
            some = slice(c.start + edge, max(c.end - edge, 0))
            if c.start > 0 and c.end < len(found.clip) and some.stop - some.start >= 4:
                yield pose, leg, some

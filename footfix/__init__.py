"""footfix: finds footplants in motion-capture clips and takes the foot skate out.

    import footfix
    walk = footfix.load("walk.bvh")                 # the file, and .clip: metres, y up
    rig = footfix.find_rig(walk.clip)
    contacts = footfix.detect(walk.clip, rig)
    result = footfix.clean(walk.clip, rig=rig, contacts=contacts)
    footfix.save("walk.clean.bvh", result.clip, like=walk)
    round = footfix.loop(walk.clip, rig=rig, contacts=contacts)
    footfix.save("walk.loop.bvh", round.clip)       # a cycle that repeats without a hitch

The names below are imported when they are first used, so that `footfix --help` need not wait for numpy.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from footfix.version import __version__

if TYPE_CHECKING:
    from footfix.api import clean, detect, find_rig, load, loop, save
    from footfix.errors import FootfixError
    from footfix.locomotion.loop import Loop
    from footfix.motion.clip import Clip, Skeleton
    from footfix.motion.contacts import Contact, Contacts, Effector
    from footfix.rig.rig import Leg, Rig, SolePoint

_HOME = {
    "clean": "footfix.api",
    "detect": "footfix.api",
    "find_rig": "footfix.api",
    "load": "footfix.api",
    "loop": "footfix.api",
    "save": "footfix.api",
    "FootfixError": "footfix.errors",
    "Clip": "footfix.motion.clip",
    "Skeleton": "footfix.motion.clip",
    "Contact": "footfix.motion.contacts",
    "Contacts": "footfix.motion.contacts",
    "Effector": "footfix.motion.contacts",
    "Leg": "footfix.rig.rig",
    "Loop": "footfix.locomotion.loop",
    "Rig": "footfix.rig.rig",
    "SolePoint": "footfix.rig.rig",
}

__all__ = [
    "Clip", "Contact", "Contacts", "Effector", "FootfixError", "Leg", "Loop", "Rig", "Skeleton", "SolePoint",
    "__version__", "clean", "detect", "find_rig", "load", "loop", "save",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    # `footfix.detect` is also a package: importing `footfix.detect.auto` would put the package in the
    # function's place, so the functions of the API are looked up here and nowhere else.
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)

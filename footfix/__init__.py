"""footfix: finds footplants in motion-capture clips and takes the foot skate out.

    import footfix
    walk = footfix.load("walk.bvh")                 # the file, and .clip: metres, y up
    rig = footfix.find_rig(walk.clip)
    contacts = footfix.detect(walk.clip, rig)
    result = footfix.clean(walk.clip, rig=rig, contacts=contacts)
    footfix.save("walk.clean.bvh", result.clip, like=walk)
    round = footfix.loop(walk.clip, rig=rig, contacts=contacts)
    footfix.save("walk.loop.bvh", round.clip)       # a cycle that repeats without a hitch
    live = footfix.Stream(walk, look_ahead=0.15)    # frames in, frames out: live.push(row), live.close()

The names below are imported when they are first used, so that `footfix --help` need not wait for numpy.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from footfix.version import __version__

if TYPE_CHECKING:
    from footfix.api.clips import apply, clean, clean_figures, detect, find_rig, find_rigs, global_positions, measure
    from footfix.api.engines import Ahead, Engine, Frame, fit_cycles, load_model, save_model
    from footfix.api.files import animations, load, save
    from footfix.api.follows import follow
    from footfix.api.labels import load_contacts, save_contacts
    from footfix.api.loops import loop
    from footfix.api.parameters import make_settings, presets
    from footfix.api.positions import HUMANML3D_NAMES, HUMANML3D_PARENTS, CleanedPositions, clean_positions
    from footfix.api.reports import clean_file, make_page, make_report, summarize
    from footfix.api.streams import Stream
    from footfix.enforce.correction import Correction
    from footfix.enforce.footplant import Footplant
    from footfix.errors import ArgumentError, FootfixError, InputError, NoLegsError, OutputError, UsageError
    from footfix.formats.document import Document
    from footfix.jobs.outputs import Outputs
    from footfix.locomotion.follow.run import Follow
    from footfix.locomotion.loop.run import Loop
    from footfix.measure.arrays import PhysDiff, jitter, physdiff, skating_ratio, slides, weighted_skate
    from footfix.measure.clip import Measures
    from footfix.measure.plants import PlantMeasure
    from footfix.motion.clip import Clip, Skeleton
    from footfix.motion.contacts import Contact, Contacts, Effector
    from footfix.notes import Note
    from footfix.pipeline import Result
    from footfix.rig.params import RigParams
    from footfix.rig.rig import Leg, Rig, SolePoint
    from footfix.settings import Settings

_NAMES = {
    "footfix.api.clips": "apply clean clean_figures detect find_rig find_rigs global_positions measure",
    "footfix.api.files": "animations load save",
    "footfix.api.parameters": "make_settings presets",
    "footfix.api.follows": "follow",
    "footfix.api.engines": "Ahead Engine Frame fit_cycles load_model save_model",
    "footfix.api.labels": "load_contacts save_contacts",
    "footfix.api.loops": "loop",
    "footfix.api.positions": "HUMANML3D_NAMES HUMANML3D_PARENTS CleanedPositions clean_positions",
    "footfix.api.reports": "clean_file make_page make_report summarize",
    "footfix.enforce.correction": "Correction",
    "footfix.enforce.footplant": "Footplant",
    "footfix.errors": "ArgumentError FootfixError InputError NoLegsError OutputError UsageError",
    "footfix.formats.document": "Document",
    "footfix.jobs.outputs": "Outputs",
    "footfix.locomotion.follow.run": "Follow",
    "footfix.locomotion.loop.run": "Loop",
    "footfix.measure.arrays": "PhysDiff jitter physdiff skating_ratio slides weighted_skate",
    "footfix.measure.clip": "Measures",
    "footfix.measure.plants": "PlantMeasure",
    "footfix.motion.clip": "Clip Skeleton",
    "footfix.motion.contacts": "Contact Contacts Effector",
    "footfix.notes": "Note",
    "footfix.pipeline": "Result",
    "footfix.rig.params": "RigParams",
    "footfix.rig.rig": "Leg Rig SolePoint",
    "footfix.settings": "Settings",
    "footfix.api.streams": "Stream",
}
_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}

__all__ = [
    "HUMANML3D_NAMES",
    "HUMANML3D_PARENTS",
    "Ahead",
    "ArgumentError",
    "CleanedPositions",
    "Clip",
    "Contact",
    "Contacts",
    "Correction",
    "Document",
    "Effector",
    "Engine",
    "Follow",
    "FootfixError",
    "Footplant",
    "Frame",
    "InputError",
    "Leg",
    "Loop",
    "Measures",
    "NoLegsError",
    "Note",
    "OutputError",
    "Outputs",
    "PhysDiff",
    "PlantMeasure",
    "Result",
    "Rig",
    "RigParams",
    "Settings",
    "Skeleton",
    "SolePoint",
    "Stream",
    "UsageError",
    "__version__",
    "animations",
    "apply",
    "clean",
    "clean_figures",
    "clean_file",
    "clean_positions",
    "detect",
    "find_rig",
    "find_rigs",
    "fit_cycles",
    "follow",
    "global_positions",
    "jitter",
    "load",
    "load_contacts",
    "load_model",
    "loop",
    "make_page",
    "make_report",
    "make_settings",
    "measure",
    "physdiff",
    "presets",
    "save",
    "save_contacts",
    "save_model",
    "skating_ratio",
    "slides",
    "summarize",
    "weighted_skate",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _CallablePackage(ModuleType):
    """A package that is also the function of its name: `footfix.detect(clip)` beside `footfix.detect.auto`."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        name = self.__name__.rpartition(".")[2]
        return getattr(import_module(_HOME[name]), name)(*args, **kwargs)


class _Footfix(ModuleType):
    """This package, in which importing a module of `detect` or `measure` must not hide the function of that name."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _HOME and isinstance(value, ModuleType):
            value.__class__ = _CallablePackage
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Footfix

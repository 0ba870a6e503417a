"""Legs that the animations of one file share: legs found in most of them are used for all.

The legs of a horse that lies down or a fox that is curled up can't be found in that animation alone. Where no
animation shows four, the pose in which the skin was bound may.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Literal

import numpy as np

from footfix.errors import InputError
from footfix.formats.bvh.text import Limits
from footfix.formats.document import Beside, clips_of, neighbours_of, open_document
from footfix.formats.suffixes import in_file
from footfix.motion.lead_in import motion_range
from footfix.rig.frame_sample import sample
from footfix.rig.leg_assignment import Figure, figures
from footfix.rig.params import LegParams, RigParams
from footfix.rig.skin import legs_of
from footfix.settings import Settings

_BOUND = ""  # stands for the pose of binding among the animations
_FOUR = 4  # legs, more than which nothing is looked for
_MOST = 12  # animations of a file that are examined, spread over it

_Legs = tuple[tuple[str, LegParams], ...]


def with_shared_legs(data: bytes, name: str, settings: Settings, beside: Beside | None = None) -> Settings:
    """Name the legs of an animation in its settings, where most animations of its file show other legs than it does.

    Args:
        data: the bytes of the file.
        name: of the animation, as in character.glb#Walk.
        settings: returned unchanged where they name legs, or where the animation shows the same ones.
        beside: reads files that this one names.
    """
    file, animation = in_file(name)
    if settings.rig.legs or not animation:
        return settings
    try:
        # Not cached where the file names other files, since those may change.
        names = neighbours_of(data, name=file, limits=settings.limits, beside=beside)
        found = _found.__wrapped__ if names else _found
        by_animation = found(data, file, settings.limits, beside if names else None)
    except InputError:
        return settings  # the error is raised where the animation is read
    best = _best(by_animation)
    own = by_animation.get(animation)
    if own is None:
        own = _legs_of(data, name, settings.limits, beside)
    return settings if best in ((), own) else replace(settings, rig=replace(settings.rig, legs=dict(best)))


def _best(by_animation: Mapping[str, _Legs]) -> _Legs:
    """Choose the largest number of legs found, and among sets of that many the one most animations show."""
    count = Counter(legs for legs in by_animation.values() if legs)
    return max(count, key=lambda legs: (len(legs), count[legs]), default=())


@lru_cache(maxsize=2)
def _found(data: bytes, file: str, limits: Limits, beside: Beside | None) -> Mapping[str, _Legs]:
    """Find the legs that each examined animation shows; none where it shows none."""
    names = clips_of(data, name=file, limits=limits, beside=beside) or ()
    if len(names) < 2:
        return {}
    some = np.unique(np.linspace(0, len(names) - 1, _MOST).astype(np.intp)).tolist()
    found = {names[k]: _legs_of(data, f"{file}#{names[k]}", limits, beside) for k in some}
    most = max(map(len, found.values()))
    bound = _bound_legs(data, f"{file}#{names[0]}", limits, beside) if most < _FOUR else ()
    return {**found, _BOUND: bound} if len(bound) > most else found


def _legs_of(data: bytes, name: str, limits: Limits, beside: Beside | None) -> _Legs:
    try:
        document = open_document(data, name=name, limits=limits, beside=beside)
        if document.unusable or document.frames < 2:
            return ()
        clip = document.clip
        shown = figures(sample(clip, motion_range(clip)), RigParams(), y_up=True)
    except InputError:
        return ()
    return _as_params(shown[0], clip.skeleton.names) if len(shown) == 1 else ()


def _bound_legs(data: bytes, name: str, limits: Limits, beside: Beside | None) -> _Legs:
    """Find the legs that the pose shows in which the skin was bound: an animal that runs or sits stands in it."""
    try:
        document = open_document(data, name=name, limits=limits, beside=beside)
        legs = () if document.skin is None else legs_of(document.skin)
    except InputError:
        return ()
    if document.skin is None or not legs:
        return ()
    names, known = document.skin.names, document.clip.skeleton.names
    found = []
    for leg in legs:
        joints = (leg.hip, leg.knee, leg.ankle, *(() if leg.toe is None else (leg.toe,)))
        if any(known.count(names[joint]) != 1 for joint in joints):
            return ()
        side: Literal["left", "right"] = "right" if leg.name.endswith("right") else "left"
        toe = "none" if leg.toe is None else names[leg.toe]
        own = LegParams(hip=names[leg.hip], knee=names[leg.knee], ankle=names[leg.ankle], toe=toe, side=side)
        found.append((leg.name, own))
    return tuple(sorted(found, key=_in_order))


def _in_order(leg: tuple[str, LegParams]) -> tuple[bool, bool]:
    """Make the key that sorts legs as the search does: front before back, left before right."""
    return not leg[0].startswith("front"), leg[1].side == "right"


def _as_params(figure: Figure, names: tuple[str, ...]) -> _Legs:
    """Write the legs of a figure as parameters; none where their names or joints are not unique."""
    if not all(figure.sides):
        return ()
    legs = []
    for limb, toe, end, side in zip(figure.limbs, figure.toes, figure.names, figure.sides, strict=True):
        joints = (limb.hip, limb.knee, limb.ankle, *(() if toe is None else (toe,)))
        if any(names.count(names[joint]) != 1 for joint in joints):
            return ()
        hip, knee, ankle = (names[joint] for joint in joints[:3])
        own = LegParams(hip=hip, knee=knee, ankle=ankle, toe="none" if toe is None else names[toe], side=side)
        legs.append((f"{end}_{side}" if end else side, own))
    return tuple(sorted(legs, key=_in_order))

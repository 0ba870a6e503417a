"""Clips: found legs in, cleaned and measured."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace

from footfix import pipeline
from footfix.api.parameters import check_settings
from footfix.detect import run as detection
from footfix.enforce.correction import Correction
from footfix.enforce.correction import apply as apply_correction
from footfix.errors import ArgumentError
from footfix.input_checks import check_clip, check_contacts, check_rig
from footfix.jobs.source import LEAST_FRAMES
from footfix.measure.clip import Measures
from footfix.measure.clip import measure as measured
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import places
from footfix.pipeline import Result
from footfix.rig import find
from footfix.rig.rig import Rig
from footfix.rig.skin import Skin
from footfix.settings import Settings

__all__ = [
    "apply", "clean", "clean_figures", "detect", "find_rig", "find_rigs", "global_positions", "measure",
]  # fmt: skip


def find_rig(
    clip: Clip, settings: Settings | None = None, skin: str | os.PathLike[str] | Skin | None = None
) -> Rig:  # fmt: skip
    """Find legs, sole points, leg length and floor of a clip's figure; of the first one where there are several.

    Examples:
        >>> from footfix.api.files import load
        >>> rig = find_rig(load("sample_data/walk_skate.bvh").clip)
        >>> [sole.name for sole in rig.soles], round(rig.leg_length, 2)
        (['left_heel', 'left_toe', 'right_heel', 'right_toe'], 0.88)

    Args:
        clip: in metres, y up; positions parent-local.
        settings: what is known beforehand, as `settings.rig`.
        skin: a glTF file of the character whose feet these are, from whose mesh the soles are taken, or the `.skin`
            of a glTF file that was loaded; by default what `settings.rig.skin` names.

    Raises:
        ArgumentError: it is not a clip, or not in metres.
        InputError: the skin can't be read.
        NoLegsError: nothing in the skeleton could be a pair of legs.
    """
    return find_rigs(clip, settings, skin)[0]


def find_rigs(
    clip: Clip, settings: Settings | None = None, skin: str | os.PathLike[str] | Skin | None = None
) -> tuple[Rig, ...]:  # fmt: skip
    """Find the rigs of all figures of a clip, in the order of the file: one for each root that has legs.

    Args:
        clip: in metres, y up; positions parent-local.
        settings: what is known beforehand, as `settings.rig`.
        skin: a glTF file of the character whose feet these are, from whose mesh the soles are taken, or the `.skin`
            of a glTF file that was loaded; by default what `settings.rig.skin` names.

    Raises:
        ArgumentError: it is not a clip, or not in metres.
        InputError: the skin can't be read.
        NoLegsError: no figure has legs.
    """
    check_clip(clip)
    settings = check_settings(settings)
    if not isinstance(skin, Skin):
        from footfix.batch.skins import skin_for

        params = settings.rig if skin is None else replace(settings.rig, skin=os.fspath(skin))
        skin = skin_for(replace(settings, rig=params))
    else:
        params = replace(settings.rig, skin=skin.name)
    rigs = find.find_rigs(clip, params, skin=skin)
    return tuple(check_rig(rig, clip) for rig in rigs)


def detect(clip: Clip, rig: Rig | None = None, settings: Settings | None = None) -> Contacts:
    """Find when heel and toe of each foot are planted; frames that lead in and out of the motion are left out.

    Examples:
        >>> from footfix.api.files import load
        >>> contacts = detect(load("sample_data/walk_skate.bvh").clip)
        >>> contacts.mask().shape, contacts.names[:2]
        ((301, 4), ('left_heel', 'left_toe'))
        >>> first = contacts["left_toe"].contacts[0]
        >>> first.start
        0

    Args:
        clip: in metres, y up; positions parent-local.
        rig: its legs and sole points; found where it is not given.
        settings: which detector, as `settings.detect`.

    Returns:
        Contacts for each sole point of the rig; `.mask()` is (F, E), left heel, left toe, right heel, right toe.

    Raises:
        ArgumentError: the clip or the rig can't be what is meant.
        NoLegsError: no legs were found, and no rig was given.
    """
    settings = check_settings(settings)
    rig = find_rig(clip, settings) if rig is None else check_rig(rig, check_clip(clip))
    return detection.detect(clip, rig, settings.detect)


def clean(
    clip: Clip, settings: Settings | None = None, *, rig: Rig | None = None, contacts: Contacts | None = None
) -> Result:
    """Find the footplants of a clip and take the foot skate out.

    Examples:
        >>> from footfix.api.files import load
        >>> walk = load("sample_data/walk_skate.bvh")
        >>> result = clean(walk.clip)
        >>> result.before.slide_mm > 40.0, result.after.slide_mm < 1.0
        (True, True)
        >>> "pinned" in {plant.outcome for plant in result.plants}
        True

    Args:
        clip: the motion, metres, y up; positions parent-local.
        settings: the parameters of all steps.
        rig: legs and soles; found where it is not given.
        contacts: which sole points are planted when; detected where they are not given.

    Returns:
        The corrected clip and all that was found on the way.

    Raises:
        ArgumentError: clip, rig, contacts or settings can't be what is meant.
        NoLegsError: no legs were found, and no rig was given.
    """
    rigs: tuple[Rig, ...] | None = None if rig is None else (rig,)
    if rigs is None and contacts is not None:
        rigs = find_rigs(clip, settings)[:1]
    return clean_figures(clip, settings, rigs=rigs, contacts=contacts, most=1)[0]


def clean_figures(
    clip: Clip, settings: Settings | None = None, *, rigs: Sequence[Rig] | None = None,
    contacts: Contacts | None = None, most: int | None = None,
) -> tuple[Result, ...]:  # fmt: skip
    """Clean every figure of a clip: two dancers in one file.

    Args:
        clip: the motion, metres, y up; positions parent-local.
        settings: the parameters of all steps.
        rigs: legs and soles of each figure; found where they are not given.
        contacts: of the sole points of all figures, in the order of the rigs; detected where they are not given.
        most: figures that are cleaned, the first ones of the file; all by default.

    Returns:
        One result a figure, each with the whole corrected clip.

    Raises:
        ArgumentError: clip, rigs, contacts or settings can't be what is meant.
        NoLegsError: no legs were found, and no rigs were given.
    """
    settings = check_settings(settings)
    check_clip(clip)
    if len(clip) < LEAST_FRAMES:
        raise ArgumentError(f"a clip of {len(clip)} frames is too short to hold a motion")
    rigs = (find_rigs(clip, settings) if rigs is None else tuple(check_rig(rig, clip) for rig in rigs))[:most]
    if contacts is not None:
        check_contacts(contacts, clip, [sole.name for rig in rigs for sole in rig.soles])
    return pipeline.clean_figures(clip, settings, rigs=rigs, contacts=contacts)


def measure(clip: Clip, rig: Rig | None = None, contacts: Contacts | None = None) -> Measures:
    """Measure what the feet of a clip do; the names of the measures carry their units.

    Examples:
        >>> from footfix.api.files import load
        >>> found = measure(load("sample_data/walk_skate.bvh").clip)
        >>> found.slide_mm > 40.0, found.coverage > 0.5
        (True, True)

    Args:
        clip: the motion, metres, y up; positions parent-local.
        rig: legs, soles and floor; found where it is not given.
        contacts: which sole points are planted when; detected where they are not given. Hand in the same ones to
            compare two clips.

    Raises:
        ArgumentError: clip, rig or contacts can't be what is meant.
        NoLegsError: no legs were found, and no rig was given.
    """
    rig = find_rig(clip) if rig is None else check_rig(rig, check_clip(clip))
    contacts = detect(clip, rig) if contacts is None else contacts
    return measured(clip, rig, check_contacts(contacts, clip, [sole.name for sole in rig.soles]))[0]


def apply(clip: Clip, correction: Correction) -> Clip:
    """Apply a correction; frames and joints that it leaves alone keep their very numbers.

    Args:
        clip: the motion it was made for.
        correction: `Result.correction`.

    Raises:
        ArgumentError: it is for a clip of another length.
    """
    check_clip(clip)
    if len(correction.root_shift) != len(clip):
        raise ArgumentError(f"a correction of {len(correction.root_shift)} frames, and a clip of {len(clip)}")
    return apply_correction(clip, correction)


def global_positions(clip: Clip) -> Floats:
    """Compute where all joints of a clip are in the world, (F, J, 3) [m], y up.

    Args:
        clip: the motion.
    """
    return places(check_clip(clip))

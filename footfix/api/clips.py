"""Clips: read, found legs in, cleaned, measured, written."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from footfix import pipeline
from footfix.arguments import check_clip, check_contacts, check_rig
from footfix.config import nested, presets, read_preset
from footfix.detect import run as detection
from footfix.enforce.correction import Correction
from footfix.enforce.correction import apply as apply_correction
from footfix.errors import ArgumentError
from footfix.formats.bvh import compose
from footfix.formats.document import Beside, Document, clips_of, one_format, rewrite
from footfix.formats.suffixes import in_file, is_motion
from footfix.jobs import clean as job
from footfix.measure.clip import Measures
from footfix.measure.clip import measure as measured
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import places
from footfix.pipeline import Result
from footfix.rig import find
from footfix.rig.rig import Rig
from footfix.rig.skin import Skin
from footfix.settings import Layer, Settings
from footfix.settings import compose as settings_of

__all__ = [
    "animations", "apply", "clean", "clean_figures", "detect", "find_rig", "find_rigs", "global_positions", "load",
    "make_settings", "measure", "presets", "save",
]  # fmt: skip


def load(
    path: str | os.PathLike[str], settings: Settings | None = None, *, animation: str | None = None
) -> Document:  # fmt: skip
    """Read a file of motion: BVH or glTF.

    Examples:
        >>> walk = load("sample_data/walk_skate.bvh")
        >>> walk.clip.positions.shape, round(walk.clip.fps), walk.unit_m, walk.up
        ((301, 21, 3), 60, 0.01, 'y')

    Args:
        path: the file.
        settings: how its unit and up axis are found, and how large it may be.
        animation: which one of a glTF file that holds several (`animations` lists them); character.glb#Walk as the
            path says the same.

    Returns:
        The file; its `.clip` is the motion in metres, y up, its `.notes` what was odd about it.

    Raises:
        InputError: it can't be read, holds numbers that are none, or several animations, of which none was named.
        OSError: it can't be opened.
    """
    file, named = _file_and_clip(path, animation)
    name = f"{file}#{named}" if named else file
    return job.read(Path(file).read_bytes(), name, check_settings(settings), beside=_beside(file))


def animations(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """List the animations of a glTF file by name; a BVH file is one clip, which has no name.

    Examples:
        >>> animations("sample_data/walk_skate.bvh")
        ()

    Args:
        path: the file.

    Raises:
        InputError: it can't be read, or holds no animation.
        OSError: it can't be opened.
    """
    file = os.fspath(path)
    return clips_of(Path(file).read_bytes(), name=file, beside=_beside(file)) or ()


def _file_and_clip(path: str | os.PathLike[str], animation: str | None) -> tuple[str, str]:
    """The file that a path means, and the animation in it; "" where neither names one."""
    name = os.fspath(path)
    file, named = (name, "") if Path(name).exists() else in_file(name)
    if named and animation not in (None, named):
        raise ArgumentError(f"{name} names the animation {named!r}, and animation={animation!r} another one")
    return file, animation or named


def _beside(file: str) -> Beside:
    """What reads the files that a glTF file names."""
    return lambda name: (Path(file).parent / name).read_bytes()


def save(path: str | os.PathLike[str], clip: Clip, *, like: Document | None = None) -> None:
    """Write a file of motion, whole or not at all.

    Args:
        path: the file; one that is there is replaced.
        clip: the motion.
        like: the document the clip came from. Its text is kept, and only the numbers of channels that
            changed are written anew; of a glTF file, all other animations are kept, too. Without it, a plain BVH file
            in centimetres, y up, is composed.

    Raises:
        ArgumentError: the clip is none, or not of the document's joints; or the path is that of another format.
        OutputError: it could not be written; what stood there still does.
    """
    from footfix.batch.files import write_whole

    check_clip(clip)
    if like is not None and clip.skeleton.names != like.clip.skeleton.names:
        raise ArgumentError(f"the clip's joints are not those of {like.name}; leave out `like` to write a plain file")
    if like is not None and len(clip) != like.frames:
        raise ArgumentError(f"the clip has {len(clip)} frames, {like.name} has {like.frames}; leave out `like`")
    name = os.fspath(path)
    if is_motion(name) and not one_format(name, ".bvh" if like is None else like.name):
        wanted = "needs `like`, the document that it came from" if like is None else f"and {like.name} differ in format"
        raise ArgumentError(f"{name} {wanted}; a clip is written in the format that it was read from, or as BVH")
    write_whole(Path(path), compose(clip) if like is None else rewrite(like, clip)[0])


def make_settings(preset: str | None = None, values: Mapping[str, Any] | None = None) -> Settings:
    """Make settings from a preset and from values, as a config file and `--set` do.

    Examples:
        >>> make_settings("video", {"detect.method": "threshold"}).detect.method
        'threshold'

    Args:
        preset: one of `presets()`.
        values: dotted names, or groups of them as mappings, over the preset.

    Raises:
        UsageError: an unknown preset or setting, or a value of the wrong kind; says which ones there are.
    """
    layers = [] if preset is None else [Layer(f"preset {preset}", read_preset(preset))]
    layers += [Layer("values", nested(name, value)) for name, value in (values or {}).items()]
    return settings_of(layers)


def check_settings(settings: Any) -> Settings:
    """Refuse settings that are none.

    Args:
        settings: what was given; None stands for the defaults.

    Returns:
        The settings.

    Raises:
        ArgumentError: it is a mapping, a name or something else.
    """
    if settings is None:
        return Settings()
    if isinstance(settings, (dict, str)):
        raise ArgumentError(f"Settings are wanted, not {settings!r}; footfix.make_settings(preset, values) makes them")
    if not isinstance(settings, Settings):
        raise ArgumentError(f"Settings are wanted, not {type(settings).__name__}")
    return settings


def find_rig(
    clip: Clip, settings: Settings | None = None, skin: str | os.PathLike[str] | Skin | None = None
) -> Rig:  # fmt: skip
    """Find legs, sole points, leg length and floor of a clip's figure; of the first one where there are several.

    Examples:
        >>> rig = find_rig(load("sample_data/walk_skate.bvh").clip)
        >>> [sole.name for sole in rig.soles], round(rig.leg_length, 2)
        (['left_heel', 'left_toe', 'right_heel', 'right_toe'], 0.88)

    Args:
        clip: in metres, y up; positions parent-local.
        settings: what is known beforehand, as `settings.rig`.
        skin: a glTF file of the character whose feet these are, from whose mesh the soles are taken; by default what
            `settings.rig.skin` names.

    Raises:
        ArgumentError: the clip is none, or not in metres.
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
        skin: a glTF file of the character whose feet these are, from whose mesh the soles are taken; by default what
            `settings.rig.skin` names.

    Raises:
        ArgumentError: the clip is none, or not in metres.
        InputError: the skin can't be read.
        NoLegsError: no figure has legs.
    """
    check_clip(clip)
    settings = check_settings(settings)
    if not isinstance(skin, Skin):
        from footfix.batch.skins import skin_for

        rig = settings.rig if skin is None else replace(settings.rig, skin=os.fspath(skin))
        skin = skin_for(replace(settings, rig=rig))
    rigs = find.find_rigs(clip, settings.rig, skin=skin)
    return tuple(check_rig(rig, clip) for rig in rigs)


def detect(clip: Clip, rig: Rig | None = None, settings: Settings | None = None) -> Contacts:
    """Find when heel and toe of each foot are planted; frames that lead in and out of the motion are left out.

    Examples:
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
    if len(clip) < job.LEAST_FRAMES:
        raise ArgumentError(f"a clip of {len(clip)} frames is too short to hold a motion")
    rigs = (find_rigs(clip, settings) if rigs is None else tuple(check_rig(rig, clip) for rig in rigs))[:most]
    if contacts is not None:
        check_contacts(contacts, clip, [sole.name for rig in rigs for sole in rig.soles])
    return pipeline.clean_figures(clip, settings, rigs=rigs, contacts=contacts)


def measure(clip: Clip, rig: Rig | None = None, contacts: Contacts | None = None) -> Measures:
    """Measure what the feet of a clip do; the names of the measures carry their units.

    Examples:
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
    """Work out where all joints of a clip are in the world: (F, J, 3) [m], y up.

    Args:
        clip: the motion.
    """
    return places(check_clip(clip))

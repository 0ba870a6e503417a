"""Checks of what a program hands to the Python interface, so that wrong input is refused in words.

Files are checked where they are read; what stands here is for arrays, whose unit, order and frame of reference nothing
says. Each check names what was given, what is expected, and how to come from the one to the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from footfix.errors import ArgumentError
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.rig.rig import Rig

_SLOWEST, _QUICKEST = 0.5, 1.0 / 5000.0  # [s] frame times outside these are another unit
_LEGS = (0.04, 4.0)  # [m] legs outside these are in another unit: no figure from a doll to a giant has them
_UNIT = 1e-3  # by which the length of a unit quaternion may differ from 1: what float16 leaves


def check_frame_time(frame_time: float) -> None:
    """Refuse a frame time that is a rate, or not in seconds.

    >>> check_frame_time(60)
    Traceback (most recent call last):
        ...
    footfix.errors.ArgumentError: frame_time is the time from frame to frame in seconds; 60 looks like a rate: give 1/60
    """
    if isinstance(frame_time, bool) or not isinstance(frame_time, (int, float, np.integer, np.floating)):
        raise ArgumentError(f"frame_time must be one number, the seconds from frame to frame, not {frame_time!r}")
    if not np.isfinite(frame_time) or frame_time <= 0.0:
        raise ArgumentError(f"frame_time must be a positive number of seconds, not {frame_time}")
    if frame_time >= 10.0:
        raise ArgumentError(
            f"frame_time is the time from frame to frame in seconds; {frame_time:g} looks like a rate: "
            f"give 1/{frame_time:g}"
        )
    if not _QUICKEST <= frame_time <= _SLOWEST:
        raise ArgumentError(
            f"a frame_time of {frame_time:g} s would be {1.0 / frame_time:g} frames per second; give seconds"
        )


def check_clip(clip: Any) -> Clip:
    """Raise if this is no Clip, or holds NaN or infinity.

    Args:
        clip: what was given.

    Returns:
        The same.

    Raises:
        ArgumentError: it is a file, an array or something else, its frame time is not in seconds, a number is NaN
            or infinite, or a rotation is no unit quaternion.
    """
    if not isinstance(clip, Clip):
        raise ArgumentError(_no_clip(clip))
    check_frame_time(clip.frame_time)
    names = clip.skeleton.names
    for joint, name in enumerate(names):
        _check_finite(f"position of {name}", clip.position(joint))
        turns = clip.rotation(joint)
        _check_finite(f"rotation of {name}", turns)
        if len(turns):
            turns = turns[:1] if turns.strides[0] == 0 else turns
            lengths = np.sqrt(np.einsum("fi,fi->f", turns, turns))
            worst = int(np.argmax(np.abs(lengths - 1.0)))
            if abs(lengths[worst] - 1.0) > _UNIT:
                raise ArgumentError(
                    f"rotations must be unit quaternions xyzw; that of {name} in frame {worst} has the length "
                    f"{lengths[worst]:.3g}; divide each by its length, if they are quaternions"
                )
    return clip


def _no_clip(given: Any) -> str:
    if hasattr(given, "clip") and hasattr(given, "frames"):
        return "this is a file, and its motion is wanted: give document.clip"
    if isinstance(given, np.ndarray):
        return "a Clip is wanted, not an array; footfix.clean_positions takes positions (F, J, 3) in the world"
    if isinstance(given, str) or hasattr(given, "__fspath__"):
        return f"a Clip is wanted, not the name of a file; footfix.load({str(given)!r}).clip reads it"
    return f"a Clip is wanted, not {type(given).__name__}"


def _check_finite(what: str, track: Floats) -> None:
    """Refuse a track (F, n) with NaN or infinity, saying in which frames."""
    if track.strides and track.strides[0] == 0:
        track = track[:1]
    if np.isfinite(track.sum()):  # a single NaN or infinity shows in the sum, at a tenth of the cost
        return
    broken = np.flatnonzero(~np.isfinite(track).all(axis=1))
    if len(broken):  # else the numbers are as large as numbers get
        where = f"frame {broken[0]}" if len(broken) == 1 else f"{len(broken)} frames, the first of them {broken[0]}"
        raise ArgumentError(f"{what} is NaN or infinite in {where}; fill in or cut out those frames first")


def check_rig(rig: Any, clip: Clip) -> Rig:
    """Refuse a rig of another skeleton, or one of a size that nothing has in metres.

    Args:
        rig: what was given, or found.
        clip: the clip it is used with.

    Returns:
        The same.

    Raises:
        ArgumentError: its joints are not the clip's, or its legs are not in metres.
    """
    if not isinstance(rig, Rig):
        raise ArgumentError(f"a Rig is wanted, as footfix.find_rig(clip) gives, not {type(rig).__name__}")
    highest = max(rig.joints(), default=0)
    if highest >= len(clip.skeleton):
        raise ArgumentError(f"the rig has a joint {highest}, the clip {len(clip.skeleton)} joints: of another skeleton")
    check_size(rig.leg_length)
    return rig


def check_size(leg_length: float) -> None:
    """Refuse a figure that is not in metres.

    >>> check_size(84.0)
    Traceback (most recent call last):
        ...
    footfix.errors.ArgumentError: a leg of 84 m: a Clip is in metres; if these are centimetres, multiply positions and \
offsets by 0.01
    """
    shortest, longest = _LEGS
    if shortest <= leg_length <= longest:
        return
    units = (("millimetres", 0.001), ("centimetres", 0.01), ("inches", 0.0254), ("decimetres", 0.1))
    usual = [(name, unit) for name, unit in units if 0.6 <= leg_length * unit <= 1.2]
    if usual:
        hint = f"if these are {usual[0][0]}, multiply positions and offsets by {usual[0][1]:g}"
    else:
        hint = f"multiply positions and offsets by {0.9 / leg_length:.3g}, as long as a person's leg"
    raise ArgumentError(f"a leg of {leg_length:.3g} m: a Clip is in metres; {hint}")


def check_contacts(contacts: Any, clip: Clip, names: Sequence[str]) -> Contacts:
    """Refuse contacts of another clip or another rig.

    Args:
        contacts: what was given.
        clip: the clip they are used with.
        names: of its effectors, in the order of the rig.

    Returns:
        The same.

    Raises:
        ArgumentError: they are a mask, of other frames, of another frame time, of other effectors, or out of order.
    """
    if isinstance(contacts, (np.ndarray, list, tuple)):
        raise ArgumentError(
            "Contacts are wanted, not an array; rig.no_contacts(clip).with_mask(mask) makes them of a mask (F, E)"
        )
    if not isinstance(contacts, Contacts):
        raise ArgumentError(f"Contacts are wanted, not {type(contacts).__name__}")
    if contacts.frames != len(clip):
        raise ArgumentError(f"contacts of {contacts.frames} frames, and a clip of {len(clip)}: of another clip")
    if abs(contacts.frame_time - clip.frame_time) > 0.01 * clip.frame_time:
        raise ArgumentError(
            f"contacts at {1.0 / contacts.frame_time:.4g} fps, and a clip at {clip.fps:.4g} fps: of another clip"
        )
    if contacts.names != tuple(names):
        raise ArgumentError(
            f"contacts of {', '.join(contacts.names) or 'nothing'}; the rig has {', '.join(names)}, in this order"
        )
    for effector in contacts.effectors:
        last = 0
        for each in effector.contacts:
            if not last <= each.start < each.end <= len(clip):
                raise ArgumentError(
                    f"{effector.name}: contact [{each.start}, {each.end}) is empty, overlaps the one before it, "
                    f"or lies outside the {len(clip)} frames of the clip"
                )
            last = each.end
    return contacts

"""Joint positions in the world, cleaned: what text-to-motion and pose-estimation networks give and take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from footfix.api.clips import clean, find_rig
from footfix.api.parameters import check_settings
from footfix.errors import ArgumentError
from footfix.input_checks import check_frame_time
from footfix.motion.clip import Clip, Floats
from footfix.motion.from_positions import fit_rotations
from footfix.motion.kinematics import places
from footfix.pipeline import Result
from footfix.rig.frame_sample import sample
from footfix.rig.leg_assignment import figures
from footfix.rig.rig import Rig
from footfix.rig.units import scores, vector
from footfix.settings import Settings

# The 22 joints of HumanML3D and SMPL: each one's parent, and its name.
HUMANML3D_PARENTS = (-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19)
HUMANML3D_NAMES = (
    "pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2", "left_ankle", "right_ankle",
    "spine3", "left_foot", "right_foot", "neck", "left_collar", "right_collar", "head", "left_shoulder",
    "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist",
)  # fmt: skip

_PLAINLY = 0.5  # evidence by which another axis must lead: of captured clips with y up, none leads by more than 0.24
_UNMOVED = 1e-9  # [m] forward kinematics gives positions back no worse than that


@dataclass(frozen=True, eq=False)
class CleanedPositions:
    """What cleaning joint positions gives.

    Args:
        positions: (F, J, 3) of the joints in the world, in the unit, axes and type that came in; each bone as long in
            each frame as it was. Unchanged values are returned exactly as given.
        contacts: (F, E) True where a sole point is planted: left heel, left toe, right heel, right toe.
        result: all that was found on the way; its clip is in metres, y up, with rotations fitted to the positions.
    """

    positions: Floats
    contacts: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
    result: Result


def clean_positions(
    positions: ArrayLike, parents: Sequence[int], frame_time: float, *, names: Sequence[str] | None = None,
    rest: ArrayLike | None = None, contacts: ArrayLike | None = None, unit_m: float = 1.0, up: str | None = None,
    settings: Settings | None = None, rig: Rig | None = None,
) -> CleanedPositions:  # fmt: skip
    """Take the foot skate out of joint positions in the world.

    Rotations are fitted to the bones, the clip is cleaned as any other, and its positions are given back. Legs are
    found by their shape; names help to tell left from right.

    Examples:
        >>> import footfix
        >>> clip = footfix.load("sample_data/walk_skate.bvh").clip
        >>> positions = footfix.global_positions(clip)  # as a network gives them: (F, J, 3)
        >>> cleaned = clean_positions(positions, clip.skeleton.parents, clip.frame_time, names=clip.skeleton.names)
        >>> cleaned.positions.shape, cleaned.contacts.shape, cleaned.result.after.slide_mm < 1.0
        ((301, 21, 3), (301, 4), True)

    Args:
        positions: (F, J, 3) of the joints in the world: not parent-local, not normalised, not relative to the root.
        parents: (J,) each joint's parent, before the joint, -1 for the root; HumanML3D's are `HUMANML3D_PARENTS`.
        frame_time: [s] from frame to frame; 1/20 in HumanML3D.
        names: (J,) of the joints.
        rest: (J, 3) a rest pose, in the unit and axes of the positions; by default the frame in which the figure stands
            tallest.
        contacts: (F, 4) True where left heel, left toe, right heel, right toe are planted; detected by default.
        unit_m: [m] one unit of the positions; 0.01 for centimetres.
        up: the upward axis of the positions: "y", "z", "x", "-y", "-z" or "-x"; by default y, and refused where the
            motion plainly says otherwise.
        settings: the parameters of all steps.
        rig: legs and soles; found where it is not given.

    Raises:
        ArgumentError: an array has another shape, holds NaN or infinity, or is in another unit than stated.
        NoLegsError: nothing in the skeleton could be a pair of legs.
    """
    given = np.asarray(positions)
    if given.ndim != 3 or given.shape[2] != 3 or given.dtype.kind not in "fiu":
        raise ArgumentError(f"positions must be (F, J, 3), frames, joints, x y z, not {given.shape} {given.dtype}")
    if not np.isfinite(given).all():
        frame = int(np.flatnonzero(~np.isfinite(given).all(axis=(1, 2)))[0])
        raise ArgumentError(f"positions are NaN or infinite in frame {frame}; fill in or cut out such frames first")
    if len(parents) != given.shape[1]:
        raise ArgumentError(f"{given.shape[1]} joints need {given.shape[1]} parents, not {len(parents)}")
    if names is not None and len(names) != given.shape[1]:
        raise ArgumentError(f"{given.shape[1]} joints need {given.shape[1]} names, not {len(names)}")
    check_frame_time(frame_time)
    settings, axes = check_settings(settings), _y_up(up or "y")
    world = unit_m * given.astype(np.float64) @ axes.T  # [m] y up
    pose = None if rest is None else unit_m * np.asarray(rest, dtype=np.float64) @ axes.T
    clip = fit_rotations(world, parents, float(frame_time), names=names, rest=pose)
    if up is None:
        _check_up(clip, settings)
    rig = find_rig(clip, settings) if rig is None else rig
    labels = None if contacts is None else rig.no_contacts(clip).with_mask(np.asarray(contacts))
    result = clean(clip, settings, rig=rig, contacts=labels)
    cleaned = places(result.clip)
    moved = np.abs(cleaned - world).max(axis=2, keepdims=True) > _UNMOVED
    kind = given.dtype if given.dtype.kind == "f" else np.dtype(np.float64)
    back = np.where(moved, cleaned @ axes / unit_m, given).astype(kind)
    return CleanedPositions(back, result.contacts.mask(), result)


def _check_up(clip: Clip, settings: Settings) -> None:
    """Refuse motion that stands along another axis than y."""
    seen = sample(clip)
    evidence = scores(seen, figures(seen, settings.rig, y_up=False)[0])
    by_axis = {axis: sum(each.values()) for axis, each in evidence.items()}
    best = max(by_axis, key=lambda axis: by_axis[axis])
    if by_axis[best] - by_axis["y"] > _PLAINLY:
        raise ArgumentError(f'{best} seems to be up here: hand in up="{best}", or up="y" if y is up after all')


def _y_up(up: str) -> Floats:
    """Get the rotation (3, 3) that takes an upward axis to y, by shuffling axes so that no number changes."""
    axes = ("y", "z", "x", "-y", "-z", "-x")
    if up not in axes:
        raise ArgumentError(f"up must be one of {', '.join(axes)}, not {up!r}")
    y = vector(up)
    z = np.roll(np.abs(y), 1)  # the axis after it, so that x y z stay a right-handed frame
    return np.stack([np.cross(y, z), y, z])

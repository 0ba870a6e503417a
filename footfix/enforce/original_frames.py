"""Map plants and correction of the cropped, thinned clip back to all frames of the file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footfix.enforce.correction import Correction
from footfix.enforce.footplant import Footplant
from footfix.enforce.run import Enforcement
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.duplicate_frames import DuplicateFrames
from footfix.rig.motion_crop import Crop

_REST = 1e-3  # [rad] root mean square over the joints: frames that differ by less are the same pose


def uncropped(found: Enforcement, clip: Clip, crop: Crop) -> Enforcement:
    """Extend an enforcement of the motion range to all frames.

    A T-pose before or after the motion is unchanged; in the transition frames beside it the correction fades in or out.

    Args:
        found: on the frames of `crop` alone.
        clip: F frames, the whole of it.
        crop: which frames are the motion.

    Returns:
        The same with all frames counted from the clip's start.
    """
    if not any(crop.cut):
        return found
    return replace(
        found,
        plants=tuple(_moved(plant, crop.start) for plant in found.plants),
        correction=_correction(found.correction, clip, crop),
        notes=crop.notes_back(found.notes),
        ground=crop.track_back(found.ground),
    )


def repeated(found: Enforcement, clip: Clip, thin: DuplicateFrames) -> Enforcement:
    """Extend an enforcement from unrepeated frames to all frames, so that repeated frames stay repeated.

    Args:
        found: on the frames that `thin` keeps.
        clip: F frames, all of them.
        thin: which frames those are.
    """
    if not thin:
        return found
    shift, rotations = (thin.track_back(each) for each in (found.correction.root_shift, found.correction.rotations))
    for k, joint in enumerate(found.correction.joints):
        own = clip.rotation(joint)  # repeats may differ by rounding, which stays where nothing is corrected
        as_captured = np.all(rotations[:, k] == own[thin.kept[thin.owner]], axis=1)[:, None]
        rotations[:, k] = np.where(as_captured, own, rotations[:, k])
    return replace(
        found,
        plants=tuple(_repeated(plant, thin) for plant in found.plants),
        correction=replace(found.correction, root_shift=shift, rotations=rotations),
        notes=thin.notes_back(found.notes),
        ground=thin.track_back(found.ground),
    )


def _repeated(plant: Footplant, thin: DuplicateFrames) -> Footplant:
    """Number the plant's frames among all frames."""
    held = tuple((thin.first(start), thin.first(end)) for start, end in plant.held)
    return replace(plant, start=thin.first(plant.start), end=thin.first(plant.end), held=held)


def _moved(plant: Footplant, by: int) -> Footplant:
    """Move a plant `by` frames later."""
    held = tuple((start + by, end + by) for start, end in plant.held)
    return replace(plant, start=plant.start + by, end=plant.end + by, held=held)


def _correction(found: Correction, clip: Clip, crop: Crop) -> Correction:
    """Fade the correction of the motion's first and last frame out over the transition frames beside it."""
    start, end = crop.start, crop.end
    shift = np.zeros((crop.frames, 3))  # [m]
    shift[crop.within] = found.root_shift
    rotations = np.zeros((crop.frames, 0, 4))
    if found.joints:
        rotations = np.stack([clip.rotation(joint) for joint in found.joints], axis=1)  # (F, J, 4)
    rotations[crop.within] = found.rotations
    for rest, motion, between in ((0, start, slice(1, start)), (len(clip) - 1, end - 1, slice(end, len(clip) - 1))):
        share = _way_over(clip, rest, motion, between)
        shift[between] = share[:, None] * shift[motion]
        for k, joint in enumerate(found.joints):
            captured = clip.rotation(joint)
            turn = rotation.multiply(rotations[motion, k], rotation.inverse(captured[motion]))
            eased = rotation.from_rotation_vector(share[:, None] * rotation.to_rotation_vector(turn))
            on_its_way = (share > 0.0)[:, None]
            rotations[between, k] = np.where(on_its_way, rotation.multiply(eased, captured[between]), captured[between])
    return replace(found, root_shift=shift, rotations=rotations)


def _way_over(clip: Clip, rest: int, motion: int, between: slice) -> Floats:
    """Measure how far each transition frame is from the rest pose towards the motion, from 0 to 1."""

    def far(other: int) -> Floats:  # [rad] from another frame, root mean square over the joints
        turns = rotation.multiply(clip.rotations[between], rotation.inverse(clip.rotations[[other]]))
        return np.asarray(np.sqrt(np.mean(rotation.angle(turns) ** 2, axis=1)))

    from_rest = far(rest)
    return np.where(from_rest < _REST, 0.0, from_rest / np.maximum(from_rest + far(motion), 1e-9))

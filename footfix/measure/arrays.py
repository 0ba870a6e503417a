"""The published measures on plain arrays, for positions without a skeleton.

Positions are in the world, in metres, y up; tracks are (F, 3), or (F, n, 3) for several points. They call the same
functions as `measure`, after checking their arguments.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from footfix.errors import ArgumentError
from footfix.measure import clip as whole
from footfix.measure import plants
from footfix.motion.clip import Floats
from footfix.motion.contacts import runs
from footfix.motion.segments import segments


class PhysDiff(NamedTuple):
    """PhysDiff's three measures [mm]: mean depth below the floor, mean height above it, mean slide a frame."""

    penetrate_mm: float
    float_mm: float
    skate_mm: float


def skating_ratio(toes: ArrayLike, frame_time: float, *, rest: ArrayLike = 0.0) -> float:
    """Compute the foot-skating ratio of GMD and OmniControl: the share of frames in which a toe skates.

    A toe skates where it is less than 5 cm above its height at rest, now and in the next frame, and faster than 0.5 m/s
    now and in the mean of 5 frames; motion is resampled to the 20 fps for which these bounds were set. Source:
    Karunratanakul et al. 2023, Xie et al. 2024.

    Examples:
        >>> toe = np.zeros((41, 3))
        >>> toe[:, 2] = 0.06 * np.arange(41)   # 1.2 m/s along the floor at 20 fps
        >>> skating_ratio(toe, 1 / 20)
        1.0

    Args:
        toes: (F, n, 3) [m] the toe joints, in the world.
        frame_time: [s].
        rest: (n,) or one number [m]: the height of a toe joint at rest; 0 as published.
    """
    points = _points("toes", toes, frame_time)
    rests = np.broadcast_to(np.asarray(rest, dtype=np.float64), (points.shape[1],))
    return whole.skating_ratio(list(points.transpose(1, 0, 2)), rests.tolist(), frame_time)


def weighted_skate(points: ArrayLike, frame_time: float, *, floor: float = 0.0, height: float = 0.033) -> float:
    """Compute the mean of v (2 - 2^(h / H)) [cm/s] over points of the foot near the floor.

    Source: Zhang et al. 2018 (mode-adaptive neural networks), H = 3.3 cm as in later code.

    Args:
        points: (F, n, 3) [m] points of the feet, in the world.
        frame_time: [s].
        floor: [m] its height.
        height: H [m].
    """
    tracks = _points("points", points, frame_time)
    return whole.weighted_skate(list(tracks.transpose(1, 0, 2)), floor, frame_time, height)


def physdiff(points: ArrayLike, *, floor: float = 0.0, tolerance: float = 0.005) -> PhysDiff:
    """Compute penetrate, float and skate of PhysDiff (Yuan et al. 2023), over points of the soles.

    Args:
        points: (F, n, 3) [m] in the world; vertices in the paper.
        floor: [m] its height.
        tolerance: [m] points no farther than this from the floor are on it.
    """
    tracks = _points("points", points, 1.0)
    return PhysDiff(*whole.physdiff(list(tracks.transpose(1, 0, 2)), floor, tolerance=tolerance))


def jitter(positions: ArrayLike, frame_time: float) -> float:
    """Compute the mean length of the third difference of joint positions x fps^3 [10^2 m/s^3].

    Source: Karunratanakul et al. 2024 (DNO); others divide by 10 in place of 100.

    Args:
        positions: (F, J, 3) [m] in the world.
        frame_time: [s].
    """
    total, count = whole.jerks(_points("positions", positions, frame_time))
    return total / count / frame_time**3 / 100.0 if count else 0.0


def slides(track: ArrayLike, contact: ArrayLike) -> Floats:
    """Compute how far a point slides in each of its contacts: the farthest horizontal distance from its median place.

    All frames count: leave those in which the foot lands or lifts out of `contact` if they should not.

    Examples:
        >>> track = np.zeros((6, 3))
        >>> track[3, 0] = 0.021
        >>> slides(track, [1, 1, 1, 1, 1, 0])
        array([21.])

    Args:
        track: (F, 3) [m] in the world.
        contact: (F,) where it is in contact.

    Returns:
        (C,) [mm] one a contact, in order of time.
    """
    points = _points("track", track, 1.0)
    mask = np.asarray(contact)
    if points.shape[1] != 1 or mask.shape != (len(points),):
        raise ArgumentError(f"one track (F, 3) and a mask (F,) are wanted, not {np.shape(track)} and {mask.shape}")
    return np.asarray(1000.0 * plants.slide(points[:, 0], segments(runs(mask.astype(np.bool_)))))


def _points(what: str, given: ArrayLike, frame_time: float) -> Floats:
    """Check tracks (F, n, 3); refuse other shapes, NaN and infinity, and a frame time that must be a frame rate."""
    array = np.asarray(given, dtype=np.float64)
    if array.ndim == 2:
        array = array[:, None]
    if array.ndim != 3 or array.shape[2] != 3:
        raise ArgumentError(f"{what} must be (F, n, 3), frames, points, x y z, not {np.shape(given)}")
    if not np.isfinite(array).all():
        frame = int(np.flatnonzero(~np.isfinite(array).all(axis=(1, 2)))[0])
        raise ArgumentError(f"{what}: frame {frame} is NaN or infinite")
    if not 0.0 < frame_time < 10.0:
        raise ArgumentError(f"frame_time is the time from frame to frame in seconds, not {frame_time:g}")
    return array

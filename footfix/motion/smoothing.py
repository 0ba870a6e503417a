"""Savitzky-Golay smoothing of positions and rotations, with the window in seconds.

Source: Kim & Neff §5.1 (window 0.1 s, degree 4); A. Savitzky, M. Golay, Analytical Chemistry 36 (1964).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import factorial

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, frozen
from footfix.notes import Note


@dataclass(frozen=True, kw_only=True)
class SmoothParams:
    """How curves are smoothed.

    Args:
        seconds: [s] window of the filter (K §5.1: 12 frames at 120 fps).
        degree: degree of the polynomial (K §5.1) [count].
        channels: whether to smooth the written motion, too; off, only the input of detection is smoothed.
    """

    seconds: float = 0.1
    degree: int = 4
    channels: bool = False


def window_frames(seconds: float, frame_time: float, degree: int) -> int:
    """Compute the window in frames: odd, and at least as long as the polynomial needs."""
    nearest_odd = 2 * round((seconds / frame_time - 1.0) / 2.0) + 1
    shortest = degree + 1 if degree % 2 == 0 else degree + 2
    return max(nearest_odd, shortest)


def can_smooth(seconds: float, frame_time: float, degree: int) -> bool:
    """Tell whether the window holds more frames than the polynomial has coefficients."""
    return window_frames(seconds, frame_time, degree) > degree + 1


@lru_cache(maxsize=512)
def _weights(window: int, degree: int, at: float, derivative: int) -> Floats:
    """Compute weights (window,) that evaluate the least-squares polynomial, or a derivative [1/frame^d], at a place."""
    k = np.arange(derivative, degree + 1)
    falling = np.array([factorial(n) / factorial(n - derivative) for n in k])
    row = np.zeros(degree + 1)
    row[derivative:] = falling * at ** (k - derivative)
    return frozen(row @ _fit(window, degree))


@lru_cache(maxsize=64)
def _fit(window: int, degree: int) -> Floats:
    """Compute the matrix (degree + 1, window) that gives the coefficients of the least-squares polynomial."""
    places = np.arange(window) - window // 2
    powers = np.vander(places, degree + 1, increasing=True).astype(np.float64)  # (window, degree + 1)
    return frozen(np.linalg.pinv(powers))


def savgol(
    x: Floats, frame_time: float, *, seconds: float = SmoothParams.seconds,
    degree: int = SmoothParams.degree, derivative: int = 0,
) -> Floats:  # fmt: skip
    """Apply the Savitzky-Golay filter, or a derivative of its polynomial, along the first axis.

    At both ends the polynomial of the outermost whole window is evaluated, so nothing is padded.

    Args:
        x: (F, ...) any unit.
        frame_time: [s].
        seconds: [s] window.
        degree: of the polynomial.
        derivative: 0 for the value, 1 for the speed [unit/s], 2 for the acceleration [unit/s^2].

    Returns:
        (F, ...); clips shorter than the window are filtered with the longest window that fits.
    """
    frames = len(x)
    window = window_frames(seconds, frame_time, degree)
    if frames < window:
        window = frames if frames % 2 else frames - 1
        degree = min(degree, window - 1)
    if window < 1 or degree < derivative:
        return np.array(x) if derivative == 0 else np.zeros_like(x)
    half = window // 2
    out = np.zeros_like(x)
    inner = frames - window + 1
    # A sum over the few frames of the window runs along contiguous memory; a filter library would take
    # ten times longer to import than this takes to run.
    for k, weight in enumerate(_weights(window, degree, 0.0, derivative)):
        out[half : half + inner] += weight * x[k : k + inner]
    for i in range(half):
        out[i] = np.tensordot(_weights(window, degree, i - half, derivative), x[:window], 1)
        out[-1 - i] = np.tensordot(_weights(window, degree, half - i, derivative), x[-window:], 1)
    return np.asarray(out / frame_time**derivative)


def smooth_rotations(q: Floats, frame_time: float, *, seconds: float, degree: int) -> Floats:
    """Smooth rotations (F, ..., 4), as sign-continuous quaternions and never as angles that wrap."""
    return rotation.normalize(savgol(rotation.continuous(q), frame_time, seconds=seconds, degree=degree))


def smooth_clip(clip: Clip, params: SmoothParams, frame_range: slice) -> tuple[Clip, tuple[Note, ...]]:
    """Smooth the channels of a clip, inside the motion range only.

    Frames before and after `frame_range` (a T-pose or zero lead-in) keep their numbers and do not bleed into
    the motion. Joints that stand still keep theirs, too.

    Args:
        clip: the motion.
        params: window and degree.
        frame_range: the frames that belong to the motion.

    Returns:
        The smoothed clip, and a note where the frame rate is too low for the window.
    """
    if not can_smooth(params.seconds, clip.frame_time, params.degree):
        text = (
            f"at {clip.fps:.4g} fps a window of {params.seconds:g} s holds no more frames than the polynomial "
            "needs, so nothing was smoothed; a longer window smooths (smooth.seconds)"
        )
        return clip, (Note("smoothing-too-short", text),)
    positions, rotations = clip.positions.copy(order="K"), clip.rotations.copy(order="K")
    for joint in range(len(clip.skeleton)):
        place, turn = clip.positions[frame_range, joint], clip.rotations[frame_range, joint]
        if np.any(place != place[:1]):
            positions[frame_range, joint] = savgol(place, clip.frame_time, seconds=params.seconds, degree=params.degree)
        if np.any(turn != turn[:1]):
            rotations[frame_range, joint] = smooth_rotations(
                turn, clip.frame_time, seconds=params.seconds, degree=params.degree
            )
    return replace(clip, positions=positions, rotations=rotations), ()

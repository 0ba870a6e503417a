"""Smoothing: polynomials of each window are the oracle, polynomials are fixed points, lead-ins do not bleed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footfix.motion import rotation
from footfix.motion.clip import Clip, Skeleton
from footfix.motion.smoothing import SmoothParams, can_smooth, savgol, smooth_clip, window_frames

RNG = np.random.default_rng(11)


@pytest.mark.parametrize("derivative", [0, 1, 2])
@pytest.mark.parametrize("fps", [60, 120, 240])
def test_savgol_is_the_polynomial_of_each_window(derivative: int, fps: int) -> None:
    """Fitted frame by frame; over the ends lies the polynomial of the first or last whole window."""
    x = RNG.normal(size=(100, 2, 3))
    ours = savgol(x, 1 / fps, seconds=0.1, degree=4, derivative=derivative)
    window = window_frames(0.1, 1 / fps, 4)
    for frame in range(len(x)):
        start = min(max(frame - window // 2, 0), len(x) - window)
        at = np.arange(start, start + window) - frame
        fitted = np.polyfit(at / fps, x[start : start + window].reshape(window, -1), 4)
        value = (1.0, 1.0, 2.0)[derivative] * fitted[-1 - derivative].reshape(2, 3)
        assert np.allclose(ours[frame], value, rtol=1e-6, atol=1e-8 * fps**derivative)


def test_a_polynomial_of_the_degree_is_left_alone() -> None:
    t = np.linspace(-1, 1, 80)[:, None]
    x = t**4 - 0.3 * t**3 + 2 * t
    assert np.allclose(savgol(x, 0.01, seconds=0.15, degree=4), x, atol=1e-12)


@pytest.mark.parametrize("frames", [1, 2, 3, 4, 5, 6])
def test_short_clips_keep_their_length(frames: int) -> None:
    x = RNG.normal(size=(frames, 3))
    for derivative in (0, 1, 2):
        y = savgol(x, 1 / 120, seconds=0.1, degree=4, derivative=derivative)
        assert y.shape == x.shape and np.all(np.isfinite(y))


def test_window_is_odd_and_long_enough() -> None:
    assert window_frames(0.1, 1 / 120, 4) == 13 or window_frames(0.1, 1 / 120, 4) == 11
    assert window_frames(0.1, 1 / 30, 4) == 5 and not can_smooth(0.1, 1 / 30, 4)
    assert all(window_frames(s, 1 / 60, d) % 2 == 1 for s in (0.01, 0.1, 0.33) for d in (2, 3, 4, 5))


def noisy_clip() -> Clip:
    t = np.arange(300) / 120
    turn = Rotation.from_euler("y", (8.0 * t + RNG.normal(0, 0.01, 300))[:, None]).as_quat()
    turn *= np.where(RNG.random(300) < 0.5, -1, 1)[:, None]
    turn[0] = [0, 0, 0, 1]
    still = np.tile([0.0, 0.0, 0.0, 1.0], (300, 1))
    positions = np.zeros((300, 2, 3))
    positions[1:, 0] = [5.0, 0.0, 0.0]
    skeleton = Skeleton(("root", "still"), np.array([-1, 0]), np.zeros((2, 3)))
    return Clip(skeleton, positions, np.stack([turn, still], 1), 1 / 120)


def test_a_lead_in_is_not_smeared_and_still_joints_keep_their_numbers() -> None:
    clip = noisy_clip()
    smooth, notes = smooth_clip(clip, SmoothParams(channels=True), slice(1, None))
    assert not notes
    assert np.array_equal(smooth.positions, clip.positions)
    assert np.array_equal(smooth.rotations[0], clip.rotations[0])
    assert np.array_equal(smooth.rotations[:, 1], clip.rotations[:, 1])

    def roughness(each: Clip) -> float:
        steps = rotation.multiply(rotation.inverse(each.rotations[1:-1, 0]), each.rotations[2:, 0])
        return float(np.std(rotation.angle(steps)))

    assert roughness(smooth) < 0.5 * roughness(clip)


def test_it_says_when_the_rate_is_too_low() -> None:
    clip = noisy_clip()
    slow = Clip(clip.skeleton, clip.positions, clip.rotations, 1 / 30)
    same, notes = smooth_clip(slow, SmoothParams(channels=True), slice(1, None))
    assert same is slow and notes[0].id == "smoothing-too-short"

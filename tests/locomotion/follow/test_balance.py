"""Masses, and a zero-moment point held against mechanics that are known."""

from __future__ import annotations

import numpy as np
import pytest
from walks import rig_of, walk

from footfix.locomotion.follow.balance import (
    GRAVITY,
    acceleration,
    arms_of,
    corrected_lean,
    lean_for,
    neck_of,
    segments,
    zero_moment_point,
)
from footfix.motion.clip import Clip, Floats


def test_the_parts_of_a_body_weigh_a_body() -> None:
    made = walk()
    skeleton, rig = made.clip.skeleton, rig_of(made)
    body = segments(skeleton, rig)
    assert sum(each.mass for each in body) == pytest.approx(1.0)
    assert all(each.mass > 0.0 for each in body)
    assert len(arms_of(skeleton, rig)) == 2
    neck = neck_of(skeleton, rig)
    assert neck is not None
    assert "Neck" in skeleton.names[neck]


def test_the_difference_is_exact_for_what_falls() -> None:
    t = np.arange(240)[:, None] / 120.0
    track = np.concatenate([3.0 * t, 2.0 * t - 0.5 * GRAVITY * t**2, t**3], axis=1)
    found = acceleration(track, 1.0 / 120.0)[40:-40]
    assert np.allclose(found, np.concatenate([0.0 * t, 0.0 * t - GRAVITY, 6.0 * t], axis=1)[40:-40], atol=1e-8)


def still(place: Floats) -> Clip:
    """The walker's first pose, its root at places (F, 3)."""
    made = walk()
    first = made.clip.frames(np.zeros(len(place), np.intp))
    return first.with_joints({0: first.position(0) * [0.0, 1.0, 0.0] + place}, {})


def test_the_zero_moment_point_of_who_stands_is_below_the_centre_and_lags_who_speeds_up() -> None:
    rig = rig_of(walk())
    body = segments(walk().clip.skeleton, rig)
    t = np.arange(180) / 60.0
    at_rest, press = zero_moment_point(still(np.zeros((180, 3))), rig, body)
    assert np.allclose(at_rest, at_rest[0], atol=1e-9)
    assert np.allclose(press, GRAVITY)
    faster, _ = zero_moment_point(still(np.stack([0.5 * t**2, 0.0 * t, 0.0 * t], axis=1)), rig, body)
    lag = (faster[:, 0] - 0.5 * t**2 - at_rest[:, 0])[40:-40]
    height = -float(lag.mean()) * GRAVITY  # of the centre of mass, by x'' = 1 m/s^2
    assert np.allclose(lag, lag[0], atol=1e-6)
    assert 0.85 < height < 1.15


def test_who_walks_a_circle_leans_by_its_centripetal_acceleration() -> None:
    lean = lean_for(np.full(300, 1.5), np.full(300, 0.5), 60.0)
    assert np.allclose(lean, np.arctan(1.5**2 * 0.5 / GRAVITY))
    assert not np.any(lean_for(np.full(300, 1.5), np.zeros(300), 60.0))


def test_one_newton_step_takes_the_mean_offset_away_but_no_more_than_half_a_degree() -> None:
    lean = np.full(400, 0.05)
    assert np.allclose(corrected_lean(lean, np.full(400, -0.004), 1.0, 60.0), 0.054)
    assert np.all(corrected_lean(lean, np.full(400, -0.4), 1.0, 60.0) <= 0.05 + np.radians(0.5))
    assert not np.any(corrected_lean(0.0 * lean, np.full(400, 0.01), 1.0, 60.0))

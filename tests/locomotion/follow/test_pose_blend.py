"""Two walks mixed: rotations keep to one side, legs are brought in step."""

from __future__ import annotations

import numpy as np
import pytest

from footfix.locomotion.follow.key_times import in_step
from footfix.locomotion.follow.pose_blend import mixed
from footfix.motion import rotation
from footfix.motion.clip import Floats

Z = np.array([0.0, 0.0, 1.0])


def about_z(degrees: Floats) -> Floats:
    return rotation.from_axis_angle(Z, np.radians(degrees))


def test_rotations_mixed_half_a_turn_apart_do_not_change_sides() -> None:
    apart = np.linspace(150.0, 200.0, 51)  # the shorter way changes sides at 180
    seen = [np.ones(51, dtype=np.bool_)] * 2
    out = mixed(rotation.identity((51,)), about_z(apart), seen, np.full(51, 0.5), turn=True)
    assert np.allclose(rotation.angle(rotation.multiply(rotation.inverse(about_z(0.5 * apart)), out)), 0.0, atol=1e-7)


def test_the_numbers_of_one_walk_stay_where_only_that_counts() -> None:
    weight = np.array([0.0, 0.0, 0.25, 1.0, 1.0])
    one, two = np.arange(15.0).reshape(5, 3), 100.0 + np.arange(15.0).reshape(5, 3)
    seen = [weight < 1.0, weight > 0.0]
    out = mixed(one[seen[0]], two[seen[1]], seen, weight)
    assert np.array_equal(out[:2], one[:2])
    assert np.array_equal(out[3:], two[3:])
    assert np.allclose(out[2], one[2] + 25.0)


@pytest.mark.parametrize("own", [0.35, 0.5, 0.62])
def test_a_leg_in_step_strikes_and_lifts_as_asked(own: float) -> None:
    strike, stands = 0.2, 0.5
    events = np.array([strike, strike + 0.5 * stands, strike + stands, strike + 1.0, strike + 2.0 + stands])
    there = in_step(events, strike, np.full(5, stands), own)
    assert np.allclose(there, [strike, strike + 0.5 * own, strike + own, strike + 1.0, strike + 2.0 + own])
    time = np.linspace(-2.0, 3.0, 1001)
    moved = in_step(time, strike, np.full(1001, stands), own)
    assert np.all(np.diff(moved) > 0.0)
    assert np.allclose(in_step(moved, strike, np.full(1001, own), stands), time)  # there and back
    assert np.allclose(in_step(time, strike, np.full(1001, own), own), time)

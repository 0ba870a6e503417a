"""Travel: a turn and a shift over the floor, shared out along an arc, taken out and put back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from walks import rig_of, walk

from footfix.locomotion.loop.root_motion import (
    Travel,
    carrier,
    put_in,
    root_in_world,
    straightened,
    taken_out,
    without_drift,
)
from footfix.motion import rotation
from footfix.motion.clip import Clip

TURNING, STRAIGHT = Travel(0.8, 1.2, -0.3), Travel(0.0, 1.2, -0.3)


@pytest.mark.parametrize("travel", [TURNING, STRAIGHT, Travel(-3.0, 0.1, 0.2)])
def test_going_back_undoes_going(travel: Travel) -> None:
    points = np.random.default_rng(0).normal(size=(5, 3))
    assert np.allclose(travel.places_back(travel.places(points)), points, atol=1e-12)
    assert np.allclose(travel.places(points)[:, 1], points[:, 1])


@pytest.mark.parametrize("travel", [TURNING, STRAIGHT])
def test_two_halves_are_the_whole_and_no_part_is_nothing(travel: Travel) -> None:
    turns, shifts = travel.share(np.array([0.0, 0.5, 1.0]))
    half = Travel(0.5 * travel.yaw, shifts[1, 0], shifts[1, 2])
    points = np.random.default_rng(1).normal(size=(4, 3))
    assert np.allclose(half.places(half.places(points)), travel.places(points), atol=1e-12)
    assert np.allclose(rotation.rotate(turns[2], points) + shifts[2], travel.places(points), atol=1e-12)
    assert np.allclose(shifts[0], 0.0)


def test_a_quarter_of_a_circle_walked_straight_is_as_long_as_its_arc() -> None:
    quarter = Travel(np.pi / 2, 2.0, 2.0)  # to the left, from heading +z, on a circle of 2 m: half pi times 2 m
    straight = quarter.straight()
    assert np.hypot(straight.x, straight.z) == pytest.approx(np.pi)
    assert (straight.x, straight.yaw) == (pytest.approx(0.0, abs=1e-12), 0.0)
    assert straight.z > 0.0


def circling(travel: Travel) -> Clip:
    """A round of a cycle that travels evenly, with a sway that is the same at both ends."""
    clip = walk().clip.frames(slice(0, 41))
    sway = np.sin(np.linspace(0.0, 2.0 * np.pi, 41))[:, None] * [0.03, 0.01, 0.0] + [0.4, 0.9, 1.0]
    turns, shifts = travel.share(np.linspace(0.0, 1.0, 41))
    lean = rotation.from_rotation_vector(np.sin(np.linspace(0.0, 2.0 * np.pi, 41))[:, None] * [0.0, 0.1, 0.05])
    places = clip.positions.copy()
    places[:, 0] = rotation.rotate(turns, sway) + shifts
    rotations = clip.rotations.copy()
    rotations[:, 0] = rotation.multiply(turns, lean)
    return replace(clip, positions=places, rotations=rotations)


@pytest.mark.parametrize("travel", [TURNING, STRAIGHT])
def test_on_the_spot_the_last_frame_is_the_first_and_putting_travel_in_gives_the_walk_back(travel: Travel) -> None:
    clip = circling(travel)
    spot = taken_out(clip, 0, travel)
    place, turn = root_in_world(spot, 0)
    assert np.allclose(place[-1], place[0], atol=1e-12)
    assert rotation.angle(rotation.multiply(turn[-1], rotation.inverse(turn[0]))) < 1e-9
    again = put_in(spot, 0, travel)
    assert np.allclose(again.positions, clip.positions, atol=1e-12)
    assert np.abs(np.einsum("fi,fi->f", again.rotations[:, 0], clip.rotations[:, 0])).min() > 1.0 - 1e-12


def test_straightened_it_goes_as_far_and_turns_no_more() -> None:
    clip, straight = straightened(circling(TURNING), 0, TURNING)
    place, turn = root_in_world(clip, 0)
    assert np.allclose(place[-1], straight.places(place[0]), atol=1e-12)
    assert rotation.angle(rotation.multiply(turn[-1], rotation.inverse(turn[0]))) < 1e-9
    arc = np.linalg.norm(np.diff(root_in_world(circling(Travel(0.8, 1.2, -0.3)), 0)[0][:, [0, 2]], axis=0), axis=1)
    line = np.linalg.norm(np.diff(place[:, [0, 2]], axis=0), axis=1)
    assert line.sum() == pytest.approx(arc.sum(), rel=0.02)


def test_what_moves_above_the_root_carries_the_figure() -> None:
    made = walk()
    assert carrier(made.clip, rig_of(made)) == 0
    hips = replace(rig_of(made), root=1)
    assert carrier(made.clip, hips) == 0
    still = made.clip.with_joints({0: np.zeros((len(made.clip), 3))}, {0: rotation.identity((len(made.clip),))})
    assert carrier(still, hips) == 1


@pytest.mark.parametrize("drift", [Travel(0.03, 0.02, -0.05), Travel(0.0, 0.0, 0.04)])
def test_without_its_drift_a_cycle_ends_where_it_began_and_is_moved_by_half_of_it(drift: Travel) -> None:
    clip = circling(drift)
    root = carrier(clip, rig_of(walk()))
    captured, turned = root_in_world(clip, root)
    place, turn = root_in_world(without_drift(clip, root, drift), root)
    assert np.allclose(place[-1], place[0], atol=1e-12)
    assert rotation.angle(rotation.multiply(turn[-1], rotation.inverse(turn[0]))) < 1e-7
    assert np.allclose(place[20], captured[20], atol=1e-12)
    whole = np.linalg.norm(drift.places(captured[0]) - captured[0])
    assert np.linalg.norm(place - captured, axis=1).max() <= 0.501 * whole
    angles = rotation.angle(rotation.multiply(turn, rotation.inverse(turned)))
    assert angles.max() == pytest.approx(0.5 * drift.yaw, abs=1e-7)

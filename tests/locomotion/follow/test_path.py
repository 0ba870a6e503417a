"""Paths: lengths and curvatures of shapes that are known, corners that are rounded."""

from __future__ import annotations

import numpy as np
import pytest

from footfix.errors import ArgumentError
from footfix.locomotion.follow.path import make_path
from footfix.motion.clip import Floats


def circle(radius: float, points: int = 200) -> Floats:
    turn = np.linspace(0.0, 2.0 * np.pi, points + 1)
    return np.stack([radius - radius * np.cos(turn), radius * np.sin(turn)], axis=1)


@pytest.mark.parametrize("radius", [8.0, 2.0, 1.0])
def test_a_circle_has_its_length_curvature_and_turn(radius: float) -> None:
    path = make_path(circle(radius))
    s = np.linspace(0.0, 2.0 * path.length, 500)
    assert path.closed
    assert path.length == pytest.approx(2.0 * np.pi * radius, rel=5e-4)
    assert np.allclose(path.curvature(s), 1.0 / radius, rtol=2e-3)  # to the left
    assert np.allclose(np.hypot(*(path.position(s) - [radius, 0.0]).T), radius, atol=1e-3)
    assert np.allclose(path.heading(s), s / path.length * 2.0 * np.pi, atol=1e-3)


def test_arc_length_is_arc_length() -> None:
    ahead = np.linspace(0.0, 12.0, 60)
    path = make_path(np.stack([np.sin(ahead), ahead], axis=1))
    s = np.linspace(0.0, path.length, 20001)
    steps = np.linalg.norm(np.diff(path.position(s), axis=0), axis=1)
    assert np.allclose(steps, s[1], rtol=1e-4)
    heading = np.arctan2(*np.diff(path.position(s), axis=0).T)
    assert np.allclose(heading, path.heading(0.5 * (s[1:] + s[:-1])), atol=1e-3)
    assert np.allclose(np.gradient(path.heading(s), s)[5:-5], path.curvature(s)[5:-5], atol=0.02)


def test_few_points_of_a_circle_are_a_circle_and_corners_are_not() -> None:
    around = make_path(circle(2.0, points=12))
    assert np.ptp(around.curvature(np.linspace(0.0, around.length, 300))) < 0.03
    square = make_path(np.array([[0.0, 0.0], [0.0, 5.0], [5.0, 5.0]]), sharpest=2.0)
    bent = np.abs(square.curvature(np.linspace(0.0, square.length, 1000)))
    assert 1.0 < bent.max() <= 2.1
    assert square.position(np.array(1.0)) == pytest.approx([0.0, 1.0], abs=1e-9)  # what is straight stays
    assert square.position(np.array(square.length)) == pytest.approx([5.0, 5.0], abs=1e-9)
    assert [note.id for note in square.notes] == ["kinks-rounded"]


@pytest.mark.parametrize("back", [[0.0, 0.0], [0.05, 0.0], [3.0, 0.0]])
def test_who_has_to_turn_back_is_led_round(back: list[float]) -> None:
    path = make_path(np.array([[0.0, 0.0], [0.0, 5.0], back]), sharpest=1.5)
    s = np.linspace(0.0, path.length, 4001)
    assert np.abs(path.curvature(s)).max() <= 1.05 * 1.5
    assert np.abs(np.diff(path.heading(s))).max() <= 1.05 * 1.5 * s[1]  # no cusp, either
    assert path.position(np.array(path.length)) == pytest.approx(back, abs=0.15)
    assert np.linalg.norm(path.position(s) - [0.0, 5.0], axis=1).min() < 0.7
    assert [note.id for note in path.notes] == ["kinks-rounded"]


def test_a_straight_path_is_straight_to_the_last_bit() -> None:
    path = make_path(np.array([[1.0, 2.0], [1.0, 3.0], [1.0, 7.0]]))
    s = np.array([-1.0, 0.0, 2.5, 9.0])
    assert path.straight
    assert not np.any(path.curvature(s))
    assert not np.any(path.heading(s))
    assert np.array_equal(path.position(s), np.stack([np.ones(4), 2.0 + s], axis=1))


@pytest.mark.parametrize("points", [[[0.0, 0.0]], [[0.0, 1e6]] * 2, [[0.0, np.nan], [1.0, 1.0]]])
def test_what_is_no_path_is_refused(points: list[list[float]]) -> None:
    with pytest.raises(ArgumentError):
        make_path(np.array(points))

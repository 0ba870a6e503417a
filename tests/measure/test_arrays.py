"""Measures of bare arrays: the published ones over points, slides of a track, and what is refused in words."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from footfix.errors import ArgumentError
from footfix.measure import arrays, clip

DT = 0.05  # [s]
POINTS = np.cumsum(np.random.default_rng(3).normal(size=(60, 3, 3)) * [0.02, 0.01, 0.02], axis=0)  # (F, n, 3) [m]
TRACKS = list(POINTS.transpose(1, 0, 2))


def test_arrays_are_measured_as_clips_are() -> None:
    assert arrays.skating_ratio(POINTS, DT) == clip.skating_ratio(TRACKS, [0.0] * 3, DT)  # as published
    assert arrays.skating_ratio(POINTS, DT, rest=0.01) == clip.skating_ratio(TRACKS, [0.01] * 3, DT) > 0.0
    assert arrays.skating_ratio(POINTS, DT, rest=[0.0, 9.0, -9.0]) == clip.skating_ratio(TRACKS, [0.0, 9.0, -9.0], DT)
    assert arrays.weighted_skate(POINTS, DT, floor=0.01, height=0.05) == clip.weighted_skate(TRACKS, 0.01, DT, 0.05) > 0
    assert tuple(arrays.physdiff(POINTS, floor=-0.02, tolerance=0.01)) == clip.physdiff(TRACKS, -0.02, tolerance=0.01)


def test_jitter_of_a_cubic_is_its_third_derivative() -> None:
    t = DT * np.arange(9)
    cubic = np.zeros((9, 2, 3))
    cubic[:, 0, 1] = 50.0 * t**3  # 300 m/s^3 of one joint in two
    assert arrays.jitter(cubic, DT) == pytest.approx(1.5)
    assert arrays.jitter(cubic[:4], DT) == pytest.approx(1.5)
    assert arrays.jitter(cubic[:3], DT) == 0.0


def test_each_contact_of_a_track_slides_on_its_own() -> None:
    track = np.zeros((9, 3))
    track[2], track[6:8] = [0.003, 0.5, 0.004], [[0.01, 0.0, 0.0], [0.05, 0.0, 0.0]]  # heights don't count
    assert arrays.slides(track, [0, 1, 1, 1, 0, 1, 1, 1, 1]) == pytest.approx([5.0, 45.0])
    assert arrays.slides(track, np.zeros(9)).shape == (0,)


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "a wrong shape": (lambda: arrays.jitter(np.zeros((4, 3, 2)), DT), r"\(F, n, 3\).*not \(4, 3, 2\)"),
    "four numbers a point": (lambda: arrays.jitter(np.zeros((4, 2, 1, 3)), DT), r"positions must be"),
    "a number that is none": (lambda: arrays.physdiff(np.diag([0.0, 0.0, np.nan])), "frame 2"),
    "a rate": (lambda: arrays.weighted_skate(POINTS, 60.0), "not 60"),
    "ten seconds a frame": (lambda: arrays.weighted_skate(POINTS, 10.0), "in seconds"),
    "no time": (lambda: arrays.weighted_skate(POINTS, 0.0), "in seconds"),
    "two tracks": (lambda: arrays.slides(POINTS[:, :2], np.ones(60)), "one track"),
    "a mask of another length": (lambda: arrays.slides(POINTS[:, 0], np.ones(59)), r"\(59,\)"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_no_track_is_refused(what: str) -> None:
    call, words = WRONG[what]
    with pytest.raises(ArgumentError, match=words):
        call()


def test_physdiffs_tolerance_is_half_a_centimetre() -> None:
    for height, floating, penetrating in ((0.004, 0.0, 0.0), (0.006, 6.0, 0.0), (-0.004, 0.0, 0.0), (-0.006, 0.0, 6.0)):
        found = arrays.physdiff(np.full((5, 1, 3), [0.0, height, 0.0]))
        assert (found.float_mm, found.penetrate_mm) == (pytest.approx(floating), pytest.approx(penetrating))


def test_the_skate_of_two_points_on_the_floor_is_their_mean_and_a_raised_one_does_not_count() -> None:
    points = np.zeros((5, 3, 3))
    points[:, 0, 0], points[:, 1, 0], points[:, 2, 0] = (step * np.arange(5) for step in (0.004, 0.010, 0.5))
    points[:, 2, 1] = 0.2
    assert arrays.physdiff(points).skate_mm == pytest.approx(7.0)
    points[2:, 1, 1] = 0.2  # from the second step on only the first is left
    assert arrays.physdiff(points).skate_mm == pytest.approx((7.0 + 3 * 4.0) / 4)

"""What tells when feet land and leave: it finds the moment, wherever it is looked for, and keeps the order."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footfix.detect.evidence import STEP, Sampled
from footfix.detect.network import FLAT, HEEL, TOE
from footfix.detect.timing import SHARE, Line, Timing, braking, seen, timed, tipping
from footfix.detect.tracks import FootTracks, Tracks
from footfix.detect.viterbi import Stretch
from footfix.detect.weights import timing
from footfix.motion.clip import Floats

LINE = Line((-1, 0, 1), np.array([0.0, -1.0, 0.0]), 0.0, 3.0)  # of a curve that rises by one a step: to its zero


def sampled(pitch: Floats, heading: float = 0.0, size: float = 1.0) -> Sampled:
    """A foot that is turned up by some angles [rad], in any direction and size, while it moves along."""
    forward = np.array([np.sin(heading), np.cos(heading)])
    along = np.stack([np.cos(pitch) * forward[0], np.sin(pitch), np.cos(pitch) * forward[1]], axis=1)
    heel = size * np.cumsum(np.abs(np.sin(np.arange(len(pitch)) / 9.0)))[:, None] * np.array([0.1, 0.02, 0.2])
    foot = FootTracks("left", heel, heel, heel, heel + size * 0.25 * along)
    level = np.tile(forward, (len(pitch), 1))
    return Sampled(Tracks(heel, (foot,), 1.0, STEP), (0,), ((level, level[:, ::-1]),), 0.0)


def test_tipping_is_the_second_derivative_of_the_pitch() -> None:
    times = np.arange(200) * STEP
    tips = tipping(sampled(-0.7 + 0.5 * np.sin(5.0 * times)), 0)
    assert tips[5:-5] == pytest.approx(-12.5 * np.sin(5.0 * times)[5:-5], abs=0.1)


def test_tipping_knows_no_place_heading_or_size() -> None:
    pitch = -1.0 + np.random.default_rng(0).normal(size=120).cumsum() * 0.05
    one, other = tipping(sampled(pitch), 0), tipping(sampled(pitch, heading=2.0, size=3.0), 0)
    assert other == pytest.approx(one, abs=1e-6)


def test_tipping_goes_through_a_foot_that_points_straight_down() -> None:
    times = np.arange(200) * STEP
    assert np.abs(tipping(sampled(-1.0 - 0.8 * times), 0)).max() < 1e-6


def test_braking_is_the_upward_acceleration_of_the_ankle() -> None:
    still = sampled(np.zeros(100))
    ankle = np.outer((np.arange(100) * STEP) ** 2, [3.0, 7.0, 1.0])
    moved = replace(still, tracks=replace(still.tracks, feet=(replace(still.tracks.feet[0], ankle=ankle),)))
    assert braking(moved, 0) == pytest.approx(np.full(100, 14.0))


@given(st.floats(30.0, 60.0), st.floats(-2.5, 2.5))
def test_the_same_moment_is_found_from_before_and_after(happens: float, away: float) -> None:
    assert LINE.finds(np.arange(100.0) - happens, happens + away) == pytest.approx(happens)


@pytest.mark.parametrize("about", [0.5, 98.7])
def test_at_the_ends_of_a_clip_nothing_is_moved(about: float) -> None:
    assert LINE.finds(np.arange(100.0) - 50.0, about) == about


@pytest.mark.parametrize(("about", "most", "found"), [(40.0, 9.0, 43.0), (60.0, 9.0, 57.0), (40.0, 1.5, 41.5)])
def test_nothing_is_moved_farther_than_the_path_may_be_wrong(about: float, most: float, found: float) -> None:
    assert LINE.finds(np.arange(100.0) - 50.0, about, most) == found


def test_a_line_too_flat_comes_nearer_with_each_look() -> None:
    half = replace(LINE, weights=0.5 * LINE.weights)
    assert half.finds(np.arange(100.0) - 50.0, 52.0) == pytest.approx(50.5)


@given(st.integers(0, 10_000))
def test_stretches_keep_their_order_and_plants_move_by_a_share_of_their_time(seed: int) -> None:
    random = np.random.default_rng(seed)
    wild = sampled(-1.0 + random.normal(0.0, 0.3, 300).cumsum() * 0.2)
    edges = [-np.inf, *np.sort(random.uniform(5.0, 295.0, 10)), np.inf]
    every = [Stretch(a, b, part) for (a, b), part in zip(pairwise(edges), 4 * (HEEL, FLAT, TOE), strict=False)]
    plants = [every[0:2], every[3:6], every[7:8], every[9:11]]  # what lies between them is a swing
    found = [stretch for plant in plants for stretch in plant]
    after = timed(found, wild, 0, timing())
    assert [stretch.state for stretch in after] == [stretch.state for stretch in found]
    assert all(one.end <= other.start for one, other in pairwise(after))
    assert all(stretch.start <= stretch.end for stretch in after)
    for plant in plants:
        moved = after[found.index(plant[0]) : found.index(plant[-1]) + 1]
        assert [s.end for s in moved[:-1]] == [s.end for s in plant[:-1]]
        most = SHARE * (plant[-1].end - plant[0].start) + 1e-9
        for one, other in ((plant[0].start, moved[0].start), (plant[-1].end, moved[-1].end)):
            assert one == other or abs(one - other) <= most


def test_a_plant_starts_when_the_foot_is_braked_and_ends_when_it_tips() -> None:
    pitch = np.arange(100.0) ** 3 / 6.0 * STEP**2 - 29.0 * np.arange(100.0) ** 2 / 2.0 * STEP**2
    foot = sampled(pitch)
    ankle = np.zeros((100, 3))
    ankle[:, 1] = STEP**2 * ((np.arange(100.0) - 10.0) ** 3 / 6.0)
    foot = replace(foot, tracks=replace(foot.tracks, feet=(replace(foot.tracks.feet[0], ankle=ankle),)))
    (plant,) = timed([Stretch(9.7, 29.5, FLAT)], foot, 0, Timing(LINE, LINE))
    assert plant == (pytest.approx(10.0), pytest.approx(29.0), FLAT)


def test_what_the_clip_cuts_stays_cut() -> None:
    cut = [Stretch(-np.inf, np.inf, FLAT)]
    assert timed(cut, sampled(np.zeros(100)), 0, timing()) == cut
    assert timed([], sampled(np.zeros(100)), 0, timing()) == []


def test_a_curve_is_seen_between_its_steps() -> None:
    assert seen(np.arange(10.0) ** 2, np.array([4.5]), (-1, 0, 1)).tolist() == [[12.5, 20.5, 30.5]]
    assert seen(np.arange(10.0) ** 2, np.array([8.0]), (-8, 0, 1)).tolist() == [[0.0, 64.0, 81.0]]  # both its ends

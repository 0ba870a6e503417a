"""What tells when a foot leaves: it finds where a push ends, wherever it is looked for, and keeps the order."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footfix.detect.evidence import STEP, Sampled
from footfix.detect.fitted import LEAVING
from footfix.detect.leaving import FARTHEST, SHARE, Leaving, seen, timed, tipping
from footfix.detect.network import FLAT, HEEL, TOE
from footfix.detect.path import Stretch
from footfix.detect.tracks import Foot, Tracks
from footfix.motion.clip import Floats

LINE = Leaving((-1, 0, 1), np.array([0.0, -1.0, 0.0]), 0.0)  # of a curve that rises by one a step: to its zero


def sampled(pitch: Floats, heading: float = 0.0, size: float = 1.0) -> Sampled:
    """A foot that is turned up by some angles [rad], in any direction and size, while it moves along."""
    forward = np.array([np.sin(heading), np.cos(heading)])
    along = np.stack([np.cos(pitch) * forward[0], np.sin(pitch), np.cos(pitch) * forward[1]], axis=1)
    heel = size * np.cumsum(np.abs(np.sin(np.arange(len(pitch)) / 9.0)))[:, None] * np.array([0.1, 0.02, 0.2])
    foot = Foot("left", heel, heel, heel, heel + size * 0.25 * along)
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


@given(st.floats(30.0, 60.0), st.floats(-2.5, 2.5))
def test_the_same_moment_is_found_from_before_and_after(leaves: float, away: float) -> None:
    tips = np.arange(100.0) - leaves
    assert LINE.leaves(tips, leaves + away, FARTHEST) == pytest.approx(leaves)
    found = timed([Stretch(leaves + away - 90.0, leaves + away, FLAT)], tips, LINE)
    assert found[0].end == pytest.approx(leaves)


@pytest.mark.parametrize("about", [0.5, 98.7])
def test_at_the_ends_of_a_clip_nothing_is_moved(about: float) -> None:
    assert LINE.leaves(np.arange(100.0) - 50.0, about, FARTHEST) == about


@given(st.integers(0, 10_000))
def test_stretches_keep_their_order_and_ends_move_by_a_share_of_the_plant(seed: int) -> None:
    random = np.random.default_rng(seed)
    tips = random.normal(0.0, 200.0, 300)
    edges = np.sort(random.uniform(5.0, 295.0, 12))
    found = [Stretch(a, b, part) for a, b, part in zip(edges[:-1], edges[1:], 4 * (HEEL, FLAT, TOE), strict=False)]
    found = [stretch for k, stretch in enumerate(found) if k % 4 != 3]  # every fourth is a swing
    after = timed(found, tips, LEAVING)
    assert [(s.start, s.state) for s in after] == [(s.start, s.state) for s in found]
    assert all(s.start <= s.end <= following.start for s, following in pairwise(after))
    landed = found[0].start
    for one, other, following in zip(found, after, [*found[1:], None], strict=True):
        farthest = min(FARTHEST, SHARE * (one.end - landed))
        touching = following is not None and following.start == one.end
        assert abs(other.end - one.end) <= (0.0 if touching else farthest + 1e-9)
        if following is not None and not touching:
            landed = following.start


def test_what_the_clip_cuts_stays_cut() -> None:
    cut = [Stretch(-np.inf, 40.0, FLAT), Stretch(60.0, np.inf, FLAT)]
    first, last = timed(cut, np.arange(100.0) - 42.0, LINE)
    assert (first.start, first.end) == (-np.inf, pytest.approx(42.0))
    assert last == cut[1]
    assert timed([], np.zeros(10), LINE) == []


def test_a_curve_is_seen_between_its_steps() -> None:
    assert seen(np.arange(10.0) ** 2, np.array([4.5]), (-1, 0, 1)).tolist() == [[12.5, 20.5, 30.5]]


def test_a_stiffer_push_is_no_other_moment() -> None:
    # a line without a bias that finds a zero finds it at any scale from nearby, though not in one look
    tips = np.arange(100.0) - 50.0
    half = replace(LINE, weights=0.5 * LINE.weights)
    assert abs(half.leaves(tips, 52.0, FARTHEST) - 50.0) == pytest.approx(0.5)

"""A contact takes in the last of the way that leads to it, as long as the foot looks planted there, and no more."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from footfix.detect.settling import SettlingParams, settled
from footfix.motion.clip import Bools, Floats

FRAMES, FRAME_TIME = 40, 0.01
PARAMS = SettlingParams(farthest=0.03, share=0.35, within=0.05)


def down(*spans: tuple[int, int]) -> Bools:
    out = np.zeros(FRAMES, dtype=np.bool_)
    for start, end in spans:
        out[start:end] = True
    return out


def going(step: float, *, until: int = 20) -> Floats:
    """(F, 2) a foot that goes so far a frame, until it rests."""
    at = np.minimum(np.arange(FRAMES), until) * step
    return np.stack([0.6 * at, 0.8 * at], axis=1)


def held(place: Floats, part: Bools) -> list[int]:
    """The frames that are held besides; told backwards they are the same."""
    looks = np.ones_like(part)
    found = settled(part, looks, place, FRAME_TIME, PARAMS)
    assert np.all(found >= part)
    assert_array_equal(settled(part[::-1], looks, place[::-1], FRAME_TIME, PARAMS)[::-1], found)
    return np.flatnonzero(found & ~part).tolist()


@pytest.mark.parametrize(("step", "first"), [(0.02, 19), (0.0149, 18), (0.001, 15), (0.5, 20)])
def test_a_landing_is_held_over_the_last_of_its_way_and_not_for_long(step: float, first: int) -> None:
    assert held(going(step), down((20, 40))) == list(range(first, 20))


def test_of_a_short_step_no_more_is_held_than_its_share() -> None:
    # ten frames from one rest to the other: 35 % of the way at either end are three and a half
    place = np.clip(np.arange(FRAMES) - 10, 0, 10)[:, None] * np.array([[0.006, 0.0]])
    assert held(place, down((0, 11), (20, 40))) == [11, 12, 13, 17, 18, 19]


def test_at_the_start_of_a_clip_the_way_seen_so_far_counts() -> None:
    assert held(going(0.006, until=2), down((2, 40))) == []
    assert held(going(0.006, until=3), down((3, 40))) == [2]


def test_only_frames_are_held_in_which_the_foot_looks_planted() -> None:
    part, looks = down((20, 40)), down((0, 18), (19, 40))
    found = settled(part, looks, going(0.001), FRAME_TIME, PARAMS)
    assert_array_equal(found, down((19, 40)))


def test_a_foot_that_is_never_down_or_always_stays_so() -> None:
    for part in (down(), down((0, FRAMES))):
        assert held(going(0.01), part) == []

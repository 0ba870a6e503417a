"""Measures: against definitions written out the slow way, and figures that can be worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from walker import make
from walker_plan import Gait

from footfix.measure import clip as whole
from footfix.measure import plants as single
from footfix.measure.clip import measure
from footfix.motion import rotation
from footfix.motion.clip import Clip, Skeleton
from footfix.motion.segments import segments
from footfix.rig.find import find_rig

RNG = np.random.default_rng(5)
SPANS = [(0, 1), (2, 9), (5, 30), (30, 32), (39, 40)]


def test_reductions_are_those_of_each_stretch() -> None:
    values = RNG.normal(size=40)
    over = segments(SPANS)
    laid = values[over.frames]
    assert np.allclose(over.median(laid), [np.median(values[a:b]) for a, b in SPANS])
    assert np.allclose(over.mean(laid), [np.mean(values[a:b]) for a, b in SPANS])
    assert np.allclose(over.largest(laid), [np.max(values[a:b]) for a, b in SPANS])
    assert [int(over.frames[m]) for m in over.middle()] == [a + (b - a) // 2 for a, b in SPANS]
    assert len(segments([]).median(np.zeros(0))) == 0


def test_slide_is_the_farthest_from_the_median_place() -> None:
    track = RNG.normal(size=(40, 3))
    for (a, b), found in zip(SPANS, single.slide(track, segments(SPANS)), strict=True):
        flat = track[a:b][:, [0, 2]]
        assert found == pytest.approx(np.linalg.norm(flat - np.median(flat, axis=0), axis=1).max())


def test_speeds_are_of_the_plants_own_steps() -> None:
    track = np.zeros((40, 3))
    track[:, 0] = np.arange(40.0)
    track[:, 1] = RNG.normal(size=40)
    mean, peak = single.speeds(track, segments(SPANS), 0.5)
    assert np.allclose(mean, [0, 2, 2, 2, 0]) and np.allclose(peak, [0, 2, 2, 2, 0])


def test_yaw_counts_heading_and_not_roll() -> None:
    heading = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.linspace(0, 0.3, 31))
    roll = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.linspace(-0.5, 0.5, 31))
    assert single.yaw(heading, segments([(0, 31)]))[0] == pytest.approx(0.15)
    assert single.yaw(roll, segments([(0, 31)]))[0] == pytest.approx(0.0, abs=1e-9)
    assert single.yaw(rotation.multiply(heading, roll), segments([(0, 31)]))[0] == pytest.approx(0.15)


def still(frames: int) -> Clip:
    turns = np.broadcast_to([0.0, 0.0, 0.0, 1.0], (frames, 1, 4))
    return Clip(Skeleton(("a",), np.array([-1]), np.zeros((1, 3))), np.zeros((frames, 1, 3)), turns, 0.1)


@pytest.mark.parametrize("frames", [5, 1024, 1027, 1028, 2500])
def test_jitter_is_the_third_difference_whatever_the_blocks(frames: int) -> None:
    clip = still(frames)
    positions = RNG.normal(size=(frames, 1, 3))
    shaken = Clip(clip.skeleton, positions, clip.rotations, 0.1)
    slow = np.linalg.norm(np.diff(positions, n=3, axis=0), axis=-1).mean() * 10.0**3 / 100.0
    assert whole.jitter(shaken) == pytest.approx(slow)
    assert whole.jitter(clip) == 0.0


def test_skating_ratio_counts_low_and_fast() -> None:
    toe = np.zeros((101, 3))
    toe[:, 0] = np.where(np.arange(101) < 50, 0.0, np.arange(101) - 50) * 0.1  # 1 m/s at 10 fps from frame 50
    ratio = whole.skating_ratio([toe], 0.0, 0.1)
    assert 0.45 <= ratio <= 0.5
    toe[:, 1] = 0.06
    assert whole.skating_ratio([toe], 0.0, 0.1) == 0.0


def test_weighted_skate_falls_to_nothing_at_its_height() -> None:
    track = np.zeros((11, 3))
    track[:, 2] = np.arange(11) * 0.1
    assert whole.weighted_skate([track], 0.0, 0.1) == pytest.approx(100.0)
    track[:, 1] = 0.033 * np.log2(1.5)
    assert whole.weighted_skate([track], 0.0, 0.1) == pytest.approx(50.0)
    track[:, 1] = 0.033
    assert whole.weighted_skate([track], 0.0, 0.1) == 0.0


def test_physdiff_by_hand() -> None:
    track = np.zeros((4, 3))
    track[:, 1] = [-0.02, 0.004, 0.03, -0.004]
    track[:, 0] = [0.0, 0.01, 0.02, 0.03]
    penetrate, floating, skate = whole.physdiff([track], 0.0)
    assert (penetrate, floating) == (pytest.approx(5.0), pytest.approx(7.5))
    assert skate == pytest.approx(10.0 / 3)


def test_a_walker_has_no_skate_and_a_drifting_one_has() -> None:
    import artefacts

    walk = make(Gait(name="walk", duration=3.0))
    rig = find_rig(walk.clip)
    clean = measure(walk.clip, rig, walk.contacts)[0]
    drifting = measure(artefacts.drift(walk.clip, 0.3), rig, walk.contacts)[0]
    assert drifting.skate_cm_s - clean.skate_cm_s == pytest.approx(10.0, rel=0.15)
    assert clean.coverage == pytest.approx(walk.contacts.mask().mean()) == drifting.coverage
    assert clean.plants == sum(len(effector.contacts) for effector in walk.contacts.effectors)


def test_plants_on_a_belt_are_measured_against_the_belt() -> None:
    walk = make(Gait(name="treadmill", duration=3.0))
    rig = find_rig(walk.clip)
    at_rest = measure(walk.clip, rig, walk.contacts)[0]
    on_belt = measure(walk.clip, rig, walk.contacts, belt=walk.belt)[0]
    assert at_rest.slide_mm > 200.0 and on_belt.slide_mm < 15.0
    assert at_rest.skate_cm_s > 100.0 and on_belt.skate_cm_s < 5.0

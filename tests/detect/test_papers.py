"""The papers' detectors: each does what its paper says, on walkers whose contacts are known and by hand."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from conftest import SHARED
from hypothesis import given
from hypothesis import strategies as st
from skinmaker import skin_of
from walker import Walk, make
from walker_plan import Gait

from footfix.api.files import load
from footfix.detect.adaptive import AdaptiveParams, adaptive
from footfix.detect.gait_cycles import CycleParams, find_cycles, zigzag
from footfix.detect.lyard import LyardParams, lyard
from footfix.detect.threshold import ThresholdParams, threshold, vote
from footfix.detect.tracks import Finding, Tracks, tracks_of
from footfix.measure import agreement
from footfix.motion.contacts import runs
from footfix.rig.find import find_rig


@cache
def walked(name: str = "walk", fps: float = 60.0, duration: float = 6.0) -> tuple[Walk, Tracks]:
    walk = make(Gait(name=name, fps=fps, duration=duration))  # type: ignore[arg-type]
    return walk, tracks_of(walk.clip, find_rig(walk.clip))


def feet_f1(finding: Finding, walk: Walk) -> float:
    """F1 of whole feet, 30 ms forgiven."""
    found, true = agreement.feet(finding.mask), agreement.feet(walk.contacts.mask())
    tolerance = round(0.03 * walk.clip.fps)
    return float(np.mean([agreement.frames(found[:, k], true[:, k], tolerance=tolerance).f1 for k in (0, 1)]))


# Kim & Neff


def test_low_and_slow_finds_a_walk() -> None:
    walk, tracks = walked()
    assert feet_f1(threshold(tracks, ThresholdParams()), walk) >= 0.9


def test_a_frame_joins_when_most_of_its_neighbours_are_in_contact() -> None:
    raw = np.ones(40, dtype=np.bool_)
    raw[[0, 1, 2, 37, 38, 39]] = False
    raw[20:23] = False  # N_f = 17 / 4, so 4: of 9 neighbours 6 are in contact
    voted = vote(raw, 0.25)
    assert runs(voted) == [(3, 37)]


def test_a_gap_as_long_as_the_vote_reaches_stays() -> None:
    raw = np.ones(40, dtype=np.bool_)
    raw[15:25] = False
    assert not vote(raw, 0.25)[19:21].any()


@given(st.lists(st.booleans(), min_size=1, max_size=80))
def test_the_vote_only_adds_and_never_before_the_first_or_after_the_last_plant(bits: list[bool]) -> None:
    raw = np.array(bits, dtype=np.bool_)
    voted = vote(raw, 0.25)
    assert np.all(voted >= raw)
    if raw.any():
        first, last = np.flatnonzero(raw)[[0, -1]]
        assert not voted[:first].any()
        assert not voted[last + 1 :].any()


# Glardon, Boulic & Thalmann


def test_cycles_are_those_of_the_walker() -> None:
    walk, tracks = walked()
    cycles = find_cycles(tracks, tracks.feet[0], tracks.feet[1], CycleParams())
    strikes = np.array([step.strike for step in walk.steps[1]]) * walk.clip.fps
    assert len(cycles) >= 3
    for cycle in cycles:
        assert not cycle.run
        assert np.abs(strikes - cycle.start).min() < 0.06 * walk.clip.fps
        assert np.abs(strikes - cycle.end).min() < 0.06 * walk.clip.fps


@pytest.mark.parametrize(("name", "run"), [("walk", False), ("run", True), ("turn", False), ("sprint", True)])
def test_a_run_is_told_from_a_walk(name: str, run: bool) -> None:
    _, tracks = walked(name)
    cycles = find_cycles(tracks, tracks.feet[0], tracks.feet[1], CycleParams())
    assert len(cycles) >= 3
    assert all(cycle.run == run for cycle in cycles)


@pytest.mark.parametrize("name", ["walk", "run", "turn"])
def test_the_adaptive_threshold_finds_a_gait(name: str) -> None:
    walk, tracks = walked(name)
    assert feet_f1(adaptive(tracks, AdaptiveParams(), ThresholdParams()), walk) >= 0.85


def test_a_plant_of_a_cycle_never_splits() -> None:
    _, tracks = walked(duration=8.0)
    shaken = tracks.feet[0].heel + np.random.default_rng(0).normal(0.0, 0.004, tracks.feet[0].heel.shape)
    left = type(tracks.feet[0])("left", tracks.feet[0].hip, tracks.feet[0].ankle, shaken, tracks.feet[0].toe)
    noisy = Tracks(tracks.pelvis, (left, tracks.feet[1]), tracks.leg_length, tracks.frame_time)
    cycles = find_cycles(noisy, *noisy.feet, CycleParams())
    inside = slice(round(cycles[0].start), round(cycles[-1].end))
    strikes = runs(adaptive(noisy, AdaptiveParams(), ThresholdParams()).mask[inside, 0])
    assert len(strikes) <= len(cycles) + 1


def test_it_says_where_there_is_no_cycle_and_another_detector_answers_there() -> None:
    _, tracks = walked("stand")
    finding = adaptive(tracks, AdaptiveParams(), ThresholdParams())
    assert [(note.id, note.start, note.end) for note in finding.notes] == [("no-cycle", 0, len(tracks))]
    assert np.array_equal(finding.mask, threshold(tracks, ThresholdParams()).mask)


def test_walking_throughout_it_speaks_of_both_ends_only() -> None:
    _, tracks = walked()
    notes = adaptive(tracks, AdaptiveParams(), ThresholdParams()).notes
    assert {note.id for note in notes} <= {"no-cycle"}
    assert all(note.start == 0 or note.end == len(tracks) for note in notes)


@given(st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=60), st.floats(0.05, 1.0))
def test_highs_and_lows_take_turns_and_stand_out(values: list[float], least: float) -> None:
    curve = np.array(values)
    turns = zigzag(curve, least)
    assert turns == sorted(set(turns))
    heights = np.diff(curve[turns])
    assert np.all(heights[1:] * heights[:-1] < 0.0)
    assert np.all(np.abs(heights) > least)


# Lyard & Magnenat-Thalmann


def test_the_static_point_finds_a_walk() -> None:
    walk, tracks = walked()
    assert feet_f1(lyard(tracks, LyardParams()), walk) >= 0.8


def test_one_point_is_static_at_a_time_while_the_root_moves() -> None:
    _, tracks = walked()
    mask = lyard(tracks, LyardParams()).mask
    assert np.mean(mask.sum(axis=1) == 1) > 0.95


def test_no_point_is_static_in_flight() -> None:
    walk, tracks = walked("run", 120.0)
    true = walk.contacts.mask().any(axis=1)
    flight = ~true & ~np.roll(true, 4) & ~np.roll(true, -4)
    assert flight.sum() > 50
    assert lyard(tracks, LyardParams()).mask[flight].mean() < 0.05


def test_all_points_are_static_where_the_figure_stands_still() -> None:
    walk, _ = walked("stand")
    still = walk.clip.frames(np.zeros(60, dtype=np.intp))
    assert lyard(tracks_of(still, find_rig(walk.clip)), LyardParams()).mask.all()


def test_vertices_of_soles_find_a_walk_as_well_as_heel_and_toe_do() -> None:
    walk, points = walked()
    rig = find_rig(walk.clip, skin=skin_of(walk.clip))
    vertices = tracks_of(walk.clip, rig, mesh=True)
    assert all(foot.mesh is not None and len(foot.mesh) > 2 for foot in vertices.feet)
    found = lyard(vertices, LyardParams())
    assert feet_f1(found, walk) >= feet_f1(lyard(points, LyardParams()), walk) - 0.03
    assert np.mean(found.mask.sum(axis=1) == 1) > 0.95


def test_pairs_of_vertices_are_compared_alike_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    walk, _ = walked()
    tracks = tracks_of(walk.clip, find_rig(walk.clip, skin=skin_of(walk.clip)), mesh=True)
    whole = lyard(tracks, LyardParams()).mask
    monkeypatch.setattr("footfix.detect.lyard._MOST_PAIRS", 1)
    assert np.array_equal(lyard(tracks, LyardParams()).mask, whole)


@pytest.mark.parametrize("name", ["walk", "run"])
@pytest.mark.parametrize("size", [0.5, 2.0])
def test_size_does_not_matter_to_any_of_them(name: str, size: float) -> None:
    """Figures are alike when speeds go with the square root of their size (Froude)."""
    _, tracks = walked(name)
    feet = tuple(type(f)(f.side, f.hip * size, f.ankle * size, f.heel * size, f.toe * size) for f in tracks.feet)
    like = Tracks(tracks.pelvis * size, feet, tracks.leg_length * size, tracks.frame_time * size**0.5)
    pairs = (
        (threshold(like, ThresholdParams()), threshold(tracks, ThresholdParams())),
        (adaptive(like, AdaptiveParams(), ThresholdParams()), adaptive(tracks, AdaptiveParams(), ThresholdParams())),
        (lyard(like, LyardParams()), lyard(tracks, LyardParams())),
    )
    for one, other in pairs:  # windows are in seconds, so not to the frame
        assert np.mean(agreement.feet(one.mask) != agreement.feet(other.mask)) < 0.04


@pytest.mark.parametrize(
    ("clip", "run"),
    [("bandai/dataset-1_run_normal_001.bvh", True), ("pybvh/cmu_12_01_walk.bvh", False),
     ("marcojr_cmu/running.bvh", True), ("accad/Male1_B15_WalkTurnAround.bvh", False)],
)  # fmt: skip
def test_duty_tells_captured_runs_from_walks(clip: str, run: bool) -> None:
    path = next(iter((SHARED / "clips").glob(clip)), None)
    if path is None:
        pytest.skip("the shared clips are not here")
    document = load(path)
    tracks = tracks_of(document.clip, find_rig(document.clip))
    cycles = find_cycles(tracks, tracks.feet[0], tracks.feet[1], CycleParams())
    assert all(cycle.run == run for cycle in cycles)

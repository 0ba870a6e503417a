"""The papers' detectors against their formulas, on tracks made by hand: what is counted here was counted on paper."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from footfix.detect.adaptive import AdaptiveParams, _frames_of, _plants, _with_ends, adaptive
from footfix.detect.foot_locks import let_go
from footfix.detect.gait_cycles import Cycle, CycleParams, _even, find_cycles, zigzag
from footfix.detect.lyard import LyardParams, _agreement, _follow, lyard
from footfix.detect.threshold import ThresholdParams, _nearest_plant_length, threshold
from footfix.detect.tracks import GRAVITY, FootTracks, Tracks
from footfix.motion.clip import Floats
from footfix.motion.contacts import runs
from footfix.motion.smoothing import savgol

DT = 0.01  # [s]
LEG = 1.0  # [m]


def line(x: object, y: object, z: object, frames: int = 101) -> Floats:
    """(F, 3) [m] a track from its three curves."""
    return np.stack([np.zeros(frames) + np.asarray(each) for each in (x, y, z)], axis=1)


def tracks(pelvis: Floats, heel: Floats, toe: Floats | None = None, *, others: Floats | None = None) -> Tracks:
    """Two feet: the left one as told, the right one far up unless it is told, too."""
    away = line(0.1, 3.0, 0.0, len(pelvis)) if others is None else others
    left = FootTracks("left", pelvis, heel, heel, heel if toe is None else toe)
    return Tracks(pelvis, (left, FootTracks("right", pelvis, away, away, away)), LEG, DT)


T = np.arange(101) * DT
RIDE = line(2.0 * T, 1.0, 0.0)  # a pelvis at 2 m/s: half of that is slow


# ---- Kim & Neff -------------------------------------------------------------------------------------


def test_low_is_within_a_share_of_the_points_own_range() -> None:
    mask = threshold(tracks(RIDE, line(0.0, 0.5 + 0.9 * T, 0.0)), ThresholdParams(height=0.155)).mask
    assert runs(mask[:, 0]) == [(0, 16)]  # 15.5 % of 100 steps, and the frame they begin at


@pytest.mark.parametrize(("speed", "planted"), [(0.99, True), (1.01, False)])
def test_slow_is_half_as_fast_as_the_body(speed: float, planted: bool) -> None:
    mask = threshold(tracks(RIDE, line(0.0, 0.0, speed * T)), ThresholdParams()).mask
    assert mask[:, 0].all() == mask[:, 0].any() == planted


@pytest.mark.parametrize(("speed", "planted"), [(0.99, True), (1.01, False)])
def test_a_body_that_stands_has_a_speed_by_its_size(speed: float, planted: bool) -> None:
    bound = 0.1 * np.sqrt(9.81 * LEG)
    mask = threshold(tracks(line(0.0, 1.0, 0.0), line(speed * bound * T, 0.0, 0.0)), ThresholdParams()).mask
    assert mask[:, 0].all() == mask[:, 0].any() == planted


@pytest.mark.parametrize(("height", "planted"), [(0.0099, True), (0.0101, False)])
def test_a_range_of_a_hundredth_of_a_leg_is_noise(height: float, planted: bool) -> None:
    steps = line(0.0, np.where(T < 0.5, 0.0, height), 0.0)
    mask = threshold(tracks(RIDE, steps), ThresholdParams(smooth=DT, degree=0)).mask
    assert mask[60:, 0].all() == mask[60:, 0].any() == planted


# ---- Glardon ----------------------------------------------------------------------------------------

WALK = ((1, 12), (3, 15), (13, 26), (15, 29))  # of 25 frames: right ankle, right ball, left ankle, left ball
RUN = ((1, 7), (1, 9), (12, 19), (13, 22))


@pytest.mark.parametrize("run", [False, True])
@pytest.mark.parametrize("row", range(4))
def test_plants_lie_in_the_windows_of_table_one(row: int, run: bool) -> None:
    first, last = (RUN if run else WALK)[row]
    mask = _plants(np.zeros(200), [Cycle(100.0, 150.0, run, 0.5)], row, 0.4)  # 2 frames for each of G's
    assert runs(mask) == [(100 + 2 * (first - 1), 100 + 2 * (last - 1) + 1)]


def test_a_plants_threshold_is_equation_eight() -> None:
    height = np.full(40, 9.0)
    height[10:22] = [0.5, 0.27, 0.25, 0.1, 0.3, 0.1, 0.2, 0.23, 0.24, 0.3, 0.4, 0.3]  # h 0.4, lowest 0.1: 0.22
    mask = _plants(height, [Cycle(10.0, 35.0, False, 0.5)], 0, 0.4)
    assert runs(mask) == [(13, 17)]  # what is higher in between does not split it
    assert runs(_plants(height, [Cycle(10.0, 35.0, False, 0.5)], 0, 0.6)) == [(11, 19)]  # 0.28


def test_windows_end_where_the_clip_does() -> None:
    whole = [Cycle(-5.0, 20.0, False, 0.5), Cycle(20.0, 45.0, False, 0.5)]
    assert runs(_plants(np.zeros(30), whole, 0, 0.4)) == [(0, 7), (20, 30)]


def test_cycles_are_continued_by_one_at_the_ends_of_each_stretch() -> None:
    cycles = [Cycle(50.0, 80.0, False, 0.5), Cycle(80.0, 100.0, False, 0.5), Cycle(200.0, 240.0, True, 0.6)]
    more = {(each.start, each.end, each.run) for each in _with_ends(cycles)}
    assert more - {(c.start, c.end, c.run) for c in cycles} == {
        (20.0, 50.0, False), (100.0, 120.0, False), (160.0, 200.0, True), (240.0, 280.0, True),
    }  # fmt: skip
    assert runs(_frames_of(cycles, 300)) == [(50, 101), (200, 241)]


# ---- cycles -----------------------------------------------------------------------------------------


def walker(
    seconds: float = 5.0, period: float = 1.0, swing: float = 0.2, *, forwards: bool = True,
    phase: Floats | None = None,
) -> Tracks:  # fmt: skip
    """Ankles that swing by `swing` [m] past a pelvis at 1 m/s, the right one ahead a quarter of a period after 0."""
    t = np.arange(round(seconds / DT) + 1) * DT
    turn = 2.0 * np.pi * t / period if phase is None else phase
    way = (1.0 if forwards else -1.0) * t
    pelvis = line(0.0, 1.0, way, len(t))
    feet = []
    for side, sign in (("left", -1.0), ("right", 1.0)):
        lift = 0.05 * np.maximum(sign * np.cos(turn), 0.0) * (1.0 if forwards else 0.0)
        lift += 0.05 * np.maximum(-sign * np.cos(turn), 0.0) * (0.0 if forwards else 1.0)
        hip = pelvis + [-0.1 * sign, 0.0, 0.0]
        ankle = line(-0.1 * sign, 0.1 + lift, way + sign * swing * np.sin(turn), len(t))
        feet.append(FootTracks(side, hip, ankle, ankle - [0.0, 0.1, 0.05], ankle + [0.0, -0.1, 0.15]))
    return Tracks(pelvis, tuple(feet), LEG, DT)


def cycles_of(of: Tracks, **params: float) -> list[Cycle]:
    return find_cycles(of, *of.feet, CycleParams(**params))


def test_a_cycle_goes_from_a_right_strike_to_the_next_and_a_step_is_as_long_as_feet_are_apart() -> None:
    cycles = cycles_of(walker())
    assert [(c.start, c.end) for c in cycles] == [(25.0 + 100.0 * k, 125.0 + 100.0 * k) for k in range(4)]
    assert [c.step for c in cycles] == pytest.approx([0.4] * 4, rel=0.02)  # smoothing flattens tops a little


def test_backwards_the_foot_behind_strikes() -> None:
    cycles = cycles_of(walker(forwards=False))
    assert [(c.start, c.end) for c in cycles] == [(75.0 + 100.0 * k, 175.0 + 100.0 * k) for k in range(4)]


@pytest.mark.parametrize(("name", "takes", "leaves"), [
    ("shortest", 0.99, 1.01), ("longest", 1.01, 0.99), ("stride", 0.77, 0.81),
])  # fmt: skip
def test_cycles_have_bounds(name: str, takes: float, leaves: float) -> None:
    assert len(cycles_of(walker(), **{name: takes})) == 4
    assert not cycles_of(walker(), **{name: leaves})


@pytest.mark.parametrize(("middle", "found"), [(0.34, True), (0.26, False), (0.66, True), (0.74, False)])
def test_the_left_foot_strikes_about_the_middle_of_a_cycle(middle: float, found: bool) -> None:
    t = np.arange(501) * DT - 0.25
    share = t % 1.0
    warped = np.where(share < middle, 0.5 * share / middle, 0.5 + 0.5 * (share - middle) / (1.0 - middle))
    phase = 2.0 * np.pi * (np.floor(t) + warped) + 0.5 * np.pi
    assert bool(cycles_of(walker(phase=phase))) is found


def test_a_cycle_with_a_pause_in_it_is_left_out() -> None:
    lengths = [100, 149, 100, 151, 100]
    edges = np.concatenate([[0], np.cumsum(lengths)]).astype(float)
    cycles = [Cycle(float(a), float(b), False, 0.5) for a, b in pairwise(edges)]
    assert _even(cycles, 1.5) == [cycles[0], cycles[1], cycles[2], cycles[4]]
    alone = [cycles[0], Cycle(1000.0, 1400.0, False, 0.5)]  # none touches it
    assert _even(alone, 1.5) == alone
    longer = [Cycle(0.0, 200.0, False, 0.5), Cycle(200.0, 300.0, False, 0.5)]  # it is the one before that pauses
    assert _even(longer, 1.5) == longer[1:]


def test_turns_of_a_zigzag_by_hand() -> None:
    curve = np.array([0.0, 1.0, 0.8, 1.2, 0.0, 0.5, -0.2, 1.0, 0.9, 1.0])
    assert zigzag(curve, 0.4) == [3, 4, 5, 6]  # the last high stands at the end and may grow
    assert zigzag(curve, 0.6) == [3, 6]
    assert zigzag(-curve, 0.6) == [3, 6]
    assert zigzag(curve, 2.0) == []


def test_what_is_no_cycle_is_told_between_cycles() -> None:
    notes = adaptive(walker(), AdaptiveParams(), ThresholdParams()).notes
    assert [(note.start, note.end) for note in notes] == [(0, 25), (426, 501)]
    assert "0.00 to 0.25 s" in notes[0].text and "4.26 to 5.01 s" in notes[1].text


# ---- Lyard ------------------------------------------------------------------------------------------


def test_agreement_is_equation_one_by_hand() -> None:
    root = np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 0.1]])
    points = np.array([  # one stays, one rides with the root, one goes twice as far
        [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0], [0.0, 0.0, 0.1]], [[0.0, 0.0, 0.0], [0.0, 0.0, 0.2]],
    ])  # fmt: skip
    dots, way = _agreement(points, root, np.array([0]), 1)
    assert way == pytest.approx([0.1])
    # dR' is half of what the one leaves and half of what the other arrives by: 0.1, 0 and -0.1 along z, halved
    expected = [[1.0, 1.0, 0.0], [1.0, 0.0, -1.0], [0.0, -1.0, -1.0]]
    assert dots[0] == pytest.approx(np.array(expected))


def test_the_static_point_is_the_slowest_at_first_and_then_the_one_that_agrees() -> None:
    best = np.array([[0, 2, 0], [0, 0, 0], [1, 0, 0], [0, 0, 0]])  # (F, E) the next point, by the last
    speeds = np.array([[2.0] * 4, [1.0] * 4, [3.0] * 4])
    assert _follow(best, speeds, np.arange(3)).tolist() == [1, 2, 0, 1]


def test_of_the_foot_that_agrees_the_slowest_point_is_static_and_leads_on() -> None:
    best = np.array([[0, 2, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0]])  # the other foot by its point 2; then by 1 from point 3
    speeds = np.array([[2.0] * 3, [1.0] * 3, [9.0, 9.0, 9.0], [9.0, 3.0, 3.0]])
    assert _follow(best, speeds, np.array([0, 0, 1, 1])).tolist() == [1, 3, 1]


@pytest.mark.parametrize(("height", "fall", "flies"), [
    (0.03, 0.5, True), (0.03, 0.3, False), (0.015, 0.5, False), (0.09, 0.0, False), (0.11, 0.0, True),
])  # fmt: skip
def test_in_flight_nothing_is_low_and_the_pelvis_falls_or_everything_is_far_up(
    height: float, fall: float, flies: bool
) -> None:
    t = np.arange(301) * DT
    air = (t > 1.4) & (t < 1.6)
    foot = line(0.0, np.where(air, height, 0.0), 0.0, len(t))
    pelvis = line(0.0, 1.0 - 0.5 * fall * GRAVITY * (t - 1.5) ** 2, 0.0, len(t))
    mask = lyard(tracks(pelvis, foot, others=foot + [0.2, 0.0, 0.0]), LyardParams(still=1e9)).mask
    assert mask[:120].all() and mask[180:].all()
    assert mask[150].any() != flies


def test_where_the_root_stands_all_slow_points_are_static_and_no_fast_one() -> None:
    bound = 0.03 * np.sqrt(9.81 * LEG)  # [m/s]
    slow, fast = line(0.0, 0.0, 0.95 * bound * T), line(0.2, 0.0, 1.05 * bound * T)
    for way, planted in ((0.95, [True, True, False, False]), (1.05, None)):
        pelvis = line(0.0, 1.0, way * bound * T)
        mask = lyard(tracks(pelvis, slow, others=fast), LyardParams()).mask
        if planted is not None:
            assert (mask == planted).all()
        else:
            assert (mask.sum(axis=1) == 1).all()


# ---- feet that a program has put to rest ------------------------------------------------------------


def rested(before: float, after: float, *, rests: int = 20, moves: int = 3) -> list[tuple[int, int]]:
    """The contact left of one that rests to the digit, with a step [m] into the rest and one out of it."""
    steps = [*[0.001] * moves, before, *[0.0] * rests, after, *[0.001] * moves]
    place = line(0.0, 0.0, np.concatenate([[0.0], np.cumsum(steps)]), len(steps) + 1)
    mask = np.zeros((len(place), 4), dtype=np.bool_)
    mask[:, 0] = True
    return runs(let_go(mask, tracks(place, place))[:, 0])


def test_a_contact_ends_beside_its_rest_where_the_foot_snaps() -> None:
    assert rested(0.01, 0.01) == [(0, 29)]  # under 11.4 mm a foot lifts by itself
    assert rested(0.012, 0.01) == [(4, 29)]
    assert rested(0.01, 0.012) == [(0, 25)]
    assert rested(0.012, 0.012) == [(4, 25)]


def test_a_short_rest_and_one_in_less_than_half_of_a_contact_ends_nothing() -> None:
    assert rested(0.02, 0.02, rests=4, moves=1) == [(0, 9)]
    assert rested(0.02, 0.02, rests=5, moves=1) == [(2, 8)]
    assert rested(0.02, 0.02, rests=20, moves=9) == [(10, 31)]
    assert rested(0.02, 0.02, rests=20, moves=10) == [(0, 43)]


def test_a_frame_votes_by_the_plant_that_is_nearest() -> None:
    lengths = _nearest_plant_length([(0, 4), (10, 30), (50, 51)], np.arange(60))
    assert runs(lengths == 4) == [(0, 8)] and runs(lengths == 20) == [(8, 41)] and runs(lengths == 1) == [(41, 60)]


def test_each_point_is_looked_at_in_its_own_window() -> None:
    of = walker()
    feet = tuple(
        FootTracks(f.side, f.hip, f.ankle, f.heel * [1.0, 1.0 + 0.3 * k, 1.0], f.toe * [1.0, 2.0 + k, 1.0])
        for k, f in enumerate(of.feet)
    )  # fmt: skip
    of = Tracks(of.pelvis, feet, LEG, DT)
    mask, cycles = adaptive(of, AdaptiveParams(), ThresholdParams()).mask, cycles_of(of)
    inside = slice(round(cycles[0].start), round(cycles[-1].end) + 1)
    for column, (foot, part, row) in enumerate(((0, "heel", 2), (0, "toe", 3), (1, "heel", 0), (1, "toe", 1))):
        height = savgol(getattr(of.feet[foot], part)[:, 1], DT, seconds=0.05, degree=2)
        expected = _plants(height, _with_ends(cycles), row, 0.4)
        assert np.array_equal(mask[inside, column], expected[inside])

"""The path through the states, the network and the evidence, held against what defines them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footfix.detect import viterbi
from footfix.detect.evidence import COLUMNS, STEP, catmull_rom, evidence, floors, resample
from footfix.detect.network import FLAT, HEEL, SWING, TOE
from footfix.detect.tracks import FootTracks, Tracks
from footfix.detect.weights import network
from footfix.motion.clip import Floats


def greatest_total(score: Floats, switch: float) -> float:
    """The greatest total of any path, step by step."""
    value = score[0].copy()
    for row in score[1:]:
        value = np.maximum(value, value.max() - switch) + row
    return float(value.max())


def total(score: Floats, found: list[tuple[int, int, int]], switch: float) -> float:
    return sum(float(score[a:b, state].sum()) for a, b, state in found) - switch * (len(found) - 1)


@given(st.integers(0, 10_000), st.integers(1, 60), st.floats(0.0, 5.0))
def test_the_path_of_two_states_is_the_best_there_is(seed: int, steps: int, switch: float) -> None:
    score = np.random.default_rng(seed).normal(size=(steps, 2)).cumsum(axis=0)
    found = viterbi.segments(score, switch)
    assert found[0][0] == 0
    assert found[-1][1] == steps
    assert all(a[1] == b[0] and a[2] != b[2] for a, b in pairwise(found))
    assert total(score, found, switch) == pytest.approx(greatest_total(score, switch))


@given(st.integers(0, 10_000), st.integers(2, 60))
def test_without_a_cost_every_step_takes_its_best_state(seed: int, steps: int) -> None:
    score = np.random.default_rng(seed).normal(size=(steps, 3))
    states = np.concatenate([np.full(b - a, state) for a, b, state in viterbi.segments(score, 0.0)])
    assert np.array_equal(states, np.argmax(score, axis=1))


def test_a_state_that_is_given_up_is_shared_where_its_neighbours_cross() -> None:
    # 0, then a short doubtful 1, then 2; between 0 and 2 the better one changes at step 12
    score = np.full((30, 3), -9.0)
    score[:10, 0] = score[20:, 2] = 0.0
    score[10:20, 1] = 0.0
    score[10:20, 0] = np.where(np.arange(10, 20) < 12, -0.1, -0.3)
    score[10:20, 2] = -0.2
    assert viterbi.segments(score, 5.0) == [(0, 12, 0), (12, 30, 2)]


def test_events_lie_where_the_odds_are_even() -> None:
    logits = np.full((100, 4), -20.0)
    planted = np.linspace(-5.0, 5.0, 100) - 0.02  # even odds between steps
    logits[:, SWING], logits[:, FLAT] = -np.logaddexp(0.0, planted), -np.logaddexp(0.0, -planted)
    (stretch,) = viterbi.stretches(logits, 3.0, 2.0)
    assert stretch.state == FLAT
    assert stretch.start == pytest.approx(np.interp(0.0, planted, np.arange(100)), abs=1e-6)
    assert stretch.end == np.inf
    for per_frame in (0.33, 1.0, 3.3):
        heel, toe = viterbi.masks([stretch], 25, per_frame)
        landed = stretch.start - min(viterbi.EARLY, 0.5 * per_frame)
        assert np.array_equal(heel, np.arange(25) * per_frame >= landed)
        assert np.array_equal(heel, toe)


@pytest.mark.parametrize(("landed", "per_frame", "first"), [
    (10.0, 5.0, 2), (10.39, 5.0, 2), (10.41, 5.0, 3), (10.19, 0.4, 25), (10.21, 0.4, 26), (0.0, 5.0, 0), (0.39, 5.0, 0),
])  # fmt: skip
def test_a_frame_just_before_a_landing_counts_as_after_it(landed: float, per_frame: float, first: int) -> None:
    heel, _ = viterbi.masks([viterbi.Stretch(landed, np.inf, HEEL)], 60, per_frame)
    assert np.flatnonzero(heel)[0] == first


def test_heel_flat_and_toe_are_intervals_of_heel_and_toe() -> None:
    found = [viterbi.Stretch(2.0, 5.0, HEEL), viterbi.Stretch(5.0, 8.0, FLAT), viterbi.Stretch(8.0, 11.5, TOE)]
    heel, toe = viterbi.masks(found, 15, 1.0)
    assert np.flatnonzero(heel).tolist() == list(range(2, 8))
    assert np.flatnonzero(toe).tolist() == list(range(5, 12))


def test_a_part_that_does_not_rise_between_two_contacts_of_a_plant_never_left() -> None:
    part = np.array([0, 1, 1, 0, 0, 1, 0, 0, 1, 0], dtype=np.bool_)
    planted = np.array([1, 1, 1, 1, 1, 1, 1, 1, 1, 1], dtype=np.bool_)
    height = np.array([9, 0, 0, 0.5, 0.5, 0, 0, 2, 0, 0], dtype=np.float64)
    assert np.flatnonzero(viterbi.resting(part, planted, height, 1.0)).tolist() == [1, 2, 3, 4, 5, 8]
    apart = planted.copy()
    apart[3] = False  # two plants
    assert np.array_equal(viterbi.resting(part, apart, height, 1.0), part)


def test_a_contact_begins_once_the_foot_is_braked_and_ends_before_it_dashes_off() -> None:
    step = np.full(19, 0.002)
    step[[4, 5, 6]] = [0.11, 0.10, 0.03]
    step[14] = 0.08
    part = np.zeros(20, dtype=np.bool_)
    part[5:16] = True
    assert np.flatnonzero(viterbi.landed(part, step, 0.05)).tolist() == list(range(7, 15))
    slow = np.minimum(step, 0.04)
    assert np.array_equal(viterbi.landed(part, slow, 0.05), part), "what is not far in any frame stays"
    belt = step + 0.2
    assert np.array_equal(viterbi.landed(part, belt, 0.05), viterbi.landed(part, step, 0.05)), "a belt takes all along"
    fast = np.where(np.arange(19) % 2 == 0, 0.2, 0.1)
    assert viterbi.landed(part, fast, 0.05)[6:15].all(), "what is fast throughout loses its ends alone"


def test_at_the_ends_of_a_clip_no_foot_lands() -> None:
    step = np.array([0.2, 0.001, 0.001, 0.001, 0.2])
    every = np.ones(6, dtype=np.bool_)
    assert np.array_equal(viterbi.landed(every, step, 0.05), every)
    single = np.array([False, True, False, False, False, False])
    assert np.array_equal(viterbi.landed(single, step, 0.05), single)


def test_the_network_is_what_its_numbers_say() -> None:
    random = np.random.default_rng(0)
    seen = random.normal(size=(50, len(COLUMNS)))
    fitted = network()
    answer = fitted.logits(seen)
    for t in (0, 20, 49):
        z = (seen - fitted.mean) / fitted.spread
        rows = z[np.clip(t + np.array(fitted.taps), 0, 49)]  # (taps, columns)
        first = np.tanh(np.einsum("te,teh->h", rows, fitted.hidden) + fitted.hidden_bias)
        second = np.tanh(first @ fitted.mixing + fitted.mixing_bias)
        logits = second @ fitted.answer + fitted.answer_bias
        assert answer[t] == pytest.approx(logits - np.log(np.exp(logits).sum()))
    assert np.exp(answer).sum(axis=1) == pytest.approx(1.0)


@given(st.integers(0, 1000), st.integers(1, 80), st.floats(0.01, 0.5))
def test_floors_are_the_lowest_places_ahead_and_behind(seed: int, steps: int, seconds: float) -> None:
    height = np.random.default_rng(seed).normal(size=steps)
    n = max(round(seconds / STEP), 1)
    ahead, behind = floors(height, seconds)
    for t in range(steps):
        assert ahead[t] == height[t : t + n + 1].min()
        assert behind[t] == height[max(t - n, 0) : t + 1].min()


def test_sampling_goes_through_the_frames_and_keeps_parabolas() -> None:
    frames = np.arange(20.0)
    parabola = np.stack([frames**2, 3.0 - frames], axis=1)
    assert catmull_rom(parabola, 1.0) == pytest.approx(parabola)
    fine = catmull_rom(parabola, 0.25)
    inner = slice(4, -5)
    at = np.arange(len(fine))[inner] * 0.25
    assert fine[inner, 0] == pytest.approx(at**2)
    assert len(fine) == 77


def test_evidence_has_no_scale_place_or_heading() -> None:
    random = np.random.default_rng(3)
    tracks = _random_tracks(random)
    turn = np.array([[np.cos(2.0), 0.0, -np.sin(2.0)], [0.0, 1.0, 0.0], [np.sin(2.0), 0.0, np.cos(2.0)]])

    def changed(x: Floats) -> Floats:
        return 3.0 * (x @ turn.T + [5.0, -2.0, 1.0])

    feet = tuple(
        FootTracks(f.side, changed(f.hip), changed(f.ankle), changed(f.heel), changed(f.toe)) for f in tracks.feet
    )
    other = Tracks(changed(tracks.pelvis), feet, 3.0 * tracks.leg_length, tracks.frame_time)
    for one, two in zip(evidence(resample(tracks)), evidence(resample(other)), strict=True):
        assert one.shape == (len(one), len(COLUMNS))
        assert two == pytest.approx(one, abs=1e-6)


def _random_tracks(random: np.random.Generator) -> Tracks:
    def track(x: float, y: float) -> Floats:
        return catmull_rom(random.normal(size=(14, 3)), 0.1)[:120] * 0.1 + [x, y, 0.0]

    feet = tuple(
        FootTracks(
            side, track(x, 1.0), track(x, 0.1), track(x, 0.0) - [0.0, 0.0, 0.05], track(x, 0.0) + [0.0, 0.0, 0.15]
        )
        for side, x in (("left", 0.5), ("right", -0.5))
    )
    return Tracks(track(0.0, 1.1), feet, 0.9, 1 / 60)


def test_a_plant_that_the_clip_cuts_begins_and_ends_beyond_it() -> None:
    stand, swing = np.log([0.1, 0.3, 0.3, 0.3]), np.log([0.97, 0.01, 0.01, 0.01])
    cut = viterbi.stretches(np.concatenate([[stand] * 20, [swing] * 20, [stand] * 20]), 1.0, 1.0)
    assert cut[0].start == -np.inf and cut[-1].end == np.inf
    assert 19.0 <= cut[0].end <= 20.0 and 39.0 <= cut[-1].start <= 40.0
    whole = viterbi.stretches(np.concatenate([[swing] * 20, [stand] * 20, [swing] * 20]), 1.0, 1.0)
    assert (19.0 <= whole[0].start <= 20.0) and (39.0 <= whole[-1].end <= 40.0)


def test_a_score_crosses_zero_on_the_line_between_two_steps_or_halfway() -> None:
    assert viterbi.crossing(np.array([-3.0, 1.0, 2.0]), 1) == pytest.approx(0.75)
    assert viterbi.crossing(np.array([-3.0, 0.0, 2.0]), 1) == pytest.approx(1.0)
    for flat in ([1.0, 2.0, 3.0], [-1.0, -1.0, -2.0], [1.0, -1.0, -2.0]):
        assert viterbi.crossing(np.array(flat), 1) == 0.5

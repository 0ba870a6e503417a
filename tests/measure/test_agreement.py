"""Agreement with known contacts, held against counts by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footfix.measure import agreement
from footfix.motion.contacts import runs

MASKS = st.lists(st.booleans(), min_size=1, max_size=60).map(lambda bits: np.array(bits, dtype=np.bool_))


def test_frames_are_counted_where_the_truth_is_known() -> None:
    found = np.array([1, 1, 0, 0, 1], dtype=np.bool_)
    true = np.array([1, 0, 1, 0, 1], dtype=np.bool_)
    known = np.array([1, 1, 1, 1, 0], dtype=np.bool_)
    scored = agreement.frames(found, true, known=known)
    assert scored == agreement.Frames(both=1, found=1, missed=1, neither=1)
    assert scored.f1 == scored.precision == scored.recall == 0.5


@given(MASKS)
def test_a_mask_agrees_with_itself(mask: np.ndarray) -> None:
    scored = agreement.frames(mask, mask)
    assert scored.f1 == 1.0
    assert scored.found == scored.missed == 0
    for found in agreement.edges(mask, 0.01):
        paired = agreement.events(found, found)
        assert paired.missed == paired.extra == 0
        assert np.all(paired.errors == 0.0)


@given(MASKS, MASKS, st.integers(0, 4))
def test_tolerance_never_makes_it_worse(a: np.ndarray, b: np.ndarray, tolerance: int) -> None:
    n = min(len(a), len(b))
    strict = agreement.frames(a[:n], b[:n])
    lenient = agreement.frames(a[:n], b[:n], tolerance=tolerance)
    assert lenient.found <= strict.found
    assert lenient.missed <= strict.missed
    assert lenient.both + lenient.missed == strict.both + strict.missed == np.count_nonzero(b[:n])


def test_a_shift_within_the_tolerance_is_forgiven_and_one_beyond_is_not() -> None:
    true = np.zeros(50, dtype=np.bool_)
    true[10:30] = True
    for shift, tolerance, wrong in ((2, 2, 0), (3, 2, 2), (-2, 2, 0), (-3, 2, 2)):
        scored = agreement.frames(np.roll(true, shift), true, tolerance=tolerance)
        assert scored.found + scored.missed == wrong


def test_events_lie_between_the_frames_and_cut_contacts_have_none() -> None:
    mask = np.array([1, 1, 0, 0, 1, 1, 0], dtype=np.bool_)
    strikes, offs = agreement.edges(mask, 0.1)
    assert strikes == pytest.approx([0.35])
    assert offs == pytest.approx([0.15, 0.55])
    assert len(runs(mask)) == 2


def test_each_event_has_one_partner_at_most() -> None:
    paired = agreement.events(np.array([0.98, 1.01, 5.0]), np.array([1.0, 3.0]))
    assert paired.errors == pytest.approx([0.01])
    assert (paired.missed, paired.extra) == (1, 2)
    assert paired.median == pytest.approx(0.01)
    both = agreement.together([paired, agreement.events(np.array([2.1]), np.array([2.0]))])
    assert both.errors == pytest.approx([0.01, 0.1])
    assert (both.missed, both.extra) == (1, 2)
    assert both.quantile(1.0) == pytest.approx(0.1)


def test_nothing_found_where_nothing_is_counts_as_right() -> None:
    nothing = np.zeros(5, dtype=np.bool_)
    assert agreement.frames(nothing, nothing).f1 == 1.0
    assert np.isnan(agreement.events(np.zeros(0), np.zeros(0)).median)


def test_feet_are_in_contact_where_heel_or_toe_is() -> None:
    mask = np.array([[1, 0, 0, 0], [0, 1, 0, 1]], dtype=np.bool_)
    assert agreement.feet(mask).tolist() == [[True, False], [True, True]]


def test_calibration_says_how_often_each_confidence_was_right() -> None:
    random = np.random.default_rng(0)
    confidence = random.uniform(size=20000)
    right = random.uniform(size=20000) < confidence
    for said, was, count in agreement.calibration(confidence, right):
        assert was == pytest.approx(said, abs=0.03)
        assert count == 4000


def test_counts_of_several_clips_add_up() -> None:
    one, other = agreement.Frames(1, 2, 3, 4), agreement.Frames(10, 20, 30, 40)
    assert one + other == agreement.Frames(11, 22, 33, 44)


def test_precision_is_of_what_was_found_and_recall_of_what_is_there() -> None:
    scored = agreement.Frames(both=6, found=2, missed=6)
    assert (scored.precision, scored.recall, scored.f1) == (0.75, 0.5, 0.6)
    wrong = agreement.Frames(found=3, missed=2)
    assert (wrong.precision, wrong.recall, wrong.f1) == (0.0, 0.0, 0.0)

"""What became of the plants of a cleaned clip, and what cleaning cost, counted by hand."""

from __future__ import annotations

from footfix.measure.cleaning_effect import costs, held


def test_held_and_costs_by_hand() -> None:
    found = held([1.0, 30.0, 50.0, 2.0], [False, False, True, False])
    assert (found.held_slide_mm, found.held_over_21mm, found.let_go) == (30.0, 1 / 3, 1)
    assert held([21.0, 21.1], [False, False]).held_over_21mm == 0.5
    assert vars(held([], [])) == {"held_slide_mm": 0.0, "held_over_21mm": 0.0, "let_go": 0}
    paid = costs({"jitter_100m_s3": 3.0, "peak_knee_speed_deg_s": 5.0}, {"jitter_100m_s3": 2.0})
    assert (paid.jitter_ratio, paid.acceleration_ratio, paid.knee_speed_ratio) == (1.5, 1.0, 1.0)


def test_a_cost_is_what_is_now_over_what_was_to_six_digits() -> None:
    paid = costs(
        {"jitter_100m_s3": 1.0, "peak_acceleration_m_s2": 2.0, "peak_knee_speed_deg_s": None},
        {"jitter_100m_s3": 3.0, "peak_acceleration_m_s2": 0.0, "peak_knee_speed_deg_s": 5.0},
    )
    assert (paid.jitter_ratio, paid.acceleration_ratio, paid.knee_speed_ratio) == (0.333333, 1.0, 0.0)

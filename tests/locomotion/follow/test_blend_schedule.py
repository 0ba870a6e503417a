"""Walks handed over to each other in time."""

from __future__ import annotations

import numpy as np

from footfix.locomotion.follow.blend_schedule import _on_whole_frames, _weights


def test_walks_are_handed_over_evenly_in_time_however_unlike_their_strides() -> None:
    one, two = np.full(400, 0.001), np.full(400, 0.004)
    weight, part, since = _weights(one, two)
    assert (weight[0], weight[-1]) == (0.0, 1.0)
    np.testing.assert_allclose(np.diff(since), (1.0 - part) * one + part * two, rtol=1e-12)
    u = since / since[-1]
    np.testing.assert_allclose(weight, 3.0 * u**2 - 2.0 * u**3, atol=1e-12)
    assert np.interp(0.5 * since[-1], since, weight) > 0.49  # half of it at half time, though not at half the stride
    assert weight[200] < 0.4


def test_a_blend_ends_on_a_whole_frame_and_its_clock_does_not_jump_at_either_end() -> None:
    times = np.linspace(2.0, 2.71, 1000)
    led = _on_whole_frames(times, 103.4, 1.0 / 60.0, 1.0 / 60.0)
    off = 60.0 * led[-1] - 103.4
    assert abs(off - round(off)) < 1e-9
    assert abs(led[-1] - times[-1]) <= 0.5 / 60.0
    rates = np.diff(led) / np.diff(times)
    assert abs(rates[0] - 1.0) < 1e-4
    assert abs(rates[-1] - 1.0) < 1e-4

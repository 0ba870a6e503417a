"""What happens between plants."""

from __future__ import annotations

import numpy as np
import pytest

from footfix.enforce.ease import EaseParams, displacement, fit, gamma, within_reach

DT = 1.0 / 100.0


def pinned_at(frames: int, *spans: tuple[int, int]) -> np.ndarray:
    mask = np.zeros(frames, dtype=bool)
    for start, end in spans:
        mask[start:end] = True
    return mask


def test_gamma_falls_from_one_to_zero_flat_at_both_ends() -> None:
    u = np.linspace(0.0, 1.0, 1001)
    values = gamma(u)
    assert values[0] == 1.0 and values[-1] == 0.0 and np.all(np.diff(values) <= 0.0)
    assert np.allclose(values, 2 * u**3 - 3 * u**2 + 1)
    assert abs(values[1] - 1.0) < 1e-5 and abs(values[-2]) < 1e-5


def test_cubic_is_glardons_equation_nine() -> None:
    frames, start, end, sigma = 200, 80, 120, 30
    values = np.tile([[0.03, 0.0, -0.02]], (frames, 1))
    values[start] += 0.01
    on = pinned_at(frames, (start, end))
    params = EaseParams(method="cubic", seconds=sigma * DT)
    eased = displacement(on, values, within_reach(on, DT, params.seconds), DT, params)
    t = np.arange(start - sigma, start)
    assert np.allclose(eased[t], (1.0 - gamma((t - start + sigma) / sigma))[:, None] * values[start])
    t = np.arange(end, end + sigma - 1)
    assert np.allclose(eased[t], gamma((t - (end - 1)) / sigma)[:, None] * values[end - 1])
    assert not eased[: start - sigma].any() and not eased[end + sigma :].any()


@pytest.mark.parametrize("method", ["smooth", "cubic", "hermite"])
def test_close_plants_are_led_over_and_never_add_up(method: str) -> None:
    frames = 200
    on = pinned_at(frames, (20, 80), (100, 180))
    values = np.where(np.arange(frames)[:, None] < 90, 0.05, 0.03) * np.array([[1.0, 0.0, 0.0]])
    params = EaseParams(method=method, seconds=0.3)  # type: ignore[arg-type]
    eased = displacement(on, values, within_reach(on, DT, 0.3), DT, params, track=np.zeros((frames, 3)))
    between = eased[80:100, 0]
    assert between.max() <= 0.05 + 1e-9 and between.min() >= 0.03 - 1e-9
    assert np.array_equal(eased[on], values[on])


def test_smooth_holds_pins_keeps_slopes_and_ends_in_zero() -> None:
    frames = 300
    on = pinned_at(frames, (100, 160))
    values = -0.04 + 0.05 * DT * (np.arange(frames)[:, None] - 100)  # a plant that drifts at 5 cm/s
    near = within_reach(on, DT, 0.4)
    eased = displacement(on, values, near, DT, EaseParams(seconds=0.4))
    assert np.array_equal(eased[on], values[on])
    assert not eased[~near].any()
    speed = np.diff(eased[:, 0]) / DT
    assert abs(speed[160] - 0.05) < 0.02  # it leaves as it was going
    assert np.abs(np.diff(speed) / DT).max() < 6.0  # and never with a kick


def test_smooth_is_the_least_squares_it_says_it_is() -> None:
    rng = np.random.default_rng(1)
    frames, settle, slack = 60, 0.03, 0.1
    weights = rng.integers(0, 2, frames).astype(float)
    values, near = rng.normal(size=(frames, 2)), pinned_at(frames, (5, 50))
    found = fit(weights, values, near, DT, settle, slack)

    def cost(d: np.ndarray) -> float:
        bend, slope = np.diff(d, 2, axis=0) / DT**2, np.diff(d, axis=0) / DT
        inside = weights * near
        data = np.sum(inside[:, None] * (d - values) ** 2)
        return float(data + settle**4 * (np.sum(bend**2) + np.sum(slope**2) / slack**2))

    best = cost(found)
    for _ in range(30):
        push = 1e-4 * rng.normal(size=found.shape) * near[:, None]
        assert cost(found + push) >= best


def test_soft_plants_follow_slow_slides_and_ignore_quick_ones() -> None:
    frames = 400
    on = pinned_at(frames, (50, 350))
    t = np.arange(frames)[:, None] * DT
    slow, quick = 0.02 * np.sin(2 * np.pi * 0.3 * t), 0.005 * np.sin(2 * np.pi * 12.0 * t)
    near = within_reach(on, DT, 0.3)
    soft = np.full(frames, 0.06)
    eased = displacement(on, slow + quick, near, DT, EaseParams(), soft)
    inside = slice(100, 300)
    assert np.abs(eased - slow)[inside].max() < 0.0015
    hard = displacement(on, slow + quick, near, DT, EaseParams(), np.zeros(frames))
    assert np.array_equal(hard[on], (slow + quick)[on])


def test_half_the_frame_rate_is_the_same_curve() -> None:
    fine, coarse = pinned_at(400, (160, 240)), pinned_at(200, (80, 120))
    a = displacement(fine, np.full((400, 1), 0.04), within_reach(fine, DT, 0.4), DT, EaseParams(seconds=0.4))
    near = within_reach(coarse, 2 * DT, 0.4)
    near = within_reach(coarse, 2 * DT, 0.4)
    b = displacement(coarse, np.full((200, 1), 0.04), near, 2 * DT, EaseParams(seconds=0.4))
    assert np.abs(a[::2] - b).max() < 0.002

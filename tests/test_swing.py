"""The way of a knee between plants."""

from __future__ import annotations

import numpy as np
import pytest

from footfix.enforce.ease import EaseParams, displacement, gamma, presence
from footfix.enforce.ik import Hinge, staying
from footfix.enforce.swing import more_bent, within_bounds
from footfix.enforce.toe import _no_faster
from footfix.motion import banded
from footfix.motion.clip import Floats

DT = 1.0 / 120.0
PARAMS = EaseParams()


def knee(flexion: Floats, thigh: float = 0.42, shank: float = 0.4) -> Hinge:
    ones = np.ones(len(flexion))
    axis = np.tile([1.0, 0.0, 0.0], (len(flexion), 1))
    return Hinge(axis, flexion, (thigh**2 + shank**2) * ones, 2.0 * thigh * shank * ones, float(flexion.min()))


def swinging(frames: int = 120, straight: float = 4.0) -> tuple[Floats, np.ndarray]:
    """A knee that swings between two plants, and flutters while it is nearly straight."""
    t = np.linspace(0.0, 1.0, frames)
    flexion = straight + 50.0 * np.exp(-(((t - 0.4) / 0.12) ** 2))
    flexion[80:92] += np.abs(np.sin(np.linspace(0.0, 2.0 * np.pi, 12))) * 4.0
    known = np.ones(frames, dtype=bool)
    known[20:100] = False
    return np.radians(flexion), known


def test_a_knee_keeps_what_is_known_and_goes_on_from_it() -> None:
    flexion, known = swinging()
    more = np.where(np.arange(len(flexion)) < 60, np.radians(6.0), np.radians(18.0))
    near = np.ones_like(known)
    d = more_bent(knee(flexion), more, known, near, DT, PARAMS)
    assert np.array_equal(d[known], more[known])
    assert np.abs(np.diff(d)).max() < np.radians(2.0)  # no jump anywhere
    near[40:60] = False
    assert not more_bent(knee(flexion), more, known, near, DT, PARAMS)[40:60].any()


def test_a_straight_knees_flutter_is_not_handed_to_the_foot() -> None:
    flexion, known = swinging()
    hinge, more = knee(flexion), np.full(len(flexion), np.radians(18.0))
    near = np.ones_like(known)
    alone = displacement(known, more[:, None], near, DT, PARAMS)[:, 0]
    both = more_bent(hinge, more, known, near, DT, PARAMS)

    def jerks(d: Floats) -> float:  # of the foot, along the leg
        return float(np.abs(np.diff(hinge.length(flexion + d) - hinge.length(flexion), n=3))[76:92].mean())

    assert jerks(both) < 0.5 * jerks(alone)


def test_length_and_slope_agree_with_differences() -> None:
    flexion, _ = swinging()
    hinge = knee(flexion)
    h = 1e-6
    differences = (hinge.length(flexion + h) - hinge.length(flexion - h)) / (2.0 * h)
    assert np.allclose(hinge.slope(flexion), differences, atol=1e-8)
    # law of cosines with the angle inside the knee
    inside = np.pi - flexion
    assert np.allclose(hinge.length(flexion) ** 2, 0.42**2 + 0.4**2 - 2.0 * 0.42 * 0.4 * np.cos(inside))


@pytest.mark.parametrize("more", [-30.0, -8.0, -2.0, 0.0, 5.0])
def test_a_swinging_knee_is_never_straighter_than_it_was(more: float) -> None:
    flexion, known = swinging()
    d = np.where(known, 0.0, np.radians(more))
    share = np.where(known, 0.0, 1.0)
    bent = within_bounds(knee(flexion), d, share, ~known, DT, PARAMS)
    assert bent.min() >= flexion.min() - 1e-12
    if more > 0.0:
        assert np.degrees(np.abs(bent - flexion - d)[30:90].max()) < 1.0
    if more == 0.0:  # nothing is asked, nothing changes
        assert np.allclose(bent, flexion, atol=1e-9)


def test_product_is_what_solve_undoes() -> None:
    random = np.random.default_rng(1)
    for frames in (3, 4, 50, 301):
        bands = random.normal(size=(3, frames))
        bands[0] = 8.0 + np.abs(bands[0])
        x = random.normal(size=frames)
        assert np.allclose(banded.solve(bands, banded.product(bands, x)[:, None])[:, 0], x)


def test_toes_are_no_faster_than_they_may_be() -> None:
    frames, most = 100, 0.02
    exact = np.zeros(frames, dtype=bool)
    exact[40:60] = True
    held = np.tile([0.4, -0.1, 0.0], (frames, 1))
    out = _no_faster(held, np.zeros((frames, 3)), exact, most)
    assert np.array_equal(out[exact], held[exact])
    assert np.abs(np.diff(out, axis=0)).max() <= most + 1e-12
    assert not out[:19].any() and not out[81:].any()  # 0.4 in steps of 0.02, and then what was eased


def test_presence_is_told_by_the_nearest_frame_that_does_not_change() -> None:
    random = np.random.default_rng(2)
    for _ in range(20):
        changed = random.random(60) < 0.8
        risen = presence(changed, DT, 5 * DT)
        still = np.flatnonzero(~changed)
        for t in range(60):
            far = np.abs(still - t).min(initial=60)
            assert risen[t] == pytest.approx(1.0 - float(gamma(np.array(min(far / 5.0, 1.0)))) if changed[t] else 0.0)


def test_a_knee_whose_foot_stays_keeps_its_side() -> None:
    forwards = np.radians(np.linspace(5.0, 60.0, 12))
    assert np.allclose(staying(knee(forwards), forwards + 0.1), 0.1)
    # overstretched by little: as it is while nothing is asked, through straight where much is
    little = np.radians(np.array([1.0, -4.0, -4.0, 1.0]))
    assert np.allclose(staying(knee(little), np.abs(little)), 0.0)
    bent = np.full(4, np.radians(40.0))
    assert np.allclose(little + staying(knee(little), bent), bent, atol=np.radians(1.0))
    # bent backwards it goes on backwards, by as much as forwards it would forwards, and changes sides without a jump
    backwards = np.radians(np.linspace(10.0, -70.0, 200))
    more = staying(knee(backwards), np.abs(backwards) + 0.2)
    assert np.allclose(more[backwards > 0.0], 0.2) and np.allclose(more[backwards < np.radians(-35.0)], -0.2)
    assert np.abs(np.diff(more)).max() < 0.01

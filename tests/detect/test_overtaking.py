"""A foot that goes ahead of a pelvis that travels swings; one that falls behind, or shakes on the spot, may stand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from footfix.detect.overtaking import OvertakingParams, ahead
from footfix.motion.clip import Floats

PARAMS = OvertakingParams()
STEPS = 50


def going(x: float, z: float) -> Floats:
    return np.tile([x, z], (STEPS, 1))


def swings(foot: tuple[float, float], pelvis: tuple[float, float], drift: tuple[float, float] = (0.0, 0.0)) -> float:
    """How likely a foot swings that goes as fast, both it and the pelvis taken along by a drift [leg lengths/s]."""
    own = going(foot[0] + drift[0], foot[1] + drift[1])
    travel = going(pelvis[0] + drift[0], pelvis[1] + drift[1])
    found = ahead(np.stack([own, own], axis=1), travel, travel, PARAMS)
    assert np.ptp(found) == 0.0
    return float(found[0])


def test_a_foot_that_goes_twice_as_fast_as_the_pelvis_swings_and_one_at_rest_does_not() -> None:
    for pelvis in ((0.0, 1.0), (0.8, -0.6)):
        assert swings((2.0 * pelvis[0], 2.0 * pelvis[1]), pelvis) > 0.99
        assert swings((0.0, 0.0), pelvis) == 0.0
        assert swings(pelvis, pelvis) == 0.0, "what goes along with the pelvis is no evidence"


@pytest.mark.parametrize("scale", [0.3, 0.8, 1.3, 2.0])
def test_a_foot_that_stands_skates_with_a_way_that_is_scaled_and_does_not_swing(scale: float) -> None:
    assert swings((0.0, scale - 1.0), (0.0, scale)) == 0.0


def test_it_is_as_likely_as_not_where_the_parameters_say() -> None:
    travel = 3.0  # fast enough that it certainly travels
    even = travel + PARAMS.least + PARAMS.share * travel
    assert swings((0.0, even), (0.0, travel)) == pytest.approx(0.5, abs=1e-6)


def test_beside_a_pelvis_that_sways_nothing_is_told() -> None:
    foot = going(0.0, 3.0)
    sway = going(0.0, 0.5)
    found = ahead(np.stack([foot, foot], axis=1), sway, 0.1 * sway, PARAMS)
    assert found.max() < 1e-4


def test_the_slower_of_heel_and_toe_counts_and_headings_do_not() -> None:
    random = np.random.default_rng(3)
    foot, pelvis = random.normal(size=(STEPS, 2, 2)), random.normal(size=(STEPS, 2))
    angle = 0.7
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    found = ahead(foot, pelvis, pelvis, PARAMS)
    assert_allclose(ahead(foot @ turn, pelvis @ turn, pelvis @ turn, PARAMS), found, atol=1e-12)
    assert_array_equal(ahead(foot[:, ::-1], pelvis, pelvis, PARAMS), found)
    each = [ahead(np.stack([foot[:, k]] * 2, axis=1), pelvis, pelvis, PARAMS) for k in (0, 1)]
    assert_allclose(found, np.minimum(*each))

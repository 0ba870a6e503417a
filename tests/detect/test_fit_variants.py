"""What detection learns from: changed takes stay what their truth says of them."""

from __future__ import annotations

import sys
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "benchmarks"))

import fit_variants
from fit_takes import Take, made

from footfix.detect.network import SWING


@cache
def takes() -> tuple[Take, ...]:
    return tuple(made(6, seed=3))


@pytest.mark.parametrize("seed", range(6))
def test_a_forefoot_landing_keeps_the_foot_rigid_its_lowest_point_and_its_stances(seed: int) -> None:
    take = takes()[seed]
    changed = fit_variants.on_forefoot(take, np.random.default_rng(seed))
    for a, b in (("ankle", "heel"), ("ankle", "toe"), ("heel", "toe")):
        before, after = (np.linalg.norm(getattr(t, a) - getattr(t, b), axis=-1) for t in (take, changed))
        assert after == pytest.approx(before, abs=1e-9)
    lowest, now = (np.minimum(t.heel[..., 1], t.toe[..., 1]) for t in (take, changed))
    assert now == pytest.approx(lowest, abs=1e-9)
    assert np.array_equal(changed.hip, take.hip)
    assert np.array_equal(changed.allowed[:, :, SWING], take.allowed[:, :, SWING])
    assert changed.allowed.any(axis=2).all()


@pytest.mark.parametrize("seed", range(6))
def test_a_forefoot_landing_has_the_heel_up_when_the_foot_lands(seed: int) -> None:
    take = takes()[seed]
    changed = fit_variants.on_forefoot(take, np.random.default_rng(seed))
    lands = ~take.stands[:-1] & take.stands[1:]
    up = (changed.heel - changed.toe)[1:, :, 1] - (take.heel - take.toe)[1:, :, 1]
    assert np.all(up[lands] > 0.02)


@pytest.mark.parametrize("seed", range(20))
def test_clips_that_a_take_is_cut_into_follow_each_other(seed: int) -> None:
    cuts = fit_variants._cuts(700, np.random.default_rng(seed))
    assert cuts[0].start == 0
    assert cuts[-1].stop == 700
    assert all(one.stop == other.start for one, other in pairwise(cuts))
    assert all(cut.stop - cut.start >= 50 for cut in cuts)
    assert fit_variants._cuts(700, None) == [slice(0, 700)]

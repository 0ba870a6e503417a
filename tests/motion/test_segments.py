"""Reductions over stretches of frames are what a loop over the stretches gives."""

from __future__ import annotations

import numpy as np
from hypothesis import given, strategies

from footfix.motion.segments import geometric_medians, segments

SPANS = strategies.lists(
    strategies.tuples(strategies.integers(0, 40), strategies.integers(1, 12)), min_size=1, max_size=6
).map(lambda pairs: [(a, a + n) for a, n in pairs])


@given(SPANS, strategies.integers(0, 2**32 - 1))
def test_reductions_of_some_frames_are_those_of_each_stretch(spans: list[tuple[int, int]], seed: int) -> None:
    random = np.random.default_rng(seed)
    whole = segments(spans)
    keep = random.random(len(whole.frames)) < 0.5
    keep[whole.starts + random.integers(0, whole.lengths)] = True  # at least one in each
    values = random.normal(size=60)
    for parts, used in ((whole, np.ones_like(keep)), (whole.kept(keep), keep)):
        laid = values[parts.frames]
        own = [values[a:b][used[at : at + b - a]] for (a, b), at in zip(spans, whole.starts, strict=True)]
        assert np.allclose(parts.median(laid), [np.median(each) for each in own])
        for share in (0.0, 0.05, 0.5, 0.73, 1.0):
            assert np.array_equal(parts.quantile(laid, share), [np.quantile(each, share) for each in own])
        assert np.allclose(parts.mean(laid), [np.mean(each) for each in own])
        assert np.allclose(parts.largest(laid), [np.max(each) for each in own])
    assert [int(whole.frames[m]) for m in whole.middle()] == [a + (b - a) // 2 for a, b in spans]
    assert len(segments([]).median(np.zeros(0))) == len(segments([]).kept(np.zeros(0, bool))) == 0


@given(SPANS, strategies.integers(0, 2**32 - 1))
def test_geometric_medians_of_many_are_those_of_each(spans: list[tuple[int, int]], seed: int) -> None:
    parts = segments(spans)
    points = np.random.default_rng(seed).normal(size=(len(parts.frames), 3))
    together = geometric_medians(points, parts)
    for k, (at, n) in enumerate(zip(parts.starts, parts.lengths, strict=True)):
        alone = geometric_medians(points[at : at + n], segments([(0, int(n))]))[0]
        assert np.allclose(together[k], alone, atol=1e-12)


def test_a_geometric_median_knows_no_axes_and_no_outlier() -> None:
    random = np.random.default_rng(1)
    points = np.concatenate([0.001 * random.normal(size=(20, 2)), np.full((5, 2), 0.5)])
    place = geometric_medians(points, segments([(0, 25)]))[0]
    assert np.linalg.norm(place) < 0.01
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    assert np.allclose(geometric_medians(points @ turn.T, segments([(0, 25)]))[0], turn @ place)

"""From a solution on few frames to one on all: natural cubic splines, held against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from footfix.enforce.solve import interpolated


@pytest.mark.parametrize(("first", "every", "count"), [(0, 3, 9), (4, 5, 12), (2, 1, 4), (7, 4, 5)])
def test_between_frames_lies_a_natural_cubic_spline(first: int, every: int, count: int) -> None:
    at = first + every * np.arange(count)
    x = np.random.default_rng(count).normal(size=(5, count))
    wanted = np.arange(first, at[-1] + 1)
    expected = CubicSpline(at, x, axis=1, bc_type="natural")(wanted)
    assert interpolated(x, at, wanted) == pytest.approx(expected)
    beyond = interpolated(x, at, np.array([at[-1] + 1, at[-1] + 20]))
    assert beyond == pytest.approx(np.repeat(x[:, -1:], 2, axis=1))


def test_between_two_frames_lies_a_line() -> None:
    found = interpolated(np.array([[1.0, 3.0]]), np.array([10, 14]), np.arange(10, 15))
    assert found == pytest.approx(np.array([[1.0, 1.5, 2.0, 2.5, 3.0]]))

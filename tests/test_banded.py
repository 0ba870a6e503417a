"""The five-diagonal solver, with scipy as the oracle."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solveh_banded

from footfix.motion.banded import solve

RNG = np.random.default_rng(2)


@pytest.mark.parametrize("frames", [1, 2, 3, 4, 5, 31, 32, 33, 34, 35, 36, 67, 1000, 4097])
def test_solve_is_scipys(frames: int) -> None:
    bands = np.zeros((3, frames))
    bands[0] = RNG.uniform(0.0, 1.0, frames) * (RNG.random(frames) < 0.3) + 1e-6
    # a smoothing spline's own matrix: second differences, and a little of the first
    if frames > 2:
        for offset, weight in ((0, 1.0), (1, 4.0), (2, 1.0)):
            bands[0, offset : frames - 2 + offset] += weight * 30.0
        for offset in (0, 1):
            bands[1, offset : frames - 2 + offset] -= 2.0 * 30.0
        bands[2, : frames - 2] += 30.0
    right = RNG.normal(size=(frames, 3))
    solution = solve(bands, right)
    theirs = solveh_banded(bands[: min(3, frames)], right, lower=True) if frames > 2 else right / bands[0][:, None]
    assert np.allclose(solution, theirs, rtol=1e-6, atol=1e-7 * np.abs(theirs).max())

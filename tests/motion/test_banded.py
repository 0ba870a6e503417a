"""Banded systems against numpy's dense solver, an independent oracle; both ways to LAPACK; and what loads."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from footfix.motion import banded
from footfix.motion.banded import solve_banded, solve_tridiagonal
from footfix.motion.clip import Floats


def dense(bands: Floats) -> Floats:
    """(n, n) the symmetric matrix of its columns (n, w) from the diagonal down."""
    n, width = bands.shape
    out = np.zeros((n, n))
    for c in range(n):
        end = min(c + width, n)
        out[c:end, c] = out[c, c:end] = bands[c, : end - c]
    return out


def some(n: int, width: int) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(width)
    bands = rng.normal(size=(n, width))
    bands[:, 0] = 4.0 * width
    return bands, rng.normal(size=n)


@pytest.fixture(params=["from the table of functions", "from scipy.linalg"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param == "from scipy.linalg":  # as where scipy has no such table
        monkeypatch.setattr(banded, "_c_function", lambda name: None)
    else:
        assert banded._c_function("dpbsv") and banded._c_function("dptsv"), "this scipy's table is not understood"


@pytest.mark.usefixtures("way")
@pytest.mark.parametrize(("n", "width"), [(1, 1), (5, 2), (40, 17), (90, 39)])
def test_a_banded_solution_is_that_of_the_dense_matrix(n: int, width: int) -> None:
    bands, right = some(n, width)
    expected = np.linalg.solve(dense(bands), right)
    assert np.allclose(solve_banded(bands.copy(), right.copy()), expected, rtol=1e-12, atol=1e-13)


@pytest.mark.usefixtures("way")
def test_a_tridiagonal_solution_is_that_of_the_dense_matrix_and_leaves_its_input_alone() -> None:
    bands, _ = some(30, 2)
    main, beside, right = bands[:, 0].copy(), bands[:-1, 1].copy(), np.random.default_rng(0).normal(size=(30, 3))
    given = [each.copy() for each in (main, beside, right)]
    assert np.allclose(solve_tridiagonal(main, beside, right), np.linalg.solve(dense(bands), right), rtol=1e-12)
    assert all(map(np.array_equal, (main, beside, right), given))


@pytest.mark.usefixtures("way")
def test_a_matrix_that_is_not_positive_definite_is_an_error() -> None:
    bands, right = some(20, 3)
    bands[11, 0] = -1.0
    with pytest.raises(np.linalg.LinAlgError):
        solve_banded(bands, right)
    with pytest.raises(np.linalg.LinAlgError):
        solve_tridiagonal(-np.ones(4), np.zeros(3), np.ones((4, 1)))


@pytest.mark.parametrize("first", ["", "import scipy.linalg; "])
def test_all_of_scipy_linalg_is_loaded_only_where_it_was_and_works_afterwards(first: str) -> None:
    code = (
        "import sys, numpy as np; from footfix.motion.banded import solve_banded; "
        "x = solve_banded(np.full((9, 1), 2.0), np.ones(9)); loaded = 'scipy.linalg' in sys.modules; "
        "from scipy.linalg import cython_lapack, solveh_banded; "
        "print(loaded, np.array_equal(x, solveh_banded(np.full((1, 9), 2.0), np.ones(9))))"
    )
    found = subprocess.run([sys.executable, "-c", first + code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == [str(bool(first)), "True"]

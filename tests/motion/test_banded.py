"""Banded systems are solved as dense ones are."""

from __future__ import annotations

import numpy as np
import pytest

from footfix.motion import banded
from footfix.motion.banded import solve_banded


def system(below: int, size: int = 30) -> tuple[np.ndarray, np.ndarray]:
    """The bands of a positive definite matrix, and the matrix."""
    random = np.random.default_rng(below)
    bands = random.normal(size=(below + 1, size))
    bands[0] = 4.0 * (below + 1)
    whole = np.diag(bands[0])
    for k in range(1, below + 1):
        bands[k, size - k :] = 0.0
        whole += np.diag(bands[k, : size - k], -k) + np.diag(bands[k, : size - k], k)
    return bands, whole


@pytest.mark.parametrize("below", [1, 2, 7])
@pytest.mark.parametrize("public", [False, True])
def test_the_solution_is_that_of_the_dense_matrix(below: int, public: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """With LAPACK alone, and with all of `scipy.linalg` where that is not found."""
    bands, whole = system(below)
    right = np.random.default_rng(1).normal(size=(30, 3))
    banded._lapack.cache_clear()
    if public:
        monkeypatch.setattr(banded.importlib.machinery.PathFinder, "find_spec", lambda *_: None)
    for wanted in (right, right[:, 0]):
        assert np.allclose(solve_banded(bands.copy(), wanted), np.linalg.solve(whole, wanted), rtol=1e-12)
    assert ("scipy" in banded._lapack().__name__) == public
    banded._lapack.cache_clear()


@pytest.mark.parametrize("below", [1, 2])
def test_a_matrix_that_is_not_positive_definite_is_refused(below: int) -> None:
    bands, _ = system(below)
    bands[0, 3] = -1.0
    with pytest.raises(np.linalg.LinAlgError, match="row 4"):
        solve_banded(bands, np.ones(30))

"""Solve linear systems with symmetric positive definite banded matrices, by LAPACK."""

from __future__ import annotations

import importlib.machinery
import importlib.util
from functools import cache
from typing import Any

import numpy as np

from footfix.motion.clip import Floats


def solve_banded(bands: Floats, right: Floats) -> Floats:
    """Solve a system by Cholesky's decomposition of its matrix.

    Args:
        bands: (k + 1, N) the main diagonal, and the k below it; Fortran's order saves a copy, and is overwritten then.
        right: (N,) or (N, D).

    Returns:
        The solution, of the shape of `right`.

    Raises:
        numpy.linalg.LinAlgError: the matrix is not positive definite.
    """
    if len(bands) == 2:
        *_, found, failed = _lapack().dptsv(bands[0], bands[1, :-1], right)
    else:
        _, found, failed = _lapack().dpbsv(bands, right, lower=1, overwrite_ab=1)
    if failed:
        raise np.linalg.LinAlgError(f"the matrix is not positive definite: row {failed}")
    return np.asarray(found)


@cache
def _lapack() -> Any:
    """Load LAPACK as scipy has it, but not all of `scipy.linalg`: that takes 0.4 s, longer than a short clip's solving.

    Where scipy's files are arranged otherwise than they were so far, all of it is loaded.
    """
    home = importlib.util.find_spec("scipy")
    folders = [f"{each}/linalg" for each in home.submodule_search_locations or ()] if home else []
    found = importlib.machinery.PathFinder.find_spec("_flapack", folders)
    try:
        import scipy  # finds the libraries that LAPACK needs

        assert found is not None and found.loader is not None and scipy
        lapack = importlib.util.module_from_spec(found)
        found.loader.exec_module(lapack)
        assert hasattr(lapack, "dpbsv") and hasattr(lapack, "dptsv")
    except (ImportError, AssertionError, OSError):
        from scipy.linalg import lapack
    return lapack

"""Symmetric positive definite systems whose matrix has a few diagonals only, solved by LAPACK.

LAPACK comes with scipy. `scipy.linalg` is not used if it can be helped: to load all of it takes as long as to solve a
short clip, and no other thread runs while its functions do. scipy offers the same LAPACK to compiled code, as a table
of C functions (`scipy.linalg.cython_lapack`); called from there it has neither fault.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from functools import cache
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from types import ModuleType
from typing import Any

import numpy as np
import scipy

from footfix.motion.clip import Floats

_TABLE = "scipy.linalg.cython_lapack"
# The C functions, and the types of their arguments: letters, counts, and arrays of doubles.
_ARGUMENTS = {"dpbsv": "char int int int _d int _d int int", "dptsv": "int int _d _d _d int int"}


def solve_banded(bands: Floats, right: Floats) -> Floats:
    """Solve A x = b by a Cholesky decomposition.

    Args:
        bands: (n, w) each column of A from its diagonal down; used up.
        right: (n,) b; used up.

    Raises:
        np.linalg.LinAlgError: A is not positive definite.
    """
    n, width = bands.shape
    call = _c_function("dpbsv")
    if call is None:
        from scipy.linalg.lapack import dpbsv

        _, right, info = dpbsv(bands.T, right, lower=1, overwrite_ab=1, overwrite_b=1)
    else:
        info = call(b"L", n, width - 1, 1, bands, width, right, n)
    return _sure(right, info)


def solve_tridiagonal(main: Floats, beside: Floats, right: Floats) -> Floats:
    """Solve A x = b for several right-hand sides.

    Args:
        main: (n,) diagonal of A.
        beside: (n - 1,) the one below it, and above it.
        right: (n, D) b.

    Raises:
        np.linalg.LinAlgError: A is not positive definite.
    """
    main, beside, out = main.copy(), beside.copy(), np.array(right, order="F")
    n, count = out.shape
    call = _c_function("dptsv")
    if call is None:
        from scipy.linalg.lapack import dptsv

        _, _, out, info = dptsv(main, beside, out)
    else:
        info = call(n, count, main, beside, out, n)
    return _sure(out, info)


def _sure(x: Floats, info: int) -> Floats:
    if info:
        raise np.linalg.LinAlgError(f"the matrix is not positive definite (LAPACK's info: {info})")
    return x


@cache
def _c_function(name: str) -> Callable[..., int] | None:
    """Find a function of LAPACK's C interface, which returns its `info`; None where this scipy has another."""
    try:
        capsule, api = _table().__pyx_capi__[name], ctypes.pythonapi
        api.PyCapsule_GetName.restype, api.PyCapsule_GetName.argtypes = ctypes.c_char_p, [ctypes.py_object]
        api.PyCapsule_GetPointer.restype = ctypes.c_void_p
        api.PyCapsule_GetPointer.argtypes = [ctypes.py_object, ctypes.c_char_p]
        signature = api.PyCapsule_GetName(capsule)
        kinds = _ARGUMENTS[name].split()
        stated = signature.decode().removeprefix("void (").removesuffix(" *)").split(" *, ")
        if len(stated) != len(kinds) or not all(map(str.endswith, stated, kinds)):
            return None
        pointer = api.PyCapsule_GetPointer(capsule, signature)
    except (ImportError, AttributeError, KeyError, ValueError):
        return None
    function = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(kinds))(pointer)

    def call(*arguments: Any) -> int:
        info = ctypes.c_int()
        function(*(_address(each) for each in arguments), ctypes.byref(info))
        return info.value

    return call


def _table() -> ModuleType:
    """Load scipy's table of LAPACK's functions, without the rest of `scipy.linalg` where that is not loaded yet."""
    if _TABLE in sys.modules:
        return sys.modules[_TABLE]
    spec = PathFinder.find_spec(_TABLE.rpartition(".")[2], [f"{each}/linalg" for each in scipy.__path__])
    if spec is None or spec.loader is None:
        raise ImportError(_TABLE)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _address(argument: Any) -> Any:
    """Pass an argument as Fortran takes it: by its address."""
    if isinstance(argument, np.ndarray):
        return argument.ctypes.data
    return argument if isinstance(argument, bytes) else ctypes.byref(ctypes.c_int(argument))

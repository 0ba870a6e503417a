"""Splines against scipy's, an independent oracle."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

from footfix.motion.spline import monotone, spline

AT = np.array([0.0, 0.7, 1.1, 2.0, 3.5, 4.0, 5.2])
VALUES = np.random.default_rng(1).normal(size=(7, 2))


@pytest.mark.parametrize("derivative", [0, 1, 2])
def test_a_spline_is_the_natural_one(derivative: int) -> None:
    wanted = np.linspace(0.0, 5.2, 101)
    known = CubicSpline(AT, VALUES, bc_type="natural")
    assert np.allclose(spline(AT, VALUES)(wanted, derivative), known(wanted, derivative), atol=1e-9)


def test_two_and_three_values_are_enough() -> None:
    wanted = np.linspace(0.0, 1.1, 11)
    assert np.allclose(spline(AT[:2], VALUES[:2])(AT[:2]), VALUES[:2])
    known = CubicSpline(AT[:3], VALUES[:3], bc_type="natural")
    assert np.allclose(spline(AT[:3], VALUES[:3])(wanted), known(wanted), atol=1e-12)


def test_a_closed_spline_is_the_periodic_one() -> None:
    values = np.concatenate([VALUES[:-1], VALUES[:1]])
    wanted = np.linspace(0.0, 5.2, 101)
    found, known = spline(AT, values, closed=True), CubicSpline(AT, values, bc_type="periodic")
    for derivative in (0, 1, 2):
        assert np.allclose(found(wanted, derivative), known(wanted, derivative), atol=1e-7)


def test_a_monotone_curve_never_swings_out() -> None:
    rising = np.cumsum(np.abs(VALUES), axis=0)
    wanted = np.linspace(0.0, 5.2, 1001)
    assert np.all(np.diff(monotone(AT, rising)(wanted), axis=0) >= -1e-12)
    inside = wanted[(wanted > AT[1]) & (wanted < AT[-2])]
    assert np.allclose(monotone(AT, rising)(inside), PchipInterpolator(AT, rising)(inside), atol=1e-9)

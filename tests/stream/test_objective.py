"""The objective of a window is that of `enforce.terms`, term by term."""

from __future__ import annotations

import numpy as np
import pytest
from streams import legs_of, pins_stacked, sample

from footfix.enforce.objective import linearised, objective
from footfix.enforce.params import EnforceParams
from footfix.enforce.problem import Problem
from footfix.enforce.solve import descend as descend_clip
from footfix.enforce.task import task_of
from footfix.enforce.whole_clip import problem_of
from footfix.motion.clip import Floats
from footfix.pipeline import find_contacts, prepare
from footfix.rig.find import find_rigs
from footfix.settings import Settings
from footfix.stream.gauss_newton import Fixed, descend
from footfix.stream.objective import normal


def problem(start: int = 40, frames: int = 24) -> Problem:
    """A window of a walk that skates."""
    clip, settings = sample("walk_skate").clip, Settings()
    rigs = find_rigs(clip)
    prepared = prepare(clip, settings, rigs, slice(0, len(clip)))
    contacts = find_contacts(prepared, settings)
    part = clip.frames(slice(start, start + frames))
    mask = contacts.mask()[start : start + frames]
    own = rigs[0].no_contacts(part).with_mask(mask)
    params = EnforceParams(cycle="no")
    return problem_of(part, rigs[0], task_of(part, rigs[0], own, params), params, (False, False))


def state(of: Problem, size: float) -> Floats:
    return np.random.default_rng(5).normal(size=(of.unknowns, of.frames)) * size * of.free()[:, None]


@pytest.mark.parametrize("static", [1.0, 8.0])
@pytest.mark.parametrize("size", [0.003, 0.1])
def test_gradient_and_matrix_are_those_of_a_whole_clip(static: float, size: float) -> None:
    of = problem()
    x = state(of, size)
    known = linearised(of, x, 1e-5, static=static)
    ours = normal(of, legs_of(of.legs), pins_stacked(of.pins), x, 1e-5, static)
    assert np.allclose(ours.gradient.T, known.gradient, rtol=1e-9, atol=1e-9 * np.abs(known.gradient).max())
    lower = np.tril(known.main)
    assert np.allclose(np.tril(ours.main), lower, rtol=1e-9, atol=1e-9 * np.abs(lower).max())
    assert np.allclose(ours.next.swapaxes(1, 2), known.next, rtol=1e-9, atol=1e-9 * np.abs(known.next).max())
    assert np.array_equal(ours.near, known.near)


def test_descent_goes_where_that_of_a_whole_clip_goes_and_leaves_the_past_alone() -> None:
    of = problem()
    x = np.zeros((of.unknowns, of.frames))
    stacked = {"legs": legs_of(of.legs), "pins": pins_stacked(of.pins), "fixed": Fixed.of(of)}
    found = x
    for _ in range(25):
        found = descend(of, found, 3, **stacked)  # type: ignore[arg-type]
    assert np.array_equal(found[:, :3], x[:, :3])
    fixed = np.arange(of.frames) < 3
    known = descend_clip(of, x, 25, first=8e-4, fixed=fixed)
    eps = 2e-4 * of.frame_time
    least = objective(of, known, eps)
    assert objective(of, found, eps) < objective(of, x, eps)
    assert objective(of, found, eps) < least + 0.02 * (objective(of, x, eps) - least)

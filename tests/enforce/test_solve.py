"""The solver: a banded step is a dense one, what is fixed stays, nothing rises, and what must slide slides at once."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import artefacts
import numpy as np
import pytest
from legmaker import figure_of
from problems import FREE, dense, idle, places, problem, state, system
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce import solve as solver
from footfix.enforce.costs import RATE, CostParams
from footfix.enforce.leg import HEEL, LEG, ROOT, TOE, B
from footfix.enforce.objective import linearised, objective
from footfix.enforce.params import EnforceParams
from footfix.enforce.problem import Problem, _onward
from footfix.enforce.solve import EPS, descend, solve, thinned
from footfix.enforce.task import task_of
from footfix.enforce.whole_clip import costs_of, problem_of
from footfix.motion.clip import Floats

# A quadratic problem: legs that can't turn, and a root that is wanted elsewhere.
SPRINGS = CostParams(slide=0.0, speed=1e9, root_farthest=1e9, line_farthest=1e9, ankle_farthest=1e9)


def pulled(frames: int = 9) -> Problem:
    """A root whose heel is wanted 2 cm away in some frames: NEAR and PLACE, both quadratic in what may change."""
    base = places(problem(frames=frames), np.zeros((ROOT + LEG, frames)))[0][HEEL]
    at = np.where(np.arange(frames) % 4 == 1, 0.001, 0.0)
    pin = replace(idle(frames), place=base + [[0.02], [0.0], [0.01]], placed=at)
    of = problem({(0, HEEL): pin}, frames=frames, costs=SPRINGS)
    return replace(of, legs=tuple(replace(leg, turns=False) for leg in of.legs))


def skating(fps: float = 60.0, frames: int = 150) -> Problem:
    """A walker that wanders, with its true contacts."""
    made = walk("walk", fps, 3.0)
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.04, slowest=1.0).frames(slice(0, frames))
    contacts = replace(made.contacts, frames=frames).with_mask(made.contacts.mask()[:frames])
    return problem_of(clip, rig, task_of(clip, rig, contacts, EnforceParams()), EnforceParams(), (False, False))


def least(of: Problem, fixed: Floats | None = None, x: Floats | None = None) -> Floats:
    """(U, F) where a quadratic objective is least, by a dense solve; `fixed` (F,) frames stay at x."""
    start = np.zeros((of.unknowns, of.frames)) if x is None else x
    found = system(of, start, EPS)
    matrix, right = dense(found), -found.gradient.T.ravel()
    free = np.tile(of.free(), of.frames)
    if fixed is not None:
        free &= ~np.repeat(fixed.astype(bool), of.unknowns)
    step = np.zeros(len(right))
    step[free] = np.linalg.solve(matrix[np.ix_(free, free)], right[free])
    return start + step.reshape(of.frames, of.unknowns).T


def test_a_step_is_that_of_a_dense_solve() -> None:
    made = skating(frames=20)
    x = 0.3 * state(made)
    made = replace(made, root_moves=False, legs=(replace(made.legs[0], bends=False), made.legs[1]))
    found, free = linearised(made, x, 1e-3), made.free()
    assert np.flatnonzero(~free).tolist() == [0, 1, 2, ROOT + B]
    fixed = np.zeros(20, dtype=bool)
    fixed[[0, 1, 7, 19]] = True
    damped = dense(found)
    s0, _ = made.near()
    damped += np.diag(np.tile(solver.DAMPING * 60.0 * made.frame_time / s0**2, 20))
    for held in (None, fixed):
        on = np.tile(free, 20) & ~np.repeat(np.zeros(20, dtype=bool) if held is None else held, made.unknowns)
        expected = np.zeros(len(on))
        expected[on] = np.linalg.solve(damped[np.ix_(on, on)], -found.gradient.T.ravel()[on])
        step = solver._step(made, found, held)
        assert np.allclose(step.T.ravel(), expected, rtol=1e-6, atol=1e-9 * np.abs(expected).max())
        assert not step[~free].any()


def test_descent_ends_where_a_quadratic_objective_is_least() -> None:
    of = pulled()
    expected = least(of)
    assert np.abs(expected[:ROOT]).max() > 1e-3 and not expected[ROOT:].any()
    found = descend(of, np.zeros_like(expected), 60, first=EPS)
    assert np.allclose(found, expected, atol=1e-6 * np.abs(expected).max())
    assert objective(of, found, EPS) <= objective(of, expected, EPS) * (1.0 + 1e-9)


def test_fixed_frames_keep_their_state_and_the_rest_is_the_best_beside_them() -> None:
    of = pulled(12)
    x = np.zeros((of.unknowns, 12))
    x[:ROOT, :4] = 0.01 * np.random.default_rng(0).normal(size=(ROOT, 4))
    fixed = np.arange(12) < 4
    found = descend(of, x, 60, first=EPS, fixed=fixed)
    assert np.array_equal(found[:, :4], x[:, :4])
    expected = least(of, fixed, x)
    assert np.allclose(found, expected, atol=1e-6)
    assert np.abs(expected - least(of))[:, 4:].max() > 1e-4, "the past was to matter"


def test_a_past_held_fixed_at_the_solution_leads_on_to_the_solution() -> None:
    """What a stream does: with the frames before a cut at their optimum, the rest comes out as it was."""
    of = skating(60.0, 120)
    whole = descend(of, np.zeros((of.unknowns, 120)), 30, first=0.06)
    fixed = np.arange(120) < 60
    start = np.where(fixed, whole, 0.0)
    again = descend(of, start, 30, first=0.06, fixed=fixed)
    assert np.array_equal(again[:, :60], whole[:, :60])
    off = np.abs(again - whole)[:, 60:]
    assert off.max() < 1e-5 < 1e-3 < np.abs(whole[:, 60:]).max()


def test_a_root_that_is_no_unknown_stays_and_the_legs_step_as_in_a_dense_solve_without_it() -> None:
    of = skating(60.0, 30)
    x = 0.2 * state(of)
    step = sum(solver._step(of, linearised(of, x, 1e-3, leg=k), None) for k in range(2))
    whole = dense(system(of, x, 1e-3))
    whole += np.diag(np.tile(solver.DAMPING * 60.0 * of.frame_time / of.near()[0] ** 2, 30))
    on = np.tile(np.arange(of.unknowns) >= ROOT, 30)
    right = -system(of, x, 1e-3).gradient.T.ravel()
    expected = np.zeros(len(on))
    expected[on] = np.linalg.solve(whole[np.ix_(on, on)], right[on])
    assert np.allclose(step.T.ravel(), expected, rtol=1e-6, atol=1e-9 * np.abs(expected).max())
    found = descend(of, x, 4, first=0.06, leg=1)
    own = of.columns(1)
    assert np.array_equal(found[: own.start], x[: own.start]) and np.all(np.any(found[own] != x[own], axis=1))


def test_unknowns_that_a_file_does_not_have_stay_zero() -> None:
    of = skating(frames=60)
    stiff = replace(of, root_moves=False, legs=(replace(of.legs[0], bends=False), replace(of.legs[1], turns=False)))
    x = solve(stiff)
    assert not x[~stiff.free()].any() and np.all(np.any(x[stiff.free()] != 0.0, axis=1))


def test_kinetic_rounds_never_raise_the_objective() -> None:
    of = skating(frames=120)
    x, costs = np.zeros((of.unknowns, 120)), []
    eps = 20.0 * EPS
    for _ in range(8):
        costs.append(objective(of, x, eps * of.frame_time))
        x = descend(of, x, 1, first=eps)
    costs.append(objective(of, x, eps * of.frame_time))
    assert np.all(np.diff(costs) <= 1e-9 * costs[0]) and costs[-1] < 0.3 * costs[0]


def test_a_step_that_would_raise_the_objective_is_shortened() -> None:
    """A place half a metre away, and a root that hardly goes beyond 5 cm, which is not seen from where it stands."""
    frames = 9
    base = places(problem(frames=frames), np.zeros((ROOT + LEG, frames)))[0][HEEL]
    pin = replace(idle(frames), place=base + [[0.5], [0.0], [0.0]], placed=np.full(frames, 0.01))
    of = problem({(0, HEEL): pin}, frames=frames, costs=replace(SPRINGS, root_farthest=0.06))
    of = replace(of, legs=tuple(replace(leg, turns=False) for leg in of.legs))
    x, cost = np.zeros((of.unknowns, frames)), np.inf
    for _ in range(5):
        now = objective(of, x, EPS)
        assert now <= cost
        x, cost = descend(of, x, 1, first=EPS), now
    assert 0.06 * of.leg_length < np.abs(x[0]).max() < 0.25


def test_the_gradient_is_small_where_the_descent_ends() -> None:
    of = skating(frames=90)
    start = np.zeros((of.unknowns, 90))
    x = descend(of, start, 40, first=0.06)
    here = EPS * of.frame_time
    # where it is flat a step, not a slope, says how far the least is
    step = solver._step(of, linearised(of, x, here), None)
    first = solver._step(of, linearised(of, start, here), None)
    assert np.abs(step).max() < 0.01 * np.abs(first).max()
    slope = np.abs(system(of, x, here).gradient).max() / np.abs(system(of, start, here).gradient).max()
    assert slope < 0.01


def test_the_objective_of_the_solver_is_about_the_least() -> None:
    """The few rounds of the solver, coarse and fine, lead to where many rounds do."""
    of = skating(120.0, 120)
    found = solve(of)
    here = EPS * of.frame_time
    many = descend(of, found, 40, first=EPS)
    cost, lowest = objective(of, found, here), objective(of, many, here)
    nothing = objective(of, np.zeros_like(found), here)
    assert lowest <= cost <= lowest + 0.02 * (nothing - lowest)


# ---- friction ---------------------------------------------------------------------------------------


def torn(slide: float, slip: float) -> tuple[Problem, Floats]:
    """A figure that stands on both feet, which the capture takes apart by `slip` [m] evenly over 1.5 s."""
    made = walk("stand", 60.0, 2.0)
    rig = rig_of(made)
    frames = 90
    clip = made.clip.frames(np.zeros(frames, dtype=int))  # nothing moves
    still = figure_of(clip, rig, made.contacts)
    pins = {}
    for k in range(2):
        away = np.zeros((3, frames - 1))
        away[0] = (1 - 2 * k) * slip / (frames - 1)  # the ground itself parts under them
        pins[k, TOE] = replace(idle(frames), hold=np.ones(frames - 1), slip=away, stands=np.ones(frames, dtype=bool))
    of = problem(pins, frames=frames, legs=2, first=0, every=1, costs=replace(CostParams(), slide=slide))
    return replace(of, legs=still.legs, frame_time=1.0 / 60.0), away[0]


def slips(of: Problem, x: Floats, k: int) -> Floats:
    """(F - 1,) [m] how far the toe of a leg slips from frame to frame."""
    s = np.diff(places(of, x)[k][TOE], axis=1) - of.pins[k][TOE].slip
    return np.asarray(np.hypot(s[0], s[2]))


@pytest.mark.parametrize(("slide", "slip"), [(CostParams().slide, 0.01), (300.0, 0.3)])
def test_what_must_slide_slides_at_once(slide: float, slip: float) -> None:
    """The L1 norm: where holding is cheap all stands; where it is too dear feet slide in few frames, and far."""
    of, _ = torn(slide, slip)
    x = descend(of, np.zeros((of.unknowns, of.frames)), 40, first=0.06)
    found = np.concatenate([slips(of, x, 0), slips(of, x, 1)])
    moves = found > 0.05 * of.leg_length * of.frame_time
    if slip < 0.1:
        assert not moves.any() and found.sum() < 1e-4
    else:
        assert found.sum() > 0.1 and 0 < moves.sum() < 0.5 * len(found)
        assert found[moves].sum() > 0.9 * found.sum()
        assert np.quantile(found, 0.3) < 0.004 * of.leg_length * of.frame_time  # what stands stands


def test_a_dearer_slide_is_a_shorter_one() -> None:
    totals = []
    for slide in (0.0, 100.0, 300.0, 9000.0):
        of, _ = torn(slide, 0.3)
        x = descend(of, np.zeros((of.unknowns, of.frames)), 20, first=0.06)
        totals.append(float(slips(of, x, 0).sum() + slips(of, x, 1).sum()))
    assert np.isclose(totals[0], 0.3 * 2, rtol=1e-3)  # where it costs nothing all may slide
    assert totals[1] < 0.7 * totals[0] and totals[2] < 0.6 * totals[1] and totals[3] < 0.01 * totals[2]


def test_static_rounds_bring_what_hardly_moves_to_rest() -> None:
    of = skating(60.0, 120)
    kinetic = descend(of, np.zeros((of.unknowns, 120)), 13, first=0.06)
    static = descend(of, np.zeros((of.unknowns, 120)), 13, first=0.06, last=3)

    def rest(x: Floats) -> float:
        found = [slips(of, x, k)[of.pins[k][TOE].hold > 0.5] for k in range(2)]
        slow = np.concatenate(found) / of.frame_time
        return float(np.median(slow[slow < 0.02]))

    assert rest(static) < 0.5 * rest(kinetic)


def test_before_static_friction_comes_what_slides_in_most_frames_is_let_go() -> None:
    of = skating(60.0, 120)
    spans = ((10, 40), (50, 61), (70, 100))
    toe = replace(of.pins[0][TOE], hold=np.ones(119), spans=spans)
    x = np.zeros((of.unknowns, 120))
    slip = np.diff(places(of, x)[0][TOE], axis=1)  # ground that goes along: it stands,
    slip[0, :57] += 0.1 * of.leg_length * of.frame_time  # or goes by more than the foot: it slides
    toe = replace(toe, slip=slip)
    of = replace(of, pins=((of.pins[0][HEEL], toe, *of.pins[0][2:]), of.pins[1]))
    found = solver.settled(of, x).pins[0][TOE]
    assert found.spans == ((50, 61), (70, 100)) and found.sliding == ((10, 40),)  # three steps of ten are just enough
    sticks = found.sticking()
    assert found.hold.all() and not sticks[10:39].any() and sticks[:10].all() and sticks[39:].all()


def test_what_is_to_come_costs_as_much_as_if_its_frames_were_solved() -> None:
    """The cost of a last place and speed against the least cost of two seconds more of NEAR, with no more plants."""
    s0, s2, dt, more = np.array([0.03]), np.array([0.6]), 1.0 / 240.0, 480  # [m], [m/s^2], [s]
    told = np.zeros((3, 1, 2))
    _onward(told, s0, s2, dt)
    second = np.diff(np.eye(more + 2), 2, axis=0) / dt**2  # the first of them has the last two known frames
    near = np.eye(more + 2)[2:]
    matrix = RATE * dt * (near.T @ near / s0**2 + second.T @ second / s2**2)
    solved = matrix[:2, :2] - matrix[:2, 2:] @ np.linalg.solve(matrix[2:, 2:], matrix[2:, :2])
    stated = np.array([[told[0, 0, 0], told[1, 0, 0]], [told[1, 0, 0], told[0, 0, 1]]])
    for place, speed in ((0.02, 0.0), (0.0, 0.1), (0.02, 0.1), (0.02, -0.05)):  # [m], [m/s]
        last = np.array([place - speed * dt, place])
        assert last @ stated @ last == pytest.approx(last @ solved @ last, rel=0.04)


# ---- fewer frames -----------------------------------------------------------------------------------


def test_what_slides_is_let_go_once_before_the_rounds_with_static_friction(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Floats] = []

    def let_go(of: Problem, x: Floats, leg: int | None) -> Problem:
        asked.append(x)
        return of

    monkeypatch.setattr(solver, "settled", let_go)
    made, start = pulled(), np.zeros((pulled().unknowns, pulled().frames))
    descend(made, start, 4, first=0.01, last=2)
    assert len(asked) == 1
    assert np.array_equal(asked[0], descend(made, start, 2, first=0.01))  # as the first two of four rounds left it
    assert len(asked) == 1, "no static friction, nothing let go"


@pytest.mark.parametrize("frames", [200, 201, 203])
def test_a_thinned_problem_holds_the_same_contacts(frames: int) -> None:
    of = skating(120.0, frames)
    which = np.arange(0, frames, 4)
    rough = thinned(of, which)
    assert rough.frame_time == pytest.approx(1.0 / 30.0) and rough.frames == len(which)
    for fine, coarse in zip(of.pins, rough.pins, strict=True):
        for a, b in zip(fine, coarse, strict=True):
            for n, (start, end) in enumerate(pairwise(which)):
                assert b.hold[n] == a.hold[start:end].min()  # held on the way, not only at both ends
                assert np.allclose(b.slip[:, n], a.slip[:, start:end].sum(axis=1))
            for name in ("stands", "level", "draw", "lowest", "placed"):
                assert np.array_equal(getattr(b, name), getattr(a, name)[which])
            assert np.array_equal(b.place, a.place[:, which])
            assert len(b.hold) == len(which) - 1
    for a, b in zip(of.legs, rough.legs, strict=True):
        assert np.array_equal(b.hip, a.hip[:, which]) and np.array_equal(b.least, a.least[which])
    assert rough.costs is of.costs and rough.cut == of.cut


def test_a_motion_costs_the_same_at_any_rate() -> None:
    """A smooth state of a smooth motion: its terms are sums over time, not over frames."""
    of = skating(120.0, 241)
    t = np.arange(241) / 120.0
    x = 0.02 * np.sin(2.0 * np.pi * t / 1.3 + np.arange(of.unknowns)[:, None])
    which = np.arange(0, 241, 2)
    for costs in (
        replace(CostParams(), slide=0.0, speed=1e9),
        replace(FREE, slide=0.0, line_farthest=0.5, ankle_farthest=0.5, root_farthest=0.01),
        replace(FREE, slide=0.0),
    ):
        fine = replace(of, costs=costs, noise=np.zeros(of.unknowns))
        rough = thinned(fine, which)
        a, b = objective(fine, x, 1e-6), objective(rough, x[:, which], 2e-6)
        assert a > 0.0 and b == pytest.approx(a, rel=0.06)


@pytest.mark.parametrize("frames", [4, 5, 33, 35])
def test_clips_of_any_length_are_solved(frames: int) -> None:
    x = solve(skating(120.0, frames))
    assert x.shape[1] == frames and np.isfinite(x).all()


def test_a_root_that_shares_the_correction_goes_five_times_as_far_and_as_fast() -> None:
    own = CostParams()
    assert costs_of(EnforceParams(costs=own)) == own == costs_of(EnforceParams(costs=own, method="root"))
    shared = replace(
        own, root=5.0 * own.root, root_height=5.0 * own.root_height, root_acceleration=5.0 * own.root_acceleration,
        root_farthest=5.0 * own.root_farthest,
    )  # fmt: skip
    assert costs_of(EnforceParams(costs=own, method="both")) == shared

"""The objective, term by term: its cost, its gradient, and its matrix, against differences and by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from legmaker import figure
from problems import (
    FREE,
    curvature,
    dense,
    differences,
    idle,
    lifted_cost,
    places,
    problem,
    residuals,
    slip_cost,
    state,
    system,
)

from footfix.enforce import costs
from footfix.enforce.assembly import product
from footfix.enforce.costs import CostParams
from footfix.enforce.leg import ANKLE, HEEL, LEG, ROOT, TIP, TOE, B, K, Q, W
from footfix.enforce.objective import linearised, objective
from footfix.enforce.problem import Problem
from footfix.enforce.vertices import Vertices
from footfix.motion.clip import Floats

EPS = 1e-3  # [m]
DEG = np.pi / 180.0
SOME = np.array([0.0, 0.01, 0.02, 0.03, 0.05, 0.1, np.inf])  # [m] faults


def near() -> Problem:
    far = dict.fromkeys(("root_farthest", "line_farthest", "ankle_farthest", "toes_farthest"), 1e9)
    return problem(costs=CostParams(slide=0.0, speed=1e9, **far))


def holding(hold: float = 1.0, point: int = TOE, frames: int = 7) -> dict[tuple[int, int], object]:
    pin = idle(frames)
    slip = 0.01 * np.random.default_rng(4).normal(size=pin.slip.shape)
    return {(0, point): replace(pin, hold=hold * np.linspace(0.2, 1.0, frames - 1), slip=slip)}


def drawn(point: int = TOE) -> dict[tuple[int, int], object]:
    stands = np.arange(7) % 3 != 0
    return {(0, point): replace(idle(7), stands=stands, level=np.full(7, 0.02), draw=np.linspace(0.1, 1.0, 7))}


def floored(point: int = TIP) -> dict[tuple[int, int], object]:
    return {(0, point): replace(idle(7), lowest=np.linspace(-0.2, 0.6, 7))}


def bent_up() -> dict[tuple[int, int], object]:
    """The tip lies where it was captured, and may be up to 3 cm lower or higher over its toe joint than there."""
    toe, tip = (places(problem(), np.zeros((ROOT + LEG, 7)))[0][point][1] for point in (TOE, TIP))
    return {(0, TIP): replace(idle(7), rise=tip - toe + np.array([-0.03, 0.0, 0.03, -0.01, 0.0, np.inf, -0.02]))}


def placed(point: int = HEEL) -> dict[tuple[int, int], object]:
    place = places(problem(), np.zeros((ROOT + LEG, 7)))[0][point] + [[0.02], [-0.01], [0.03]]
    return {(0, point): replace(idle(7), place=place, placed=np.array([0.0, 1.0, 1.0, 100.0, 0.0, 0.0, 1.0]))}


PROBLEMS = {
    "near": near,
    "slip": lambda: problem(holding()),
    "slip of the heel": lambda: problem(holding(point=HEEL)),
    "slip of the ankle": lambda: problem(holding(point=ANKLE)),
    "slip of the tip": lambda: problem(holding(point=TIP)),
    "level": lambda: problem(drawn()),
    "floor": lambda: problem(floored()),
    "rise": lambda: problem(bent_up()),
    "knee": lambda: raised_knees(problem()),
    "speed": lambda: problem(costs=replace(FREE, speed=20.0)),
    "root far": lambda: problem(costs=replace(FREE, root_farthest=0.06)),
    "line far": lambda: problem(costs=replace(FREE, line_farthest=4.0)),
    "ankle far": lambda: problem(costs=replace(FREE, ankle_farthest=5.0)),
    "toes far": lambda: problem(costs=replace(FREE, toes_farthest=2.0)),
    "little is wrong": lambda: problem(costs=replace(FREE, noticed=0.02, unnoticed_turn=2.0), fault=SOME),
    "place": lambda: problem(placed()),
    "vertices": lambda: problem(skins={0: some_vertices(problem())}),
    "vertices of a stiff foot": lambda: problem(skins={0: replace(some_vertices(problem()), toes=None)}),
    "cut": lambda: replace(near(), cut=(True, True)),
    "cut after": lambda: replace(near(), cut=(False, True)),
    "all of it": lambda: replace(
        raised_knees(problem(
            {(0, TOE): both(holding(), drawn(), TOE), (0, TIP): both(holding(0.3, TIP), floored(), TIP),
             (0, HEEL): placed()[0, HEEL], (1, TOE): drawn()[0, TOE], (1, ANKLE): holding(0.4, ANKLE)[0, ANKLE]},
            legs=2, costs=CostParams(speed=40.0, line_farthest=3.0, ankle_farthest=5.0),
        )), cut=(True, False)),
}  # fmt: skip


def some_vertices(of: Problem) -> Vertices:
    """Vertices here and there around the first foot, of which about half are below what is their floor."""
    rng = np.random.default_rng(8)
    base, toes = (size * rng.normal(size=(5, 3, of.frames)) for size in (0.1, 0.04))
    return Vertices(base, toes, (of.legs[0].ankle[1] + base[:, 1]) + 0.05 * rng.normal(size=(5, of.frames)))


def both(one: dict, other: dict, point: int) -> object:  # type: ignore[type-arg]
    a, b = one[0, point], other[0, point]
    return replace(b, hold=a.hold, slip=a.slip)


def raised_knees(of: Problem) -> Problem:
    """Knees that have to be bent more in most frames."""
    legs = [replace(leg, least=leg.flexion + np.linspace(-0.2, 0.4, of.frames)) for leg in of.legs]
    return replace(of, legs=tuple(legs))


def spread(of: Problem, seed: int = 0) -> Floats:
    """(U, F) a state in which one-sided terms are neither all on nor at their kinks."""
    x = state(of, 0.08, seed)
    x[:ROOT] *= 0.7
    return x


@pytest.mark.parametrize("name", PROBLEMS)
def test_each_gradient_is_the_slope_of_its_cost(name: str) -> None:
    of = PROBLEMS[name]()
    x, h = spread(of), 1e-6
    found = system(of, x, EPS)
    assert found.cost == pytest.approx(objective(of, x, EPS), rel=1e-12)
    slopes, stated = [], []
    for u in range(of.unknowns):  # each unknown, its frames at random
        way = np.zeros_like(x)
        way[u] = np.random.default_rng(u).normal(size=of.frames)
        slopes.append((objective(of, x + h * way, EPS) - objective(of, x - h * way, EPS)) / (2.0 * h))
        stated.append(float(np.sum(found.gradient * way)))
    assert np.abs(slopes).max() > 0.0
    assert np.allclose(stated, slopes, rtol=0.0, atol=2e-6 * np.abs(slopes).max())


@pytest.mark.parametrize("name", PROBLEMS)
def test_each_cost_is_what_the_table_says(name: str) -> None:
    of = PROBLEMS[name]()
    x = spread(of, 3)
    without = replace(of, costs=replace(of.costs, slide=0.0))
    r = residuals(without, x)
    expected = 0.5 * float(r @ r) + slip_cost(of, x, EPS) + lifted_cost(of, x)
    assert objective(of, x, EPS) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("name", "static"), [
    *((name, 1.0) for name in PROBLEMS if not name.startswith(("slip of", "all"))), ("slip", 8.0), ("all of it", 8.0)
])  # fmt: skip
def test_each_matrix_is_that_of_its_residuals(name: str, static: float) -> None:
    """Gauss-Newton: J'J and J'r, J from differences of residuals that are written down in the tests; FAR is curved.

    Of the seven frames those at and next to an end, one in the middle with its neighbours, and the other end.
    """
    of = PROBLEMS[name]()
    x = spread(of, 2)
    found = system(of, x, EPS, static)

    before = places(of, x)

    def r(y: Floats) -> Floats:
        return residuals(of, y, near_at=before, eps=EPS, static=static)

    some = (0, 1, 2, 6)
    at = (np.array(some)[:, None] * of.unknowns + np.arange(of.unknowns)).ravel()
    J = differences(r, x, some)
    matrix, expected = dense(found)[np.ix_(at, at)], J.T @ J + curvature(of, x)[np.ix_(at, at)]
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected))) + 1e-9 * np.abs(expected).max()
    assert np.abs((matrix - expected) / scale).max() < 1e-5
    assert np.abs(found.gradient.T.ravel()[at] - J.T @ r(x)).max() <= 2e-6 * np.abs(J.T @ r(x)).max()


@pytest.mark.parametrize("name", PROBLEMS)
def test_while_the_root_stays_each_leg_has_its_part_of_the_whole(name: str) -> None:
    of = PROBLEMS[name]()
    x = spread(of, 5)
    whole = system(of, x, EPS, 3.0)
    legs = [linearised(of, x, EPS, static=3.0, leg=k) for k in range(len(of.legs))]
    assert [each.rows.tolist() for each in legs] == [
        list(range(of.columns(k).start, of.columns(k).stop)) for k in range(len(of.legs))
    ]
    matrix = dense(whole).reshape(of.frames, of.unknowns, of.frames, of.unknowns)
    own = 0.0
    for each in legs:
        assert np.allclose(each.gradient, whole.gradient[each.rows], rtol=1e-12, atol=1e-9)
        part = matrix[:, each.rows][:, :, :, each.rows]
        assert np.allclose(dense(each), part.reshape(each.gradient.size, -1), rtol=1e-12, atol=1e-9)
        own += each.cost
    root = x.copy()
    root[ROOT:] = 0.0  # what only the root's own terms cost
    idle_legs = replace(of, skins={}, pins=tuple(tuple(idle(of.frames) for _ in each) for each in of.pins), legs=tuple(
        replace(leg, least=np.full(of.frames, -9.0)) for leg in of.legs
    ))  # fmt: skip
    assert own + objective(idle_legs, root, EPS) == pytest.approx(whole.cost, rel=1e-9)


def test_what_nothing_asks_of_costs_nothing() -> None:
    of = problem(legs=2)
    found = system(of, np.zeros((of.unknowns, of.frames)), EPS)
    assert found.cost == 0.0 and not found.gradient.any()
    far = problem({(0, TOE): replace(idle(7), lowest=np.full(7, -5.0))}, legs=2)
    assert objective(far, np.abs(state(far)), EPS) < 1e-9  # knees bend more
    # a level counts only where a point stands, and only as much as it is drawn
    off = replace(idle(7), level=np.full(7, -9.0), draw=np.ones(7))
    none = replace(idle(7), level=np.full(7, -9.0), stands=np.ones(7, dtype=bool))
    for pin in (off, none):
        assert objective(problem({(0, TOE): pin}), np.zeros((ROOT + LEG, 7)), EPS) == 0.0


# ---- by hand ----------------------------------------------------------------------------------------


def one(of: Problem, row: int, frame: int, value: float) -> float:
    """The objective where one unknown of one frame is not zero."""
    x = np.zeros((of.unknowns, of.frames))
    x[row, frame] = value
    return objective(of, x, EPS)


def test_near_by_hand() -> None:
    """One frame of seven is 1 degree off: 1/2 of 60 / s, over the deviations' squares; and 1 + 4 + 1 accelerations."""
    of, c = near(), CostParams()
    dt, size = of.frame_time, of.leg_length
    grown = 0.9 / size
    for row, s0, s2 in (
        (ROOT + 0, c.line * DEG, c.line_acceleration * DEG * grown),
        (ROOT + K, c.knee * DEG, c.knee_acceleration * DEG * grown),
        (ROOT + 5, c.foot * DEG, c.foot_acceleration * DEG * grown),
        (ROOT + B, c.toes * DEG, c.toes_acceleration * DEG * grown),
        (0, c.root * size, c.root_acceleration * size * grown),
        (1, c.root_height * size, c.root_acceleration * size * grown),
    ):
        value = 0.01
        expected = 0.5 * 60.0 * dt * ((value / s0) ** 2 + 6.0 * (value / dt**2 / s2) ** 2)
        assert one(of, row, 3, value) == pytest.approx(expected, rel=1e-9)
        end = 0.5 * 60.0 * dt * ((value / s0) ** 2 + (value / dt**2 / s2) ** 2)
        assert one(of, row, 0, value) == pytest.approx(end, rel=1e-9)
    even = np.ones((of.unknowns, of.frames)) * 0.01  # no acceleration
    s0, _ = of.near()
    assert objective(of, even, EPS) == pytest.approx(0.5 * 60.0 * dt * 7 * np.sum((0.01 / s0) ** 2), rel=1e-9)


def test_noise_makes_accelerations_cheaper_and_no_more_than_so_much_if_it_may_be_motion() -> None:
    of = near()
    s2 = of.near()[1]
    sigma = s2 * of.frame_time**2  # noise whose second differences are sqrt(6) times as large
    noisy = replace(of, noise=0.4 * sigma)
    assert np.allclose(noisy.near()[1], s2 * np.sqrt(1.0 + 6.0 * 0.4**2))
    assert np.allclose(noisy.near()[0], of.near()[0])
    mad = replace(of, noise=100.0 * sigma)
    assert np.allclose(mad.near()[1], s2 * np.sqrt(1.0 + costs.NOISY**2))
    white = replace(mad, white=np.arange(of.unknowns) % 2 == 0)
    times = np.where(white.white, np.sqrt(1.0 + 6.0 * 100.0**2), np.sqrt(1.0 + costs.NOISY**2))
    assert np.allclose(white.near()[1], s2 * times)


def test_slip_by_hand() -> None:
    """A root that goes 5 cm over the floor under a held toe: 9000 a leg length, but for what is round at its foot."""
    hold = np.array([1.0, 1.0, 0.5, 1.0, 1.0, 1.0])
    of = problem({(0, TOE): replace(idle(7), hold=hold)})
    still = replace(of, legs=tuple(leg.frames(np.zeros(7, dtype=int)) for leg in of.legs))
    x = np.zeros((of.unknowns, 7))
    x[0, 3:] = 0.03
    x[2, 3:] = 0.04
    expected = 0.5 * still.costs.slide / still.leg_length * (0.05 - 1e-3 * np.log(51.0))
    assert objective(still, x, 1e-3) == pytest.approx(expected, rel=1e-6)
    x[:] = 0.0
    x[1, 3:] = 0.05  # up and down it counts by little
    expected = 0.5 * still.costs.slide / still.leg_length * costs.UPRIGHT * 0.05
    assert objective(still, x, 1e-9) == pytest.approx(expected, rel=1e-5)


def test_static_friction_is_more_than_kinetic() -> None:
    """It holds what hardly moves: its weight is so many times as much there, half of that at its speed, none above."""
    of = problem({(0, TOE): replace(idle(7), hold=np.ones(6))})
    still = replace(of, legs=tuple(leg.frames(np.zeros(7, dtype=int)) for leg in of.legs))
    speed = costs.STATIC * still.leg_length * still.frame_time  # [m] from frame to frame
    for slip, times in ((1e-6, 8.0), (speed, 4.5), (30.0 * speed, 1.0)):
        x = np.zeros((of.unknowns, 7))
        x[0, 6] = slip
        usual, static = (system(still, x, 1e-12, friction).main for friction in (1.0, 8.0))
        assert static[6, 0, 0] / usual[6, 0, 0] == pytest.approx(times, rel=1e-3)
    # what it costs: so many times as much for a small slip, and no more than its all for a long one
    for slip, times in ((1e-3 * speed, 7.0), (300.0 * speed, 7.0 * np.pi / (2.0 * np.sqrt(2.0)) / 300.0)):
        x[0, 6] = slip
        more = objective(still, x, 1e-12, static=8.0) - objective(still, x, 1e-12)
        assert more == pytest.approx(times * still.costs.slide / still.leg_length * slip, rel=1e-4)


def test_what_was_let_go_has_kinetic_friction_only() -> None:
    of = problem({(0, TOE): replace(idle(7), hold=np.ones(6), spans=((2, 6),)).let_slide([(2, 6)])})
    still = replace(of, legs=tuple(leg.frames(np.zeros(7, dtype=int)) for leg in of.legs))
    x = np.zeros((of.unknowns, 7))
    kinetic, static = (system(still, x, 1e-12, friction).main[:, 0, 0] for friction in (1.0, 8.0))
    assert static[3:5] == pytest.approx(kinetic[3:5]) and static[0] > 7.0 * kinetic[0]
    x[0, 4:] = 0.02
    assert objective(still, x, 1e-12, static=8.0) == pytest.approx(objective(still, x, 1e-12))


@pytest.mark.parametrize("off", [0.006, -0.006, -0.2])  # [m]
def test_level_by_hand(off: float) -> None:
    """A point off its level in three frames of seven."""
    base = places(problem(), np.zeros((ROOT + LEG, 7)))[0][TOE]
    stands = np.array([0, 1, 1, 0, 0, 1, 0], dtype=bool)
    pin = replace(idle(7), stands=stands, level=base[1] - off, draw=np.full(7, 0.25))
    of = problem({(0, TOE): pin})
    s = CostParams().level * of.leg_length
    expected = 3 * 0.5 * 60.0 * of.frame_time * 0.25 * (off / s) ** 2
    assert objective(of, np.zeros((of.unknowns, 7)), EPS) == pytest.approx(expected, rel=1e-9)
    x = np.zeros((of.unknowns, 7))
    x[1] = -off  # the figure comes to it
    assert objective(of, x, EPS) == pytest.approx(0.0, abs=1e-9)


def test_a_point_lifted_far_is_drawn_down_no_harder_than_one_lifted_a_little() -> None:
    base = places(problem(), np.zeros((ROOT + LEG, 7)))[0][TOE]
    stands, most = np.arange(7) == 3, costs.LIFTED * problem().leg_length

    def force(high: float) -> float:
        of = problem({(0, TOE): replace(idle(7), stands=stands, level=base[1] - high, draw=np.ones(7))})
        return float(system(of, np.zeros((of.unknowns, 7)), EPS).gradient[1, 3])

    assert force(0.5 * most) == pytest.approx(0.5 * force(most))
    for high in (2.0 * most, 30.0 * most):
        assert force(high) == pytest.approx(force(most))
    assert force(-30.0 * most) == pytest.approx(-30.0 * force(most))  # what is in the floor is raised with all force


def test_floor_and_knee_by_hand() -> None:
    base = places(problem(), np.zeros((ROOT + LEG, 7)))[0][TIP]
    of = problem({(0, TIP): replace(idle(7), lowest=base[1] + np.array([0.01, 0.02, 0, 0, 0, 0, -1.0]))})
    per_frame = 60.0 * of.frame_time
    expected = 0.5 * per_frame * (0.01**2 + 0.02**2) / (costs.FLOOR * of.leg_length) ** 2
    assert objective(of, np.zeros((of.unknowns, 7)), EPS) == pytest.approx(expected, rel=1e-9)
    of = problem()
    straight = (np.degrees(of.legs[0].flexion) - np.degrees(of.legs[0].least)) * DEG
    assert straight.min() > 0.03
    expected = 0.5 * per_frame * (0.02 / (costs.KNEE * DEG)) ** 2
    assert one(of, ROOT + K, 4, -straight[4] - 0.02) == pytest.approx(expected, rel=1e-9)
    assert one(of, ROOT + K, 4, -straight[4] + 0.01) < 1e-9 and one(of, ROOT + K, 4, 1.0) < 1e-7


def test_speed_by_hand() -> None:
    """Knee and ankle: by so many degrees more from one frame to the next, and back."""
    of = problem(costs=replace(FREE, speed=130.0))
    most = 130.0 * of.frame_time  # [degrees] a frame
    beyond = 3.0
    half = 0.5 * (most + beyond)  # a knee's bend turns hip and ankle by half of it: no more than they may
    assert half < most
    expected = 2 * 0.5 * (beyond / costs.SPEED) ** 2
    assert one(of, ROOT + K, 3, (most + beyond) * DEG) == pytest.approx(expected, rel=1e-9)
    assert one(of, ROOT + 4, 3, (most + beyond) * DEG) == pytest.approx(expected, rel=1e-9)
    assert one(of, ROOT + 1, 3, (most + beyond) * DEG) == pytest.approx(2.0 * expected, rel=1e-9)  # hip and ankle
    assert one(of, ROOT + 1, 3, (most - 0.1) * DEG) < 1e-9
    # thigh and foot that turn together turn the hip alone
    x = np.zeros((of.unknowns, 7))
    x[ROOT : ROOT + LEG][Q, 3] = x[ROOT : ROOT + LEG][W, 3] = [0.0, (most + beyond) * DEG, 0.0]
    assert objective(of, x, EPS) == pytest.approx(expected, rel=1e-9)
    # a knee and a thigh, turned about the knee's axis so that the hip stays, turn the ankle twice over
    axis = of.legs[0].axis[:, 3]
    x = np.zeros((of.unknowns, 7))
    x[ROOT + K, 3] = most * DEG
    x[ROOT : ROOT + 3, 3] = 0.5 * most * DEG * axis
    x[ROOT + 4 : ROOT + 7, 3] = -beyond * DEG * axis
    # the axis moves with the leg, but what is zero before and after stays so
    assert objective(of, x, EPS) == pytest.approx(expected, rel=1e-9)


def test_how_far_by_hand() -> None:
    of = problem(costs=replace(FREE, root_farthest=0.06, line_farthest=12.0, ankle_farthest=25.0))
    per_frame, size = 60.0 * of.frame_time, of.leg_length
    expected = 0.5 * per_frame * (0.01 / costs.FAR_ROOT) ** 2
    for row in range(ROOT):
        assert one(of, row, 2, -0.07 * size) == pytest.approx(expected, rel=1e-9)
    assert one(of, 0, 2, 0.059 * size) < 1e-9
    turn = 0.5 * per_frame * (2.0 / costs.FAR_TURN) ** 2
    assert one(of, ROOT + 2, 5, 14.0 * DEG) == pytest.approx(turn, rel=1e-9)
    assert one(of, ROOT + 6, 5, -27.0 * DEG) == pytest.approx(turn, rel=1e-9)
    x = np.zeros((of.unknowns, 7))
    x[ROOT + 2, 5], x[ROOT + 6, 5] = 11.0 * DEG, -16.0 * DEG  # against each other
    assert objective(of, x, EPS) == pytest.approx(turn, rel=1e-9)
    x[ROOT + 6, 5] = 27.0 * DEG  # together
    assert objective(of, x, EPS) < 1e-9


def test_what_nobody_notices_is_worth_a_small_turn_by_hand() -> None:
    of = problem(costs=replace(FREE, noticed=0.02, unnoticed_turn=2.0, ankle_farthest=8.0))
    noticed = 0.02 * of.leg_length
    of = replace(of, fault=noticed * np.array([0.0, 1.0, 1.5, 3.0, 4.0, 9.0, np.inf]))
    line, knee, ankle, toes = (bound / DEG for bound in of.farthest)
    np.testing.assert_allclose(line, [2.0, 2.0, 3.0, 6.0, 8.0, 18.0, FREE.line_farthest], rtol=1e-12)
    np.testing.assert_allclose([knee, ankle], [[2.0, 2.0, 3.0, 6.0, 8.0, 8.0, 8.0]] * 2, rtol=1e-12)
    assert toes[:2] == pytest.approx(costs.TOES * 2.0) and np.all(toes[3:] > 1e6)  # nothing bounds them here
    for frame, degrees, sigma in ((0, 3.0, costs.FIRM_TURN), (2, 4.0, costs.FAR_TURN), (5, 9.0, costs.FAR_TURN)):
        turn = 0.5 * 60.0 * of.frame_time * (1.0 / sigma) ** 2
        assert one(of, ROOT + 3, frame, degrees * DEG) == pytest.approx(turn, rel=1e-6)


def test_a_bound_is_firm_where_nobody_notices_the_fault() -> None:
    of = problem(costs=CostParams(noticed=0.02))
    hardly = costs.UNNOTICED
    of = replace(of, fault=0.02 * of.leg_length * np.array([0.0, 1.0, 0.5 * (1.0 + hardly), hardly, 2.0, 9.0, np.inf]))
    between = 0.5 * (costs.FIRM_TURN + costs.FAR_TURN)
    expected = [costs.FIRM_TURN, costs.FIRM_TURN, between, *[costs.FAR_TURN] * 4]
    np.testing.assert_allclose(of.beyond / DEG, expected, rtol=1e-12)
    assert costs.FIRM_TURN < costs.FAR_TURN


def test_toes_bend_as_far_as_they_may_for_twice_what_is_noticed() -> None:
    of = problem(costs=CostParams(noticed=0.02, unnoticed_turn=2.0, toes_farthest=40.0))
    some = costs.UNNOTICED
    of = replace(of, fault=0.02 * of.leg_length * np.array([0.0, 1.0, 1.2, some, 0.5 * (some + 2.0), 2.0, np.inf]))
    least = 2.0 * costs.TOES
    expected = [least, least, 1.2 * least, some * least, 0.5 * (some * least + 40.0), 40.0, 40.0]
    np.testing.assert_allclose(of.farthest[3] / DEG, expected, rtol=1e-12)


def test_place_and_cut_by_hand() -> None:
    base = places(problem(), np.zeros((ROOT + LEG, 7)))[0][HEEL]
    pin = replace(idle(7), place=base + [[0.003], [0.0], [0.004]], placed=np.array([0, 0, 1.0, 100.0, 0, 0, 0]))
    of = problem({(0, HEEL): pin})
    expected = 0.5 * 60.0 * of.frame_time * 101.0 * (0.005 / (costs.PLACE * of.leg_length)) ** 2
    assert objective(of, np.zeros((of.unknowns, 7)), EPS) == pytest.approx(expected, rel=1e-9)
    for cut, ends in (((True, False), (0,)), ((False, True), (6,)), ((True, True), (0, 6)), ((False, False), ())):
        of = problem(cut=cut)
        frames = 120.0 * of.frame_time  # so many 1/120 s is a frame
        for frame in range(7):
            turn = 0.5 * (0.01 / (costs.CUT * DEG * frames)) ** 2
            assert one(of, ROOT + 4, frame, 0.01) == pytest.approx(turn * (frame in ends), rel=1e-6, abs=1e-8)
            shift = 0.5 * (0.01 / (costs.CUT_ROOT * of.leg_length * frames)) ** 2
            assert one(of, 1, frame, 0.01) == pytest.approx(shift * (frame in ends), rel=1e-6, abs=1e-8)


# ---- the whole of it --------------------------------------------------------------------------------


def test_nears_matrix_is_its_product() -> None:
    of = replace(near(), cut=(True, False))
    x = state(of)
    found = system(of, x, EPS)
    whole = dense(replace(found, bands=0.0 * found.bands))
    assert np.allclose(whole @ x.T.ravel(), product(found.near, x).T.ravel(), rtol=1e-12)


def test_what_a_file_cannot_turn_is_not_free() -> None:
    plain = problem(legs=2)
    assert plain.free().all()
    assert np.flatnonzero(~replace(plain, root_moves=False).free()).tolist() == [0, 1, 2]
    toeless = problem(legs=2, kind="no toes")
    assert np.flatnonzero(~toeless.free()).tolist() == [ROOT + B, ROOT + LEG + B]
    legs = (replace(plain.legs[0], turns=False), plain.legs[1])
    assert np.flatnonzero(~replace(plain, legs=legs).free()).tolist() == list(range(ROOT, ROOT + LEG))
    assert (plain.unknowns, plain.frames) == (ROOT + 2 * LEG, 7)


def test_a_giant_is_held_like_a_child() -> None:
    """Everything twice as long in sqrt(2) as much time is the same problem: accelerations of places are the same."""
    small = problem({(0, TOE): both(holding(), drawn(), TOE)}, costs=replace(CostParams(), speed=1e9))
    pin = small.pins[0][TOE]
    longer = ("hip", "ankle", "thigh", "shank", "reach")
    leg = small.legs[0]
    scale = {name: (4.0 if name == "reach" else 2.0) * getattr(leg, name) for name in longer}
    giant_leg = replace(leg, **scale, points=tuple(2.0 * p for p in leg.points))
    giant_pin = replace(pin, slip=2.0 * pin.slip, level=2.0 * pin.level)
    pins = tuple(giant_pin if n == TOE else each for n, each in enumerate(small.pins[0]))
    giant = replace(small, legs=(giant_leg,), pins=(pins,), leg_length=2.0 * small.leg_length)
    x = state(small, 0.02)
    large = x.copy()
    large[:ROOT] *= 2.0
    s0, s2 = small.near()
    t0, t2 = giant.near()
    assert np.allclose(t0[ROOT:], s0[ROOT:]) and np.allclose(t0[:ROOT], 2.0 * s0[:ROOT])
    assert np.allclose(t2[ROOT:], 0.5 * s2[ROOT:]) and np.allclose(t2[:ROOT], s2[:ROOT])
    without = [replace(each, costs=replace(each.costs, **dict.fromkeys(
        ("root_acceleration", "line_acceleration", "knee_acceleration", "foot_acceleration", "toes_acceleration"), 1e9
    ))) for each in (small, giant)]  # fmt: skip
    assert objective(without[1], large, 2.0 * EPS) == pytest.approx(objective(without[0], x, EPS), rel=1e-9)


def test_the_figure_of_these_tests_is_a_plain_one() -> None:
    assert len(figure().legs) == 2 and len(figure().legs[0].points) == 3

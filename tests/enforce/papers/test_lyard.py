"""Lyard's root-only correction."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import artefacts
import numpy as np
import pytest
from footplants import plants_of, strays
from skinmaker import skin_of
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce.correction import apply
from footfix.enforce.papers.lyard import (
    LyardRootParams,
    _calmed,
    _over_floor,
    _speeds,
    correct,
    height_shift,
    root_steps,
    static_points,
)
from footfix.enforce.papers.static_point_switch import catmull_rom, cubic_roots, hand_over, offset_at, share_gone
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints
from footfix.rig.find import find_rig
from footfix.rig.rig import Rig

PARAMS = LyardRootParams()
PAPER = LyardRootParams(calm=0.0, hand_over=0.0)


def lyard(clip: Clip, rig: Rig, params: LyardRootParams = PARAMS, name: str = "walk") -> Clip:
    return apply(clip, correct(clip, rig, plants_of(rig, walk(name).contacts), params))


def test_cubic_roots_are_numpys() -> None:
    coefficients = np.random.default_rng(0).normal(size=(300, 4))
    for c, found in zip(coefficients, cubic_roots(coefficients), strict=True):
        expected = np.roots(c)
        expected = np.sort(expected[np.abs(expected.imag) < 1e-9].real)
        assert np.allclose(np.sort(found[np.isfinite(found)]), expected, atol=1e-6)


def test_cubic_roots_of_squares_lines_and_threefold_roots() -> None:
    found = cubic_roots(np.array([
        [0.0, 1.0, -3.0, 2.0], [0.0, 0.0, 2.0, -1.0], [1.0, -3.0, 3.0, -1.0], [0.0, 0.0, 0.0, 1.0],
        [0.0, 1.0, 0.0, 1.0],
    ]))  # fmt: skip
    assert np.allclose(np.sort(found[0, :2]), [1.0, 2.0])
    assert np.isclose(found[1, 0], 0.5)
    assert np.allclose(found[2], 1.0, atol=1e-5)
    assert np.isnan(found[3:]).all()


def at(*numbers: int) -> Ints:
    return np.array(numbers, dtype=np.intp)


def test_speeds_cross_where_catmull_rom_splines_do() -> None:
    random = np.random.default_rng(4)
    checked = 0
    for _ in range(300):
        speeds = random.uniform(0.0, 1.0, size=(8, 2))
        # Catmull-Rom is the cubic Hermite spline whose slopes are the central differences
        gap = speeds @ [1.0, -1.0]
        a, b, da, db = gap[3], gap[4], 0.5 * (gap[4] - gap[2]), 0.5 * (gap[5] - gap[3])
        cubic = np.array([2.0 * (a - b) + da + db, 3.0 * (b - a) - 2.0 * da - db, da, a])
        roots = [r.real for r in np.roots(cubic) if abs(r.imag) < 1e-12 and 0.0 <= r.real <= 1.0]
        crossings = [r for r in roots if np.polyval(np.polyder(cubic), r) >= 0.0]
        q = float(hand_over(at(3), at(0), at(1), speeds)[0])
        assert abs(q - min(crossings, default=0.5)) < 1e-7
        checked += bool(crossings)
    assert checked > 60


def test_the_way_that_is_gone_is_the_integral_of_the_speed() -> None:
    speeds = np.random.default_rng(1).uniform(0.1, 1.0, size=(6, 1))
    curve = np.poly1d(catmull_rom(speeds, at(2), at(0))[0])
    for q in (0.0, 0.3, 0.7, 1.0):
        share = share_gone(speeds, at(2), at(0), np.array([q]))[0]
        u = np.linspace(0.0, q, 2001)
        whole = np.linspace(0.0, 1.0, 2001)
        assert abs(share - np.trapezoid(curve(u), u) / np.trapezoid(curve(whole), whole)) < 1e-6
    line = np.arange(6.0)[:, None, None] * np.array([1.0, 2.0, -3.0])  # at an even speed the place is the straight one
    found = offset_at(line, np.ones((6, 1)), at(2), at(0), np.array([0.4]))
    assert np.allclose(found, 2.4 * np.array([1.0, 2.0, -3.0]))


def test_a_step_between_two_points_is_lyards_equation_one() -> None:
    random = np.random.default_rng(2)
    offsets, speeds = random.normal(size=(8, 2, 3)), random.uniform(0.1, 1.0, size=(8, 2))
    q = hand_over(at(3), at(0), at(1), speeds)
    o_i, o_j = (offset_at(offsets, speeds, at(3), at(v), q)[0] for v in (0, 1))
    expected = offsets[3, 0] - o_i + o_j - offsets[4, 1]
    assert np.allclose(root_steps(at(3), at(0), at(1), offsets, speeds)[0], expected)
    # one point alone: the root goes back by what the point goes on
    assert np.allclose(root_steps(at(3), at(0), at(0), offsets, speeds)[0], offsets[3, 0] - offsets[4, 0])


def test_one_static_point_stands_still() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.05, slowest=1.0)
    plants = plants_of(rig, made.contacts)
    toe = [next(plant for plant in plants if plant.name == "right_toe" and plant.start > 5)]
    for params in (PAPER, replace(PARAMS, calm=0.0)):
        after = apply(clip, correct(clip, rig, toe, params))
        track = rig.held(rig.pose(after))[toe[0].effector][toe[0].frames]
        assert strays(clip, rig, toe).max() > 0.01 and np.ptp(track[:, [0, 2]], axis=0).max() < 1e-9


@pytest.mark.parametrize("gait", ["walk", "run", "turn", "backwards", "stairs"])
@pytest.mark.parametrize(
    "artefact",
    [
        lambda clip: artefacts.drift(clip, 0.05),
        lambda clip: artefacts.wander(clip, 0.05, slowest=1.0),
        lambda clip: artefacts.scale_root(clip, 0.9, height=False),
        lambda clip: artefacts.scale_root(clip, 1.1, height=False),
        lambda clip: artefacts.shake(clip, 0.5, slowest=0.3),
    ],
)
def test_the_root_alone_stills_single_support(gait: str, artefact) -> None:  # type: ignore[no-untyped-def]
    made = walk(gait)
    rig = rig_of(made)
    clip = artefact(made.clip)
    after = lyard(clip, rig, name=gait)
    assert np.array_equal(after.rotations, clip.rotations)
    assert np.array_equal(after.positions[:, 1:], clip.positions[:, 1:])
    mask = made.contacts.mask()
    found = []
    for e in (1, 3):
        other = mask[:, [k for k in range(4) if k // 2 != e // 2]].any(axis=1)
        track = rig.held(rig.pose(after))[e]
        for contact in made.contacts.effectors[e].contacts:
            alone = track[contact.start : contact.end][~other[contact.start : contact.end]][:, [0, 2]]
            if len(alone) > 2:
                found.append(float(np.linalg.norm(alone - np.median(alone, axis=0), axis=1).max()))
    assert np.percentile(found, 90) <= 0.008


def test_the_static_point_is_the_slowest_and_keeps_its_turn() -> None:
    speeds = np.full((60, 2), 1.0)
    speeds[:30, 0], speeds[30:, 1] = 0.1, 0.1
    planted = np.ones((60, 2), dtype=bool)
    planted[50:] = False
    expected = np.repeat([0, 1, -1], [30, 20, 10])
    assert np.array_equal(static_points(speeds, planted, 0.01, 0.0), expected)
    speeds[12, 0] = 1.2  # for a moment the other one is slower
    assert static_points(speeds, planted, 0.01, 0.0)[12] == 1
    assert np.array_equal(static_points(speeds, planted, 0.01, 0.01), expected)


def test_static_points_move_least_of_all_ways_to_choose() -> None:
    random = np.random.default_rng(7)
    for _ in range(20):
        speeds, cost = random.uniform(0.0, 1.0, size=(9, 2)), 0.4
        planted = random.uniform(size=(9, 2)) < 0.8
        planted[~planted.any(axis=1)] = True

        def price(way: Floats | Ints, speeds: Floats = speeds, planted: Floats = planted, cost: float = cost) -> float:
            if not all(planted[t, v] for t, v in enumerate(way)):
                return np.inf
            turns = sum(a != b for a, b in pairwise(way))
            return float(sum(speeds[t, v] for t, v in enumerate(way)) + cost * turns)

        best = min(price([(k >> t) & 1 for t in range(9)]) for k in range(512))  # type: ignore[arg-type]
        assert np.isclose(price(static_points(speeds, planted, 1.0, cost)), best)


def test_in_flight_the_root_keeps_its_own_velocity() -> None:
    made = walk("run")
    rig = rig_of(made)
    clip = artefacts.scale_root(made.clip, 1.1, height=False)
    after = lyard(clip, rig, name="run")
    air = ~made.contacts.mask().any(axis=1)
    both = air[1:] & air[:-1]
    steps = [np.diff(each.positions[:, 0, [0, 2]], axis=0)[both] for each in (clip, after)]
    assert both.sum() > 10 and np.allclose(*steps, atol=1e-12)


def test_the_known_scale_of_a_scaled_path_is_undone() -> None:
    made = walk()
    rig = rig_of(made)
    after = lyard(artefacts.scale_root(made.clip, 1.1, height=False), rig)
    length = [np.linalg.norm((c.positions[-1] - c.positions[0])[0, [0, 2]]) for c in (made.clip, after)]
    assert np.isclose(*length, rtol=0.01)


@pytest.mark.parametrize("depth", [0.03, -0.04])
def test_one_offset_brings_the_plants_to_the_floor(depth: float) -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.sink(made.clip, depth)
    after = lyard(clip, rig)
    assert np.allclose(after.positions[:, 0, 1], made.clip.positions[:, 0, 1], atol=0.002)
    level = lyard(clip, rig, replace(PARAMS, vertical=False))
    assert np.array_equal(level.positions[:, 0, 1], clip.positions[:, 0, 1])


def test_offset_and_scale_minimise_what_lyard_minimises() -> None:
    random = np.random.default_rng(2)
    root = 0.9 + 0.03 * np.sin(np.arange(80) / 6.0)
    above = 0.4 * (root - 0.9) + 0.001 * random.normal(size=80) + 0.02
    shift = height_shift(root, np.arange(80), above)
    r = root - root.mean()
    fit = np.polyfit(r, above, 1)  # of an offset and a multiple of r, this leaves the least of the heights
    assert np.allclose(above + shift, above - np.polyval(fit, r), atol=1e-12)


def test_a_pinned_end_comes_back() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.drift(made.clip, 0.3)
    drifts, pinned = (lyard(clip, rig, replace(PARAMS, pin_end=end)) for end in (False, True))
    off = [np.linalg.norm((each.positions[-1] - clip.positions[-1])[0, [0, 2]]) for each in (drifts, pinned)]
    assert off[0] > 0.2 and off[1] < 1e-9
    # the way back is spread over the clip: no step of it is a jump
    steps = np.linalg.norm(np.diff((pinned.positions - clip.positions)[:, 0, [0, 2]], axis=0), axis=1)
    assert steps.max() < 0.01
    back = np.linalg.norm(np.diff((pinned.positions - drifts.positions)[:, 0, [0, 2]], axis=0), axis=1)
    assert max(back[0], back[-1]) < 0.05 * back.mean()  # and it begins and ends gently


def test_the_noise_of_a_held_point_does_not_shake_the_figure() -> None:
    made = walk(fps=120.0)
    rig = rig_of(made)
    clip = artefacts.shake(made.clip, 0.3)
    plants = plants_of(rig, made.contacts)
    rough = [
        np.abs(np.diff(correct(clip, rig, plants, replace(PARAMS, calm=calm)).root_shift[:, [0, 2]], 2, axis=0)).mean()
        for calm in (0.0, 0.03)
    ]
    assert rough[1] < 0.5 * rough[0]


def test_plants_on_steps_are_at_the_height_of_their_steps() -> None:
    made = walk("stairs")
    rig = rig_of(made)
    clip = artefacts.drift(made.clip, 0.2)
    shift = correct(clip, rig, plants_of(rig, made.contacts), PARAMS).root_shift
    assert np.abs(shift[:, [0, 2]]).max() > 0.1 and np.abs(shift[:, 1]).max() < 0.002


def test_where_all_stands_well_enough_nothing_moves() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.002, slowest=1.0)
    plants = plants_of(rig, made.contacts)
    assert not correct(clip, rig, plants, PARAMS).root_shift.any()
    assert correct(clip, rig, plants, replace(PARAMS, keep_slide=0.0005)).root_shift.any()
    assert not correct(clip, rig, [], replace(PARAMS, keep_slide=0.0)).root_shift.any()


def test_a_root_without_position_channels_stays() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.05, slowest=1.0)
    none = np.zeros(len(clip.skeleton), dtype=bool)
    fixed = replace(clip, skeleton=replace(clip.skeleton, translates=none))
    assert not correct(fixed, rig, plants_of(rig, made.contacts), PARAMS).root_shift.any()


def test_turned_and_shifted_clips_give_the_turned_shift() -> None:
    made = walk("turn")
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.05, slowest=1.0)
    plants = plants_of(rig, made.contacts)
    here = correct(clip, rig, plants, PARAMS).root_shift
    there = correct(artefacts.turned(clip, 1.9, (3.0, -2.0)), rig, plants, PARAMS).root_shift
    turn = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(1.9))
    assert np.abs(rotation.rotate(turn, here) - there).max() < 1e-9


@pytest.mark.parametrize("skinned", [False, True])
def test_on_a_belt_planted_points_go_with_the_belt(skinned: bool) -> None:
    made = walk("treadmill", duration=3.0)
    rig = find_rig(made.clip, skin=skin_of(made.clip)) if skinned else rig_of(made)
    assert bool(rig.meshes) is skinned
    plants = plants_of(rig, made.contacts)
    ground = (np.arange(len(made.clip)) * made.clip.frame_time)[:, None] * np.array(made.belt)
    clip = artefacts.wander(made.clip, 0.05, slowest=1.0)
    after = apply(clip, correct(clip, rig, plants, PAPER, ground=ground))
    assert strays(clip, rig, plants, ground).max() > 0.02
    # a foot rolls over the vertices of a skin, over heel and toe it rolls in place
    assert np.percentile(strays(after, rig, plants, ground), 75) < (0.008 if skinned else 0.001)
    # and a figure whose feet stand on the belt stays as it is
    assert not correct(made.clip, rig, plants, PAPER, ground=ground).root_shift.any()


def test_steps_are_averaged_over_the_planted_steps_nearby() -> None:
    t = np.array([0, 1, 2, 3, 7])
    more = np.array([[1.0, 0.0], [2.0, 3.0], [6.0, 0.0], [0.0, 0.0], [5.0, -5.0]])
    found = _calmed(more, t, 9, 1)
    assert found[:, 0] == pytest.approx([1.5, 3.0, 8.0 / 3.0, 3.0, 5.0])
    assert found[:, 1] == pytest.approx([1.5, 1.0, 1.0, 0.0, -5.0])
    assert _calmed(more, t, 9, 0) == pytest.approx(more)


def test_the_root_takes_the_mean_of_so_many_seconds_of_steps() -> None:
    frames, frame_time = 101, 0.01
    points = np.zeros((frames, 1, 3))
    points[51:, 0, 0] = 0.13  # one step of 13 cm
    shift = _over_floor(
        np.zeros((frames, 3)), points, np.zeros(frames, dtype=np.intp), frame_time,
        LyardRootParams(calm=0.12, pin_end=False),
    )  # fmt: skip
    expected = -0.13 * np.clip((np.arange(frames) - 44) / 13.0, 0.0, 1.0)  # 6 steps to either side of the one
    assert shift[:, 0] == pytest.approx(expected)
    assert not shift[:, 1].any()


def test_speeds_are_means_over_a_window_that_repeats_the_ends() -> None:
    way = np.cumsum(np.random.default_rng(2).normal(size=(30, 2, 3)), axis=0)
    sharp = _speeds(way, 0.1, 0.0)
    assert sharp == pytest.approx(np.linalg.norm(np.gradient(way, 0.1, axis=0), axis=2))
    padded = np.pad(sharp, ((2, 2), (0, 0)), mode="edge")
    expected = np.mean([padded[k : k + 30] for k in range(5)], axis=0)
    assert _speeds(way, 0.1, 0.4) == pytest.approx(expected)
    assert _speeds(way[:1], 0.1, 0.4).tolist() == [[0.0, 0.0]]

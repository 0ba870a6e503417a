"""What is to be mended, and by how much, of a figure that stands and is shifted as told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from legmaker import Figure, figure_of
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce.footing import Footing
from footfix.enforce.footplant import Footplant
from footfix.enforce.leg import HEEL, TOE
from footfix.enforce.pins import PinParams
from footfix.enforce.plant_faults import core, faults, kept
from footfix.enforce.standing_heights import Floors
from footfix.motion.clip import Floats

FRAMES = 121
DT = 1.0 / 60.0
AROUND = 21  # frames in 0.35 s
PARAMS = PinParams()


def shifted(shift: Floats) -> Figure:
    """A walker that stands as if frozen, its root shifted by (F, 3) [m]."""
    made = walk("stand", 60.0, 2.0)
    clip = made.clip.frames(np.zeros(FRAMES, dtype=int))
    positions = clip.positions.copy()
    positions[:, 0] += shift
    return figure_of(replace(clip, positions=positions), rig_of(made), replace(made.contacts, frames=FRAMES))


def toe(start: int, end: int, **more: object) -> Footplant:
    return Footplant(0, 1, "left_toe", 0, "toe", start, end, **more)  # type: ignore[arg-type]


def level(part: int = TOE, up: float = 0.0) -> Floors:
    height = float(shifted(np.zeros((FRAMES, 3))).legs[0].place(part)[1, 0]) + up
    return Floors(np.full(4, height), np.zeros(2), (height,))


def fault(
    shift: Floats, plant: Footplant, *, floors: Floors | None = None, keep: bool = False, heights: bool = True,
    ground: Floats | None = None,
) -> Floats:  # fmt: skip
    moves = np.zeros((FRAMES, 3)) if ground is None else ground
    footing = Footing((plant,), floors or level(), moves, (keep,), (False,))
    return faults(footing, shifted(shift).legs, DT, heights=heights, edge=0.0)


def slid(distance: float, first: int, last: int) -> Floats:
    way = np.interp(np.arange(FRAMES), [first, last], [0.0, distance])
    return np.asarray(way[:, None] * [0.6, 0.0, 0.8])


@pytest.mark.parametrize(("span", "edge", "found"), [
    ((10, 40), 0.015, (11, 39)), ((10, 40), 0.05, (13, 37)), ((10, 40), 0.0, (11, 39)), ((10, 14), 0.05, (10, 14)),
    ((10, 15), 0.05, (11, 14)), ((10, 13), 0.05, (10, 13)), ((10, 17), 0.05, (12, 15)), ((10, 11), 0.05, (10, 11)),
])  # fmt: skip
def test_a_core_leaves_out_the_edges_and_keeps_three_frames(
    span: tuple[int, int], edge: float, found: tuple[int, int]
) -> None:
    assert core(toe(*span), DT, edge) == found


def test_a_fault_is_the_farthest_from_the_median_place_around_the_plant() -> None:
    found = fault(slid(0.058, 40, 98), toe(40, 99))  # of frames 41 to 97 the median is 69, and 28 mm to either side
    near = slice(40 - AROUND, 99 + AROUND)
    assert found[near] == pytest.approx(np.full(99 - 40 + 2 * AROUND, 0.028))
    assert not found[: 40 - AROUND].any() and not found[99 + AROUND :].any()
    assert fault(slid(0.058, 10, 68), toe(10, 69))[0] > 0.0  # as far as the clip goes


def test_a_fault_of_a_short_plant_leaves_out_the_frames_in_which_it_lands_and_leaves() -> None:
    shift = slid(0.01, 41, 42)
    shift[:41] -= [0.018, 0.0, 0.024]  # 30 mm in the step with which it lands
    assert fault(shift, toe(40, 44))[41] == pytest.approx(0.005)  # the middle of two frames
    assert fault(shift, toe(40, 43))[41] > 0.025  # three frames are too few to leave any out


def test_a_fault_is_how_high_the_plant_is_where_that_is_more() -> None:
    up = np.tile([0.0, 0.03, 0.0], (FRAMES, 1))
    assert fault(up, toe(40, 99))[60] == pytest.approx(0.03)
    assert fault(-up, toe(40, 99))[60] == pytest.approx(0.03)
    assert fault(-up + slid(0.058, 40, 98), toe(40, 99))[60] == pytest.approx(0.03)
    assert fault(up, toe(40, 99), floors=level(up=0.03))[60] == pytest.approx(0.0, abs=1e-12)
    assert fault(up, toe(40, 99), heights=False)[60] == 0.0


def test_what_goes_with_the_ground_is_no_fault() -> None:
    ride = slid(0.5, 0, FRAMES - 1)
    assert fault(ride, toe(40, 99), ground=ride)[60] == pytest.approx(0.0, abs=1e-12)
    assert fault(np.zeros((FRAMES, 3)), toe(40, 99), ground=ride)[60] > 0.1


def test_what_is_asked_for_or_forced_is_mended_whatever_it_costs_and_what_is_kept_is_not() -> None:
    still = np.zeros((FRAMES, 3))
    assert np.isinf(fault(still, toe(40, 99, force=True), keep=True)[60])
    assert np.isinf(fault(still, toe(40, 99, asked=(0.0, 0.0, 0.0)), keep=True)[60])
    assert not fault(slid(0.05, 40, 98), toe(40, 99), keep=True).any()


def test_the_worst_of_plants_nearby_counts() -> None:
    plants = (replace(toe(20, 50), id=0), replace(toe(60, 100), id=1))
    legs = shifted(slid(0.04, 60, 99)).legs
    floors = replace(level(), plants=level().plants * 2)
    footing = Footing(plants, floors, np.zeros((FRAMES, 3)), (False, False), (False, False))
    found = faults(footing, legs, DT, heights=True, edge=0.0)
    assert found[45] == pytest.approx(found[80]) and found[45] > 0.015
    assert found[30] == 0.0


@pytest.mark.parametrize(("slide", "stays"), [(0.9, True), (1.1, False)])
@pytest.mark.parametrize("part", [HEEL, TOE])
def test_what_slides_no_farther_than_the_tolerance_stays(part: int, slide: float, stays: bool) -> None:
    made = shifted(slid(2.0 * slide * PARAMS.keep_slide * rig_of(walk()).leg_length, 41, 97))
    plant = toe(40, 99) if part == TOE else Footplant(0, 0, "left_heel", 0, "heel", 40, 99)
    (found,) = kept(
        [plant], made.legs, np.zeros((FRAMES, 3)), level(part), DT, made.rig.leg_length, heights=True, params=PARAMS,
    )  # fmt: skip
    assert found is stays


@pytest.mark.parametrize(("up", "heights", "stays"), [
    (0.9, True, True), (1.1, True, False), (-0.9, True, True), (-1.1, True, False), (1.1, False, True),
])  # fmt: skip
def test_what_is_no_farther_from_its_floor_than_the_tolerance_stays(up: float, heights: bool, stays: bool) -> None:
    size = rig_of(walk()).leg_length
    made = shifted(slid(0.004, 41, 97) * 0.5)
    floors = level(up=up * PARAMS.keep_height * size)
    (found,) = kept(
        [toe(40, 99)], made.legs, np.zeros((FRAMES, 3)), floors, DT, size, heights=heights, params=PARAMS
    )  # fmt: skip
    assert found is stays


@pytest.mark.parametrize(("share", "asked", "stays"), [(0.4, True, True), (0.2, True, False), (0.4, False, False)])
def test_what_was_put_to_rest_in_many_of_its_frames_stays_if_that_is_wanted(
    share: float, asked: bool, stays: bool
) -> None:
    frames = round(share * 58)
    made = shifted(slid(0.1, 41 + frames, 98))  # rests, then slides
    (found,) = kept(
        [toe(40, 99)], made.legs, np.zeros((FRAMES, 3)), level(), DT, made.rig.leg_length, heights=True,
        params=replace(PARAMS, keep_rested=asked),
    )  # fmt: skip
    assert found is stays


def test_a_plant_too_short_to_be_held_stays_unless_it_is_forced() -> None:
    made = shifted(slid(0.1, 40, 45))
    for plant, stays in ((toe(40, 42), True), (toe(40, 43), False), (toe(40, 42, force=True), False)):
        (found,) = kept(
            [plant], made.legs, np.zeros((FRAMES, 3)), level(), DT, made.rig.leg_length, heights=True, params=PARAMS
        )
        assert found is stays


@pytest.mark.parametrize(("moves_on", "stays"), [(True, True), (False, False)])
def test_two_still_steps_are_a_lock_where_the_hip_moves_on_and_a_duplicate_frame_where_it_does_not(
    moves_on: bool, stays: bool
) -> None:
    steps = np.tile([0.002, 0.0, 0.0, 0.002], FRAMES)[: FRAMES - 1]  # [m] two of four are still
    made = shifted(np.concatenate([[0.0], np.cumsum(steps)])[:, None] * [0.6, 0.0, 0.8])
    (leg, other), on = made.legs, np.linspace(0.0, 2.0, FRAMES)
    hip = leg.hip + (on if moves_on else 0.0) * np.array([[1.0], [0.0], [0.0]])
    (found,) = kept(
        [toe(40, 99)], (replace(leg, hip=hip), other), np.zeros((FRAMES, 3)), level(), DT, made.rig.leg_length,
        heights=True, params=PARAMS,
    )  # fmt: skip
    assert found is stays


@pytest.mark.parametrize(("number", "stays"), [(0, True), (1, False)])
def test_a_heel_that_rolls_stays_while_the_toe_of_its_own_foot_is_locked(number: int, stays: bool) -> None:
    made = shifted(slid(0.04, 40, 99))  # all of it slides, but for the left toe, while the hips move on by 2 m
    on = np.linspace(0.0, 2.0, FRAMES) * np.array([[1.0], [0.0], [0.0]])
    left, right = (replace(leg, hip=leg.hip + on) for leg in made.legs)
    locked = left.place(TOE)[:, :1] - left.ankle  # (3, F) [m]
    left = replace(left, points=(left.points[0], locked, *left.points[2:]))
    heel = Footplant(0, 2 * number, "heel", number, "heel", 40, 99)
    (found,) = kept(
        [heel], (left, right), np.zeros((FRAMES, 3)), level(HEEL), DT, made.rig.leg_length, heights=True,
        params=PARAMS,
    )  # fmt: skip
    assert found is stays


@pytest.mark.parametrize(("slide", "locked", "asked", "stays"), [
    (0.9, True, True, True), (1.1, True, True, False), (0.9, False, True, False), (0.9, True, False, False),
])  # fmt: skip
def test_in_a_clip_that_a_program_has_locked_what_nobody_notices_stays(
    slide: float, locked: bool, asked: bool, stays: bool
) -> None:
    size = rig_of(walk()).leg_length
    shift = slid(2.0 * slide * 0.02 * size, 101, 119)
    if not locked:
        shift += slid(0.1, 0, 90)
    made = shifted(shift)
    plants = [toe(0, 90), replace(toe(100, FRAMES), id=1)]
    floors = replace(level(), plants=level().plants * 2)
    _, found = kept(
        plants, made.legs, np.zeros((FRAMES, 3)), floors, DT, size, heights=True,
        params=replace(PARAMS, keep_rested=asked), noticed=0.02,
    )  # fmt: skip
    assert found is stays


@pytest.mark.parametrize(("slide", "given", "stays"), [
    (0.0015, False, True), (0.0015, True, False), (0.0003, True, True),
])  # fmt: skip
def test_a_toe_joint_that_was_given_stays_only_if_it_is_at_rest(slide: float, given: bool, stays: bool) -> None:
    made = shifted(slid(2.0 * slide, 40, 99))
    (found,) = kept(
        [toe(40, 99)], made.legs, np.zeros((FRAMES, 3)), level(), DT, made.rig.leg_length, heights=True,
        params=PARAMS, by_hand=(given,),
    )  # fmt: skip
    assert found is stays


def test_a_toe_joint_that_was_given_is_held_for_two_frames_and_though_a_program_locked_it_in_others() -> None:
    made = shifted(slid(0.1, 41 + 29, 98))  # rests, then slides
    for plant, stays in ((toe(40, 99), False), (toe(80, 82), False), (toe(80, 81), True), (toe(40, 60), True)):
        (found,) = kept(
            [plant], made.legs, np.zeros((FRAMES, 3)), level(), DT, made.rig.leg_length, heights=True, params=PARAMS,
            by_hand=(True,),
        )  # fmt: skip
        assert found is stays


@pytest.mark.parametrize(("number", "start", "given", "stays"), [
    (0, 98, True, False), (0, 99, True, True), (1, 98, True, True), (0, 98, False, True),
])  # fmt: skip
def test_a_heel_that_was_given_stays_only_if_the_toe_joint_of_its_foot_does(
    number: int, start: int, given: bool, stays: bool
) -> None:
    made = shifted(slid(0.05, 99, FRAMES - 1))  # the heel rests until the toe joint slides
    heel = Footplant(0, 2 * number, "heel", number, "heel", 40, 99)
    floors = replace(level(HEEL), plants=(*level(HEEL).plants, *level().plants))
    found, _ = kept(
        [heel, replace(toe(start, FRAMES), id=1)], made.legs, np.zeros((FRAMES, 3)), floors, DT, made.rig.leg_length,
        heights=True, params=PARAMS, by_hand=(given, given),
    )  # fmt: skip
    assert found is stays

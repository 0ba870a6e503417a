"""Measures: every figure worked out on paper, on a foot whose joints move as told."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace

import numpy as np
import pytest

from footfix.measure.clip import WORLD, Measures, jitter, measure, physdiff, skating_ratio, weighted_skate
from footfix.measure.plants import PlantMeasure
from footfix.measure.skinned_joints import tip_of
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Skeleton
from footfix.motion.contacts import Contact, Contacts
from footfix.rig.rig import Leg, Rig, SolePoint

# Every joint is a root of its own, so that each goes where its track says; HEEL and BALL carry the sole points.
PELVIS, HIP, KNEE, ANKLE, TOE, HEEL, BALL = range(7)
AT_REST = ((0.0, 1.0, 0.0), (0.0, 0.9, 0.0), (0.0, 0.5, 0.0), (0.0, 0.1, 0.0), (0.0, 0.03, 0.1), (0, 0, 0), (0, 0, 0.1))
TIP = 0.05  # [m] the End Site of the toe joint, ahead of it
DT = 0.05  # [s] 20 frames a second: 1 mm a frame is 2 cm/s
UP = np.array([0.0, 1.0, 0.0])


def figure(
    frames: int, moves: Mapping[int, Floats] = {}, turns: Mapping[int, Floats] = {}, *, tip: float = TIP
) -> tuple[Clip, Rig]:
    """One leg at rest on the floor; `moves` (F, 3) [m] are added to its joints' places, `turns` (F, 4) turn them."""
    names = ("pelvis", "hip", "knee", "ankle", "toe", "heel", "ball")
    rest = np.array(AT_REST, dtype=np.float64)
    skeleton = Skeleton(names, np.full(7, -1), rest, np.array([TOE]), np.array([[0.0, 0.0, tip]]))
    positions, rotations = np.tile(rest, (frames, 1, 1)), rotation.identity((frames, 7))
    for joint, move in moves.items():
        positions[:, joint] += move
    for joint, turn in turns.items():
        rotations[:, joint] = turn
    legs = (Leg("left", "left", HIP, KNEE, ANKLE, TOE, (HIP, KNEE, ANKLE)),)
    soles = (SolePoint("left_heel", 0, "heel", HEEL, (0, 0, 0)), SolePoint("left_toe", 0, "toe", BALL, (0, 0, 0)))
    return Clip(skeleton, positions, rotations, DT), Rig(PELVIS, PELVIS, legs, soles, 0.9, 0.0)


def measured(
    clip: Clip, rig: Rig, heel: tuple[tuple[int, int], ...] = (), toe: tuple[tuple[int, int], ...] = (),
    belt: Floats | None = None,
) -> tuple[Measures, tuple[PlantMeasure, ...]]:  # fmt: skip
    blank = rig.no_contacts(clip)
    spans = zip(blank.effectors, (heel, toe), strict=True)
    effectors = tuple(replace(each, contacts=tuple(Contact(a, b) for a, b in own)) for each, own in spans)
    return measure(clip, rig, replace(blank, effectors=effectors), belt=belt)


def along(axis: int, track: Floats) -> Floats:
    """(F, 3) [m] a track (F,) [mm] along one axis."""
    move = np.zeros((len(track), 3))
    move[:, axis] = 0.001 * track
    return move


def steady(frames: int, millimetres: float = 10.0) -> Floats:
    """(F,) [mm] so many millimetres a frame."""
    return millimetres * np.arange(frames)


# ---- one plant --------------------------------------------------------------------------------------


def test_a_toe_plant_slides_as_its_toe_joint_does() -> None:
    clip, rig = figure(21, {TOE: along(0, steady(21))})
    (plant,) = measured(clip, rig, toe=((0, 21),))[1]
    assert (plant.effector, plant.start, plant.end) == ("left_toe", 0, 21)
    assert plant.slide_mm == pytest.approx(90.0)  # frames 1 to 19 go from 10 to 190 mm, their median is 100
    assert plant.travel_mm == pytest.approx(180.0)
    assert plant.sole_slide_mm == 0.0
    assert (plant.speed_cm_s, plant.peak_speed_cm_s) == (pytest.approx(20.0), pytest.approx(20.0))


def test_a_foot_that_rolls_over_its_missing_toe_joint_does_not_slide() -> None:
    frames, high = 21, 0.04
    pitch = np.radians(np.linspace(0.0, 40.0, frames))
    turn = rotation.from_axis_angle(np.array([[1.0, 0.0, 0.0]]), pitch)
    arm = np.array([0.0, -high, 0.0])  # from the missing joint down to the sole point
    move = rotation.rotate(turn, np.tile(arm, (frames, 1))) - arm  # of the sole point, as the foot rolls over the joint
    clip, rig = figure(frames, {BALL: move}, {BALL: turn})
    heel, toe = rig.soles
    bare = replace(
        rig, legs=(replace(rig.legs[0], toe=None),), soles=(heel, replace(toe, held=(0.0, high, 0.0))),
    )  # fmt: skip
    measures, (plant,) = measured(clip, bare, toe=((0, frames),))
    assert plant.slide_mm == pytest.approx(0.0, abs=1e-9)
    assert plant.travel_mm == pytest.approx(0.0, abs=1e-9)
    depth = 1000.0 * high * np.sin(pitch[1:-1])
    assert plant.sole_slide_mm == pytest.approx(np.max(np.abs(depth - np.median(depth))))
    assert measures.skating_ratio == 0.0


def test_a_toe_without_joint_that_is_held_at_its_sole_is_looked_at_there() -> None:
    clip, rig = figure(21, {TOE: along(0, steady(21)), BALL: along(2, steady(21, 2.0))})
    (plant,) = measured(clip, replace(rig, legs=(replace(rig.legs[0], toe=None),)), toe=((0, 21),))[1]
    assert plant.slide_mm == plant.sole_slide_mm == pytest.approx(18.0)
    assert plant.tip_slide_mm is None


def test_a_heel_plant_slides_as_the_ankle_does_while_the_toe_stands_too() -> None:
    clip, rig = figure(30, {ANKLE: along(2, steady(30)), HEEL: along(2, steady(30, 1.0))})
    (plant, _) = measured(clip, rig, heel=((0, 20),), toe=((10, 30),))[1]
    assert plant.slide_mm == pytest.approx(35.0)  # frames 11 to 18
    assert plant.travel_mm == pytest.approx(70.0)
    assert plant.speed_cm_s == pytest.approx(20.0)
    assert plant.sole_slide_mm == pytest.approx(8.5)  # frames 1 to 18
    assert plant.tip_slide_mm is None


@pytest.mark.parametrize("toe", [(), ((17, 40),)])  # never, and for one frame that counts
def test_a_heel_that_the_foot_rolls_over_is_looked_at_itself(toe: tuple[tuple[int, int], ...]) -> None:
    clip, rig = figure(40, {ANKLE: along(2, steady(40)), HEEL: along(2, steady(40, 1.0))})
    plant = measured(clip, rig, heel=((0, 20),), toe=toe)[1][0]
    assert plant.slide_mm == pytest.approx(8.5)
    assert plant.speed_cm_s == pytest.approx(2.0)


def test_the_ankle_is_looked_at_in_all_frames_in_which_both_stand_and_in_no_other() -> None:
    away = np.repeat([0.0, 500.0, 8.0], (13, 13, 14))  # [mm] far off while the toe is up
    clip, rig = figure(40, {ANKLE: along(0, away)})
    plant = measured(clip, rig, heel=((0, 40),), toe=((0, 13), (26, 40)))[1][0]
    assert (plant.slide_mm, plant.travel_mm) == (pytest.approx(8.0), pytest.approx(8.0))
    assert (plant.speed_cm_s, plant.peak_speed_cm_s) == (0.0, 0.0)  # it did not go there while it was looked at


@pytest.mark.parametrize(("frames", "slide"), [(1, 0.0), (2, 5.0), (4, 15.0), (5, 10.0), (6, 15.0)])
def test_first_and_last_frame_count_in_short_contacts_only(frames: int, slide: float) -> None:
    clip, rig = figure(12, {TOE: along(0, steady(12))})
    (plant,) = measured(clip, rig, toe=((3, 3 + frames),))[1]
    assert plant.slide_mm == pytest.approx(slide)


def test_the_tip_of_the_toes_slides_on_its_own() -> None:
    quarter = np.where(np.arange(21) < 13, 0.0, np.pi / 2)
    turns = rotation.from_axis_angle(np.tile(UP, (21, 1)), quarter)
    clip, rig = figure(21, turns={TOE: turns})
    (plant,) = measured(clip, rig, toe=((0, 21),))[1]
    assert plant.tip_slide_mm == pytest.approx(50.0 * np.sqrt(2.0))  # from ahead to the side, 12 frames of 19 ahead
    assert plant.slide_mm == 0.0
    bare = measured(*figure(21, turns={TOE: turns}, tip=0.009), toe=((0, 21),))[1][0]
    assert bare.tip_slide_mm is None


def test_the_tip_is_what_ends_farthest_from_the_toe_joint() -> None:
    offsets = np.array([(0, 0, 0), (0, 0, 0.04), (0.01, 0, 0.02), (9, 9, 9)], dtype=np.float64)
    skeleton = Skeleton(
        ("toe", "big", "small", "hand"), np.array([-1, 0, 0, -1]), offsets, np.array([1, 2, 3]),
        np.array([(0, 0, 0.02), (0, 0, 0.01), (0, 9, 0)]),
    )  # fmt: skip
    joint, offset = tip_of(skeleton, 0) or (None, None)
    assert joint == 1 and np.allclose(offset, (0, 0, 0.02))
    without_ends = replace(skeleton, end_parents=np.zeros(0, int), end_offsets=np.zeros((0, 3)))
    joint, offset = tip_of(without_ends, 0) or (None, None)
    assert joint == 1 and np.allclose(offset, 0.0)
    assert tip_of(without_ends, 2) is None


def test_yaw_is_the_heading_of_the_foot_in_degrees_and_not_its_roll() -> None:
    heading = rotation.from_axis_angle(np.tile(UP, (33, 1)), 0.01 * np.arange(33))
    roll = rotation.from_axis_angle(np.tile([1.0, 0.0, 0.0], (33, 1)), np.linspace(-0.5, 0.5, 33))
    for turns, degrees in ((heading, 8.594367), (roll, 0.0), (rotation.multiply(heading, roll), 8.594367)):
        (plant,) = measured(*figure(33, turns={BALL: turns}), toe=((0, 33),))[1]
        assert plant.yaw_deg == pytest.approx(degrees, abs=1e-6)  # 0.15 rad on either side of the median


def test_penetration_is_downwards_float_is_upwards_and_a_stair_is_a_floor() -> None:
    heights = np.zeros(21)
    heights[[0, 5, 9]] = -50.0, -7.0, 4.0  # [mm]; frame 0 does not count
    (plant,) = measured(*figure(21, {BALL: along(1, heights)}), toe=((0, 21),))[1]
    assert (plant.penetration_mm, plant.float_mm) == (pytest.approx(7.0), pytest.approx(4.0))
    (plant,) = measured(*figure(21, {BALL: along(1, heights + 300.0)}), toe=((0, 21),))[1]
    assert (plant.penetration_mm, plant.float_mm) == (pytest.approx(7.0), pytest.approx(4.0))
    (plant,) = measured(*figure(21, {BALL: along(1, heights + 40.0)}), toe=((0, 21),))[1]  # under 4.5 cm is no stair
    assert (plant.penetration_mm, plant.float_mm) == (0.0, pytest.approx(44.0))


def test_mean_and_peak_speed_are_of_the_plants_own_steps() -> None:
    track = steady(41)
    track[12:] += 20.0  # one step of 30 mm among the 17 of frames 1 to 18
    track[20:] += 900.0  # between two plants
    first, second = measured(*figure(41, {TOE: along(2, track)}), toe=((0, 20), (20, 41)))[1]
    assert first.speed_cm_s == pytest.approx(2.0 * (16 * 10.0 + 30.0) / 17)
    assert first.peak_speed_cm_s == pytest.approx(60.0)
    assert (second.speed_cm_s, second.peak_speed_cm_s) == (pytest.approx(20.0), pytest.approx(20.0))
    short = measured(*figure(41, {TOE: along(2, track)}), toe=((17, 20), (20, 23)))[1]
    assert [plant.peak_speed_cm_s for plant in short] == pytest.approx([20.0, 20.0])


def test_slide_is_the_farthest_from_the_median_place_over_the_floor() -> None:
    move = np.random.default_rng(5).normal(size=(40, 3))
    (plant,) = measured(*figure(40, {TOE: move}), toe=((4, 33),))[1]
    flat = move[5:32][:, [0, 2]]
    assert plant.slide_mm == pytest.approx(1000.0 * np.linalg.norm(flat - np.median(flat, axis=0), axis=1).max())


# ---- a clip -----------------------------------------------------------------------------------------


def test_the_plants_of_a_clip_in_numbers() -> None:
    track = np.zeros(100)
    track[:12], track[70:82] = steady(12), steady(12, 1.0)  # [mm] the first plant slides, the third a little,
    track[40:60] = 15.0  # and the second in one step
    heights, turn = np.zeros(100), np.zeros(100)
    heights[[3, 30]] = -8.0, 6.0  # [mm]
    turn[25:60] = np.linspace(0.0, 0.2, 35)  # [rad]
    turns = rotation.from_axis_angle(np.tile(UP, (100, 1)), turn)
    clip, rig = figure(100, {TOE: along(0, track), BALL: along(1, heights)}, {BALL: turns})
    found, plants = measured(clip, rig, toe=((0, 11), (25, 60), (70, 81)))
    assert [plant.slide_mm for plant in plants] == pytest.approx([40.0, 15.0, 4.0])
    assert (found.plants, found.plants_over_21mm) == (3, 1)
    assert found.share_over_21mm == found.tip_over_21mm == pytest.approx(1 / 3)
    assert (found.slide_mm, found.slide_median_mm) == (pytest.approx(40.0), pytest.approx(15.0))
    assert found.yaw_deg == pytest.approx(max(plant.yaw_deg for plant in plants)) == pytest.approx(5.56, abs=0.2)
    assert found.coverage == pytest.approx((11 + 35 + 11) / 200)
    assert found.skate_cm_s == pytest.approx((10 * 20.0 + 34 * 30.0 / 32 + 10 * 2.0) / 54)
    assert found.skate_worst_cm_s == pytest.approx(30.0)
    assert (found.penetration_mm, found.float_mm) == (pytest.approx(8.0), pytest.approx(6.0))


def test_what_is_forbidden_is_no_plant_and_a_clip_may_have_none() -> None:
    clip, rig = figure(30, {TOE: along(0, steady(30))})
    blank = rig.no_contacts(clip)
    banned = replace(blank.effectors[1], contacts=(Contact(0, 20, wish="forbid"),))
    found, plants = measure(clip, rig, replace(blank, effectors=(blank.effectors[0], banned)))
    assert plants == () and found == measured(clip, rig)[0]
    assert (found.plants, found.slide_mm, found.skate_cm_s, found.coverage, found.tip_over_21mm) == (0, 0, 0, 0, None)


def test_peaks_are_of_knees_and_ankles_seen_from_the_pelvis() -> None:
    t = DT * np.arange(41)
    ride = along(0, 3000.0 * t**2)  # all of it accelerates by 6 m/s^2
    moves: dict[int, Floats] = dict.fromkeys(range(7), ride)
    moves[ANKLE] = ride + along(0, 2000.0 * t**2)
    found = measured(*figure(41, moves))[0]
    assert found.peak_acceleration_m_s2 == pytest.approx(4.0)
    shin = np.pi / 2 * t / 2.0  # [rad] 45 degrees a second
    swung = 0.4 * np.stack([np.sin(shin), 1.0 - np.cos(shin), np.zeros(41)], axis=1)
    assert measured(*figure(41, {ANKLE: swung}))[0].peak_knee_speed_deg_s == pytest.approx(45.0)


@pytest.mark.parametrize("frames", [5, 1024, 4099, 4100, 9000])
def test_jitter_is_the_mean_third_difference_whatever_the_blocks(frames: int) -> None:
    t = DT * np.arange(frames)
    clip, rig = figure(frames, {TOE: along(0, 50.0 * t**3)})  # [mm] 0.3 m/s^3, of one joint in seven
    assert jitter(clip) == pytest.approx(0.3 / 7 / 100.0, rel=1e-6)
    assert measured(clip, rig)[0].jitter_100m_s3 == pytest.approx(0.3 / 7 / 100.0, rel=1e-6)


# ---- the measures of the literature -----------------------------------------------------------------


def run_off(fps: float, speed: float) -> Floats:
    """(F, 3) [m] two seconds of a toe that stands for one and then goes off."""
    track = np.zeros((round(2 * fps) + 1, 3))
    track[:, 0] = speed * np.maximum(np.arange(len(track)) / fps - 1.0, 0.0)
    return track


@pytest.mark.parametrize("fps", [20, 30, 60, 120])
def test_skating_ratio_is_the_published_one_at_any_frame_rate(fps: int) -> None:
    assert skating_ratio([run_off(fps, 1.0)], [0.0], 1.0 / fps) == pytest.approx(20 / 40)
    # at 0.8 m/s the mean of five steps, of which two are none, is 0.48 at either end
    assert skating_ratio([run_off(fps, 0.8)], [0.0], 1.0 / fps) == pytest.approx(18 / 40)
    assert skating_ratio([run_off(fps, 0.49)], [0.0], 1.0 / fps) == 0.0
    assert skating_ratio([run_off(fps, 0.0), run_off(fps, 1.0)], [0.0, 0.0], 1.0 / fps) == pytest.approx(20 / 40)


@pytest.mark.parametrize(("height", "rest", "ratio"), [(0.049, 0.0, 0.5), (0.051, 0.0, 0.0), (0.14, 0.1, 0.5)])
def test_skating_is_near_where_the_toe_rests(height: float, rest: float, ratio: float) -> None:
    assert skating_ratio([run_off(20, 1.0) + height * UP], [rest], DT) == pytest.approx(ratio)


def test_a_toe_joint_rests_where_it_does_in_its_contacts() -> None:
    track = run_off(20, 1.0) + 0.1 * UP  # the toe joint, 13 cm over the floor
    clip, rig = figure(41, {TOE: track})
    assert measured(clip, rig, toe=((2, 18),))[0].skating_ratio == pytest.approx(20 / 40)
    assert measured(clip, rig)[0].skating_ratio == 0.0  # nowhere it rests


def test_weighted_skate_falls_to_nothing_at_its_height() -> None:
    for height, speed in ((0.0, 200.0), (-0.1, 200.0), (0.033 * np.log2(1.5), 100.0), (0.033, 0.0)):
        track = along(2, steady(11, 100.0)) + height * UP  # 2 m/s
        assert weighted_skate([track], 0.0, DT) == pytest.approx(speed)
        found = measured(*figure(11, {BALL: track, HEEL: 9.0 * UP + np.zeros((11, 3))}))[0]
        assert found.weighted_skate_cm_s == pytest.approx(speed / 2)  # of two sole points


def test_physdiffs_three() -> None:
    track = np.zeros((4, 3))
    track[:, 1] = [-0.02, 0.004, 0.03, -0.004]
    track[:, 0] = [0.0, 0.01, 0.02, 0.03]
    assert physdiff([track], 0.0) == (pytest.approx(5.0), pytest.approx(7.5), pytest.approx(10.0 / 3))
    stair = physdiff([track + 0.2 * UP], 0.2, [track[:, 1] + 0.19, track[:, 1] + 0.3])  # a vertex 1 cm below the point
    assert stair[:2] == (pytest.approx((30.0 + 6.0 + 14.0) / 4), pytest.approx(20.0 / 4))
    found = measured(*figure(4, {BALL: track, HEEL: 9.0 * UP + np.zeros((4, 3))}))[0]
    assert found.phys_penetrate_mm == pytest.approx(5.0)
    assert found.phys_float_mm == pytest.approx(7.5)
    assert found.phys_skate_mm == pytest.approx(10.0 / 3)


# ---- a ground that moves ----------------------------------------------------------------------------


def test_on_a_belt_plants_are_measured_against_it_and_the_literature_is_silent() -> None:
    belt = along(2, steady(41, -60.0))
    clip, rig = figure(41, dict.fromkeys((ANKLE, TOE, HEEL, BALL), belt))
    spans = {"heel": ((0, 41),), "toe": ((5, 36),)}
    carried, plants = measured(clip, rig, **spans, belt=belt)
    assert max(plant.slide_mm for plant in plants) == pytest.approx(0.0, abs=1e-9)
    assert max(plant.speed_cm_s for plant in plants) == pytest.approx(0.0, abs=1e-9)
    assert max(plant.tip_slide_mm or 0.0 for plant in plants) == pytest.approx(0.0, abs=1e-9)
    assert max(plant.sole_slide_mm for plant in plants) == pytest.approx(0.0, abs=1e-9)
    assert all(getattr(carried, name) is None for name in WORLD)
    at_rest = measured(clip, rig, **spans, belt=np.zeros((41, 3)))
    assert at_rest == measured(clip, rig, **spans)
    assert at_rest[0].slide_mm == pytest.approx(14 * 60.0) and at_rest[0].skating_ratio == 1.0
    blank = {each.name for each in fields(Measures) if getattr(carried, each.name) is None}
    assert blank == set(WORLD)


def test_contacts_that_are_no_plants_do_not_shift_the_others() -> None:
    """Plants are joined to measures by their place, so each measure is of the contact at that place."""
    clip, rig = figure(60, {TOE: along(0, steady(60))})
    contacts: Contacts = rig.no_contacts(clip)
    spans = (Contact(0, 10), Contact(12, 20, wish="forbid"), Contact(30, 51))
    contacts = replace(contacts, effectors=(contacts.effectors[0], replace(contacts.effectors[1], contacts=spans)))
    assert [(p.start, p.end, round(p.slide_mm)) for p in measure(clip, rig, contacts)[1]] == [(0, 10, 35), (30, 51, 90)]


def test_what_is_just_as_far_from_the_floor_as_the_tolerance_is_on_it() -> None:
    track = np.zeros((3, 3))
    track[:, 0], track[:, 1] = [0.0, 1.0, 2.0], [0.5, -0.5, 0.5]
    assert physdiff([track], 0.0, tolerance=0.5) == (0.0, 0.0, 1000.0)
    assert physdiff([], 0.0) == physdiff([track[:0]], 0.0) == (0.0, 0.0, 0.0)


def test_a_figure_without_sole_points_is_never_in_contact() -> None:
    clip, rig = figure(20)
    rig = replace(rig, soles=())
    assert measure(clip, rig, rig.no_contacts(clip))[0].coverage == 0.0


def test_a_clip_too_short_to_move_has_no_peaks() -> None:
    for frames in (1, 2):
        found = measured(*figure(frames))[0]
        assert (found.peak_acceleration_m_s2, found.jitter_100m_s3) == (0.0, 0.0)
        assert (found.peak_knee_speed_deg_s, found.skating_ratio, found.weighted_skate_cm_s) == (0.0, 0.0, 0.0)


def test_jitter_is_the_length_of_the_third_difference_in_space() -> None:
    t = DT * np.arange(20)
    cubic = 0.001 * (along(0, 20.0 * t**3) + along(1, 30.0 * t**3) + along(2, 60.0 * t**3)) / 0.001  # 70 mm/s^3 long
    clip, _ = figure(20, {TOE: cubic})
    assert jitter(clip) == pytest.approx(6.0 * 0.07 / 7 / 100.0)


@pytest.mark.parametrize("block", [1, 7, 16, 17, 100])
def test_jitter_counts_each_third_difference_once_whatever_the_blocks(block: int) -> None:
    move = np.random.default_rng(7).normal(size=(20, 3))
    clip, _ = figure(20, {TOE: move})
    lengths = np.linalg.norm(np.diff(move, n=3, axis=0), axis=1)
    assert jitter(clip, block) == pytest.approx(lengths.mean() / 7 / DT**3 / 100.0)


def test_two_frames_are_enough_to_skate() -> None:
    track = np.array([[0.0, 0.0, 0.0], [0.13, 0.0, 0.0]])  # 2.6 m/s, and 0.52 in the mean of five steps
    assert skating_ratio([track], [0.0], DT) == 1.0
    assert skating_ratio([0.9 * track], [0.0], DT) == 0.0

"""The engine: plans, courses, feet that stand, and what comes next."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cycle_walkers import fitted

import footfix
from footfix.errors import ArgumentError
from footfix.formats.locomotion_plans import PlanRow
from footfix.jobs.make_cycles import make, plan_of
from footfix.locomotion.cycles.engine import changed_plan, postures, predict
from footfix.locomotion.cycles.plan import Plan, Point, make_course
from footfix.locomotion.cycles.postures import cycle_postures, leg_poses
from footfix.locomotion.follow.path import make_path
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import runs
from footfix.motion.kinematics import forward


def steady(speed: float, turn: float = 0.0) -> Plan:
    rows = (np.array([each]) for each in (0.0, speed, 0.0, turn))
    return Plan(*rows, np.zeros((1, 0)))


def course_of(plan: Plan, until: float = 6.0) -> object:
    return make_course(plan, None, Point(), until, 0.0, lambda asked: np.full(len(asked.times), 0.9))


def test_a_steady_turn_is_a_circle() -> None:
    course = course_of(steady(1.5, 0.5))
    times = np.linspace(0.0, 6.0, 50)
    place, heading = course.where(times)  # type: ignore[attr-defined]
    centre = np.array([3.0, 0.0])  # to the left, v / omega away
    assert np.allclose(np.linalg.norm(place - centre, axis=1), 3.0, atol=1e-9)
    assert np.allclose(heading, 0.5 * times, atol=1e-12)


def test_a_speed_that_rises_evenly_goes_the_known_way() -> None:
    plan = Plan(np.array([0.0, 2.0]), np.array([1.0, 2.0]), np.zeros(2), np.zeros(2), np.zeros((2, 0)))
    course = course_of(plan, 3.0)
    gone = course.lengths(np.array([1.0, 2.0, 3.0]))  # type: ignore[attr-defined]
    assert np.allclose(gone, [1.25, 3.0, 5.0], atol=1e-12)


def test_a_changed_plan_goes_on_from_where_it_is() -> None:
    plan = Plan(np.array([0.0, 4.0]), np.array([1.0, 3.0]), np.zeros(2), np.zeros(2), np.zeros((2, 0)))
    new = plan.changed(2.0, np.array([3.0, np.nan, np.nan]), steady(0.5))
    assert new.at(np.array([1.0])).speed[0] == pytest.approx(1.5)
    assert new.at(np.array([2.0, 2.5, 3.0, 9.0])).speed == pytest.approx([2.0, 1.25, 0.5, 0.5])


def test_what_is_not_named_goes_on_as_it_was_planned() -> None:
    plan = Plan(np.array([0.0, 4.0]), np.array([1.0, 3.0]), np.zeros(2), np.zeros(2), np.zeros((2, 0)))
    new = plan.changed(1.0, np.array([np.nan, np.nan, 2.0]), steady(0.5, 1.0))
    at = np.linspace(0.0, 5.0, 21)
    assert new.at(at).speed == pytest.approx(plan.at(at).speed)
    assert new.at(at).turn == pytest.approx(np.clip(at - 1.0, 0.0, 1.0))
    assert new.ends()[[0, 2]] == pytest.approx([4.0, 2.0]) and np.isneginf(new.ends()[1])
    for k in range(50):  # knots at which nothing bends are not kept
        new = new.changed(1.0 + 0.01 * k, np.array([np.nan, np.nan, 2.0 + 0.01 * k]), steady(0.5, 1.0))
    assert len(new.since(1.49).times) <= 5


def plants(clip: Clip, mask: np.ndarray) -> float:
    """[m] the farthest that a planted toe joint or heel strays, told from the clip alone."""
    model = fitted().model
    worst = 0.0
    for e, sole in enumerate(model.rig.soles):
        toe = model.rig.legs[sole.leg].toe
        track: Floats
        if sole.part == "toe" and toe is not None:
            track = forward(clip, [toe]).position(toe)
        else:
            track = forward(clip, [sole.joint]).point(sole.joint, np.array(sole.offset))
        for a, b in runs(mask[:, e]):
            own = track[a:b, [0, 2]]
            worst = max(worst, float(np.linalg.norm(own - np.median(own, axis=0), axis=1).max()))
    return worst


def steps(clip: Clip) -> Floats:
    """(F - 1, J) [degrees] that joints turn from frame to frame."""
    turn = rotation.multiply(rotation.inverse(clip.rotations[:-1]), clip.rotations[1:])
    return np.degrees(rotation.angle(turn))


@pytest.mark.parametrize("turn", [0.0, 30.0])
def test_from_a_walk_to_a_run_within_three_seconds(turn: float) -> None:
    model = fitted().model
    rows = [PlanRow(0.0, 0.8, 0.0, 0.0), PlanRow(1.0, 0.8, 0.0, 0.0), PlanRow(4.0, 1.9, 1.0, turn)]
    made = make(model, plan_of(rows, model), seconds=5.5, fps=120.0)
    assert plants(made.clip, made.postures.contacts) <= 1e-3
    assert (steps(made.clip) - steps(made.free)).max() <= 2.0
    assert made.postures.contacts.any(axis=1).mean() > 0.6


def test_the_speed_is_what_was_asked_for() -> None:
    model = fitted().model
    for speed in (0.9, 1.6):
        made = make(model, plan_of([PlanRow(0.0, speed, 0.0)], model), seconds=4.0, fps=60.0)
        root = made.clip.position(model.rig.root)
        period = round(60.0 / float(model.frequency(plan_of([PlanRow(0.0, speed, 0.0)], model))[0]))
        assert np.linalg.norm(root[3 * period] - root[0]) / (3 * period / 60.0) == pytest.approx(speed, rel=0.02)


def test_along_a_path_the_root_stays_on_it() -> None:
    model = fitted().model
    angle = np.linspace(0.0, np.pi, 60)
    line = make_path(np.stack([3.0 * (1.0 - np.cos(angle)), 3.0 * np.sin(angle)], axis=1))
    made = make(model, plan_of([PlanRow(0.0, 1.3, 0.0)], model), seconds=6.0, fps=60.0, line=line)
    root = made.clip.position(model.rig.root)[:, [0, 2]]
    off = np.linalg.norm(root - [3.0, 0.0], axis=1) - 3.0
    period = round(60.0 / float(model.frequency(plan_of([PlanRow(0.0, 1.3, 0.0)], model))[0]))
    mean = np.convolve(off, np.ones(period) / period, mode="valid")
    assert np.abs(mean).max() < 0.01
    assert plants(made.clip, made.postures.contacts) <= 1e-3


def test_the_engine_changes_in_mid_change_without_a_slip() -> None:
    engine = footfix.Engine(fitted().model, speed=0.8, run=0.0)
    frames = []
    for k in range(330):
        if k == 40:
            engine.set(speed=1.9, run=1.0, over=3.0)
        if k == 150:
            engine.set(speed=1.2, run=0.0, turn=25.0, over=1.0)
        frames.append(engine.step(1 / 120))
    clip = engine.clip(frames, 1 / 120)
    mask = np.array([list(each.contacts.values()) for each in frames])
    assert plants(clip, mask) <= 1e-3
    place = forward(clip).positions
    assert np.linalg.norm(np.diff(place, axis=0), axis=2).max() < 0.08  # m in a frame: nothing leaps


def test_steered_hard_no_joint_turns_much_faster_than_in_the_cycles() -> None:
    engine = footfix.Engine(fitted().model, speed=1.2, run=0.0)
    frames, cycles = [], []
    for k in range(240):
        if k % 12 == 0:
            engine.set(turn=90.0 * (-1.0) ** (k // 36), speed=1.2 + 0.3 * np.sin(k), over=0.1)
        frames.append(engine.step(1 / 120))
        course = engine._live.prediction.course
        cycles.append(cycle_postures(engine.model, course, np.array([engine.time])).turns[0])
    own = engine.clip([replace(f, rotations=q) for f, q in zip(frames, cycles, strict=True)], 1 / 120)
    clip = engine.clip(frames, 1 / 120)
    assert (steps(clip) - steps(own)).max() <= 2.0
    assert plants(clip, np.array([list(each.contacts.values()) for each in frames])) <= 1e-3


def test_a_change_is_taken_up_as_quickly_as_feet_can_follow() -> None:
    model = fitted().model
    here = steady(1.2)
    target = steady(1.2 + 0.25 * model.froude, np.radians(150.0))
    for over in (0.0, 0.1, 2.0):
        turned = changed_plan(model, here, 1.0, 1.0 + np.array([over, np.nan, over]), target)
        assert turned.ends()[[0, 2]] == pytest.approx(1.0 + np.maximum(over, [0.5, 1.0]))
    assert changed_plan(model, here, 1.0, np.full(3, 1.0), here).times[-1] == pytest.approx(1.25)


def test_the_course_is_the_one_asked_for_though_it_is_taken_up_some_frames_later() -> None:
    engine = footfix.Engine(fitted().model, speed=0.8, run=0.0)
    for k in range(480):
        if k == 60:
            engine.set(speed=1.9, run=1.0, turn=30.0, over=3.0)
        if k == 240:
            engine.set(speed=1.2, run=0.0, turn=-30.0, over=1.0)
        engine.step(1 / 120)
    mid = 0.8 + 1.1 * 0.5
    times = np.array([0.5, 2.0, 3.0])
    turns = np.radians([0.0, 15.0, -30.0])
    asked = Plan(times, np.array([0.8, mid, 1.2]), np.zeros(3), turns, np.zeros((3, 0)))
    place, heading = course_of(asked).where(np.array([engine.time]))  # type: ignore[attr-defined]
    own, headed = engine._live.prediction.course.where(np.array([engine.time]))
    assert np.linalg.norm(own - place) < 0.005
    assert headed == pytest.approx(heading, abs=2e-3)


def test_one_plan_is_joined_to_another() -> None:
    rising = Plan(np.array([0.0, 3.0]), np.array([0.0, 3.0]), *np.zeros((2, 2)), np.zeros((2, 0)))
    both = steady(1.0).joined(1.0, 0.5, rising, np.zeros(3))
    assert both.at(np.array([0.5, 1.0, 1.25, 1.5, 2.0, 4.0])).speed == pytest.approx([1.0, 1.0, 1.25, 1.5, 2.0, 3.0])


def test_a_plan_that_is_joined_makes_up_for_what_it_was_behind() -> None:
    rising = Plan(np.array([0.0, 3.0]), np.array([0.0, 3.0]), *np.zeros((2, 2)), np.zeros((2, 0)))
    both = steady(0.5).joined(1.0, 0.5, rising, np.array([0.2, 0.3, 0.1]))
    fine = np.linspace(1.0, 2.0, 100001)
    gone, turned = (np.mean(each) for each in (both.at(fine).speed, both.at(fine).turn))
    assert gone == pytest.approx(1.5 + 0.2, abs=1e-4)
    assert both.sums(1.0, 2.0) == pytest.approx([gone, 0.0, turned], abs=1e-4)
    assert turned == pytest.approx(0.1, abs=1e-4)


@pytest.mark.parametrize("dts", [[1 / 120], [1 / 30], [0.004, 0.021, 0.009]])
def test_frames_of_any_length_go_on_without_a_leap(dts: list[float]) -> None:
    engine = footfix.Engine(fitted().model, speed=1.0, run=0.0)
    places, times = [], []
    for k in range(90):
        if k % 5 == 0:
            engine.set(speed=1.0 + 0.3 * (k % 2), over=0.5)
        frame = engine.step(dts[k % len(dts)])
        places.append(frame.positions[engine.rig.root])
        times.append(frame.time)
    assert times == pytest.approx(np.cumsum([dts[k % len(dts)] for k in range(90)]))
    speed = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(times)
    assert speed.max() < 1.8 and speed.min() > 0.6


def test_to_ask_for_the_same_again_changes_nothing() -> None:
    once, often = (footfix.Engine(fitted().model, speed=1.0, run=0.0) for _ in range(2))
    once.set(speed=1.4, turn=20.0, over=1.0)
    for _ in range(80):
        often.set(speed=1.4, turn=20.0, over=1.0)
        one, other = once.step(1 / 60), often.step(1 / 60)
        assert np.array_equal(one.rotations, other.rotations) and np.array_equal(one.positions, other.positions)


def test_a_figure_goes_on_from_where_it_is_whatever_is_asked() -> None:
    engine = footfix.Engine(fitted().model, speed=1.2, run=0.0)
    for k in range(60):
        frame = engine.step(1 / 60)
        if k % 7 == 0:
            engine.set(speed=0.9 + 0.01 * k, run=k / 60, turn=3.0 * k - 60.0, over=0.5)
            told = engine.ahead(0.1, frames=2)
            assert np.allclose(told.positions[0], frame.positions, atol=1e-9)
            off = rotation.multiply(rotation.inverse(frame.rotations), told.rotations[0])
            assert rotation.angle(off).max() < 1e-6


def test_ahead_is_in_the_know_of_what_was_just_asked_for() -> None:
    engine = footfix.Engine(fitted().model, speed=1.0, run=0.0)
    for _ in range(30):
        engine.step(1 / 60)
        straight = engine.ahead(1.0)
    engine.set(turn=40.0, over=0.25)
    left = engine.ahead(1.0)
    assert left.positions[-1, engine.rig.root, 0] > straight.positions[-1, engine.rig.root, 0] + 0.15


def test_who_looks_ahead_in_every_frame_is_still_steered() -> None:
    engine = footfix.Engine(fitted().model, speed=1.0, run=0.0)
    for k in range(90):
        engine.set(speed=1.0 + 0.006 * k, over=0.25)
        frame = engine.step(1 / 60)
        told = engine.ahead(0.2, frames=3)
        assert np.allclose(told.positions[0], frame.positions, atol=1e-9)
    gone = np.linalg.norm(told.positions[-1, engine.rig.root] - told.positions[0, engine.rig.root])
    assert gone / 0.2 == pytest.approx(1.5, abs=0.15)


def test_many_times_at_once_are_the_same_as_one_by_one() -> None:
    model = fitted().model
    prediction = predict(model, steady(1.4, 0.3), None, Point(), 3.0)
    times = np.linspace(0.0, 3.0, 13)
    every = postures(model, prediction, times)
    for k, time in enumerate(times):
        one = postures(model, prediction, np.array([time]))
        assert np.allclose(one.place[0], every.place[k], atol=1e-12)
        assert np.allclose(one.turns[0], every.turns[k], atol=1e-9)
    legs = leg_poses(model, prediction.course, times)
    free = cycle_postures(model, prediction.course, times)
    for name in ("hip", "knee", "ankle", "soles", "ends"):
        assert np.allclose(getattr(legs, name), getattr(free.legs, name), atol=1e-12)
    clip = replace(every, place=free.place, turns=free.turns).clip(model, 0.25)
    pose = forward(clip)
    for k, leg in enumerate(model.rig.legs):
        assert np.allclose(pose.position(leg.knee), legs.knee[:, k], atol=1e-9)
        assert leg.toe is None or np.allclose(pose.position(leg.toe), legs.toe[:, k], atol=1e-9)


@pytest.mark.parametrize("speed", [0.0, 12.0])
def test_what_nobody_walks_at_is_made_as_well(speed: float) -> None:
    engine = footfix.Engine(fitted().model, speed=speed)
    frames = [engine.step(dt) for dt in (0.0, 0.02, 9.0, 0.02)]
    assert all(np.isfinite(each.rotations).all() for each in frames)
    assert frames[-1].positions[engine.rig.root, 2] == pytest.approx(9.04 * speed, abs=0.3)


def test_what_comes_next_does_come() -> None:
    engine = footfix.Engine(fitted().model, speed=1.2, run=0.0)
    for _ in range(30):
        engine.step(1 / 60)
    told = engine.ahead(0.5, frames=31)
    for k in range(1, 31):
        frame = engine.step(1 / 60)
        assert np.allclose(frame.positions, told.positions[k], atol=1e-5)
        off = rotation.multiply(rotation.inverse(frame.rotations), told.rotations[k])
        assert rotation.angle(off).max() < 1e-4
    (start, end, place), *_ = told.plants["left_toe"]
    assert end > start
    assert place[1] == pytest.approx(fitted().model.levels[1] * fitted().model.rig.leg_length)


def test_what_can_not_be_meant_is_refused() -> None:
    model = fitted().model
    with pytest.raises(ArgumentError, match="speed must be 0 to 100"):
        footfix.Engine(model, speed=-1.0)
    engine = footfix.Engine(model)
    with pytest.raises(ArgumentError, match="dt must be"):
        engine.step(-0.1)
    with pytest.raises(footfix.UsageError, match="no style 'sad'"):
        engine.set(style="sad")

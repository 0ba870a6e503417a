"""The ground under plants: belts that a figure gets on and off, and figures that float."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce.ground import GroundParams, _drifts, _without_gaps, belt, belt_notes, lift
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.motion.contacts import Contact, Contacts
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig

FPS, LEG = 60.0, 0.88
LENGTH = 24  # frames of a step
PARAMS = GroundParams()


def steps(speeds: Floats, hip_speed: float = 0.0) -> tuple[Rig, Pose, Contacts]:
    """Two feet that stand in turn for 0.4 s at these speeds [m/s] over the floor, under hips that go on at another."""
    made = walk()
    rig = rig_of(made)
    frames = LENGTH * (len(speeds) + 1)
    at = np.zeros((frames, 3))
    at[:, 0] = hip_speed * np.arange(frames) / FPS
    tracks, spans = [at.copy(), at.copy()], [[], []]  # type: ignore[var-annotated]
    for n, speed in enumerate(speeds):
        span = slice(n * LENGTH, (n + 1) * LENGTH)
        tracks[n % 2][span, 0] = at[n * LENGTH, 0] + speed * np.arange(LENGTH) / FPS
        spans[n % 2].append(Contact(span.start, span.stop, 0.9))
    joints = rig.joints()
    feet = {joint: tracks[k] for k, leg in enumerate(rig.legs) for joint in (leg.ankle, leg.toe)}
    places = np.stack([feet.get(joint, at) for joint in joints], axis=1)
    pose = Pose(joints, places, rotation.identity((frames, len(joints))))
    effectors = tuple(
        replace(e, contacts=tuple(spans[k // 2]) if e.part == "heel" else ())
        for k, e in enumerate(made.contacts.effectors)
    )
    return rig, pose, replace(made.contacts, frames=frames, effectors=effectors)


def found(speeds: Floats, hip_speed: float = 0.0) -> Floats:
    """(F, 3) [m/s] velocity of the belt."""
    ground = belt(*steps(speeds, hip_speed), 1.0 / FPS, PARAMS)
    assert not ground[0].any()
    return np.diff(ground, axis=0) * FPS


def test_a_belt_is_the_velocity_that_planted_feet_share_while_the_hips_stay() -> None:
    assert np.allclose(found(np.full(20, 1.2)), [1.2, 0.0, 0.0])
    assert not found(np.full(20, 1.2), hip_speed=1.2).any()
    assert not found(np.zeros(20)).any()
    assert not found(0.8 * PARAMS.belt * LEG * np.ones(20)).any()
    assert found(1.2 * PARAMS.belt * LEG * np.ones(20)).any()
    assert not found(np.full(3, 1.2)).any()  # three plants make no belt


def test_a_figure_gets_on_a_belt_and_off() -> None:
    speeds = np.zeros(40)
    speeds[10:26] = 1.2 + 0.05 * np.cos(np.arange(16))
    velocity = found(speeds)
    on = np.linalg.norm(velocity, axis=1) > 0.0
    first, last = np.flatnonzero(on)[[0, -1]] / LENGTH
    assert 7.0 <= first <= 10.0 and 26.0 <= last + 1.0 / LENGTH <= 29.0 and np.all(np.diff(np.flatnonzero(on)) == 1)
    assert np.allclose(velocity[on], [1.2, 0.0, 0.0], atol=0.06)
    few = np.zeros(40)
    few[10:15] = 1.2  # a slide or two are none
    assert not found(few).any()
    assert not found(np.array([0.0, 1.2, 1.2, 1.2, 0.0])).any()
    slow = np.where(speeds > 0.0, 0.3, 0.0)  # a figure that wanders while its hips stay
    assert not found(slow).any()


def test_a_plant_or_two_that_do_not_go_along_make_no_end_of_a_belt() -> None:
    speeds = np.full(30, 1.2)
    speeds[[11, 12]] = 0.0
    assert np.allclose(found(speeds), [1.2, 0.0, 0.0], atol=1e-6)
    rig, pose, contacts = steps(np.full(20, 1.2))
    none = [replace(e, contacts=tuple(replace(c, wish="forbid") for c in e.contacts)) for e in contacts.effectors]
    assert not belt(rig, pose, replace(contacts, effectors=tuple(none)), 1.0 / FPS, PARAMS).any()


def test_a_belt_says_how_fast_it_is_and_for_how_long() -> None:
    ground = np.cumsum(np.tile([0.02, 0.0, 0.0], (61, 1)), axis=0)
    (note,) = belt_notes(ground, 1.0 / FPS)
    assert note.id == "in-place" and "1.20 m/s" in note.text and " for " not in note.text
    ground[30:] = ground[30]
    (note,) = belt_notes(ground, 1.0 / FPS)
    assert "for 0.5 s" in note.text and "1.20 m/s" in note.text
    assert belt_notes(0.0 * ground, 1.0 / FPS) == ()


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_figure_is_lifted_only_where_its_plants_agree(sign: float) -> None:
    def lifted(*lacks: float) -> float:
        return sign * lift(sign * np.array(lacks), LEG, PARAMS)

    assert lifted(0.033, 0.031, 0.035) == pytest.approx(0.033)
    assert lifted(0.03, 0.03, 0.03, 0.029, 0.001) == pytest.approx(0.03)
    assert lifted(0.03, 0.03, 0.03, 0.0, 0.0) == 0.0
    assert lifted(0.002, 0.001, 0.002) == 0.0  # less than is worth it
    assert lifted(0.034, 0.033, 0.001, 0.003, 0.034) == 0.0
    assert lifted(0.05, 0.05) == 0.0  # two plants may be a step
    assert lifted() == 0.0


def test_a_figure_that_steps_off_the_floor_onto_a_belt_is_not_lowered_by_the_belts_height() -> None:
    on_belt = [-0.16] * 19
    assert lift(np.array([*on_belt, 0.01, 0.02]), LEG, PARAMS) == 0.0
    assert lift(np.array([*on_belt, 0.3, -0.02]), LEG, PARAMS) == pytest.approx(-0.16)  # one in 21 is an error
    assert lift(np.array(on_belt), LEG, PARAMS) == pytest.approx(-0.16)


def test_hips_that_go_on_ride_no_belt_for_a_while_either() -> None:
    speeds = np.zeros(40)
    speeds[10:26] = 1.2
    assert found(speeds).any()
    for hip_speed in (0.4, 1.2):
        assert not found(speeds, hip_speed=hip_speed).any()


def test_a_plants_drift_is_its_way_over_its_time() -> None:
    rig, pose, contacts = steps(np.array([1.2, 0.6]))
    first, second = _drifts(rig, pose, contacts, 1.0 / FPS)
    assert [(each.leg, each.start, each.end) for each in (first, second)] == [(0, 0, LENGTH), (1, LENGTH, 2 * LENGTH)]
    for drift, speed in ((first, 1.2), (second, 0.6)):
        assert drift.seconds == pytest.approx((LENGTH - 1) / FPS)
        assert drift.velocity == pytest.approx([speed, 0.0, 0.0])
        assert drift.steps == pytest.approx(np.tile([speed, 0.0, 0.0], (LENGTH - 1, 1)))
    short = [replace(e, contacts=tuple(replace(c, end=c.start + n) for c in e.contacts)) for n, e in
             zip((3, 0, 2, 0), contacts.effectors, strict=True)]  # fmt: skip
    assert len(_drifts(rig, pose, replace(contacts, effectors=tuple(short)), 1.0 / FPS)) == 1


def test_short_gaps_within_are_filled_and_no_others() -> None:
    mask = np.array([0, 0, 1, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0], dtype=bool)
    assert np.flatnonzero(_without_gaps(mask, 2)).tolist() == [2, 3, 4, 5, 6, 7, 11]


def test_four_plants_may_make_a_belt() -> None:
    assert np.allclose(found(np.full(4, 1.2)), [1.2, 0.0, 0.0])

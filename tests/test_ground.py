"""The ground under plants: belts that a figure gets on and off, and feet that are on none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from walks import cleaned, rig_of, walk

from footfix.enforce.aims import levelled
from footfix.enforce.foot import Foot, feet, posed
from footfix.enforce.ground import GroundParams, belt
from footfix.enforce.plants import Plant, PlantParams, Stance
from footfix.motion.clip import Floats
from footfix.motion.contacts import Contact
from footfix.motion.kinematics import forward

FPS, LEG = 60.0, 0.88


def steps(speeds: Floats, hip_speed: float = 0.0) -> tuple[list[Foot], list[Stance]]:
    """Two feet that stand in turn for 0.4 s at these speeds [m/s] over the floor, over hips that go on at another."""
    made = walk()
    rig = rig_of(made)
    length = 24
    frames = length * (len(speeds) + 1)
    at = np.zeros((frames, 3))
    at[:, 0] = hip_speed * np.arange(frames) / FPS
    legs, stands = [], []
    for k, foot in enumerate(feet(rig, posed(made.clip, rig))):
        track = at.copy()
        for n in range(k, len(speeds), 2):
            span = slice(n * length, (n + 1) * length)
            track[span, 0] = at[n * length, 0] + speeds[n] * np.arange(length) / FPS
            contact = Contact(span.start, span.stop, 0.9)
            stands.append(Stance(k, (Plant(k, "heel", contact, span.start, span.stop, np.zeros(3)),)))
        still = np.zeros((frames, 3))
        legs.append(replace(foot, hip=at, knee=at, ankle=track, heel=track, ball=track, turn=np.zeros((frames, 4)),
                            heel_in_foot=still, ball_in_foot=still))  # fmt: skip
    return legs, stands


def test_a_belt_is_the_velocity_that_planted_feet_share_while_the_hips_stay() -> None:
    legs, stands = steps(np.full(20, 1.2))
    assert np.allclose(belt(stands, legs, 1.0 / FPS, LEG, GroundParams()), [1.2, 0.0, 0.0])
    assert not np.any(belt(*steps(np.full(20, 1.2), hip_speed=1.2)[::-1], 1.0 / FPS, LEG, GroundParams()))
    assert not np.any(belt(*steps(np.zeros(20))[::-1], 1.0 / FPS, LEG, GroundParams()))


def test_a_figure_gets_on_a_belt_and_off() -> None:
    speeds = np.zeros(40)
    speeds[10:26] = 1.2 + 0.05 * np.cos(np.arange(16))
    legs, stands = steps(speeds)
    found = belt(stands, legs, 1.0 / FPS, LEG, GroundParams())
    on = np.linalg.norm(found, axis=1) > 0.0
    first, last = np.flatnonzero(on)[[0, -1]] / 24.0
    assert 7.0 <= first <= 10.0 and 26.0 <= last + 1.0 / 24.0 <= 29.0 and np.all(np.diff(np.flatnonzero(on)) == 1)
    assert np.allclose(found[on], [1.2, 0.0, 0.0], atol=0.06)
    few = np.zeros(40)
    few[10:15] = 1.2  # a slide or two are none
    assert not np.any(belt(*steps(few)[::-1], 1.0 / FPS, LEG, GroundParams()))
    assert not np.any(belt(*steps(np.array([0.0, 1.2, 1.2, 1.2, 0.0]))[::-1], 1.0 / FPS, LEG, GroundParams()))
    slow = np.where(speeds > 0.0, 0.3, 0.0)  # a figure that wanders while its hips stay
    assert not np.any(belt(*steps(slow)[::-1], 1.0 / FPS, LEG, GroundParams()))


@pytest.mark.parametrize("given", [False, True])
def test_feet_that_move_up_and_down_in_the_air_do_not_stand(given: bool) -> None:
    """As on the pedals of a bicycle. On a step they are as high, but steady."""
    made = walk("stand")
    rig = rig_of(made)
    frames = len(made.clip)
    up = 0.25 + 0.03 * np.sin(2.0 * np.pi * np.arange(frames) / made.clip.fps)  # [m]
    for heights, stands in ((up, given), (np.full(frames, 0.25), True)):
        positions = made.clip.positions.copy()
        positions[:, 0, 1] += heights
        contacts = made.contacts if given else replace(made.contacts, method="auto")
        clip = replace(made.clip, positions=positions)
        assert np.isclose(forward(clip).position(0)[0, 1] - forward(made.clip).position(0)[0, 1], heights[0])
        _, found = cleaned(clip, rig, contacts)
        gone = [plant for plant in found.plants if plant.outcome == "released"]
        assert len(gone) == (0 if stands else len(found.plants))
        assert all("up and down" in plant.reason for plant in gone)


def test_what_is_let_go_has_a_floor_too() -> None:
    made = walk("stand")
    rig = rig_of(made)
    legs = feet(rig, posed(made.clip, rig))
    contact = Contact(0, len(made.clip), 0.9)
    stance = Stance(0, (Plant(0, "heel", contact, 0, len(made.clip), np.zeros(3), reason="for a test"),))
    floor = rig.floor + 0.01
    assert levelled([stance], legs, floor, rig.leg_length, PlantParams())[0].level == floor

"""What is shown: toes exactly where they stand, joints that do not jump, ground that is learnt."""

from __future__ import annotations

import numpy as np
from streams import figure

from footfix.enforce.ground import GroundParams
from footfix.enforce.leg import LEG, ROOT, TOE
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.motion.kinematics import Pose
from footfix.stream.belt import Belt
from footfix.stream.leg_rotations import Turner
from footfix.stream.legs import Legs, places_of
from footfix.stream.toe_lock import exact


def toes(legs: Legs, x: Floats) -> Floats:
    return places_of(legs, x[:ROOT], x[ROOT:].reshape(-1, LEG, x.shape[1]).swapaxes(0, 1))[:, TOE]


def test_toes_that_stand_are_put_where_they_stand_at_the_height_they_have() -> None:
    part, _, _, legs = figure("walk_skate")
    x, size = np.zeros((ROOT + 2 * LEG, 60)), part.known.rig.leg_length
    before = toes(legs, x)
    place = before + np.array([0.004, 0.5, -0.003])[:, None, None]
    asked = np.zeros((2, 60), dtype=np.bool_)
    asked[0, :20] = True
    found = exact(legs, x, place, asked, (True, False), size, 1.0 / 60.0)
    after = toes(legs, found)
    off = np.hypot(*(after - place)[::2, 0, :20])
    assert off.max() < 1e-4
    assert np.abs(after - before)[1, 0, :20].max() < 5e-4
    assert np.array_equal(found[:ROOT], x[:ROOT])
    assert not found[ROOT + LEG :].any()
    assert np.abs(np.diff(found[ROOT : ROOT + LEG, 19:30], axis=1)).max() < 0.01  # it ends with an ease
    assert not found[:, 30:].any()


def test_a_plant_that_begins_stands_where_its_foot_is_and_one_far_off_is_left() -> None:
    part, _, _, legs = figure("walk_skate")
    x, size = np.zeros((ROOT + 2 * LEG, 60)), part.known.rig.leg_length
    before = toes(legs, x)
    asked = np.zeros((2, 60), dtype=np.bool_)
    asked[0, 10:13] = asked[1, :10] = True
    place = before + 0.1 * size
    place[:, 0] = place[:, 0, :1]
    found = exact(legs, x, place, asked, (False, True), size, 1.0 / 60.0)
    after = toes(legs, found)
    assert np.abs(after - before)[::2, 0, 10].max() < 1e-9
    assert np.hypot(*(after[:, 0, 10:13] - after[:, 0, 10:11])[::2]).max() < 2e-4
    assert np.array_equal(after[:, 1], before[:, 1])


def test_no_joint_as_it_is_written_turns_faster_than_it_may_and_all_else_is_left() -> None:
    part, clip, pose, legs = figure("walk_skate")
    dt, x = clip.frame_time, np.zeros((ROOT + 2 * LEG, 60))
    x[ROOT : ROOT + LEG, 30:] = 0.5  # all of a leg jumps by half a radian, and after a time back
    x[ROOT : ROOT + LEG, 50:] = 0.0
    x[ROOT + LEG :] = 0.01
    turner, free = Turner(part, pose.joints, legs.kinds, dt), Turner(part, pose.joints, legs.kinds, 10.0)
    halves = [  # in two parts, as frames go out
        turner.turn(Pose(pose.joints, pose.positions[some], pose.rotations[some]), legs.frames(some), x[:, some])
        for some in (slice(32), slice(32, None))
    ]
    late = np.concatenate([each.late for each in halves], axis=1)
    assert late[0, 30]
    assert not late[0, :30].any()
    assert not late[0, 45:50].any()  # it has got there
    assert not late[1].any()
    found = np.concatenate([each.rotations for each in halves], axis=2)
    wanted = free.turn(pose, legs, x).rotations
    assert np.array_equal(found[:, ~late], wanted[:, ~late])
    for at, joint in enumerate(legs.kinds.legs[0].chain[:3]):
        steps = [rotation.angle(rotation.multiply(rotation.inverse(q[:-1]), q[1:]))
                 for q in (clip.rotation(joint), found[at, 0])]  # fmt: skip
        more = np.degrees(np.abs(steps[1] - steps[0])) / dt
        assert more.max() <= 235.0 + 1e-6


def walked(belt: Belt, speed: float, first: int, steps: int, dt: float) -> int:
    """Feet that are planted for 30 frames in turn, on ground that moves by `speed` [m/s] under hips that stay."""
    for k in range(steps):
        down = np.zeros((40, 4), dtype=np.bool_)
        down[5:35, 2 * (k % 2) : 2 * (k % 2) + 2] = True
        soles = np.zeros((3, 2, 2, 40))
        soles[2] = speed * dt * np.arange(40)
        belt.follow(soles, np.zeros((3, 40)), down, first)
        first += 40
    return first


def test_a_belt_is_learnt_and_forgotten() -> None:
    dt = 1.0 / 60.0
    belt = Belt(np.zeros(3), dt, 0.9, GroundParams())
    first = walked(belt, 0.0, 0, 10, dt)
    assert not belt.velocity.any()
    first = walked(belt, 1.3, first, 12, dt)
    assert np.allclose(belt.velocity, [0.0, 0.0, 1.3], atol=1e-9)
    first = walked(belt, 1.1, first, 12, dt)
    assert np.allclose(belt.velocity, [0.0, 0.0, 1.1], atol=1e-9)
    walked(belt, 0.0, first, 10, dt)
    assert not belt.velocity.any()


def test_a_foot_that_stands_for_a_second_is_on_no_belt() -> None:
    dt = 1.0 / 60.0
    belt = Belt(np.array([0.0, 0.0, 1.3]), dt, 0.9, GroundParams())
    down = np.zeros((60, 4), dtype=np.bool_)
    down[:, 1] = True
    along, still = np.zeros((3, 2, 2, 60)), np.zeros((3, 2, 2, 60))
    along[2] = 1.3 * dt * np.arange(60)
    belt.follow(along, np.zeros((3, 60)), down, 0)
    belt.follow(along[..., -1:] + np.zeros(60), np.zeros((3, 60)), down & False, 60)
    assert belt.velocity.any()
    belt.follow(still, np.zeros((3, 60)), down, 120)
    assert belt.velocity.any()
    belt.follow(still[..., :2], np.zeros((3, 2)), down[:2], 180)
    assert not belt.velocity.any()

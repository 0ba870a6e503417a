"""Goals of a leg from the targets of its plants."""

from __future__ import annotations

from dataclasses import replace

import artefacts
import numpy as np
import pytest
from walks import rig_of, walk

from footfix.enforce.ease import EaseParams
from footfix.enforce.foot import Foot, feet, posed
from footfix.enforce.judge import dart_of, let_go
from footfix.enforce.plants import Plant, PlantParams, Stance
from footfix.enforce.targets import Goals, calmed, eased, goals, levels
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contact

PARAMS = EaseParams()
FPS = 120.0


def foot_of(clip: Clip) -> Foot:
    rig = rig_of(walk(fps=FPS))
    return feet(rig, posed(clip, rig))[0]


def on_the_ball(foot: Foot, start: int, end: int) -> tuple[Goals, Floats]:
    """A foot that stands on its ball alone, and where that is to stand."""
    target = np.median(foot.ball[start:end], axis=0)
    plant = Plant(1, "toe", Contact(start, end, 1.0), start, end, target)
    stands = [Stance(0, (plant,), level=float(target[1]))]
    none = np.zeros(len(foot))
    return goals(foot, stands, levels(stands, len(foot)), 1.0 / FPS, PARAMS, none), target


def ball(goal: Goals, foot: Foot) -> Floats:
    return goal.ankle(foot) + rotation.rotate(goal.foot_turn(foot), foot.ball_in_foot)


def quickness(track: Floats) -> float:
    return float(np.linalg.norm(np.diff(track, n=3, axis=0), axis=1).mean())


def test_a_foot_that_twitches_on_its_ball_does_not_swing_its_ankle() -> None:
    made = walk(fps=FPS)
    names = made.clip.skeleton.names
    start, end = next((c.start, c.end) for c in made.contacts.effectors[1].contacts if c.start > 5)
    twitch = np.zeros((len(made.clip), 3))
    twitch[start + 10 : end - 10 : 7, 0] = np.radians(1.5)
    ankle = names.index("LeftFoot")
    turned = rotation.multiply(made.clip.turn(ankle), rotation.from_rotation_vector(twitch))
    foot = foot_of(made.clip.with_joints({}, {ankle: turned}))
    goal, target = on_the_ball(foot, start, end)
    calm = calmed(goal, foot, 1.0 / FPS, PARAMS)
    held = slice(start, end)
    assert np.allclose(ball(goal, foot)[held], target, atol=1e-9)
    assert np.allclose(ball(calm, foot)[held], target, atol=1e-9)  # what stands keeps standing
    assert quickness(calm.ankle(foot)[held]) < 0.3 * quickness(goal.ankle(foot)[held])


def test_a_figure_that_shakes_as_a_whole_does_not_shake_its_feet() -> None:
    made = walk(fps=FPS)
    start, end = next((c.start, c.end) for c in made.contacts.effectors[1].contacts if c.start > 5)
    shaken = made.clip.positions.copy()
    shaken[:, 0] += 0.003 * np.random.default_rng(0).normal(size=(len(made.clip), 3))
    foot = foot_of(replace(made.clip, positions=shaken))
    goal, _ = on_the_ball(foot, start, end)
    calm = calmed(goal, foot, 1.0 / FPS, PARAMS)
    turns = [rotation.to_rotation_vector(each.foot_turn(foot))[start:end] for each in (goal, calm)]
    assert quickness(turns[1]) < quickness(turns[0]) + 0.1 * quickness(foot.ball[start:end]) / 0.1


@pytest.mark.parametrize("method", ["smooth", "cubic", "hermite"])
def test_easing_keeps_what_is_planted_and_ends_in_nothing(method: str) -> None:
    made = walk(fps=FPS)
    clip = artefacts.drift(made.clip, 0.05)
    foot = foot_of(clip)
    start, end = next((c.start, c.end) for c in made.contacts.effectors[1].contacts if c.start > 5)
    goal, _ = on_the_ball(foot, start, end)
    params = replace(PARAMS, method=method)  # type: ignore[arg-type]
    done = eased(goal, foot, 1.0 / FPS, params, np.zeros(len(foot)))
    assert np.array_equal(done.shift[start:end], goal.shift[start:end])
    assert not done.shift[~goal.near].any() and not done.turn[~goal.near].any()
    most = 0.03 if method == "hermite" else 0.005  # [m] Kim & Neff's joins take few frames
    assert np.abs(np.diff(done.shift, axis=0)).max() < most


def test_the_end_that_turned_goes_with_its_pivot() -> None:
    target = np.zeros(3)
    plants = tuple(Plant(e, part, Contact(10, 30, 1.0), 10, 30, target) for e, part in enumerate(("heel", "toe")))
    stance = Stance(0, plants, pivots="heel")
    still = [np.zeros((40, 3)), np.zeros((40, 3))]
    hurry = np.zeros(40)
    params = PlantParams()
    kept = let_go(stance, still, np.zeros(40), hurry, np.full(40, 240.0), 0.9, params)
    assert kept is stance
    hurry[20] = 500.0
    gone = let_go(stance, still, np.zeros(40), hurry, np.full(40, 240.0), 0.9, params)
    assert all("jerk" in plant.reason for plant in gone.plants)


def test_a_plant_held_in_part_is_held_there_and_swings_for_the_rest() -> None:
    """Followed softly, the frames before it moved on would draw the foot half way to where it does not stand yet."""
    plant = Plant(1, "toe", Contact(10, 40, 1.0), 10, 40, np.zeros(3))
    points = [np.zeros((50, 3)), np.zeros((50, 3))]
    points[1][10:20, 0] = 0.1  # [m] from its target
    soft, hurry, most = np.where(np.arange(50) < 20, 0.16, 0.0), np.zeros(50), np.full(50, 240.0)
    held = let_go(Stance(0, (plant,)), points, soft, hurry, most, 0.9, PlantParams()).plants[0]
    assert (held.start, held.end, held.reason) == (20, 40, "")
    points[1][10:30, 0] = 0.1
    assert let_go(Stance(0, (plant,)), points, soft, hurry, most, 0.9, PlantParams()).plants[0].reason


def test_a_foot_that_was_held_and_catches_up_darts() -> None:
    t = np.arange(100) / 100.0  # [s]
    captured = np.stack([0.5 * t, 0.0 * t, 0.0 * t], axis=1)  # 0.5 m/s
    held = captured.copy()
    held[20:60] = captured[20]
    held[60:80] = captured[20] + (np.arange(20) / 20.0)[:, None] * (captured[80] - captured[20])
    dart = dart_of(captured, held, 0.01)
    assert np.isclose(dart.max(), 1.5 - 0.5) and dart[:55].max() <= 1e-9 and dart[85:].max() <= 1e-9
    turn = rotation.from_rotation_vector(np.array([0.3, -1.0, 0.5]))
    assert np.allclose(dart_of(rotation.rotate(turn, captured), rotation.rotate(turn, held), 0.01), dart)
    assert not np.any(dart_of(captured, captured, 0.01) > 0.0)


def test_a_plant_that_jerks_the_leg_at_its_end_is_held_before() -> None:
    plant = Plant(1, "toe", Contact(10, 60, 1.0), 10, 60, np.zeros(3))
    still = [np.zeros((80, 3)), np.zeros((80, 3))]
    hurry, most = np.zeros(80), np.full(80, 240.0)
    hurry[56:59] = 500.0

    def judged(beside: int = 0, around: int = 0) -> Plant:
        stance = Stance(0, (plant,))
        return let_go(stance, still, np.zeros(80), hurry, most, 0.9, PlantParams(), beside, around).plants[0]

    assert "jerk" in judged().reason
    held = judged(around=3)
    assert (held.start, held.end, held.reason) == (10, 53, "")
    hurry[:] = 0.0
    hurry[66] = 500.0  # on the way from it
    assert not judged().reason and "jerk" in judged(beside=8).reason
    hurry[20:50:8] = 500.0  # all over it: nothing is left to hold
    assert "jerk" in judged(around=3).reason


def test_no_knee_is_pushed_through_the_floor() -> None:
    plant = Plant(1, "toe", Contact(10, 60, 1.0), 10, 60, np.zeros(3))
    still = [np.zeros((80, 3)), np.zeros((80, 3))]
    sunk = np.zeros(80)
    sunk[30:33] = 0.05  # [m] deeper than captured

    def judged(plant: Plant) -> str:
        stance = Stance(0, (plant,))
        return let_go(
            stance, still, np.zeros(80), np.zeros(80), np.full(80, 240.0), 0.9, PlantParams(), sunk=sunk
        ).plants[0].reason  # fmt: skip

    assert "50 mm deeper into the floor" in judged(plant)
    assert not judged(replace(plant, start=40)) and not judged(replace(plant, given=True))

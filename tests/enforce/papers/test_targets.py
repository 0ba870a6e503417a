"""Where plants of the papers stand, worked out by hand on a figure of two-metre legs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce.footplant import Footplant
from footfix.enforce.papers.rigid_foot import Displacement, _closeness, foot_goal
from footfix.enforce.papers.targets import TargetParams, near_floor, targets, usual_place
from footfix.enforce.two_bone_ik import captured_leg
from footfix.motion import rotation
from footfix.motion.clip import Floats

FRAMES = 40
RIG = replace(rig_of(walk()), leg_length=2.0, floor=0.1)
PARAMS = TargetParams(near=0.05)  # 10 cm
NO_GROUND = np.zeros((FRAMES, 3))


def at(x: float, y: float, z: float) -> Floats:
    return np.tile([x, y, z], (FRAMES, 1))


def plant(k: int, effector: int, start: int = 0, end: int = FRAMES, **more: object) -> Footplant:
    part = "heel" if effector % 2 == 0 else "toe"
    return Footplant(k, effector, RIG.soles[effector].name, effector // 2, part, start, end, **more)  # type: ignore[arg-type]


@pytest.mark.parametrize(("height", "near"), [(0.199, True), (0.201, False), (0.001, True), (-0.001, False)])
def test_near_the_floor_is_within_a_share_of_the_leg(height: float, near: bool) -> None:
    track = at(0.0, height, 0.0)
    track[:5] = 9.0  # while it leaves
    assert near_floor(RIG, [track] * 4, [plant(0, 0)], PARAMS) == [near]


def test_plants_on_the_floor_have_one_height_and_those_on_steps_their_own() -> None:
    track = np.concatenate([at(0, 0.1, 0)[:10], at(1, 0.12, 0)[:10], at(2, 0.13, 0)[:10], at(3, 0.5, 0)[:10]])
    plants = [plant(k, 1, 10 * k, 10 * k + 10) for k in range(4)]
    found = targets(RIG, [track] * 4, [track + [0.0, 0.02, 0.0]] * 4, plants, NO_GROUND, PARAMS)
    assert np.array(found) == pytest.approx(np.array([[0, 0.14, 0], [1, 0.14, 0], [2, 0.14, 0], [3, 0.52, 0]]))


def test_a_place_asked_for_is_of_the_sole_and_of_the_world() -> None:
    ground = np.outer(np.arange(FRAMES), [0.01, 0.0, 0.0])
    sole = at(0.0, 0.12, 0.0) + ground
    joint = sole + [0.0, 0.03, 0.0]
    for height, up in ((0.12, 0.15 - 0.1), (0.6, 0.03)):  # over the floor of the rig, or over a step of its own
        lift = [0.0, height - 0.12, 0.0]
        own = [plant(0, 1, asked=(5.0, 0.2, 6.0))]
        (found,) = targets(RIG, [sole + lift] * 4, [joint + lift] * 4, own, ground, PARAMS)
        assert found == pytest.approx([5.0 - 0.2, 0.2 + up, 6.0])  # 20 frames on, the ground is 20 cm further


def test_heel_and_toe_that_overlap_are_a_foot_apart() -> None:
    heel, toe = at(0.0, 0.1, 0.0), at(0.0, 0.1, 0.25)
    toe[20:] += [0.0, 0.0, 0.1]  # the toe slides away once the heel has left
    tracks = [heel, toe, heel + 1.0, toe + 1.0]
    plants = [plant(0, 0, 0, 20), plant(1, 1, 5, 40)]
    found = targets(RIG, tracks, tracks, plants, NO_GROUND, PARAMS)
    assert np.array(found) == pytest.approx(np.array([[0.0, 0.1, 0.0], [0.0, 0.1, 0.25]]))
    apart = [plants[0], replace(plants[1], start=20)]
    assert targets(RIG, tracks, tracks, apart, NO_GROUND, PARAMS)[1] == pytest.approx([0.0, 0.1, 0.35])
    other = [plants[0], replace(plants[1], effector=3, leg=1)]  # of another foot
    assert targets(RIG, tracks, tracks, other, NO_GROUND, PARAMS)[1] == pytest.approx([1.0, 1.1, 1.34], abs=0.01)


def test_a_foot_apart_is_counted_along_the_slope_where_heights_differ() -> None:
    heel, toe = at(0.0, 0.1, 0.0), at(0.15, 0.5, 0.2)  # 0.25 m over the floor, and 0.4 m up
    tracks = [heel, toe, heel, toe]
    places = targets(RIG, tracks, tracks, [plant(0, 0), plant(1, 1)], NO_GROUND, PARAMS)
    assert places[1] == pytest.approx([0.15, 0.5, 0.2])


def test_the_usual_place_is_the_median_of_the_plane_and_of_the_heights() -> None:
    places = np.array([[0, 1, 0], [0, 2, 0], [0, 9, 0], [0, 2, 0], [100, 3, 100]], dtype=np.float64)
    assert usual_place(places) == pytest.approx([0.0, 2.0, 0.0], abs=0.06)


def test_closeness_falls_from_contacts_with_glardons_ease() -> None:
    planted = np.zeros(40, dtype=bool)
    planted[10:15] = planted[25:30] = True
    found = _closeness(planted, 8)
    away = np.array([min(abs(f - e) for e in (*range(10, 15), *range(25, 30))) for f in range(40)])
    u = np.minimum(away / 8.0, 1.0)
    assert found == pytest.approx(2.0 * u**3 - 3.0 * u**2 + 1.0)
    assert not _closeness(np.zeros(40, dtype=bool), 8).any()


def test_a_foot_goes_with_the_end_that_is_planted_and_turns_with_both() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    pose = rig.pose(made.clip)
    leg = captured_leg(rig, pose, 0, rig.held(pose))
    frames = len(leg)
    none, all_ = np.zeros(frames, dtype=bool), np.ones(frames, dtype=bool)
    still, moved = np.zeros((frames, 3)), np.tile([0.01, 0.0, 0.02], (frames, 1))
    for heel, toe, by in (
        (Displacement(moved, all_), Displacement(still, none), moved),
        (Displacement(still, none), Displacement(2.0 * moved, all_), 2.0 * moved),
    ):
        goal = foot_goal(leg, heel, toe, 10)
        assert goal.ankle == pytest.approx(leg.ankle + by) and goal.turn == pytest.approx(leg.turn)
        assert goal.moves.all()
    turn = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.full(frames, 0.2))
    swung = leg.heel + rotation.rotate(turn, leg.toe - leg.heel) - leg.toe
    goal = foot_goal(leg, Displacement(still, all_), Displacement(swung, all_), 10)
    assert goal.place(leg.in_foot(leg.heel)) == pytest.approx(leg.heel)
    assert goal.place(leg.in_foot(leg.toe)) == pytest.approx(leg.toe + swung)
    rest = foot_goal(leg, Displacement(still, none), Displacement(still, none), 10)
    assert not rest.moves.any() and rest.ankle == pytest.approx(leg.ankle)

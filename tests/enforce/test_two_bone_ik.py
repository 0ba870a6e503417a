"""The two-bone leg of the papers on random legs, whose shanks lie in no plane with their thighs and knee axes."""

from __future__ import annotations

import numpy as np
import pytest

from footfix.enforce.two_bone_ik import CapturedLeg, _knee_axis, flexion_for, two_bones, within_reach
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.motion.vectors import cross, dot, norm, unit
from footfix.rig.rig import Leg

N = 200


def legs(seed: int = 0, flexion: tuple[float, float] = (0.2, 2.0)) -> CapturedLeg:
    """Legs whose knees bend about axes at right angles to the thigh; the shank has a part along the axis, too."""
    rng = np.random.default_rng(seed)
    hip, thigh = rng.normal(size=(N, 3)), 0.4 * unit(rng.normal(size=(N, 3)))
    axis = unit(cross(thigh, rng.normal(size=(N, 3))))
    bend = rng.uniform(*flexion, size=N)
    shank = 0.38 * rotation.rotate(rotation.from_axis_angle(axis, bend), unit(thigh)) + 0.05 * axis
    knee = hip + thigh
    joints = Leg("left", "left", 0, 1, 2, None, (0, 1, 2))
    ankle = knee + shank
    return CapturedLeg(joints, hip, knee, ankle, rotation.identity((N,)), ankle, ankle, axis, bend)


def placed(leg: CapturedLeg, goal: Floats) -> Floats:
    """(N, 3) [m] where the solved leg has its ankle."""
    turns = two_bones(leg, goal)
    bent = rotation.rotate(turns.bend, leg.ankle - leg.knee)
    return np.asarray(leg.hip + rotation.rotate(turns.swing, leg.knee - leg.hip + bent))


@pytest.mark.parametrize("seed", range(3))
def test_goals_in_reach_are_met_and_the_captured_place_needs_nothing(seed: int) -> None:
    leg = legs(seed)
    assert flexion_for(leg, leg.ankle) == pytest.approx(leg.flexion)
    far = np.random.default_rng(seed + 10).uniform(0.35, 0.7, size=N)
    goal = leg.hip + far[:, None] * unit(leg.ankle - leg.hip + 0.2 * np.random.default_rng(seed).normal(size=(N, 3)))
    assert np.abs(placed(leg, goal) - goal).max() < 1e-9


@pytest.mark.parametrize(("bend", "own"), [(0.0, False), (0.4, False), (0.7, True)])  # [degrees]
def test_a_leg_that_hardly_ever_bends_bends_away_from_its_toes(bend: float, own: bool) -> None:
    """From a mean bend of about half a degree on the leg itself says about which axis its knee flexes."""
    thigh = np.tile([0.0, -0.4, 0.0], (N, 1))
    sideways = rotation.from_axis_angle(np.array([0.0, 0.0, 1.0]), np.radians(np.full(N, bend)))
    shank, backwards = rotation.rotate(sideways, thigh), np.tile([0.0, 0.0, -0.2], (N, 1))  # toes are at +z
    axis = _knee_axis(thigh, shank, backwards, rotation.identity((N,)))
    assert axis == pytest.approx(np.tile([0.0, 0.0, 1.0] if own else unit(cross(thigh, backwards))[0], (N, 1)), abs=0.2)


def test_a_knee_bent_far_backwards_stays_so_and_an_overstretched_one_bends_forwards() -> None:
    for flexion, sign in (((-1.5, -0.31), -1.0), ((-0.29, -0.05), 1.0)):
        leg = legs(flexion=flexion)
        assert flexion_for(leg, leg.ankle) == pytest.approx(sign * np.abs(leg.flexion))


def test_what_is_out_of_reach_is_drawn_to_where_the_leg_is_all_but_straight() -> None:
    leg = legs()
    line = unit(leg.ankle - leg.hip)
    straight = np.sqrt((0.4 + 0.38) ** 2 + 0.05**2)  # [m] the leg at no flexion
    goal = leg.hip + 0.9 * line
    found = within_reach(leg, goal)
    assert norm(found - leg.hip) == pytest.approx(np.full(N, 0.9995 * straight))
    assert dot(unit(found - leg.hip), line) == pytest.approx(np.ones(N))
    near = leg.hip + 0.7 * line
    assert np.array_equal(within_reach(leg, near), near)
    longest = legs(flexion=(0.0, 0.005))  # captured straighter than that, and left so
    assert np.array_equal(within_reach(longest, longest.ankle), longest.ankle)

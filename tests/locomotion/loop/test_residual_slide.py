"""A foot that is brought back by a little: a knee that is overstretched stays so, and is not thrown forwards."""

from __future__ import annotations

import numpy as np
import pytest

from footfix.enforce.two_bone_ik import CapturedLeg
from footfix.locomotion.loop.residual_slide import _solved
from footfix.motion import rotation
from footfix.rig.rig import Leg

F = 40


def leg(flexion: float) -> CapturedLeg:
    """A leg that hangs down, its knee bent by so much [rad]."""
    axis, down = np.tile([1.0, 0.0, 0.0], (F, 1)), np.tile([0.0, -0.4, 0.0], (F, 1))
    thigh, shank = (rotation.rotate(rotation.from_axis_angle(axis, side * np.full(F, flexion)), down)
                    for side in (-0.5, 0.5))  # fmt: skip
    joints, foot = Leg("left", "left", 0, 1, 2, None, (0, 1, 2)), thigh + shank
    return CapturedLeg(
        joints, np.zeros((F, 3)), thigh, foot, rotation.identity((F,)), foot, foot, axis, np.full(F, flexion)
    )


@pytest.mark.parametrize(("degrees", "nearer", "sign"), [
    (-5.0, 2e-4, -1.0), (-5.0, 0.03, 1.0), (20.0, 2e-4, 1.0)
])  # fmt: skip
def test_an_overstretched_knee_stays_so_where_its_foot_hardly_moves(degrees: float, nearer: float, sign: float) -> None:
    there = leg(np.radians(degrees))
    moves = (np.arange(F) >= 10) & (np.arange(F) < 30)
    goal = np.where(moves, 1.0 - nearer, 1.0)[:, None] * there.ankle
    turns = _solved(there, goal, moves)
    knee = rotation.rotate(turns.swing, there.knee)
    shank = rotation.rotate(rotation.multiply(turns.swing, turns.bend), there.ankle - there.knee)
    assert np.allclose((knee + shank)[moves], goal[moves], atol=1e-9)
    assert np.all(sign * np.cross(knee, shank)[moves, 0] > 0.0)

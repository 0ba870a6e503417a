"""Legs that lead from a body on a path to its feet."""

from __future__ import annotations

import numpy as np

from footfix.enforce.two_bone_ik import CapturedLeg, flexion_for
from footfix.locomotion.follow.blend_weight import ease
from footfix.locomotion.follow.body_placement import Goal
from footfix.locomotion.follow.legs import astray
from footfix.locomotion.follow.swinging import _led_over, steadying, swung
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.rig.rig import Leg

F = 80
ACROSS, DOWN = np.array([1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])


def leg(flexion: Floats, spin: Floats) -> CapturedLeg:
    """A leg that hangs down, whose knee bends about an axis that is turned about the vertical by `spin` (F,) [rad]."""
    axis = rotation.rotate(rotation.about_vertical(spin), np.broadcast_to(ACROSS, (F, 3)))
    down = np.broadcast_to(0.4 * DOWN, (F, 3))
    thigh, shank = (rotation.rotate(rotation.from_axis_angle(axis, side * flexion), down) for side in (-0.5, 0.5))
    hip, turn = np.zeros((F, 3)), rotation.identity((F,))
    joints = Leg("left", "left", 0, 1, 2, None, (0, 1, 2))
    return CapturedLeg(joints, hip, thigh, thigh + shank, turn, thigh + shank, thigh + shank, axis, flexion)


def planes(captured: CapturedLeg, spin: Floats, bent: float) -> Floats:
    """(F,) [rad] about the vertical, to which the leg's plane is turned when its knee is bent."""
    return spin + steadying(captured, np.full(F, bent), astray(captured, rotation.identity((F,)), 20))


def test_the_plane_of_a_nearly_straight_leg_that_is_bent_now_does_not_spin() -> None:
    spin = np.where(np.arange(F) < 40, 0.0, 1.5)
    straight = leg(np.where(np.abs(np.arange(F) - 40) < 20, 0.03, 0.5), spin)
    assert np.abs(np.diff(planes(straight, spin, 0.6))).max() < 0.3


def test_a_leg_keeps_its_plane_where_it_is_bent_already_or_not_bent_now() -> None:
    spin = 0.3 * np.sin(np.arange(F) / 4.0)
    bent = leg(np.full(F, 0.9), spin)
    assert np.array_equal(planes(bent, spin, 1.4), spin)
    straight = leg(np.full(F, 0.03), spin)
    assert np.array_equal(planes(straight, spin, 0.03), spin)


def stretched(flexion: Floats) -> CapturedLeg:
    """A leg that swings forwards below a hip at rest, its knee bent by `flexion` (F,) [rad]."""
    axis = np.broadcast_to(-ACROSS, (F, 3))
    ahead = np.linspace(-0.3, 0.3, F)
    thigh, shank = (
        rotation.rotate(rotation.from_axis_angle(axis, ahead + side * flexion), np.broadcast_to(0.4 * DOWN, (F, 3)))
        for side in (0.5, -0.5)
    )
    joints, ankle = Leg("left", "left", 0, 1, 2, None, (0, 1, 2)), thigh + shank
    return CapturedLeg(joints, np.zeros((F, 3)), thigh, ankle, rotation.identity((F,)), ankle, ankle, -axis, flexion)


def test_a_knee_that_is_straightened_with_a_jolt_does_not_jolt_its_foot_where_it_is_bent_more() -> None:
    count = np.arange(float(F))
    captured = stretched(np.maximum(0.04 * (50.0 - count), 0.01))  # straight from frame 50 on, at once
    shorter = 1.0 - 0.03 * ease(count / 60.0)  # it comes down with its knee bent by a quarter of a radian
    asked = captured.ankle * shorter[:, None]
    some = slice(20, 70)
    goal = Goal(asked, captured.turn, (some,), np.broadcast_to([0.02, 0.002, 0.002], (F, 3)))
    turns, _ = swung(captured, asked, goal, np.zeros(F))
    bent = rotation.rotate(turns.bend, captured.ankle - captured.knee)
    ankle = rotation.rotate(turns.swing, captured.knee + bent)
    np.testing.assert_allclose(np.delete(ankle, np.r_[some], axis=0), np.delete(asked, np.r_[some], axis=0), atol=1e-9)

    def jolt(track: Floats) -> float:
        return float(np.linalg.norm(np.diff(track, n=2, axis=0), axis=1).max())

    asked_flexion = np.asarray(flexion_for(captured, asked))
    alone = captured.flexion + np.interp(count, [20.0, 69.0], (asked_flexion - captured.flexion)[[20, 69]])
    far = 0.8 * np.cos(0.5 * alone[some])
    by_flexion = far[:, None] * captured.ankle[some] / np.linalg.norm(captured.ankle[some], axis=1)[:, None]
    assert jolt(ankle) < 0.7 * jolt(by_flexion)


def test_a_swing_leads_on_where_its_ends_are_gentle_and_never_far_out() -> None:
    count = np.arange(200.0)
    gentle = np.stack([1e-5 * count**2 - 1e-7 * count**3, 2e-3 * count], axis=1)
    some = slice(60, 140)
    np.testing.assert_allclose(_led_over(gentle, some)[:, 1], gentle[some, 1], atol=1e-12)
    np.testing.assert_allclose(_led_over(gentle, some)[:, 0], gentle[some, 0], atol=1e-3)
    steep = np.zeros((200, 1))
    steep[:61, 0] = 0.08 * (count[:61] - 59.0)  # at rest at frame 59, and gone on with at once, half a turn and more
    led = _led_over(steep, some)
    assert np.abs(led).max() < 0.4
    np.testing.assert_allclose(np.diff(led[:2, 0]), 0.08, rtol=0.3)

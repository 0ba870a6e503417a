"""Legs that lead from a body on a path to its feet."""

from __future__ import annotations

import numpy as np

from footfix.enforce.papers.leg import CapturedLeg
from footfix.locomotion.follow.legs import astray
from footfix.locomotion.follow.swinging import _led_over, steadying
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

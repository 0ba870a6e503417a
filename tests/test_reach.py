"""How far legs stretch, and what gives way."""

from __future__ import annotations

import artefacts
import numpy as np
from walks import cleaned, extension, rig_of, straightness, walk

from footfix.enforce import reach
from footfix.enforce.foot import feet, posed
from footfix.enforce.reach import ReachParams
from footfix.enforce.run import EnforceParams
from footfix.motion import rotation
from footfix.motion.vectors import norm


def test_what_is_captured_is_allowed_and_no_more_than_the_source_reaches() -> None:
    made = walk()
    rig = rig_of(made)
    foot = feet(rig, posed(made.clip, rig))[0]
    params = ReachParams()
    captured = norm(foot.ankle - foot.hip)
    assert np.allclose(reach.allowed(foot, foot.hip, foot.ankle, params), captured)
    length = norm(foot.knee - foot.hip) + norm(foot.ankle - foot.knee)
    for farther in (0.01, 0.05, 0.3):
        away = foot.ankle + farther * (foot.ankle - foot.hip)
        limit = reach.allowed(foot, foot.hip, away, params)
        assert np.all(limit <= length * max(float((captured / length).max()), 0.0) + 1e-9)
        assert np.all(limit >= captured - 1e-9)
        spare, kept = 1.0 - captured / length, 1.0 - limit / length
        assert np.all(kept >= params.planted**2 * spare - 1e-9)
        # law of cosines, thigh and shank as they are: half of the reserve's root is half of a small bend
        thigh, shank = norm(foot.knee - foot.hip), norm(foot.ankle - foot.knee)
        was, now = (
            np.pi - np.arccos(np.clip((thigh**2 + shank**2 - d**2) / (2.0 * thigh * shank), -1.0, 1.0))
            for d in (captured, limit)
        )
        assert np.all(now >= 0.97 * params.planted * was)
    nearer = foot.hip + 0.8 * (foot.ankle - foot.hip)
    assert np.allclose(reach.allowed(foot, foot.hip, nearer, params), 0.8 * captured)


def test_the_limit_comes_on_softly() -> None:
    made = walk()
    rig = rig_of(made)
    foot = feet(rig, posed(made.clip, rig))[0]
    frame = int(np.argmin(norm(foot.ankle - foot.hip)))  # bent: there is room
    ways = np.linspace(0.0, 0.2, 400)
    limits = [
        reach.allowed(foot, foot.hip, foot.ankle + way * (foot.ankle - foot.hip), ReachParams())[frame] for way in ways
    ]
    slope = np.diff(limits) / np.diff(ways * norm(foot.ankle - foot.hip)[frame])
    assert np.all(slope > 0.0) and np.all(np.diff(slope) < 1e-6) and 0.9 < slope[0] <= 1.0 + 1e-6


def test_the_root_comes_down_as_far_as_needed_and_smoothly() -> None:
    frames, dt = 200, 1 / 100
    hip, ankle = np.tile([0.0, 0.85, 0.0], (frames, 1)), np.zeros((frames, 3))
    limit = np.full(frames, 0.85)
    limit[90:110] = 0.83
    held = np.ones(frames, dtype=bool)
    lower = reach.lowering([hip], [ankle], [limit], [held], dt, 0.88, ReachParams(root_ease=0.15))
    assert np.all(0.85 - lower[90:110] <= 0.83 + 1e-12)
    assert lower[0] == lower[-1] == 0.0
    assert np.abs(np.diff(lower, 2)).max() / dt**2 < 3.0
    assert lower.max() < 0.021


def test_a_knee_that_comes_to_its_bound_and_goes_again_does_so_without_a_cusp() -> None:
    frames, dt = 240, 1 / 120
    t = np.arange(frames) * dt  # [s]
    hip, ankle = np.tile([0.0, 0.8796, 0.0], (frames, 1)), np.zeros((frames, 3))
    ankle[:, 1] = 0.002 * np.cos(2.0 * np.pi * t) - 0.002  # wanted up to 4 mm lower
    limit = np.full(frames, 0.8796)  # of a leg of 0.88 m: nearly straight
    held = np.ones(frames, dtype=bool)

    def kink(margin: float) -> float:
        lower = reach.lowering([hip], [ankle], [limit], [held], dt, 0.88, ReachParams(margin=margin))
        distance = hip[:, 1] - lower - ankle[:, 1]
        assert np.all(distance <= limit + 1e-12)
        assert lower.max() <= 0.004 + margin * 0.88 + 1e-12
        bend = 2.0 * np.arccos(distance / 0.88)  # thigh and shank alike
        return float(np.abs(np.diff(bend, 2)).max() / dt**2)

    assert kink(0.001) < 0.6 * kink(0.0)


def test_where_the_roots_help_would_not_do_it_stays() -> None:
    frames = 50
    hip, ankle = np.tile([0.0, 0.85, 0.0], (frames, 1)), np.zeros((frames, 3))
    held = np.ones(frames, dtype=bool)
    lower = reach.lowering([hip], [ankle], [np.full(frames, 0.7)], [held], 0.01, 0.88, ReachParams())
    assert not lower.any()


def test_a_foot_rolls_on_its_ball_until_the_leg_reaches() -> None:
    hip, ankle, ball = np.array([[0.0, 0.9, 0.35]]), np.array([[0.0, 0.09, 0.0]]), np.array([[0.0, 0.0, 0.13]])
    limit = norm(ankle - hip) - 0.008
    turn = reach.rolled(hip, ankle, ball, limit, np.array([True]), np.radians(30.0))
    lifted = ball + rotation.rotate(turn, ankle - ball)
    assert np.isclose(norm(lifted - hip), limit, atol=1e-9)
    assert lifted[0, 1] > ankle[0, 1]  # the heel comes up, not down
    none = reach.rolled(hip, ankle, ball, limit, np.array([False]), np.radians(30.0))
    assert np.isclose(none[0, 3], 1.0)
    least = reach.rolled(hip, ankle, ball, limit - 0.5, np.array([True]), np.radians(12.0))
    assert rotation.angle(least)[0] <= np.radians(12.0) + 1e-9


def test_a_figure_too_high_for_its_legs_is_said() -> None:
    """A root that jumps up by 8 cm, quicker than it may be brought down: what the legs can't reach is reported."""
    made = walk("stand")
    rig = rig_of(made)
    positions = made.clip.positions.copy()
    t = np.arange(len(made.clip)) * made.clip.frame_time
    positions[:, 0, 1] += 0.08 * np.sin(2 * np.pi * t / 0.4) ** 2
    clip = type(made.clip)(made.clip.skeleton, positions, made.clip.rotations, made.clip.frame_time)
    after, found = cleaned(clip, rig, made.contacts, EnforceParams())
    partly = [plant for plant in found.plants if plant.outcome == "partly"]
    assert partly and all(plant.residual > 0.002 and "reach" in plant.reason for plant in partly)
    assert extension(after, rig) <= 0.9995


def test_longer_legs_stay_within_reach() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.scale_root(made.clip, 1.1, height=False)
    after, _ = cleaned(clip, rig, made.contacts)
    before, now = straightness(clip, rig), straightness(after, rig)
    mask = made.contacts.mask()
    for k in range(2):  # a held leg is never straighter than the source's straightest,
        held = mask[:, 2 * k] | mask[:, 2 * k + 1]
        assert now[held, k].max() <= before[:, k].max() + 1e-6
    # and one that swings by little: its knee keeps most of its least bend
    bend = 2.0 * np.arccos(before.max()), 2.0 * np.arccos(now.max())
    assert bend[1] >= ReachParams.swing * bend[0] - 1e-3

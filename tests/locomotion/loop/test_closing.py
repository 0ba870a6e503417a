"""Closing: the ends meet with one velocity, each moved by half, and what lies between stays as it was."""

from __future__ import annotations

import numpy as np
import pytest
from walks import rig_of, walk

from footfix.errors import InputError
from footfix.locomotion.loop.closing import Closed, close, decay
from footfix.locomotion.loop.cut_search import Cut
from footfix.locomotion.loop.cyclic_enforcement import lay
from footfix.locomotion.loop.params import LoopParams
from footfix.motion import rotation
from footfix.motion.clip import Clip, Skeleton
from footfix.motion.kinematics import places
from footfix.rig.rig import Rig

CUT = Cut(60, 125, 0, 1, 0, 0.02, stands=((52, 80), (117, 145)))
TIMES = np.linspace(0.0, 1.0, 1001)


def closed(method: str = "offset", blend: float = 0.3) -> Closed:
    made = walk()
    return close(made.clip, rig_of(made), CUT, LoopParams(method=method, blend=blend))  # type: ignore[arg-type]


def test_a_gap_decays_from_its_value_and_slope_to_rest() -> None:
    fade = decay(1001, 0.001, 0.3, 0.2)
    gap, speed = np.array([2.0, 0.0, 0.0]), np.array([0.0, 3.0, 0.0])
    ahead, behind = fade.ahead(gap, speed), fade.behind(gap, speed)
    slope = np.gradient(ahead, TIMES, axis=0)
    assert np.allclose(ahead[0], [1.0, 0.0, 0.0])
    assert np.allclose(slope[0], [0.0, 1.5, 0.0], atol=0.05)
    assert np.allclose(ahead[300:], 0.0, atol=1e-12)
    assert np.allclose(behind[:-301], 0.0, atol=1e-12)
    assert np.allclose(ahead[0] - behind[-1], gap)  # both shares are the whole gap
    assert np.allclose(slope[0] - np.gradient(behind, TIMES, axis=0)[-1], speed, atol=0.05)


@pytest.mark.parametrize("method", ["offset", "kim-neff"])
def test_the_last_frame_is_the_first_moved_on(method: str) -> None:
    found = closed(method)
    place = places(found.clip)
    assert np.allclose(place[-1], found.travel.places(place[0]), atol=1e-9)
    assert np.array_equal(found.clip.rotations[-1, 1:], found.clip.rotations[0, 1:])
    assert len(found.clip) == CUT.end - CUT.start + 1


@pytest.mark.parametrize("method", ["offset", "kim-neff"])
def test_frames_away_from_the_seam_are_the_very_numbers_of_the_clip(method: str) -> None:
    found = closed(method, blend=0.2)
    middle = slice(20, len(found.clip) - 20)
    captured = walk().clip.frames(slice(found.start, found.start + len(found.clip)))
    assert np.array_equal(found.clip.rotations[middle, 1:], captured.rotations[middle, 1:])
    assert np.allclose(found.clip.positions[middle], captured.positions[middle], atol=1e-12)


def test_over_the_seam_it_goes_on_as_fast_as_it_went_and_each_end_is_moved_by_half_the_gap() -> None:
    found, made = closed(), walk()
    place, captured = places(found.clip), places(made.clip)[CUT.start : CUT.end + 1]
    on = found.travel.places(place[1]) - place[-1]  # [m] the first step of the next round
    sharp = np.linalg.norm(on - (place[-1] - place[-2]), axis=1)
    usual = np.linalg.norm(np.diff(place, n=2, axis=0), axis=2).max(axis=0)
    assert np.all(sharp <= 1.05 * usual)  # the swinging leg's own acceleration, no more
    gap = np.linalg.norm(captured[-1] - found.travel.places(captured[0]), axis=1).max()
    change = np.linalg.norm(place - captured, axis=2)
    assert change[[0, -1]].max() == pytest.approx(0.5 * gap, rel=0.1)
    assert change.max() < 0.65 * gap


def test_what_is_closed_stays_as_it_is_when_it_is_closed_again() -> None:
    once, length = closed(), len(closed().clip) - 1
    three = lay(once.clip, 0, once.travel, range(-1, 2))
    again = close(three, rig_of(walk()), Cut(length, 2 * length, 0, 1, 0, 0.0), LoopParams())
    assert np.allclose(again.clip.positions, once.clip.positions, atol=1e-9)
    assert rotation.angle(rotation.multiply(again.clip.rotations, rotation.inverse(once.clip.rotations))).max() < 1e-7
    assert (again.travel.yaw, again.travel.x) == pytest.approx((once.travel.yaw, once.travel.x), abs=1e-9)


def test_the_papers_blend_starts_in_mid_window_and_needs_frames_of_both_plants() -> None:
    assert closed("kim-neff").start == 60 + 18 // 2  # 19 frames are left of the first plant after its frame 60
    short = Cut(60, 125, 0, 1, 0, 0.02, stands=((52, 63), (117, 128)))
    with pytest.raises(InputError, match="too few to blend"):
        close(walk().clip, rig_of(walk()), short, LoopParams(method="kim-neff"))


def test_velocities_join_over_a_wide_gap_of_turns() -> None:
    skeleton, fps = Skeleton(("root", "arm"), np.array([-1, 0]), np.zeros((2, 3))), 240.0
    time = np.arange(481) / fps
    # an arm that swings about one axis while it has turned about another: half a gap turns its velocity by half
    swing = np.stack([0.4 * np.sin(3.0 * time), 0.5 * time, 0.8 * time**2], axis=1)
    turns = np.stack([np.tile([0.0, 0.0, 0.0, 1.0], (481, 1)), rotation.from_rotation_vector(swing)], axis=1)
    clip = Clip(skeleton, np.zeros((481, 2, 3)), turns, 1.0 / fps)
    found = close(clip, Rig(0, 0, (), (), 1.0, 0.0), Cut(120, 360, -1, 1, 0, 0.0), LoopParams()).clip.rotation(1)
    twice = np.concatenate([found, found[1:]])
    speed = fps * rotation.to_rotation_vector(rotation.multiply(twice[1:], rotation.inverse(twice[:-1])))
    sharp = fps * np.linalg.norm(np.diff(speed, axis=0), axis=1)
    seam = len(found) - 2
    assert sharp[seam] <= sharp[:seam].max()

"""Feet that stand: how far they turn, however one looks at it, and what is taken out of that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import SHARED
from strides import stances
from walks import rig_of, walk

from footfix.enforce.params import EnforceParams
from footfix.formats.floor_paths import shape
from footfix.jobs.follow import walk_of
from footfix.jobs.source import read
from footfix.locomotion.follow.footsteps import find_steps
from footfix.locomotion.follow.params import FollowParams
from footfix.locomotion.follow.plant_cleanup import stands
from footfix.locomotion.follow.planted_feet import fair, rolled, unturned, yaws
from footfix.locomotion.follow.prepared_walk import Walk
from footfix.locomotion.follow.run import Follow, follow_path
from footfix.locomotion.follow.transitions import At
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.settings import Settings

AHEAD = np.array([0.0, -0.06, 0.13])  # [m] from the ankle to the toe of a foot that points along z


def foot(yaw: Floats, pitch: Floats) -> tuple[Floats, Floats]:
    """A foot that is turned about the vertical after it was pitched about the axis across it."""
    turn = rotation.multiply(rotation.about_vertical(yaw), rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), pitch))
    return turn, rotation.rotate(turn, AHEAD)


def test_a_mixed_foot_rolls_over_its_heel_until_its_toe_comes_down() -> None:
    count = np.arange(60)
    heels, toes = (count >= 20) & (count < 40), (count >= 30) & (count < 50)
    heel = np.outer(0.01 * np.clip((count - 20.0) / 10.0, 0.0, 1.0), [0.0, 0.0, 1.0])  # it slides on by 10 mm
    mixed = np.ones(60, dtype=np.bool_)
    shift = rolled(heel, heels, toes, mixed, 1.0 / 60.0)
    held = (heel + shift)[21:40]
    assert np.abs(held - held[-1]).max() < 1e-12
    assert not np.any(shift[30:])
    assert np.abs(np.diff(shift[:31, 2])).max() < 0.002
    assert not np.any(rolled(heel, heels, toes, ~mixed, 1.0 / 60.0))


def test_all_readings_of_a_flat_foot_are_its_yaw() -> None:
    yaw = np.radians(np.linspace(0.0, 20.0, 11))
    readings = yaws(*foot(yaw, np.zeros(11)), np.arange(11))
    assert np.allclose(readings, yaw - yaw[5], atol=1e-9)


def test_a_foot_that_rolls_over_its_toes_does_not_turn() -> None:
    pitch = np.radians(np.linspace(0.0, 50.0, 11))
    assert np.allclose(yaws(*foot(np.zeros(11), pitch), np.arange(11)), 0.0, atol=1e-9)


def test_no_reading_grows_by_what_is_taken_out_and_all_of_them_vanish_where_they_are_one() -> None:
    readings = np.radians(np.random.default_rng(3).normal(0.0, 8.0, (3, 400)))
    left = readings + fair(readings)
    assert np.all(np.abs(left) <= np.maximum(np.abs(readings), np.radians(1.0)) + 1e-12)
    assert np.allclose(np.tile(readings[0], (3, 1)) + fair(np.tile(readings[0], (3, 1))), 0.0)
    assert np.abs(left).max(axis=0).sum() < np.abs(readings).max(axis=0).sum()


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_a_flat_foot_that_turns_stands_on_curves_and_is_left_alone_on_straight_paths(share: float) -> None:
    F, down = 90, np.zeros(90, dtype=np.bool_)
    down[30:60] = True
    turn, ahead = foot(np.radians(0.2 * np.arange(F)), np.zeros(F))
    heel = -1.5 * ahead
    yaw, shift = unturned(turn, -ahead, heel, down, find_steps(down, 1 / 60), np.full(F, share), 1 / 60)
    whole = rotation.yaw(rotation.multiply(rotation.about_vertical(yaw), turn))[30:60]
    assert np.degrees(np.ptp(whole)) <= (0.5 if share else 6.0)
    assert np.allclose(shift, 0.0)
    assert np.any(yaw) == bool(share)
    assert np.allclose(yaw[[0, -1]], 0.0)  # as it was captured, long before and after


def test_a_contact_too_short_to_slide_does_not_count() -> None:
    made = walk()
    rig = rig_of(made)
    none = rig.no_contacts(made.clip)
    mask = none.mask()
    mask[0, 1] = True
    assert stands(made.clip, rig, none.with_mask(mask, mask.astype(np.float64)))
    mask[:40, 1] = True
    assert not stands(made.clip, rig, none.with_mask(mask, mask.astype(np.float64)))


def turned(found: Follow) -> Floats:
    """(5,) [degrees] the farthest that a foot turns from its median while its toe stands, by each reading."""
    most = np.zeros(5)
    for pose, leg, some in stances(found):
        ahead = pose.position(leg.toe) - pose.position(leg.ankle)
        read = yaws(pose.rotation(leg.ankle)[some], ahead[some], np.arange(some.stop - some.start))
        most = np.maximum(most, np.abs(read - np.median(read, axis=1)[:, None]).max(axis=1))
    return np.degrees(most)


@pytest.mark.parametrize("name", ["pybvh/cmu_12_01_walk.bvh", "dme/comp_3d_2_raw.bvh"])
def test_a_captured_foot_turns_no_more_on_a_circle_than_straight_on(name: str) -> None:
    path = SHARED / "clips" / name
    if not path.is_file():
        pytest.skip(f"no clips: {path} is absent")
    settings = Settings()
    found = walk_of(read(path.read_bytes(), name, settings).clip, name, settings)
    params = replace(settings.follow, seconds=5.0)
    straight, bent = (_along(way, found, params) for way in ("line:8", "circle:2"))
    assert np.all(turned(bent) <= turned(straight) + 1.0)


def _along(path: str, found: Walk, params: FollowParams) -> Follow:
    drawn = shape(path)
    assert drawn is not None
    return follow_path(drawn.points, [found], [At()], params, EnforceParams(), relative=True)

"""Cycles: what is learnt from clips, and what a model of it says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cycle_walkers import SPEEDS, files, fitted
from exports import without_toes
from walks import short_walk as walk

from footfix.errors import InputError
from footfix.formats.cycle_models import decode_model, encode_model
from footfix.jobs.fit_cycles import fit_entry, fit_files
from footfix.locomotion.cycles.eigencycles import Ramp, kernel
from footfix.locomotion.cycles.leg_pose import Legs
from footfix.locomotion.cycles.model import warped
from footfix.locomotion.cycles.samples import Sample, shift_phases
from footfix.motion import rotation
from footfix.rig.find import find_rig


def test_speed_and_gait_of_made_walkers_are_found() -> None:
    speeds = [(gait, speed) for gait, own in SPEEDS.items() for speed in own]
    for file, (gait, speed) in zip(files(), speeds, strict=True):
        assert len(file.samples) >= 3
        found = np.array([each.speed for each in file.samples]) * np.sqrt(9.81 * file.rig.leg_length)
        assert {each.gait for each in file.samples} == {gait}
        assert np.abs(found / speed - 1.0).max() < 0.03


def test_a_file_left_out_is_told_better_than_by_its_nearest_neighbour() -> None:
    error = fitted().error
    assert error.predicted <= 0.8 * error.nearest
    assert error.frequency <= 0.04


def test_a_cycle_closes_with_its_slopes() -> None:
    values = np.random.default_rng(0).normal(size=(32, 3))
    near = kernel(np.array([-1e-4, 0.0, 1e-4, 1.0 - 1e-4, 1.0, 1.0 + 1e-4]), 32) @ values
    assert np.allclose(near[:3], near[3:], atol=1e-9)
    assert np.allclose(near[1], values[0], atol=1e-12)


def test_values_between_samples_are_those_of_the_harmonics() -> None:
    at, phases = np.arange(32) / 32, np.linspace(0.0, 1.0, 17)

    def wave(p: np.ndarray) -> np.ndarray:
        return 0.3 + np.sin(2 * np.pi * p) + 0.2 * np.cos(2 * np.pi * 7 * p)

    assert np.allclose(kernel(phases, 32) @ wave(at), wave(phases), atol=1e-12)
    assert np.allclose(shift_phases(wave(at)[:, None], 0.13)[:, 0], wave(at + 0.13), atol=1e-12)


def test_the_map_is_straight_outside_of_the_range_seen() -> None:
    ramp = Ramp(0.3, 0.7, 2)
    for outside in (np.array([0.7, 0.8, 0.9]), np.array([0.3, 0.2, 0.1])):
        first, second, third = ramp(outside)
        assert np.allclose(third - second, second - first)
    before, at, after = ramp(0.7 + 1e-6 * np.array([-1.0, 0.0, 1.0]))
    assert np.allclose(after - at, at - before, atol=1e-9)


def test_phases_are_led_to_where_the_foot_is_as_far() -> None:
    here, there = np.array([0.1, 0.6]), np.array([0.05, 0.35])
    assert warped(np.array(0.1), here, there) == pytest.approx(0.05)
    assert warped(np.array(0.7), here, there) == pytest.approx(0.4)
    grid = warped(np.linspace(0.1, 1.0999, 200), here, there)
    assert np.all(np.diff(grid) > 0.0)
    same = np.linspace(0.0, 0.99, 50)
    assert np.allclose(np.mod(warped(same, here, here) - same + 0.5, 1.0), 0.5, atol=1e-12)


def test_legs_of_a_model_without_toe_joints_end_in_what_plants_hold() -> None:
    clip = without_toes(walk().clip)
    rig = find_rig(clip)
    legs, pose = Legs(clip.skeleton, rig), rig.pose(clip)
    turns = rotation.to_matrix(np.stack([clip.rotation(joint) for joint in legs.joints], axis=1))
    made = legs.poses(clip.position(rig.root), rotation.to_matrix(clip.rotation(rig.root)), turns)
    held = np.stack(rig.held(pose), axis=1).reshape(len(clip), 2, 2, 3)
    assert np.allclose(made.heel, held[:, :, 0], atol=1e-9)
    assert np.allclose(made.toe, held[:, :, 1], atol=1e-9)


def test_a_model_comes_back_from_its_file_and_holds_no_pickle() -> None:
    model = fitted().model
    places = [(0.0, 0.01 * k, 0.1) if sole.part == "toe" else None for k, sole in enumerate(model.rig.soles)]
    soles = tuple(replace(sole, held=place) for sole, place in zip(model.rig.soles, places, strict=True))
    model = replace(model, rig=replace(model.rig, soles=soles))
    data = encode_model(model)
    again = decode_model(data, name="m.npz")
    assert again.skeleton.names == model.skeleton.names
    assert again.origins == model.origins
    assert (again.rig.legs, again.rig.soles) == (model.rig.legs, model.rig.soles)
    for one, other in zip(model.spaces, again.spaces, strict=True):
        assert np.array_equal(one.cycle(0.5), other.cycle(0.5))
    assert encode_model(again) == data


@pytest.mark.parametrize("data", [b"", b"PK\x03\x04", b"HIERARCHY\n"])
def test_what_is_no_model_is_refused_in_words(data: bytes) -> None:
    with pytest.raises(InputError, match=r"m\.npz: this is no model of cycles"):
        decode_model(data, name="m.npz")


def test_a_damaged_model_is_refused_in_words() -> None:
    model = fitted().model
    broken = replace(model, levels=np.full_like(model.levels, np.nan))
    with pytest.raises(InputError, match="levels holds NaN or infinity"):
        decode_model(encode_model(broken), name="m.npz")


def test_too_few_cycles_are_refused_with_what_was_found() -> None:
    with pytest.raises(InputError, match=r"walk: \d+ cycles of 1 speed.*run: 0 cycles.*20 cycles"):
        fit_files(files()[:1])


def test_one_speed_is_too_few() -> None:
    file = files()[1]
    many = replace(file, samples=file.samples * 8)
    with pytest.raises(InputError, match="of 1 speed,"):
        fit_files([many])


def test_another_skeleton_is_left_aside() -> None:
    skeleton = replace(files()[0].skeleton, names=tuple("abcdefghijklmnopqrstu"))
    odd = replace(files()[0], name="odd.bvh", skeleton=skeleton)
    found = fit_files([*files(), odd])
    assert "another skeleton" in found.skipped["odd.bvh"]
    assert found.model.skeleton.names == files()[0].skeleton.names


def test_what_is_told_names_the_files() -> None:
    told = fit_entry(fitted())
    assert len(told["files"]) == len(files())
    assert {each["gait"] for each in told["gaits"]} == {"walk", "run"}


def test_half_a_style_is_half_way_between() -> None:
    walks = [each for each in files() if each.name.startswith("walk")]
    low, quick = np.array([0.0, -0.05, 0.0]), 1.2  # [leg lengths], times as often

    def styled(sample: Sample) -> Sample:
        places, frequency = sample.places + low, quick * sample.frequency
        return replace(sample, places=places, frequency=frequency, source="low " + sample.source, style="low")

    others = [replace(each, name="low " + each.name, samples=tuple(map(styled, each.samples))) for each in walks]
    (space,) = fit_files([*walks, *others]).model.spaces
    weights = np.array([[0.0], [0.5], [1.0]])
    height = np.array([space.cycle(0.4, each)[:, 1].mean() for each in weights])
    assert height[1] == pytest.approx(0.5 * (height[0] + height[2]), abs=1e-12)
    assert height[2] - height[0] == pytest.approx(low[1], rel=0.08)  # few files are drawn to the plain style
    told = space.frequencies(np.full(3, 0.4), weights)
    assert told[1] ** 2 == pytest.approx(told[0] * told[2])
    assert told[2] / told[0] == pytest.approx(quick, rel=0.01)


def test_a_person_known_from_other_files_has_their_own_frequency() -> None:
    rng = np.random.default_rng(1)
    walks = [each for each in files() if each.name.startswith("walk")]
    pace = np.exp(rng.normal(0.0, 0.07, 6))  # people differ in how often they step at one speed
    people = [
        replace(
            each, name=f"{person} {each.name}",
            samples=tuple(
                replace(s, frequency=own * s.frequency, source=f"{person} {each.name}", style=str(person))
                for s in each.samples
            ),
        )
        for person, own in enumerate(pace)
        for each in walks[1:3]
    ]  # fmt: skip
    nameless = [replace(each, samples=tuple(replace(s, style="") for s in each.samples)) for each in people]
    assert fit_files(people).error.frequency <= 0.02 < fit_files(nameless).error.frequency

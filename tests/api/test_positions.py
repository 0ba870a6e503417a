"""Joint positions in the world: fitted, cleaned, given back."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from conftest import SAMPLES, need, shared

import footfix
from footfix.motion.clip import Floats
from footfix.motion.from_positions import fit_rotations
from footfix.motion.kinematics import places


@cache
def sample() -> footfix.Clip:
    return footfix.load(SAMPLES / "walk_skate.bvh").clip


@cache
def captured() -> Floats:
    return footfix.global_positions(sample())


@cache
def cleaned() -> footfix.CleanedPositions:
    skeleton = sample().skeleton
    return footfix.clean_positions(
        captured(), skeleton.parents, sample().frame_time, names=skeleton.names  # type: ignore[arg-type]
    )


def bones(positions: Floats, parents: Floats) -> Floats:
    """(F, J - roots) [m] the length of every bone in every frame."""
    below = np.flatnonzero(parents >= 0)
    return np.linalg.norm(positions[:, below] - positions[:, parents[below]], axis=-1)  # type: ignore[index]


def noisy(positions: Floats, metres: float) -> Floats:
    return positions + np.random.default_rng(1).normal(0.0, metres, positions.shape)


def test_forward_kinematics_of_the_fit_gives_the_positions_back() -> None:
    given = noisy(captured(), 0.002)
    clip = fit_rotations(given, sample().skeleton.parents.tolist(), 1 / 60)
    assert np.allclose(places(clip), given, atol=1e-12)
    assert np.allclose(np.linalg.norm(clip.rotations, axis=-1), 1.0, atol=1e-12)


def test_a_turn_of_the_whole_figure_turns_the_root_alone() -> None:
    turn = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    parents, rest = sample().skeleton.parents.tolist(), captured()[0]
    one = fit_rotations(captured(), parents, 1 / 60, rest=rest)
    other = fit_rotations(captured() @ turn.T, parents, 1 / 60, rest=rest)
    likeness = np.abs(np.einsum("fji,fji->fj", one.rotations, other.rotations))
    assert np.all(likeness[:, 1:] > 1.0 - 1e-9)
    assert np.allclose(2.0 * np.arccos(np.clip(likeness[0, 0], 0.0, 1.0)), np.pi / 2.0, atol=1e-6)


def test_fitted_rotations_do_not_spin() -> None:
    clip = fit_rotations(captured(), sample().skeleton.parents.tolist(), 1 / 60)
    step = np.abs(np.einsum("fji,fji->fj", clip.rotations[1:], clip.rotations[:-1]))
    assert np.degrees(2.0 * np.arccos(np.clip(step, 0.0, 1.0))).max() < 20.0


def test_positions_cleaned_are_those_of_the_clip_cleaned() -> None:
    whole = footfix.clean(sample())
    there = footfix.global_positions(whole.clip)
    # positions have no tips of toes, so that feet stand up to a centimetre elsewhere
    assert np.abs(cleaned().positions - there).max() < 0.012
    assert cleaned().result.before.slide_mm == pytest.approx(whole.before.slide_mm, abs=0.5)
    assert cleaned().result.after.slide_mm < 1.0
    assert cleaned().contacts.shape == (len(sample()), 4)


def test_bones_stay_as_long_as_they_were_in_each_frame() -> None:
    parents = sample().skeleton.parents
    given = noisy(captured(), 0.002)
    back = footfix.clean_positions(given, parents, 1 / 60).positions  # type: ignore[arg-type]
    assert np.allclose(bones(back, parents), bones(given, parents), atol=1e-9)  # type: ignore[arg-type]
    assert not np.array_equal(back, given)


def test_unit_and_up_axis_are_given_back_as_they_came() -> None:
    parents, names = sample().skeleton.parents.tolist(), sample().skeleton.names
    z_up = 100.0 * captured()[..., [0, 2, 1]] * [1.0, -1.0, 1.0]  # x, -z, y in centimetres
    back = footfix.clean_positions(z_up, parents, sample().frame_time, names=names, unit_m=0.01, up="z").positions
    assert np.allclose(0.01 * back[..., [0, 2, 1]] * [1.0, 1.0, -1.0], cleaned().positions, atol=1e-4)


def test_what_needs_nothing_comes_back_to_the_digit() -> None:
    given = captured().astype(np.float32)
    nothing = np.zeros((len(given), 4), dtype=bool)
    back = footfix.clean_positions(
        given, sample().skeleton.parents, sample().frame_time, contacts=nothing  # type: ignore[arg-type]
    )
    assert back.positions.dtype == np.float32
    assert np.array_equal(back.positions, given)


def test_positions_that_are_none_are_refused() -> None:
    parents = sample().skeleton.parents.tolist()
    for given, says in (
        (captured()[:, :5], "5 joints need 5 parents"),
        (captured()[..., :2], r"must be \(F, J, 3\)"),
        (np.where(np.arange(len(captured()))[:, None, None] == 4, np.nan, captured()), "NaN or infinite in frame 4"),
        (100.0 * captured(), "centimetres"),
    ):
        with pytest.raises(footfix.ArgumentError, match=says):
            footfix.clean_positions(given, parents, 1 / 60)
    lying = captured()[..., [0, 2, 1]] * [1.0, -1.0, 1.0]
    with pytest.raises(footfix.ArgumentError, match='up="z"'):
        footfix.clean_positions(lying, parents, 1 / 60)
    with pytest.raises(footfix.ArgumentError, match="rate"):
        footfix.clean_positions(captured(), parents, 60)


def test_the_published_skeleton_is_a_tree_of_its_names() -> None:
    tree = dict(zip(footfix.HUMANML3D_NAMES, footfix.HUMANML3D_PARENTS, strict=True))
    assert footfix.HUMANML3D_NAMES[tree["left_foot"]] == "left_ankle"
    assert footfix.HUMANML3D_NAMES[tree["right_wrist"]] == "right_elbow"
    for name, parent in tree.items():
        side = name.partition("_")[0]
        assert parent < 0 or side not in ("left", "right") or "_" not in footfix.HUMANML3D_NAMES[parent] or (
            footfix.HUMANML3D_NAMES[parent].startswith(side)
        )


@pytest.mark.clips
@pytest.mark.parametrize("folder", ["t2m", "lafan_karstm"])
def test_captured_clips_are_held_as_positions(folder: str) -> None:
    path = need(shared(f"clips/{folder}"), f"clips/{folder}")[0]
    clip = footfix.load(path).clip.frames(slice(0, 250))
    whole = footfix.clean(clip)
    given = footfix.global_positions(clip)
    found = footfix.clean_positions(given, clip.skeleton.parents.tolist(), clip.frame_time, names=clip.skeleton.names)
    assert np.allclose(
        bones(found.positions, clip.skeleton.parents), bones(given, clip.skeleton.parents), atol=1e-9  # type: ignore[arg-type]
    )
    assert found.result.after.slide_median_mm <= max(2.0, whole.after.slide_median_mm + 5.0)

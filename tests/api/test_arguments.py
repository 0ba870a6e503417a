"""Wrong input is refused in words that say what was given and what is wanted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from conftest import SAMPLES
from walks import walk

import footfix
from footfix.motion.clip import Clip


@cache
def clip() -> Clip:
    return walk(duration=2.0).clip


@cache
def rig() -> footfix.Rig:
    return footfix.find_rig(clip())


@cache
def contacts() -> footfix.Contacts:
    return footfix.detect(clip(), rig())


def scaled(by: float) -> Clip:
    skeleton = clip().skeleton
    larger = replace(skeleton, offsets=by * skeleton.offsets, end_offsets=by * skeleton.end_offsets)
    return Clip(larger, by * clip().positions, clip().rotations, clip().frame_time)


def broken(name: str, value: float) -> Clip:
    array = np.array(getattr(clip(), name))
    array[7, 3, 0] = value
    return replace(clip(), **{name: array})


def cut() -> footfix.Contacts:
    return footfix.detect(clip().frames(slice(0, 60)), rig())


def swapped() -> footfix.Contacts:
    return replace(contacts(), effectors=contacts().effectors[::-1])


def reversed_contact() -> footfix.Contacts:
    first, *others = contacts().effectors
    return replace(contacts(), effectors=(replace(first, contacts=(footfix.Contact(9, 5),)), *others))


WRONG: dict[str, tuple[Callable[[], Any], str]] = {
    "centimetres": (lambda: footfix.clean(scaled(100.0)), r"a leg of \d+ m: .* centimetres, multiply .* by 0\.01"),
    "millimetres": (lambda: footfix.find_rig(scaled(1000.0)), r"millimetres, multiply .* by 0\.001"),
    "a rate": (lambda: footfix.clean(replace(clip(), frame_time=60)), r"60 looks like a rate: give 1/60"),
    "milliseconds": (lambda: footfix.clean(replace(clip(), frame_time=16.7)), r"frame_time .* seconds"),
    "no frame time": (lambda: replace(clip(), frame_time=float("nan")), r"frame_time must be positive"),
    "NaN": (lambda: footfix.clean(broken("positions", np.nan)), r"position of .* NaN or infinite in frame 7"),
    "infinite": (lambda: footfix.detect(broken("rotations", np.inf), rig()), r"rotation of .* in frame 7"),
    "no unit": (lambda: footfix.clean(broken("rotations", 2.0)), r"unit quaternions xyzw; that of .* in frame 7"),
    "a short mask": (
        lambda: rig().no_contacts(clip()).with_mask(np.ones((5, 4), bool)), r"121 frames.* left_heel.*\(5, 4\)",
    ),
    "likelihoods": (lambda: rig().no_contacts(clip()).with_mask(np.full((len(clip()), 4), 0.7)), r"mask > 0\.5"),
    "a mask": (lambda: footfix.clean(clip(), contacts=contacts().mask()), r"no_contacts\(clip\)\.with_mask\(mask\)"),
    "another clip": (lambda: footfix.clean(clip(), contacts=cut()), r"contacts of 60 frames, and a clip of 121"),
    "another rate": (
        lambda: footfix.measure(clip(), rig(), replace(contacts(), frame_time=1 / 30)), r"at 30 fps, and a clip at 60",
    ),
    "other effectors": (lambda: footfix.clean(clip(), contacts=swapped()), r"right_toe, .*the rig has left_heel"),
    "backwards": (lambda: footfix.clean(clip(), contacts=reversed_contact()), r"left_heel: contact \[9, 5\)"),
    "a document": (lambda: footfix.clean(footfix.load(SAMPLES / "walk_skate.bvh")), r"give document\.clip"),  # type: ignore[arg-type]
    "positions": (lambda: footfix.clean(np.zeros((9, 22, 3))), r"clean_positions"),  # type: ignore[arg-type]
    "a path": (lambda: footfix.detect("walk.bvh"), r"footfix\.load\('walk\.bvh'\)\.clip"),  # type: ignore[arg-type]
    "a mapping": (lambda: footfix.clean(clip(), {"detect": {}}), r"make_settings"),  # type: ignore[arg-type]
    "another rig": (lambda: footfix.clean(small(), rig=rig()), r"of another skeleton"),
    "too short": (lambda: footfix.clean(clip().frames(slice(0, 2)), rig=rig()), r"2 frames is too short"),
    "parents": (lambda: footfix.Skeleton(("a", "b"), [1, -1], np.zeros((2, 3))), r"each before its children"),  # type: ignore[arg-type]
    "a setting": (lambda: footfix.make_settings(values={"detect.methd": "auto"}), r"did you mean 'method'"),
    "a preset": (lambda: footfix.make_settings("mocab"), r"did you mean 'mocap'"),
}  # fmt: skip


def small() -> Clip:
    skeleton = footfix.Skeleton(("root",), np.array([-1]), np.zeros((1, 3)))
    return Clip(skeleton, np.zeros((9, 1, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (9, 1, 1)), 1 / 60)


@pytest.mark.parametrize("what", WRONG)
def test_wrong_input_is_refused_in_words(what: str) -> None:
    call, says = WRONG[what]
    with pytest.raises(footfix.FootfixError, match=says):
        call()


def test_wrong_arguments_are_value_errors_too() -> None:
    with pytest.raises(ValueError, match="frame_time"):
        footfix.clean(replace(clip(), frame_time=60))


def test_what_is_right_is_taken() -> None:
    half = replace(clip(), rotations=clip().rotations.astype(np.float16).astype(np.float64))
    assert footfix.detect(half).names == contacts().names
    as_numbers = rig().no_contacts(clip()).with_mask(contacts().mask().astype(int))  # type: ignore[arg-type]
    assert np.array_equal(as_numbers.mask(), contacts().mask())

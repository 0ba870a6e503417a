"""What the writer says a file holds is what reading it again finds, to the last bit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from bvhmaker import files, plain
from conftest import SAMPLES, need, one_of_each_origin, shared
from damage import says_what_is_read
from hypothesis import given, settings
from hypothesis import strategies as st

from footfix.errors import InputError
from footfix.formats.bvh import decode, rewrite
from footfix.motion import rotation
from footfix.motion.clip import Clip


def changed(clip: Clip, rng: np.random.Generator, size: float, share: float = 0.5) -> Clip:
    """Some joints of a clip moved and turned in some of its frames."""
    frames, joints = len(clip), len(clip.skeleton)
    where = rng.random((frames, joints)) < share * (rng.random(joints) < 0.5)
    turn = rotation.from_rotation_vector(rng.normal(0.0, size, (frames, joints, 3)))
    turned = np.where(where[..., None], rotation.multiply(clip.rotations, turn), clip.rotations)
    moved = clip.positions + where[..., None] * rng.normal(0.0, size, (frames, joints, 3))
    return replace(clip, positions=moved, rotations=turned)


@pytest.mark.parametrize("folder", ["samples", "clips", "odd"])
def test_real_files(folder: str) -> None:
    every = {"samples": sorted(SAMPLES.glob("*.bvh")), "clips": one_of_each_origin(1.5e5), "odd": shared("odd")}[folder]
    paths = every if folder == "samples" else every[::2]
    rng = np.random.default_rng(1)
    for path in (path for path in need(paths, folder) if path.stat().st_size < 150_000):
        try:
            document = decode(path.read_bytes())
        except InputError:
            continue
        up = str(rng.choice(["y", "-y", "z", "-z", "x", "-x"]))
        document = document.placed(unit_m=float(rng.choice([1.0, 0.01, 0.0254])), up=up)
        if len(document.values) and not document.unusable:
            says_what_is_read(document, changed(document.clip, rng, float(rng.choice([1e-9, 1e-6, 0.1, 3.0]))))


@settings(max_examples=12, deadline=None)
@given(files(), st.integers(0, 2**32), st.sampled_from([1e-7, 0.1, 1e3]), st.sampled_from([1.0, 0.01, 1 / 17.7]),
       st.sampled_from(["y", "z", "-x"]))  # fmt: skip
def test_any_file(made: tuple[Any, ...], seed: int, size: float, unit: float, up: str) -> None:
    document = decode(made[3]).placed(unit_m=unit, up=up)
    says_what_is_read(document, changed(document.clip, np.random.default_rng(seed), size))


def test_channels_that_were_zero_and_are_not() -> None:
    """They were counted from the OFFSET; read again, they take its place."""
    channels = ("CHANNELS 3 Z", "CHANNELS 6 Xposition Yposition Zposition Z")
    zeros = [(f" {a} ", f" 0 0 0 {a} ") for a in ("-4.50", "-4.40", "-4.30", "-4.20")]
    document = decode(plain(channels, *zeros))
    assert document.base.any()
    positions = document.clip.positions.copy()
    positions[2, 1, 0] += 1.0
    says_what_is_read(document, replace(document.clip, positions=positions))


def test_nothing_changed() -> None:
    document = decode(plain())
    assert rewrite(document, replace(document.clip)) == (plain(), document.clip)


def test_numbers_written_as_zero_have_no_sign() -> None:
    document = decode(plain())
    positions = document.clip.positions.copy()
    positions[:, 0] = -1e-9
    _, said = rewrite(document, replace(document.clip, positions=positions))
    says_what_is_read(document, replace(document.clip, positions=positions))
    assert not np.signbit(said.positions[1:, 0]).any()

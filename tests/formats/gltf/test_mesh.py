"""Skins out of glTF files: one figure, however its parts are bound."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SHARED
from skinmaker import file_of, skin_of
from walks import walk

from footfix.errors import InputError
from footfix.formats.gltf.mesh import read_skin
from footfix.rig.skin import feet_of, legs_of


@pytest.mark.parametrize("bound", ["skin", "shoes", "rigid"])
@pytest.mark.parametrize("normals", [True, False])
def test_a_skin_is_read_as_it_was_made(bound: str, normals: bool) -> None:
    clip = walk().clip
    made, found = skin_of(clip), read_skin(file_of(clip, bound=bound, normals=normals), name="made.glb")
    if bound != "rigid":  # nodes rest in mid-step; a mesh below one is bound as that stands to the joints
        assert found.vertices == pytest.approx(made.vertices, abs=1e-5)
    assert found.normals == pytest.approx(made.normals, abs=1e-5)
    for one, other in zip(feet_of(made, legs_of(made)), feet_of(found, legs_of(found)), strict=True):
        for name in ("heel", "ball", "tip", "up", "ahead"):
            assert getattr(other, name) == pytest.approx(getattr(one, name), abs=1e-5), name


def test_weights_are_shares_whatever_they_add_up_to() -> None:
    clip = walk().clip
    assert read_skin(file_of(clip, weights=1.755)).weights.sum(axis=1) == pytest.approx(1.0)


def test_a_file_without_a_mesh_is_refused_in_words() -> None:
    with pytest.raises(InputError, match="shows no mesh"):
        read_skin(b'{"asset": {"version": "2.0"}, "nodes": [{}]}', name="empty.gltf")


def test_damaged_files_are_refused_in_words() -> None:
    data, random = file_of(walk().clip, bound="shoes"), np.random.default_rng(5)
    for _ in range(60):
        spoiled = bytearray(data[: int(random.integers(20, len(data) + 1))] if random.random() < 0.5 else data)
        for at in random.integers(0, len(spoiled), 8):
            spoiled[at] = int(random.integers(256))
        try:
            skin = read_skin(bytes(spoiled), name="spoiled.glb")
            feet_of(skin, legs_of(skin))
        except InputError as error:
            assert str(error)


def test_a_real_character_stands_on_its_soles() -> None:
    path = SHARED / "glb" / "human-male.glb"
    if not path.is_file():
        pytest.skip(f"no character: {path} is absent")
    skin = read_skin(path.read_bytes(), name=path.name)
    left, right = feet_of(skin, legs_of(skin))
    for foot in (left, right):
        ankle = skin.places[foot.leg.ankle]
        assert min(point @ foot.up for point in (foot.heel, foot.ball)) - foot.level < 0.002
        assert 0.16 < (foot.tip - foot.heel) @ foot.ahead < 0.30
        assert (foot.heel - ankle) @ foot.ahead < 0.0 < (foot.ball - ankle) @ foot.ahead
    assert left.heel * [-1, 1, 1] == pytest.approx(right.heel, abs=1e-3)

"""`--skin` and `find_rig(skin=...)`: the mesh of a character in place of soles that are estimated."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import artefacts
import pytest
from skinmaker import file_of
from walks import walk

import footfix
from footfix.formats.bvh import compose

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    """A walk that skates, and its character."""
    made = walk("walk", 30.0, 2.0).clip
    clip, skin = tmp_path / "walk.bvh", tmp_path / "figure.glb"
    clip.write_bytes(compose(artefacts.drift(made, 0.05)))
    skin.write_bytes(file_of(made, bound="shoes"))
    return clip, skin


def test_clean_takes_the_soles_from_the_skin(run: Run, files: tuple[Path, Path], tmp_path: Path) -> None:
    clip, skin = files
    assert run("clean", clip, "--skin", skin, "-o", tmp_path / "out", "-q")[0] == 0
    report = json.loads((tmp_path / "out" / "walk.report.json").read_text())
    assert report["settings"]["rig"]["skin"] == str(skin)
    assert report["after"]["penetration_mm"] < 3.0 and report["after"]["slide_mm"] < report["before"]["slide_mm"]
    assert [note["id"] for note in report["notes"] if note["id"].startswith("skin")] == ["skin-soles"]
    page = (tmp_path / "out" / "walk.report.html").read_text()
    meshes = json.loads(re.search(r'"meshes": ?(\[.*?\]\}\])', page)[1])  # type: ignore[index]
    assert len(meshes) == 4 and all(len(part["outline"]) >= 4 for part in meshes)
    plain = tmp_path / "plain"
    assert run("clean", clip, "-o", plain, "-q")[0] == 0
    assert len(page) < 1.1 * len((plain / "walk.report.html").read_text())


def test_the_setting_is_the_option(run: Run, files: tuple[Path, Path], tmp_path: Path) -> None:
    clip, skin = files
    for folder, how in (("a", ("--skin", skin)), ("b", ("--set", f"rig.skin={skin}"))):
        assert run("clean", clip, *how, "-o", tmp_path / folder, "--report", "json", "-q")[0] == 0
    assert (tmp_path / "a" / "walk.report.json").read_bytes() == (tmp_path / "b" / "walk.report.json").read_bytes()


def test_pages_are_drawn_anew_with_the_skin(run: Run, files: tuple[Path, Path], tmp_path: Path) -> None:
    clip, skin = files
    out = tmp_path / "out"
    assert run("clean", clip, "--skin", skin, "-o", out, "-q")[0] == 0
    page = (out / "walk.report.html").read_bytes()
    assert run("report", out / "walk.report.json", "--source", clip, "--force")[0] == 0
    assert (out / "walk.report.html").read_bytes().count(b'"outline"') == page.count(b'"outline"') > 0


def test_detect_and_check_take_it_too(run: Run, files: tuple[Path, Path], tmp_path: Path) -> None:
    clip, skin = files
    code, out, _ = run("detect", clip, "--skin", skin, "--method", "lyard", "--json")
    assert code == 0 and json.loads(out)
    plain, mesh = (json.loads(run("check", clip, *how, "--format", "json")[1]) for how in ((), ("--skin", skin)))
    assert plain != mesh


def test_a_skin_that_is_none_is_said_in_words(run: Run, files: tuple[Path, Path], tmp_path: Path) -> None:
    clip, _ = files
    code, _, said = run("clean", clip, "--skin", clip, "-o", tmp_path / "out", "-q")
    assert code == 3 and "walk.bvh" in said and "JSON" in said
    assert not list((tmp_path / "out").glob("*"))


def test_python_takes_the_same_soles(files: tuple[Path, Path]) -> None:
    clip, skin = files
    motion = footfix.load(clip).clip
    rig = footfix.find_rig(motion, skin=skin)
    settings = footfix.make_settings(None, {"rig.skin": str(skin)})
    assert rig.meshes and rig.soles == footfix.find_rig(motion, settings).soles
    assert rig.soles != footfix.find_rig(motion).soles
    assert footfix.clean(motion, settings).after.penetration_mm < 3.0


@pytest.fixture(scope="module")
def character(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A figure with boxes for feet, and its walk that skates, in one file."""
    made = walk("walk", 30.0, 2.0).clip
    path = tmp_path_factory.mktemp("character") / "figure.glb"
    path.write_bytes(file_of(made, bound="shoes", animation=artefacts.drift(made, 0.05)))
    return path


def test_a_gltf_clip_takes_its_own_mesh_as_if_it_were_named(run: Run, character: Path, tmp_path: Path) -> None:
    for folder, how in (("own", ()), ("named", ("--skin", character)), ("none", ("--skin", "none"))):
        assert run("clean", character, *how, "-o", tmp_path / folder, "--report", "json", "-q")[0] == 0
    for name in ("figure.glb", "figure.contacts.json"):
        own, named, none = ((tmp_path / folder / name).read_bytes() for folder in ("own", "named", "none"))
        assert own == named != none, name
    own, named = (json.loads((tmp_path / f / "figure.report.json").read_text()) for f in ("own", "named"))
    assert own["settings"]["rig"].pop("skin") is None and named["settings"]["rig"].pop("skin")
    assert own.pop("fingerprint") != named.pop("fingerprint")  # of the settings
    assert own == named and own["after"]["penetration_mm"] < 3.0


def test_every_command_takes_the_mesh_of_a_gltf_clip(run: Run, character: Path) -> None:
    for command in (("detect", "--json"), ("check", "--format", "json"), ("inspect", "--json")):
        own, named, none = (
            run(command[0], character, *command[1:], *how)[1]
            for how in ((), ("--set", f"rig.skin={character}"), ("--set", "rig.skin=none"))
        )
        assert own == named != none, command


def test_a_mesh_that_is_none_of_the_feet_is_no_error(run: Run, tmp_path: Path) -> None:
    made = walk("walk", 30.0, 2.0).clip
    path = tmp_path / "figure.glb"
    path.write_bytes(file_of(made, animation=artefacts.drift(made, 0.05), feet=False))
    outputs = []
    for folder, how in (("own", ()), ("none", ("--set", "rig.skin=none"))):
        code, _, said = run("clean", path, *how, "-o", tmp_path / folder, "--report", "json")
        assert code == 0 and "skin" not in said
        outputs.append((tmp_path / folder / "figure.glb").read_bytes())
    assert outputs[0] == outputs[1] != path.read_bytes()
    code, _, said = run("clean", path, "--skin", path, "-o", tmp_path / "named", "--report", "json")
    assert code == 0 and "is not used" in said


def test_pages_of_a_gltf_clip_are_drawn_anew_with_its_mesh(run: Run, character: Path, tmp_path: Path) -> None:
    assert run("clean", character, "-o", tmp_path, "-q")[0] == 0
    page = (tmp_path / "figure.report.html").read_bytes()
    assert run("report", tmp_path / "figure.report.json", "--source", character, "--force")[0] == 0
    assert (tmp_path / "figure.report.html").read_bytes().count(b'"outline"') == page.count(b'"outline"') > 0


def test_python_has_the_mesh_of_a_gltf_clip_at_hand(character: Path) -> None:
    document = footfix.load(character)
    rig = footfix.find_rig(document.clip, skin=document.skin)
    assert rig.meshes and rig.soles == footfix.find_rig(document.clip, skin=character).soles
    assert not footfix.find_rig(document.clip, skin="none").meshes

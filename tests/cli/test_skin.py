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

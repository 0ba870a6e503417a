"""A clip that footfix wrote is known by the report beside it, and stays as it is."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import artefacts
import exports
import pytest
from click.testing import CliRunner
from walker import make
from walker_plan import Gait

from footfix.cli import cli


def run(*words: object) -> None:
    done = CliRunner().invoke(cli, [*map(str, words)], standalone_mode=False)
    assert done.exception is None, done.exception


def report(path: Path) -> dict[str, object]:
    found: dict[str, object] = json.loads(path.with_suffix(".report.json").read_text())
    return found


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The outputs of a walk that slides as much as no holding takes out."""
    clip = artefacts.shake(artefacts.wander(make(Gait(duration=2.5, fps=40.0)).clip, 0.2, slowest=0.5), 1.0)
    folder = tmp_path_factory.mktemp("cleanings")
    (folder / "walk.bvh").write_bytes(exports.bvh(clip))
    run("clean", folder / "walk.bvh", "-o", folder / "once", "--report", "json")
    return folder / "once"


@pytest.fixture
def once(written: Path, tmp_path: Path) -> Path:
    """The cleaned walk, beside its report."""
    shutil.copytree(written, tmp_path / "once")
    return tmp_path / "once" / "walk.bvh"


def test_a_clip_that_footfix_wrote_is_the_same_file(once: Path, tmp_path: Path) -> None:
    run("clean", once, "-o", tmp_path / "twice", "--report", "json")
    twice = tmp_path / "twice" / "walk.bvh"
    assert twice.read_bytes() == once.read_bytes()
    found = report(twice)
    assert found["status"] == "unchanged"
    assert "cleaned-already" in {note["id"] for note in found["notes"]}  # type: ignore[attr-defined]
    spans = [[(p["effector"], p["start"], p["end"]) for p in report(each)["plants"]] for each in (once, twice)]  # type: ignore[attr-defined]
    assert spans[0] == spans[1]  # by the contacts of the cleaning
    run("clean", twice, "-o", tmp_path / "thrice", "--report", "json")
    assert (tmp_path / "thrice" / "walk.bvh").read_bytes() == once.read_bytes()


@pytest.mark.parametrize("why", ["another byte", "other settings", "anew", "no report"])
def test_any_other_clip_is_cleaned(once: Path, tmp_path: Path, why: str) -> None:
    options = {"other settings": ["--set", "enforce.strength=0.5"], "anew": ["--anew"]}.get(why, [])
    if why == "another byte":
        once.write_bytes(once.read_bytes() + b"\n")
    if why == "no report":
        once.with_suffix(".report.json").unlink()
    run("clean", once, "-o", tmp_path / "twice", "--report", "json", *options)
    found = report(tmp_path / "twice" / "walk.bvh")
    assert "cleaned-already" not in {note["id"] for note in found["notes"]}  # type: ignore[attr-defined]

"""Everything footfix writes for programs keeps to its schema, and the schemas say something."""

from __future__ import annotations

import dataclasses
import json
from importlib import resources
from pathlib import Path
from typing import Any

import artefacts
import exports
import jsonschema
import pytest
from conftest import SAMPLES, Run
from walker import make
from walker_plan import Gait

from footfix.measure.clip import Measures

FOLDER = resources.files("footfix.report") / "schemas"
NAMES = ("contacts", "report", "summary", "check", "inspect", "run", "events", "cycles-fit")


def schema(name: str) -> Any:
    return json.loads((FOLDER / f"{name}.v1.json").read_text("utf-8"))


def holds(name: str, document: Any) -> None:
    jsonschema.Draft202012Validator(schema(name)).validate(document)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    walk = make(Gait(name="walk", duration=1.6, fps=30)).clip
    still = dataclasses.replace(walk.frames(slice(0, 2)))
    (tmp_path / "in").mkdir()
    for name, clip in (("walk", artefacts.wander(walk, 0.05)), ("short", still)):
        (tmp_path / "in" / f"{name}.bvh").write_bytes(exports.bvh(clip))
    (tmp_path / "in" / "broken.bvh").write_bytes(b"HIERARCHY\n")
    return tmp_path


@pytest.mark.parametrize("name", NAMES)
def test_schemas_are_schemas(name: str) -> None:
    jsonschema.Draft202012Validator.check_schema(schema(name))
    with pytest.raises(jsonschema.ValidationError):
        holds(name, {"format": "footfix-nothing", "version": 1})


def test_what_clean_writes(folder: Path, run: Run) -> None:
    document = json.loads(run("clean", folder / "in", "-o", folder / "out", "-j1", "--json")[1])
    holds("run", document)
    for stem in ("walk", "short"):
        holds("contacts", json.loads((folder / "out" / f"{stem}.contacts.json").read_text("utf-8")))
        holds("report", json.loads((folder / "out" / f"{stem}.report.json").read_text("utf-8")))
    summary = json.loads((folder / "out" / "summary.json").read_text("utf-8"))
    holds("summary", summary)
    report = json.loads((folder / "out" / "walk.report.json").read_text("utf-8"))
    assert set(report["before"]) == {each.name for each in dataclasses.fields(Measures)}
    assert set(report["before"]) == set(schema("report")["$defs"]["measures"]["properties"])
    del report["status"]
    with pytest.raises(jsonschema.ValidationError):
        holds("report", report)
    del summary["files"][0]["error"]  # of the broken clip
    with pytest.raises(jsonschema.ValidationError):
        holds("summary", summary)


def test_what_check_detect_and_inspect_print(folder: Path, run: Run) -> None:
    holds("check", json.loads(run("check", folder / "in", "--max", "slide_mm=1", "--json", "-j1")[1]))
    holds("contacts", json.loads(run("detect", folder / "in" / "walk.bvh", "--json")[1]))
    holds("inspect", json.loads(run("inspect", folder / "in" / "walk.bvh", "--json")[1]))
    holds("run", json.loads(run("inspect", folder / "in", "--json", "-j1")[1]))


def test_the_samples_known_contacts() -> None:
    for path in sorted((SAMPLES / "truth").glob("*.json")):
        holds("contacts", json.loads(path.read_text("utf-8")))

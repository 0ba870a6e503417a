"""`footfix check`: what is shown, what holds by default, and plants that cleaning let go."""

from __future__ import annotations

import csv
import io
import json
import xml.etree.ElementTree
from pathlib import Path

import artefacts
import exports
import pytest
from conftest import Run
from walker import make
from walker_plan import Gait

from footfix.batch import gates


@pytest.fixture(scope="module")
def walk() -> bytes:
    return exports.bvh(artefacts.wander(make(Gait(name="walk", duration=2.0, fps=60)).clip, 0.05))


@pytest.fixture
def folder(tmp_path: Path, walk: bytes, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("a.bvh").write_bytes(walk)
    return tmp_path


def test_without_gates_the_default_ones_hold_and_are_shown(run: Run, folder: Path) -> None:
    code, out, _ = run("check", "a.bvh")
    assert code == 1
    assert all(name in out.splitlines()[0] and f"max {gate.most:g}" in out for name, gate in gates.DEFAULTS.items())
    assert run("clean", "a.bvh", "-o", "out")[0] == 0
    code, out, _ = run("check", "out/a.bvh")
    assert code == 0 and out.splitlines()[2].startswith("passed")
    (folder / "footfix.yaml").write_text("gates: {slide_mm: 1000}\n")
    code, out, _ = run("check", "a.bvh")
    assert code == 0 and "skating_ratio" not in out


def test_what_is_quiet_shows_only_what_is_over(run: Run, folder: Path) -> None:
    assert run("check", "a.bvh", "--max", "slide_mm=1000", "-q")[1] == ""
    lines = run("check", "a.bvh", "--max", "slide_mm=1", "-q")[1].splitlines()
    assert len(lines) == 1 and lines[0].startswith("over    a.bvh: slide_mm is ")


def test_formats_say_the_same(run: Run, folder: Path) -> None:
    measures = json.loads(run("check", "a.bvh", "--format", "json")[1])["files"][0]["measures"]
    assert json.loads(run("check", "a.bvh", "--json")[1])["files"][0]["measures"] == measures
    row = next(csv.DictReader(io.StringIO(run("check", "a.bvh", "--format", "csv")[1])))
    assert (row["source"], row["status"], row["over"]) == ("a.bvh", "over", "share_over_21mm")
    assert {name: float(row[name]) if row[name] else None for name in measures} == measures


def test_the_list_has_every_measure_and_measures_nothing(run: Run, folder: Path) -> None:
    code, out, _ = run("check", "--list")
    assert code == 0
    assert [line.split()[0] for line in out.split("\n\n")[0].splitlines()] == list(gates.NAMES)


def test_plants_that_were_let_go_are_counted_apart(run: Run, folder: Path) -> None:
    assert run("clean", "a.bvh", "-o", "out", "--report", "json")[0] == 0
    path = folder / "out" / "a.report.json"
    report = json.loads(path.read_text("utf-8"))
    (folder / "out" / "a.bvh").write_bytes(Path("a.bvh").read_bytes())  # as if none of its plants had been held
    worst = max(report["plants"], key=lambda plant: plant["slide_before_mm"])
    worst["outcome"], worst["reason"] = "released", "the knee would turn too fast"
    path.write_text(json.dumps(report))
    code, out, _ = run("check", "out/a.bvh", "--max", "slide_mm=21", "--max", "held_slide_mm=21", "--json")
    found = json.loads(out)["files"][0]
    slides = sorted(plant["slide_before_mm"] for plant in report["plants"])
    assert code == 1 and found["measures"]["let_go"] == 1
    assert found["measures"]["slide_mm"] == pytest.approx(slides[-1], abs=0.1)
    assert found["measures"]["held_slide_mm"] == pytest.approx(slides[-2], abs=0.1)
    why = {each["measure"]: each["why"] for each in found["over"]}
    assert "1 of them let go" in why["slide_mm"] and why["slide_mm"].endswith("let go: the knee would turn too fast")
    assert worst["effector"] in why["slide_mm"] and "let go" not in why["held_slide_mm"]


def test_junit_has_times_and_reports_have_none(run: Run, folder: Path) -> None:
    assert run("check", "a.bvh", "--junit", "feet.xml")[0] == 1
    root = xml.etree.ElementTree.parse(folder / "feet.xml").getroot()
    case, suite = root.find(".//testcase"), root.find("testsuite")
    assert case is not None and suite is not None
    assert 0.001 < float(case.attrib["time"]) < 60 and suite.attrib["time"] == case.attrib["time"]
    first, second = (run("clean", "a.bvh", "-o", name, "--json")[1] for name in ("one", "two"))
    assert first.replace("one", "two") == second

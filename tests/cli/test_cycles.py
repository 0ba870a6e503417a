"""`footfix cycles`: files in, files out."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from cycle_walkers import fitted, walker

import footfix


@pytest.fixture
def model(tmp_path: Path) -> Path:
    footfix.save_model(tmp_path / "walker.npz", fitted().model)
    return tmp_path / "walker.npz"


def schema(name: str) -> dict[str, object]:
    file = resources.files("footfix.report") / "schemas" / f"{name}.v1.json"
    found: dict[str, object] = json.loads(file.read_text("utf-8"))
    return found


@pytest.mark.usefixtures("forking")
def test_a_bad_file_does_not_stop_the_fit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr("footfix.jobs.fit_cycles.FEWEST", 5)  # how many are enough is told in tests/locomotion/cycles
    (tmp_path / "gaits").mkdir()
    for speed in (1.5, 1.8):
        (tmp_path / "gaits" / f"walk_{speed}.bvh").write_bytes(walker("walk", speed, 3.2, 1))
    (tmp_path / "gaits" / "bad.bvh").write_bytes(b"\0nothing")
    code, out, err = run("cycles", "fit", tmp_path / "gaits", "-o", tmp_path / "m.npz", "--json", "-j2")
    assert code == 3
    assert "bad.bvh" in err
    document = json.loads(out)
    jsonschema.Draft202012Validator(schema("cycles-fit")).validate(document)
    assert [each["gait"] for each in document["gaits"]] == ["walk"]
    assert document["file_left_out"]["error_mm"] > 0.0
    assert footfix.load_model(tmp_path / "m.npz").gaits == ("walk",)
    assert run("cycles", "fit", tmp_path / "gaits", "-o", tmp_path / "one.npz", "-j1")[0] == 3
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "m.npz").read_bytes()
    code, _, err = run("cycles", "fit", tmp_path / "gaits", "-o", tmp_path / "m.npz")
    assert code == 2 and "--force" in err


def test_what_is_made_stands_and_is_told(model: Path, tmp_path: Path, run) -> None:  # type: ignore[no-untyped-def]
    code, _, err = run("cycles", "make", model, "-o", tmp_path / "out.bvh", "--speed", 1.3, "--seconds", 3)
    assert code == 0, err
    report = json.loads((tmp_path / "out.report.json").read_text("utf-8"))
    jsonschema.Draft202012Validator(schema("report")).validate(report)
    assert report["cycles"]["speed_m_s"] == pytest.approx(1.3, rel=0.02)
    assert report["after"]["slide_mm"] <= 1.0
    assert (tmp_path / "out.report.html").stat().st_size > 10_000
    labels = json.loads((tmp_path / "out.contacts.json").read_text("utf-8"))
    clip = footfix.load(tmp_path / "out.bvh").clip
    assert labels["source"]["frames"] == len(clip) == 181
    assert len(labels["effectors"]) == 4


def test_a_plan_is_followed(model: Path, tmp_path: Path, run) -> None:  # type: ignore[no-untyped-def]
    (tmp_path / "plan.yaml").write_text("- {time: 0, speed: 1, turn: 0}\n- {time: 2, speed: 2, turn: 45}\n")
    done = run("cycles", "make", model, "-o", tmp_path / "p.bvh", "--plan", tmp_path / "plan.yaml", "--report", "json")
    assert done[0] == 0, done[2]
    report = json.loads((tmp_path / "p.report.json").read_text("utf-8"))
    assert report["cycles"]["distance_m"] == pytest.approx(3.0, rel=1e-3)
    assert report["cycles"]["turned_deg"] == pytest.approx(45.0, rel=1e-3)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("speed: 1", "a plan is a list of rows"),
        ("- {speed: 1}", "row 1"),
        ("- {time: 0, sped: 1}", "'sped' is none of"),
        ("- {time: 1, speed: 1}\n- {time: 1, speed: 2}", "not after row 1"),
        ("- {time: 0, run: 3}", "run must be a number 0 to 1"),
        ("- {time: 0, style: sad}", "no style 'sad'"),
        ("- {", "no YAML"),
    ],
)
def test_a_plan_that_is_none_is_refused_in_words(model: Path, tmp_path: Path, run, text: str, said: str) -> None:  # type: ignore[no-untyped-def]
    (tmp_path / "plan.yaml").write_text(text)
    code, _, err = run("cycles", "make", model, "-o", tmp_path / "p.bvh", "--plan", tmp_path / "plan.yaml")
    assert code in (2, 3) and said in err
    assert not (tmp_path / "p.bvh").exists()


def test_along_a_path_and_a_contradiction(model: Path, tmp_path: Path, run) -> None:  # type: ignore[no-untyped-def]
    out = tmp_path / "c.bvh"
    assert run("cycles", "make", model, "-o", out, "--path", "line:4", "--speed", 1.0, "--report", "none")[0] == 0
    place = footfix.global_positions(footfix.load(out).clip)[:, 0]
    assert place[-1, 2] - place[0, 2] == pytest.approx(4.0, abs=0.06)
    assert np.abs(place[:, 0]).max() < 0.1
    code, _, err = run("cycles", "make", model, "-o", tmp_path / "d.bvh", "--path", "line:4", "--turn", 10)
    assert code == 2 and "--turn" in err

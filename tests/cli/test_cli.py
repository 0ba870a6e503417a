"""The contract of commands: outputs, exit codes, what goes to stdout and what to stderr."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import exports
import pytest
import yaml
from conftest import Run
from walker import make
from walker_plan import Gait

from footfix.errors import FootfixError


@pytest.fixture(scope="module")
def walk() -> bytes:
    import artefacts

    return exports.bvh(artefacts.wander(make(Gait(name="walk", duration=1.6, fps=30)).clip, 0.05))


@pytest.fixture
def clip(tmp_path: Path, walk: bytes) -> Path:
    path = tmp_path / "walk.bvh"
    path.write_bytes(walk)
    return path


def test_clean_writes_beside_the_input(run: Run, clip: Path, walk: bytes) -> None:
    code, out, err = run("clean", clip)
    assert (code, out) == (0, "") and "walk.bvh" in err
    assert {path.name for path in clip.parent.iterdir()} == {
        "walk.bvh", "walk.clean.bvh", "walk.contacts.json", "walk.report.json", "walk.report.html",
    }  # fmt: skip
    assert clip.read_bytes() == walk
    report = json.loads(clip.with_name("walk.report.json").read_text("utf-8"))
    assert (report["format"], report["version"], report["status"]) == ("footfix-report", 1, "cleaned")
    assert report["output"] == "walk.clean.bvh"
    contacts = json.loads(clip.with_name("walk.contacts.json").read_text("utf-8"))
    assert [each["name"] for each in contacts["effectors"]] == ["left_heel", "left_toe", "right_heel", "right_toe"]
    assert contacts["source"]["frames"] == report["source"]["frames"] == 49


def test_a_folder_keeps_its_structure(run: Run, clip: Path, walk: bytes, tmp_path: Path) -> None:
    (tmp_path / "in" / "deep").mkdir(parents=True)
    (tmp_path / "in" / "a.BVH").write_bytes(walk)
    (tmp_path / "in" / "deep" / "b.bvh").write_bytes(walk)
    code, _, _ = run("clean", tmp_path / "in", "-o", tmp_path / "out", "--report", "json")
    assert code == 0
    assert (tmp_path / "out" / "a.BVH").exists() and (tmp_path / "out" / "deep" / "b.report.json").exists()
    assert not list((tmp_path / "out").rglob("a.report.html"))


def test_existing_outputs_are_kept_without_force(run: Run, clip: Path) -> None:
    label = clip.with_name("walk.contacts.json")
    label.write_text("mine")
    code, _, err = run("clean", clip)
    assert code == 2 and "--force" in err and label.read_text() == "mine"
    assert not clip.with_name("walk.clean.bvh").exists()
    assert run("clean", clip, "--force")[0] == 0


def test_in_place_and_dry_run(run: Run, clip: Path, walk: bytes) -> None:
    assert run("clean", clip, "--dry-run")[0] == 0
    assert [path.name for path in clip.parent.iterdir()] == ["walk.bvh"]
    assert run("clean", clip, "--in-place")[0] == 0
    assert clip.read_bytes() != walk
    assert not clip.with_name("walk.clean.bvh").exists()


def test_a_bad_file_does_not_stop_the_others(run: Run, clip: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.bvh").write_text("HIERARCHY\nROOT a\n{\n OFFSET 0 0\n")
    code, _, err = run("clean", tmp_path, "-o", tmp_path / "out")
    assert code == 3 and "bad.bvh" in err and "Traceback" not in err
    assert (tmp_path / "out" / "walk.bvh").exists() and not (tmp_path / "out" / "bad.bvh").exists()


def test_labels_take_the_detectors_place(run: Run, clip: Path, tmp_path: Path) -> None:
    labels = tmp_path / "mine.csv"
    labels.write_text("effector,start,end\nleft_heel,10,20\nleft_toe,12,30\nright_heel,30,40\nright_toe,30,45\n")
    assert run("clean", clip, "-o", tmp_path / "out", "--labels", labels)[0] == 0
    found = json.loads((tmp_path / "out" / "walk.contacts.json").read_text("utf-8"))
    assert [[(c["start"], c["end"]) for c in e["contacts"]] for e in found["effectors"]] == [
        [(10, 20)], [(12, 30)], [(30, 40)], [(30, 45)],
    ]  # fmt: skip
    labels.write_text("effector,start,end\nleft_heel,10,2000\n")
    code, _, err = run("clean", clip, "-o", tmp_path / "out2", "--labels", labels)
    assert code == 3 and "2000" in err


@pytest.mark.parametrize("kind", ["json", "csv", "npz"])
def test_detected_labels_are_read_back(run: Run, clip: Path, tmp_path: Path, kind: str) -> None:
    assert run("detect", clip, "-o", tmp_path / "out", "--format", kind)[0] == 0
    labels = tmp_path / "out" / f"walk.contacts.{kind}"
    assert run("clean", clip, "-o", tmp_path / "again", "--labels", labels)[0] == 0
    code, out, _ = run("detect", clip, "--json")
    assert code == 0
    again = json.loads((tmp_path / "again" / "walk.contacts.json").read_text("utf-8"))

    def spans(document: Any) -> Any:
        return [[(c["start"], c["end"]) for c in e["contacts"]] for e in document["effectors"]]

    assert spans(json.loads(out)) == spans(again)


def test_json_is_one_document_on_stdout(run: Run, clip: Path, tmp_path: Path) -> None:
    code, out, _ = run("clean", clip, "-o", tmp_path / "out", "--json")
    assert code == 0 and json.loads(out)["files"][0]["status"] == "cleaned"
    code, out, _ = run("inspect", clip, "--json")
    assert code == 0 and json.loads(out)["rig"]["legs"][0]["ankle"] == "LeftFoot"


def test_pages_are_drawn_again_from_what_lies_on_disk(run: Run, clip: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run("clean", clip, "-o", out, "--png")[0] == 0
    page, picture = out / "walk.report.html", out / "walk.report.png"
    drawn = page.read_bytes(), picture.read_bytes()
    assert picture.read_bytes()[:4] == b"\x89PNG"
    code, _, err = run("report", out / "walk.report.json", "--png")
    assert code == 3 and "--source" in err  # the clip that came in lies elsewhere
    assert run("report", out / "walk.report.json", "--png", "--source", clip)[0] == 3  # there already
    page.unlink()
    picture.unlink()
    assert run("report", out / "walk.report.json", "--png", "--source", tmp_path)[0] == 0
    assert (page.read_bytes(), picture.read_bytes()) == drawn
    code, _, err = run("report", clip, "--source", clip)
    assert code == 3 and "no report" in err


def test_inspect_says_what_a_person_asks(run: Run, clip: Path) -> None:
    code, out, _ = run("inspect", clip)
    assert code == 0
    for word in ("49 frames", "30 fps", "LeftFoot", "0.01 m", "y is up"):
        assert word in out


def test_settings_are_yaml_with_origins_and_can_be_read_back(run: Run, clip: Path, tmp_path: Path) -> None:
    code, out, _ = run("settings", "--set", "smooth.seconds=0.2")
    assert code == 0 and re.search(r"  seconds: 0\.2 +# --set: window .*\[s\]", out)
    (tmp_path / "mine.yaml").write_text(out)
    code, again, _ = run("settings", "--config", tmp_path / "mine.yaml")
    assert code == 0 and yaml.safe_load(again) == yaml.safe_load(out)


def test_a_config_is_found_above_the_inputs_and_overrides_by_glob(run: Run, clip: Path, tmp_path: Path) -> None:
    (tmp_path / "footfix.yaml").write_text(
        "report: {kind: json}\noverrides:\n- files: 'slow/*'\n  report: {kind: none}\n"
    )
    (tmp_path / "slow").mkdir()
    (tmp_path / "slow" / "b.bvh").write_bytes(clip.read_bytes())
    assert run("clean", tmp_path, "-o", tmp_path / "out")[0] == 0
    assert (tmp_path / "out" / "walk.report.json").exists()
    assert not (tmp_path / "out" / "slow" / "b.report.json").exists()
    assert (tmp_path / "out" / "slow" / "b.contacts.json").exists()


WRONG = {
    "no such file": (["clean", "nowhere.bvh"], "nowhere.bvh"),
    "unknown option": (["clean", "{clip}", "--fast"], "--fast"),
    "misspelt setting": (["clean", "{clip}", "--set", "detect.methd=auto"], "method"),
    "wrong kind": (["clean", "{clip}", "--set", "smooth.seconds=soon"], "a number"),
    "unknown choice": (["clean", "{clip}", "--set", "detect.method=magic"], "magic"),
    "unknown preset": (["clean", "{clip}", "--preset", "mocp"], "mocap"),
    "nothing set": (["clean", "{clip}", "--set", "smooth.seconds"], "NAME=VALUE"),
    "both places": (["clean", "{clip}", "-o", "x", "--in-place"], "exclude"),
    "a group is no value": (["clean", "{clip}", "--set", "smooth=3"], "group"),
}


@pytest.mark.parametrize("why", WRONG)
def test_wrong_usage_exits_2_before_any_work(run: Run, clip: Path, why: str) -> None:
    args, word = WRONG[why]
    code, out, err = run(*(arg.format(clip=clip) for arg in args))
    assert code == 2 and out == "" and word in err and "Traceback" not in err
    assert [path.name for path in clip.parent.iterdir()] == ["walk.bvh"]


def test_a_yaml_bomb_is_refused(run: Run, clip: Path, tmp_path: Path) -> None:
    bomb = "a: &a [x,x,x,x,x,x,x,x,x]\n" + "".join(
        f"{new}: &{new} [{','.join(['*' + old] * 9)}]\n" for old, new in zip("abcdefghi", "bcdefghij", strict=True)
    )
    (tmp_path / "footfix.yaml").write_text(bomb)
    code, _, err = run("clean", clip)
    assert code == 2 and "aliases" in err


def test_a_bug_of_ours_says_so(run: Run, clip: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("never")

    monkeypatch.setattr("footfix.cli.running.config_near", broken)
    code, _, err = run("clean", clip)
    assert code == 4 and "bug" in err and "Traceback" not in err
    assert issubclass(FootfixError, Exception)


def test_a_file_cut_in_mid_row_is_refused_and_can_be_repaired(run: Run, clip: Path, tmp_path: Path) -> None:
    clip.write_bytes(clip.read_bytes()[:-200])
    code, _, err = run("clean", clip)
    assert code == 3 and "cut short" in err and "--repair" in err
    assert [path.name for path in tmp_path.iterdir()] == ["walk.bvh"]
    code, _, err = run("inspect", clip, "--repair", "-o", tmp_path / "mended")
    assert code == 0 and "last-row-cut" in err and "frames-mismatch" in err
    assert run("clean", tmp_path / "mended" / "walk.bvh")[0] == 0
    code, out, _ = run("inspect", tmp_path / "mended" / "walk.bvh", "--json")
    assert code == 0 and json.loads(out)["source"]["frames"] == 48 and not json.loads(out)["notes"]
    assert run("inspect", clip, "--repair")[0] == 2


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_output_that_can_not_be_written_is_no_bug_of_ours(clip: Path) -> None:
    with Path("/dev/full").open("wb") as full:
        ended = subprocess.run(
            [sys.executable, "-m", "footfix", "detect", str(clip), "--json"],
            stdout=full,
            stderr=subprocess.PIPE,
            check=False,
        )
    assert ended.returncode == 3 and b"No space left" in ended.stderr and b"bug" not in ended.stderr


@pytest.mark.skipif(os.name != "posix", reason="pipes are closed otherwise elsewhere")
def test_a_reader_that_goes_early_is_no_failure(clip: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    ended = subprocess.run(
        [sys.executable, "-m", "footfix", "inspect", str(clip)], stdout=writer, stderr=subprocess.PIPE, check=False
    )
    os.close(writer)
    assert ended.returncode == 0 and ended.stderr == b""


def test_a_set_of_outputs_is_whole_or_not_there(
    run: Run, clip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from footfix.batch import write_outputs
    from footfix.errors import OutputError

    def full(path: Path, data: bytes, **more: object) -> None:
        if path.suffix == ".html":
            raise OutputError(f"{path}: can't be written: No space left on device")
        path.write_bytes(data)

    monkeypatch.setattr(write_outputs, "write_whole", full)
    code, _, err = run("clean", clip, "-o", tmp_path / "out", "-j1")
    assert code == 3 and "No space left" in err
    assert not [path for path in (tmp_path / "out").iterdir() if path.is_file()]

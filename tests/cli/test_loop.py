"""`footfix loop` from bytes to bytes: closed to the written digits, the same again, and a clear word where it can't."""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import artefacts
import exports
import jsonschema
import numpy as np
import pytest
from bvhmaker import side_by_side
from conftest import Run
from exports import Spelling
from walker import make
from walker_gaits import Gait

import footfix
from footfix.errors import InputError
from footfix.formats.bvh import decode
from footfix.jobs.loop import loop_file
from footfix.jobs.outputs import Outputs
from footfix.jobs.source import read as decoded
from footfix.locomotion.loop.params import LoopParams
from footfix.settings import ReportParams, Settings

QUIET = ReportParams(kind="json")


@cache
def clip(name: str = "walk", up: str = "y", fps: float = 30.0) -> bytes:
    made = make(Gait(name=name, duration=3.2, fps=fps)).clip  # type: ignore[arg-type]
    return exports.bvh(artefacts.wander(artefacts.drift(made, 0.05), 0.02), Spelling(up=up))


@cache
def looped(name: str = "walk", up: str = "y", **asked: object) -> Outputs:
    settings = Settings(loop=LoopParams(**asked), report=QUIET)  # type: ignore[arg-type]
    return loop_file(clip(name, up), "walk.bvh", settings, output="walk.loop.bvh")


@pytest.mark.parametrize("up", ["y", "z"])
def test_a_loop_closes_to_the_written_digits(up: str) -> None:
    written = decode(looped(up=up).motion)
    first, last = written.values[0], written.values[-1]
    travel, rest = [0, 2] if up == "y" else [0, 1], slice(6, None)
    assert np.array_equal(first[rest], last[rest])
    height = 1 if up == "y" else 2
    assert last[height] == pytest.approx(first[height], abs=2e-6)
    assert np.hypot(*(last[travel] - first[travel])) > 100.0  # [cm] a stride
    assert not np.array_equal(first[:3], last[:3])


def test_in_place_all_of_the_last_row_is_the_first() -> None:
    values = decode(looped(in_place=True).motion).values
    assert np.abs(values[-1] - values[0]).max() <= 2e-6


def test_open_it_lacks_the_last_row_and_has_the_others() -> None:
    closed, opened = decode(looped().motion), decode(looped(open=True).motion)
    assert opened.frames == closed.frames - 1
    assert np.array_equal(opened.values, closed.values[:-1])


def test_hierarchy_channels_and_time_are_the_files_own() -> None:
    written = looped().motion
    assert written.split(b"MOTION")[0] == clip().split(b"MOTION")[0]
    assert decode(written).frame_time == decode(clip()).frame_time
    assert b"Frames: %d" % decode(written).frames in written


@pytest.mark.parametrize(
    ("name", "asked"),
    [("walk", {}), ("walk", {"in_place": True}), ("curve", {"straighten": True})],
    ids=["closed", "in place", "straightened"],
)
def test_a_loop_looped_again_is_the_same_file(name: str, asked: dict[str, bool]) -> None:
    once = looped(name, **asked)
    settings = Settings(loop=LoopParams(**asked), report=QUIET)  # type: ignore[arg-type]
    again = loop_file(once.motion, "walk.loop.bvh", settings)
    assert (again.status, again.motion == once.motion) == ("unchanged", True)


@pytest.mark.parametrize("name", ["run", "backwards"])
def test_of_few_frames_a_second_an_open_loop_is_known_again(name: str) -> None:
    once = looped(name, open=True)
    again = loop_file(once.motion, "walk.loop.bvh", Settings(loop=LoopParams(open=True), report=QUIET))
    assert (again.status, again.motion == once.motion) == ("unchanged", True)


def test_the_report_says_what_was_cut_and_keeps_to_its_schema() -> None:
    outputs = looped()
    report, written = outputs.report, decode(outputs.motion)
    schema = json.loads((resources.files("footfix.report") / "schemas" / "report.v1.json").read_text("utf-8"))
    jsonschema.Draft202012Validator(schema).validate(json.loads(json.dumps(report)))
    loop = report["loop"]
    assert (loop["frames"], loop["strides"], loop["closed"]) == (written.frames, 1, True)
    assert loop["end"] - loop["start"] == written.frames - 1
    assert loop["speed_m_s"] == pytest.approx(1.3, rel=0.1)
    assert loop["distance_m"] == pytest.approx(loop["speed_m_s"] * loop["seconds"], rel=1e-4)
    assert loop["seam_slide_mm"] <= 0.1
    assert max(plant["slide_after_mm"] for plant in report["plants"]) < max(
        plant["slide_before_mm"] for plant in report["plants"]
    )
    contacts = json.loads(outputs.contacts)
    assert (contacts["source"]["file"], contacts["source"]["frames"]) == ("walk.loop.bvh", written.frames)


def test_beside_the_clip_everything_is_called_loop_and_folders_leave_it_out(tmp_path: Path, run: Run) -> None:
    (tmp_path / "walk.bvh").write_bytes(clip())
    code, _, said = run("loop", tmp_path / "walk.bvh")
    assert code == 0
    assert "a loop of 1 stride, frames" in said
    ends = ["bvh", "contacts.json", "report.html", "report.json"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(["walk.bvh", *(f"walk.loop.{e}" for e in ends)])
    assert run("loop", tmp_path / "walk.bvh")[0] == 2  # they are there already
    code, out, _ = run("loop", tmp_path, "-o", tmp_path / "out", "--json", "--report", "none", "--in-place")
    (entry,) = json.loads(out)["files"]
    assert (code, entry["report"]["loop"]["in_place"]) == (0, True)
    page = (tmp_path / "walk.loop.report.html").read_bytes()
    (tmp_path / "walk.loop.report.html").unlink()
    assert run("report", tmp_path / "walk.loop.report.json")[0] == 0
    assert (tmp_path / "walk.loop.report.html").read_bytes() == page


def test_one_clip_without_a_cycle_fails_with_a_clear_word_and_the_others_are_done(tmp_path: Path, run: Run) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "walk.bvh").write_bytes(clip())
    still = make(Gait(name="stand", duration=3.0, fps=30)).clip
    (tmp_path / "in" / "stand.bvh").write_bytes(exports.bvh(still))
    code, _, said = run("loop", tmp_path / "in", "-o", tmp_path / "out", "--report", "json")
    assert code == 3
    assert "stand.bvh: no cycle found: a cycle needs two plants of one foot and one of the other between them" in said
    assert (tmp_path / "out" / "walk.bvh").is_file()
    assert not (tmp_path / "out" / "stand.bvh").exists()
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    became = {each["source"]: each["status"] for each in summary["files"]}
    assert became == {"walk.bvh": "cleaned", "stand.bvh": "failed"}


def test_a_file_without_legs_and_one_of_a_few_frames_get_a_clear_word(tmp_path: Path, run: Run) -> None:
    arm = b"HIERARCHY\nROOT Arm\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
    arm += b"End Site\n{\nOFFSET 0 1 0\n}\n}\n"
    rows = b"".join(b"%d 0 0\n" % k for k in range(30))
    (tmp_path / "arm.bvh").write_bytes(arm + b"MOTION\nFrames: 30\nFrame Time: 0.033333\n" + rows)
    code, _, said = run("loop", tmp_path / "arm.bvh")
    assert (code, "legs" in said) == (3, True)
    short = clip().split(b"\n")
    at = next(k for k, line in enumerate(short) if line.startswith(b"Frame Time"))
    (tmp_path / "short.bvh").write_bytes(b"\n".join(short[: at + 5]) + b"\n")
    code, _, said = run("loop", tmp_path / "short.bvh")
    assert (code, "4 frames are too few for a stride" in said) == (3, True)


def test_a_file_of_two_figures_is_refused_with_what_to_do(tmp_path: Path, run: Run) -> None:
    one = make(Gait(duration=4.0, fps=30)).clip
    both = side_by_side(exports.bvh(one), exports.bvh(artefacts.turned(one, 0.4, (2.0, 1.0))))
    (tmp_path / "two.bvh").write_bytes(both)
    code, _, said = run("loop", tmp_path / "two.bvh")
    assert code == 3
    assert "the file holds 2 figures" in said
    assert "each figure to a file of its own" in said
    assert not (tmp_path / "two.loop.bvh").exists()
    with pytest.raises(InputError, match="2 figures"):
        footfix.loop(decoded(both, "two.bvh", Settings()).clip)


def test_frames_by_hand_are_taken_and_wrong_ones_are_refused(tmp_path: Path, run: Run) -> None:
    (tmp_path / "walk.bvh").write_bytes(clip())
    args: list[Any] = ["loop", tmp_path / "walk.bvh", "-o", tmp_path / "out", "--json", "--report", "json"]
    code, out, _ = run(*args, "--start", 40, "--end", 72)
    (entry,) = json.loads(out)["files"]
    assert (code, entry["report"]["loop"]["start"], entry["report"]["loop"]["end"]) == (0, 40, 72)
    assert run(*args, "--force", "--start", 72, "--end", 40)[0] == 2
    assert run(*args, "--force", "--start", 40, "--end", 4000)[0] == 3

"""`footfix follow` from files to files: what is written and said, and a clear word where it can't."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from importlib import resources
from pathlib import Path

import exports
import jsonschema
import numpy as np
import pytest
from exports import Spelling
from walker import make
from walker_gaits import Gait

from footfix import cli
from footfix.batch.follow import named
from footfix.formats.bvh import decode
from footfix.formats.bvh.new_motion import continuous_angles, with_motion
from footfix.motion.kinematics import places

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def clips(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("clips")
    gaits = {"walk": Gait(name="walk", duration=3.0, fps=30), "run": Gait(name="run", duration=2.0, fps=30)}
    for name, gait in gaits.items():
        (folder / f"{name}.bvh").write_bytes(exports.bvh(make(gait).clip))
    (folder / "up.bvh").write_bytes(exports.bvh(make(Gait(name="walk", duration=3.0, fps=30)).clip, Spelling(up="z")))
    other = (folder / "walk.bvh").read_bytes().replace(b"LeftUpLeg", b"LeftThigh")
    (folder / "other.bvh").write_bytes(other)
    (folder / "still.bvh").write_bytes(exports.bvh(make(Gait(name="stand", duration=2.0, fps=30)).clip))
    (folder / "way.csv").write_text("x,z\n0,0\n0,3\n3,3\n", "utf-8")
    return folder


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Run:
    def call(*args: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["footfix", "follow", *map(str, args)])
        code = cli.run()
        said = capfd.readouterr()
        return code, str(said.out), str(said.err)

    return call


def test_what_is_written_and_said(run: Run, clips: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.bvh"
    code, _, said = run(clips / "way.csv", clips / "walk.bvh", f"{clips / 'run.bvh'}@1s", "-o", out)
    assert code == 0, said
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "out.bvh", "out.contacts.json", "out.report.html", "out.report.json"
    ]  # fmt: skip
    report = json.loads((tmp_path / "out.report.json").read_text("utf-8"))
    schema = json.loads((resources.files("footfix.report") / "schemas" / "report.v1.json").read_text("utf-8"))
    jsonschema.Draft202012Validator(schema).validate(report)
    assert report["follow"]["path"]["length_m"] < 6.0  # the corner is cut
    assert report["follow"]["transitions"][0]["start_s"] == 1.0
    assert "rounded to a radius" in said
    assert "run.bvh takes over at 1.00 s" in said
    assert "joints would accelerate" in said
    contacts = json.loads((tmp_path / "out.contacts.json").read_text("utf-8"))
    assert contacts["source"]["frames"] == report["follow"]["walked"]["frames"]
    code, _, said = run(clips / "way.csv", clips / "walk.bvh", "-o", out)
    assert code == 2
    assert "--force" in said


def test_a_file_with_z_up_is_written_with_z_up(run: Run, clips: Path, tmp_path: Path) -> None:
    for name in ("walk", "up"):
        assert run("circle:1", clips / f"{name}.bvh", "-o", tmp_path / f"{name}.bvh", "-q", "--report", "none")[0] == 0
    flat, high = (decode((tmp_path / f"{name}.bvh").read_bytes()) for name in ("walk", "up"))
    assert high.text.split(b"MOTION")[0] == decode((clips / "up.bvh").read_bytes()).text.split(b"MOTION")[0]
    assert np.allclose(np.ptp(flat.values[:, [0, 2]], axis=0), np.ptp(high.values[:, [0, 1]], axis=0), atol=0.5)
    assert np.ptp(high.values[:, 2]) < 0.2 * np.ptp(high.values[:, 0])


@pytest.mark.parametrize(("args", "said"), [
    (("circle:x", "walk.bvh"), "circle:2 is one"),
    (("nowhere.csv", "walk.bvh"), "no such file"),
    (("line:4", "nobody.bvh"), "nobody.bvh: no such file"),
    (("line:4", "walk.bvh@3s"), "begins at the start"),
    (("line:4", "walk.bvh", "run.bvh"), "where does"),
    (("line:4", "walk.bvh", "run.bvh@2x"), "no place to begin"),
    (("line:4", "walk.bvh", "run.bvh@200m"), "the walk ends after"),
    (("line:4", "walk.bvh", "--speed", "fast"), "no speed"),
])  # fmt: skip
def test_what_makes_no_sense_is_refused_before_anything_is_written(
    run: Run, clips: Path, tmp_path: Path, args: tuple[str, ...], said: str
) -> None:
    named = [str(clips / each) if ".bvh" in each or ".csv" in each else each for each in args]
    code, _, heard = run(*named, "-o", tmp_path / "out.bvh")
    assert (code, said in heard) in ((2, True), (3, True)), heard
    assert not list(tmp_path.iterdir())


def test_clips_that_can_not_be_used_fail_and_say_why(run: Run, clips: Path, tmp_path: Path) -> None:
    code, _, said = run("line:4", clips / "walk.bvh", f"{clips / 'other.bvh'}@1s", "-o", tmp_path / "out.bvh")
    assert code == 3
    assert "'LeftThigh', not 'LeftUpLeg'" in said
    code, _, said = run("line:4", clips / "still.bvh", "-o", tmp_path / "out.bvh")
    assert code == 3
    assert "still.bvh" in said
    assert not list(tmp_path.iterdir())
    assert run("line:4", clips / "walk.bvh", "-o", tmp_path / "out.txt")[0] == 2


def test_json_is_one_document(run: Run, clips: Path, tmp_path: Path) -> None:
    asked = ("--json", "--dry-run", "--speed", "1.2x")
    code, out, _ = run("circle:2", clips / "walk.bvh", "-o", tmp_path / "out.bvh", *asked)
    assert code == 0
    assert json.loads(out)["files"][0]["report"]["follow"]["walked"]["speed_m_s"] > 1.2
    assert not list(tmp_path.iterdir())


def test_a_name_may_hold_an_at_sign(tmp_path: Path) -> None:
    path = tmp_path / "a@3s"
    path.write_bytes(b"")
    assert named(str(path)) == (str(path), None)
    assert named(f"{path}@8m") == (str(path), "8m")


def test_a_file_with_its_own_motion_says_the_same(clips: Path) -> None:
    document = decode((clips / "walk.bvh").read_bytes())
    frames = np.arange(document.frames)
    again = decode(with_motion(document, frames, document.clip))
    assert np.allclose(places(again.clip), places(document.clip), atol=1e-5)
    assert again.text.split(b"MOTION")[0] == document.text.split(b"MOTION")[0]


def test_angles_go_on_past_a_whole_turn_and_over_gimbal_lock() -> None:
    turn = np.linspace(0.0, 900.0, 301)
    wrapped = (turn + 180.0) % 360.0 - 180.0
    angles = np.stack([wrapped, 0.0 * turn, 10.0 + 0.0 * turn], axis=1)
    assert np.allclose(continuous_angles(angles, three=True)[:, 0], turn)
    flipped = angles.copy()
    flipped[100:] = np.stack([angles[100:, 0] + 180.0, 180.0 - angles[100:, 1], angles[100:, 2] - 180.0], axis=1)
    assert np.allclose(continuous_angles(flipped, three=True)[:, 0], turn)

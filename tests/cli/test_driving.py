"""How the command line is driven: names of outputs, what is said last, closed streams, completion, the manual page."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import exports
import pytest
from conftest import Run
from walker import make
from walker_plan import Gait

from footfix import cli
from footfix.batch import inputs
from footfix.cli import manual


@pytest.fixture(scope="module")
def walk() -> bytes:
    import artefacts

    return exports.bvh(artefacts.wander(make(Gait(name="walk", duration=1.6, fps=30)).clip, 0.05))


@pytest.fixture
def clip(tmp_path: Path, walk: bytes, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "walk.bvh").write_bytes(walk)
    return tmp_path / "walk.bvh"


@pytest.fixture
def takes(clip: Path, walk: bytes) -> Path:
    (clip.parent / "takes" / "deep").mkdir(parents=True)
    (clip.parent / "takes" / "a.bvh").write_bytes(walk)
    (clip.parent / "takes" / "deep" / "b.bvh").write_bytes(walk.replace(b"walk", b"walc"))
    return clip.parent / "takes"


def names(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_one_clip_may_be_given_a_name(run: Run, clip: Path) -> None:
    code, _, err = run("clean", "walk.bvh", "-o", "new/out.bvh")
    assert code == 0
    assert names(clip.parent / "new") == {"out.bvh", "out.contacts.json", "out.report.json", "out.report.html"}
    assert json.loads(Path("new/out.report.json").read_text("utf-8"))["output"] == "out.bvh"
    last = err.rstrip().splitlines()[-1]
    assert last == f"wrote {Path('new/out.bvh')} and 3 more beside it; open {Path('new/out.report.html')}"
    assert run("clean", "walk.bvh", "-o", "new/out.bvh")[0] == 2
    assert run("check", "new/out.bvh", "--max", "slide_mm=21")[0] == 0  # finds the report beside it


REFUSED = {
    "a folder is there": (("clean", "walk.bvh", "-o", "there.bvh"), "there.bvh: a folder of this name"),
    "a file is there": (("clean", "walk.bvh", "-o", "file"), "file: this is a file"),
    "the input itself": (("clean", "walk.bvh", "-o", "walk.bvh"), "itself an input"),
    "one name for a folder": (("clean", "takes", "-o", "all.bvh"), "name a folder"),
    "one name for two clips": (("clean", "walk.bvh", "takes/a.bvh", "-o", "all.bvh"), "2 clips were named"),
    "another format": (("clean", "walk.bvh", "-o", "walk.fbx"), ".fbx is not written"),
    "no command": (("walk.bvh",), "footfix clean walk.bvh"),
    "no command, a folder": (("takes", "-o", "out"), "footfix clean takes -o out"),
    "a slip": (("clen", "walk.bvh"), "did you mean footfix clean"),
    "an order of one name twice": (("clean", "walk.bvh", "--order", "left_toe,left_toe"), "--order takes"),
}


@pytest.mark.parametrize("why", REFUSED)
def test_what_can_not_be_meant_is_refused_plainly(run: Run, takes: Path, why: str) -> None:
    Path("there.bvh").mkdir()
    Path("file").touch()
    before = names(takes.parent)
    args, words = REFUSED[why]
    code, out, err = run(*args)
    assert code == 2 and words in err and not out
    assert names(takes.parent) == before


def test_a_folder_without_an_output_gets_summary_and_index(run: Run, takes: Path) -> None:
    code, _, err = run("clean", "takes", "-j1")
    assert code == 0 and err.rstrip().endswith(f"open {Path('takes/index.html')}")
    files = {
        each["source"]: each["outputs"] for each in json.loads((takes / "summary.json").read_text("utf-8"))["files"]
    }
    assert files["deep/b.bvh"]["bvh"] == "deep/b.clean.bvh"
    assert all((takes / path).is_file() for outputs in files.values() for path in outputs.values())
    assert run("clean", "takes", "-j1")[0] == 2  # what is there stays
    was = {name: (takes / name).read_bytes() for name in names(takes)}
    (takes / "deep" / "b.clean.bvh").unlink()
    code, _, err = run("clean", "takes", "--resume", "-j1")
    assert code == 0 and "1 clip was done before" in err
    assert {name: (takes / name).read_bytes() for name in names(takes)} == was
    # a folder in which clips were cleaned is still a folder of clips to those above it
    assert len(inputs.sources(["."])) == 3


def test_a_folder_is_cleaned_in_place(run: Run, takes: Path, walk: bytes) -> None:
    assert run("clean", "takes", "--in-place", "-j1")[0] == 0
    files = {
        each["source"]: each["outputs"] for each in json.loads((takes / "summary.json").read_text("utf-8"))["files"]
    }
    assert {name: outputs["bvh"] for name, outputs in files.items()} == {"a.bvh": "a.bvh", "deep/b.bvh": "deep/b.bvh"}
    assert (takes / "a.bvh").read_bytes() != walk


def test_resuming_one_clip_needs_no_folder(run: Run, clip: Path) -> None:
    assert run("clean", "walk.bvh", "--resume")[0] == 0
    was = clip.with_name("walk.clean.bvh").stat().st_mtime_ns
    assert run("clean", "walk.bvh", "--resume")[0] == 0
    assert clip.with_name("walk.clean.bvh").stat().st_mtime_ns == was


def test_what_was_written_is_told_unless_nobody_asks(run: Run, clip: Path) -> None:
    every = run("clean", "walk.bvh", "-o", "a", "-v")[2]
    assert {line for line in every.splitlines() if line.startswith("wrote ")} == {
        f"wrote {Path('a') / name}" for name in names(Path("a"))
    }
    assert "wrote" not in run("clean", "walk.bvh", "-o", "b", "-q")[2]
    assert "wrote" not in run("clean", "walk.bvh", "-o", "c", "--json")[2]
    assert "wrote" not in run("clean", "walk.bvh", "-o", "d", "--dry-run")[2]


@pytest.mark.parametrize("name", ["w.csv", "w.json", "w.npz", "w.npy", "w.frames.csv"])
def test_labels_are_of_the_format_that_they_are_named_by(run: Run, clip: Path, name: str) -> None:
    assert run("detect", "walk.bvh", "-o", name)[0] == 0
    head = Path(name).read_bytes()[:12]
    assert head.startswith({"w.csv": b"effector,sta", "w.json": b"{", "w.npz": b"PK", "w.npy": b"\x93NUMPY"}.get(
        name, b"frame,time_s"
    ))  # fmt: skip


def test_detecting_in_many_clips_prints_a_table(run: Run, takes: Path) -> None:
    code, out, _ = run("detect", "takes", "-o", "labels", "-j1")
    lines = out.splitlines()
    assert code == 0 and len(lines) == 3
    assert lines[0].split() == ["clip", "left_heel", "left_toe", "right_heel", "right_toe", "planted"]
    document = json.loads(Path("labels/a.contacts.json").read_text("utf-8"))
    counts = [len(each["contacts"]) for each in document["effectors"]]
    share = sum(c["end"] - c["start"] for e in document["effectors"] for c in e["contacts"]) / 4 / 49
    assert lines[1].split()[1:] == [*map(str, counts), f"{100 * share:.0f}", "%"]


@pytest.mark.skipif(sys.platform == "win32", reason="a shell of POSIX closes streams")
@pytest.mark.parametrize("closed", [">&- 2>&- <&-"])
def test_closed_streams_are_no_failure(clip: Path, closed: str) -> None:
    command = f'"{sys.executable}" -m footfix clean walk.bvh -o out {closed}'
    assert subprocess.run(command, shell=True, check=False).returncode == 0
    assert names(Path("out")) == {"walk.bvh", "walk.contacts.json", "walk.report.json", "walk.report.html"}
    assert Path("out/walk.bvh").read_bytes().startswith(b"HIERARCHY")


def test_shells_complete_commands_presets_and_files(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def completed(words: str) -> list[str]:
        monkeypatch.setenv("_FOOTFIX_COMPLETE", "bash_complete")
        monkeypatch.setenv("COMP_WORDS", words)
        monkeypatch.setenv("COMP_CWORD", str(len(words.split(" ")) - 1))
        code = subprocess.run([Path(sys.executable).with_name("footfix")], capture_output=True, text=True, check=False)
        return code.stdout.split()

    assert completed("footfix che") == ["plain,check"]
    assert "plain,video" in completed("footfix clean --preset v")
    assert completed("footfix clean wal") == ["file,wal"]


def test_the_manual_page_names_every_command_and_option() -> None:
    page = manual.page()
    for name in cli.COMMANDS:
        assert f"\n.SH FOOTFIX {name.upper()}\n" in page
    for option in ("order", "in\\-place", "presets", "junit"):
        assert f"\\-\\-{option}" in page
    assert not re.search(r"^\.(?!TH|SH|SS|PP|TP|B |I )", page, re.M)


def test_every_ending_stands_in_the_manual() -> None:
    from footfix.errors import ExitCode

    assert set(manual._ENDINGS) == {str(int(code)) for code in ExitCode}

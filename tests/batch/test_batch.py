"""Batches: which inputs, which outputs, what is refused before any work, journal, resume, gates, summaries."""

from __future__ import annotations

import html
import json
import os
import re
import shutil
import sys
import xml.etree.ElementTree
from pathlib import Path
from typing import Any

import artefacts
import exports
import pytest
import yaml
from conftest import ROOT, Run
from walker import make
from walker_plan import Gait

from footfix import cli
from footfix.batch import gates
from footfix.batch.inputs import MARK, shard, sources
from footfix.batch.journal import Journal, journal_in, recall
from footfix.batch.output_paths import plan
from footfix.batch.task import FileResult
from footfix.errors import UsageError
from footfix.report.annotations import annotation
from footfix.report.junit import Case, junit


def suffixes(source: object) -> tuple[str, ...]:
    return (".contacts.json",)


@pytest.fixture(scope="module")
def walk() -> bytes:
    return exports.bvh(artefacts.wander(make(Gait(name="walk", duration=1.6, fps=30, seed=1)).clip, 0.05))


@pytest.fixture
def tree(tmp_path: Path, walk: bytes, monkeypatch: pytest.MonkeyPatch) -> Path:
    """in/ with three good clips and a broken one; the working folder is its parent."""
    monkeypatch.chdir(tmp_path)
    fill(tmp_path, walk)
    return tmp_path


@pytest.fixture(scope="module")
def once(walk: bytes, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What comes of `tree` when it is cleaned into out/, beside the list of it for CI."""
    folder = tmp_path_factory.mktemp("batch")
    fill(folder, walk)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(sys, "argv", ["footfix", "clean", "in", "-o", "out", "--junit", "junit.xml", "-j1"])
        assert cli.run() == 3
    return folder


def fill(folder: Path, walk: bytes) -> None:
    for name in ("a.bvh", "b.BVH", "deep/c.bvh"):
        put(folder / "in" / name, walk)
    put(folder / "in" / "broken.bvh", b"HIERARCHY\nROOT x\n")


def put(path: Path, data: bytes = b"") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path


def names(found: Any) -> list[str]:
    return [source.below.as_posix() for source in found]


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


# inputs


def test_folders_give_their_clips_in_order(tmp_path: Path) -> None:
    for name in ("b.bvh", "a.BVH", "sub/c.bvh", ".hid/x.bvh", ".y.bvh", "old.clean.bvh", "notes.txt"):
        put(tmp_path / name)
    assert names(sources([str(tmp_path)])) == ["a.BVH", "b.bvh", "sub/c.bvh"]


def test_own_outputs_are_left_out(tmp_path: Path) -> None:
    put(tmp_path / "a.bvh")
    put(tmp_path / "out" / "a.bvh")
    put(tmp_path / "old" / MARK / "run.jsonl")
    put(tmp_path / "old" / "a.bvh")
    assert names(sources([str(tmp_path)], leave_out=tmp_path / "out")) == ["a.bvh"]
    assert names(sources([str(tmp_path / "old")])) == ["a.bvh"]  # named by itself it is meant
    assert len(sources([str(tmp_path)], own_outputs=True)) == 3


def test_globs_choose_among_what_folders_give(tmp_path: Path) -> None:
    for name in ("walk1.bvh", "run1.bvh", "sub/walk2.bvh", "sub/bad/walk3.bvh"):
        put(tmp_path / name)
    assert names(sources([str(tmp_path)], include=["walk*"])) == ["walk1.bvh", "sub/walk2.bvh", "sub/bad/walk3.bvh"]
    assert names(sources([str(tmp_path)], include=["walk*"], exclude=["sub/bad/*"])) == ["walk1.bvh", "sub/walk2.bvh"]
    with pytest.raises(UsageError, match="--include"):
        sources([str(tmp_path)], include=["nothing*"])


def test_lists_keep_paths_from_here_and_only_names_from_elsewhere(tree: Path, walk: bytes) -> None:
    elsewhere = put(tree.parent / f"{tree.name}-else" / "far.bvh", walk)
    text = f"# a comment\n\nin/a.bvh\r\nin/deep/../deep/c.bvh\n{elsewhere}\n../{elsewhere.parent.name}/far.bvh\n"
    (tree / "list").write_text(text, newline="")
    assert names(sources([], lists=["list"])) == ["in/a.bvh", "in/deep/c.bvh", "far.bvh"]  # named twice, done once
    (tree / "list0").write_bytes(b"in/a.bvh\0in/b.BVH\0")
    assert names(sources([], lists=["list0"])) == ["in/a.bvh", "in/b.BVH"]
    (tree / "bad").write_text("in/a.bvh\nin/none.bvh\n")
    with pytest.raises(UsageError, match=r"bad:2: in/none\.bvh"):
        sources([], lists=["bad"])


def test_a_clip_named_in_many_ways_is_one_input(tree: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    found = sources(["in", "./in/a.bvh", str(tree / "in" / "a.bvh")])
    assert names(found) == ["a.bvh", "b.BVH", "broken.bvh", "deep/c.bvh"]
    listing = put(tree / "list", b"in/a.bvh\n./in/deep/c.bvh\n")
    with listing.open("rb") as file:
        monkeypatch.setattr(sys, "stdin", type("Stream", (), {"buffer": file})())
        assert run("clean", "--from-file", "-", "-o", "out", "--report", "none")[0] == 0
    assert {name for name in contents(tree / "out") if name.endswith(".bvh")} == {"in/a.bvh", "in/deep/c.bvh"}


def test_shards_are_disjoint_and_whole(tmp_path: Path) -> None:
    for k in range(10):
        put(tmp_path / f"{k}.bvh")
    found = sources([str(tmp_path)])
    parts = [shard(found, part, 4) for part in range(1, 5)]
    assert sorted(names([each for part in parts for each in part])) == names(found)
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


# outputs


def test_two_inputs_for_one_output_are_refused(tmp_path: Path) -> None:
    one, two = put(tmp_path / "1" / "a.bvh"), put(tmp_path / "2" / "a.bvh")
    with pytest.raises(UsageError, match="both write"):
        plan(sources([str(one), str(two)]), output=tmp_path / "out", in_place=False, suffixes=suffixes, force=False)
    same = sources([str(put(tmp_path / "3" / "a.bvh").parent)]) + sources([str(put(tmp_path / "3" / "a.BVH"))])
    if len({os.path.realpath(each.path) for each in same}) == 2:
        with pytest.raises(UsageError, match="both write"):
            plan(same, output=None, in_place=False, suffixes=suffixes, force=False)


@pytest.mark.skipif(sys.platform == "win32", reason="making links takes a right there")
def test_outputs_never_leave_their_folder_by_a_link(tmp_path: Path) -> None:
    put(tmp_path / "in" / "sub" / "a.bvh")
    (tmp_path / "out").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out" / "sub").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(UsageError, match="outside"):
        plan(sources([str(tmp_path / "in")]), output=tmp_path / "out", in_place=False, suffixes=suffixes, force=True)
    assert not list((tmp_path / "elsewhere").iterdir())


@pytest.mark.skipif(sys.platform == "win32", reason="making links takes a right there")
def test_a_link_in_the_place_of_an_output_is_replaced_not_followed(tree: Path, run: Run) -> None:
    (tree / "out").mkdir()
    precious = put(tree / "precious.bvh", b"mine")
    (tree / "out" / "a.bvh").symlink_to(precious)
    assert run("clean", "in/a.bvh", "-o", "out")[0] == 2
    assert run("clean", "in/a.bvh", "-o", "out", "--force", "--report", "none")[0] == 0
    assert precious.read_bytes() == b"mine" and not (tree / "out" / "a.bvh").is_symlink()


def test_an_output_folder_that_is_a_file_is_refused_before_any_work(tree: Path, run: Run) -> None:
    put(tree / "file")
    code, _, err = run("clean", "in", "-o", "file/out")
    assert code == 2 and "is a file" in err


@pytest.mark.skipif(sys.platform == "win32" or not hasattr(os, "geteuid") or os.geteuid() == 0,
                    reason="permissions do not hold for everyone here")  # fmt: skip
def test_a_folder_that_can_not_be_written_is_refused_before_any_work(tree: Path, run: Run) -> None:
    (tree / "locked").mkdir(mode=0o500)
    code, _, err = run("clean", "in", "-o", "locked/out")
    assert code == 2 and "can't be written" in err


# runs


def test_one_broken_clip_does_not_stop_the_others(tree: Path, run: Run) -> None:
    before = contents(tree / "in")
    code, out, err = run("clean", "in", "-o", "in/out", "--report", "json", "-j1")
    assert code == 3 and out == "" and "broken.bvh" in err and "Traceback" not in err
    found = contents(tree / "in" / "out")
    for stem in ("a.bvh", "b.BVH", "deep/c.bvh"):
        for suffix in (Path(stem).suffix, ".contacts.json", ".report.json"):
            assert Path(stem).with_suffix(suffix).as_posix() in found
    assert not any("broken" in name for name in found) and not any(name.endswith(".tmp") for name in found)
    assert {name: data for name, data in contents(tree / "in").items() if not name.startswith("out/")} == before
    assert run("clean", "in", "-o", "in/out")[0] == 2  # nothing is overwritten
    assert contents(tree / "in" / "out") == found
    assert run("clean", "in", "-o", "in/out", "--force", "--report", "json", "-j1")[0] == 3  # nor taken for input
    assert contents(tree / "in" / "out") == found


def test_summary_and_index_name_every_clip(once: Path) -> None:
    summary = json.loads((once / "out" / "summary.json").read_text("utf-8"))
    assert summary["clips"] == {"total": 4, "cleaned": 3, "unchanged": 0, "failed": 1}
    assert [each["source"] for each in summary["files"]] == ["a.bvh", "b.BVH", "broken.bvh", "deep/c.bvh"]
    for each in summary["files"]:
        for path in each.get("outputs", {}).values():
            assert (once / "out" / path).is_file()
    assert summary["worst"]["slide_after_mm"] < summary["worst"]["slide_before_mm"]
    index = html.unescape((once / "out" / "index.html").read_text("utf-8"))
    assert "deep/c.report.html" in index and "broken.bvh" in index
    cases = xml.etree.ElementTree.parse(once / "junit.xml").getroot().findall(".//testcase")
    assert len(cases) == 4 and sum(case.find("error") is not None for case in cases) == 1


def test_resuming_leaves_what_is_done_and_does_the_rest(tree: Path, run: Run, once: Path) -> None:
    shutil.copytree(once / "out", tree / "out")
    whole = contents(tree / "out")
    done = tree / "out" / "a.bvh"
    written = done.stat().st_mtime_ns
    (tree / "out" / "deep" / "c.report.json").unlink()  # as if the power had gone before the last file
    (tree / "out" / "b.BVH").unlink()
    (tree / "out" / "index.html").unlink()
    assert run("clean", "in", "-o", "out", "-j1", "--resume")[0] == 3
    assert contents(tree / "out") == whole
    assert done.stat().st_mtime_ns == written


def test_resuming_does_again_what_has_changed_and_keeps_what_was_edited(tree: Path, run: Run, once: Path) -> None:
    shutil.copytree(once / "out", tree / "out")
    labels = tree / "out" / "a.contacts.json"
    labels.write_text("mine")
    code, _, err = run("clean", "in", "-o", "out", "-j1", "--resume")
    assert code == 3 and "a.contacts" not in err and labels.read_text() == "mine"
    assert run("clean", "in", "-o", "out", "-j1", "--resume", "--method", "root")[0] == 3
    assert labels.read_text() == "mine"  # made with other settings, but edited since
    report = json.loads((tree / "out" / "deep" / "c.report.json").read_text("utf-8"))
    assert report["method"] == "root"
    assert json.loads((tree / "out" / "a.report.json").read_text("utf-8"))["method"] == "ik"


def test_resuming_never_takes_the_files_of_others_for_its_own(tree: Path, run: Run) -> None:
    put(tree / "out" / "deep" / "c.bvh", b"mine")
    code, _, err = run("clean", "in", "-o", "out", "--resume", "-j1")
    assert code == 2 and "c.bvh is there already" in err
    assert (tree / "out" / "deep" / "c.bvh").read_bytes() == b"mine"


def test_shards_add_up_to_the_whole(tree: Path, run: Run, once: Path) -> None:
    for part in (1, 2, 3):
        run("clean", "in", "-o", "out", "-j1", "--shard", f"{part}/3")
    assert (tree / "out" / "summary.2-of-3.json").exists()
    assert run("clean", "in", "-o", "out", "-j1", "--resume")[0] == 3  # gathers
    whole, parts = contents(once / "out"), contents(tree / "out")
    shared = {name for name in whole if not name.startswith(MARK)}
    assert {name: parts[name] for name in shared} == {name: whole[name] for name in shared}
    assert run("clean", "in", "-o", "x", "--shard", "4/3")[0] == 2


def test_standard_input_to_a_folder(tree: Path, run: Run, walk: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    with (tree / "in" / "a.bvh").open("rb") as file:
        monkeypatch.setattr(sys, "stdin", type("Stream", (), {"buffer": file})())
        assert run("clean", "-", "-o", "out", "--report", "none")[0] == 0
    assert (tree / "out" / "stdin.bvh").exists()


def test_the_journal_outlives_a_torn_line(tmp_path: Path) -> None:
    journal = Journal(journal_in(tmp_path, "run", own=True))
    journal.begin(["a"])
    journal.end("a", FileResult("a", "cleaned", hashes={"a.bvh": "12"}))
    journal.begin(["b"])
    journal.close()
    path = tmp_path / MARK / "run.jsonl"
    path.write_bytes(path.read_bytes()[:-10])
    past = recall(tmp_path)
    assert past.begun == {"a"} and past.hashes == {"a": {"a.bvh": "12"}}
    again = Journal(journal_in(tmp_path, "run", own=True))
    again.begin(["c"])
    again.close()
    assert recall(tmp_path).begun == {"a", "c"}


# check


def test_check_fails_a_skating_clip_and_passes_the_cleaned_one(tree: Path, run: Run) -> None:
    code, out, _ = run("check", "in/a.bvh", "--max", "slide_mm=1", "--junit", "junit.xml")
    assert code == 1 and "slide_mm" in out
    failure = xml.etree.ElementTree.parse(tree / "junit.xml").getroot().find(".//failure")
    assert failure is not None and "slide_mm" in failure.attrib["message"]
    assert run("clean", "in/a.bvh", "-o", "out")[0] == 0
    gates_given = ("--max", "slide_mm=21", "--max", "skate_cm_s=1", "--max", "jitter_ratio=1.1")
    assert run("check", "out/a.bvh", *gates_given)[0] == 0
    assert run("check", "in/a.bvh", "in/broken.bvh", "--max", "slide_mm=1")[0] == 3


def test_gates_stand_in_the_config_and_unknown_ones_are_refused(tree: Path, run: Run) -> None:
    (tree / "footfix.yaml").write_text("gates: {slide_mm: 1}\n")
    assert run("check", "in/a.bvh")[0] == 1
    assert run("check", "in/a.bvh", "--max", "slide_mm=1000")[0] == 0
    code, _, err = run("check", "in/a.bvh", "--max", "slid_mm=1")
    assert code == 2 and "slide_mm" in err
    assert run("check", "in/a.bvh", "--max", "slide_mm=nan")[0] == 2
    code, _, err = run("check", "in/a.bvh", "--set", "detect.methd=auto")
    assert code == 2 and "method" in err


def test_ratios_are_held_against_the_clip_before_its_cleaning(tree: Path, run: Run) -> None:
    assert run("clean", "in/a.bvh", "-o", "out")[0] == 0
    report = json.loads((tree / "out" / "a.report.json").read_text("utf-8"))
    ratio = report["after"]["jitter_100m_s3"] / report["before"]["jitter_100m_s3"]
    code, out, _ = run("check", "out/a.bvh", "--max", f"jitter_ratio={ratio * 0.999}", "--json")
    document = json.loads(out)
    assert code == 1 and document["passed"] is False
    assert document["files"][0]["over"][0]["value"] == pytest.approx(ratio, rel=1e-4)
    code, out, _ = run("check", "in/a.bvh", "--max", "jitter_ratio=1.1")
    assert code == 0 and "held against itself" in out


def test_annotations_for_github(tree: Path, run: Run) -> None:
    code, out, _ = run("check", "in", "--max", "slide_mm=1", "--format", "github", "-j1")
    lines = out.splitlines()
    assert code == 3 and len(lines) == 4 and all(line.startswith("::error file=") for line in lines)
    assert annotation("error", "a:b,c\n.bvh", "100%\nx", line=3) == (
        "::error file=a%3Ab%2Cc%0A.bvh,line=3,title=footfix::100%25%0Ax"
    )


def test_junit_holds_names_that_xml_can_not_write() -> None:
    data = junit("s", [Case("a\x00<&\"\udcff.bvh", ("x > 1",), "", ("\x1b[31m",)), Case("b", error="no]]>")])
    root = xml.etree.ElementTree.fromstring(data)
    assert root.attrib["failures"] == "1" and root.attrib["errors"] == "1"
    case = root.find(".//testcase")
    assert case is not None and "<&\"" in case.attrib["name"]


def test_every_gate_is_a_measure() -> None:
    assert gates.parse(("slide_mm=21", "jitter_ratio=1.1")) == {"slide_mm": 21.0, "jitter_ratio": 1.1}
    with pytest.raises(UsageError, match="NAME=NUMBER"):
        gates.parse(("slide_mm",))


# what the README shows


def test_the_workflow_and_the_hook_of_the_docs_are_what_they_say(tree: Path, run: Run) -> None:
    text = (ROOT / "docs" / "recipes" / "ci.md").read_text("utf-8")
    blocks = re.findall(r"```yaml\n# (\S+)\n(.*?)```", text, flags=re.DOTALL)
    shown = {name: yaml.safe_load(text) for name, text in blocks}
    steps = shown[".github/workflows/feet.yml"]["jobs"]["feet"]["steps"]
    commands = [step["run"].split() for step in steps if step.get("run", "").startswith("footfix")]
    (tree / "in").rename(tree / "clips")
    code, out, _ = run(*commands[0][1:], "-j1")
    assert code == 3 and "::error file=clips" in out and (tree / "feet.xml").exists()
    hook = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))[0]
    used = shown[".pre-commit-config.yaml"]["repos"][0]["hooks"][0]
    assert used["id"] == hook["id"]
    assert run(*hook["entry"].split()[1:], *used["args"], "clips/a.bvh")[0] == 1
    assert re.search(hook["files"], "clips/a.BVH")

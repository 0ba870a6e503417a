"""The command that a page prints cleans the clip again from edited contacts, typed as it stands there."""

from __future__ import annotations

import html
import json
import re
import shlex
import sys
from pathlib import Path

import artefacts
import exports
import pytest
from walker import make
from walker_plan import Gait

from footfix import cli
from footfix.report.rerun_command import clean_again
from footfix.settings import Layer, Settings, compose

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="quoted for another shell there")


def run(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr(sys, "argv", ["footfix", *words])
    return int(cli.run() or 0)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    clip = artefacts.wander(make(Gait(name="walk", duration=1.6, fps=30)).clip, 0.05)
    for name in ("in/a walk.bvh", "in/deep/er/walk.bvh"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(exports.bvh(clip))
    return tmp_path


@pytest.mark.parametrize(
    ("words", "stem"),
    [
        (["in", "-o", "out"], "out/deep/er/walk"),
        (["in", "-o", "out"], "out/a walk"),
        (["in/a walk.bvh"], "in/a walk"),
        (["in/a walk.bvh", "-o", "else where", "--set", "enforce.method=root"], "else where/a walk"),
    ],
)
def test_the_printed_command_works(folder: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], stem: str) -> None:
    assert run(monkeypatch, "clean", *words, "-q", "-j1") == 0
    page = (folder / f"{stem}.report.html").read_text("utf-8")
    (printed,) = re.findall(r"<code>(footfix clean [^<]+)</code>", page)
    contacts = folder / f"{stem}.contacts.json"
    edited = json.loads(contacts.read_bytes())
    edited["effectors"][0]["contacts"] = [{"start": 3, "end": 12, "confidence": 1}]
    contacts.write_text(json.dumps(edited), encoding="utf-8")
    first = json.loads((folder / f"{stem}.report.json").read_bytes())
    monkeypatch.chdir(contacts.parent)
    assert run(monkeypatch, *shlex.split(html.unescape(printed))[1:], "-q") == 0
    again = json.loads((folder / f"{stem}.report.json").read_bytes())
    heel = edited["effectors"][0]["name"]
    assert [(p["start"], p["end"]) for p in again["plants"] if p["effector"] == heel] == [(3, 12)]
    assert (again["source"], again["output"], again["method"]) == (first["source"], first["output"], first["method"])


def test_settings_that_differ_are_repeated_and_nothing_else() -> None:
    settings = compose([Layer("--set", {"enforce": {"method": "root"}, "report": {"png": True}})])
    again = clean_again(Path("walk.bvh"), Path("out/walk.bvh"), Path("out/walk.contacts.json"), settings)
    assert shlex.split(again.command) == [
        "footfix", "clean", "../walk.bvh", "-o", ".", "--set", 'enforce.method="root"',
        "--labels", "walk.contacts.json", "--force",
    ]  # fmt: skip
    assert "--set" not in clean_again(Path("a.bvh"), Path("b/a.bvh"), Path("b/a.contacts.json"), Settings()).command
    named = clean_again(Path("in/a.bvh"), Path("b/c.bvh"), Path("b/c.contacts.json"), Settings()).command
    assert named == "footfix clean ../in/a.bvh -o c.bvh --labels c.contacts.json --force"
    in_place = clean_again(Path("a.bvh"), Path("a.bvh"), Path("a.contacts.json"), Settings()).command
    assert in_place == "footfix clean a.bvh --in-place --labels a.contacts.json --force"

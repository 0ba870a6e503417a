"""The lines of the README, and the commands over many clips, run as they stand."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path

import pytest
from conftest import ROOT

from footfix import cli
from footfix.config import presets
from footfix.formats.contacts import ENCODERS


def test_the_python_lines_of_the_readme_run(tmp_path: object, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    code = re.search(r"```python\n(.*?)```", text, re.S)
    assert code is not None
    lines = code[1].replace('"sample_data/', f'"{(ROOT / "sample_data").as_posix()}/')
    monkeypatch.chdir(tmp_path)  # type: ignore[arg-type]
    names: dict[str, object] = {}
    exec(compile(lines, "README.md", "exec"), names)
    assert (tmp_path / "walk.clean.bvh").stat().st_size > 1000  # type: ignore[operator]
    result = names["result"]
    assert result.after.slide_mm < result.before.slide_mm  # type: ignore[attr-defined]


def test_the_commands_over_many_clips_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "docs" / "recipes" / "many.md").read_text(encoding="utf-8")
    block = next(each for each in re.findall(r"```\n(.*?)```", text, re.S) if "takes -o cleaned" in each)
    commands = [line.split("   ")[0].split() for line in block.splitlines() if "--dask" not in line]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "takes").mkdir()
    whole = (ROOT / "sample_data" / "walk_skate.bvh").read_bytes().splitlines(keepends=True)
    rows = next(k for k, line in enumerate(whole) if line.startswith(b"Frame Time")) + 1
    head = b"".join(whole[:rows]).replace(b"Frames: 301", b"Frames: 120")
    (tmp_path / "takes" / "walk_skate.bvh").write_bytes(head + b"".join(whole[rows : rows + 120]))
    for command in commands:
        if "--shard" in command:  # one clip has no third of sixteen parts
            command[command.index("--shard") + 1] = "1/1"
            command.append("--resume")
        monkeypatch.setattr(sys, "argv", command)
        assert cli.run() == 0, command
    assert len(commands) == 5 and (tmp_path / "feet.xml").exists()


def test_nothing_is_installed_from_an_index_that_does_not_have_it() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert not re.search(r"pip install ['\"]?footfix(?! @)", text)


def test_every_preset_and_kind_of_label_is_named() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert all(f"`{name}`" in text for name in presets())
    assert "|".join(["json", *ENCODERS]) in text


def test_the_commands_on_cycles_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    found = re.search(r"```\n(python sample_data/make_gaits.py.*?)```", text, re.S)
    assert found is not None
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sample_data").symlink_to(ROOT / "sample_data")
    for line in found[1].splitlines():
        program, *rest = line.split()
        if program == "python":
            monkeypatch.setattr(sys, "argv", rest)
            runpy.run_path(rest[0], run_name="__main__")
            made = sorted((tmp_path / "gaits").iterdir())
            assert len(made) == 12
            for path in made:  # two walks do as well, where fewer cycles are enough
                if path.stem not in ("walk_150cm_s", "walk_180cm_s"):
                    path.unlink()
            monkeypatch.setattr("footfix.jobs.fit_cycles.FEWEST", 10)
            continue
        monkeypatch.setattr(sys, "argv", [program, *rest])
        assert cli.run() == 0, line
    assert (tmp_path / "stroll.report.html").stat().st_size > 10_000

"""The README's Python lines run as they stand."""

from __future__ import annotations

import re

import pytest
from conftest import ROOT


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

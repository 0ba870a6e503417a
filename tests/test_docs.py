"""The documentation: whatever can be set or measured is explained, and its lines of Python run."""

from __future__ import annotations

import importlib.util
import re
import sys
from types import ModuleType

import pytest
from conftest import ROOT

DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def reference() -> ModuleType:
    spec = importlib.util.spec_from_file_location("docs_reference", DOCS / "reference.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def pages(reference: ModuleType) -> dict[str, str]:
    found: dict[str, str] = reference.pages()
    return found


def test_every_setting_and_measure_is_explained(reference: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    assert reference.main() == 0, capsys.readouterr().out


def test_generated_pages_have_every_command_setting_and_public_name(pages: dict[str, str]) -> None:
    assert "## check" in pages["reference/commands.md"]
    assert "| `slide` | `11000.0` |" in pages["reference/settings.md"]
    assert "::: footfix.api.positions.clean_positions" in pages["reference/python.md"]
    assert "| `source.sha256` | string |" in pages["reference/files.md"]


def test_every_page_is_in_the_menu_and_every_entry_is_a_page(pages: dict[str, str]) -> None:
    listed = re.findall(r"^ +-(?: [^:\n]+:)? ([\w/-]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.M)
    written = {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md")}
    assert sorted(listed) == sorted(written | set(pages))


def test_pictures_that_pages_show_are_drawn() -> None:
    drawn = set(re.findall(r'^    "([a-z-]+)": [a-z_]+,$', (DOCS / "pictures.py").read_text(encoding="utf-8"), re.M))
    text = "".join(path.read_text(encoding="utf-8") for path in DOCS.rglob("*.md"))
    assert set(re.findall(r"pictures/([a-z-]+)\.svg", text)) == drawn


def test_python_of_the_first_page_runs(tmp_path: object, monkeypatch: pytest.MonkeyPatch) -> None:
    found = re.search(r"```python\n(.*?)```", (DOCS / "index.md").read_text(encoding="utf-8"), re.S)
    assert found is not None
    monkeypatch.chdir(tmp_path)  # type: ignore[arg-type]
    exec(found[1].replace('"sample_data/', f'"{(ROOT / "sample_data").as_posix()}/'), {})
    assert (tmp_path / "walk.clean.bvh").exists()  # type: ignore[operator]

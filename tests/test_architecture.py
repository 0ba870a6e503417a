"""The house: imports point down, and numeric code neither reads, prints nor logs."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from conftest import ROOT

PACKAGE = ROOT / "footfix"

# Lower rooms first: a module may import from its own room and from rooms before it.
FLOORS = [
    {"errors", "notes", "version"},
    {"motion"},
    {"rig", "input_checks"},
    {"detect", "enforce", "measure"},
    {"locomotion"},
    {"formats"},
    {"settings", "configs"},
    {"pipeline", "config"},
    {"report"},
    {"jobs"},
    {"stream"},
    {"batch", "api"},
    {"cli", "__main__", "__init__"},
]
NUMERIC = {"motion", "rig", "detect", "enforce", "measure", "locomotion"}
DOORS_ONLY = {"click", "yaml", "json", "pathlib", "logging"}
SAID = re.compile(r"\b(print|open)\b")
MODULES = sorted(path for path in PACKAGE.rglob("*.py"))


def room(parts: tuple[str, ...]) -> str:
    return parts[0].removesuffix(".py")


def floor(name: str) -> int:
    return next(k for k, rooms in enumerate(FLOORS) if name in rooms)


def statements(path: Path) -> Iterator[ast.AST]:
    """All statements of a module, those within functions, too; what stands in their expressions imports nothing."""
    left: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    while left:
        node = left.pop()
        yield node
        for block in ("body", "orelse", "finalbody", "handlers", "cases"):
            own = getattr(node, block, ())
            left += own if isinstance(own, list) else ()


@cache
def imported(path: Path) -> set[str]:
    names: set[str] = set()
    for node in statements(path):
        if isinstance(node, ast.Import):
            names.update(each.name for each in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.update(f"{node.module}.{each.name}" for each in node.names)
    return names


def test_imports_point_down() -> None:
    for path in MODULES:
        here = room(path.relative_to(PACKAGE).parts)
        for name in imported(path):
            parts = name.split(".")
            if parts[0] == "footfix" and len(parts) > 1 and here not in ("__init__",):
                assert floor(parts[1]) <= floor(here), f"{path} imports {name}"
                same_floor = floor(parts[1]) == floor(here) and parts[1] != here
                assert not (same_floor and here in NUMERIC), f"{path} imports its neighbour {name}"
            if here in NUMERIC:
                assert parts[0] not in DOORS_ONLY, f"{path} is numeric and imports {name}"


def test_numeric_code_does_not_print() -> None:
    numeric = [path for path in MODULES if room(path.relative_to(PACKAGE).parts) in NUMERIC]
    for path in numeric:
        text = path.read_text(encoding="utf-8")
        calls = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)] if SAID.search(text) else []
        names = {call.func.id for call in calls if isinstance(call.func, ast.Name)}
        assert not names & {"print", "open"}, path
    assert len(numeric) > 50


def name_of(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def test_no_module_imports_itself_by_way_of_others() -> None:
    known = {name_of(path) for path in MODULES}
    arrows = {
        name_of(path): {each if each in known else each.rpartition(".")[0] for each in imported(path)} & known
        for path in MODULES
    }
    done: set[str] = set()

    def look(name: str, way: tuple[str, ...]) -> None:
        assert name not in way, " -> ".join((*way[way.index(name) :], name))
        if name not in done:
            for each in sorted(arrows[name] - {name, "footfix"}):
                look(each, (*way, name))
            done.add(name)

    for name in sorted(known - {"footfix"}):
        look(name, ())


def test_every_room_is_installed() -> None:
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["packages"]
    rooms = {".".join(path.relative_to(ROOT).parent.parts) for path in MODULES}
    assert sorted(listed) == sorted(rooms | {"footfix.configs"})


def test_help_waits_for_no_number_cruncher() -> None:
    code = "import sys, footfix.cli; print(sorted({'numpy', 'scipy', 'yaml', 'bvhio'} & set(sys.modules)))"
    seen = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert seen.strip() == "[]"

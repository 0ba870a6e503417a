"""Every setting and every measure says what it is, and in which unit."""

from __future__ import annotations

import dataclasses
import typing
from pathlib import Path
from typing import Any

import pytest

from footfix.batch import gates
from footfix.config import as_yaml, load_config, meanings_of, preset_changes, preset_summary, presets, read_preset
from footfix.rig.params import LegParams, SoleParams
from footfix.settings import Meaning, Settings, flat, meanings


def kinds(of: type[Any], prefix: str = "") -> dict[str, Any]:
    """Dotted path -> declared type of every setting."""
    found: dict[str, Any] = {}
    for name, kind in typing.get_type_hints(of).items():
        if dataclasses.is_dataclass(kind):
            found |= kinds(kind, f"{prefix}{name}.")  # type: ignore[arg-type]
        else:
            found[prefix + name] = kind
    return found


def is_number(kind: Any) -> bool:
    return kind in (int, float) or any(each in (int, float) for each in typing.get_args(kind))


def test_every_setting_has_a_meaning_and_every_number_a_unit() -> None:
    said = dict(meanings_of(Settings()))
    declared = kinds(Settings)
    assert set(declared) == {path for path, _ in flat(Settings())} and set(declared) < set(said)
    assert not [path for path, meaning in said.items() if not meaning.text]
    unitless = {"gates"}  # each measure has its own
    assert not [
        path for path, kind in declared.items() if is_number(kind) and not said[path].unit and path not in unitless
    ]
    assert not [path for path, kind in declared.items() if kind is bool and said[path].unit]


@pytest.mark.parametrize("kind", [LegParams, SoleParams])
def test_settings_in_mappings_have_meanings_too(kind: type[Any]) -> None:
    assert list(meanings(kind)) == [each.name for each in dataclasses.fields(kind)]


def test_every_measure_has_a_meaning_and_a_unit() -> None:
    assert all(meaning.text and meaning.unit for meaning in gates.MEASURES.values())
    ends = {"mm": "_mm", "cm/s": "_cm_s", "deg": "_deg", "deg/s": "_deg_s", "m/s^2": "_m_s2", "factor": "_ratio"}
    for name, meaning in gates.MEASURES.items():
        assert name.endswith(ends.get(meaning.unit, "")), (name, meaning.unit)
    assert set(gates.DEFAULTS) < set(gates.MEASURES)


def test_docstrings_are_read_as_they_are_written() -> None:
    @dataclasses.dataclass
    class Params:
        """Some.

        Args:
            near: how near a foot is, in
                two lines: with a colon [m].
            first, last: [s] of both.
            word: no unit.

        Not an argument: this.
        """

        near: float = 0.0
        first: float = 0.0
        last: float = 0.0
        word: str = ""
        silent: str = ""

    assert meanings(Params) == {
        "near": Meaning("how near a foot is, in two lines: with a colon", "m"),
        "first": Meaning("of both", "s"),
        "last": Meaning("of both", "s"),
        "word": Meaning("no unit"),
    }


def test_what_settings_print_is_read_back_with_every_value_on_a_line_of_its_own(tmp_path: Path) -> None:
    config = load_config(preset="video", sets=["enforce.style.toe_out={left: 5}"])
    text = as_yaml(config.stack())
    (tmp_path / "mine.yaml").write_text(text, encoding="utf-8")
    assert load_config(config=tmp_path / "mine.yaml").settings() == config.settings()
    assert text.count("  # preset video: ") == len(preset_changes("video"))


@pytest.mark.parametrize("name", presets())
def test_a_preset_changes_something_and_says_why(name: str) -> None:
    changes = preset_changes(name)
    assert preset_summary(name) and changes
    assert all(change.value != change.default and change.why for change in changes)
    assert {change.path for change in changes} == {path for path, _ in leaves(read_preset(name))}


def leaves(values: Any, prefix: str = "") -> list[tuple[str, Any]]:
    if not isinstance(values, dict):
        return [(prefix.rstrip("."), values)]
    return [leaf for key, value in values.items() for leaf in leaves(value, f"{prefix}{key}.")]

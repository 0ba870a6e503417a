"""Settings and presets as text: each value with its meaning, its unit and where it came from."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from footfix.config import preset_text, presets, read_preset
from footfix.meanings import Meaning, meanings
from footfix.settings import Layer, Settings, compose, flat, origins, plain

_COLUMN = 34  # where comments begin, if the value leaves room


@dataclass(frozen=True)
class Change:
    """What a preset sets, and why.

    Args:
        path: dotted name of the setting.
        value: in the preset.
        default: without it.
        why: the comment that stands beside it.
    """

    path: str
    value: Any
    default: Any
    why: str


def meanings_of(settings: Any, prefix: str = "") -> Iterator[tuple[str, Meaning]]:
    """List (dotted path, meaning) of every setting and every group of them, in the order of declaration."""
    said = meanings(type(settings))
    for each in dataclasses.fields(settings):
        value = getattr(settings, each.name)
        yield prefix + each.name, said.get(each.name, Meaning(""))
        if dataclasses.is_dataclass(value):
            yield from meanings_of(value, f"{prefix}{each.name}.")


def as_yaml(layers: Iterable[Layer]) -> str:
    """Write the settings that layers make as YAML that can be read back, each value with origin, meaning and unit."""
    layers = tuple(layers)
    came_from, settings = origins(layers), compose(layers)
    said = dict(meanings_of(settings))
    lines: list[str] = []
    open_groups: list[str] = []
    for path, value in flat(settings):
        *groups, name = path.split(".")
        shared = 0
        while shared < min(len(groups), len(open_groups)) and groups[shared] == open_groups[shared]:
            shared += 1
        for depth in range(shared, len(groups)):
            group = f"{'  ' * depth}{groups[depth]}:"
            lines.append(f"{group:<{_COLUMN}}  # {said['.'.join(groups[: depth + 1])]}")
        open_groups = groups
        text = f"{'  ' * len(groups)}{name}: {json.dumps(plain(value), ensure_ascii=False)}"  # JSON is YAML
        lines.append(f"{text:<{_COLUMN}}  # {came_from.get(path, 'default')}: {said[path]}")
    return "\n".join(lines) + "\n"


def preset_summary(name: str) -> str:
    """Say what clips a preset is for: the comment at its head, in one line."""
    head = []
    for line in preset_text(name).splitlines():
        if not line.startswith("#") or not line.strip("# "):
            break
        head.append(line.strip("# "))
    return " ".join(head)


def preset_changes(name: str) -> tuple[Change, ...]:
    """List what a preset sets, in its order, each with the comment beside it."""
    defaults = dict(flat(Settings()))
    values = dict(flat(compose([Layer(f"preset {name}", read_preset(name))])))
    why: dict[str, str] = {}
    groups: list[str] = []
    for line in preset_text(name).splitlines():
        text, _, comment = line.partition("#")
        key, colon, _ = text.partition(":")
        if colon:
            depth = (len(key) - len(key.lstrip())) // 2
            groups = [*groups[:depth], key.strip()]
            why[".".join(groups)] = comment.strip()
    return tuple(Change(path, values[path], defaults[path], why[path]) for path in why if path in values)


def describe_presets() -> str:
    """Describe all presets: what clips each is for, what it sets, and why."""
    lines = []
    for name in presets():
        lines.append(f"{name}: {preset_summary(name)}")
        for change in preset_changes(name):
            value, default = json.dumps(plain(change.value)), json.dumps(plain(change.default))
            otherwise = "found" if change.default is None else default
            lines.append(f"  {change.path}: {value}, not {otherwise}: {change.why}")
        lines.append("")
    return "\n".join(lines)

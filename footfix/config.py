"""Where settings come from: a preset, `footfix.yaml`, the command line; which hold for which file; and all as YAML."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath
from typing import Any, cast

from footfix.errors import UsageError
from footfix.settings import Layer, Meaning, Settings, compose, flat, meanings, origins, plain, suggest

CONFIG_NAME = "footfix.yaml"
_COLUMN = 34  # where comments begin in a listing, if the value leaves room
# A settings file is a page of text; this bounds what a hostile one can make the YAML reader do.
_MOST_BYTES, _MOST_EVENTS, _MOST_ALIASES = 1_000_000, 20_000, 20


@dataclass(frozen=True)
class Config:
    """All layers of a run, lowest first, and the overrides by file.

    Args:
        layers: preset, config file, command line.
        overrides: (glob, layer) from the config file; they lie over the file and under the command line.
        folder: the folder of the config file, which the globs are relative to.
    """

    layers: tuple[Layer, ...] = ()
    overrides: tuple[tuple[str, Layer], ...] = ()
    folder: Path | None = None

    def settings(self, path: Path | None = None) -> Settings:
        """Get the settings for one input, or for inputs that no override names."""
        return compose(self.stack(path))

    def stack(self, path: Path | None = None) -> tuple[Layer, ...]:
        """Get the layers that hold for one input, lowest first."""
        chosen = [layer for glob, layer in self.overrides if path is not None and self._matches(path, glob)]
        command_line = [layer for layer in self.layers if layer.origin.startswith("--")]
        below = [layer for layer in self.layers if not layer.origin.startswith("--")]
        return (*below, *chosen, *command_line)

    def _matches(self, path: Path, glob: str) -> bool:
        absolute = path.absolute()
        folder = (self.folder or Path.cwd()).absolute()
        try:
            name = PurePosixPath(absolute.relative_to(folder)).as_posix()
        except ValueError:
            name = absolute.as_posix()
        return fnmatchcase(name, glob) or ("/" not in glob and fnmatchcase(absolute.name, glob))


def load_config(
    *, config: Path | None = None, preset: str | None = None, sets: Iterable[str] = (), near: Path | None = None,
    command_line: Mapping[str, Any] | None = None,
) -> Config:  # fmt: skip
    """Read the config of a run.

    Args:
        config: a settings file; without one, `footfix.yaml` is looked for from `near` upward.
        preset: name of a packed preset; over the one that the file names.
        sets: "detect.method=auto" and the like.
        near: common parent of the inputs.
        command_line: values of options such as --method, nested by section.

    Raises:
        UsageError: unknown keys, values of the wrong kind, files that can't be read. Nothing has been done yet.
    """
    path = config if config is not None else _found_upward(near)
    document = _read(path) if path is not None else {}
    preset = preset or document.pop("preset", None)
    document.pop("preset", None)
    overrides = _overrides(document.pop("overrides", []), str(path))
    layers = []
    if preset is not None:
        layers.append(Layer(f"preset {preset}", read_preset(preset)))
    if path is not None:
        layers.append(Layer(str(path), document))
    if command_line:
        layers.append(Layer("--option", command_line))
    layers.extend(Layer("--set", _nested(text)) for text in sets)
    result = Config(tuple(layers), overrides, path.parent if path is not None else None)
    result.settings()  # so that a wrong key is said before any work
    for _, layer in overrides:
        compose((*result.layers, layer))
    return result


def presets() -> tuple[str, ...]:
    """List the names of the packed presets."""
    return tuple(sorted(path.name.removesuffix(".yaml") for path in _preset_folder() if path.name.endswith(".yaml")))


def preset_text(name: str) -> str:
    """Read the commented YAML of a preset.

    Raises:
        UsageError: there is none of that name.
    """
    for path in _preset_folder():
        if path.name == f"{name}.yaml":
            return str(path.read_text(encoding="utf-8"))
    raise UsageError(f"there is no preset {name!r}{suggest(name, presets())}")


def read_preset(name: str) -> dict[str, Any]:
    """Read the values of a preset."""
    return _parse(preset_text(name), f"preset {name}")


def _preset_folder() -> list[Any]:
    from importlib import resources

    return list(resources.files("footfix.configs").iterdir())


def _found_upward(near: Path | None) -> Path | None:
    if near is None:
        return None
    start = near.absolute()
    for folder in (start, *start.parents):
        candidate = folder / CONFIG_NAME
        if candidate.is_file():
            return candidate
    return None


def _read(path: Path) -> dict[str, Any]:
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise UsageError(f"{path}: too large for a settings file")
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{path}: can't be read as settings ({error})") from None
    return _parse(text, str(path))


def _parse(text: str, where: str) -> dict[str, Any]:
    import yaml

    try:
        # Aliases are counted before anything is built: a few lines of them can stand for gigabytes.
        aliases = 0
        for events, event in enumerate(yaml.parse(text, Loader=yaml.SafeLoader)):
            aliases += isinstance(event, yaml.AliasEvent)
            if events > _MOST_EVENTS or aliases > _MOST_ALIASES:
                raise UsageError(f"{where}: too many values or aliases for a settings file")
        document = yaml.safe_load(text)
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        place = getattr(error, "problem_mark", None)
        line = f":{place.line + 1}:{place.column + 1}" if place is not None else ""
        raise UsageError(f"{where}{line}: not valid YAML: {getattr(error, 'problem', None) or error}") from None
    if document is None:
        return {}
    if not isinstance(document, dict):
        raise UsageError(f"{where}: settings are a mapping of names to values")
    return {str(key): value for key, value in document.items()}


def _overrides(listed: Any, where: str) -> tuple[tuple[str, Layer], ...]:
    if isinstance(listed, dict):
        listed = [{"files": glob, **values} for glob, values in listed.items() if isinstance(values, dict)]
    if not isinstance(listed, list) or not all(isinstance(each, dict) and "files" in each for each in listed):
        raise UsageError(f"{where}: overrides is a list of mappings, each with `files: GLOB` and settings")
    found: list[tuple[str, Layer]] = []
    for entry in listed:
        values = {key: value for key, value in entry.items() if key != "files"}
        globs = entry["files"] if isinstance(entry["files"], list) else [entry["files"]]
        found.extend((str(glob), Layer(f"{where} (files: {glob})", values)) for glob in globs)
    return tuple(found)


def _nested(text: str) -> dict[str, Any]:
    path, equals, value = text.partition("=")
    if not equals or not path.strip():
        raise UsageError(f"--set takes NAME=VALUE, not {text!r}")
    import yaml

    try:
        parsed: Any = yaml.safe_load(value) if value.strip() else value
    except yaml.YAMLError:
        parsed = value
    return nested(path.strip(), parsed)


def nested(path: str, value: Any) -> dict[str, Any]:
    """Nest a value in groups by its dotted path: {"detect": {"method": "auto"}} of detect.method."""
    for key in reversed(path.split(".")):
        value = {key: value}
    return cast(dict[str, Any], value)


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

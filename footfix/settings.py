"""Settings: the parameters of all steps in one value, and the ways in: defaults, preset, config file, --set.

A default stands once, in the parameter class beside its mathematics; this module only walks those classes.
Each value remembers its origin, so that `footfix settings` can say where it came from.
"""

from __future__ import annotations

import dataclasses
import difflib
import types
import typing
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath
from typing import Any, Literal

from footfix.detect.run import DetectParams
from footfix.enforce.run import EnforceParams
from footfix.errors import UsageError
from footfix.formats.bvh import Limits
from footfix.motion.smoothing import SmoothParams
from footfix.rig.params import RigParams

CONFIG_NAME = "footfix.yaml"
# A settings file is a page of text; this bounds what a hostile one can make the YAML reader do.
_MOST_BYTES, _MOST_NODES = 1_000_000, 20_000


@dataclass(frozen=True, kw_only=True)
class ReportParams:
    """What is written beside the corrected clip.

    Args:
        kind: "html" (JSON and a page), "json", or "none".
        png: also draw a picture of the worst plants.
    """

    kind: Literal["none", "json", "html"] = "html"
    png: bool = False


@dataclass(frozen=True, kw_only=True)
class Settings:
    """The parameters of all steps.

    Args:
        rig: finding legs, soles, scale and floor, or being told them.
        smooth: the Savitzky-Golay filter.
        detect: finding contacts.
        enforce: holding them.
        report: what is written beside the clip.
        limits: how large an input may be.
        gates: measure -> the most it may be, for `footfix check`.
    """

    rig: RigParams = RigParams()
    smooth: SmoothParams = SmoothParams()
    detect: DetectParams = DetectParams()
    enforce: EnforceParams = EnforceParams()
    report: ReportParams = ReportParams()
    limits: Limits = Limits()
    gates: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Layer:
    """Values from one place, and where that is ("preset mocap", "footfix.yaml", "--set")."""

    origin: str
    values: Mapping[str, Any]


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
        """The settings for one input, or for inputs that no override names."""
        return compose(self.stack(path))

    def stack(self, path: Path | None = None) -> tuple[Layer, ...]:
        """The layers that hold for one input, lowest first."""
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
    """The config of a run.

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


def compose(layers: Iterable[Layer]) -> Settings:
    """The settings that layers make, each over the ones before it."""
    settings = Settings()
    for layer in layers:
        settings = _merge(settings, layer.values, layer.origin, "")
    return settings


def origins(layers: Iterable[Layer]) -> dict[str, str]:
    """For each dotted path that some layer sets, the origin of the value that holds."""
    found: dict[str, str] = {}
    for layer in layers:
        for path, _ in _leaves(Settings(), layer.values, ""):
            found[path] = layer.origin
    return found


def flat(settings: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """(dotted path, value) of every setting, in the order in which they are declared."""
    for each in dataclasses.fields(settings):
        value = getattr(settings, each.name)
        if dataclasses.is_dataclass(value):
            yield from flat(value, f"{prefix}{each.name}.")
        else:
            yield prefix + each.name, value


def plain(value: Any) -> Any:
    """Settings as nested plain values, for JSON and YAML."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {each.name: plain(getattr(value, each.name)) for each in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    return value


def presets() -> tuple[str, ...]:
    """The names of the packed presets."""
    return tuple(sorted(path.name.removesuffix(".yaml") for path in _preset_folder() if path.name.endswith(".yaml")))


def preset_text(name: str) -> str:
    """The commented YAML of a preset.

    Raises:
        UsageError: there is none of that name.
    """
    for path in _preset_folder():
        if path.name == f"{name}.yaml":
            return str(path.read_text(encoding="utf-8"))
    raise UsageError(f"there is no preset {name!r}{_suggest(name, presets())}")


def read_preset(name: str) -> dict[str, Any]:
    """The values of a preset."""
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
        nodes = aliases = 0
        for event in yaml.parse(text, Loader=yaml.SafeLoader):
            nodes += 1
            aliases += isinstance(event, yaml.AliasEvent)
            if nodes > _MOST_NODES or aliases > 100:
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
    found = []
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
    for key in reversed(path.strip().split(".")):
        parsed = {key: parsed}
    return typing.cast(dict[str, Any], parsed)


def _suggest(word: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return f"; did you mean {close[0]!r}?" if close else f"; known: {', '.join(known)}"


def _merge(current: Any, values: Any, origin: str, prefix: str) -> Any:
    """A parameter class with some of its values replaced; nested classes recursively."""
    if not isinstance(values, Mapping):
        raise UsageError(f"{origin}: {prefix.rstrip('.') or 'settings'} is a group of settings, not {values!r}")
    kinds = typing.get_type_hints(type(current))
    names = [each.name for each in dataclasses.fields(current)]
    changes = {}
    for key, value in values.items():
        if key not in names:
            raise UsageError(f"{origin}: unknown setting {prefix}{key}{_suggest(str(key), names)}")
        inner = getattr(current, key)
        if dataclasses.is_dataclass(inner):
            changes[key] = _merge(inner, value, origin, f"{prefix}{key}.")
        else:
            changes[key] = _convert(value, kinds[key], origin, f"{prefix}{key}")
    try:
        return dataclasses.replace(current, **changes)
    except (ValueError, UsageError) as error:
        raise UsageError(f"{origin}: {prefix.rstrip('.')}: {error}") from None


def _leaves(current: Any, values: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for key, value in values.items():
        inner = getattr(current, key)
        if dataclasses.is_dataclass(inner):
            yield from _leaves(inner, value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def _convert(value: Any, kind: Any, origin: str, path: str) -> Any:
    """A plain value as the type that a parameter declares."""
    shape, parts = typing.get_origin(kind), typing.get_args(kind)
    if shape in (typing.Union, types.UnionType):
        if value is None and type(None) in parts:
            return None
        failure: UsageError | None = None
        for part in parts:
            if part is not type(None):
                try:
                    return _convert(value, part, origin, path)
                except UsageError as error:
                    failure = failure or error
        raise failure or UsageError(f"{origin}: {path} can't be {value!r}")
    if shape is Literal:
        if value in parts:
            return value
        raise UsageError(f"{origin}: {path} can't be {value!r}{_suggest(str(value), [str(part) for part in parts])}")
    if isinstance(shape, type) and issubclass(shape, Mapping):
        if isinstance(value, Mapping):
            return {str(k): _convert(v, parts[1], origin, f"{path}.{k}") for k, v in value.items()}
    elif shape is tuple:
        if isinstance(value, (list, tuple)):
            inner = [parts[0]] * len(value) if len(parts) == 2 and parts[1] is Ellipsis else list(parts)
            if len(inner) == len(value):
                pairs = zip(value, inner, strict=True)
                return tuple(_convert(v, part, origin, f"{path}[{k}]") for k, (v, part) in enumerate(pairs))
    elif dataclasses.is_dataclass(kind) and isinstance(kind, type):
        return _build(kind, value, origin, path)
    elif kind is bool:
        if isinstance(value, bool):
            return value
    elif kind in (int, float):
        if isinstance(value, (int, float)) and not isinstance(value, bool) and value == value:
            if kind is float:
                return float(value)
            if int(value) == value:
                return int(value)
    elif kind is str and isinstance(value, (str, int, float)) and not isinstance(value, bool):
        return str(value)
    raise UsageError(f"{origin}: {path} must be {_words(kind)}, not {value!r}")


def _build(kind: type[Any], value: Any, origin: str, path: str) -> Any:
    """A value of a parameter class from a mapping that may leave out what has a default."""
    if not isinstance(value, Mapping):
        raise UsageError(f"{origin}: {path} is a group of settings, not {value!r}")
    kinds = typing.get_type_hints(kind)
    for key in value:
        if key not in kinds:
            raise UsageError(f"{origin}: unknown setting {path}.{key}{_suggest(str(key), list(kinds))}")
    given = {key: _convert(each, kinds[key], origin, f"{path}.{key}") for key, each in value.items()}
    try:
        return kind(**given)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{origin}: {path}: {error}") from None


def _words(kind: Any) -> str:
    names = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}
    if kind in names:
        return names[kind]
    shape = typing.get_origin(kind)
    if shape is tuple:
        return f"a list of {len(typing.get_args(kind))}" if Ellipsis not in typing.get_args(kind) else "a list"
    return "a mapping" if isinstance(shape, type) and issubclass(shape, Mapping) else str(kind)


def as_yaml(layers: Iterable[Layer]) -> str:
    """The settings that layers make as YAML that can be read back, each value with its origin."""
    import json

    layers = tuple(layers)
    came_from = origins(layers)
    lines: list[str] = []
    open_groups: list[str] = []
    for path, value in flat(compose(layers)):
        *groups, name = path.split(".")
        shared = 0
        while shared < min(len(groups), len(open_groups)) and groups[shared] == open_groups[shared]:
            shared += 1
        lines.extend(f"{'  ' * depth}{groups[depth]}:" for depth in range(shared, len(groups)))
        open_groups = groups
        text = json.dumps(plain(value), ensure_ascii=False)  # JSON is YAML
        lines.append(f"{'  ' * len(groups)}{name}: {text}  # {came_from.get(path, 'default')}")
    return "\n".join(lines) + "\n"

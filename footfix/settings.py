"""Settings: the parameters of all steps in one value, and how plain values become them.

A default stands once, in the parameter class beside its mathematics; this module only walks those classes.
Values come in layers, and each layer has an origin, so that `footfix settings` can say where a value came from.
What a field means is read from the docstring of its class, where it stands once: as `name: meaning [unit]` below
`Args:`; the unit may also come first, several names may share a line, and what goes on is indented further.
"""

from __future__ import annotations

import dataclasses
import difflib
import inspect
import re
import types
import typing
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from footfix.detect.run import DetectParams
from footfix.enforce.params import EnforceParams
from footfix.errors import UsageError
from footfix.formats.bvh.text import Limits
from footfix.locomotion.follow.params import FollowParams
from footfix.locomotion.loop.params import LoopParams
from footfix.motion.smoothing import SmoothParams
from footfix.rig.params import RigParams

_ENTRY = re.compile(r"( +)(\w+(?:, \w+)*): (.*)")
_UNIT = re.compile(r"\s*\[([^\]]+)\]")


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
        rig: finding legs, soles, scale and floor, or taking them as given.
        smooth: the Savitzky-Golay filter.
        detect: finding contacts.
        enforce: holding them.
        loop: cutting a seamless cycle out of a walk, and closing it.
        follow: leading walks along a path.
        report: what is written beside the clip.
        limits: how large an input may be.
        gates: measure -> the most it may be, for `footfix check`.
    """

    rig: RigParams = field(default_factory=RigParams)
    smooth: SmoothParams = field(default_factory=SmoothParams)
    detect: DetectParams = field(default_factory=DetectParams)
    enforce: EnforceParams = field(default_factory=EnforceParams)
    loop: LoopParams = field(default_factory=LoopParams)
    follow: FollowParams = field(default_factory=FollowParams)
    report: ReportParams = field(default_factory=ReportParams)
    limits: Limits = field(default_factory=Limits)
    gates: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Layer:
    """Values from one place, and where that is ("preset mocap", "footfix.yaml", "--set")."""

    origin: str
    values: Mapping[str, Any]


def compose(layers: Iterable[Layer]) -> Settings:
    """Compose the settings that layers make, each over the ones before it."""
    settings = Settings()
    for layer in layers:
        settings = _merge(settings, layer.values, layer.origin, "")
    return settings


def origins(layers: Iterable[Layer]) -> dict[str, str]:
    """Find for each dotted path that some layer sets the origin of the value that holds."""
    found: dict[str, str] = {}
    for layer in layers:
        for path, _ in _leaves(Settings(), layer.values, ""):
            found[path] = layer.origin
    return found


def flat(settings: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """List (dotted path, value) of every setting, in the order in which they are declared."""
    for each in dataclasses.fields(settings):
        value = getattr(settings, each.name)
        if dataclasses.is_dataclass(value):
            yield from flat(value, f"{prefix}{each.name}.")
        else:
            yield prefix + each.name, value


def plain(value: Any) -> Any:
    """Convert settings to nested plain values, for JSON and YAML."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {each.name: plain(getattr(value, each.name)) for each in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    return value


def suggest(word: str, known: Iterable[str]) -> str:
    """Write the end of a message about an unknown word: the nearest known one, or all of them."""
    close = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return f"; did you mean {close[0]!r}?" if close else f"; known: {', '.join(known)}"


def _merge(current: Any, values: Any, origin: str, prefix: str) -> Any:
    """Replace some values of a parameter class; nested classes recursively."""
    if not isinstance(values, Mapping):
        raise UsageError(f"{origin}: {prefix.rstrip('.') or 'settings'} is a group of settings, not {values!r}")
    kinds = typing.get_type_hints(type(current))
    names = [each.name for each in dataclasses.fields(current)]
    changes = {}
    for key, value in values.items():
        if key not in names:
            raise UsageError(f"{origin}: unknown setting {prefix}{key}{suggest(str(key), names)}")
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


_SCIENTIFIC = re.compile(r"[-+]?\d+(\.\d*)?[eE][-+]?\d+")


def _convert(value: Any, kind: Any, origin: str, path: str) -> Any:
    """Convert a plain value to the type that a parameter declares."""
    shape, parts = typing.get_origin(kind), typing.get_args(kind)
    if shape in (typing.Union, types.UnionType):
        if value is None and type(None) in parts:
            return None
        kinds = [part for part in parts if part is not type(None)]
        failures = []
        for part in kinds:
            try:
                return _convert(value, part, origin, path)
            except UsageError as error:
                failures.append(error)
        if len(failures) == 1:
            raise failures[0]
        raise UsageError(f"{origin}: {path} must be {' or '.join(map(_words, kinds))}, not {value!r}")
    if shape is Literal:
        if value in parts:
            return value
        raise UsageError(f"{origin}: {path} can't be {value!r}{suggest(str(value), [str(part) for part in parts])}")
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
        if isinstance(value, str) and _SCIENTIFIC.fullmatch(value):  # 2e-5 is a number to all but YAML 1.1
            value = float(value)
        if isinstance(value, (int, float)) and not isinstance(value, bool) and value == value:
            if kind is float:
                return float(value)
            if int(value) == value:
                return int(value)
    elif kind is str and isinstance(value, (str, int, float)) and not isinstance(value, bool):
        return str(value)
    raise UsageError(f"{origin}: {path} must be {_words(kind)}, not {value!r}")


def _build(kind: type[Any], value: Any, origin: str, path: str) -> Any:
    """Make a parameter class from a mapping that may leave out what has a default."""
    if not isinstance(value, Mapping):
        raise UsageError(f"{origin}: {path} is a group of settings, not {value!r}")
    kinds = typing.get_type_hints(kind)
    for key in value:
        if key not in kinds:
            raise UsageError(f"{origin}: unknown setting {path}.{key}{suggest(str(key), list(kinds))}")
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
    if shape is Literal:
        return " or ".join(repr(part) for part in typing.get_args(kind))
    if shape is tuple:
        return f"a list of {len(typing.get_args(kind))}" if Ellipsis not in typing.get_args(kind) else "a list"
    return "a mapping" if isinstance(shape, type) and issubclass(shape, Mapping) else str(kind)


@dataclass(frozen=True)
class Meaning:
    """What a field is.

    Args:
        text: in one line, without a full stop.
        unit: "" where it has none, as a name or a choice.
    """

    text: str
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.text} [{self.unit}]" if self.unit else self.text


def meanings(kind: type[Any]) -> dict[str, Meaning]:
    """Read the meaning of each field of a dataclass that its docstring names, in the order of the fields.

    Args:
        kind: the class.
    """
    said: dict[str, str] = {}
    names: list[str] = []
    depth = 0
    _, _, listed = inspect.cleandoc(kind.__doc__ or "").partition("\nArgs:\n")
    for line in listed.splitlines():
        entry = _ENTRY.fullmatch(line)
        indent = len(line) - len(line.lstrip())
        if not line.strip() or indent == 0:
            break
        if entry and (not names or indent <= depth):
            names, depth = entry[2].split(", "), indent
            said.update(dict.fromkeys(names, entry[3]))
        else:
            said.update({name: f"{said[name]} {line.strip()}" for name in names})
    return {each.name: _meaning(said[each.name]) for each in dataclasses.fields(kind) if each.name in said}


def _meaning(text: str) -> Meaning:
    unit = _UNIT.search(text)
    return Meaning(_UNIT.sub("", text, count=1).strip().rstrip("."), unit[1] if unit else "")

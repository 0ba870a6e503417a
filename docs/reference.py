"""Pages of the reference, generated: commands from click, settings and measures from docstrings, files from schemas.

python docs/reference.py  lists settings and measures that have no word of explanation, and fails where there are any.
"""

from __future__ import annotations

import ast
import dataclasses
import inspect
import json
import re
import sys
import textwrap
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import resources
from typing import Any, get_args, get_origin, get_type_hints

import click

import footfix
from footfix import config
from footfix.cli import COMMANDS, cli
from footfix.measure.clip import Measures
from footfix.measure.plants import PlantMeasure
from footfix.settings import Settings, plain

_NAMED = re.compile(r"^([a-z_0-9]+(?:, [a-z_0-9]+)*): (.*)$")


_COMMANDS = """# Commands

Every command takes files, folders (all clips below them) or `-` for standard input. Exit codes: 0 done, 1 `check` found
a clip over a gate, 2 wrong usage, 3 some input failed and the others are done, 4 a bug of footfix, 130 interrupted.
"""
_SETTINGS = """# Settings

Every setting may stand in `footfix.yaml` (looked for from the inputs upward), in a file named by `--config`, in a
[preset](presets.md), or after `--set`: `--set enforce.costs.slide=20000`. From Python:
`footfix.make_settings(preset, {"enforce.costs.slide": 20000})`. `footfix settings` prints those that hold, and where
each comes from.

Times are in seconds and lengths in leg lengths, whatever the frame rate and the unit of the file.
"""
_MEASURES = """# Measures

Each stands in reports under `before` and `after`, and may be a gate: `footfix check clips --max slide_mm=21`.
[How they are measured](../how/measure.md) has the formulas.

| Measure | Meaning |
|---|---|"""
_SCHEMAS = """# Files and schemas

Everything written for programs has a JSON schema, installed with footfix in `footfix/report/schemas`. Numbers carry
their unit in their name. Frames are counted from 0; `end` is the first frame after a stretch.
"""
_INTERFACE = """# Python

`import footfix` has all of these names. Positions in a `Clip` are parent-local, in metres, y up; rotations are unit
quaternions xyzw. What can't be what is meant is refused with an `ArgumentError` that says what is wanted.
`HUMANML3D_PARENTS` and `HUMANML3D_NAMES` are the tree and the names of HumanML3D's 22 joints.
"""


def pages() -> dict[str, str]:
    """All generated pages, by their path below docs/."""
    return {
        "reference/commands.md": commands(),
        "reference/settings.md": settings(),
        "reference/presets.md": presets(),
        "reference/measures.md": measures(),
        "reference/files.md": files(),
        "reference/python.md": python(),
    }


# ---- what docstrings and comments say ----------------------------------------------------------------


@cache
def meanings(kind: type[Any]) -> dict[str, str]:
    """What the docstring of a class says of its fields, or the comments beside them do.

    Args:
        kind: a dataclass.
    """
    found = _beside(kind)
    for names, text in _listed(inspect.getdoc(kind) or ""):
        for name in names:
            found[name] = text
    return found


def _listed(doc: str) -> Iterator[tuple[list[str], str]]:
    """Names and text of each entry below `Args:`."""
    _, _, listed = doc.partition("Args:\n")
    listed = listed.partition("\n\n")[0]
    for entry in re.split(r"\n(?=    \S)", listed):
        match = _NAMED.match(" ".join(entry.split()))
        if match:
            yield match[1].split(", "), match[2]


def _beside(kind: type[Any]) -> dict[str, str]:
    """The comments that stand beside fields, or below them where the line was full."""
    source = textwrap.dedent(inspect.getsource(kind))
    lines = source.splitlines()
    found: dict[str, str] = {}
    body = ast.parse(source).body[0]
    assert isinstance(body, ast.ClassDef)
    for node in body.body:
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.end_lineno is not None:
            after = [lines[node.end_lineno - 1][node.end_col_offset or 0 :]]
            for line in lines[node.end_lineno :]:
                if not line.strip().startswith("#"):
                    break
                after.append(line)
            said = " ".join(part.partition("#")[2].partition("type: ignore")[0].strip() for part in after).strip()
            if said:
                found[node.target.id] = said
    return found


def _escaped(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*").replace("[", "\\[")


# ---- commands ----------------------------------------------------------------------------------------


def commands() -> str:
    """The page of all commands, as click has them."""
    parts = [_COMMANDS]
    context = click.Context(cli, info_name="footfix")
    for name in COMMANDS:
        command = cli.get_command(context, name)
        assert command is not None
        with click.Context(command, info_name=f"footfix {name}") as inner:
            usage = command.get_usage(inner).removeprefix("Usage: ")
            told = inspect.cleandoc(command.help or "").replace("\b", "")
            parts += [f"## {name}\n", f"```text\n{usage}\n```\n", told + "\n", "| Option | |\n|---|---|"]
            for parameter in command.get_params(inner):
                record = parameter.get_help_record(inner)
                if record is not None and isinstance(parameter, click.Option):
                    parts.append(f"| `{record[0]}` | {_escaped(record[1])} |")
            parts.append("")
            for sub, inner_command in getattr(command, "commands", {}).items():
                parts += _subcommand(f"footfix {name} {sub}", inner_command)
    return "\n".join(parts)


def _subcommand(name: str, command: click.Command) -> list[str]:
    """The part on a command of a command."""
    with click.Context(command, info_name=name) as context:
        usage = command.get_usage(context).removeprefix("Usage: ")
        told = inspect.cleandoc(command.help or "").replace("\b", "")
        heading = name.removeprefix("footfix ")
        parts = [f"### {heading}\n", f"```text\n{usage}\n```\n", told + "\n", "| Option | |\n|---|---|"]
        for parameter in command.get_params(context):
            record = parameter.get_help_record(context)
            if record is not None and isinstance(parameter, click.Option):
                parts.append(f"| `{record[0]}` | {_escaped(record[1])} |")
    return [*parts, ""]


# ---- settings ----------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Setting:
    """One setting: its dotted name, the kind of values, its default, what it means, and who declares it."""

    path: str
    kind: str
    default: str
    meaning: str
    home: str


def all_settings(kind: type = Settings, value: Any = None, prefix: str = "") -> Iterator[Setting]:
    """Every setting, in the order in which they are declared."""
    value = Settings() if value is None else value
    kinds, known = get_type_hints(kind), meanings(kind)
    for each in dataclasses.fields(kind):
        inner, path = getattr(value, each.name), f"{prefix}{each.name}"
        if dataclasses.is_dataclass(inner):
            yield from all_settings(type(inner), inner, f"{path}.")
        else:
            default = json.dumps(plain(inner), ensure_ascii=False)
            yield Setting(path, _kind(kinds[each.name]), default, known.get(each.name, ""), kind.__name__)


def _kind(kind: Any) -> str:
    """A type in words."""
    words = {float: "number", int: "whole number", bool: "true or false", str: "text", type(None): "null"}
    if kind in words:
        return words[kind]
    if get_origin(kind) is not None and str(get_origin(kind)).endswith("Literal"):
        return " or ".join(str(each) for each in get_args(kind))
    if isinstance(get_origin(kind), type) and issubclass(get_origin(kind), Mapping):
        return "mapping"
    if get_origin(kind) is tuple:
        return f"list of {len(get_args(kind))}"
    if get_args(kind):
        return " or ".join(_kind(each) for each in get_args(kind) if each is not type(None))
    return str(getattr(kind, "__name__", kind))


def settings() -> str:
    """The page of all settings, by group."""
    parts = [_SETTINGS]
    group = ""
    for each in all_settings():
        above, _, name = each.path.rpartition(".")
        if above != group:
            group = above
            parts.append(f"\n## {above or 'gates'}\n\n| Setting | Default | Values | Meaning |\n|---|---|---|---|")
        parts.append(f"| `{name}` | `{each.default}` | {_escaped(each.kind)} | {_escaped(each.meaning)} |")
    return "\n".join(parts) + "\n"


def presets() -> str:
    """The page of presets: what each is for, as its own file says."""
    parts = ["# Presets\n\n`footfix clean --preset NAME`, or `preset: NAME` in `footfix.yaml`.\n"]
    for name in config.presets():
        text = config.preset_text(name)
        purpose = [line.lstrip("# ") for line in text.splitlines() if line.startswith("# ")]
        parts.append(f"## {name}\n\n{purpose[0] if purpose else ''}\n\n```yaml\n{text}```\n")
    return "\n".join(parts)


# ---- measures and files ------------------------------------------------------------------------------


def measures() -> str:
    """The page of measures: each a column of reports, and a name that `check --max` takes."""
    known = meanings(Measures)
    parts = [_MEASURES]
    parts += [f"| `{each.name}` | {_escaped(known.get(each.name, ''))} |" for each in dataclasses.fields(Measures)]
    return "\n".join(parts) + "\n"


_FILES = {
    "contacts": "Contacts: `NAME.contacts.json`",
    "report": "Report: `NAME.report.json`",
    "summary": "Summary of a run: `summary.json`",
    "check": "What `footfix check --json` prints",
    "inspect": "What `footfix inspect --json` prints",
    "run": "What `footfix clean --json` prints",
    "events": "Strikes and lifts: `NAME.events.json`",
}


def files() -> str:
    """The page of files: every field of every schema."""
    parts = [_SCHEMAS]
    for path in sorted(resources.files("footfix.report.schemas").iterdir(), key=lambda path: path.name):
        if path.name.endswith(".json"):
            schema = json.loads(path.read_text(encoding="utf-8"))
            title = _FILES.get(path.name.partition(".")[0], path.name)
            parts += [f"## {title}\n", f"{schema.get('description', '')}\n", f"Schema: `{path.name}`\n"]
            parts.append("| Field | Kind | Meaning |\n|---|---|---|")
            parts += [f"| `{name}` | {kind} | {_escaped(text)} |" for name, kind, text in _fields(schema, schema, "")]
            parts.append("")
    return "\n".join(parts)


def _fields(schema: Mapping[str, Any], whole: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, str, str]]:
    """The fields of a schema, nested ones by dotted names."""
    schema = _resolved(schema, whole)
    for name, given in schema.get("properties", {}).items():
        inner = _resolved(given, whole)
        told = given.get("description") or inner.get("description") or _measured(name)
        yield prefix + name, _json_kind(inner), str(told)
        yield from _fields(inner, whole, f"{prefix}{name}.")
        if isinstance(inner.get("items"), dict):
            yield from _fields(inner["items"], whole, f"{prefix}{name}[].")


def _measured(name: str) -> str:
    """What a field named for a measure holds, by the docstring of that measure."""
    known = {**meanings(PlantMeasure), **meanings(Measures)}
    when = next((each for each in ("before", "after") if f"_{each}_" in name), "")
    told = known.get(name.replace(f"_{when}_", "_"), "") if when else known.get(name, "")
    return f"{told.rstrip('.')} ({when})" if told and when else told


def _resolved(schema: Mapping[str, Any], whole: Mapping[str, Any]) -> Mapping[str, Any]:
    """What a `$ref` within the same schema stands for."""
    ref = schema.get("$ref")
    if not isinstance(ref, str) or not ref.startswith("#/"):
        return schema
    found: Any = whole
    for key in ref[2:].split("/"):
        found = found[key]
    return _resolved(found, whole)


def _json_kind(schema: Mapping[str, Any]) -> str:
    if "const" in schema:
        return f"`{json.dumps(schema['const'])}`"
    if "enum" in schema:
        return " or ".join(f"`{each}`" for each in schema["enum"])
    kind = schema.get("type", "")
    return " or ".join(kind) if isinstance(kind, list) else str(kind)


# ---- Python ------------------------------------------------------------------------------------------

_PYTHON = {
    "Files": "load animations save Document clean_file Outputs",
    "Clips": "Clip Skeleton global_positions",
    "Legs and soles": "find_rig find_rigs Rig Leg SolePoint RigParams",
    "Contacts": "detect Contacts Effector Contact load_contacts save_contacts",
    "Cleaning": "clean clean_figures Result Correction apply Footplant Note",
    "Loops": "loop Loop",
    "Live figures": "Stream",
    "Paths": "follow Follow",
    "Cycles": "fit_cycles load_model save_model Engine Frame Ahead",
    "Joint positions": "clean_positions CleanedPositions",
    "Measuring": "measure Measures PlantMeasure skating_ratio weighted_skate physdiff PhysDiff jitter slides",
    "Settings": "make_settings presets Settings",
    "Reports": "make_report make_page summarize",
    "Errors": "FootfixError ArgumentError InputError NoLegsError OutputError UsageError",
}
_PLAIN = {"HUMANML3D_NAMES", "HUMANML3D_PARENTS", "__version__"}


def python() -> str:
    """The page of the Python interface, by what it is for."""
    listed = {name for names in _PYTHON.values() for name in names.split()}
    missing = set(footfix.__all__) - listed - _PLAIN
    if missing:
        raise ValueError(f"docs/reference.py leaves out public names: {', '.join(sorted(missing))}")
    with_members = {"Clip": ["fps", "frames"], "Contacts": ["mask", "only", "with_mask"], "Rig": ["no_contacts"],
                    "Engine": ["set", "step", "ahead", "clip"]}  # fmt: skip
    parts = [_INTERFACE]
    for title, names in _PYTHON.items():
        parts.append(f"## {title}\n")
        for name in names.split():
            home = footfix._HOME[name]
            parts.append(f"::: {home}.{name}")
            if name in with_members:
                parts.append(f"    options:\n      members: [{', '.join(with_members[name])}]")
            parts.append("")
    return "\n".join(parts)


def main() -> int:
    """List what has no word of explanation; 1 where there is any."""
    known = meanings(Measures)
    mute = [each.path for each in all_settings() if not each.meaning]
    mute += [each.name for each in dataclasses.fields(Measures) if not known.get(each.name)]
    for name in mute:
        print(f"{name}: not explained")
    return 1 if mute else 0


if __name__ == "__main__":
    sys.exit(main())

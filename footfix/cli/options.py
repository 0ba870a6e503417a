"""Options that several commands share, gathered as values."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import click

from footfix.rig.params import NO_SKIN

Command = TypeVar("Command", bound=Callable[..., Any])


@dataclass(frozen=True)
class Common:
    """Options of every command on clips.

    Args:
        config: a settings file.
        preset: name of a packed preset.
        sets: "detect.method=auto" and the like.
        as_json: one JSON document on stdout.
        quiet, verbose: how much is printed.
    """

    config: Path | None
    preset: str | None
    sets: tuple[str, ...]
    as_json: bool
    quiet: bool
    verbose: bool


def _presets(context: click.Context, option: click.Parameter, begun: str) -> list[str]:
    """List the presets whose names begin so, for the completion of a shell."""
    from footfix.config import presets

    return [name for name in presets() if name.startswith(begun)]


def shared(command: Command) -> Command:
    """Add the options that every command on clips takes; they arrive together as `common: Common`."""
    return _gathered(
        command, Common, "common",
        click.option("--config", type=click.Path(exists=True, dir_okay=False, path_type=Path),
                     help="Settings file; without it footfix.yaml is looked for from the inputs upward."),
        click.option("--preset", metavar="NAME", shell_complete=_presets,
                     help="Packed settings: animals, game-retarget, ml-generated, mocap, video; "
                     "`footfix settings --presets` explains them."),
        click.option("--set", "sets", multiple=True, metavar="NAME=VALUE",
                     help="One setting, such as detect.method=threshold. May be repeated."),
        click.option("--json", "as_json", is_flag=True, help="One JSON document on stdout."),
        click.option("-q", "--quiet", is_flag=True, help="Only errors."),
        click.option("-v", "--verbose", is_flag=True, help="All measures and notes."),
    )  # fmt: skip


@dataclass(frozen=True)
class Given:
    """Contacts and soles given by the user.

    Args:
        labels: a label file, or a folder of them; None for none.
        order: effector names of the columns of an array, () for the default ones.
        skin: a character from whose mesh the soles are taken, or "none"; None where nothing was said.
    """

    labels: Path | None = None
    order: tuple[str, ...] = ()
    skin: str | None = None


def given(purpose: str) -> Callable[[Command], Command]:
    """Add the options for what is given, contacts for a purpose in words; they arrive together as `given: Given`."""

    def decorate(command: Command) -> Command:
        return _gathered(
            command, Given, "given",
            click.option("--labels", type=click.Path(exists=True, path_type=Path),
                         help=f"{purpose}: JSON, CSV, NPZ or NPY, or a folder with a file for each clip."),
            click.option("--order", default="", metavar="NAMES", callback=_order,
                         help="Effectors of the columns of an array, left to right; by default "
                         "left_heel,left_toe,right_heel,right_toe, as HumanML3D and LAFAN1 have them."),
            click.option("--skin", metavar="CHARACTER", callback=_character,
                         help="Take the soles from the mesh of this character: .glb, .gltf or .vrm; a glTF clip takes "
                         "its own by default; none estimates them (rig.skin)."),
        )  # fmt: skip

    return decorate


def _character(context: click.Context, option: click.Parameter, value: str | None) -> str | None:
    if value is None or value == NO_SKIN:
        return value
    return str(click.Path(exists=True, dir_okay=False).convert(value, option, context))


def _order(context: click.Context, option: click.Parameter, value: str) -> tuple[str, ...]:
    if not value:
        return ()
    from footfix.formats.contacts import order_from

    return order_from(value)


@dataclass(frozen=True)
class Writing:
    """How the clips of a run are written and its failures printed.

    Args:
        dry_run: whether nothing is written.
        force: whether existing outputs are overwritten.
        resume: whether clips that are done are skipped.
        junit: path of a JUnit XML file with the results; None for none.
        style: how failures are printed, "text" or "github".
    """

    dry_run: bool = False
    force: bool = False
    resume: bool = False
    junit: Path | None = None
    style: str = "text"


def writing(command: Command) -> Command:
    """Add the options of commands that make a clip of each clip; they arrive together as `writing: Writing`."""
    return _gathered(
        command, Writing, "writing",
        click.option("--dry-run", is_flag=True, help="Do everything but write."),
        click.option("--force", is_flag=True, help="Overwrite existing outputs."),
        click.option("--resume", is_flag=True, help="Continue an interrupted run: skip what is done already."),
        click.option("--junit", type=click.Path(dir_okay=False, path_type=Path),
                     help="Write the results as JUnit XML."),
        click.option("--format", "style", type=click.Choice(["text", "github"]), default="text", show_default=True,
                     help="How failures are printed."),
    )  # fmt: skip


@dataclass(frozen=True)
class Many:
    """Which inputs, and on which processes.

    Args:
        from_file: lists of inputs.
        include, exclude: globs that choose among the files in folders.
        animation: names of the clips to take from files that hold several; empty for all.
        shard: (part, parts), part from 1; None for all.
        jobs: processes; 0 to choose by the number of clips.
        timeout: [s] for one clip.
        dask: address of a scheduler; "" for this machine.
    """

    from_file: tuple[str, ...] = ()
    include: tuple[str, ...] = ()
    exclude: tuple[str, ...] = ()
    animation: tuple[str, ...] = ()
    shard: tuple[int, int] | None = None
    jobs: int = 0
    timeout: float | None = None
    dask: str = ""

    @property
    def tag(self) -> str:
        """Make the part of file names that tells this shard of a run from the others."""
        return "run" if self.shard is None else f"{self.shard[0]}-of-{self.shard[1]}"

    def named(self, stem: str, suffix: str) -> str:
        """Name a file of the whole run."""
        return f"{stem}{suffix}" if self.shard is None else f"{stem}.{self.tag}{suffix}"


def many(command: Command) -> Command:
    """Add the options of commands that do many clips; they arrive together as `many: Many`."""
    return _gathered(
        command, Many, "many",
        click.option("--from-file", multiple=True, metavar="LIST", help="Inputs, one a line; - for standard input."),
        click.option("--include", multiple=True, metavar="GLOB", help="Of folders, only files that match."),
        click.option("--exclude", multiple=True, metavar="GLOB", help="Of folders, no files that match."),
        click.option("--animation", multiple=True, metavar="NAME",
                     help="Of glTF files only this animation; file.glb#NAME means the same. May be repeated."),
        click.option("--shard", metavar="PART/PARTS", callback=_shard,
                     help="Only this part of the inputs, such as 3/16, for job arrays."),
        click.option("-j", "--jobs", type=click.IntRange(0), default=0, metavar="N",
                     help="Processes; by default one a processor, where that pays."),
        click.option("--timeout", type=click.FloatRange(min=0.0, min_open=True), metavar="SECONDS",
                     help="Give a clip up after this long."),
        click.option("--dask", default="", metavar="ADDRESS",
                     help="Work on this Dask cluster; its machines see the same paths."),
    )  # fmt: skip


def _shard(context: click.Context, option: click.Parameter, value: str | None) -> tuple[int, int] | None:
    if value is None:
        return None
    found = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", value.strip())
    if not found or not 1 <= int(found[1]) <= int(found[2]):
        raise click.BadParameter(f"{value!r} is not PART/PARTS, such as 3/16", context, option)
    return int(found[1]), int(found[2])


def _gathered(command: Command, kind: type[Any], key: str, *options: Callable[[Any], Any]) -> Command:
    """Add options to a command, which it receives as one value."""
    names = [each.name for each in fields(kind)]

    @wraps(command)
    def call(**given: Any) -> Any:
        values = {name: given.pop(name) for name in names}
        return command(**given, **{key: kind(**values)})

    decorated: Any = call
    for option in reversed(options):
        decorated = option(decorated)
    return cast(Command, decorated)

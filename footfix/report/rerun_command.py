"""The command that cleans a clip again from contacts that a person has edited."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from footfix.settings import Settings, flat, plain

_NOT_REPEATED = ("follow", "gates", "limits", "loop", "report")  # settings without effect on how a clip is cleaned


@dataclass(frozen=True)
class RerunCommand:
    """How to clean a clip again after its contacts were edited.

    Args:
        contacts: name of the contacts file, beside the page, to replace by the edited one.
        command: the command to type in the folder of the page, quoted for a shell.
    """

    contacts: str
    command: str


def clean_again(
    source: Path, target: Path, contacts: Path, settings: Settings, *, several: bool = False
) -> RerunCommand:  # fmt: skip
    """Write the command that cleans a clip again, to be typed in the folder of its contacts file and its page.

    All its paths are relative, so that it still works when clip and outputs are moved together.

    Args:
        source: path of the clip.
        target: path of the corrected clip.
        contacts: path of the contacts file.
        settings: those that the clip was cleaned with; what differs from the defaults is repeated.
        several: whether the file holds several clips: all are cleaned again, each from its contacts file in the folder.
    """
    folder = contacts.parent
    words = ["footfix", "clean", _seen_from(folder, source), *_where(folder, source, target)]
    defaults = dict(flat(Settings()))
    for path, value in flat(settings):
        if path.split(".")[0] not in _NOT_REPEATED and value != defaults[path]:
            words += ["--set", f"{path}={json.dumps(plain(value), ensure_ascii=False)}"]
    words += ["--labels", "." if several else contacts.name, "--force"]
    return RerunCommand(contacts.name, quoted(words))


def clean_loop_again(target: Path, contacts: Path, settings: Settings, *, several: bool = False) -> RerunCommand:
    """Write the command that cleans a loop again from its edited contacts, into a folder beside it.

    Args:
        target: path of the loop.
        contacts: path of its contacts file.
        settings: those that it was made with.
        several: whether its file holds several clips.
    """
    return clean_again(target, target.parent / "cleaned" / target.name, contacts, settings, several=several)


def _seen_from(folder: Path, path: Path) -> str:
    """Make a path relative to a folder; unchanged where they are on different drives."""
    try:
        return os.path.relpath(path, folder)
    except ValueError:
        return str(path)


def _where(folder: Path, source: Path, target: Path) -> list[str]:
    """List the options that write the corrected clip to the same path as before."""
    if os.path.realpath(source) == os.path.realpath(target):
        return ["--in-place"]
    if target.name == source.name:
        return ["-o", _seen_from(folder, target.parent)]
    beside = target.parent.resolve() == source.parent.resolve()
    return [] if beside else ["-o", _seen_from(folder, target)]


def quoted(words: Sequence[str]) -> str:
    """Join words to one line for the shell of this system."""
    return subprocess.list2cmdline(words) if os.name == "nt" else shlex.join(words)

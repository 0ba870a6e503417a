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

_NOT_REPEATED = ("gates", "limits", "report")  # they change nothing of how a clip is cleaned


@dataclass(frozen=True)
class Again:
    """How a clip is cleaned again.

    Args:
        contacts: path of the contacts file that the edited one takes the place of.
        command: what to type, quoted for a shell.
    """

    contacts: str
    command: str


def clean_again(source: str, target: Path, contacts: Path, settings: Settings) -> Again:
    """The command that cleans a clip again, run from the same folder as the first time.

    Args:
        source: path of the clip, as it was named.
        target: path of the corrected clip.
        contacts: path of the contacts file.
        settings: those that held; what differs from the defaults is repeated.
    """
    words = ["footfix", "clean", source, *_where(Path(source), target)]
    defaults = dict(flat(Settings()))
    for path, value in flat(settings):
        if path.split(".")[0] not in _NOT_REPEATED and value != defaults[path]:
            words += ["--set", f"{path}={json.dumps(plain(value), ensure_ascii=False)}"]
    words += ["--labels", str(contacts), "--force"]
    return Again(str(contacts), quoted(words))


def _where(source: Path, target: Path) -> list[str]:
    """The options that make the corrected clip land where it did."""
    if os.path.realpath(source) == os.path.realpath(target):
        return ["--in-place"]
    if target.name == source.name:
        return ["-o", str(target.parent)]
    return [] if target.parent == source.parent else ["-o", str(target)]


def quoted(words: Sequence[str]) -> str:
    """Words as one line for the shell of this system."""
    return subprocess.list2cmdline(words) if os.name == "nt" else shlex.join(words)

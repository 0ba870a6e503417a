"""The inputs of a command: files, folders, lists and globs of the command line."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from footfix.batch.file_io import STDIN, read_whole
from footfix.errors import UsageError
from footfix.formats.suffixes import STDIN_NAME, in_file, is_cleaned, is_motion

# Every folder of outputs has a folder of this name, with the journal of the run that wrote them.
MARK = ".footfix"

_MOST_LIST_BYTES = 1 << 28


@dataclass(frozen=True)
class Source:
    """An input, and its path below the folder given on the command line.

    Args:
        path: the file, or "-" for standard input.
        below: its path relative to the folder that was given; only its name for a file that was given.
        clip: the name of the clip to take from a file that holds several; "" for all.
    """

    path: str
    below: Path
    clip: str = ""


def sources(
    named: Iterable[str], *, lists: Iterable[str] = (), include: Sequence[str] = (), exclude: Sequence[str] = (),
    leave_out: Path | None = None, own_outputs: bool = False,
) -> tuple[Source, ...]:  # fmt: skip
    """List the inputs that files, folders, lists and "-" stand for.

    A folder stands for its motion files, sorted, at any depth, with endings of any case; hidden files and those that
    footfix wrote are left out. Globs choose among files in folders: they are matched against the path below the folder
    (`*` also matches slashes), and those without a slash also against the name.

    Args:
        named: files, folders and "-".
        lists: files that name one input a line; "-" for standard input.
        include: only files that match one of these.
        exclude: no file that matches one of these.
        leave_out: the folder of the outputs of this run.
        own_outputs: True to include cleaned copies and folders of outputs.

    Raises:
        UsageError: an input does not exist, or none is left.
    """
    wanted = _chooser(include, exclude)
    found: dict[str, Source] = {}  # by absolute path: a clip that is given twice is one input

    def add(path: str, below: Path, clip: str = "") -> None:
        key = path if path == STDIN else os.path.normpath(Path.cwd() / path) + clip
        found.setdefault(key, Source(path, below, clip))

    for name in named:
        path = Path(name)
        if name == STDIN:
            add(name, Path(STDIN_NAME))
        elif path.is_dir():
            below = [each for each in _walk(path, leave_out, own_outputs) if wanted(each.relative_to(path))]
            if not below:
                chosen = " that --include and --exclude leave" if include or exclude else ""
                raise UsageError(f"{name}: no files of motion in this folder{chosen}")
            for each in below:
                add(str(each), each.relative_to(path))
        elif path.exists():
            add(name, Path(path.name))
        elif in_file(name)[1] and Path(in_file(name)[0]).is_file():
            file, clip = in_file(name)
            add(file, Path(Path(file).name), clip)
        else:
            raise UsageError(f"{name}: no such file or folder")
    for path_listed, below_here in (each for name in lists for each in _listed(name)):
        add(path_listed, below_here)
    if not found:
        raise UsageError("nothing to do: name a file of motion, a folder, or - for standard input")
    return tuple(found.values())


def shard(found: Sequence[Source], part: int, parts: int) -> tuple[Source, ...]:
    """Take part `part` (1 to `parts`) of the inputs: every `parts`-th one, so that all parts are alike."""
    return tuple(found[part - 1 :: parts])


def _chooser(include: Sequence[str], exclude: Sequence[str]) -> Callable[[Path], bool]:
    def matches(path: Path, glob: str) -> bool:
        return fnmatchcase(path.as_posix(), glob) or ("/" not in glob and fnmatchcase(path.name, glob))

    def wanted(path: Path) -> bool:
        chosen = not include or any(matches(path, glob) for glob in include)
        return chosen and not any(matches(path, glob) for glob in exclude)

    return wanted


def _walk(folder: Path, leave_out: Path | None, own_outputs: bool) -> Iterator[Path]:
    avoided = None if leave_out is None else os.path.realpath(leave_out)
    for root, folders, files in os.walk(folder):
        if not own_outputs and Path(root) != folder and MARK in folders:
            folders.clear()
            continue
        folders[:] = sorted(
            each for each in folders
            if not each.startswith(".") and (avoided is None or os.path.realpath(Path(root, each)) != avoided)
        )  # fmt: skip
        for name in sorted(files):
            ours = is_cleaned(name) and not own_outputs  # a cleaned copy in a folder is no input
            if is_motion(name) and not ours and not name.startswith("."):
                yield Path(root) / name


def _listed(name: str) -> Iterator[tuple[str, Path]]:
    """Read a list of inputs: one a line, or separated by NUL bytes, without blank lines and # comments."""
    data = read_whole(name, _MOST_LIST_BYTES)
    lines = data.split(b"\0") if b"\0" in data else data.removeprefix(b"\xef\xbb\xbf").splitlines()
    for number, line in enumerate(lines, start=1):
        entry = os.fsdecode(line)
        if b"\0" not in data:
            entry = entry.strip()
            if entry.startswith("#"):
                continue
        if not entry:
            continue
        if not Path(entry).is_file():
            raise UsageError(f"{name}:{number}: {entry}: no such file")
        yield entry, _within_here(entry)


def _within_here(entry: str) -> Path:
    """Choose the path of a listed file's outputs below the output folder: its relative path, or its name if outside."""
    path = Path(os.path.normpath(Path.cwd() / entry))
    try:
        return path.relative_to(Path.cwd())
    except ValueError:
        return Path(path.name)

"""What a run has begun and done, line by line, so that an interrupted one can go on where it was.

A clip is done when its report lies there with the right fingerprint; the journal is asked only whether outputs that
are in the way are ours to overwrite, and keeps what the index shows. Its last line may be torn: it is left out.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from footfix.batch.clips import named
from footfix.batch.files import write_whole
from footfix.batch.inputs import MARK
from footfix.batch.task import FileResult
from footfix.errors import OutputError


@dataclass(frozen=True)
class Past:
    """What earlier runs into a folder have left.

    Args:
        begun: names of the clips whose outputs they wrote or were about to write.
        hashes: clip -> file name -> SHA-256 of what they wrote, for the clips that were done.
        offenders: clip -> its worst plants, as plain values.
    """

    begun: frozenset[str] = frozenset()
    hashes: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    offenders: Mapping[str, list[dict[str, Any]]] = field(default_factory=dict)


def journal_in(folder: Path, tag: str, *, own: bool, ending: str = "clean") -> Path:
    """Find where the journal of a run lies.

    Args:
        folder: the outputs of the run.
        tag: of the run.
        own: whether the folder holds outputs alone. The mark of such a folder keeps its clips from being taken for
            inputs; where outputs lie beside their inputs, the journal is a hidden file and marks nothing.
        ending: of the outputs' names beside their inputs, where several commands may write.
    """
    return folder / MARK / f"{tag}.jsonl" if own else folder / f".footfix-{ending}-{tag}.jsonl"


def recall(folder: Path, ending: str = "clean") -> Past:
    """Read what the journals in a folder of outputs say, those of all its shards."""
    begun: set[str] = set()
    hashes: dict[str, Mapping[str, str]] = {}
    offenders: dict[str, list[dict[str, Any]]] = {}
    for path in sorted([*(folder / MARK).glob("*.jsonl"), *folder.glob(f".footfix-{ending}-*.jsonl")]):
        for _, entry in _entries(path):
            clip = entry["clip"]
            begun.add(clip)
            if entry["state"] == "done":
                hashes[clip], offenders[clip] = entry.get("files", {}), entry.get("offenders", [])
    return Past(frozenset(begun), hashes, offenders)


def _entries(path: Path) -> Iterator[tuple[bytes, dict[str, Any]]]:
    """Read the lines that are whole, and what they say."""
    for line in path.read_bytes().splitlines():
        try:
            entry = json.loads(line)
        except ValueError:
            continue
        if isinstance(entry, dict) and isinstance(entry.get("clip"), str) and "state" in entry:
            yield line, entry


class Journal:
    """The journal of a run, appended to by its parent process alone; nothing at all without a path."""

    def __init__(self, path: Path | None = None) -> None:
        self._handle = -1
        self._path = Path() if path is None else path
        if path is None:
            return
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0), 0o666)
            size = os.fstat(self._handle).st_size
            if size and path.read_bytes()[-1:] != b"\n":
                os.write(self._handle, b"\n")  # what a power cut tore stays a line of its own
        except OSError as error:
            raise OutputError(f"{path}: can't be written: {error.strerror or error}") from None

    def begin(self, clips: Iterable[str]) -> None:
        """Say, before anything of theirs is written, that these clips' outputs are ours."""
        self._write([{"clip": clip, "state": "begun"} for clip in clips], safely=True)

    def end(self, clip: str, result: FileResult) -> None:
        """Say what became of a clip."""
        if result.status == "failed":
            self._write([{"clip": clip, "state": "failed"}])
        elif not result.skipped:
            pictures = [asdict(each) for each in result.offenders]
            self._write([{"clip": clip, "state": "done", "files": dict(result.hashes), "offenders": pictures}])
        for part in result.parts:
            self.end(named(clip, part), part)

    def finish(self) -> None:
        """Keep one line a clip, by name: however a run came to its end, its journal is the same."""
        if self._handle < 0:
            return
        last: dict[str, bytes] = {}
        for line, entry in _entries(self._path):
            if entry["state"] != "begun":
                last[entry["clip"]] = line
        self.close()
        write_whole(self._path, b"".join(last[clip] + b"\n" for clip in sorted(last)))

    def close(self) -> None:
        """Close the file."""
        if self._handle >= 0:
            os.close(self._handle)
            self._handle = -1

    def _write(self, entries: list[dict[str, Any]], *, safely: bool = False) -> None:
        if self._handle < 0 or not entries:
            return
        lines = "".join(json.dumps(entry) + "\n" for entry in entries)
        os.write(self._handle, lines.encode("ascii"))
        if safely:  # what has ended says so itself, by its report
            os.fsync(self._handle)

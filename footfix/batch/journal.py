"""The journal of a run: which clips it began and finished, a line each, so that --resume can continue it.

A clip is done when its report exists with the right fingerprint. The journal only tells whether existing outputs are
the run's own and may be overwritten, and keeps what the index shows. An incomplete last line is ignored.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from footfix.batch.file_io import write_whole
from footfix.batch.inputs import MARK
from footfix.batch.multi_clip_files import named
from footfix.batch.task import FileResult
from footfix.errors import OutputError


@dataclass(frozen=True)
class Past:
    """What the journals of earlier runs say of a folder.

    Args:
        begun: names of the clips whose outputs they wrote or were about to write.
        hashes: clip -> file name -> SHA-256 of each output, for the clips that were done.
        offenders: clip -> its worst plants, as plain values.
    """

    begun: frozenset[str] = frozenset()
    hashes: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    offenders: Mapping[str, list[dict[str, Any]]] = field(default_factory=dict)


def journal_in(folder: Path, tag: str, *, own: bool, ending: str = "clean") -> Path:
    """Choose the path of the journal of a run.

    Args:
        folder: the outputs of the run.
        tag: of the run.
        own: whether the folder holds only outputs. The journal's folder then marks its clips as outputs; where outputs
            are beside their inputs, the journal is a hidden file and no mark.
        ending: of the outputs' names beside their inputs, where several commands may write.
    """
    return folder / MARK / f"{tag}.jsonl" if own else folder / f".footfix-{ending}-{tag}.jsonl"


def recall(folder: Path, ending: str = "clean") -> Past:
    """Read the journals in a folder of outputs, those of all shards."""
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
    """Read the complete lines of a journal, as text and as values."""
    for line in path.read_bytes().splitlines():
        try:
            entry = json.loads(line)
        except ValueError:
            continue
        if isinstance(entry, dict) and isinstance(entry.get("clip"), str) and "state" in entry:
            yield line, entry


class Journal:
    """The journal of a run, written by its parent process alone; without a path nothing is written."""

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
                os.write(self._handle, b"\n")  # end a line that was cut off by a power cut
        except OSError as error:
            raise OutputError(f"{path}: can't be written: {error.strerror or error}") from None

    def begin(self, clips: Iterable[str]) -> None:
        """Record, before they are written, that the outputs of these clips are the run's own."""
        self._write([{"clip": clip, "state": "begun"} for clip in clips], safely=True)

    def end(self, clip: str, result: FileResult) -> None:
        """Record the result of a clip."""
        if result.status == "failed":
            self._write([{"clip": clip, "state": "failed"}])
        elif not result.skipped:
            pictures = [asdict(each) for each in result.offenders]
            self._write([{"clip": clip, "state": "done", "files": dict(result.hashes), "offenders": pictures}])
        for part in result.parts:
            self.end(named(clip, part), part)

    def finish(self) -> None:
        """Keep one line a clip, sorted by name, so that interrupted and resumed runs end with the same journal."""
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
        if safely:  # the end of a clip is also known by its report
            os.fsync(self._handle)

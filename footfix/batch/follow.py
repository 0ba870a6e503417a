"""Walks along a path, from files to files."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from footfix.batch.attempt import attempted
from footfix.batch.file_io import STDIN, read_clip, read_whole
from footfix.batch.inputs import Source
from footfix.batch.output_paths import plan
from footfix.batch.task import FileResult, Task, beside
from footfix.batch.write_outputs import fingerprint, write_outputs
from footfix.errors import UsageError
from footfix.formats.suffixes import STDIN_NAME

if TYPE_CHECKING:
    from footfix.formats.floor_paths import DrawnPath
    from footfix.settings import Settings

_AT = re.compile(r"(.+)@((?:\d+\.?\d*|\.\d+)[sm])", re.IGNORECASE | re.DOTALL)
_MOST = 1 << 26  # [bytes] largest file of a path


def named(text: str) -> tuple[str, str | None]:
    """Split walk.bvh@3s into a clip's file and where it begins; a text that is the whole name of a file is not split.

    Raises:
        UsageError: there is no such file.
    """
    if text == STDIN or Path(text).exists():
        return text, None
    found = _AT.fullmatch(text)
    if found and (found[1] == STDIN or Path(found[1]).exists()):
        return found[1], found[2]
    name, sign, at = text.rpartition("@")
    if sign and Path(name).exists():
        raise UsageError(f"{text}: {at!r} is no place to begin; 3s and 8m are")
    raise UsageError(f"{found[1] if found else text}: no such file")


def read_path(text: str) -> DrawnPath:
    """Read a path from a file, or make the shape that a text names.

    Raises:
        UsageError: it is neither a file nor a shape.
        InputError: the file holds no path.
    """
    from footfix.formats.floor_paths import read_path, shape

    if Path(text).is_file():
        return read_path(read_whole(text, _MOST), text)
    found = shape(text)
    if found is None:
        raise UsageError(
            f"{text}: no such file, and no path; a CSV or SVG file is one, or line:10, circle:2, sine:1x6"
        )
    return found


def run_follow(
    path: str, clips: Sequence[tuple[str, str | None]], output: Path, settings: Settings, *, force: bool,
    dry_run: bool,
) -> FileResult:  # fmt: skip
    """Lay the walks of some files along a path, and write all outputs or none.

    Args:
        path: a file, or the name of a shape.
        clips: files, and where each walk begins.
        output: the file to be written.
        settings: the parameters of all steps.
        force: whether existing outputs are overwritten.
        dry_run: whether nothing is written.

    Raises:
        UsageError: the arguments contradict each other, or an output can't be written.
    """
    from footfix.jobs.follow import check_starts, start_of

    ats = [start_of(at) for _, at in clips]
    check_starts(ats, [name for name, _ in clips])
    if output.suffix.lower() != ".bvh":
        raise UsageError(f"-o {output}: what is written is BVH; end the name in .bvh")
    for name, _ in clips:
        if name != STDIN and Path(name).is_dir():
            raise UsageError(f"{name} is a folder; name clips")
    drawing = read_path(path)
    source = Source(clips[0][0], Path(clips[0][0] if clips[0][0] != STDIN else STDIN_NAME))
    inputs = {os.path.realpath(name) for name, _ in clips} | {os.path.realpath(path)}
    if os.path.realpath(output) in inputs:
        raise UsageError(f"{output} is itself an input; write elsewhere")
    (job,) = plan(
        [source], output=output, in_place=False, suffixes=lambda _: beside(settings), force=force, dry_run=dry_run,
        one_file=True, ending="follow",
    )  # fmt: skip
    task = Task(job, settings, dry_run=dry_run, folder=str(Path.cwd()))

    def work() -> FileResult:
        from footfix.jobs.follow import Part, follow_file

        held: dict[str, bytes] = {}
        for name, _ in clips:
            held[name] = held[name] if name in held else read_clip(name, settings.limits, name=name)
        parts = [Part(held[name], name if name != STDIN else STDIN_NAME, at)
                 for (name, _), at in zip(clips, ats, strict=True)]  # fmt: skip
        made = follow_file(drawing, parts, settings, output=output.name)
        return write_outputs(task, made, fingerprint(b"".join(held.values()), settings, None))

    begun = time.perf_counter()
    return replace(attempted(task, work), seconds=time.perf_counter() - begun)

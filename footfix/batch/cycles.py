"""Cycles, from files to files: a model from clips, and a clip from a model."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING

from footfix.batch.attempt import attempted
from footfix.batch.file_io import read_whole, write_whole
from footfix.batch.inputs import Source
from footfix.batch.output_paths import plan as plan_outputs
from footfix.batch.task import FileResult, Task, beside
from footfix.batch.write_outputs import fingerprint, write_outputs
from footfix.errors import UsageError

if TYPE_CHECKING:
    from footfix.formats.locomotion_plans import PlanRow
    from footfix.jobs.fit_cycles import FileCycles, Fitted
    from footfix.jobs.outputs import Outputs
    from footfix.locomotion.cycles.model import CycleModel
    from footfix.settings import Settings

_MOST = 1 << 30  # [bytes] largest model
_MOST_PLAN = 1 << 24  # [bytes] largest plan


def fit_and_write(files: Sequence[FileCycles], output: Path, *, components: int | None) -> Fitted:
    """Fit a model to the cycles of files, and write it.

    Args:
        files: their cycles.
        output: path of the model.
        components: how many principal components a gait keeps at most.

    Raises:
        InputError: there are too few cycles.
    """
    from footfix.formats.cycle_models import encode_model
    from footfix.jobs.fit_cycles import fit_files

    fitted = fit_files(files, components=components)
    output.parent.mkdir(parents=True, exist_ok=True)
    write_whole(output, encode_model(fitted.model))
    return fitted


def style_of(source: Source, styles: Mapping[str, str]) -> str:
    """Find the style of a file: that of the first glob it matches, else its folder below the folder given."""
    for glob, name in styles.items():
        if any(fnmatchcase(each, glob) for each in (source.below.as_posix(), source.below.name)):
            return name
    parts = source.below.parts[:-1]
    return "" if styles or not parts or source.below.is_absolute() else parts[0]


def check_output(output: Path, ends: Sequence[str], inputs: Sequence[str], *, force: bool) -> None:
    """Check that a file can be written.

    Raises:
        UsageError: its name has another ending, it is an input, or it exists.
    """
    if output.suffix.lower() not in ends:
        raise UsageError(f"-o {output}: end the name in {' or '.join(ends)}")
    if os.path.realpath(output) in {os.path.realpath(each) for each in inputs}:
        raise UsageError(f"{output} is itself an input; write elsewhere")
    if output.exists() and not force:
        raise UsageError(f"{output} is there already; --force overwrites it")


def load_model(path: str | Path) -> CycleModel:
    """Read a model.

    Raises:
        InputError: it can't be read.
    """
    from footfix.formats.cycle_models import decode_model

    return decode_model(read_whole(path, _MOST), name=str(path))


def load_plan(path: str | Path) -> tuple[PlanRow, ...]:
    """Read a plan.

    Raises:
        InputError: it can't be read.
    """
    from footfix.formats.locomotion_plans import decode_plan

    return decode_plan(read_whole(path, _MOST_PLAN), name=str(path))


def run_make(
    model_file: str, rows: Sequence[PlanRow], output: Path, settings: Settings, *, seconds: float | None, fps: float,
    path: str | None, force: bool, dry_run: bool,
) -> FileResult:  # fmt: skip
    """Make locomotion from a model, and write all outputs or none.

    Args:
        model_file: the file of the model.
        rows: the plan.
        output: the file to be written.
        settings: which report files are written.
        seconds: [s] how long; None for as long as the plan, or the path.
        fps: frames a second.
        path: a file, or the name of a shape.
        force: whether existing outputs are overwritten.
        dry_run: whether nothing is written.

    Raises:
        UsageError: the arguments contradict each other, or an output can't be written.
    """
    if output.suffix.lower() != ".bvh":
        raise UsageError(f"-o {output}: what is written is BVH; end the name in .bvh")
    (job,) = plan_outputs(
        [Source(model_file, Path(model_file))], output=output, in_place=False, suffixes=lambda _: beside(settings),
        force=force, dry_run=dry_run, one_file=True, ending="cycles",
    )  # fmt: skip
    task = Task(job, settings, dry_run=dry_run, folder=str(Path.cwd()))

    def work() -> FileResult:
        data = read_whole(model_file, _MOST)
        made = _made(data, model_file, rows, settings, seconds=seconds, fps=fps, path=path, output=output.name)
        asked = f"{rows} {seconds} {fps} {path}".encode("utf-8", "surrogateescape")
        return write_outputs(task, made, fingerprint(asked + data, settings, None))

    begun = time.perf_counter()
    return replace(attempted(task, work), seconds=time.perf_counter() - begun)


def _made(
    data: bytes, model_file: str, rows: Sequence[PlanRow], settings: Settings, *, seconds: float | None, fps: float,
    path: str | None, output: str,
) -> Outputs:  # fmt: skip
    """Make the outputs of a plan from the bytes of a model."""
    import hashlib

    import numpy as np

    from footfix.formats.cycle_models import decode_model
    from footfix.jobs.make_cycles import make_file, plan_of

    model = decode_model(data, name=model_file)
    plan = plan_of(rows, model)
    line = None
    if path is not None:
        from footfix.batch.follow import read_path
        from footfix.locomotion.follow.path import make_path

        line = make_path(read_path(path).metres(settings.follow.unit))
        if seconds is None and len(rows) == 1:
            seconds = line.length / max(float(plan.speed[0]), 0.05)
    if seconds is None:
        seconds = float(np.max(plan.times)) if len(rows) > 1 else 10.0
    source = {"file": Path(model_file).name, "sha256": hashlib.sha256(data).hexdigest()}
    return make_file(model, plan, settings, seconds=seconds, fps=fps, source=source, line=line, output=output)

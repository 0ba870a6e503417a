"""Pages redrawn from the report, the contacts and the clips on disk."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from footfix.batch.file_io import read_whole, write_whole
from footfix.batch.skins import skin_for
from footfix.batch.task import CONTACTS, REPORT, FileResult
from footfix.errors import FootfixError, InputError
from footfix.formats.suffixes import in_file
from footfix.report.rerun_command import RerunCommand, clean_again, clean_loop_again
from footfix.rig.params import NO_SKIN
from footfix.settings import Layer, ReportParams, Settings, compose

if TYPE_CHECKING:
    from footfix.rig.skin import Skin


def redraw_one(
    path: Path, source: Path | None, params: ReportParams, output: Path | None, *, force: bool
) -> FileResult:
    """Draw the pages of one clip again.

    Args:
        path: its report file.
        source: the captured clip, or a folder that holds it; None to look beside the report.
        params: which pages.
        output: the folder for the pages; None for that of the report.
        force: existing pages are replaced.
    """
    from footfix.report.pages import redraw

    try:
        most = Settings().limits.bytes
        report = _report(read_whole(path, most), path)
        stem = path.name.removesuffix(REPORT)
        pages = redraw(
            report,
            read_whole(path.with_name(stem + CONTACTS), most),
            _input(report, path, source, most),
            read_whole(path.with_name(str(report.get("output") or f"{stem}.bvh")), most),
            params,
            _again(report, path, source),
            lambda name: read_whole(path.parent / name, most),
            _skin(report, path, source),
        )
        folder = output or path.parent
        targets = {folder / (stem + suffix): page for suffix, page in pages.items()}
        for target in targets:
            if target.exists() and not force:
                raise InputError("is there already", file=str(target), hint="--force draws over it")
        folder.mkdir(parents=True, exist_ok=True)
        for target, page in targets.items():
            write_whole(target, page)
        return FileResult(str(path), "done", written=tuple(map(str, targets)))
    except FootfixError as error:
        return FileResult(str(path), "failed", error=str(error))
    except OSError as error:
        return FileResult(str(path), "failed", error=f"{path}: {error.strerror or error}")


def _report(data: bytes, path: Path) -> Mapping[str, Any]:
    try:
        report = json.loads(data.decode("utf-8", "surrogateescape"))
    except (ValueError, RecursionError):
        report = None
    if not isinstance(report, dict) or report.get("format") != "footfix-report":
        raise InputError("this is no report of footfix", file=str(path), hint="give the file that ends in .report.json")
    return report


def _again(report: Mapping[str, Any], path: Path, source: Path | None) -> RerunCommand | None:
    """Write the command that cleans the clip again with the settings of the report."""
    name, output = (report.get("source") or {}).get("file"), report.get("output")
    if not name or not output:
        return None
    folder = source if source is not None and source.is_dir() else path.parent
    file, own = in_file(str(name))
    clip = source if source is not None and source.is_file() else folder / Path(file).name
    contacts = path.with_name(path.name.removesuffix(REPORT) + CONTACTS)
    settings = compose([Layer("report", report.get("settings") or {})])
    if report.get("loop"):
        return clean_loop_again(path.with_name(str(output)), contacts, settings, several=bool(own))
    return clean_again(clip, path.with_name(str(output)), contacts, settings, several=bool(own))


def _skin(report: Mapping[str, Any], path: Path, source: Path | None) -> Skin | None:
    """Find the character whose mesh the soles were taken from: at its path, or beside the clip or the report."""
    told = (report.get("settings") or {}).get("rig") or {}
    named = told.get("skin")
    if not isinstance(named, str) or named == NO_SKIN:
        return None
    settings = compose([Layer("report", {"rig": {"skin": named}})])
    beside = [path.parent] if source is None else [source if source.is_dir() else source.parent, path.parent]
    for place in (Path(named), *(folder / Path(named).name for folder in beside)):
        if place.is_file():
            return skin_for(replace(settings, rig=replace(settings.rig, skin=str(place))))
    raise InputError("the skin that the soles were taken from is not there", file=named)


def _input(report: Mapping[str, Any], path: Path, source: Path | None, most: int) -> bytes:
    """Find the captured clip, by its hash."""
    entry = report.get("source") or {}
    name, known = str(entry.get("file", "")), entry.get("sha256")
    folder = source if source is not None and source.is_dir() else path.parent
    candidates = [source] if source is not None and source.is_file() else [folder / Path(in_file(name)[0]).name]
    for candidate in candidates:
        if candidate.is_file():
            data = read_whole(candidate, most)
            if hashlib.sha256(data).hexdigest() == known:
                return data
    raise InputError(
        f"the clip it was made from, {name}, is not {'there' if source else 'beside it'}, or was changed since",
        file=str(path), hint="--source says where it is",
    )  # fmt: skip

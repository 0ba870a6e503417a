"""Walks along a path, from the bytes of clips to the bytes of outputs. No file is read or written here."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import PurePath
from typing import Any

import numpy as np

from footfix import version
from footfix.errors import InputError, UsageError
from footfix.formats.document import write_motion
from footfix.formats.floor_paths import DrawnPath
from footfix.jobs.contacts import contacts_json, find_contacts
from footfix.jobs.loop import LEAST_FRAMES
from footfix.jobs.outputs import Outputs
from footfix.jobs.source import about, read, source_entry
from footfix.locomotion.follow.prepared_walk import Walk, make_walk
from footfix.locomotion.follow.run import Follow, follow_path
from footfix.locomotion.follow.transitions import At
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.duplicate_frames import DuplicateFrames
from footfix.motion.lead_in import motion_range
from footfix.pipeline import Figure, cut_loop, measure_figures, prepare
from footfix.report import document as report_format
from footfix.report.pages import draw
from footfix.rig.find import find_rigs
from footfix.rig.rig import Rig
from footfix.settings import Settings, plain

Start = str | float | None

_AT = re.compile(r"\s*(\d+\.?\d*|\.\d+)\s*(s|m)\s*", re.IGNORECASE)
_DRAWN = 400  # points of a path in a report, at most


@dataclass(frozen=True)
class Part:
    """A captured walk, and where on the path it begins.

    Args:
        data: the bytes of its file.
        name: the name of its file.
        at: where it begins, as `start_of` reads it.
    """

    data: bytes
    name: str
    at: At = field(default_factory=At)


def walk_of(
    clip: Clip, name: str, settings: Settings, *, rig: Rig | None = None, contacts: Contacts | None = None
) -> Walk:  # fmt: skip
    """Make a straight loop of a captured walk, to be laid along a path.

    Args:
        clip: the walk [m], y up.
        name: for messages.
        settings: the parameters of all steps.
        rig: its legs; found where it is not given.
        contacts: which sole points are planted when; detected where they are not given.

    Raises:
        InputError: it holds no cycle.
    """
    asked = replace(settings.loop, straighten=True, open=True, in_place=False)
    settings = replace(settings, loop=asked)
    with about(name):
        if len(clip) < LEAST_FRAMES:
            raise InputError(f"{len(clip)} frames are too few for a stride")
        frame_range = motion_range(clip)
        rigs = (rig,) if rig is not None else find_rigs(clip, settings.rig, frame_range)
        if len(rigs) > 1:
            raise InputError(f"the file holds {len(rigs)} figures; one walks along a path")
        prepared = prepare(clip, settings, rigs, frame_range)
        found = contacts if contacts is not None else find_contacts(prepared, settings, None)
        return make_walk(cut_loop(prepared, found, settings), name)


def follow_file(
    path: DrawnPath, parts: Sequence[Part], settings: Settings, *, output: str | None = None
) -> Outputs:  # fmt: skip
    """Lay captured walks along a path.

    Args:
        path: the path as drawn.
        parts: the walks, in their order.
        settings: the parameters of all steps.
        output: the name of the file, for the report.

    Raises:
        InputError: a clip can't be used, or the clips have different skeletons.
        UsageError: a walk begins where it can't.
    """
    documents = [read(part.data, part.name, settings) for part in parts]
    walks: dict[bytes, Walk] = {}
    for part, document in zip(parts, documents, strict=True):
        if part.data not in walks:
            walks[part.data] = walk_of(document.clip, part.name, settings)
    used = [walks[part.data] for part in parts]
    found = follow_path(
        path.metres(settings.follow.unit), used, [part.at for part in parts], settings.follow, settings.enforce,
        relative=path.relative,
    )  # fmt: skip
    document = documents[0]
    written, reread = write_motion(document, found.frames, found.clip, limits=settings.limits)
    ground = np.zeros((len(reread), 3))
    every = DuplicateFrames(np.arange(len(reread)), len(reread))
    figure = Figure(
        found.rig, found.contacts, found.contacts, found.plants, found.correction, ground, every, found.notes
    )
    (result,) = measure_figures(found.laid, reread, (figure,))
    source = source_entry(parts[0].data, parts[0].name, document.clip)
    report = {
        **report_format.frame(source, version.__version__, status="cleaned", output=output),
        "method": settings.enforce.method,
        "rig": report_format.rig(found.rig, reread, unit_m=document.unit_m, up=document.up),
        "settings": plain(settings),
        "follow": follow_entry(found, path.name, [(part.name, part.data) for part in parts]),
        "before": report_format.measures(result.before),
        "after": report_format.measures(result.after),
        "plants": report_format.plants(result.plants, result.plants_before, result.plants_after),
        "correction": report_format.corrections([found.correction], found.laid),
        "notes": report_format.notes((*document.notes, *found.rig.notes, *found.notes)),
        "seconds": {
            "clip": report_format.rounded(len(reread) * reread.frame_time),
            "in_contact": report_format.rounded(float(found.contacts.mask().any(axis=1).sum()) * reread.frame_time),
        },
    }
    made = {**source, "sha256": hashlib.sha256(written).hexdigest(), "frames": len(reread)}
    made["file"] = PurePath(output).name if output else source["file"]
    contacts_file = contacts_json(found.contacts, made, report["rig"], settings)
    pages, offenders = draw(found.laid, reread, found.rig, report, contacts_file, settings.report, None, ground)
    return Outputs("cleaned", written, contacts_file, report, pages, offenders)


def start_of(at: Start) -> At:
    """Read where a walk begins: "3s", "8m", a number of seconds, or None.

    Raises:
        UsageError: it is something else.
    """
    if at is None:
        return At()
    if isinstance(at, str):
        found = _AT.fullmatch(at)
        if not found:
            raise UsageError(f"{at!r} is no place to begin; 3s and 8m are")
        value = float(found[1])
        return At(seconds=value) if found[2].lower() == "s" else At(metres=value)
    return At(seconds=float(at))


def check_starts(ats: Sequence[At], names: Sequence[str]) -> None:
    """Check that the first walk begins at the start, and each of the others later.

    Raises:
        UsageError: one does not.
    """
    for k, (at, name) in enumerate(zip(ats, names, strict=True)):
        value = at.seconds if at.seconds is not None else at.metres
        if k == 0 and value:
            raise UsageError(f"{name} is the first walk, and begins at the start")
        if k and value is None:
            raise UsageError(f"where does {name} begin? say when, as 3s, or how far on the path, as 8m")


def follow_entry(found: Follow, asked: str, clips: Sequence[tuple[str, bytes]]) -> dict[str, Any]:
    """Describe walks along a path as the report's entry; each key carries its unit.

    Args:
        found: the walks.
        asked: the path, as given on the command line.
        clips: name and bytes of each clip.
    """
    number, walked, path = report_format.rounded, found.walked, found.path
    lean = np.degrees(walked.lean)
    return {
        "path": {
            "asked": asked,
            "length_m": number(path.length),
            "closed": path.closed,
            "points_m": _points(path.points),
        },
        "walked": {
            "frames": len(found.clip),
            "seconds": number((len(found.clip) - 1) * found.clip.frame_time),
            "length_m": number(float(walked.arc[-1] - walked.arc[0])),
            "root_length_m": number(float(np.linalg.norm(np.diff(walked.root, axis=0), axis=1).sum())),
            "root_off_path_mm": number(1000.0 * float(np.abs(walked.off).max())),
            "speed_m_s": number(float(walked.speed.mean())),
            "points_m": _points(walked.root),
        },
        "strides": {
            "mean_scale": number(float(walked.scale.mean())),
            "shortest_scale": number(float(walked.scale.min())),
            "lowered_mm": number(1000.0 * float(walked.lowered.max())),
        },
        "lean": {
            "most_left_deg": number(float(max(lean.max(), 0.0))),
            "most_right_deg": number(float(max(-lean.min(), 0.0))),
            "feet_beside_path_mm": number(1000.0 * float(np.abs(walked.aside).max())),
            "balance_off_mm": number(1000.0 * float(np.abs(walked.balance).max())),
        },
        "clips": [
            {
                "file": PurePath(name).name, "sha256": hashlib.sha256(data).hexdigest(),
                "start": walk.loop.start, "end": walk.loop.end, "strides": walk.strides,
                "speed_m_s": number(walk.speed), "stride_m": number(walk.length / walk.strides),
                "stride_s": number(walk.stride_seconds),
            }
            for (name, data), walk in zip(clips, found.walks, strict=True)
        ],
        "transitions": [
            {
                "from": each.before, "to": each.after, "start_s": number(each.start), "end_s": number(each.end),
                "start_m": number(each.metres), "by": each.effector,
                "asked_s": number(each.asked) if np.isfinite(each.asked) else None, "clamped": each.clamped,
                "peak_times": None if each.peak is None else number(each.peak),
                "asked_peak_times": None if each.asked_peak is None else number(each.asked_peak),
            }
            for each in found.transitions
        ],
    }  # fmt: skip


def _points(points: Floats) -> list[list[float]]:
    some = np.unique(np.linspace(0, len(points) - 1, min(len(points), _DRAWN)).round().astype(int))
    return [[round(float(x), 4), round(float(z), 4)] for x, z in points[some]]

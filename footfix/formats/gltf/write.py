"""Writing glTF: only the channels that changed are new, with keys at every frame; all else stays as it is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from footfix.formats.bvh.channels import displaced
from footfix.formats.bvh.text import Limits
from footfix.formats.gltf.container import Beside, open_container
from footfix.formats.gltf.document import Document
from footfix.formats.gltf.frame_times import Grid
from footfix.formats.gltf.nodes import read_nodes
from footfix.formats.gltf.patch import Patch, patched
from footfix.formats.gltf.tracks import Track, read_tracks
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, same_track

_LIMITS = Limits()
_TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
_SAME = 1e-4  # of a step, by which the keys of a channel may miss the frames: then its times stay


@dataclass
class Numbers:
    """New accessors as they are gathered, and their bytes.

    Args:
        first: the number of the first one.
        rows: what they say of themselves.
        parts: their bytes.
    """

    first: int
    rows: list[dict[str, Any]] = field(default_factory=list)
    parts: list[bytes] = field(default_factory=list)

    def add(self, values: Floats, *, bounds: bool = False) -> int:
        """Add an accessor of floats (N, w), with its least and largest where `bounds`; return its number."""
        small = np.ascontiguousarray(values, dtype="<f4")
        row: dict[str, Any] = {
            "byteOffset": sum(map(len, self.parts)), "componentType": 5126, "count": len(small),
            "type": _TYPES.get(small.shape[1], "SCALAR"),
        }  # fmt: skip
        if row["type"] == "SCALAR":
            row["count"] = small.size
        if bounds:
            row |= {"min": small.min(axis=0).tolist(), "max": small.max(axis=0).tolist()}
        self.rows.append(row)
        self.parts.append(small.tobytes())
        return self.first + len(self.rows) - 1


def rewrite(document: Document, clip: Clip, *, limits: Limits = _LIMITS) -> tuple[bytes, Clip]:
    """Write the file with the motion of `clip` in one of its animations; only channels that changed are new.

    Args:
        document: the file and the animation.
        clip: F frames of its joints [m], y up.
        limits: beyond these it can't be read again.

    Returns:
        The file, and the motion in it [m], y up; the very bytes and `document.clip` itself where nothing changed.
    """
    old = document.clip
    if clip is not old and (len(clip), len(clip.skeleton)) != (len(old), len(old.skeleton)):
        of = [f"{len(each)} frames of {len(each.skeleton)} joints" for each in (clip, old)]
        raise ValueError(f"the clip has {of[0]}, the file {of[1]}")
    changed = _every(document, clip) if document.cut else {} if clip is old else _changes(document, clip)
    if not changed:
        return document.container.data, old
    written = patched(document.container, _patch(document, changed))
    return written, _reread(document, written, limits)


def _reread(document: Document, written: bytes, limits: Limits) -> Clip:
    """Read an animation of a file again, at the same times."""
    beside = _at_hand(document)
    container = open_container(written, name=document.container.name, limits=limits, beside=beside)
    tracks, nodes = read_tracks(container, document.animation), read_nodes(container, limits)
    again = replace(document, container=container, nodes=nodes, tracks=tracks)
    return again.placed(unit_m=document.unit_m, up=document.up).clip


def _patch(document: Document, changed: Mapping[tuple[int, str], Floats]) -> Patch:
    """Make of new values what is new in the file.

    Args:
        document: the file and the animation.
        changed: (node, path) -> (F, w) at the times of its grid, in the file's units and axes.
    """
    tree, container, grid = document.container.tree, document.container, document.grid
    row = _copied(tree["animations"][document.animation])
    numbers = Numbers(len(container.tables["accessors"]))
    times = dict[bool, int]()  # of the first and last frame alone, or of all
    users = _users(row["channels"])
    for (node, path), values in changed.items():
        track = document.tracks.get((node, path))
        if not document.cut and track is not None and _fits(track, grid):
            taken = row["samplers"][track.sampler]["input"]
        else:
            still = document.cut and bool(np.all(values == values[0]))
            if still not in times:
                times[still] = numbers.add(grid.times[[0, -1] if still else slice(None), None], bounds=True)
            taken, values = times[still], values[:2] if still else values
        mode = "STEP" if document.cut and track is not None and track.mode == "STEP" else "LINEAR"
        _put(row, track, users, node, path, {"input": taken, "interpolation": mode, "output": numbers.add(values)})
    nodes = _without_matrices(document, {node for node, _ in changed})
    return Patch({document.animation: row}, nodes, numbers.rows, b"".join(numbers.parts))


def _fits(track: Track, grid: Grid) -> bool:
    """Tell whether a channel has its keys at the frames, so that its times can stay."""
    if track.mode != "LINEAR" or len(track.times) != grid.frames:
        return False
    return bool(np.all(np.abs(track.times - grid.times) < _SAME * grid.step))


def _put(
    row: dict[str, Any], track: Track | None, users: Mapping[int, int], node: int, path: str, sampler: dict[str, Any]
) -> None:  # fmt: skip
    """Put a sampler in the place of a channel's own, beside it where others use that, or with a new channel."""
    if track is not None and users[track.sampler] == 1:
        row["samplers"][track.sampler] = {**row["samplers"][track.sampler], **sampler}
        return
    row["samplers"].append(sampler)
    number = len(row["samplers"]) - 1
    if track is not None:
        row["channels"][track.channel]["sampler"] = number
    else:
        row["channels"].append({"sampler": number, "target": {"node": node, "path": path}})


def _changes(document: Document, clip: Clip) -> dict[tuple[int, str], Floats]:
    """Find the channels that changed: (node, path) -> their values, in the file's units and axes."""
    old, was = document.clip, document.file_clip
    now = clip if document.plain else displaced(clip, document.unit_m, document.up)
    found: dict[tuple[int, str], Floats] = {}
    for j, node in enumerate(document.joints):
        turned = _differ(clip.rotation(j), old.rotation(j))
        if np.any(turned):
            values = np.where(turned[:, None], now.rotation(j), was.rotation(j))
            found[node, "rotation"] = _signed(values, was.rotation(j))
        moved = _differ(clip.position(j), old.position(j))
        if np.any(moved):
            size = np.ones(1) if document.parent(j) < 0 else document.scales[document.parent(j)]
            kept = document.local(j)
            found[node, "translation"] = np.where(moved[:, None], now.position(j) / size[:, None], kept)
    return found


def _every(document: Document, clip: Clip) -> dict[tuple[int, str], Floats]:
    """Take the values of every channel: of joints those of a clip, of all else those of the document."""
    found = {key: np.array(track.at(document.grid.times)) for key, track in document.tracks.items()}
    return {**found, **_changes(document, clip)}


def _differ(new: Floats, old: Floats) -> Floats:
    return np.zeros(len(old), np.bool_) if same_track(new, old) else np.any(new != old, axis=1)


def _signed(turns: Floats, old: Floats) -> Floats:
    """Choose the signs of rotations: those of the file's own where it has any, without a jump in between."""
    first = 1.0 if float(turns[0] @ old[0]) >= 0.0 else -1.0
    return rotation.continuous(first * turns)


def _without_matrices(document: Document, nodes: Iterable[int]) -> dict[int, dict[str, Any]]:
    """Give nodes translation, rotation and scale in place of a matrix, since an animation moves no matrix."""
    found = {}
    for node in nodes:
        if not document.nodes.matrices[node]:
            continue
        row = _copied(document.container.tree["nodes"][node])
        del row["matrix"]
        row["translation"] = document.nodes.translations[node].tolist()
        row["rotation"] = document.nodes.rotations[node].tolist()
        row["scale"] = document.nodes.scales[node].tolist()
        found[node] = row
    return found


def _users(channels: Iterable[Any]) -> dict[int, int]:
    """Count the channels that use each sampler."""
    found: dict[int, int] = {}
    for channel in channels:
        found[channel.get("sampler")] = found.get(channel.get("sampler"), 0) + 1
    return found


def _copied(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _copied(each) for key, each in value.items()}
    return [_copied(each) for each in value] if isinstance(value, list) else value


def _at_hand(document: Document) -> Beside:
    """Hand out the files beside a document that were read with it."""
    return lambda path: document.container.fetched[path]

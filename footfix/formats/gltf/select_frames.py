"""Some frames of an animation as an animation, and one file with the changes of several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from footfix.formats.bvh.text import Limits
from footfix.formats.gltf.container import Beside, Container, open_container
from footfix.formats.gltf.document import Document
from footfix.formats.gltf.frame_times import Grid
from footfix.formats.gltf.patch import Patch, patched
from footfix.formats.gltf.tracks import Track, animation_names
from footfix.motion.clip import Ints

_LIMITS = Limits()


def select_frames(document: Document, frames: Sequence[int] | Ints, *, limits: Limits = _LIMITS) -> Document:
    """Make the document of some frames, from time 0 on; every channel of the animation is cut to them.

    Args:
        document: the animation.
        frames: which of its frames, in their new order; a frame may come more than once.
        limits: not used; the interface of formats has it.
    """
    which = np.asarray(frames, dtype=np.intp)
    grid = Grid(0.0, document.grid.step, len(which))
    tracks = {}
    for key, track in document.tracks.items():
        if track.constant:
            tracks[key] = replace(track, times=grid.times[[0, -1]], values=track.values[[0, 0]], tangents=None)
        else:
            mode = "STEP" if track.mode == "STEP" else "LINEAR"
            values = track.at(document.grid.times)[which]
            tracks[key] = replace(track, times=grid.times, values=values, tangents=None, mode=mode)
    tracks = {key: _without_splines(track) for key, track in tracks.items()}
    new = replace(document, tracks=tracks, grid=grid, cut=True)
    return new.placed(unit_m=document.unit_m, up=document.up)


def annotated(data: bytes, extras: Mapping[str, Any], *, name: str, beside: Beside | None = None) -> bytes:
    """Add `extras` to some of a file's animations, which engines and programs hand on to scripts.

    Args:
        data: the file.
        extras: name of an animation -> what its extras are to have.
        name: what the file is called.
        beside: reads a file that it names.
    """
    container = open_container(data, name=name, beside=beside)
    names = animation_names(container)
    rows = container.tables["animations"]
    new: dict[int, dict[str, Any]] = {}
    for animation, more in extras.items():
        k = names.index(animation)
        own = rows[k].get("extras")
        new[k] = {**rows[k], "extras": {**(own if isinstance(own, dict) else {}), **more}}
    return patched(container, Patch(animations=new))


def joined(data: bytes, so_far: bytes, written: bytes, *, name: str, beside: Beside | None = None) -> bytes:
    """Make one file with the changes of two others.

    Args:
        data: the file that both were made of.
        so_far: it with some animations changed.
        written: it with others changed.
        name: what it is called.
        beside: reads a file that this one names.
    """
    base, target, source = (open_container(each, name=name, beside=beside) for each in (data, so_far, written))
    first = len(base.tables["accessors"])
    shift = len(target.tables["accessors"]) - first
    animations, nodes = (
        {k: row for k, row in enumerate(source.tables[key]) if row != base.tables[key][k]}
        for key in ("animations", "nodes")
    )
    moved = {
        k: {**row, "samplers": [_shifted(sampler, first, shift) for sampler in row["samplers"]]}
        for k, row in animations.items()
    }
    rows, bytes_ = _new_numbers(source, first, len(base.tables["bufferViews"]))
    return patched(target, Patch(moved, nodes, rows, bytes_))


def _new_numbers(source: Container, first: int, views: int) -> tuple[list[dict[str, object]], bytes]:
    """Take the accessors of a file from number `first` on, and the bytes of their buffer views."""
    starts, parts, at = dict[int, int](), list[bytes](), 0
    for k in range(views, len(source.tables["bufferViews"])):
        view = source.tables["bufferViews"][k]
        held = source.buffers[view["buffer"]]
        assert held is not None
        start = view.get("byteOffset", 0)
        starts[k] = at
        parts.append(bytes(held[start : start + view["byteLength"]]))
        at += len(parts[-1])
    rows = []
    for row in source.tables["accessors"][first:]:
        own = {key: value for key, value in row.items() if key != "bufferView"}
        rows.append({**own, "byteOffset": starts[row["bufferView"]] + row.get("byteOffset", 0)})
    return rows, b"".join(parts)


def _shifted(sampler: dict[str, object], first: int, shift: int) -> dict[str, object]:
    """Renumber a sampler's accessors from `first` on."""
    return {
        key: value + shift if key in ("input", "output") and isinstance(value, int) and value >= first else value
        for key, value in sampler.items()
    }


def _without_splines(track: Track) -> Track:
    return replace(track, mode="LINEAR") if track.mode == "CUBICSPLINE" else track

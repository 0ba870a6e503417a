"""Changing a glTF file in a few places: all other bytes of its text and of its buffers stay as they are.

New numbers go into a buffer view at the end; what they take the place of stays where it is, so that nothing else that
points there is touched.
"""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from footfix.errors import InputError
from footfix.formats.gltf.container import Container

_DECODER = json.JSONDecoder()
_BLANK = " \t\r\n"
_MOST = (1 << 32) - 1  # [bytes] of a GLB, whose lengths have four bytes
_URI = "data:application/octet-stream;base64,"


@dataclass(frozen=True)
class Patch:
    """What is new in a file.

    Args:
        animations: index -> the animation as it is to be; it may name new accessors by numbers that follow those of
            the file.
        nodes: index -> the node as it is to be.
        accessors: new ones, without a buffer view, which is `data`, but with the `byteOffset` in it.
        data: the bytes of the new accessors.
    """

    animations: Mapping[int, Mapping[str, Any]] = field(default_factory=dict)
    nodes: Mapping[int, Mapping[str, Any]] = field(default_factory=dict)
    accessors: Sequence[Mapping[str, Any]] = ()
    data: bytes = b""


def patched(container: Container, patch: Patch) -> bytes:
    """Write a file with some animations and nodes new, and all else as it stands.

    Args:
        container: the file.
        patch: what is new.

    Raises:
        InputError: it would be larger than a GLB can be.
    """
    tree = container.tree
    raw = container.data[slice(*container.text_at)]
    mark = b"\xef\xbb\xbf" if raw.startswith(b"\xef\xbb\xbf") else b""
    text = raw[len(mark) :].decode("utf-8")
    edits = [*_replaced(text, "animations", patch.animations), *_replaced(text, "nodes", patch.nodes)]
    own, start = container.binary_at, 0
    if patch.accessors:
        inside = own is not None and not tree["buffers"][0].get("uri")
        if inside and own is not None:
            start = own[1] - own[0] + (own[0] - own[1]) % 4
            size = start + len(patch.data)
            edits += _replaced(text, "buffers", {0: {**tree["buffers"][0], "byteLength": size}})
            buffer = 0
        else:
            uri = _URI + base64.b64encode(patch.data).decode("ascii")
            edits.append(_added(text, tree, "buffers", [{"byteLength": len(patch.data), "uri": uri}]))
            buffer = len(tree["buffers"])
        view = {"buffer": buffer, "byteOffset": start, "byteLength": len(patch.data)}
        edits.append(_added(text, tree, "bufferViews", [view]))
        views = len(container.tables["bufferViews"])
        edits.append(_added(text, tree, "accessors", [{"bufferView": views, **each} for each in patch.accessors]))
    new_text = mark + _spliced(text, edits).encode("utf-8")
    if not container.is_binary:
        return new_text
    return _as_glb(container, new_text, start, patch.data if start else b"")


def _as_glb(container: Container, text: bytes, start: int, data: bytes) -> bytes:
    """Put a GLB together: its new JSON, its binary chunk with more at its end, and whatever else it has."""
    source, own = container.data, container.binary_at
    text = text.rstrip(b" \0\t\r\n")
    text += b" " * (-len(text) % 4)
    after = container.text_at[1] + (container.text_at[0] - container.text_at[1]) % 4
    length = struct.unpack_from("<I", source, 8)[0]
    parts = [struct.pack("<II", len(text), 0x4E4F534A), text]
    if own is not None and data:
        parts.append(source[after : own[0] - 8])
        size = start + len(data) + (-len(data)) % 4
        parts.append(struct.pack("<II", size, 0x004E4942))
        parts += [source[own[0] : own[1]], bytes(start - (own[1] - own[0])), data, bytes(-len(data) % 4)]
        after = own[1] + (own[0] - own[1]) % 4
    parts.append(source[after:length])
    total = 12 + sum(map(len, parts))
    if total > _MOST:
        raise InputError("it would be larger than 4 GB, which no GLB can be", file=container.name)
    return b"".join([source[:8], struct.pack("<I", total), *parts, source[length:]])


def _replaced(text: str, key: str, rows: Mapping[int, Mapping[str, Any]]) -> list[tuple[int, int, str]]:
    """Make the edits that replace objects of a top-level list: (start, stop, text)."""
    if not rows:
        return []
    places = list(_elements(text, _span(text, key)[0]))
    return [(*places[number], _json(row)) for number, row in rows.items()]


def _added(text: str, tree: Mapping[str, Any], key: str, rows: Sequence[Mapping[str, Any]]) -> tuple[int, int, str]:
    """Make the edit that appends objects to a top-level list."""
    new = ",".join(map(_json, rows))
    if key not in tree:
        start, _ = next(_members(text))[1]
        at = text.rindex('"', 0, text.rindex('"', 0, start))
        return at, at, f'"{key}":[{new}],'
    stop = _span(text, key)[1] - 1
    while text[stop - 1] in _BLANK:
        stop -= 1
    return stop, stop, f",{new}" if tree[key] else new


def _spliced(text: str, edits: Sequence[tuple[int, int, str]]) -> str:
    parts, at = [], 0
    for start, stop, new in sorted(edits):
        parts += [text[at:start], new]
        at = stop
    return "".join([*parts, text[at:]])


def _span(text: str, key: str) -> tuple[int, int]:
    """Find the value of a top-level member; of two with one name the last counts, as in reading."""
    return dict(_members(text))[key]


def _members(text: str) -> Iterator[tuple[str, tuple[int, int]]]:
    """List the members of a valid JSON object, and where their values are."""
    at = _past(text, 0) + 1
    while text[at := _past(text, at)] != "}":
        key, at = _DECODER.raw_decode(text, at)
        start = _past(text, _past(text, at) + 1)
        _, at = _DECODER.raw_decode(text, start)
        yield key, (start, at)
        at = _past(text, at)
        at += text[at] == ","


def _elements(text: str, start: int) -> Iterator[tuple[int, int]]:
    """Find the elements of a JSON list."""
    at = start + 1
    while text[at := _past(text, at)] != "]":
        _, stop = _DECODER.raw_decode(text, at)
        yield at, stop
        at = _past(text, stop)
        at += text[at] == ","


def _past(text: str, at: int) -> int:
    while text[at] in _BLANK:
        at += 1
    return at


def _json(row: Mapping[str, Any]) -> str:
    return json.dumps(row, separators=(",", ":"), ensure_ascii=False)

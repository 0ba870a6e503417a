"""The container of a glTF file: its JSON and its buffers, from .glb, .vrm, .vrma or .gltf.

Lengths that a file tells are held against what is there before memory is spent on them. Source: glTF 2.0, 3.6, 4.4.
"""

from __future__ import annotations

import base64
import binascii
import json
import re
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote_to_bytes

from footfix.errors import InputError
from footfix.formats.bvh.text import Limits
from footfix.formats.gltf.fields import table, text, whole

Beside = Callable[[str], bytes]  # the bytes of a file that another one names

_LIMITS = Limits()
_MAGIC = b"glTF"
_HEADER, _CHUNK = 12, 8  # [bytes]
_JSON, _BIN = 0x4E4F534A, 0x004E4942
_TABLES = ("accessors", "animations", "bufferViews", "buffers", "images", "meshes", "nodes", "scenes", "skins")
_DATA_URI = re.compile(r"data:[^,]{0,200},", re.IGNORECASE)
_UNDO = "`npx @gltf-transform/cli copy IN.glb OUT.glb` undoes it"
# What packs numbers in a way of its own: extension -> what people call it.
_PACKED = {
    "EXT_meshopt_compression": "meshopt",
    "KHR_meshopt_compression": "meshopt",
    "KHR_draco_mesh_compression": "Draco",
}


@dataclass(frozen=True, eq=False)
class Container:
    """A glTF file, opened.

    Args:
        name: of the file, for messages.
        data: the file.
        tree: its JSON.
        tables: the lists of objects in it by name, such as "nodes"; an empty one where the file has none.
        text_at: where the JSON stands in the file, `(start, stop)`.
        binary_at: where its binary chunk's bytes stand, `(start, stop)`; None where it has none.
        buffers: the bytes of each buffer; None of one that has neither bytes nor an address (a placeholder).
        fetched: the files beside it that were read: path -> bytes.
    """

    name: str
    data: bytes
    tree: Mapping[str, Any]
    tables: Mapping[str, list[dict[str, Any]]]
    text_at: tuple[int, int]
    binary_at: tuple[int, int] | None
    buffers: tuple[memoryview | None, ...]
    fetched: Mapping[str, bytes]

    @property
    def is_binary(self) -> bool:
        """Tell whether it is a GLB, not a .gltf."""
        return self.text_at[0] > 0


def open_container(
    data: bytes, *, name: str = "", limits: Limits = _LIMITS, beside: Beside | None = None
) -> Container:  # fmt: skip
    """Open a glTF file.

    Args:
        data: the file.
        name: what it is called, for messages.
        limits: beyond these it is refused.
        beside: reads a file that this one names, relative to its folder.

    Raises:
        InputError: it is no glTF, is damaged, or packed in a way that is not read.
    """
    try:
        if len(data) > limits.bytes:
            raise InputError(f"{len(data)} bytes, more than {limits.bytes}", hint="limits.bytes allows more")
        text_at, binary_at = _chunks(data) if data[:4] == _MAGIC else ((0, len(data)), None)
        tree = _parsed(data, *text_at)
        refuse_packed(tree)
        fetched: dict[str, bytes] = {}
        buffers = _buffers(data, tree, binary_at, limits, _remembering(beside, fetched))
        tables = {key: table(tree, key) for key in _TABLES}
        return Container(name, data, tree, tables, text_at, binary_at, buffers, fetched)
    except InputError as error:
        raise (error.within(name) if name and not error.file else error) from None


def _remembering(beside: Beside | None, fetched: dict[str, bytes]) -> Beside | None:
    """Read files that are named as `beside` does, and keep them."""
    if beside is None:
        return None

    def fetch(path: str) -> bytes:
        if path not in fetched:
            fetched[path] = beside(path)
        return fetched[path]

    return fetch


def neighbours(tree: Mapping[str, Any]) -> tuple[str, ...]:
    """List the files that a glTF names: its buffers, then its images; each once."""
    rows = [*table(tree, "buffers"), *table(tree, "images")]
    named = [text(row, "uri") for row in rows]
    return tuple(dict.fromkeys(_path(uri) for uri in named if uri and not _DATA_URI.match(uri)))


def _chunks(data: bytes) -> tuple[tuple[int, int], tuple[int, int] | None]:
    """Find where JSON and binary chunk of a GLB stand."""
    if len(data) < _HEADER + _CHUNK:
        raise InputError("the file is cut short within its header")
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise InputError(
            f"version {version} of GLB, not 2", hint="`npx gltf-pipeline -i IN.glb -o OUT.glb` converts version 1"
        )
    if length > len(data):
        raise InputError(f"the file is cut short: it says {length} bytes, and has {len(data)}")
    at, found = _HEADER, dict[int, tuple[int, int]]()
    while at + _CHUNK <= length:
        size, kind = struct.unpack_from("<II", data, at)
        start = at + _CHUNK
        if start + size > length:
            raise InputError(f"a part of the file says {size} bytes, {length - start} are left for it")
        if not found and kind != _JSON:
            raise InputError("its first part is not JSON")
        found.setdefault(kind, (start, start + size))
        at = start + size + (-size % 4)
    if _JSON not in found:
        raise InputError("it has no JSON")
    return found[_JSON], found.get(_BIN)


def _parsed(data: bytes, start: int, stop: int) -> dict[str, Any]:
    raw = data[start:stop]
    try:
        tree = json.loads(raw.decode("utf-8-sig").rstrip(" \0\t\r\n"))
    except UnicodeDecodeError:
        raise InputError("its JSON is not UTF-8; this is no glTF, or a damaged one") from None
    except json.JSONDecodeError as error:
        place = f" at line {error.lineno}, column {error.colno}"
        raise InputError(f"its JSON is damaged{place}: {error.msg}") from None
    except (RecursionError, ValueError):
        raise InputError("its JSON nests too deeply or holds numbers too long to be meant") from None
    if not isinstance(tree, dict) or not isinstance(tree.get("asset"), dict):
        raise InputError("its JSON is no glTF: there is no asset")
    version = text(tree["asset"], "version")
    if not version.startswith("2"):
        raise InputError(f"glTF of version {version or 'unknown'}, not 2")
    return tree


def refuse_packed(tree: Mapping[str, Any]) -> None:
    """Refuse what is compressed by meshopt or Draco.

    Raises:
        InputError: it is compressed; the hint is a command that decompresses it.
    """
    needed = tree.get("extensionsRequired", [])
    used = set(filter(lambda each: isinstance(each, str), needed)) if isinstance(needed, list) else set()
    for view in table(tree, "bufferViews"):
        extensions = view.get("extensions")
        used |= set(extensions) if isinstance(extensions, dict) else set()
    for extension, called in _PACKED.items():
        if extension in used:
            raise InputError(f"it is compressed by {called} ({extension}), which is not read", hint=_UNDO)


def _buffers(
    data: bytes, tree: Mapping[str, Any], binary_at: tuple[int, int] | None, limits: Limits, beside: Beside | None
) -> tuple[memoryview | None, ...]:
    found: list[memoryview | None] = []
    known: dict[str, bytes] = {}
    for k, row in enumerate(table(tree, "buffers")):
        where = f"buffers[{k}]"
        length, uri = whole(row, "byteLength", where), text(row, "uri")
        if uri:
            if uri not in known:
                known[uri] = _fetched(uri, where, limits, beside)
            held = memoryview(known[uri])
        elif k == 0 and binary_at is not None:
            held = memoryview(data)[binary_at[0] : binary_at[1]]
        elif "extensions" in row:
            found.append(None)
            continue
        else:
            raise InputError(f"{where} has neither bytes in the file nor an address")
        if length > len(held):
            raise InputError(f"{where} says {length} bytes, and has {len(held)}")
        found.append(held[:length])
    return tuple(found)


def _fetched(uri: str, where: str, limits: Limits, beside: Beside | None) -> bytes:
    head = _DATA_URI.match(uri)
    if head is not None:
        body = uri[head.end() :]
        if ";base64" not in head[0].lower():
            return unquote_to_bytes(body)
        try:
            return base64.b64decode(body, validate=True)
        except (binascii.Error, ValueError):
            raise InputError(f"{where} is no Base64") from None
    path = _path(uri)
    if re.match(r"[a-zA-Z][a-zA-Z0-9+.-]+:", uri):
        raise InputError(f"{where} is {uri[:80]!r}; nothing is fetched from elsewhere", hint="save it beside the file")
    if path.startswith(("/", "\\")) or ".." in re.split(r"[/\\]", path) or "\0" in path:
        raise InputError(f"{where} is {uri[:80]!r}, outside of the file's folder", hint="put it beside the file")
    if beside is None:
        raise InputError(f"{where} is in a file of its own, {path!r}, which can't be read from here")
    fetched = beside(path)
    if len(fetched) > limits.bytes:
        raise InputError(f"{path} has {len(fetched)} bytes, more than {limits.bytes}", hint="limits.bytes allows more")
    return fetched


def _path(uri: str) -> str:
    return unquote_to_bytes(uri).decode("utf-8", "replace")

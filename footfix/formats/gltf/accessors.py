"""Accessors: the arrays of a glTF file, with strides, sparse values and normalised integers.

Source: glTF 2.0, 3.6.2 (accessors), 3.11 (normalised integers), 5.1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from footfix.errors import InputError
from footfix.formats.gltf.container import Container
from footfix.formats.gltf.fields import Row, child, index, text, whole
from footfix.motion.clip import Floats

Array = NDArray[Any]

# componentType -> how a number is stored.
_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_INDICES = (5121, 5123, 5125)
# type -> numbers of an element.
_SHAPES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_MOST_ZEROS = 1 << 23  # numbers of an accessor without a view, which no length of the file bounds


def read_accessor(container: Container, number: int) -> Array:
    """Read an accessor.

    Args:
        container: the file.
        number: of the accessor.

    Returns:
        (N,) of scalars, (N, k) of vectors, (N, 4, 4) of matrices, row by row. Normalised integers and floats as
        float64, other integers as they are stored.

    Raises:
        InputError: it reaches beyond its buffer, or what it says of itself makes no sense.
    """
    rows, where = container.tables["accessors"], f"accessors[{number}]"
    if not 0 <= number < len(rows):
        raise InputError(f"{where} is named, but there are only {len(rows)}", file=container.name)
    try:
        return _read(container, rows[number], where)
    except InputError as error:
        raise (error.within(container.name) if container.name and not error.file else error) from None


def read_floats(container: Container, number: int, width: int) -> Floats:
    """Read an accessor of vectors (or scalars, `width` 1) as (N, width) floats; integers are taken as they are.

    Raises:
        InputError: it can't be read, is of another width, or holds NaN or infinity.
    """
    found = np.asarray(read_accessor(container, number), dtype=np.float64)
    found = found.reshape(len(found), -1)
    if found.shape[1] != width:
        raise InputError(
            f"accessors[{number}] has {found.shape[1]} numbers an element, not {width}", file=container.name
        )
    if not np.isfinite(found).all():
        raise InputError(f"accessors[{number}] holds NaN or infinity", file=container.name)
    return found


def _read(container: Container, row: Row, where: str) -> Array:
    kind = text(row, "type")
    if kind not in _SHAPES:
        raise InputError(f"{where}.type is {kind[:20]!r}, none of {', '.join(_SHAPES)}")
    component = whole(row, "componentType", where)
    if component not in _TYPES:
        raise InputError(f"{where}.componentType is {component}, which glTF does not know")
    if kind.startswith("MAT") and component != 5126:
        raise InputError(f"{where} is a matrix of whole numbers, which is not read")
    count, width, dtype = whole(row, "count", where, least=1), _SHAPES[kind], np.dtype(_TYPES[component])
    view = index(row, "bufferView", where, len(container.tables["bufferViews"]))
    sparse = child(row, "sparse", where)
    if view is not None:
        found = _strided(container, view, whole(row, "byteOffset", where, default=0), count, width, dtype, where)
    elif count * width > _MOST_ZEROS:
        raise InputError(f"{where} says {count} elements, and has no bytes for them")
    else:
        found = np.broadcast_to(np.zeros(1, dtype), (count, width))
    if sparse:
        at, values = _sparse(container, sparse, count, width, dtype, where)
        found = np.array(found)
        found[at] = values
    if row.get("normalized") is True and dtype.kind in "iu":
        found = np.maximum(found / float(np.iinfo(dtype).max), -1.0)
    elif dtype.kind == "f":
        found = found.astype(np.float64)
    if kind == "SCALAR":
        return found[:, 0]
    side = {"MAT2": 2, "MAT3": 3, "MAT4": 4}.get(kind)
    return found if side is None else found.reshape(count, side, side).transpose(0, 2, 1)


def _sparse(container: Container, row: Row, count: int, width: int, dtype: Any, where: str) -> tuple[Array, Array]:
    """Read which elements of an accessor are given apart, and what they are."""
    where, views = f"{where}.sparse", len(container.tables["bufferViews"])
    few = whole(row, "count", where, least=1, below=count + 1)
    places, given = child(row, "indices", where), child(row, "values", where)
    component = whole(places, "componentType", where)
    if component not in _INDICES:
        raise InputError(f"{where}.indices.componentType is {component}, no type of indices")
    found = []
    for part, size, kind in ((places, 1, np.dtype(_TYPES[component])), (given, width, dtype)):
        view = index(part, "bufferView", where, views)
        if view is None:
            raise InputError(f"{where} has no bytes")
        found.append(_strided(container, view, whole(part, "byteOffset", where, default=0), few, size, kind, where))
    at = found[0][:, 0].astype(np.int64)
    if int(at.max()) >= count:
        raise InputError(f"{where} names element {int(at.max())}, but there are {count} of them")
    return at, found[1]


def _strided(
    container: Container, view: int, offset: int, count: int, width: int, dtype: Any, where: str
) -> Array:  # fmt: skip
    """Look at `count` elements of a buffer view as (count, width), without a copy."""
    row, place = container.tables["bufferViews"][view], f"bufferViews[{view}]"
    buffer = index(row, "buffer", place, len(container.buffers))
    if buffer is None:
        raise InputError(f"{place} has no buffer")
    held = container.buffers[buffer]
    if held is None:
        raise InputError(f"{place} lies in a buffer without bytes")
    start, length = whole(row, "byteOffset", place, default=0), whole(row, "byteLength", place, least=1)
    if start + length > len(held):
        raise InputError(f"{place} ends at byte {start + length}, its buffer at {len(held)}")
    size = width * dtype.itemsize
    stride = whole(row, "byteStride", place, default=size, below=256) or size
    if stride < size:
        raise InputError(f"{place} has an element every {stride} bytes, but one of {where} takes {size}")
    if offset + stride * (count - 1) + size > length:
        raise InputError(f"{where} reaches beyond {place}, which has {length} bytes")
    return np.ndarray((count, width), dtype, held, start + offset, (stride, dtype.itemsize))

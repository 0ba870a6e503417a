"""Motion as compact text: rounded, second differences, variable-length bytes, base64.

A joint moves smoothly, so the second difference of its position, in half millimetres, mostly fits a single byte. The
page decodes it with one loop (codec.js).
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footfix.motion.clip import Floats

_LARGEST = 1 << 28  # its second differences still fit the 32 bits of the page's integers


def quantize(values: Floats, quantum: float) -> NDArray[np.int32]:
    """Round values to whole multiples of a quantum; NaN becomes 0, large values are clipped."""
    finite = np.nan_to_num(values / quantum, nan=0.0, posinf=_LARGEST, neginf=-_LARGEST)
    return np.rint(np.clip(finite, -_LARGEST, _LARGEST)).astype(np.int32)


def pack(steps: NDArray[np.int32]) -> str:
    """Pack series of integers.

    Args:
        steps: (N, ...) N samples of each series.

    Returns:
        Base64 of, series after series, the second differences (the samples before the first taken as 0),
        zigzag-folded, in 7-bit groups, lowest first, the high bit set on all but the last group.
    """
    series = np.ascontiguousarray(np.moveaxis(steps, 0, -1)).reshape(-1, len(steps))
    if not series.size:
        return ""
    bend = np.diff(series, n=2, axis=1, prepend=np.zeros((len(series), 2), np.int32)).ravel()
    folded = ((bend << 1) ^ (bend >> 31)).view(np.uint32)
    return base64.b64encode(_groups(folded).tobytes()).decode("ascii")


def _groups(values: NDArray[np.uint32]) -> NDArray[np.uint8]:
    """Split each value into as many 7-bit groups as it needs."""
    sizes = np.ones(len(values), np.uint8)
    for bits in (7, 14, 21, 28):
        sizes += values >= np.uint32(1 << bits)
    longest = int(sizes.max())
    if longest == 1:
        return values.astype(np.uint8)
    ends = np.cumsum(sizes, dtype=np.intp)
    starts = ends - sizes
    out = np.empty(int(ends[-1]), np.uint8)
    out[starts] = (values & 127) | ((sizes > 1).astype(np.uint32) << 7)
    for k in range(1, longest):
        more = np.flatnonzero(sizes > k)
        high = (sizes[more] > k + 1).astype(np.uint32) << 7
        out[starts[more] + k] = ((values[more] >> np.uint32(7 * k)) & 127) | high
    return out


def unpack(packed: str, shape: tuple[int, ...]) -> NDArray[np.int32]:
    """Invert `pack`, for tests and to read the motion out of a page.

    Args:
        packed: what `pack` gave.
        shape: (N, ...) of the samples.
    """
    raw = np.frombuffer(base64.b64decode(packed), np.uint8)
    if not raw.size:
        return np.zeros(shape, np.int32)
    starts = np.concatenate([[0], np.flatnonzero(raw < 128)[:-1] + 1])
    place = np.arange(len(raw)) - np.repeat(starts, np.diff(np.append(starts, len(raw))))
    groups: NDArray[Any] = (raw & 127).astype(np.int64) << (7 * place)
    folded = np.add.reduceat(groups, starts)
    bend = (folded >> 1) ^ -(folded & 1)
    series = np.cumsum(np.cumsum(bend.reshape(-1, shape[0]), axis=1), axis=1)
    return series.T.reshape(shape).astype(np.int32)

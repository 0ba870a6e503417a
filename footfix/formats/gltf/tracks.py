"""Tracks: what the channels of an animation do, and what they are at any time. Source: glTF 2.0, 3.11, appendix C."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from footfix.errors import InputError
from footfix.formats.gltf.accessors import read_accessor
from footfix.formats.gltf.container import Container
from footfix.formats.gltf.fields import child, index, rows_of, text
from footfix.formats.gltf.nodes import node_at
from footfix.motion import rotation
from footfix.motion.clip import Floats, Ints, constant_track

WIDTHS = {"translation": 3, "rotation": 4, "scale": 3}
_MODES = ("LINEAR", "STEP", "CUBICSPLINE")
_ON_A_KEY = 1e-3  # of a step: a time as near to a key is the key's, whose numbers are then taken as they stand


@dataclass(frozen=True, eq=False)
class Track:
    """One channel of an animation.

    Args:
        channel, sampler: their indices in the animation.
        node: that it moves.
        path: "translation", "rotation", "scale" or "weights".
        times: (K,) [s] of its keys.
        values: (K, w) at its keys.
        mode: "LINEAR", "STEP" or "CUBICSPLINE".
        tangents: (2, K, w) into and out of each key, for "CUBICSPLINE".
    """

    channel: int
    sampler: int
    node: int
    path: str
    times: Floats
    values: Floats
    mode: str
    tangents: Floats | None = None

    @property
    def constant(self) -> bool:
        """Tell whether it never changes."""
        still = self.tangents is None or not np.any(self.tangents)
        return still and (len(self.values) == 1 or bool(np.all(self.values == self.values[0])))

    def at(self, times: Floats) -> Floats:
        """Compute its values (F, w) at some times [s]; before the first key and after the last, the value of that key.

        Args:
            times: (F,) [s], evenly spaced.
        """
        if self.constant:
            return constant_track(self.values[0], len(times))
        last = len(self.times) - 1
        near = _ON_A_KEY * (times[1] - times[0] if len(times) > 1 else 0.0)
        left = np.clip(np.searchsorted(self.times, times + near, side="right") - 1, 0, last)
        right = np.minimum(left + 1, last)
        gap = self.times[right] - self.times[left]
        since = np.clip(times - self.times[left], 0.0, gap)
        since[since <= near] = 0.0
        u = np.divide(since, gap, out=np.zeros_like(gap), where=gap > 0.0)
        if self.mode == "STEP" or not np.any(u):
            return self.values[left]
        a, b = self.values[left], self.values[right]
        if self.tangents is not None:
            return self._spline(a, b, left, right, gap, u)
        if self.path != "rotation":
            return np.asarray(a + u[:, None] * (b - a))
        between = u > 0.0
        a[between] = rotation.slerp(a[between], b[between], u[between])
        return a

    def _spline(self, a: Floats, b: Floats, left: Ints, right: Ints, gap: Floats, u: Floats) -> Floats:
        """Interpolate between keys by Hermite splines (glTF 2.0, appendix C.4)."""
        assert self.tangents is not None
        u, gap = u[:, None], gap[:, None]
        out, into = gap * self.tangents[1][left], gap * self.tangents[0][right]
        found = (
            (2.0 * u**3 - 3.0 * u**2 + 1.0) * a + (u**3 - 2.0 * u**2 + u) * out
            + (3.0 * u**2 - 2.0 * u**3) * b + (u**3 - u**2) * into
        )  # fmt: skip
        return rotation.normalize(found) if self.path == "rotation" else np.asarray(found)


def animation_names(container: Container) -> tuple[str, ...]:
    """List what the animations are called, each by a name of its own; those without one by their number."""
    found: dict[str, None] = {}
    count: dict[str, int] = {}
    for k, row in enumerate(container.tables["animations"]):
        plain = text(row, "name").strip() or f"animation {k}"
        name = plain
        while name in found:
            count[plain] = count.get(plain, 1) + 1
            name = f"{plain} ({count[plain]})"
        found[name] = None
    return tuple(found)


def morphs_only(container: Container, animation: int) -> bool:
    """Tell whether an animation moves no node, but changes the shapes of meshes: a face that smiles."""
    row, where = container.tables["animations"][animation], f"animations[{animation}]"
    try:
        targets = [child(each, "target", where) for each in rows_of(row, "channels", where)]
    except InputError:
        return False  # it is damaged, which is reported when it is read
    return bool(targets) and all(target.get("path") == "weights" for target in targets)


def read_tracks(container: Container, animation: int) -> Mapping[tuple[int, str], Track]:
    """Read the channels of an animation that move nodes: (node, path) -> track.

    Args:
        container: the file.
        animation: its index.

    Raises:
        InputError: the keys of one make no sense.
    """
    row, where = container.tables["animations"][animation], f"animations[{animation}]"
    samplers, found = rows_of(row, "samplers", where), dict[tuple[int, str], Track]()
    known: dict[int, tuple[Floats, Floats, str, Floats | None]] = {}
    inputs: dict[int, Floats] = {}
    for k, channel in enumerate(rows_of(row, "channels", where)):
        here = f"{where}.channels[{k}]"
        target = child(channel, "target", here)
        node, path = node_at(target, f"{here}.target", container), text(target, "path")
        if node is None or path not in (*WIDTHS, "weights") or (node, path) in found:
            continue
        sampler = index(channel, "sampler", here, len(samplers))
        if sampler is None:
            raise InputError(f"{here} has no sampler")
        if sampler not in known:
            known[sampler] = _keys(container, samplers[sampler], f"{where}.samplers[{sampler}]", inputs)
        times, values, mode, tangents = known[sampler]
        if path in WIDTHS and values.shape[1] != WIDTHS[path]:
            raise InputError(f"{here}: a {path} of {values.shape[1]} numbers, not {WIDTHS[path]}")
        if path == "rotation":
            values = _turns(values, here)
        found[node, path] = Track(k, sampler, node, path, times, values, mode, tangents)
    return found


def _keys(
    container: Container, row: Mapping[str, object], where: str, inputs: dict[int, Floats]
) -> tuple[Floats, Floats, str, Floats | None]:
    """Read the times and values of a sampler, how they are joined, and the tangents of splines."""
    mode = text(row, "interpolation") or "LINEAR"
    if mode not in _MODES:
        raise InputError(f"{where}.interpolation is {mode[:20]!r}, none of {', '.join(_MODES)}")
    count = len(container.tables["accessors"])
    taken, given = index(row, "input", where, count), index(row, "output", where, count)
    if taken is None or given is None:
        raise InputError(f"{where} has no keys")
    if taken not in inputs:
        inputs[taken] = _times(container, taken, where)
    times = inputs[taken]
    values = np.asarray(read_accessor(container, given), dtype=np.float64)
    values = values.reshape(len(values), -1)
    parts = 3 if mode == "CUBICSPLINE" else 1
    elements = len(times) * parts
    if values.size % elements or (values.shape[1] > 1 and len(values) != elements):
        raise InputError(f"{where} has {len(times)} keys, and {len(values)} values")
    if not np.isfinite(values).all():
        raise InputError(f"{where} holds NaN or infinity")
    values = values.reshape(elements, -1)
    if parts == 1:
        return times, values, mode, None
    split = values.reshape(len(times), 3, -1).transpose(1, 0, 2)
    return times, split[1], mode, split[[0, 2]]


def _times(container: Container, accessor: int, where: str) -> Floats:
    times = np.asarray(read_accessor(container, accessor), dtype=np.float64)
    if times.ndim != 1 or not np.isfinite(times).all():
        raise InputError(f"{where} has times that are NaN or infinite")
    if np.any(np.diff(times) < 0.0) or times[0] < -1.0:
        raise InputError(f"{where} has times that go back")
    return times


def _turns(values: Floats, where: str) -> Floats:
    sizes = np.linalg.norm(values, axis=1)
    if sizes.min() < 1e-6:
        raise InputError(f"{where} has a rotation of no length")
    off = np.abs(sizes - 1.0) > 1e-7  # numbers of four bytes are no nearer to 1 than that
    return np.where(off[:, None], values / sizes[:, None], values)

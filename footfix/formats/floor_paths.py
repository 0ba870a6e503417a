"""Paths over the floor: points in CSV, SVG paths, and shapes by name, as points (N, 2) in x and z."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import PurePath

import numpy as np

from footfix.errors import InputError, UsageError
from footfix.formats.svg_path import points_of
from footfix.motion.clip import Floats, frozen

_SHAPE = re.compile(r"(line|circle|sine):(.*)", re.IGNORECASE | re.DOTALL)
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?"
_SVG = re.compile(rf"\s*[Mm]\s*{_NUMBER}")
_EARTH = 6_371_008.8  # [m] mean radius
_FINE = 720  # points of a circle, or of a wave
_KINDS = "a CSV file of points, an SVG file or path, or line:10, circle:2, sine:1x6"


@dataclass(frozen=True, eq=False)
class DrawnPath:
    """A path as it was given.

    Args:
        points: (N, 2) x and z, in metres where it is a shape, else in units of the file.
        relative: whether it begins where the walk does, in its direction: x to its left, z ahead.
        name: what it was given as.
    """

    points: Floats
    relative: bool
    name: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", frozen(self.points))

    def metres(self, unit: float) -> Floats:
        """Give the points (N, 2) [m], with `unit` [m] of what was read from a file."""
        return self.points if self.relative else np.asarray(self.points * unit)


def shape(text: str) -> DrawnPath | None:
    """Read the path that a text names or is: a shape, or an SVG path; None where it may name a file.

    Args:
        text: "line:10", "circle:2" (to the left; "circle:-2" to the right), "sine:1x6" (1 m aside, 6 m a wave; as
            "sine:1x6x4" four of them), or "M 0 0 L 4 0 ...".

    Raises:
        UsageError: a shape has no such size.
    """
    found = _SHAPE.fullmatch(text.strip())
    if found is None:
        return DrawnPath(points_of(text, "the path"), False, "SVG path") if _SVG.match(text) else None
    kind = found[1].lower()
    sizes = found[2].strip().lower().split("x")
    try:
        numbers = [float(each) for each in sizes]
        return DrawnPath(_SHAPES[kind](*numbers), True, text.strip())
    except (TypeError, ValueError):
        example = {"line": "line:10", "circle": "circle:2", "sine": "sine:1x6"}[kind]
        raise UsageError(f"{text!r} is no {kind}; {example} is one, in metres") from None


def _line(length: float) -> Floats:
    return np.array([[0.0, 0.0], [0.0, _size(length)]])


def _circle(radius: float) -> Floats:
    _size(abs(radius))
    turn = np.linspace(0.0, 2.0 * np.pi, _FINE + 1)
    points = np.stack([radius * (1.0 - np.cos(turn)), abs(radius) * np.sin(turn)], axis=1)
    points[-1] = points[0]
    return points


def _sine(aside: float, wave: float, count: float = 2.0) -> Floats:
    ahead = np.linspace(0.0, _size(wave) * _size(count), round(_FINE * count) + 1)
    return np.stack([aside * np.sin(2.0 * np.pi * ahead / wave), ahead], axis=1)


def _size(length: float) -> float:
    if not 0.0 < length < 1e5:
        raise ValueError
    return length


_SHAPES: dict[str, Callable[..., Floats]] = {"line": _line, "circle": _circle, "sine": _sine}


def read_path(data: bytes, name: str) -> DrawnPath:
    """Read a file of a path: SVG, or points in CSV.

    Args:
        data: the bytes of the file.
        name: what it is called.

    Raises:
        InputError: it holds no path.
    """
    text = data.decode("utf-8-sig", "replace")
    if PurePath(name).suffix.lower() == ".svg" or "<svg" in text[:2000].lower():
        found = re.findall(r"<path\b[^>]*?\bd\s*=\s*(?:\"([^\"]*)\"|'([^']*)')", text, re.DOTALL)
        if not found:
            lines = re.search(r"<poly(?:line|gon)\b[^>]*?\bpoints\s*=\s*[\"']([^\"']*)[\"']", text, re.DOTALL)
            if not lines:
                raise InputError("no <path d=...> and no <polyline> in it", file=name)
            return DrawnPath(points_of(f"M {lines[1]}", name), False, name)
        return DrawnPath(points_of(found[0][0] or found[0][1], name), False, name)
    if _SVG.match(text):
        return DrawnPath(points_of(text, name), False, name)
    return DrawnPath(_table(text, name), False, name)


def _table(text: str, name: str) -> Floats:
    """Read x and z of a table of points, (N, 2)."""
    head = text[:4000]
    comma = next((each for each in (";", "\t", ",") if each in head), None)
    if comma is None:
        rows = [line.split() for line in text.splitlines()]
    else:
        rows = [[cell.strip() for cell in row] for row in csv.reader(io.StringIO(text), delimiter=comma)]
    decimal = comma == ";" and "," in head and "." not in head
    numbered = [(k + 1, row) for k, row in enumerate(rows) if any(row) and not row[0].startswith("#")]
    if not numbered:
        raise InputError("it is empty; " + _KINDS + " is a path", file=name)
    first = numbered[0][1]
    titles = [] if _numbers(first, decimal) is not None else [cell.strip("\"' ").lower() for cell in first]
    body = numbered[1:] if titles else numbered
    left, right, globe = _columns(titles, len(first), name, numbered[0][0])
    points = []
    for line, row in body:
        cells = _numbers([row[k] if k < len(row) else "" for k in (left, right)], decimal)
        if cells is None:
            raise InputError(f"no two numbers in {', '.join(row)!r}", file=name, line=line)
        points.append(cells)
    if not points:
        raise InputError("it holds no points", file=name)
    found = np.array(points)
    return _on_globe(found) if globe else found


def _numbers(cells: Sequence[str], decimal: bool) -> list[float] | None:
    try:
        return [float(cell.replace(",", ".") if decimal else cell) for cell in cells if cell != ""] or None
    except ValueError:
        return None


def _columns(titles: Sequence[str], count: int, name: str, line: int) -> tuple[int, int, bool]:
    """Find which columns are x and z, and whether they are degrees of longitude and latitude."""
    short = [re.sub(r"[\s_\[(].*", "", title) for title in titles]
    for left, right, globe in (("x", "z", False), ("lon", "lat", True), ("longitude", "latitude", True),
                               ("lng", "lat", True), ("x", "y", False)):  # fmt: skip
        if left in short and right in short:
            return short.index(left), short.index(right), globe
    if titles:
        raise InputError(
            f"no columns x and z among {', '.join(titles)}", file=name, line=line,
            hint="name them x and z, x and y, or lon and lat",
        )  # fmt: skip
    if count not in (2, 3):
        raise InputError(f"{count} columns without names", file=name, line=line, hint="points are x, z or x, y, z")
    return 0, count - 1, False


def _on_globe(degrees: Floats) -> Floats:
    """Convert degrees of longitude and latitude to metres east and south of the first point, (N, 2)."""
    lon, lat = np.radians(degrees - degrees[0]).T
    return _EARTH * np.stack([lon * np.cos(np.radians(degrees[0, 1])), -lat], axis=1)

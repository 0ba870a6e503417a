"""SVG path data as points: lines, Bezier curves and arcs, laid out densely."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from footfix.errors import InputError
from footfix.motion.clip import Floats

_TOKEN = re.compile(r"([MmLlHhVvCcSsQqTtAaZz])|([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|([\s,]+)|(.)", re.DOTALL)
_TAKES = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
_FINE = 48  # points of a curve

Point = complex  # x + i y


def points_of(data: str, name: str) -> Floats:
    """Read the points (N, 2) of path data; y of the drawing, which goes down, is z.

    Args:
        data: "M 0 0 L 4 0 C ...".
        name: for messages.

    Raises:
        InputError: it is no path data, or more than one path.
    """
    here = start = 0j
    points: list[Point] = []
    before, control = "", 0j
    for command, numbers in _commands(data, name):
        kind, base = command.upper(), here if command.islower() else 0j
        if kind == "M" and points:
            raise InputError("the path has a gap: it goes on somewhere else", file=name, hint="draw it in one line")
        if kind == "M":
            start = here = base + complex(*numbers)
            points.append(here)
        elif not points:
            raise InputError(f"path data begins with {command!r}, not with M", file=name)
        elif kind == "Z":
            points += [start] if abs(here - start) > 0.0 else []
            here = start
        else:
            piece, control = _piece(kind, here, base, numbers, control if before in _BEFORE.get(kind, "") else here)
            points += piece
            here = points[-1]
        before = kind
    return np.array([[point.real, point.imag] for point in points]).reshape(-1, 2)


_BEFORE = {"S": "CS", "T": "QT"}


def _piece(kind: str, here: Point, base: Point, numbers: Sequence[float], control: Point) -> tuple[list[Point], Point]:
    """List the points of one piece after `here`, and its last control point."""
    if kind == "H":
        return [complex(base.real + numbers[0], here.imag)], here
    if kind == "V":
        return [complex(here.real, base.imag + numbers[0])], here
    if kind == "A":
        return _arc(here, base + complex(*numbers[5:]), numbers), here
    given = [base + complex(a, b) for a, b in zip(numbers[::2], numbers[1::2], strict=True)]
    if kind == "L":
        return given, here
    if kind in "ST":
        given.insert(0, 2.0 * here - control)
    return _bezier([here, *given]), given[-2]


def _bezier(points: Sequence[Point]) -> list[Point]:
    u = np.linspace(0.0, 1.0, _FINE + 1)[1:]
    level = [np.full(len(u), point) for point in points]
    while len(level) > 1:  # de Casteljau
        level = [(1.0 - u) * a + u * b for a, b in pairwise(level)]
    out: list[Point] = level[0].tolist()
    return out


def _arc(here: Point, end: Point, numbers: Sequence[float]) -> list[Point]:
    """List points of an elliptical arc, by its centre (SVG 1.1, F.6.5)."""
    rx, ry, tilt, large, sweep = abs(numbers[0]), abs(numbers[1]), np.radians(numbers[2]), numbers[3], numbers[4]
    if rx == 0.0 or ry == 0.0 or here == end:
        return [end]
    turn = np.exp(-1j * tilt)
    half = 0.5 * (here - end) * turn
    far = (half.real / rx) ** 2 + (half.imag / ry) ** 2
    if far > 1.0:
        rx, ry, far = rx * np.sqrt(far), ry * np.sqrt(far), 1.0
    size = np.sqrt(max(1.0 / far - 1.0, 0.0)) * (-1.0 if bool(large) == bool(sweep) else 1.0)
    middle = size * complex(rx * half.imag / ry, -ry * half.real / rx)
    first, last = (complex((p - middle).real / rx, (p - middle).imag / ry) for p in (half, -half))
    begin, around = np.angle(first), np.angle(last / first)
    if sweep and around < 0.0:
        around += 2.0 * np.pi
    elif not sweep and around > 0.0:
        around -= 2.0 * np.pi
    angles = begin + around * np.linspace(0.0, 1.0, 2 * _FINE + 1)[1:]
    on = (rx * np.cos(angles) + 1j * ry * np.sin(angles) + middle) / turn + 0.5 * (here + end)
    return [*on[:-1].tolist(), end]


def _commands(data: str, name: str) -> list[tuple[str, list[float]]]:
    """Split path data into commands with their numbers; a letter with several sets of numbers becomes several."""
    found: list[tuple[str, list[float]]] = []
    letter, numbers = "", list[float]()
    for each in [*_tokens(data, name), "Z!"]:
        if isinstance(each, float):
            numbers.append(each)
            continue
        if letter:
            takes = _TAKES[letter.upper()]
            if (takes == 0) != (not numbers) or (takes and len(numbers) % takes):
                raise InputError(f"{len(numbers)} numbers after {letter!r}, which takes {takes}", file=name)
            pieces = [numbers[k : k + takes] for k in range(0, len(numbers), takes)] if takes else [[]]
            for k, piece in enumerate(pieces):
                again = letter if k == 0 or letter not in "Mm" else "l" if letter == "m" else "L"
                found.append((again, piece))
        letter, numbers = each, []
    return found


def _tokens(data: str, name: str) -> list[str | float]:
    out: list[str | float] = []
    letter = ""
    for found in _TOKEN.finditer(data):
        if found[4]:
            raise InputError(f"{found[4]!r} is no part of path data", file=name)
        if found[1]:
            letter = found[1]
            out.append(letter)
        elif found[2]:
            out += _flags(found[2], letter, out)
    return out


def _flags(number: str, letter: str, out: Sequence[str | float]) -> list[str | float]:
    """Read a number; flags of an arc, which may stand without blanks before the next number, are split off."""
    since = 0
    for each in reversed(out):
        if isinstance(each, str):
            break
        since += 1
    if letter in "Aa" and letter and since % 7 in (3, 4) and len(number) > 1 and number[0] in "01":
        first: list[str | float] = [float(number[0])]
        return first + _flags(number[1:], letter, [*out, *first])
    return [float(number)]

"""Paths as they are given: tables, drawings, shapes; and what is none of these."""

from __future__ import annotations

import numpy as np
import pytest

from footfix.errors import InputError, UsageError
from footfix.formats.floor_paths import DrawnPath, read_path, shape
from footfix.formats.svg_path import points_of
from footfix.motion.clip import Floats


def drawn(text: str) -> DrawnPath:
    found = shape(text)
    assert found is not None
    return found


def table(text: str, name: str = "way.csv") -> list[list[float]]:
    return read_path(text.encode(), name).points.tolist()


@pytest.mark.parametrize("text", [
    "0,1\n2,3\n", "x,z\n0,1\n2,3\n", "z;name;x\n1;a;0\n3;b;2\n", "\ufeffX (m)\tZ (m)\n0\t1\n2\t3\n", "0 9 1\n2 9 3\n",
    "x;z\n0,0;1,0\n2,0;3,0\n", "# a comment\nx,y\n0,1\n2,3\n\n",
])  # fmt: skip
def test_tables_of_points(text: str) -> None:
    assert table(text) == [[0.0, 1.0], [2.0, 3.0]]


def test_degrees_become_metres_east_and_south() -> None:
    found = np.array(table("lon,lat\n11.0,48.0\n11.001,48.0\n11.0,48.001\n"))
    assert found[1] == pytest.approx([111195.0 * np.cos(np.radians(48.0)) / 1000.0, 0.0], rel=1e-3)
    assert found[2] == pytest.approx([0.0, -111.195], rel=1e-3)


@pytest.mark.parametrize(("text", "said"), [
    ("a,b\n1,2\n", "no columns x and z"), ("x,z\n1,2\n3,two\n", ":3"), ("", "empty"), ("1\n2\n", "1 columns"),
    ("x,z\n", "no points"),
])  # fmt: skip
def test_what_is_wrong_with_a_table_is_said(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        table(text)


def test_shapes_have_the_sizes_they_name() -> None:
    line, circle, sine = (drawn(text) for text in ("line:10", "circle:2", "sine:1x6x3"))
    assert line.points.tolist() == [[0.0, 0.0], [0.0, 10.0]]
    assert np.allclose(np.hypot(circle.points[:, 0] - 2.0, circle.points[:, 1]), 2.0)
    assert circle.points[1, 0] > 0.0  # to the left
    assert drawn("circle:-2").points[1, 0] < 0.0
    assert sine.points[-1, 1] == 18.0
    assert np.ptp(sine.points[:, 0]) == pytest.approx(2.0, abs=1e-3)
    assert all(each.relative for each in (line, circle, sine))
    assert shape("way.csv") is None


@pytest.mark.parametrize("text", ["line:", "line:-3", "circle:0", "circle:two", "sine:1", "sine:1x0", "line:1x2"])
def test_shapes_of_no_size_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="is no"):
        shape(text)


def ends(data: str) -> list[float]:
    found = points_of(data, "")
    return [*found[0].tolist(), *found[-1].tolist()]


@pytest.mark.parametrize(("data", "end"), [
    ("M 1 2 L 4 6", [4, 6]), ("m1,2 3,4", [4, 6]), ("M1 2h3v4", [4, 6]), ("M1 2H4V6", [4, 6]),
    ("M1 2c0 1 3 3 3 4", [4, 6]), ("M1 2q1 1 3 4", [4, 6]), ("M1 2q1 1 2 2t1 2", [4, 6]),
    ("M1 2C1 2 2 2 2 3S4 5 4 6", [4, 6]), ("M1 2a3 3 0 013 4", [4, 6]), ("M1 2L4 2L4 6Z", [1, 2]),
])  # fmt: skip
def test_drawings_end_where_they_should(data: str, end: list[float]) -> None:
    assert ends(data) == pytest.approx([1.0, 2.0, *end])


def test_curves_are_curves() -> None:
    arc = points_of("M 2 0 A 2 2 0 0 1 0 2", "")
    assert np.allclose(np.hypot(*arc.T), 2.0)
    assert np.all(arc > -1e-9)  # the short way round
    large = points_of("M 2 0 A 2 2 0 1 0 0 2", "")
    assert np.allclose(np.hypot(*large.T), 2.0)
    assert large.min() < -1.9
    u = np.linspace(0.0, 1.0, 49)
    bezier: Floats = points_of("M 0 0 C 0 1 2 1 2 0", "")
    assert np.allclose(bezier, np.stack([6 * u**2 * (1 - u) + 2 * u**3, 3 * u * (1 - u)], axis=1))
    smooth = points_of("M 0 0 Q 1 1 2 0 T 4 0", "")
    assert smooth[:, 1].min() == pytest.approx(-0.5, abs=1e-3)  # the mirrored control point


@pytest.mark.parametrize(("data", "said"), [
    ("L 1 1", "not with M"), ("M 0 0 L 1", "1 numbers after 'L'"), ("M 0 0 L 1 1 M 5 5 L 6 6", "gap"),
    ("M 0 0 L 1 1 & 3", "'&'"),
])  # fmt: skip
def test_what_is_wrong_with_a_drawing_is_said(data: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        points_of(data, "way.svg")


def test_files_of_drawings() -> None:
    svg = b'<svg xmlns="http://www.w3.org/2000/svg"><path id="a" fill="none" d="M0 0L0 4"/></svg>'
    assert read_path(svg, "way.svg").points.tolist() == [[0.0, 0.0], [0.0, 4.0]]
    assert read_path(b'<svg><polyline points="0,0 0,4"/></svg>', "w.svg").points.tolist() == [[0.0, 0.0], [0.0, 4.0]]
    assert read_path(b"M0 0L0 400", "way.txt").metres(0.01).tolist() == [[0.0, 0.0], [0.0, 4.0]]
    with pytest.raises(InputError, match="no <path"):
        read_path(b"<svg></svg>", "way.svg")

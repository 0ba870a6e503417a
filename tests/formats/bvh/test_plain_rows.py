"""The quick reader of plain rows: whatever it takes, numpy's reader takes and finds the same, to the last bit."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from conftest import need, one_of_each_origin
from hypothesis import given, settings
from hypothesis import strategies as st

from footfix.formats.bvh.plain_rows import read_plain

HEAD = b"Frame Time: 0.01\n"
ENDS = st.sampled_from([b"\n", b"\r\n", b" \n", b"\n\n", b"\n \t\n", b"\t\n"])


@st.composite
def plain_rows(draw: st.DrawFn) -> bytes:
    decimals, columns = draw(st.integers(1, 8)), draw(st.integers(1, 5))
    size = 10 ** draw(st.integers(0, min(8, 15 - decimals)))
    numbers = st.floats(-size, size, exclude_min=True, exclude_max=True).map(lambda x: f"{x:.{decimals}f}")
    fits = numbers.filter(lambda word: len(word.lstrip("-").partition(".")[0]) <= min(8, 15 - decimals))
    rows = draw(st.lists(st.lists(fits, min_size=columns, max_size=columns), min_size=1, max_size=6))
    blank, end = draw(st.sampled_from([" ", "\t", "  "])), draw(ENDS)
    text = end.join(blank.join(row).encode() for row in rows)
    return text + end if draw(st.booleans()) else text


def by_numpy(text: bytes) -> np.ndarray | None:
    try:
        return np.loadtxt(BytesIO(text), comments=None, ndmin=2)
    except ValueError:
        return None


@settings(max_examples=60, deadline=None)
@given(plain_rows())
def test_plain_rows_are_taken(text: bytes) -> None:
    found, expected = read_plain(HEAD + text, len(HEAD)), by_numpy(text)
    assert found is not None and expected is not None
    assert found.shape == expected.shape
    assert found.tobytes() == expected.tobytes()


ODD = [b"0", b"9", b".", b"-", b"+", b" ", b"\t", b"\r", b"\n", b"\x0b", b"\x1c", b"\x85", b"\xa0", b"\0", b"e", b"/",
       b":", b"_", b"#", b",", b"x", b"\xff", b"99999999.9", b"-0.0", b"1e5", b"nan"]  # fmt: skip
EDITS = st.lists(st.tuples(st.integers(0, 200), st.sampled_from(ODD), st.booleans()), min_size=1, max_size=3)


@settings(max_examples=100, deadline=None)
@given(plain_rows(), EDITS)
def test_whatever_is_taken_is_what_numpy_finds(text: bytes, edits: list[tuple[int, bytes, bool]]) -> None:
    for at, odd, instead in edits:
        at %= len(text) + 1
        text = text[:at] + odd + text[at + instead :]
    found = read_plain(HEAD + text, len(HEAD))
    if found is not None:
        expected = by_numpy(text)
        assert expected is not None and found.shape == expected.shape
        assert found.tobytes() == expected.tobytes()


def test_long_rows_and_many() -> None:
    rng = np.random.default_rng(0)
    rows = rng.normal(0.0, 200.0, (1500, 40)).tolist()
    text = b"".join(b" ".join(b"%.6f" % x for x in row) + b"\r\n" for row in rows)
    found, expected = read_plain(HEAD + text, len(HEAD)), by_numpy(text)
    assert found is not None and expected is not None and np.array_equal(found, expected)
    assert read_plain(HEAD + text + b"1.000000", len(HEAD)) is None  # a row cut short
    assert read_plain(HEAD + b"1.0 " * 200_000, len(HEAD)) is None  # a row longer than what is looked at together


@pytest.mark.clips
def test_real_clips() -> None:
    taken = 0
    for path in need(one_of_each_origin(), "clips"):
        data = path.read_bytes()
        start = data.find(b"\n", data.find(b"Frame Time")) + 1
        found = read_plain(data, start)
        if found is not None:
            taken += 1
            assert found.tobytes() == np.loadtxt(BytesIO(data[start:]), ndmin=2).tobytes(), path.name
    assert taken

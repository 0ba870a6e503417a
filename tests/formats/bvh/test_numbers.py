"""Numbers as text and back: fixed-point formatting is Python's, and words stand where they are said to."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footfix.formats.bvh.fixed_point import fixed, read_back
from footfix.formats.bvh.numbers import decimals, number, token_chunks, tokens, words

VALUES = st.floats(allow_nan=False, allow_infinity=False, width=64) | st.floats(-1e4, 1e4)
TIES = st.builds(lambda n, places: (2 * n + 1) / (2 * 10**places), st.integers(-(10**9), 10**9), st.integers(1, 12))


def printed(value: float, places: int) -> str:
    text = f"{value:.{places}f}"
    return text.lstrip("-") if float(text) == 0.0 else text


@given(st.lists(VALUES | TIES, min_size=1, max_size=40), st.integers(0, 20))
def test_formatting_is_exact(values: list[float], places: int) -> None:
    letters = fixed(np.array(values), places)
    got = [row.tobytes().translate(None, b"\0").decode() for row in letters]
    assert got == [printed(value, places) for value in values]


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 60.0, 999.9999, 1e4, 1e6, 1e9, 1e15])
@pytest.mark.parametrize("places", [1, 2, 3, 4, 6, 7, 9, 10, 12, 13, 15, 16, 17, 18])
def test_formatting_is_exact_near_ties(scale: float, places: int) -> None:
    rng = np.random.default_rng(places)
    values = rng.normal(0.0, scale, 600)
    values[:300] = np.round(values[:300], places) + 0.5 * 10.0**-places
    got = [row.tobytes().translate(None, b"\0").decode() for row in fixed(values, places)]
    assert got == [printed(value, places) for value in values.tolist()]


@given(st.lists(VALUES | TIES, min_size=1, max_size=40), st.integers(0, 20))
def test_what_is_written_means_what_is_read(values: list[float], places: int) -> None:
    said = read_back(np.array(values), places)
    assert said.tobytes() == np.array([float(printed(value, places)) for value in values]).tobytes()


@pytest.mark.parametrize("places", [1, 6, 9, 10, 15])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 180.0, 1e4, 1e7, 1e12])
def test_what_is_written_means_what_is_read_near_ties(scale: float, places: int) -> None:
    values = np.random.default_rng(places).normal(0.0, scale, 600)
    values[:300] = np.round(values[:300], places) + 0.5 * 10.0**-places
    said = [float(printed(value, places)) for value in values.tolist()]
    assert read_back(values, places).tobytes() == np.array(said).tobytes()


@given(st.binary(max_size=300))
def test_words_stand_where_they_are_said_to(text: bytes) -> None:
    starts, ends = tokens(text, 0, len(text))
    assert [text[a:b] for a, b in zip(starts, ends, strict=True)] == words(text, 0, len(text))


def test_chunks_are_the_whole() -> None:
    text = b" 12.5\t-3 \r\n" * 300_000
    parts = list(token_chunks(text, 3, len(text) - 4))
    assert len(parts) > 2
    starts, ends = (np.concatenate(each) for each in zip(*parts, strict=True))
    whole_starts, whole_ends = tokens(text, 3, len(text) - 4)
    assert np.array_equal(starts, whole_starts)
    assert np.array_equal(ends, whole_ends)


@given(st.lists(st.sampled_from([b"1", b"-1.25", b"1.5e-10", b"2E5", b".5", b"7.", b"1e3", b"0.123456"]), min_size=1))
def test_decimals(split: list[bytes]) -> None:
    text = b" ".join(split)
    expected = {b"1": 0, b"-1.25": 2, b"1.5e-10": 1, b"2E5": 0, b".5": 1, b"7.": 0, b"1e3": 0, b"0.123456": 6}
    assert decimals(text, *tokens(text, 0, len(text))).tolist() == [expected[word] for word in split]


@pytest.mark.parametrize(
    ("word", "value"),
    [(b"1,5", 1.5), (b"-1e-3", -0.001), (b"+4", 4.0), (b"1_0", None), (b"x", None), (b"", None), (b"0x10", None),
     (b"1.#INF", math.inf), (b"-1.#INF00", -math.inf), (b"inf", math.inf), (b"9" * 500, None)],
)  # fmt: skip
def test_spellings(word: bytes, value: float | None) -> None:
    assert number(word) == value


@pytest.mark.parametrize("word", [b"nan", b"-nan", b"-nan(ind)", b"NaN", b"1.#QNAN", b"-1.#IND", b"-1.#IND00", b"null"])
def test_spellings_of_nan(word: bytes) -> None:
    value = number(word)
    assert value is not None
    assert math.isnan(value)

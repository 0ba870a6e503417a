"""Numbers that run together are named for what they are, and put apart where that is certain."""

from __future__ import annotations

import numpy as np
import pytest
from bvhmaker import PLAIN, plain
from conftest import SHARED

from footfix.errors import InputError
from footfix.formats.bvh import decode, repair, separate_numbers
from footfix.formats.bvh.unseparated_numbers import count_numbers, split_numbers
from footfix.jobs.inspect import repair_file
from footfix.settings import Settings


@pytest.mark.parametrize(("word", "numbers"), [
    ("12.5-3.1", ["12.5", "-3.1"]), ("-1-2-3", ["-1", "-2", "-3"]), ("1e-5", ["1e-5"]), ("-1.5E+3", ["-1.5E+3"]),
    ("1e-5-2.0e-3", ["1e-5", "-2.0e-3"]), ("0.+1", ["0.", "+1"]), (".5-.25", [".5", "-.25"]),
    ("12,5-3,1", ["12,5", "-3,1"]),
    ("1.2.3", ["1.2.3"]), ("1-", ["1-"]), ("--1", ["--1"]), ("a-1", ["a-1"]), ("2024-01-02x", ["2024-01-02x"]),
])  # fmt: skip
def test_a_sign_begins_a_number_unless_it_is_an_exponents(word: str, numbers: list[str]) -> None:
    assert split_numbers(word.encode()) == [each.encode() for each in numbers]


def glued(data: bytes, rows: slice = slice(None)) -> bytes:
    """The file without the blanks before minus signs, in some of its rows."""
    head, _, body = data.partition(b"Frame Time: ")
    first, *lines = body.split(b"\n")
    lines[rows] = [line.replace(b" -", b"-") for line in lines[rows]]
    return head + b"Frame Time: " + b"\n".join([first, *lines])


def minus(newline: bytes = b"\n") -> bytes:
    """A file with negative numbers in its rows, two of them one behind the other."""
    data = PLAIN[: PLAIN.index("0.00 9.00")].encode()
    row = b"%d.00 9.00 -1.25 0.00 0.00 5.50 -1e-3 -2 0 0 0 -0.50"
    return (data.replace(b"Frames: 4", b"Frames: 6") + b"\n".join(row % k for k in range(6)) + b"\n").replace(
        b"\n", newline
    )


@pytest.mark.parametrize("newline", [b"\n", b"\r\n"])
@pytest.mark.parametrize("rows", [slice(None), slice(2, 3), slice(5, 6), slice(0, 1)])
def test_they_are_named_with_their_place_and_repair_puts_them_apart(rows: slice, newline: bytes) -> None:
    whole = minus(newline)
    data = glued(whole, rows)
    assert data != whole
    with pytest.raises(InputError, match="run together") as told:
        decode(data)
    line = 1 + data[: data.index(b"9.00-1.25")].count(b"\n")
    assert (told.value.line, told.value.column) == (line, 6)
    assert "-1.25" in str(told.value) and "--repair" in str(told.value)
    mended, notes = separate_numbers(data)
    assert mended == whole  # to the byte
    assert [(note.id, note.line) for note in notes] == [("numbers-run-together", line)]
    again, told_all = repair_file(data, "a.bvh", Settings())
    assert np.array_equal(decode(again).values, decode(whole).values)
    assert told_all[0]["id"] == "numbers-run-together"
    assert repair(decode(again))[0] == again


def fixed(newline: bytes = b"\n") -> bytes:
    """A file whose numbers all have four decimals."""
    data = PLAIN[: PLAIN.index("0.00 9.00")].encode()
    row = b"%d.0000 9.0000 1.2500 0.0000 -0.0000 5.5000 -0.0010 12.5300 1.0000 0.0000 0.0000 -0.5000"
    return (data.replace(b"Frames: 4", b"Frames: 6") + b"\n".join(row % k for k in range(6)) + b"\n").replace(
        b"\n", newline
    )


@pytest.mark.parametrize(("a", "b"), [
    (b"12.5300 1.0000", b"12.53001.0000"), (b"0.0010 12.5300 1.0000 0.0000", b"0.001012.53001.00000.0000"),
    (b"-0.0010 12.5300", b"-0.001012.5300"), (b" 0.0000 -0.0000 5.5000", b" 0.0000-0.00005.5000"),
])  # fmt: skip
@pytest.mark.parametrize("newline", [b"\n", b"\r\n"])
@pytest.mark.parametrize("times", [-1, 2])
@pytest.mark.parametrize("comma", [False, True])
def test_without_a_sign_the_number_of_decimals_tells_them_apart(
    a: bytes, b: bytes, newline: bytes, times: int, comma: bool
) -> None:
    head, cut, body = fixed(newline).rpartition(b"0.0333333")
    body = body.replace(b".", b",") if comma else body
    a, b = (each.replace(b".", b",") if comma else each for each in (a, b))
    whole, data = head + cut + body, head + cut + body.replace(a, b, times)
    with pytest.raises(InputError, match="run together") as told:
        decode(data)
    word = data.index(b.split()[-1])
    assert told.value.line == 1 + data[:word].count(b"\n") and "--repair" in str(told.value)
    assert separate_numbers(data)[0] == whole


def test_all_numbers_of_all_rows_may_run_together() -> None:
    whole = fixed()
    head, body = whole[: whole.index(b"0.0000 9.0000")], whole[whole.index(b"0.0000 9.0000") :]
    data = head + body.replace(b" ", b"")
    with pytest.raises(InputError, match="run together"):
        decode(data)
    assert separate_numbers(data)[0] == whole


def test_where_the_number_of_decimals_varies_they_are_named_but_not_put_apart() -> None:
    data = fixed().replace(b"5.5000 ", b"5.5 ").replace(b"12.5300 1.0000", b"12.53001.0000", 1)
    with pytest.raises(InputError, match="run together") as told:
        decode(data)
    assert "not certain" in str(told.value) and "--repair" not in str(told.value)
    assert (told.value.line, told.value.column) == (1 + data[: data.index(b"12.53001")].count(b"\n"), 49)
    assert separate_numbers(data) == (data, ())


@pytest.mark.parametrize("part", [b"1", b"1.5", b"1-", b".", b"1e"])
def test_a_word_of_a_million_letters_that_is_no_number_stays_and_takes_no_hour(part: bytes) -> None:
    word = part * 300_000 + b"x"
    assert split_numbers(word) == split_numbers(word, 4) == [word] and count_numbers(word) == 1


def test_what_is_in_order_and_what_is_not_certain_stay_as_they_are() -> None:
    for data in (plain(), minus(), plain().replace(b"0.00 9.00", b"1e-5 9.00", 1), b"", b"no BVH, 1-2"):
        assert separate_numbers(data) == (data, ())
    odd = minus().replace(b" 9.00 -1.25", b" 9.00-1.25 7", 1)  # as many words as there are channels
    assert separate_numbers(odd) == (odd, ())
    short = glued(minus()).replace(b" 0 0 0-0.50", b" 0 0-0.50", 1)  # one number too few, however it is read
    assert separate_numbers(short)[0].split(b"\n")[-7] == short.split(b"\n")[-7]


def test_a_file_from_the_field_is_mended() -> None:
    path = SHARED / "faults" / "glued_minus.bvh"
    if not path.exists():
        pytest.skip(f"no clip: {path} is absent")
    data = path.read_bytes()
    with pytest.raises(InputError, match="run together"):
        decode(data)
    document = decode(repair_file(data, "glued_minus.bvh", Settings())[0])
    assert document.values.shape == (12, 69)

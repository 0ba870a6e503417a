"""Bytes of a live BVH, in whatever pieces they come, whole or broken."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SAMPLES
from hypothesis import given, settings
from hypothesis import strategies as st

from footfix.errors import InputError
from footfix.stream.bvh_lines import Header, Item, Lines, Row, Said, counted, header_of, with_room

FILE = (SAMPLES / "walk_skate.bvh").read_bytes()
START = FILE.index(b"\n", FILE.index(b"Frame Time")) + 1
HEAD, ROWS = FILE[:START], FILE[START:].splitlines(keepends=True)[:12]


def taken(data: bytes, sizes: list[int] | None = None) -> list[Item]:
    lines, found, at = Lines(), list[Item](), 0
    for size in sizes or [len(data)]:
        found += lines.feed(data[at : at + size])
        at += size
    found += lines.feed(data[at:])
    return found + lines.finish()


def rows(items: list[Item]) -> list[Row]:
    return [item for item in items if isinstance(item, Row)]


@given(st.lists(st.integers(1, 4000), max_size=20))
@settings(max_examples=20, deadline=None)
def test_it_does_not_matter_in_which_pieces_the_input_comes(sizes: list[int]) -> None:
    found = taken(HEAD + b"".join(ROWS), sizes)
    assert isinstance(found[0], Header)
    assert found[0].text == HEAD
    assert [row.written(row.values) for row in rows(found)] == ROWS


def test_only_numbers_that_changed_are_written_anew() -> None:
    (row,) = rows(taken(HEAD + ROWS[3]))
    values = row.values.copy()
    values[7] += 0.25
    old, new = ROWS[3].split(), row.written(values).split()
    assert [k for k, (a, b) in enumerate(zip(old, new, strict=True)) if a != b] == [7]
    assert float(new[7]) == pytest.approx(values[7], abs=1e-6)
    assert len(new[7].partition(b".")[2]) >= 6


def test_frames_that_end_with_bars_may_have_a_prefix_and_go_back_as_they_came() -> None:
    text = HEAD + b"".join(b"0 Char00 " + row.strip() + b"||" for row in ROWS)
    found = rows(taken(text))
    assert [row.written(row.values, bare=False) for row in found] == [b"0 Char00 " + r.strip() + b"||" for r in ROWS]
    assert [row.written(row.values).split() for row in found] == [r.split() for r in ROWS]


def test_what_is_no_number_is_replaced_by_the_last_one_that_was() -> None:
    words = ROWS[1].split()
    words[4] = b"nan"
    first, second = rows(taken(HEAD + ROWS[0] + b" ".join(words) + b"\n"))
    assert second.broken
    assert second.values[4] == first.values[4]
    assert float(second.written(second.values).split()[4]) == pytest.approx(first.values[4], abs=1e-6)


@pytest.mark.parametrize(
    ("broken", "kind"),
    [
        (b"1 2 3\n", "misfit"),
        (b"\x00\xff\xfe garbage \x80\n", "misfit"),
        (HEAD, "header-again"),
        (b"Frames: 12\n", "heading"),
    ],
)
def test_what_is_broken_is_left_out_and_said(broken: bytes, kind: str) -> None:
    found = taken(HEAD + ROWS[0] + broken + b"".join(ROWS[1:]))
    assert [item.kind for item in found if isinstance(item, Said)] == [kind]
    assert [row.text for row in rows(found)] == [row.rstrip(b"\r\n") for row in ROWS]


def test_an_end_in_the_middle_of_a_row_is_said() -> None:
    found = taken(HEAD + ROWS[0] + ROWS[1][:20])
    assert len(rows(found)) == 1
    assert isinstance(found[-1], Said)
    assert "middle of row 2" in found[-1].text


def test_another_rate_is_another_header() -> None:
    second = HEAD.replace(HEAD[HEAD.index(b"Frame Time:") :], b"Frame Time: 0.02\n")
    found = taken(HEAD + ROWS[0] + second + ROWS[1])
    assert [item.document.frame_time for item in found if isinstance(item, Header)] == pytest.approx([1 / 60, 0.02])
    assert len(rows(found)) == 2


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"".join(ROWS), "before any header"),
        (HEAD[:300], "within its header"),
        (b"hello", "does not begin with HIERARCHY"),
        (b"x" * 100_000, "no BVH header"),
        (HEAD + ROWS[0] + HEAD.replace(b"Head", b"Hat"), "another figure"),
    ],
)
def test_what_is_no_stream_is_refused_in_words(data: bytes, says: str) -> None:
    with pytest.raises(InputError, match=says):
        taken(data)


def test_garbage_without_an_end_does_not_pile_up() -> None:
    lines = Lines()
    list(lines.feed(HEAD))
    for _ in range(40):
        list(lines.feed(b"7" * 100_000))
    assert len(lines._rest) <= 1 << 21


@pytest.mark.parametrize("frames", [0, 7, 123456])
def test_the_count_of_frames_is_put_right_where_it_stands(frames: int) -> None:
    head, at = with_room(HEAD.replace(b"Frames: 301", b"Frames: 0"))
    text = counted(head, at, frames)
    whole = head if text is None else head[:at] + text + head[at + len(text) :]
    assert whole.split() == HEAD.replace(b"Frames: 301", b"Frames: %d" % frames).split()


def test_the_header_of_a_file_counts_no_frames() -> None:
    (header,) = (item for item in taken(HEAD) if isinstance(item, Header))
    assert header_of(header.document) == HEAD.replace(b"Frames: 301", b"Frames: 0")
    assert np.array_equal(header.document.skeleton.parents[:1], [-1])

"""Some frames of a file: header and rows as they stand, and another number of frames."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import SAMPLES, need, shared

from footfix.formats.bvh import decode
from footfix.formats.document import open_document, rewrite, select_frames
from footfix.motion.clip import Ints

SOME = np.array([3, 4, 5, 9, 3])
TEXT = (SAMPLES / "walk.bvh").read_bytes()


def rows(data: bytes) -> list[bytes]:
    return [line.strip() for line in data.split(b"Frame Time")[1].splitlines()[1:] if line.strip()]


@pytest.mark.parametrize("newline", [b"\n", b"\r\n"], ids=["LF", "CRLF"])
def test_rows_and_header_are_the_files_own_text(newline: bytes) -> None:
    data = TEXT.replace(b"\r\n", b"\n").replace(b"\n", newline)
    whole = decode(data)
    some = select_frames(whole, SOME)
    written = rewrite(some, some.clip)[0]
    assert written.split(b"MOTION")[0] == data.split(b"MOTION")[0]
    assert rows(written) == [rows(data)[k] for k in SOME]
    assert b"Frames: 5" + newline in written
    assert written.count(newline) == written.count(b"\n")


def test_what_is_selected_reads_as_those_frames() -> None:
    whole = decode(TEXT).placed(unit_m=0.01)
    some = select_frames(whole, SOME)
    assert (some.frames, some.frame_time, some.unit_m, some.name) == (5, whole.frame_time, 0.01, whole.name)
    assert np.array_equal(some.clip.positions, whole.clip.positions[SOME])
    assert np.array_equal(some.clip.rotations, whole.clip.rotations[SOME])
    again = decode(rewrite(some, some.clip)[0]).placed(unit_m=0.01)
    assert np.array_equal(again.clip.rotations, some.clip.rotations)


def test_all_frames_are_the_file() -> None:
    whole = decode(TEXT)
    assert rows(select_frames(whole, np.arange(whole.frames)).text) == rows(TEXT)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"Frames:", b"frames :"), (b"Frames: 301", b"Frames: 999"), (b"Frames: 301\n", b""),
        (b"Frame Time: 0.01666667", b"Frame Time: -1"), (b"0.0000 ", b"nan "),
    ],
    ids=["spelling", "count", "no count", "time", "not a number"],
)  # fmt: skip
def test_what_is_odd_in_a_file_stays_as_it_is_read(old: bytes, new: bytes) -> None:
    whole = decode(TEXT.replace(b"\r\n", b"\n").replace(old, new, 1))
    some = select_frames(whole, SOME)
    assert np.array_equal(some.values, whole.values[SOME], equal_nan=True)
    assert some.frame_time == whole.frame_time
    assert some.notes == whole.notes


@pytest.mark.clips
def test_files_of_other_tools_are_cut_as_they_read() -> None:
    for path in need(shared("clips"), "clips")[::12]:
        whole = open_document(path.read_bytes(), name=path.name)
        if whole.unusable or whole.frames < 10:
            continue
        some: Ints = np.array([1, 2, 7, 8, 0])
        assert np.array_equal(select_frames(whole, some).clip.rotations, whole.clip.rotations[some]), path.name

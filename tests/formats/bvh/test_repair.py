"""Repair writes what a strict reader wants, lists each change, and leaves alone what is in order."""

from __future__ import annotations

import signal
from pathlib import Path

import bvhio
import numpy as np
import pytest
from bvhmaker import PLAIN, plain
from conftest import SHARED, need, one_of_each_origin
from odd_files import OWN_FILES

from footfix.errors import InputError
from footfix.formats.bvh import decode, encode
from footfix.formats.bvh.repair import RepairParams, repair
from footfix.motion.kinematics import forward

# What a strict reader stumbles over; all else may stay.
HARMLESS = {
    "bone-zero", "offsets-zero", "frozen", "jump", "name-duplicate", "several-roots", "root-fixed", "rotation-partial",
    "positions-below-root", "positions-zero", "end-site-beside-children", "no-frames", "one-frame",
    "frame-time-unusual", "angle-unusual", "offset-not-a-number",
}  # fmt: skip


def long_clip(frame_time: float = 0.02, frames: int = 40) -> list[str]:
    rows = [f"{k}.00 9.00 0.00 0.00 0.00 {(170 + 4 * k + 180) % 360 - 180:.2f} 0 0 0 0 0 0" for k in range(frames)]
    head = PLAIN[: PLAIN.index("0.00 9.00")].replace("0.0333333", str(frame_time))
    return [*head.replace("Frames: 4", f"Frames: {frames}").splitlines(), *rows]


@pytest.mark.clips
def test_a_sound_file_comes_back_as_it_is() -> None:
    for data in (plain(), plain().replace(b"\n", b"\r\n"), plain().rstrip()):
        assert repair(decode(data)) == (data, ())
    for path in need(one_of_each_origin(), "clips"):
        data = path.read_bytes()
        document = decode(data)
        if {note.id for note in document.notes} <= HARMLESS:
            assert repair(document) == (data, ()), path.name


@pytest.mark.parametrize("name", OWN_FILES)
def test_every_odd_file_is_mended(name: str) -> None:
    data, expected = OWN_FILES[name]
    if expected.error:
        with pytest.raises(InputError):
            decode(data)
        return
    document = decode(data)
    mended, notes = repair(document)
    again = decode(mended)
    assert {note.id for note in again.notes} <= HARMLESS
    assert repair(again)[0] == mended
    told = {note.id for note in notes} | {"not-a-number", "value-huge", "value-infinite", "value-nan"}
    assert {note.id for note in document.notes} - HARMLESS <= told
    known = np.abs(document.values) < 1e9
    kept = [k for k, channel in enumerate(document.channels) if channel.kind]
    if again.values.shape == document.values.shape:
        np.testing.assert_allclose(again.values[known], document.values[known], atol=1e-9)
    else:
        np.testing.assert_allclose(again.values, document.values[:, kept], atol=1e-9)
    assert np.array_equal(again.skeleton.offsets, document.skeleton.offsets, equal_nan=True)
    assert again.frame_time == pytest.approx(document.frame_time, rel=1e-6)


def test_shared_files_are_mended_for_strict_readers(tmp_path: Path) -> None:
    if not (SHARED / "odd").is_dir():
        pytest.skip(f"no files: {SHARED / 'odd'} is absent")
    accepted = 0
    for path in sorted((SHARED / "odd").glob("*/*")):
        try:
            document = decode(path.read_bytes())
        except InputError:
            continue
        mended, _ = repair(document)
        again = decode(mended)
        assert {note.id for note in again.notes} <= HARMLESS, path.name
        assert encode(again) == mended
        if "offset-not-a-number" in {note.id for note in again.notes} or len(mended) > 100_000:
            continue
        copy = tmp_path / "mended.bvh"
        copy.write_bytes(mended)
        container = bvhio.readAsBvh(str(copy))
        assert container.FrameCount == len(again.values)
        accepted += 1
    assert accepted > 50


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="needs an alarm")
def test_bvhio_hangs_on_a_cut_file_and_reads_the_mended_one(tmp_path: Path) -> None:
    """Why bvhio is not the reader. Should it learn to refuse, this tells."""
    path = tmp_path / "cut.bvh"
    data = plain()[: plain().index(b"0.20 9.02")]
    path.write_bytes(data)

    def too_long(*_: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, too_long)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(TimeoutError):
            bvhio.readAsBvh(str(path))
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    path.write_bytes(repair(decode(data))[0])
    assert bvhio.readAsBvh(str(path)).FrameCount == 2


def test_short_gaps_are_filled_in_a_straight_line() -> None:
    lines = long_clip()
    for row in (10, 11, 12):
        lines[-40 + row] = lines[-40 + row].replace(f"{row}.00", "nan", 1)
    document = decode("\n".join(lines).encode())
    assert {note.id for note in document.unusable} == {"value-nan"}
    mended, notes = repair(document)
    again = decode(mended)
    np.testing.assert_allclose(again.values[:, 0], np.arange(40.0), atol=1e-9)
    assert not again.unusable
    assert [(note.id, note.severity, note.start, note.end) for note in notes] == [("value-nan", "note", 10, 13)]


def test_angles_are_filled_the_shorter_way_round() -> None:
    lines = long_clip()
    words = lines[-40 + 3].split()
    lines[-40 + 3] = " ".join([*words[:5], "-1.#IND", *words[6:]])  # between 178 and -174
    again = decode(repair(decode("\n".join(lines).encode()))[0])
    assert again.values[3, 5] == pytest.approx(182.0)


def test_gaps_at_the_ends_are_held() -> None:
    lines = long_clip()
    lines[-40] = "inf" + lines[-40][4:]
    lines[-1] = "1e30" + lines[-1][5:]
    again = decode(repair(decode("\n".join(lines).encode()))[0])
    assert again.values[[0, -1], 0].tolist() == [1.0, 38.0]


@pytest.mark.parametrize(("frame_time", "filled"), [(0.02, 5), (0.01, 10), (0.1, 1), (0.5, 1)])
def test_long_gaps_are_left(frame_time: float, filled: int) -> None:
    for length in (filled, filled + 1):
        lines = long_clip(frame_time)
        for row in range(10, 10 + length):
            lines[-40 + row] = lines[-40 + row].replace(f"{row}.00", "nan", 1)
        mended, notes = repair(decode("\n".join(lines).encode()))
        assert bool(decode(mended).unusable) == (length > filled)
        assert ("error" in {note.severity for note in notes}) == (length > filled)
    more = RepairParams(gap=1.0)
    assert not decode(repair(decode("\n".join(lines).encode()), more)[0]).unusable


def test_a_file_that_moves_nothing_but_an_end_site() -> None:
    data = (b"HIERARCHY\nROOT a\n{\n\tOFFSET 0 0 0\n\tEnd Site\n\t{\n\t\tOFFSET 0 1 0\n\t\tCHANNELS 1 Xrotation\n"
            b"\t}\n}\nMOTION\nFrames: 1\nFrame Time: 0.1\n5\n")  # fmt: skip
    document = decode(data)
    assert document.values.shape == (1, 1)
    assert {note.id for note in decode(repair(document)[0]).notes} == {"no-frames", "root-fixed"}


@pytest.mark.parametrize("word", ["999)999", ".", "1-2", "x"])
def test_words_that_are_no_numbers_and_stay_unknown_are_written_as_nan(word: str) -> None:
    lines = long_clip()
    for row in range(10, 20):
        lines[-40 + row] = lines[-40 + row].replace(f"{row}.00", word, 1)
    again = decode(repair(decode("\n".join(lines).encode()))[0])
    assert [note.id for note in again.unusable] == ["value-nan"]
    assert len(again.values) == 40


def test_channels_of_end_sites_and_scales_are_taken_out() -> None:
    data = plain(
        ("Zposition Zrotation", "Zposition Zscale Zrotation"), ("CHANNELS 6", "CHANNELS 7"),
        ("1.00\n\t\t\t}", "1.00\n\t\t\t\tCHANNELS 1 Xrotation\n\t\t\t}"),
        *[(f" {x} ", f" {x} 100 ") for x in ("0.00 1.00", "1.00 1.10", "2.00 1.20", "3.00 1.30")],
    )  # fmt: skip
    lines = data.replace(b" 1.00 100", b" 100 1.00").replace(b" 1.10 100", b" 100 1.10").splitlines()
    rows = [line.replace(b" 1.20 100", b" 100 1.20").replace(b" 1.30 100", b" 100 1.30") + b" 5" for line in lines[-4:]]
    document = decode(b"\n".join([*lines[:-4], *rows]))
    assert document.values.shape == (4, 14)
    np.testing.assert_allclose(forward(document.clip).positions, forward(decode(plain()).clip).positions)
    again = decode(repair(document)[0])
    assert np.array_equal(again.values, decode(plain()).values)
    assert again.notes == ()

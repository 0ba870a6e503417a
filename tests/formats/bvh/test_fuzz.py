"""Nothing a file can hold breaks the reader: it is read, or refused in words; in bounded time and memory."""

from __future__ import annotations

import re
import tracemalloc
from pathlib import Path
from typing import Any

import bvhio
import numpy as np
import pytest
from bvhmaker import PLAIN, files, plain
from conftest import need, one_of_each_origin
from damage import DAMAGES, damaged, survives
from hypothesis import given, settings
from hypothesis import strategies as st

from footfix.formats.bvh import decode
from footfix.formats.bvh.splice import row_blocks
from footfix.motion.kinematics import forward

SEEDS = st.integers(0, 2**32 - 1)


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(sorted(DAMAGES)), SEEDS)
def test_damage_to_a_plain_file(kind: str, seed: int) -> None:
    survives(DAMAGES[kind](plain(), np.random.default_rng(seed)))


@settings(max_examples=15, deadline=None)
@given(files(), SEEDS, st.integers(0, 4))
def test_damage_to_any_file(made: tuple[Any, ...], seed: int, times: int) -> None:
    survives(damaged(made[3], np.random.default_rng(seed), times))


@settings(max_examples=30, deadline=None)
@given(st.binary(max_size=200), st.integers(0, len(PLAIN)))
def test_any_bytes(junk: bytes, at: int) -> None:
    survives(junk)
    survives(PLAIN[:at].encode() + junk)
    survives(PLAIN[:at].encode() + junk + PLAIN[at:].encode())


@pytest.mark.clips
def test_damage_to_real_files() -> None:
    paths = need(one_of_each_origin(2e5), "clips")
    rng = np.random.default_rng(0)
    for path in paths[::4]:
        data = path.read_bytes()
        for _ in range(3):
            survives(damaged(data, rng, int(rng.integers(1, 4))))


BOMBS = {
    "nested joints": b"HIERARCHY ROOT a { " + b"JOINT b { " * 2_500,
    "nested braces": b"HIERARCHY ROOT a " + b"{ " * 2_500,
    "closing braces": b"HIERARCHY " + b"} " * 2_500,
    "long name": b"HIERARCHY ROOT " + b"a" * 100_000,
    "long word": b"HIERARCHY ROOT a { " + b"a" * 100_000,
    "long OFFSET": b"HIERARCHY ROOT a { OFFSET " + b"0 " * 2_500,
    "blanks": b"HIERARCHY " + b" " * 100_000,
    "one comment": b"#" * 100_000,
    "comments": b"# c\n" * 2_500,
    "long last row": plain() + b"1 " * 2_500,
    "rows of one number": plain() + b"1\n" * 2_500,
    "words after the rows": plain() + b"x " * 2_500,
    "lines of words after the rows": plain() + b"x\n" * 2_500,
    "comments after the rows": plain() + b"# no\n" * 2_500,
    "line ends after the rows": plain() + b"\n" * 100_000,
    "long number": plain(("0.10 9.01", "0" * 20_000 + "0.10 9.01" + "0" * 20_000)),
    "long gap": plain(("0.10 9.01", "0.10" + " " * 80_000 + "9.01")),
    "frame count": plain(("Frames: 4", "Frames: 1000000000000")),
    "channel count": plain(("CHANNELS 6", "CHANNELS 999999999")),
}


@pytest.mark.parametrize("kind", BOMBS)
def test_time_and_memory_are_bounded(kind: str) -> None:
    data = BOMBS[kind]
    tracemalloc.start()
    survives(data)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 60_000_000 + 60 * len(data)


def head(data: bytes, frames: int) -> bytes:
    """The first frames of a sound file."""
    document = decode(data)
    starts = [starts for _, starts, _ in row_blocks(document.rows)]
    rows = np.concatenate(starts)
    stop = int(rows[frames, 0]) if len(rows) > frames else len(data)
    text = data[:stop].decode("utf-8")
    return re.sub(r"Frames:\s*\d+", f"Frames: {min(frames, len(rows))}", text).encode()


@pytest.mark.clips
def test_readers_agree_on_files_that_all_accept(tmp_path: Path) -> None:
    """Numbers and places against two readers written by others, on clips of all origins."""
    pybvh = pytest.importorskip("pybvh")
    agreed, seen = 0, set[str]()
    for path in need(one_of_each_origin(), "clips"):
        data = path.read_bytes()
        document = decode(data)
        strict = {note.id for note in document.notes} <= {"bone-zero", "exponents", "frozen", "jump"}
        if not strict or path.parent.name in seen or len(document.values) < 3:
            continue
        copy = tmp_path / "clip.bvh"
        copy.write_bytes(head(data, 3))
        document = decode(copy.read_bytes())
        try:
            other = pybvh.read_bvh_file(str(copy))
        except ValueError:  # what pybvh refuses is not a file that all accept
            continue
        seen.add(path.parent.name)
        agreed += 1
        container = bvhio.readAsBvh(str(copy))
        assert other.frame_count == container.FrameCount == len(document.values)
        assert document.frame_time == pytest.approx(container.FrameTime)
        assert document.frame_time == pytest.approx(other.frame_time, rel=1e-3)
        ours = forward(document.clip).positions
        # positions channels of the root take the place of its OFFSET here, as they do for bvhio
        theirs = np.asarray(other.joint_positions())
        size = float(np.abs(ours).max()) + 1.0
        np.testing.assert_allclose(theirs - theirs[:, :1], ours - ours[:, :1], atol=1e-5 * size)
    assert agreed >= 10

"""Damage that files suffer, and what must hold for any bytes whatever."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from footfix.errors import InputError
from footfix.formats.bvh import Document, decode, encode, rewrite
from footfix.formats.bvh.repair import repair
from footfix.motion import rotation
from footfix.motion.clip import Clip

Damage = Callable[[bytes, np.random.Generator], bytes]

SPLINTERS = [
    b"nan", b"1e309", b"-", b"{", b"}", b"}}}", b"JOINT x {", b"ROOT r", b"End Site", b"CHANNELS 999", b"CHANNELS -1",
    b"CHANNELS 3", b"OFFSET", b"MOTION", b"HIERARCHY", b"Frames: 99999999999999999999", b"Frame Time: 0", b"\0", b",",
    b"\xff\xfe", b"\r", b"#", b"Xrotation", b"1.#IND", b"_1", b"1_0", b"0x1p3", b"\xa0", b"\x85", b"\x1c", b"inf",
]  # fmt: skip


def cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: int(rng.integers(len(data) + 1))]


def lose_start(data: bytes, rng: np.random.Generator) -> bytes:
    return data[int(rng.integers(len(data) + 1)) :]


def lose_middle(data: bytes, rng: np.random.Generator) -> bytes:
    a, b = sorted(rng.integers(0, len(data) + 1, 2).tolist())
    return data[:a] + data[b:]


def flip(data: bytes, rng: np.random.Generator) -> bytes:
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 9))):
        if out:
            out[int(rng.integers(len(out)))] ^= 1 << int(rng.integers(8))
    return bytes(out)


def insert(data: bytes, rng: np.random.Generator) -> bytes:
    at = int(rng.integers(len(data) + 1))
    splinter = SPLINTERS[int(rng.integers(len(SPLINTERS)))]
    return data[:at] + (b" " + splinter + b" " if rng.integers(2) else splinter) + data[at:]


def replace_word(data: bytes, rng: np.random.Generator) -> bytes:
    at = int(rng.integers(len(data) + 1))
    words = data[at : at + 200].split()
    if len(words) < 3:
        return insert(data, rng)
    return data[:at] + data[at:].replace(words[1], SPLINTERS[int(rng.integers(len(SPLINTERS)))], 1)


def _lines(edit: Callable[[list[bytes], int, int], None]) -> Damage:
    def damage(data: bytes, rng: np.random.Generator) -> bytes:
        lines = data.splitlines(keepends=True)
        if len(lines) > 1:
            edit(lines, *rng.integers(0, len(lines), 2).tolist())
        return b"".join(lines)

    return damage


def _swap(lines: list[bytes], a: int, b: int) -> None:
    lines[a], lines[b] = lines[b], lines[a]


DAMAGES: dict[str, Damage] = {
    "cut": cut,
    "start lost": lose_start,
    "middle lost": lose_middle,
    "bytes flipped": flip,
    "splinter inserted": insert,
    "word replaced": replace_word,
    "line lost": _lines(lambda lines, a, b: lines.__delitem__(a)),
    "lines lost": _lines(lambda lines, a, b: lines.__delitem__(slice(min(a, b), max(a, b)))),
    "line doubled": _lines(lambda lines, a, b: lines.insert(a, lines[a])),
    "line moved": _lines(lambda lines, a, b: lines.insert(b, lines.pop(a))),
    "lines swapped": _lines(_swap),
    "line joined": _lines(lambda lines, a, b: lines.__setitem__(a, lines[a].rstrip(b"\r\n") + b" ")),
}


def damaged(data: bytes, rng: np.random.Generator, times: int = 1) -> bytes:
    names = list(DAMAGES)
    for _ in range(times):
        data = DAMAGES[names[int(rng.integers(len(names)))]](data, rng)
    return data


def says_what_is_read(document: Document, clip: Clip) -> bytes:
    """The file with the motion of a clip: to the last bit, it holds the motion that its writer says it does."""
    written, said = rewrite(document, clip)
    assert written == encode(document, clip)
    back = decode(written).placed(unit_m=document.unit_m, up=document.up).clip
    assert said.frame_time == back.frame_time
    assert said.skeleton.offsets.tobytes() == back.skeleton.offsets.tobytes()
    assert said.positions.tobytes() == back.positions.tobytes()
    assert said.rotations.tobytes() == back.rotations.tobytes()
    return written


def survives(data: bytes) -> None:
    """Read, written, changed, repaired; or refused with a file and a hint. Anything else is a failure."""
    try:
        document = decode(data, name="walk.bvh")
    except InputError as error:
        assert str(error).startswith("walk.bvh:")
        assert error.hint
        assert len(str(error)) < 500
        return
    assert encode(document) == data
    assert document.frame_time > 0.0
    clip = document.clip
    assert np.isfinite(clip.positions).all() or document.unusable
    assert np.isfinite(clip.rotations).all() or document.unusable
    if len(clip):
        turn = rotation.from_rotation_vector(np.full((len(clip), len(clip.skeleton), 3), 0.1))
        rotations = np.where(np.isfinite(clip.rotations), rotation.multiply(clip.rotations, turn), 0.5)
        new = replace(clip, rotations=rotations, positions=clip.positions + 0.01)
        again = decode(says_what_is_read(document, new))
        ragged = {note.id for note in document.notes} & {"row-short", "row-long", "last-row-cut"}
        assert ragged or again.values.shape == document.values.shape
    mended, _ = repair(document)
    assert not {note.id for note in decode(mended).notes} & {"frames-mismatch", "row-long", "row-short", "exponents"}

"""Reading and writing BVH: nothing is lost, only what changed is written, and units and axes come back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bvhmaker import PLAIN, files, plain
from conftest import need, one_of_each_origin, shared
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from footfix.errors import InputError
from footfix.formats.bvh import Document, Limits, compose, decode, encode
from footfix.motion import rotation
from footfix.motion.clip import Clip
from footfix.motion.kinematics import forward

UPS = ["y", "-y", "z", "-z", "x", "-x"]


def bent(clip: Clip, joints: list[int], frames: slice, seed: int = 0) -> Clip:
    """The clip with some joints turned and, where they can, moved, in some frames."""
    rng = np.random.default_rng(seed)
    positions, rotations = clip.positions.copy(order="K"), clip.rotations.copy(order="K")
    for joint in joints:
        part = rotations[frames, joint]
        if clip.skeleton.rotates[joint]:
            turn = rotation.from_rotation_vector(rng.normal(0.0, 0.2, (len(part), 3)))
            rotations[frames, joint] = rotation.multiply(part, turn)
        if clip.skeleton.translates[joint]:
            positions[frames, joint] += rng.normal(0.0, 0.05, (len(part), 3))
    return replace(clip, positions=positions, rotations=rotations)


def turned_by(a: Clip, b: Clip) -> float:
    """The largest angle between the same joint of two clips [rad]."""
    return float(rotation.angle(rotation.multiply(rotation.inverse(a.rotations), b.rotations)).max(initial=0.0))


def readable(paths: list[Path]) -> Iterator[tuple[str, bytes, Document]]:
    for path in paths:
        data = path.read_bytes()
        try:
            yield path.name, data, decode(data, name=path.name)
        except InputError:
            assert "odd" in path.parts


@pytest.mark.clips
def test_every_clip_comes_back_to_the_byte() -> None:
    for name, data, document in readable([*need(one_of_each_origin(4e6), "clips"), *need(shared("odd"), "odd")]):
        assert encode(document) == data, name
        assert encode(document, replace(document.clip)) == data, name


@pytest.mark.clips
def test_changes_touch_nothing_else() -> None:
    for name, data, document in readable(need(one_of_each_origin(), "clips")[::2]):
        document = document.placed(unit_m=0.0254, up="z")
        clip, frames = document.clip, slice(len(document.values) // 3, 2 * len(document.values) // 3)
        if document.unusable or frames.stop == frames.start:
            continue
        joints = [0, len(clip.skeleton) // 2]
        new = bent(clip, joints, frames)
        out = encode(document, new)
        back = decode(out).placed(unit_m=0.0254, up="z").clip
        assert np.abs(back.positions - new.positions).max() < 1e-7, name
        assert turned_by(back, new) < 1e-7, name
        others = [j for j in range(len(clip.skeleton)) if j not in joints]
        assert np.array_equal(back.rotations[:, others], clip.rotations[:, others]), name
        lines, written = data.splitlines(), out.splitlines()
        assert len(lines) == len(written)
        changed = [k for k, (a, b) in enumerate(zip(lines, written, strict=True)) if a != b]
        assert len(changed) <= frames.stop - frames.start
        for k in changed:
            moved = [a for a, b in zip(lines[k].split(), written[k].split(), strict=True) if a != b]
            assert len(moved) <= 12


@pytest.mark.parametrize("up", UPS)
@pytest.mark.parametrize("unit", [1.0, 0.01, 0.0254, 1 / 17.7])
def test_units_and_axes(unit: float, up: str) -> None:
    document = decode(plain()).placed(unit_m=unit, up=up)
    raw, clip = decode(plain()).clip, document.clip
    a, b = forward(raw).positions, forward(clip).positions
    height = {"x": 0, "y": 1, "z": 2}[up[-1]]
    np.testing.assert_allclose(b[..., 1], a[..., height] * unit * (-1 if up[0] == "-" else 1), atol=1e-12)
    # a proper rotation and a scale: what is spanned keeps its volume and its sign, so nothing is mirrored
    spanned_a, spanned_b = (np.linalg.det(each[3] - each[0]) for each in (a, b))
    np.testing.assert_allclose(spanned_b, unit**3 * spanned_a, rtol=1e-9)
    assert encode(document, clip) == plain()
    np.testing.assert_allclose(document.in_file(clip).positions, raw.positions, atol=1e-12)
    assert turned_by(document.in_file(clip), raw) < 1e-7


def test_only_the_axes_that_moved() -> None:
    document = decode(plain()).placed(unit_m=0.01, up="z")
    clip = document.clip
    positions = clip.positions.copy(order="K")
    positions[2, 0, 1] += 0.001  # up, which is z in the file
    out = encode(document, replace(clip, positions=positions))
    assert out == plain(("9.02 2.00 1.20", "9.02 2.100000 1.20"))


def test_what_would_read_the_same_stays() -> None:
    document = decode(plain())
    clip = document.clip
    rotations = clip.rotations + np.random.default_rng(0).normal(0.0, 1e-12, clip.rotations.shape)
    assert encode(document, replace(clip, rotations=rotations)) == plain()


@pytest.mark.parametrize(("point", "between"), [(",", " "), (".", ", "), (".", "\t")])
def test_commas_and_blanks_stay_as_they_are(point: str, between: str) -> None:
    rows = PLAIN[PLAIN.index("0.00 9.00") :]
    data = (PLAIN[: -len(rows)] + rows.replace(".", point).replace(" ", between)).encode()
    document = decode(data)
    positions = document.clip.positions.copy(order="K")
    positions[1, 0, :2] += 0.5
    positions[2, 0, 2] += 0.5  # in another row another number: what stands between them is kept
    out = encode(document, replace(document.clip, positions=positions)).decode()
    changed = rows.replace("0.10 9.01", "0.600000 9.510000").replace("9.02 2.00", "9.02 2.500000")
    assert out == PLAIN[: -len(rows)] + changed.replace(".", point).replace(" ", between)


def test_numbers_and_gaps_of_any_length_are_kept() -> None:
    data = plain(("0.10 9.01", "0" * 500 + ".10" + "\0 " * 10 + "9.01"), ("0.20 9.02", "0.20" + " " * 300 + "9.02"))
    document = decode(data)
    positions = document.clip.positions.copy(order="K")
    positions[1:, 0, 2] += 0.5
    out = encode(document, replace(document.clip, positions=positions))
    expected = data
    for old in (b"9.01 1.", b"9.02 2.", b"9.03 3."):
        expected = expected.replace(old + b"00", old + b"500000")
    assert out == expected


def test_euler_angles_stay_on_the_branch_of_the_frame() -> None:
    document = decode(plain())
    turn = rotation.from_rotation_vector(np.array([0.0, np.radians(30.0), 0.0]))
    rotations = document.clip.rotations.copy(order="K")
    rotations[:, 2] = rotation.multiply(rotations[:, 2], turn)
    values = decode(encode(document, replace(document.clip, rotations=rotations))).values
    # about y, the last of the foot's axes: 170 goes on to 200, not to -160
    np.testing.assert_allclose(values[:, 11], [39.0, 39.9, 200.0, -145.0], atol=1e-5)
    np.testing.assert_allclose(values[:, :11], document.values[:, :11], atol=1e-5)


def test_numbers_are_written_plainly() -> None:
    document = decode(plain(("0.10 9.01", "1e-1 9.0123456789")))
    positions = document.clip.positions.copy(order="K")
    positions[1, 0] += [1e-3, 1e-3, -1.0]
    out = encode(document, replace(document.clip, positions=positions))
    row = out.splitlines()[24].split()
    assert row[:3] == [b"0.1010000000", b"9.0133456789", b"0.0000000000"]
    assert b"e" not in b" ".join(out.splitlines()[24:])


def test_position_channels_take_the_place_of_the_offset() -> None:
    text = plain(
        ("OFFSET 0.00 -4.00 0.00\n\t\t\tCHANNELS 3", "OFFSET 7.00 -4.00 8.00\n\t\t\tCHANNELS 5 Yposition Zposition"),
        ("7.00 8.00 9.00\n", "-4.1 0.1 7.00 8.00 9.00\n"), ("7.70 8.80", "-4.2 0.2 7.70 8.80"),
        ("8.40 9.60", "-4.3 0.3 8.40 9.60"), ("9.10 10.40", "-4.4 0.4 9.10 10.40"),
    )  # fmt: skip
    document = decode(text)
    np.testing.assert_allclose(document.clip.positions[:, 2, 0], 7.0)
    np.testing.assert_allclose(document.clip.positions[:, 2, 1], [-4.1, -4.2, -4.3, -4.4])
    assert document.skeleton.translates.tolist() == [True, False, False]


def test_positions_that_never_leave_zero_count_from_the_offset() -> None:
    text = plain(
        ("OFFSET 0.00 -4.00 0.00\n\t\t\tCHANNELS 3", "OFFSET 0 -4 0\n\t\t\tCHANNELS 6 Xposition Yposition Zposition"),
        ("7.00 8.00 9.00\n", "0 0 0 7.00 8.00 9.00\n"), ("7.70 8.80", "0 0 0 7.70 8.80"),
        ("8.40 9.60", "0 0 0 8.40 9.60"), ("9.10 10.40", "0 0 0 9.10 10.40"),
    )  # fmt: skip
    document = decode(text)
    assert "positions-zero" in {note.id for note in document.notes}
    np.testing.assert_allclose(document.clip.positions[:, 2], np.tile([0.0, -4.0, 0.0], (4, 1)))
    positions = document.clip.positions.copy(order="K")
    positions[0, 2, 1] += 0.5
    assert decode(encode(document, replace(document.clip, positions=positions))).values[0, 10] == 0.5


def test_memory_lies_joint_by_joint() -> None:
    clip = decode(plain()).placed(unit_m=0.01, up="z").clip
    for array in (clip.positions, clip.rotations):
        assert array.transpose(1, 2, 0).flags.c_contiguous
        assert not array.flags.writeable


def test_rotations_are_intrinsic_in_the_order_of_the_channels() -> None:
    document = decode(plain())
    angles = document.values[:, 3:6]
    expected = Rotation.from_euler("ZXY", angles, degrees=True).as_quat()
    dots = np.abs(np.sum(expected * document.clip.rotations[:, 0], axis=1))
    np.testing.assert_allclose(dots, 1.0, atol=1e-12)


@settings(max_examples=15, deadline=None)
@given(files(), st.sampled_from(UPS), st.sampled_from([1.0, 0.01, 3.7]))
def test_any_file_is_read_as_it_was_written(made: tuple, up: str, unit: float) -> None:  # type: ignore[type-arg]
    joints, values, style, data = made
    document = decode(data).placed(unit_m=unit, up=up)
    assert document.skeleton.names == tuple(joint.name for joint in joints)
    assert np.array_equal(document.values, values)
    offsets = [[float(style.number(x)) for x in joint.offset] for joint in joints]
    assert np.array_equal(document.skeleton.offsets, offsets)
    assert len(document.skeleton.end_parents) == sum(len(joint.ends) for joint in joints)
    assert encode(document) == data
    clip, new = document.clip, bent(document.clip, list(range(len(joints))), slice(None))
    out = encode(document, new)
    back = decode(out).placed(unit_m=unit, up=up).clip
    assert np.abs(back.positions - new.positions).max() < 2e-6 * max(unit, 1.0)
    assert turned_by(back, new) < 1e-6
    assert encode(document, clip) == data
    start = data.upper().index(b"MOTION")
    assert out[:start] == data[:start]


@settings(max_examples=15, deadline=None)
@given(files(), st.integers(0, 2**32))
def test_joints_with_few_channels_get_what_they_can(made: tuple, seed: int) -> None:  # type: ignore[type-arg]
    joints, values, _, data = made
    document = decode(data)
    rng = np.random.default_rng(seed)
    turn = rotation.from_rotation_vector(rng.normal(0.0, 0.3, (len(values), len(joints), 3)))
    new = replace(document.clip, rotations=rotation.multiply(document.clip.rotations, turn))
    back = decode(encode(document, new)).clip
    for j in range(len(joints)):
        off = rotation.angle(rotation.multiply(rotation.inverse(new.rotations[:, j]), back.rotations[:, j]))
        before = rotation.angle(turn[:, j])
        assert np.all(off <= before + 1e-6)


@settings(max_examples=15, deadline=None)
@given(files())
def test_a_composed_file_says_the_same_motion(made: tuple) -> None:  # type: ignore[type-arg]
    document = decode(made[3]).placed(unit_m=0.01)
    clip = document.clip
    back = decode(compose(clip)).placed(unit_m=0.01)
    order = [clip.skeleton.names.index(name) for name in back.skeleton.names]
    if len(set(clip.skeleton.names)) == len(clip.skeleton):
        assert turned_by(back.clip, replace(clip, rotations=clip.rotations[:, order])) < 1e-6
        movable = clip.skeleton.translates[order]
        np.testing.assert_allclose(back.clip.positions[:, movable], clip.positions[:, order][:, movable], atol=1e-7)
    doubts = {note.id for note in back.notes if note.severity != "note"}
    assert doubts <= {"one-frame", "offsets-zero", "jump"}


def test_composed_angles_do_not_leap() -> None:
    frames = np.linspace(0.0, 4.0 * np.pi, 400)
    q = rotation.multiply(
        rotation.from_rotation_vector(np.outer(frames, [0.0, 1.0, 0.0])),
        rotation.from_rotation_vector(np.outer(1.4 * np.sin(frames), [1.0, 0.0, 0.2])),
    )
    clip = decode(plain()).clip
    clip = Clip(clip.skeleton, np.tile(clip.skeleton.offsets, (400, 1, 1)), np.tile(q[:, None], (1, 3, 1)), 1 / 30)
    assert np.abs(np.diff(decode(compose(clip)).values, axis=0)).max() < 45.0


def test_nested_deeply() -> None:
    depth = 1500  # deeper than Python calls itself
    body = "".join(f"JOINT j{k} {{ OFFSET 0 1 0 CHANNELS 1 Xrotation " for k in range(depth))
    text = f"HIERARCHY ROOT r {{ OFFSET 0 0 0 CHANNELS 0 {body} {'}' * depth} }} MOTION Frames: 1 Frame Time: 0.1\n"
    document = decode((text + " ".join(["0"] * depth) + "\n").encode())
    assert len(document.skeleton) == depth + 1
    np.testing.assert_allclose(forward(document.clip, [depth]).positions, [[[0.0, depth, 0.0]]])


@pytest.mark.parametrize(
    ("limits", "what"),
    [
        (Limits(bytes=100), "bytes"),
        (Limits(frames=3), "4 frames"),
        (Limits(joints=2), "more than 2 joints"),
        (Limits(nesting=2), "nested more than 2"),
        (Limits(header=200), "no MOTION"),
    ],
)
def test_limits(limits: Limits, what: str) -> None:
    with pytest.raises(InputError, match=what):
        decode(plain(), name="walk.bvh", limits=limits)


def test_a_huge_frame_count_allocates_nothing() -> None:
    document = decode(plain(("Frames: 4", "Frames: 1000000000000")))
    assert len(document.values) == 4
    assert {note.id for note in document.notes} == {"frames-mismatch"}


def test_the_plain_file_has_nothing_odd() -> None:
    assert decode(PLAIN.encode()).notes == ()
    assert decode(PLAIN.replace("\n", "\r\n").encode()).notes == ()


def test_braces_in_names_are_names_where_the_joint_opens_below() -> None:
    text = b"HIERARCHY\nROOT {{7*7}}&lt;x\n{\n OFFSET 0 0 0\n CHANNELS 3 Xrotation Yrotation Zrotation\n JOINT b{\n {\n"
    text = text.replace(b"b{\n {", b"b {")
    text += b" OFFSET 0 1 0\n CHANNELS 0\n }\n}\nMOTION\nFrames: 1\nFrame Time: 0.1\n1 2 3\n"
    document = decode(text)
    assert document.skeleton.names == ("{{7*7}}&lt;x", "b") and encode(document) == text

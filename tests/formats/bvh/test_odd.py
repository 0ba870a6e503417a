"""What becomes of malformed and strange files: a stated outcome for each."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from bvhmaker import plain
from conftest import SHARED
from odd_files import OWN_FILES, Outcome, read, refused

from footfix.errors import InputError
from footfix.formats.bvh import Document, decode, encode
from footfix.formats.bvh.repair import repair
from footfix.formats.bvh.rows import offset_of
from footfix.motion import rotation
from footfix.motion.clip import Clip


def check(data: bytes, expected: Outcome) -> Document | None:
    """Decodes; the outcome is the one expected, and what was read can be written and made a clip."""
    start = time.monotonic()
    try:
        document = decode(data, name="odd.bvh")
    except InputError as error:
        assert str(error).startswith("odd.bvh:")
        assert error.hint
        place = "" if error.line is None else f"{error.line}:{error.column}: "
        assert place + error.what == expected.error
        return None
    assert time.monotonic() - start < 20.0
    assert (len(document.values), tuple(sorted({note.id for note in document.notes}))) == (
        expected.frames, expected.notes)  # fmt: skip
    assert encode(document) == data
    assert isinstance(document.clip, Clip)
    assert document.frame_time > 0.0
    for note in document.notes:
        assert note.line is not None
        assert not note.text.endswith(".")
    if len(document.values) and not document.unusable and not document.encoding:
        check_change(document, data)
    return document


def check_change(document: Document, data: bytes) -> None:
    """What is changed in an odd file is read from it again, and nothing else is touched."""
    skeleton, values, rows = document.skeleton, document.values, document.rows
    joint = next((j for j in range(len(skeleton)) if skeleton.rotates[j]), None)
    whole = np.ones(len(values), dtype=bool) if rows.width is None else rows.width >= values.shape[1]
    if joint is None or not whole[-1]:
        return
    rotations = document.clip.rotations.copy(order="K")
    rotations[-1, joint] = rotation.multiply(rotations[-1, joint], rotation.from_rotation_vector(np.full(3, 0.1)))
    out = encode(document, replace(document.clip, rotations=rotations))
    again = decode(out)
    columns = [k for k, channel in enumerate(document.channels) if channel.joint == joint and channel.kind == "R"]
    expected = values.copy()
    expected[-1, columns] = again.values[-1, columns]
    assert np.array_equal(again.values[whole], expected[whole])
    off = rotation.multiply(rotation.inverse(again.clip.rotations[-1, joint]), rotations[-1, joint])
    assert rotation.angle(off) < 1e-6
    differs = [k for k, (a, b) in enumerate(zip(data, out, strict=False)) if a != b]
    assert differs[0] >= offset_of(rows, len(values) - 1, 0)
    assert data[-1:] == out[-1:]


SHARED_FILES = {
    "made/binary.bvh": refused("this is a binary file of another kind, not a BVH"),
    "made/blank_lines.bvh": read(24, "bone-zero"),
    "made/brace_same_line.bvh": read(24, "bone-zero", "brace-on-line"),
    "made/channels_count_wrong.bvh": read(24, "bone-zero", "channel-count"),
    "made/comment_lines.bvh": read(24, "bone-zero", "comment"),
    "made/crcrlf.bvh": read(24, "bone-zero", "line-ends-doubled"),
    "made/crlf.bvh": read(24, "bone-zero"),
    "made/decimal_comma.bvh": read(24, "bone-zero", "decimal-comma", "heading-spelling"),
    "made/dup_names.bvh": read(24, "bone-zero", "name-duplicate"),
    "made/empty.bvh": refused("the file is empty"),
    "made/empty_name.bvh": read(24, "bone-zero", "name-empty"),
    "made/end_site_labelled.bvh": read(24, "bone-zero"),
    "made/end_site_lower.bvh": read(24, "bone-zero", "spelling"),
    "made/extra_brace.bvh": read(24, "bone-zero", "brace-extra"),
    "made/fbx_renamed.bvh": refused("this is a binary FBX file under the name of a BVH"),
    "made/frames_0.bvh": read(0, "bone-zero", "no-frames"),
    "made/frames_1.bvh": read(1, "bone-zero", "one-frame"),
    "made/frames_float.bvh": read(24, "bone-zero", "frames-spelling"),
    "made/frames_negative.bvh": read(24, "bone-zero", "frames-unreadable"),
    "made/frames_off_by_one.bvh": read(24, "bone-zero", "frames-mismatch"),
    "made/frames_too_many.bvh": read(24, "bone-zero", "frames-mismatch"),
    "made/frames_word.bvh": read(24, "bone-zero", "frames-unreadable"),
    "made/ft_0.bvh": read(24, "bone-zero", "frame-time-unreadable"),
    "made/ft_fps.bvh": read(24, "bone-zero", "frame-time-not-seconds"),
    "made/ft_missing.bvh": read(24, "bone-zero", "frame-time-missing"),
    "made/ft_nan.bvh": read(24, "bone-zero", "frame-time-unreadable"),
    "made/ft_negative.bvh": read(24, "bone-zero", "frame-time-negative"),
    "made/ft_tab_no_colon.bvh": read(24, "bone-zero", "heading-spelling"),
    "made/git_lfs.bvh": refused("this is a Git LFS pointer, not the file itself"),
    "made/html_404.bvh": refused("this is a web page, probably an error page of a download"),
    "made/huge_value.bvh": read(24, "bone-zero", "exponents", "jump", "value-huge"),
    "made/ind_row.bvh": read(24, "bone-zero", "value-nan"),
    "made/inf_value.bvh": read(24, "bone-zero", "value-infinite"),
    "made/long_row.bvh": read(24, "bone-zero", "row-long"),
    "made/missing_end_site.bvh": read(24, "bone-zero", "end-site-missing"),
    "made/motion_only.bvh": refused("1:1: the file has motion rows but no HIERARCHY"),
    "made/names_colon_pipe.bvh": read(24, "bone-zero"),
    "made/no_motion.bvh": refused("185:1: the file ends after the hierarchy: there is no MOTION"),
    "made/nul_bytes.bvh": refused("4:2: 'OFF�SET' means nothing in a hierarchy"),
    "made/offset_2_values.bvh": refused("5:2: OFFSET needs 3 numbers, nothing more after 2"),
    "made/offset_nan.bvh": read(24, "bone-zero", "offset-not-a-number"),
    "made/ok_base.bvh": read(24, "bone-zero"),
    "made/one_line_hierarchy.bvh": read(24, "bone-zero", "brace-on-line"),
    "made/root_no_pos.bvh": read(24, "bone-zero", "root-fixed"),
    "made/sci.bvh": read(24, "bone-zero", "exponents"),
    "made/tabs.bvh": read(24, "bone-zero"),
    "made/trailing_garbage.bvh": read(24, "bone-zero", "trailing-text"),
    "made/truncated_last_row.bvh": read(23, "bone-zero", "frames-mismatch", "last-row-cut"),
    "made/two_motions.bvh": read(24, "bone-zero", "motion-repeated"),
    "made/unknown_channel.bvh": refused("5:43: 'Wrotation' is no channel"),
    "made/upper_case_channels.bvh": read(24, "bone-zero", "spelling"),
    "made/utf16le.bvh": read(24, "bone-zero", "byte-order-mark", "encoding-utf16"),
    "made/utf8_bom.bvh": read(24, "bone-zero", "byte-order-mark"),
    "made/utf8_names.bvh": read(24, "bone-zero"),
    "made/wrapped_rows.bvh": read(24, "bone-zero", "rows-wrapped"),
    "made/zero_leg_offsets.bvh": read(24, "bone-zero"),
    "real/all_zero_offsets.bvh": read(2, "frozen", "offsets-zero"),
    "real/channels_6_but_3_named.bvh": read(111, "channel-count", "exponents", "frames-mismatch"),
    "real/declared_100_found_110.bvh": read(110, "frames-mismatch"),
    "real/declared_101_found_1.bvh": read(1, "frames-mismatch", "one-frame"),
    "real/declared_1048_found_1_ft_0p3.bvh": read(
        1, "frame-time-unusual", "frames-mismatch", "one-frame", "spelling"
    ),
    "real/declared_55_found_53.bvh": read(53, "end-site-missing", "frames-mismatch"),
    "real/endsite_beside_children_short_rows.bvh": read(947, "end-site-beside-children", "exponents", "row-short"),
    "real/face_poseunits.bvh": read(60),
    "real/frame_time_17_digits.bvh": read(3),
    "real/ft_0p001_tiny_rotations.bvh": read(3, "frame-time-unusual"),
    "real/ft_1_keyframes.bvh": read(21, "frame-time-not-seconds"),
    "real/git_lfs_pointer.bvh": refused("this is a Git LFS pointer, not the file itself"),
    "real/joint_with_2_rotations.bvh": read(2, "rotation-partial"),
    "real/mixed_orders_3_frames.bvh": read(3, "exponents"),
    "real/motion_rows_only.bvh": refused("1:1: the file has motion rows but no HIERARCHY"),
    "real/name_not_bvh_ext.bvh": read(353, "exponents", "frame-time-not-seconds"),
    "real/niall_two.bvh": read(250),
    "real/no_motion_keyword.bvh": read(
        59, "bone-zero", "frame-time-missing", "frames-mismatch", "motion-keyword-missing"
    ),
    "real/ragged_tail.bvh": read(435, "frames-mismatch", "row-short"),
    "real/single_frame_dotted_names.bvh": read(1, "one-frame"),
    "real/tiny_chain_no_end_sites.bvh": read(60, "end-site-missing"),
    "real/truncated_hierarchy.bvh": refused("35:1: the hierarchy ends in the middle: there is no MOTION"),
    "real/unclosed_brace_root_only.bvh": read(650, "brace-unclosed", "end-site-missing"),
    "real/uppercase_ext_6ch_joints.BVH": read(369, "exponents", "positions-below-root"),
    "real/zero_frames.bvh": read(0, "no-frames"),
    "real/zero_frames_165_joints.bvh": read(0, "frames-mismatch", "no-frames", "positions-below-root"),
}


def test_the_table_is_complete() -> None:
    folder = SHARED / "odd"
    if not folder.is_dir():
        pytest.skip(f"no files: {folder} is absent")
    found = {f"{path.parent.name}/{path.name}" for path in folder.glob("*/*")}
    assert found == set(SHARED_FILES)


@pytest.mark.parametrize("name", SHARED_FILES)
def test_shared_files(name: str) -> None:
    path = SHARED / "odd" / name
    if not path.is_file():
        pytest.skip(f"{path} is absent")
    check(path.read_bytes(), SHARED_FILES[name])


@pytest.mark.parametrize("name", OWN_FILES)
def test_own_files(name: str) -> None:
    data, expected = OWN_FILES[name]
    check(data, expected)


def test_headings_that_share_a_line_are_repaired() -> None:
    data = plain(("Frames: 4\nFrame Time: 0.0333333\n", "Frame Time: 0.0333333 Frames: 999\n"))
    mended, notes = repair(decode(data))
    assert "frames-mismatch" in {note.id for note in notes}
    assert decode(mended).notes == ()


def test_a_short_row_before_text_is_mended_by_itself() -> None:
    # the words of row and text together are as many as a row has
    data = plain(("9.90\n", "\nx\n"))
    document = decode(data)
    assert len(document.values) == 4
    mended, _ = repair(document)
    again = decode(mended)
    assert again.notes == ()
    np.testing.assert_allclose(again.values, document.values, atol=1e-9)

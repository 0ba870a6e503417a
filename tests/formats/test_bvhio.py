"""Kinematics against bvhio, whose reader and rotations are not ours; and the bridge both ways."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bvhio
import numpy as np
import pytest
from bvhmaker import plain
from conftest import SAMPLES, need, one_of_each_origin

from footfix.formats.bvh import Document, decode
from footfix.formats.bvhio import from_bvhio, to_bvhio
from footfix.motion.kinematics import forward

# One file of each origin that bvhio reads as it is meant: one root, one End Site a joint, names without blanks.
FRAMES = 3


def places(root: Any, frame: int) -> np.ndarray:
    """(J, 3) places of the joints of a bvhio hierarchy, in the order of the file."""
    root.loadPose(frame)
    return np.array([list(joint.PositionWorld) for joint, _, _ in root.layout()])


def head(data: bytes, frames: int) -> bytes:
    """The first frames of a file: bvhio takes a second for a long clip."""
    lines = [line for line in data.splitlines() if line.strip()]
    motion = next(k for k, line in enumerate(lines) if line.strip() == b"MOTION")
    head = [*lines[: motion + 1], b"Frames: %d" % frames, lines[motion + 2]]
    return b"\n".join([*head, *lines[motion + 3 :][:frames]]) + b"\n"


def agrees(document: Document, root: Any) -> None:
    ours = forward(document.clip).positions
    size = max(1.0, float(np.abs(ours).max()))
    for frame in range(len(ours)):
        np.testing.assert_allclose(places(root, frame), ours[frame], atol=2e-5 * size)


@pytest.mark.clips
def test_kinematics_agrees_on_clips_of_all_origins(tmp_path: Path) -> None:
    seen: set[str] = set()
    for path in need(one_of_each_origin(), "clips"):
        if path.parent.name in seen:
            continue
        data = path.read_bytes()
        document = decode(data)
        odd = {note.id for note in document.notes} & {"frame-time-missing", "positions-zero", "offset-brackets"}
        if document.unusable or odd or len(document.values) < FRAMES or b"\nMOTION" not in data:
            continue
        seen.add(path.parent.name)
        copy = tmp_path / "clip.bvh"
        copy.write_bytes(head(data, FRAMES))
        agrees(decode(copy.read_bytes()), bvhio.readAsHierarchy(str(copy)))
    assert len(seen) > 30


@pytest.mark.parametrize("path", sorted(SAMPLES.glob("*.bvh")), ids=lambda path: path.name)
def test_kinematics_agrees_on_samples(path: Path, tmp_path: Path) -> None:
    copy = tmp_path / "clip.bvh"
    copy.write_bytes(head(path.read_bytes(), 20))
    agrees(decode(copy.read_bytes()), bvhio.readAsHierarchy(str(copy)))


def test_bridge_there_and_back(tmp_path: Path) -> None:
    document = decode(plain())
    container = to_bvhio(document)
    agrees(document, bvhio.convertBvhToHierarchy(container.Root))
    back = from_bvhio(container)
    assert back.skeleton.names == document.skeleton.names
    assert back.frame_time == pytest.approx(document.frame_time)
    np.testing.assert_allclose(forward(back.clip).positions, forward(document.clip).positions, atol=2e-5)
    np.testing.assert_allclose(back.skeleton.end_offsets, document.skeleton.end_offsets, atol=1e-6)
    written = tmp_path / "bridge.bvh"
    bvhio.writeBvh(str(written), container)
    again = decode(written.read_bytes())
    np.testing.assert_allclose(forward(again.clip).positions, forward(document.clip).positions, atol=2e-4)


def test_bridge_hands_over_a_changed_clip_in_units_of_the_file() -> None:
    document = decode(plain()).placed(unit_m=0.01, up="z")
    container = to_bvhio(document, document.clip)
    np.testing.assert_allclose(places(bvhio.convertBvhToHierarchy(container.Root), 3),
                               forward(decode(plain()).clip).positions[3], atol=2e-5)  # fmt: skip


def test_bridge_takes_one_figure_of_several() -> None:
    text = plain().decode()
    tree = text[text.index("ROOT") : text.index("MOTION")]
    rows = [line + " " + line for line in text.splitlines()[-4:]]
    two = decode(("HIERARCHY\n" + tree + tree.replace("Hips", "Other") + "MOTION\nFrames: 4\nFrame Time: 0.1\n"
                  + "\n".join(rows)).encode())  # fmt: skip
    assert to_bvhio(two, root=1).Root.Name == "Other"
    with pytest.raises(ValueError, match="no root 2"):
        to_bvhio(two, root=2)

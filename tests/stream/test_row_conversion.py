"""Rows say, and come to say, what `formats.bvh` reads from them and writes to them."""

from __future__ import annotations

import numpy as np
import pytest
from streams import sample

from footfix.enforce.correction import Correction, apply
from footfix.enforce.leg_state import cross as known_cross
from footfix.enforce.leg_state import exponential as known_exponential
from footfix.enforce.leg_state import left_jacobian
from footfix.enforce.task import posed_joints
from footfix.formats.bvh.channels import changes, placed, to_clip
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import forward
from footfix.settings import Settings
from footfix.stream.arithmetic import cross, exponential_and_jacobian, median, product, product_back
from footfix.stream.calibration import calibrate
from footfix.stream.kinematics import Posing
from footfix.stream.row_conversion import Channels
from footfix.stream.subskeleton import Subskeleton, part_of

ROWS = slice(20, 26)


def corrected(clip: Clip, part: Subskeleton) -> Clip:
    """Turn the legs of a clip a little, and shift its root, in some of its frames."""
    rng, rig, n = np.random.default_rng(3), part.known.rig, len(clip)
    joints = sorted({joint for leg in rig.legs for joint in (leg.hip, leg.knee, leg.ankle)})
    turns = [rotation.multiply(rotation.from_rotation_vector(0.1 * rng.normal(size=(n, 3))), clip.rotation(joint))
             for joint in joints]  # fmt: skip
    some = np.arange(n)[:, None] % 3 > 0
    kept = [np.where(some, turn, clip.rotation(joint)) for turn, joint in zip(turns, joints, strict=True)]
    return apply(clip, Correction(rig.root, some * rng.normal(size=(n, 3)), tuple(joints), np.stack(kept, axis=1)))


@pytest.mark.parametrize(("up", "unit"), [("y", 0.01), ("z", 0.01), ("-y", 1.0), ("x", 0.0254)])
def test_rows_are_read_and_written_as_those_of_a_file(up: str, unit: float) -> None:
    walk = sample("walk_skate")
    part = part_of(walk.skeleton, calibrate(walk.clip, Settings()))
    document = walk.placed(unit_m=unit, up=up)
    codec, rows = Channels(document, part, document.frame_time), document.values[ROWS]
    whole = placed(
        to_clip(document.skeleton, document.channels, rows, document.base, document.frame_time), unit, up
    )  # fmt: skip
    clip = codec.read(rows)
    assert np.array_equal(clip.positions, whole.positions[:, list(part.joints)])
    assert np.array_equal(clip.rotations, whole.rotations[:, list(part.joints)])
    after = corrected(clip, part)
    wanted: Floats = rows.copy()
    number = {joint: k for k, joint in enumerate(part.joints)}
    which = [k for k, channel in enumerate(document.channels) if channel.joint in number]
    channels = [document.channels[k]._replace(joint=number[document.channels[k].joint]) for k in which]
    base = document.base[list(part.joints)]
    for change in changes(channels, rows[:, which], base, clip, after, unit, up):
        wanted[change.frames, which[change.column]] = change.values[change.frames]
    written = codec.write(rows, clip, after)
    assert np.array_equal(written, wanted)
    assert np.any(written != rows)


def test_joints_are_where_kinematics_of_a_clip_puts_them() -> None:
    walk = sample("turn")
    part = part_of(walk.skeleton, calibrate(walk.clip, Settings()))
    joints = posed_joints(part.skeleton, part.known.rig)
    clip = Channels(walk, part, walk.frame_time).read(walk.values[ROWS])
    ours, known = Posing(part.skeleton, joints)(clip), forward(clip, joints)
    assert np.allclose(ours.positions, known.positions, atol=1e-12)
    assert np.allclose(ours.rotations, known.rotations, atol=1e-12)


@pytest.mark.parametrize("size", [2.0, 1e-4, 0.0])
def test_arithmetic_of_few_frames_is_that_of_many(size: float) -> None:
    rng = np.random.default_rng(5)
    vectors, other = size * rng.normal(size=(2, 3, 4, 5))
    both = exponential_and_jacobian(vectors)
    assert np.allclose(both[:, :, 0], known_exponential(vectors), atol=1e-15)
    assert np.allclose(both[:, :, 1], left_jacobian(vectors), atol=1e-15)
    assert np.array_equal(cross(vectors, other), known_cross(vectors, other))
    a, b = rotation.normalize(rng.normal(size=(2, 4, 5, 4)))
    assert np.allclose(product(a, b), rotation.multiply(a, b), atol=1e-15)
    assert np.allclose(product_back(a, b), rotation.multiply(rotation.inverse(a), b), atol=1e-15)
    for n in (1, 2, 7, 8):
        assert np.array_equal(median(vectors[0, 0, :n][None]), np.median(vectors[0, 0, :n][None], axis=1))

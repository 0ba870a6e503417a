"""Walkers: what they promise about contacts holds, whatever the gait, the rate and the size."""

from __future__ import annotations

from pathlib import Path

import artefacts
import bvhio
import exports
import numpy as np
import pytest
from walker import Walk, make
from walker_plan import STYLES, Gait

from footfix.formats.bvh import decode
from footfix.motion.kinematics import forward

TIMES = {"duration": 3.0, "fps": 60.0}


def points(walk: Walk) -> list[np.ndarray]:
    """Tracks of the sole points by forward kinematics of the clip."""
    pose = forward(walk.clip)
    names = walk.clip.skeleton.names
    return [pose.point(names.index(joint), np.array(offset)) for joint, offset in walk.soles]


def gait(name: str, **more: float) -> Walk:
    return make(Gait(name=name, **{**TIMES, **more}))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", STYLES)
def test_planted_points_rest_and_lie_on_the_floor(name: str) -> None:
    walk = gait(name, seed=3)
    ride = np.arange(len(walk.clip))[:, None] * walk.clip.frame_time * np.array(walk.belt)
    for effector, track in zip(walk.contacts.effectors, points(walk), strict=True):
        for contact in effector.contacts:
            planted = (track - ride)[contact.start : contact.end]
            assert np.ptp(planted, axis=0).max() < 1e-9
            if not name.startswith("stairs"):
                assert abs(planted[0, 1]) < 1e-9


@pytest.mark.parametrize("name", STYLES)
def test_unplanted_points_do_not_rest(name: str) -> None:
    # contact ends where motion begins: a tenth of a second outside it the point has moved, and did not sink
    walk = gait(name, seed=4, fps=120.0)
    ride = np.arange(len(walk.clip))[:, None] * walk.clip.frame_time * np.array(walk.belt)
    later = 12
    for effector, track in zip(walk.contacts.effectors, walk.tracks, strict=True):
        for contact in effector.contacts:
            for inside, outside in ((contact.start, contact.start - later), (contact.end - 1, contact.end - 1 + later)):
                if 0 <= outside < len(track):
                    assert np.linalg.norm((track - ride)[outside] - (track - ride)[inside]) > 5e-4
    if not name.startswith("stairs"):
        assert min(track[:, 1].min() for track in walk.tracks) > -1e-9


@pytest.mark.parametrize("name", ["walk", "run", "stairs", "jump"])
def test_tracks_are_those_of_the_clip(name: str) -> None:
    walk = gait(name)
    for stated, found in zip(walk.tracks, points(walk), strict=True):
        np.testing.assert_allclose(stated, found, atol=1e-12)


def test_another_rate_is_the_same_motion() -> None:
    slow, fast = gait("walk", fps=30.0), gait("walk", fps=120.0)
    np.testing.assert_allclose(
        forward(fast.clip).positions[::4], forward(slow.clip).positions, atol=1e-9
    )  # fmt: skip
    assert np.array_equal(fast.contacts.mask()[::4], slow.contacts.mask())


def test_a_smaller_figure_walks_in_its_own_time() -> None:
    child = gait("walk", leg=0.5)
    assert child.clip.positions[:, 0, 1].mean() == pytest.approx(
        0.5 / 0.88 * gait("walk").clip.positions[:, 0, 1].mean(), rel=0.02
    )
    assert sum(len(effector.contacts) for effector in child.contacts.effectors) > sum(
        len(effector.contacts) for effector in gait("walk").contacts.effectors
    )


def test_a_run_flies_and_a_walk_does_not() -> None:
    assert not gait("run").contacts.mask().any(axis=1).all()
    assert gait("walk").contacts.mask().any(axis=1).all()


def test_bones_keep_their_lengths_and_no_knee_is_straight() -> None:
    walk = gait("walk")
    pose = forward(walk.clip)
    names = walk.clip.skeleton.names
    hip, ankle = pose.position(names.index("LeftUpLeg")), pose.position(names.index("LeftFoot"))
    assert np.linalg.norm(hip - ankle, axis=1).max() < 0.99 * 0.88


def test_seeds_repeat_and_differ() -> None:
    assert np.array_equal(gait("walk", seed=1).clip.rotations, gait("walk", seed=1).clip.rotations)
    assert not np.array_equal(gait("walk", seed=1).clip.rotations, gait("walk", seed=2).clip.rotations)


def test_drift_and_scaling_make_planted_feet_slide() -> None:
    walk = gait("walk")
    for changed in (artefacts.drift(walk.clip, 0.04), artefacts.scale_root(walk.clip, 0.9)):
        track = forward(changed).position(walk.clip.skeleton.names.index("LeftToeBase"))
        slides = [np.ptp(track[c.start : c.end], axis=0).max() for c in walk.contacts["left_toe"].contacts]
        assert max(slides) > 0.005


def test_mirroring_swaps_the_feet() -> None:
    walk = gait("turn")
    names = walk.clip.skeleton.names
    there, mirror = forward(walk.clip), forward(artefacts.mirrored(walk.clip))
    left, right = names.index("LeftToeBase"), names.index("RightToeBase")
    np.testing.assert_allclose(mirror.position(left), there.position(right) * [-1, 1, 1], atol=1e-12)


def test_turning_a_clip_turns_its_points() -> None:
    walk = gait("walk")
    pose = forward(artefacts.turned(walk.clip, np.pi / 2, (1.0, 2.0)))
    x, y, z = np.moveaxis(forward(walk.clip).positions, -1, 0)
    np.testing.assert_allclose(pose.positions, np.stack([z + 1.0, y, 2.0 - x], axis=-1), atol=1e-12)


@pytest.mark.parametrize("change", [exports.with_twists, exports.without_toes])
def test_other_skeletons_move_alike(change: object) -> None:
    walk = gait("walk")
    other = change(walk.clip)  # type: ignore[operator]
    here, there = forward(walk.clip), forward(other)
    for joint, name in enumerate(other.skeleton.names):
        if name in walk.clip.skeleton.names:
            np.testing.assert_allclose(
                there.position(joint), here.position(walk.clip.skeleton.names.index(name)), atol=1e-12
            )


@pytest.mark.parametrize("order", ["ZXY", "XYZ", "ZYX", "YXZ"])
@pytest.mark.parametrize(("unit", "up"), [(0.01, "y"), (1.0, "z"), (0.0254, "y"), (1 / 17.7, "z")])
def test_written_files_hold_the_motion(order: str, unit: float, up: str) -> None:
    walk = gait("walk", duration=0.5)
    clip = exports.renamed(walk.clip, "biped")
    document = decode(exports.bvh(clip, exports.Spelling(order=order, unit_m=unit, up=up, decimals=8)))
    read = document.placed(unit_m=unit, up=up).clip
    called = [read.skeleton.names.index(name) for name in clip.skeleton.names]
    # whatever heading the reader gives to z-up worlds, distances between joints and heights are the motion's
    here, there = forward(clip).positions, forward(read).positions[:, called]
    np.testing.assert_allclose(there[..., 1], here[..., 1], atol=1e-6)
    np.testing.assert_allclose(
        np.linalg.norm(there - there[:1, :1], axis=-1), np.linalg.norm(here - here[:1, :1], axis=-1), atol=1e-6
    )


def test_the_writer_agrees_with_bvhio(tmp_path: Path) -> None:
    walk = gait("walk", duration=0.3)
    path = tmp_path / "walk.bvh"
    path.write_bytes(exports.bvh(walk.clip))
    root = bvhio.readAsHierarchy(str(path))
    root.loadPose(7)
    here = forward(walk.clip).positions[7] * 100.0
    found = {joint.Name: np.array(joint.PositionWorld) for joint, _, _ in root.layout()}
    for joint, name in enumerate(walk.clip.skeleton.names):
        np.testing.assert_allclose(found[name], here[joint], atol=2e-3)  # it reckons in float32

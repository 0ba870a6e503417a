"""A clip of tracks is the clip of whole arrays, and shares what does not change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from footfix.motion.clip import Clip, Floats, Ints, Skeleton, constant_track, per_frame, same_track
from footfix.motion.kinematics import forward, places
from footfix.motion.rotation import normalize

SKELETON = Skeleton(("a", "b", "c", "d"), np.array([-1, 0, 1, 1]), np.arange(12.0).reshape(4, 3))


def both(frames: int = 9) -> tuple[Clip, Clip]:
    """The same motion as whole arrays and as tracks; only the root is moved."""
    rng = np.random.default_rng(0)
    positions = np.tile(SKELETON.offsets, (frames, 1, 1))
    positions[:, 0] = rng.normal(size=(frames, 3))
    rotations = normalize(rng.normal(size=(frames, 4, 4)))
    tracks = [positions[:, 0], *(constant_track(offset, frames) for offset in SKELETON.offsets[1:])]
    turns = [rotations[:, joint] for joint in range(4)]
    return Clip(SKELETON, positions, rotations, 0.01), Clip.from_tracks(SKELETON, tracks, turns, 0.01)


def the_same(one: Clip, other: Clip) -> None:
    assert len(one) == len(other)
    for joint in range(4):
        assert np.array_equal(one.position(joint), other.position(joint))
        assert np.array_equal(one.rotation(joint), other.rotation(joint))
    assert np.array_equal(places(one), places(other))
    assert np.array_equal(forward(one, [3]).rotations, forward(other, [3]).rotations)
    assert np.array_equal(one.positions, other.positions)
    assert np.array_equal(one.rotations, other.rotations)


def test_tracks_and_arrays_are_the_same_clip() -> None:
    the_same(*both())
    whole, tracks = both()
    the_same(whole, replace(tracks))
    assert not tracks.positions.flags.writeable


@pytest.mark.parametrize("which", [slice(2, 5), slice(0, 0), slice(None, None, 3), np.array([4, 0, 4])])
def test_some_frames(which: slice | Ints) -> None:
    whole, tracks = both()
    the_same(whole.frames(which), tracks.frames(which))
    assert np.array_equal(whole.frames(which).positions, whole.positions[which])


def test_places_are_those_of_forward() -> None:
    clip = both()[0]
    assert np.array_equal(places(clip), forward(clip).positions)


def test_other_joints_are_shared() -> None:
    for clip in both():
        place, turn = clip.position(0) + 1.0, clip.rotation(2)[:, [1, 0, 2, 3]]
        new = clip.with_joints({0: place}, {2: turn})
        assert np.array_equal(new.position(0), place)
        assert np.array_equal(new.rotation(2), turn)
        assert all(same_track(new.rotation(joint), clip.rotation(joint)) for joint in (0, 1, 3))
        assert all(same_track(new.position(joint), clip.position(joint)) for joint in (1, 2, 3))
        assert not same_track(new.position(0), clip.position(0))
        positions = clip.positions.copy()
        positions[:, 0] += 1.0
        assert np.array_equal(new.positions, positions)


def test_what_is_held_is_worked_out_once() -> None:
    sizes: list[int] = []

    def twice(track: Floats) -> Floats:
        sizes.append(len(track))
        return 2.0 * track

    assert np.array_equal(per_frame(twice, constant_track([1.0, 2.0], 5)), np.tile([2.0, 4.0], (5, 1)))
    assert np.array_equal(per_frame(twice, np.ones((5, 2))), np.full((5, 2), 2.0))
    assert per_frame(twice, constant_track([1.0], 0)).shape == (0, 1)
    assert sizes == [1, 5, 0]


def test_no_other_attributes() -> None:
    with pytest.raises(AttributeError):
        _ = both()[1].nothing

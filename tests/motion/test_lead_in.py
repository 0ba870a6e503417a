"""Lead-ins: frames before and after the motion are left out, and motion never is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from walker import make
from walker_plan import STYLES, Gait

from footfix.motion import rotation
from footfix.motion.clip import Clip
from footfix.motion.lead_in import motion_range


def walk(name: str = "walk", fps: float = 60.0) -> Clip:
    return make(Gait(name=name, duration=2.0, fps=fps)).clip  # type: ignore[arg-type]


def rest_pose(clip: Clip, frames: int, *, at_origin: bool = True) -> Clip:
    """The skeleton's rest pose, a number of times."""
    joints = len(clip.skeleton)
    positions = np.tile(clip.skeleton.offsets, (frames, 1, 1))
    if not at_origin:
        positions[:, 0] = clip.positions[0, 0]
    return replace(clip, positions=positions, rotations=rotation.identity((frames, joints)))


def joined(*parts: Clip) -> Clip:
    return replace(
        parts[-1],
        positions=np.concatenate([part.positions for part in parts]),
        rotations=np.concatenate([part.rotations for part in parts]),
    )


def blend(one: Clip, other: Clip, frames: int) -> Clip:
    """Frames that lead from one clip's last pose to another's first."""
    weight = (np.arange(1, frames + 1) / (frames + 1))[:, None]
    a, b = one.rotations[-1], other.rotations[0]
    turns = np.stack([rotation.slerp(a, b, w) for w in weight[:, 0]])
    places = one.positions[-1] + weight[..., None] * (other.positions[0] - one.positions[-1])
    return replace(one, positions=places, rotations=turns)


@pytest.mark.parametrize(("name", "fps"), [(name, (30.0, 60.0, 120.0)[k % 3]) for k, name in enumerate(sorted(STYLES))])
def test_motion_is_all_motion(name: str, fps: float) -> None:
    clip = walk(name, fps)
    assert motion_range(clip) == slice(0, len(clip))


@pytest.mark.parametrize("at_origin", [True, False])
@pytest.mark.parametrize("held", [1, 2, 3, 10, 40])
def test_a_rest_pose_at_the_start_is_no_motion(held: int, at_origin: bool) -> None:
    clip = walk()
    before = rest_pose(clip, held, at_origin=at_origin)
    assert motion_range(joined(before, clip)) == slice(held, held + len(clip))


@pytest.mark.parametrize("held", [1, 2, 10])
def test_nor_is_one_at_the_end(held: int) -> None:
    clip = walk()
    longer = joined(clip, rest_pose(clip, held))
    assert motion_range(longer) == slice(0, len(clip))


def test_both_ends_are_looked_at() -> None:
    clip = walk("run")
    longer = joined(rest_pose(clip, 1), clip, rest_pose(clip, 2))
    assert motion_range(longer) == slice(1, 1 + len(clip))


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_frames_that_lead_over_go_with_the_pose(frames: int) -> None:
    clip = walk()
    before = rest_pose(clip, 1)
    longer = joined(before, blend(before, clip, frames), clip)
    found = motion_range(longer)
    assert abs(found.start - (1 + frames)) <= 1  # the last of them is next to the motion
    assert found.stop == len(longer)


def test_an_actor_who_leaves_a_t_pose_slowly_is_motion() -> None:
    clip = walk()
    before = rest_pose(clip, 30, at_origin=False)
    longer = joined(before, blend(before, clip, 30), clip)
    assert motion_range(longer) == slice(0, len(longer))


def test_a_glitch_inside_moves_nothing() -> None:
    clip = walk()
    turns = clip.rotations.copy()
    turns[60, 5] = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(2.0))
    assert motion_range(replace(clip, rotations=turns)) == slice(0, len(clip))


def test_units_and_axes_do_not_matter() -> None:
    clip = joined(rest_pose(walk(), 1), walk())
    skeleton = replace(clip.skeleton, offsets=clip.skeleton.offsets * 39.37)
    inches = replace(clip, skeleton=skeleton, positions=clip.positions * 39.37)
    assert motion_range(inches) == motion_range(clip) == slice(1, len(clip))


@pytest.mark.parametrize("frames", range(20))
def test_short_clips_are_left_whole_or_keep_two_frames(frames: int) -> None:
    clip = walk().frames(slice(0, frames))
    assert motion_range(clip) == slice(0, frames)
    with_pose = joined(rest_pose(clip, 1), clip) if frames else clip
    found = motion_range(with_pose)
    assert found.start in (0, 1)
    assert found.stop == len(with_pose)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 60))
def test_never_fails_on_nonsense(seed: int, frames: int) -> None:
    rng = np.random.default_rng(seed)
    clip = walk().frames(slice(0, frames))
    positions, turns = clip.positions.copy(), rng.normal(size=clip.rotations.shape)
    positions[rng.random(positions.shape) < 0.01] = np.nan
    positions[rng.random(positions.shape) < 0.01] = 1e30
    found = motion_range(replace(clip, positions=positions, rotations=rotation.normalize(turns)))
    assert 0 <= found.start <= found.stop <= frames

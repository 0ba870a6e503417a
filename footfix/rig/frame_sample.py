"""A sample of a clip's frames, enough to find the rig, however long the clip is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footfix.motion.clip import Bools, Clip, Floats, Ints, Skeleton
from footfix.motion.duplicate_frames import doubled
from footfix.motion.kinematics import forward
from footfix.motion.segments import distinct

MOST_FRAMES = 240  # pairs of frames sampled; statistics of a rig change little with more
STEP = 1.0 / 30.0  # [s] between the two frames of a pair, long against the noise of one frame


@dataclass(frozen=True, eq=False)
class Sample:
    """Some frames of a clip, all joints and End Sites in the world.

    Args:
        skeleton: the joints.
        places: (S, J, 3) joints in the world, in the clip's units and axes.
        turns: (S, J, 4) their frames in the world.
        velocities: (S, J, 3) units per second, from pairs of frames.
        ends, end_velocities: (S, E, 3) End Sites in the world, likewise.
        bones: (J,) length of the bone from each joint's parent, 0 for roots.
        local: (S, J, 3) places in the parents' frames.
    """

    skeleton: Skeleton
    places: Floats
    turns: Floats
    velocities: Floats
    ends: Floats
    end_velocities: Floats
    bones: Floats
    local: Floats

    def __len__(self) -> int:
        return int(self.places.shape[0])

    def below(self, joint: int) -> tuple[int, ...]:
        """List a joint and all joints that hang from it, in the order of the file."""
        found = {joint}
        for other in range(joint + 1, len(self.skeleton)):
            if int(self.skeleton.parents[other]) in found:
                found.add(other)
        return tuple(sorted(found))

    def distance(self, one: int, other: int) -> float:
        """Measure how far two joints usually are from each other."""
        known = self._distances.get((one, other))
        if known is None:
            apart = self.places[:, one] - self.places[:, other]
            known = float(np.sqrt(np.einsum("fi,fi->f", apart, apart)).mean())
            self._distances[one, other] = known
        return known

    @cached_property
    def _distances(self) -> dict[tuple[int, int], float]:
        return {}

    @cached_property
    def travel(self) -> Floats:
        """Measure how far each joint moves in its parent's frame, (J,); 0 for joints that only turn."""
        return np.asarray(np.ptp(self.local, axis=0).max(axis=-1) * self.skeleton.translates)

    @cached_property
    def reach(self) -> Floats:
        """Measure the longest distance along bones from each joint down to a tip, (J,)."""
        skeleton = self.skeleton
        reach = np.zeros(len(skeleton))
        if len(skeleton.end_parents):
            lengths = np.linalg.norm(skeleton.end_offsets, axis=-1)
            np.maximum.at(reach, skeleton.end_parents, np.where(np.isfinite(lengths), lengths, 0.0))
        for joint in range(len(skeleton) - 1, 0, -1):
            parent = int(skeleton.parents[joint])
            if parent >= 0:
                reach[parent] = max(reach[parent], reach[joint] + self.bones[joint])
        return reach


def sample(clip: Clip, within: slice = slice(None)) -> Sample:
    """Take up to `MOST_FRAMES` pairs of frames spread evenly over a part of a clip; the rest pose where it has none."""
    skeleton = clip.skeleton
    clip = clip.frames(within)
    clip = doubled(clip).clip(clip)  # what is repeated stands still in between, and says nothing of how fast it moves
    frames = np.arange(len(clip))
    step = max(1, round(STEP / clip.frame_time))
    first, second = _evenly(clip, frames, step)
    if not len(first):  # hardly any frame is valid: look for those few
        frames = frames[_sound(clip, frames)]
        first, second = _evenly(clip, frames, step)
    if not len(first):
        clip, first, second = _at_rest(clip), np.zeros(1, np.intp), np.zeros(1, np.intp)
    else:
        clip = _drawn_out(clip, int(first[len(first) // 2]))
    both = clip.frames(np.concatenate([first, second]))
    pose = forward(both)
    n = len(first)
    elapsed = np.maximum((second - first) * clip.frame_time, 1e-9)[:, None, None]
    ends = np.empty((2 * n, len(skeleton.end_parents), 3))
    for e, (carrier, offset) in enumerate(zip(skeleton.end_parents.tolist(), skeleton.end_offsets, strict=True)):
        ends[:, e] = pose.point(carrier, np.nan_to_num(offset))
    bones = np.median(np.linalg.norm(both.positions[:n], axis=-1), axis=0)
    return Sample(
        skeleton=skeleton,
        places=pose.positions[:n],
        turns=pose.rotations[:n],
        velocities=(pose.positions[n:] - pose.positions[:n]) / elapsed,
        ends=ends[:n],
        end_velocities=(ends[n:] - ends[:n]) / elapsed,
        bones=np.where(skeleton.parents < 0, 0.0, bones),
        local=both.positions[:n],
    )


def _evenly(clip: Clip, frames: Ints, step: int) -> tuple[Ints, Ints]:
    """Choose up to `MOST_FRAMES` pairs of valid frames, `step` apart where the clip is long enough."""
    if not len(frames):
        return frames, frames
    count = max(1, len(frames) - step)
    at = distinct(np.linspace(0, count - 1, min(MOST_FRAMES, count)).round().astype(np.intp))
    first, second = frames[at], frames[np.minimum(at + step, len(frames) - 1)]
    sound = _sound(clip, np.concatenate([first, second])).reshape(2, -1).all(axis=0)
    return first[sound], second[sound]


def _sound(clip: Clip, frames: Ints) -> Bools:
    """Tell which frames hold finite numbers of a size that motion has."""
    if not len(frames):
        return np.zeros(0, np.bool_)
    some = clip.frames(frames)
    extent = np.abs(some.positions).reshape(len(frames), -1).max(axis=1, initial=0.0)
    finite = np.isfinite(extent) & np.isfinite(some.rotations).reshape(len(frames), -1).all(axis=1)
    if not finite.any():
        return np.asarray(finite, dtype=np.bool_)
    usual = float(np.median(extent[finite]))
    return np.asarray(finite & (np.where(finite, extent, 0.0) <= 1e4 * max(usual, 1e-9)), dtype=np.bool_)


def _drawn_out(clip: Clip, frame: int) -> Clip:
    """Restore the rest length of bones where position channels near zero have shrunk most of them to nothing."""
    rest = np.abs(clip.skeleton.offsets).max(axis=1)
    bones = (clip.skeleton.parents >= 0) & (rest > 0.0)
    nothing = bones & (np.abs(clip.frames(slice(frame, frame + 1)).positions[0]).max(axis=1) < 1e-3 * rest)
    if nothing.sum() <= 0.3 * bones.sum():
        return clip
    return replace(clip, positions=np.where(nothing[:, None], clip.skeleton.offsets, clip.positions))


def _at_rest(clip: Clip) -> Clip:
    skeleton = clip.skeleton
    offsets = np.where(np.isfinite(skeleton.offsets), skeleton.offsets, 0.0)
    turns = np.zeros((1, len(skeleton), 4))
    turns[..., 3] = 1.0
    return Clip(skeleton, offsets[None], turns, clip.frame_time)

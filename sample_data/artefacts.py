"""What capture, solving and retargeting do to a clip, done on purpose; each returns a changed clip.

The true contacts stay what they were: that is the point. `seed` makes each of them repeatable.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Skeleton


def drift(clip: Clip, distance: float, *, heading: float = 0.7) -> Clip:
    """The root slides evenly by `distance` [m] over the clip, towards `heading` [rad]."""
    ramp = np.linspace(0.0, distance, len(clip))
    return _moved(clip, ramp[:, None] * np.array([np.sin(heading), 0.0, np.cos(heading)]))


def wander(clip: Clip, distance: float, *, slowest: float = 0.25, seed: int = 0) -> Clip:
    """The root wanders over the floor, at most `distance` [m] from its place, no faster than `slowest` [s] a turn."""
    return _moved(clip, _noise(clip, (3,), slowest, seed) * [distance, 0.0, distance])


def scale_root(clip: Clip, scale: float, *, height: bool = True) -> Clip:
    """The root's path scaled and the limbs not, as when a motion is put on a figure of another size."""
    factor = np.array([scale, scale if height else 1.0, scale])
    start = clip.positions[0, 0] * [1.0, 0.0, 1.0]
    return _moved(clip, (clip.positions[:, 0] - start) * (factor - 1.0))


def sink(clip: Clip, depth: float) -> Clip:
    """The whole figure `depth` [m] lower; floating where it is negative."""
    return _moved(clip, np.array([0.0, -depth, 0.0]))


def shake(clip: Clip, degrees: float, *, slowest: float | None = None, seed: int = 0) -> Clip:
    """Noise of a standard deviation of `degrees` on each joint's rotation.

    Frame by frame, or with `slowest` [s] as smooth as if filtered to that time.
    """
    shape = (len(clip.skeleton), 3)
    if slowest is None:
        noise = np.random.default_rng(seed).normal(size=(len(clip), *shape))
    else:
        noise = _noise(clip, shape, slowest, seed) / 0.5
    turns = rotation.from_rotation_vector(np.radians(degrees) * noise)
    return replace(clip, rotations=rotation.multiply(clip.rotations, turns))


def spikes(clip: Clip, degrees: float, count: int, *, seed: int = 0) -> Clip:
    """Single frames in which one joint stands wrong by `degrees`, as after a marker swap."""
    random = np.random.default_rng(seed)
    rotations = clip.rotations.copy()
    for _ in range(count):
        frame, joint = int(random.integers(1, len(clip) - 1)), int(random.integers(1, len(clip.skeleton)))
        axis = random.normal(size=3)
        turn = rotation.from_rotation_vector(np.radians(degrees) * axis / np.linalg.norm(axis))
        rotations[frame, joint] = rotation.multiply(rotations[frame, joint], turn)
    return replace(clip, rotations=rotations)


def retarget(clip: Clip, legs: float, *, feet: float = 1.0) -> Clip:
    """The same rotations on longer or shorter thighs and shins, and feet; the root is left where it was."""
    skeleton, factors = clip.skeleton, np.ones(len(clip.skeleton))
    for joint, name in enumerate(skeleton.names):
        factors[joint] = legs if name.endswith(("Leg", "Foot")) and "UpLeg" not in name else factors[joint]
        factors[joint] = feet if name.endswith("ToeBase") else factors[joint]
    positions = clip.positions * factors[:, None]
    return replace(clip, skeleton=_with_offsets(skeleton, skeleton.offsets * factors[:, None]), positions=positions)


def scaled(clip: Clip, factor: float) -> Clip:
    """Everything larger or smaller: a child, a giant; or another unit of length."""
    skeleton = _with_offsets(clip.skeleton, clip.skeleton.offsets * factor)
    skeleton = replace(skeleton, end_offsets=skeleton.end_offsets * factor)
    return replace(clip, skeleton=skeleton, positions=clip.positions * factor)


def t_pose_first(clip: Clip, frames: int = 1) -> Clip:
    """The clip with T-pose frames put before it, at the origin, as many exporters do."""
    rest = np.broadcast_to(clip.skeleton.offsets, (frames, *clip.skeleton.offsets.shape)).copy()
    rest[:, 0] = [0.0, float(np.median(clip.positions[:, 0, 1])), 0.0]
    still = rotation.identity((frames, len(clip.skeleton)))
    return replace(
        clip,
        positions=np.concatenate([rest, clip.positions]),
        rotations=np.concatenate([still, clip.rotations]),
    )


def mirrored(clip: Clip) -> Clip:
    """Left for right: the figure and its motion in a mirror, joints keeping their names' sides."""
    names = clip.skeleton.names
    swap = [names.index(_other_side(name)) for name in names]
    flip, flip_turn = np.array([-1.0, 1.0, 1.0]), np.array([1.0, -1.0, -1.0, 1.0])
    return replace(clip, positions=clip.positions[:, swap] * flip, rotations=clip.rotations[:, swap] * flip_turn)


def turned(clip: Clip, heading: float, shift: tuple[float, float] = (0.0, 0.0)) -> Clip:
    """The whole motion turned about the vertical by `heading` [rad], then moved over the floor by (x, z) [m]."""
    turn = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(heading))
    positions, rotations = clip.positions.copy(), clip.rotations.copy()
    positions[:, 0] = rotation.rotate(turn, positions[:, 0]) + [shift[0], 0.0, shift[1]]
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    return replace(clip, positions=positions, rotations=rotations)


def _other_side(name: str) -> str:
    if name.startswith("Left"):
        return "Right" + name[4:]
    return "Left" + name[5:] if name.startswith("Right") else name


def _with_offsets(skeleton: Skeleton, offsets: Floats) -> Skeleton:
    return replace(skeleton, offsets=offsets)


def _moved(clip: Clip, shift: Floats) -> Clip:
    positions = clip.positions.copy()
    positions[:, 0] += shift
    return replace(clip, positions=positions)


def _noise(clip: Clip, shape: tuple[int, ...], slowest: float, seed: int) -> Floats:
    """Smooth noise (F, *shape) within -1 to 1: a sum of five sines of random period, from `slowest` [s] up."""
    random = np.random.default_rng(seed)
    t = np.arange(len(clip)).reshape(-1, *[1] * len(shape)) * clip.frame_time
    total = np.zeros((len(clip), *shape))
    for _ in range(5):
        period = slowest * 8.0 ** random.uniform(0.0, 1.0, shape)
        total += np.sin(2.0 * np.pi * (t / period + random.uniform(0.0, 1.0, shape)))
    return total / 5.0

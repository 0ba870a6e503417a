"""A bridge to bvhio, both ways, for those who build rigs with its objects.

bvhio keeps one root, one End Site a joint, and single precision: what is handed over and taken back is the same
motion to about six digits, not the same file.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from footfix.formats.bvh import Document, compose, decode
from footfix.motion.clip import Clip, Skeleton

_AXES = "XYZ"


def to_bvhio(document: Document, clip: Clip | None = None, *, root: int = 0) -> Any:
    """Make a `bvhio.BvhContainer` of one figure.

    Args:
        document: the file; its units and axes are kept.
        clip: the motion [m], y up; by default the file's own.
        root: which root of the file, counted from 0.

    Raises:
        ValueError: the file has no such root.
    """
    import bvhio

    motion = document.file_clip if clip is None else document.in_file(clip)
    skeleton = motion.skeleton
    roots = np.flatnonzero(skeleton.parents < 0).tolist()
    if not 0 <= root < len(roots):
        raise ValueError(f"the file has {len(roots)} roots, counted from 0: there is no root {root}")
    channels: list[list[str]] = [[] for _ in skeleton.names]
    for channel in document.channels:
        if channel.kind:
            kind = "position" if channel.kind == "P" else "rotation"
            channels[channel.joint].append(_AXES[channel.axis] + kind)
    ends = dict(zip(skeleton.end_parents[::-1].tolist(), skeleton.end_offsets[::-1].tolist(), strict=True))
    made: dict[int, Any] = {}
    for j, name in enumerate(skeleton.names):
        parent = int(skeleton.parents[j])
        if parent not in made and j != roots[root]:
            continue
        joint = made[j] = bvhio.BvhJoint(name, skeleton.offsets[j].tolist())
        joint.Channels = channels[j]
        if j in ends:
            joint.EndSite = type(joint.EndSite)(ends[j])
        joint.Keyframes = [
            bvhio.Pose(position, (rotation[3], rotation[0], rotation[1], rotation[2]))
            for position, rotation in zip(motion.positions[:, j].tolist(), motion.rotations[:, j].tolist(), strict=True)
        ]
        if parent in made:
            made[parent].Children.append(joint)
    return bvhio.BvhContainer(made[roots[root]], len(motion), motion.frame_time)


def from_bvhio(container: Any) -> Document:
    """Make a document of a `bvhio.BvhContainer`, in its units and axes.

    Joints with children lose the End Site that bvhio gives to every joint; a joint is movable in place if it has
    position channels.
    """
    joints: list[Any] = []
    parents: list[int] = []
    stack = [(container.Root, -1)]
    while stack:
        joint, parent = stack.pop()
        joints.append(joint)
        parents.append(parent)
        stack += [(child, len(joints) - 1) for child in reversed(joint.Children)]
    ends = [k for k, joint in enumerate(joints) if not joint.Children]
    skeleton = Skeleton(
        names=tuple(joint.Name for joint in joints),
        parents=np.array(parents, dtype=np.intp),
        offsets=np.array([list(joint.Offset) for joint in joints]),
        end_parents=np.array(ends, dtype=np.intp),
        end_offsets=np.array([list(joints[k].EndSite) for k in ends]),
        translates=np.array([any("pos" in name.lower() for name in joint.Channels) for joint in joints]),
    )
    frames = int(container.FrameCount)
    positions = np.empty((len(joints), 3, frames))
    rotations = np.empty((len(joints), 4, frames))
    for k, joint in enumerate(joints):
        poses = joint.Keyframes[:frames]
        positions[k] = np.array([list(pose.Position) for pose in poses]).reshape(frames, 3).T
        rotations[k] = np.array([_xyzw(pose.Rotation) for pose in poses]).reshape(frames, 4).T
    rotations /= np.sqrt(np.sum(rotations**2, axis=1, keepdims=True))
    clip = Clip(skeleton, positions.transpose(2, 0, 1), rotations.transpose(2, 0, 1), container.FrameTime)
    return decode(compose(clip, unit_m=1.0))


def _xyzw(quat: Any) -> tuple[float, float, float, float]:
    return quat.x, quat.y, quat.z, quat.w

"""The motion of a file after some of its numbers were replaced, found without reading it again.

Reading is the slowest step of all, and the values of the new numbers are known from writing them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from footfix.formats.bvh.channels import placed, position_base, to_clip
from footfix.formats.bvh.document import Document
from footfix.motion.clip import Clip, Floats, Skeleton

Column = Callable[[int], Floats]


def motion_after_write(document: Document, new: Mapping[int, Floats]) -> Clip | None:
    """Find the motion that a document would have if some numbers were replaced and it were read again.

    Args:
        document: the file as it was.
        new: column -> (F,) [file units, or degrees] its numbers after writing.

    Returns:
        The clip [m], y up, equal to the last bit to what reading gives; None where it must be read to know: irregular
        rows, and channels that were zero throughout, may be interpreted differently with other numbers.
    """
    rows = document.rows
    if rows.text is not document.text or rows.first is not None or rows.comma:
        return None

    def column(which: int) -> Floats:
        return new[which] if which in new else rows.values[:, which]

    base = position_base(document.skeleton, document.channels, column, len(rows.values))
    if not np.array_equal(base, document.base):
        return None
    clip, channels = document.clip, document.channels
    owners = {kind: {channels[k].joint for k in new if channels[k].kind == kind} for kind in "PR"}
    changed = sorted(owners["P"] | owners["R"])
    roots = [joint for joint in changed if clip.skeleton.parents[joint] < 0]
    others = [joint for joint in changed if clip.skeleton.parents[joint] >= 0]
    places, turns = dict[int, Floats](), dict[int, Floats]()
    for joints, up in ((roots, document.up), (others, "y")):  # below the roots the file's axes don't matter
        if joints:
            alone = placed(_alone(document, joints, column), document.unit_m, up)
            places |= {joint: alone.position(k) for k, joint in enumerate(joints) if joint in owners["P"]}
            turns |= {joint: alone.rotation(k) for k, joint in enumerate(joints) if joint in owners["R"]}
    return clip.with_joints(places, turns)


def _alone(document: Document, joints: Sequence[int], column: Column) -> Clip:
    """Make a clip of some joints, each as a root, in the units and axes of the file."""
    own = {joint: k for k, joint in enumerate(joints)}
    mine = [k for k, channel in enumerate(document.channels) if channel.joint in own]
    channels = [document.channels[k]._replace(joint=own[document.channels[k].joint]) for k in mine]
    names = tuple(document.skeleton.names[joint] for joint in joints)
    loose = Skeleton(names, np.full(len(joints), -1), document.skeleton.offsets[joints])
    numbers = np.stack([column(k) for k in mine], axis=1)
    return to_clip(loose, channels, numbers, document.base[joints], document.frame_time)

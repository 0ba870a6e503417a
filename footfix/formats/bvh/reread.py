"""What a file says after some of its numbers were written anew, without reading it again.

Reading is the slowest step of all, and the writer knows what it wrote: fixed decimals, which mean one number each.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from footfix.formats.bvh.channels import placed, position_base, to_clip
from footfix.formats.bvh.document import Document
from footfix.motion.clip import Clip, Floats, Skeleton

Column = Callable[[int], Floats]


def reread_motion(document: Document, new: Mapping[int, Floats]) -> Clip | None:
    """Find the motion that a document would have if it were written with other numbers and read again.

    Args:
        document: the file as it was.
        new: column -> (F,) what its numbers are now, in the file's units, or degrees.

    Returns:
        The clip [m], y up, to the last bit what reading gives; None where only reading can say: a row that is odd
        may be read otherwise when its numbers change, and so may channels that were zero throughout.
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
    for joints, up in ((roots, document.up), (others, "y")):  # below the roots there are no axes of the file
        if joints:
            alone = placed(_alone(document, joints, column), document.unit_m, up)
            places |= {joint: alone.position(k) for k, joint in enumerate(joints) if joint in owners["P"]}
            turns |= {joint: alone.rotation(k) for k, joint in enumerate(joints) if joint in owners["R"]}
    return clip.with_joints(places, turns)


def _alone(document: Document, joints: Sequence[int], column: Column) -> Clip:
    """Take some joints, each by itself, in the units and axes of the file."""
    own = {joint: k for k, joint in enumerate(joints)}
    mine = [k for k, channel in enumerate(document.channels) if channel.joint in own]
    channels = [document.channels[k]._replace(joint=own[document.channels[k].joint]) for k in mine]
    names = tuple(document.skeleton.names[joint] for joint in joints)
    loose = Skeleton(names, np.full(len(joints), -1), document.skeleton.offsets[joints])
    numbers = np.stack([column(k) for k in mine], axis=1)
    return to_clip(loose, channels, numbers, document.base[joints], document.frame_time)

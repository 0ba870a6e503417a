"""The part of a skeleton that a stream corrects: legs, the joints above them, and followers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from footfix.motion.clip import Skeleton
from footfix.rig.rig import Rig
from footfix.stream.calibration import Calibration


@dataclass(frozen=True, eq=False)
class Subskeleton:
    """Some joints of a skeleton, as a skeleton of their own.

    Args:
        joints: their indices in the whole.
        skeleton: of these joints alone.
        known: the calibrated figure, with joint indices among these.
    """

    joints: tuple[int, ...]
    skeleton: Skeleton
    known: Calibration


def part_of(skeleton: Skeleton, known: Calibration) -> Subskeleton:
    """Cut the joints that move the legs of a figure out of a skeleton."""
    wanted = {*known.rig.joints(), known.rig.root}
    for each in known.followers:
        wanted |= {each.joint, each.foot}
    joints = skeleton.with_ancestors(wanted)
    number = {joint: k for k, joint in enumerate(joints)}
    number[-1] = -1
    ends = [k for k, joint in enumerate(skeleton.end_parents.tolist()) if joint in number]
    part = Skeleton(
        tuple(skeleton.names[joint] for joint in joints),
        np.array([number[int(skeleton.parents[joint])] for joint in joints], dtype=np.intp),
        skeleton.offsets[list(joints)],
        np.array([number[int(skeleton.end_parents[k])] for k in ends], dtype=np.intp),
        skeleton.end_offsets[ends],
        skeleton.translates[list(joints)],
        skeleton.rotates[list(joints)],
    )
    followers = tuple(replace(f, joint=number[f.joint], foot=number[f.foot]) for f in known.followers)
    return Subskeleton(joints, part, replace(known, rig=_renumbered(known.rig, number), followers=followers))


def _renumbered(rig: Rig, number: dict[int, int]) -> Rig:
    legs = tuple(
        replace(
            leg, hip=number[leg.hip], knee=number[leg.knee], ankle=number[leg.ankle],
            toe=None if leg.toe is None else number[leg.toe], chain=tuple(number[joint] for joint in leg.chain),
        )
        for leg in rig.legs
    )  # fmt: skip
    soles = tuple(replace(sole, joint=number[sole.joint]) for sole in rig.soles)
    return replace(rig, root=number[rig.root], pelvis=number[rig.pelvis], legs=legs, soles=soles)

"""Skeletons made strange: other names, orders, units, axes, extra joints. For tests of the rig."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from exports import SCHEMES

from footfix.motion import rotation
from footfix.motion.clip import Clip, Skeleton
from footfix.rig.rig import Rig
from footfix.rig.units import vector

Legs = set[tuple[str, int, int, int, int | None]]

# The legs' names in schemes beyond those of `exports`: hip, knee, ankle, toe, with {s} for Left, {l} for L and so on.
LEGS = {
    "cmu": "{s}UpLeg {s}Leg {s}Foot {s}ToeBase",
    "cmu hip knee": "{s}Hip {s}Knee {s}Ankle {s}Toe",
    "cmu asf": "{l}femur {l}tibia {l}foot {l}toes",
    "motionbuilder": "Character1_{s}UpLeg Character1_{s}Leg Character1_{s}Foot Character1_{s}ToeBase",
    "character creator": "CC_Base_{L}_Thigh CC_Base_{L}_Calf CC_Base_{L}_Foot CC_Base_{L}_ToeBase",
    "lafan": "{s}UpLeg {s}Leg {s}Foot {s}Toe",
    "xsens": "{s}UpperLeg {s}LowerLeg {s}Foot {s}Toe",
    "kinect": "HIP_{S} KNEE_{S} ANKLE_{S} FOOT_{S}",
    "rokoko": "{s}Thigh {s}Shin {s}Foot {s}Toe",
    "makehuman": "UpLeg_{L} LoLeg_{L} Foot_{L} Toe_{L}",
    "makehuman game": "thigh_{l} calf_{l} foot_{l} ball_{l}",
    "rigify": "DEF-thigh.{L} DEF-shin.{L} DEF-foot.{L} DEF-toe.{L}",
    "bandai": "UpperLeg_{L} LowerLeg_{L} Foot_{L} Toes_{L}",
    "mixamo 6": "mixamorig6:{s}UpLeg mixamorig6:{s}Leg mixamorig6:{s}Foot mixamorig6:{s}ToeBase",
    "max": "Bip001 {L} Thigh,Bip001 {L} Calf,Bip001 {L} Foot,Bip001 {L} Toe0",
    "valve": "ValveBiped.Bip01_{L}_Thigh ValveBiped.Bip01_{L}_Calf ValveBiped.Bip01_{L}_Foot ValveBiped.Bip01_{L}_Toe0",
    "mocopi": "{l}_up_leg {l}_low_leg {l}_foot {l}_toes",
    "smpl lower": "{S1}_hip {S1}_knee {S1}_ankle {S1}_foot",
    "spaces": "{s} Hip,{s} Knee,{s} Ankle,{s} Toe",
    "japanese": "{j}足 {j}ひざ {j}足首 {j}つま先",
}
_PARTS = ("UpLeg", "Leg", "Foot", "ToeBase")


def called(clip: Clip, scheme: str) -> Clip:
    """The clip of a walker with its legs called as in a scheme of `LEGS`, the rest of it as it was."""
    names = list(clip.skeleton.names)
    pattern = LEGS[scheme]
    for side, japanese in (("Left", "左"), ("Right", "右")):
        filled = pattern.format(s=side, S=side.upper(), S1=side.lower(), L=side[0], l=side[0].lower(), j=japanese)
        words = filled.split("," if "," in filled else " ")
        for part, word in zip(_PARTS, words, strict=True):
            names[names.index(side + part)] = word
    return with_names(clip, names)


def nameless(clip: Clip) -> Clip:
    """The clip with names that say nothing."""
    return with_names(clip, [f"bone_{index:03d}" for index in range(len(clip.skeleton))])


def with_names(clip: Clip, names: Sequence[str]) -> Clip:
    return replace(clip, skeleton=replace(clip.skeleton, names=tuple(names)))


def shuffled(clip: Clip, seed: int) -> tuple[Clip, list[int]]:
    """The same figure with siblings in another order, and for each joint its index before."""
    skeleton, rng = clip.skeleton, np.random.default_rng(seed)
    order: list[int] = []

    def walk(joint: int) -> None:
        order.append(joint)
        for child in rng.permutation(skeleton.children[joint]).astype(int).tolist():
            walk(child)

    for root in np.flatnonzero(skeleton.parents < 0).tolist():
        walk(root)
    new = np.argsort(order)
    other = Skeleton(
        names=tuple(skeleton.names[j] for j in order),
        parents=np.array([-1 if skeleton.parents[j] < 0 else new[skeleton.parents[j]] for j in order]),
        offsets=skeleton.offsets[order],
        end_parents=new[skeleton.end_parents],
        end_offsets=skeleton.end_offsets,
        translates=skeleton.translates[order],
        rotates=skeleton.rotates[order],
    )
    return replace(clip, skeleton=other, positions=clip.positions[:, order], rotations=clip.rotations[:, order]), order


def scaled(clip: Clip, factor: float) -> Clip:
    skeleton = clip.skeleton
    larger = replace(skeleton, offsets=skeleton.offsets * factor, end_offsets=skeleton.end_offsets * factor)
    return replace(clip, skeleton=larger, positions=clip.positions * factor)


def with_up(clip: Clip, up: str) -> Clip:
    """The same motion in a world with another axis up, every joint's frame turned with it."""
    turn = rotation.between(np.array([0.0, 1.0, 0.0]), vector(up))
    skeleton = clip.skeleton
    other = replace(
        skeleton,
        offsets=rotation.rotate(turn, skeleton.offsets),
        end_offsets=rotation.rotate(turn, skeleton.end_offsets),
    )
    turns = rotation.multiply(rotation.multiply(turn, clip.rotations), rotation.inverse(turn))
    return replace(clip, skeleton=other, positions=rotation.rotate(turn, clip.positions), rotations=turns)


def moved(clip: Clip, yaw: float, shift: Sequence[float]) -> Clip:
    """The clip turned about the vertical [rad] and shifted [m]."""
    turn = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.array(yaw))
    roots = clip.skeleton.parents < 0
    positions, turns = clip.positions.copy(), clip.rotations.copy()
    positions[:, roots] = rotation.rotate(turn, positions[:, roots]) + np.asarray(shift)
    turns[:, roots] = rotation.multiply(turn, turns[:, roots])
    return replace(clip, positions=positions, rotations=turns)


def mirrored(clip: Clip) -> Clip:
    """The clip in a mirror: x changes its sign; names stay."""
    skeleton, flip = clip.skeleton, np.array([-1.0, 1.0, 1.0])
    other = replace(skeleton, offsets=skeleton.offsets * flip, end_offsets=skeleton.end_offsets * flip)
    turns = clip.rotations * np.array([1.0, -1.0, -1.0, 1.0])
    return replace(clip, skeleton=other, positions=clip.positions * flip, rotations=turns)


def hung(clip: Clip, parent: str, chain: Sequence[tuple[str, tuple[float, float, float]]]) -> Clip:
    """The clip with a stiff chain of more joints (name, offset [m]) below a joint."""
    skeleton, frames = clip.skeleton, len(clip)
    names, parents = [*skeleton.names, *(name for name, _ in chain)], skeleton.parents.tolist()
    parents += [skeleton.names.index(parent), *range(len(skeleton), len(skeleton) + len(chain) - 1)]
    offsets = np.array([offset for _, offset in chain])
    larger = Skeleton(
        names=tuple(names),
        parents=np.array(parents),
        offsets=np.concatenate([skeleton.offsets, offsets]),
        end_parents=skeleton.end_parents,
        end_offsets=skeleton.end_offsets,
        translates=np.concatenate([skeleton.translates, np.zeros(len(chain), bool)]),
    )
    positions = np.concatenate([clip.positions, np.tile(offsets, (frames, 1, 1))], axis=1)
    turns = np.concatenate([clip.rotations, rotation.identity((frames, len(chain)))], axis=1)
    return replace(clip, skeleton=larger, positions=positions, rotations=turns)


def without(clip: Clip, *branches: str) -> Clip:
    """The clip without some joints and all that hangs from them."""
    skeleton = clip.skeleton
    gone = {skeleton.names.index(name) for name in branches}
    for joint, parent in enumerate(skeleton.parents.tolist()):
        if parent in gone:
            gone.add(joint)
    kept = [joint for joint in range(len(skeleton)) if joint not in gone]
    ends = [e for e, parent in enumerate(skeleton.end_parents.tolist()) if parent in kept]
    smaller = Skeleton(
        names=tuple(skeleton.names[j] for j in kept),
        parents=np.array([kept.index(p) if (p := int(skeleton.parents[j])) >= 0 else -1 for j in kept]),
        offsets=skeleton.offsets[kept],
        end_parents=np.array([kept.index(int(skeleton.end_parents[e])) for e in ends], dtype=np.intp),
        end_offsets=skeleton.end_offsets[ends],
    )
    return replace(clip, skeleton=smaller, positions=clip.positions[:, kept], rotations=clip.rotations[:, kept])


def together(one: Clip, other: Clip, shift: Sequence[float]) -> Clip:
    """Two figures in one clip, the second one shifted [m]."""
    other = moved(other, 0.0, shift)
    a, b = one.skeleton, other.skeleton
    both = Skeleton(
        names=(*a.names, *(f"B_{name}" for name in b.names)),
        parents=np.concatenate([a.parents, np.where(b.parents < 0, -1, b.parents + len(a))]),
        offsets=np.concatenate([a.offsets, b.offsets]),
        end_parents=np.concatenate([a.end_parents, b.end_parents + len(a)]),
        end_offsets=np.concatenate([a.end_offsets, b.end_offsets]),
    )
    return Clip(
        both,
        np.concatenate([one.positions, other.positions], axis=1),
        np.concatenate([one.rotations, other.rotations], axis=1),
        one.frame_time,
    )


def legs(rig: Rig, order: Sequence[int] | None = None) -> Legs:
    """The legs of a rig by name and joints, as indices before a shuffle that gave `order`."""
    old = (lambda j: j) if order is None else order.__getitem__
    return {
        (leg.name, old(leg.hip), old(leg.knee), old(leg.ankle), None if leg.toe is None else old(leg.toe))
        for leg in rig.legs
    }


ALL_SCHEMES = (*SCHEMES, *LEGS)

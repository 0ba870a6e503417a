"""Clips as the programs of this world would write them: names, units, axes, channel orders, extra joints.

`bvh` is a small writer of its own, so that files for tests do not come from the writer they test.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Skeleton

_PARTS = (
    "Hips", "UpLeg", "Leg", "Foot", "ToeBase", "Spine", "Spine1", "Neck", "Head", "Shoulder", "Arm", "ForeArm", "Hand",
)  # fmt: skip


def _table(pattern: Callable[[str, str], str], words: str) -> dict[str, str]:
    """Plain name to the scheme's, for the parts in the order of `_PARTS`; the pattern joins side and word."""
    names: dict[str, str] = {}
    for part, word in zip(_PARTS, words.split(","), strict=True):
        sides = [""] if part in ("Hips", "Spine", "Spine1", "Neck", "Head") else ["Left", "Right"]
        names |= {side + part: pattern(side, word) for side in sides}
    return names


def _letter(side: str) -> str:
    return side[:1].lower()


SCHEMES: dict[str, dict[str, str]] = {
    "plain": _table(lambda side, word: side + word, ",".join(_PARTS)),
    "mixamo": _table(lambda side, word: f"mixamorig:{side}{word}", ",".join(_PARTS)),
    "daz": _table(
        lambda side, word: _letter(side) + word,
        "hip,Thigh,Shin,Foot,Toe,abdomen,chest,neck,head,Collar,Shldr,ForeArm,Hand",
    ),
    "biped": _table(
        lambda side, word: f"Bip01 {side[:1]} {word}" if side else f"Bip01 {word}",
        "Pelvis,Thigh,Calf,Foot,Toe0,Spine,Spine1,Neck,Head,Clavicle,UpperArm,Forearm,Hand",
    ),
    "unreal": _table(
        lambda side, word: f"{word}_{_letter(side)}" if side else word,
        "pelvis,thigh,calf,foot,ball,spine_01,spine_02,neck_01,head,clavicle,upperarm,lowerarm,hand",
    ),
    "smpl": _table(
        lambda side, word: f"{side[:1]}_{word}" if side else word,
        "Pelvis,Hip,Knee,Ankle,Foot,Spine1,Spine2,Neck,Head,Collar,Shoulder,Elbow,Wrist",
    ),
    "vrm": _table(
        lambda side, word: f"J_Bip_{side[:1] or 'C'}_{word}",
        "Hips,UpperLeg,LowerLeg,Foot,ToeBase,Spine,Chest,Neck,Head,Shoulder,UpperArm,LowerArm,Hand",
    ),
}


def renamed(clip: Clip, scheme: str) -> Clip:
    """The clip with its joints called as in a scheme of `SCHEMES`, or "nothing": names that say nothing."""
    names = clip.skeleton.names
    if scheme == "nothing":
        called = tuple(f"joint{index:02d}" for index in range(len(names)))
    else:
        called = tuple(SCHEMES[scheme].get(name, name) for name in names)
    return replace(clip, skeleton=replace(clip.skeleton, names=called))


def without_toes(clip: Clip, *, ends: bool = True) -> Clip:
    """The feet without toe joints: where these were, the feet have End Sites, or nothing."""
    skeleton = clip.skeleton
    toes = [j for j, name in enumerate(skeleton.names) if name.endswith("ToeBase")]
    kept = np.array([j for j in range(len(skeleton)) if j not in toes])
    new_index = {int(j): k for k, j in enumerate(kept)}
    of_others = [k for k, parent in enumerate(skeleton.end_parents.tolist()) if parent not in toes]
    end_parents = [new_index[int(skeleton.end_parents[k])] for k in of_others]
    end_offsets = [skeleton.end_offsets[k] for k in of_others]
    if ends:
        end_parents += [new_index[int(skeleton.parents[toe])] for toe in toes]
        end_offsets += [skeleton.offsets[toe] for toe in toes]
    smaller = Skeleton(
        names=tuple(skeleton.names[j] for j in kept),
        parents=np.array([new_index.get(int(skeleton.parents[j]), -1) for j in kept]),
        offsets=skeleton.offsets[kept],
        end_parents=np.array(end_parents),
        end_offsets=np.array(end_offsets),
    )
    return Clip(smaller, clip.positions[:, kept], clip.rotations[:, kept], clip.frame_time)


def with_twists(clip: Clip) -> Clip:
    """A twist bone half way down each thigh and shin, with a part of the turn about the bone."""
    for name in ("LeftUpLeg", "RightUpLeg", "LeftLeg", "RightLeg"):
        clip = _twisted(clip, name)
    return clip


def _twisted(clip: Clip, name: str) -> Clip:
    skeleton = clip.skeleton
    above = skeleton.names.index(name)
    below = skeleton.children[above][0]
    half = 0.5 * skeleton.offsets[below]
    shift = np.array([j if j <= above else j + 1 for j in range(len(skeleton))])
    parents = np.insert(shift[skeleton.parents], above + 1, above)
    parents[0] = -1
    parents[below + 1] = above + 1
    offsets = np.insert(skeleton.offsets, above + 1, half, axis=0)
    offsets[below + 1] = half
    frames = len(clip)
    turn = rotation.from_axis_angle(
        half / np.linalg.norm(half), 0.1 * np.sin(np.arange(frames) * clip.frame_time * 3.0)
    )
    positions = np.insert(clip.positions, above + 1, half, axis=1)
    positions[:, below + 1] = half
    rotations = np.insert(clip.rotations, above + 1, turn, axis=1)
    # the twist is about the bone, so what hangs below only has to turn back
    rotations[:, below + 1] = rotation.multiply(rotation.inverse(turn), rotations[:, below + 1])
    names = (*skeleton.names[: above + 1], f"{name}Twist", *skeleton.names[above + 1 :])
    larger = Skeleton(
        names=names,
        parents=parents,
        offsets=offsets,
        end_parents=shift[skeleton.end_parents],
        end_offsets=skeleton.end_offsets,
    )
    return Clip(larger, positions, rotations, clip.frame_time)


@dataclass(frozen=True, kw_only=True)
class Spelling:
    """How a BVH file is written.

    Args:
        unit_m: [m] of the file's unit of length.
        up: "y" or "z".
        order: of the rotation channels, for every joint.
        root_order: of the root's, if it differs.
        decimals: of every number in the motion block.
        six: True for position channels on every joint.
        newline: "\n" or "\r\n".
        indent: of one level of the hierarchy.
    """

    unit_m: float = 0.01
    up: str = "y"
    order: str = "ZXY"
    root_order: str = ""
    decimals: int = 6
    six: bool = False
    newline: str = "\n"
    indent: str = "  "


def bvh(clip: Clip, spelling: Spelling | None = None) -> bytes:
    """The clip as the bytes of a BVH file."""
    how = spelling or Spelling()
    placed = _z_up(clip) if how.up == "z" else clip
    lines = ["HIERARCHY", *_hierarchy(placed.skeleton, how), "MOTION", f"Frames: {len(clip)}"]
    lines.append(f"Frame Time: {clip.frame_time:.8f}")
    lines += _rows(_channels(placed, how), how.decimals)
    return (how.newline.join(lines) + how.newline).encode("utf-8")


def _z_up(clip: Clip) -> Clip:
    """The same motion in a world whose z is up, every joint's frame turned with it."""
    turn = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(np.pi / 2))
    back = rotation.inverse(turn)
    skeleton = replace(
        clip.skeleton,
        offsets=_square(rotation.rotate(turn, clip.skeleton.offsets)),
        end_offsets=_square(rotation.rotate(turn, clip.skeleton.end_offsets)),
    )
    rotations = rotation.multiply(rotation.multiply(turn, clip.rotations), back)
    return replace(clip, skeleton=skeleton, positions=rotation.rotate(turn, clip.positions), rotations=rotations)


def _square(offsets: Floats) -> Floats:
    return np.asarray(np.round(offsets, 15) + 0.0)


def _hierarchy(skeleton: Skeleton, how: Spelling) -> list[str]:
    lines: list[str] = []

    def offset(values: Floats) -> str:
        return "OFFSET " + " ".join(f"{value / how.unit_m + 0.0:.{how.decimals}f}" for value in values)

    def write(joint: int, depth: int) -> None:
        pad = how.indent * depth
        kind = "ROOT" if skeleton.parents[joint] < 0 else "JOINT"
        order = how.root_order or how.order if depth == 0 else how.order
        turns = [f"{axis}rotation" for axis in order]
        places = ["Xposition", "Yposition", "Zposition"] if depth == 0 or how.six else []
        channels = [*places, *turns]
        lines.extend([f"{pad}{kind} {skeleton.names[joint]}", f"{pad}{{"])
        lines.append(f"{pad}{how.indent}{offset(skeleton.offsets[joint])}")
        lines.append(f"{pad}{how.indent}CHANNELS {len(channels)} {' '.join(channels)}")
        for child in skeleton.children[joint]:
            write(child, depth + 1)
        for end in np.flatnonzero(skeleton.end_parents == joint):
            inner = how.indent * (depth + 1)
            lines.extend([f"{inner}End Site", f"{inner}{{"])
            lines.extend([f"{inner}{how.indent}{offset(skeleton.end_offsets[end])}", f"{inner}}}"])
        lines.append(f"{pad}}}")

    write(0, 0)
    return lines


def _channels(clip: Clip, how: Spelling) -> Floats:
    """(F, C) the motion block, joints in the order of the hierarchy."""
    columns: list[Floats] = []
    for joint in _depth_first(clip.skeleton):
        root = clip.skeleton.parents[joint] < 0
        if root or how.six:
            columns.append(clip.positions[:, joint] / how.unit_m)
        order = how.root_order or how.order if root else how.order
        turns = rotation.to_euler(clip.rotations[:, joint], order)
        columns.append(np.degrees(np.unwrap(turns, axis=0) if root else turns))
    return np.concatenate(columns, axis=1)


def _depth_first(skeleton: Skeleton, joint: int = 0) -> Iterable[int]:
    yield joint
    for child in skeleton.children[joint]:
        yield from _depth_first(skeleton, child)


def _rows(values: Floats, decimals: int) -> list[str]:
    rounded = np.round(values, decimals) + 0.0  # no minus before a zero
    row = " ".join([f"%.{decimals}f"] * values.shape[1])
    return [row % tuple(each) for each in rounded.tolist()]

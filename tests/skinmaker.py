"""Characters whose soles are known: boxes for feet, on the skeleton of a walker, as values and as glTF files."""

from __future__ import annotations

from typing import Any

import numpy as np
from glbmaker import Writer, animation_of

from footfix.motion.clip import Clip, Floats
from footfix.rig.skin import Skin

BEHIND, BEFORE, HALF, THICK = 0.05, 0.07, 0.04, 0.02  # [m] behind the ankle, before the toe joint, half wide, below it
_SIDES = ((-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1))


def zero_pose(clip: Clip) -> Floats:
    """(J, 3) [m] the joints where all rotations are none."""
    places = np.array(clip.skeleton.offsets)
    for joint, parent in enumerate(clip.skeleton.parents.tolist()):
        places[joint] += places[parent] if parent >= 0 else 0.0
    return places


def box(low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """(24, 3) the corners of a box, once for each of its sides, and their normals."""
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    vertices, normals = [], []
    for side in np.array(_SIDES, dtype=np.float64):
        across = [np.roll(np.abs(side), k) for k in (1, 2)]
        for a, b in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
            vertices.append(middle + half * (side + a * across[0] + b * across[1]))
            normals.append(side)
    return np.array(vertices), np.array(normals)


def feet_boxes(clip: Clip, longer: float = 1.0) -> list[tuple[str, Floats, Floats]]:
    """For each foot joint its name, and the box that moves with it: the sole lies `THICK` below the toe joint."""
    names, places = clip.skeleton.names, zero_pose(clip)
    found = []
    for side in ("Left", "Right"):
        ankle, toe = (places[names.index(side + part)] for part in ("Foot", "ToeBase"))
        ground, middle = toe[1] - THICK, ankle[2] + longer * (toe[2] - ankle[2])
        for part, back, front, top in (
            ("Foot", ankle[2] - BEHIND, middle, ankle[1]), ("ToeBase", middle, middle + BEFORE, toe[1]),
        ):  # fmt: skip
            corners = [np.array([ankle[0] + sign * HALF, y, z]) for sign, y, z in ((-1, ground, back), (1, top, front))]
            found.append((side + part, *box(*corners)))
    return found


def skin_of(clip: Clip, *, turn: Floats | None = None, scale: float = 1.0, names: list[str] | None = None,
            longer: float = 1.0) -> Skin:  # fmt: skip
    """A walker with boxes for feet, turned (3, 3) and scaled.

    Args:
        clip: of the walker.
        turn, scale: of the space it is modelled in.
        names: of its joints, where they are not the clip's.
        longer: how much longer its feet are, from ankle to toe joint.
    """
    turn = np.eye(3) if turn is None else turn
    own, places = list(clip.skeleton.names), zero_pose(clip)
    for side in ("Left", "Right"):
        ankle, toe = (own.index(side + part) for part in ("Foot", "ToeBase"))
        places[toe, 2] = places[ankle, 2] + longer * (places[toe, 2] - places[ankle, 2])
    frames = np.tile(np.eye(4), (len(own), 1, 1))
    frames[:, :3, :3], frames[:, :3, 3] = scale * turn, scale * places @ turn.T
    boxes = feet_boxes(clip, longer)
    vertices = np.concatenate([corners for _, corners, _ in boxes])
    normals = np.concatenate([each for _, _, each in boxes])
    joints = np.repeat([own.index(name) for name, _, _ in boxes], 24)[:, None]
    return Skin(
        "made.glb", tuple(names or own), clip.skeleton.parents, frames, scale * vertices @ turn.T, normals @ turn.T,
        joints, np.ones((len(joints), 1)),
    )  # fmt: skip


def file_of(
    clip: Clip, *, bound: str = "skin", weights: float = 1.0, normals: bool = True, animation: Clip | None = None,
    feet: bool = True,
) -> bytes:  # fmt: skip
    """The same walker as a GLB, in metres, y up.

    Args:
        clip: of the walker; its first frame is the nodes' rest pose, not that of binding.
        bound: "skin": all in one; "shoes": toes in a skin of their own, modelled in centimetres and z up; "rigid":
            toes without a skin, below their nodes.
        weights: what those of a vertex add up to.
        normals: whether they are written.
        animation: of its joints; none without it.
        feet: whether the boxes move with the feet, or with the root.
    """
    made, own, places = Writer(), clip.skeleton.names, zero_pose(clip)
    nodes: list[dict[str, Any]] = [
        {"name": name, "translation": clip.position(j)[0].tolist(), "rotation": clip.rotation(j)[0].tolist()}
        for j, name in enumerate(own)
    ]
    for j, parent in enumerate(clip.skeleton.parents.tolist()):
        if parent >= 0:
            nodes[parent].setdefault("children", []).append(j)
    spaces = [np.eye(4), np.array([[100.0, 0, 0, 0], [0, 0, -100.0, 0], [0, 100.0, 0, 0], [0, 0, 0, 1.0]])]
    made.tree |= {"meshes": [], "skins": []}
    for space in spaces:  # x y z in metres -> the space that a skin is modelled in
        inverse = np.tile(np.eye(4), (len(own), 1, 1))
        inverse[:, :3, 3] = -places
        at = made.add((inverse @ np.linalg.inv(space)).transpose(0, 2, 1).reshape(-1, 16))
        made.tree["skins"].append({"joints": list(range(len(own))), "inverseBindMatrices": at})
    for name, vertices, facing in feet_boxes(clip):
        apart = bound if name.endswith("ToeBase") else "skin"
        space, joint = spaces[apart == "shoes"], own.index(name if feet else own[0])
        vertices = vertices - places[joint] if apart == "rigid" else vertices @ space[:3, :3].T
        attributes = {"POSITION": made.add(vertices)}
        if normals:
            turned = facing if apart == "rigid" else facing @ space[:3, :3].T / np.abs(space).max()
            attributes["NORMAL"] = made.add(turned)
        if apart != "rigid":
            attributes["JOINTS_0"] = made.add(np.tile([joint, 0, 0, 0], (24, 1)), "u1")
            attributes["WEIGHTS_0"] = made.add(np.tile([weights, 0.0, 0.0, 0.0], (24, 1)))
        quads = np.arange(0, 24, 4)[:, None] + np.array([0, 2, 1, 1, 2, 3])
        quads[::2] = quads[::2, [0, 2, 1, 3, 5, 4]]  # of sides that look back
        listed = made.add(quads.ravel(), "u2")
        made.tree["meshes"].append({"primitives": [{"attributes": attributes, "indices": listed}]})
        node: dict[str, Any] = {"name": f"{name} mesh", "mesh": len(made.tree["meshes"]) - 1}
        if apart == "rigid":
            nodes[joint].setdefault("children", []).append(len(nodes))
        else:
            node["skin"] = int(apart == "shoes")
        nodes.append(node)
    made.tree["nodes"] = nodes
    if animation is not None:
        made.tree["animations"] = [animation_of(made, "Walk", animation, node=0)]
    return made.glb()

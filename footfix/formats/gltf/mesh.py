"""The skinned meshes of a glTF file, all in the pose they are bound in. Source: glTF 2.0, 3.7.2 and 3.7.3.

A vertex stands at `sum_k w_k W_k B_k v`, with W_k where joint k stands and B_k its inverse bind matrix; in the pose of
binding, W_k is the inverse of B_k. The transform of the node that shows a skinned mesh does not count. Meshes without
a skin move with their node. Skins may be bound in spaces of their own (centimetres, z up): all are brought into that
of the skin with most joints, by the joints that they share.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import PurePath
from typing import Any

import numpy as np

from footfix.errors import InputError
from footfix.formats.bvh.text import Limits
from footfix.formats.gltf.accessors import read_accessor, read_floats
from footfix.formats.gltf.container import Beside, Container, open_container
from footfix.formats.gltf.fields import child, index, indices, rows_of
from footfix.formats.gltf.nodes import Nodes, read_nodes
from footfix.motion import rotation
from footfix.motion.clip import Floats, Ints
from footfix.rig.skin import Skin

_LIMITS = Limits()
_TRIANGLES = 4  # the usual mode of a primitive


def read_skin(data: bytes, *, name: str = "", limits: Limits = _LIMITS, beside: Beside | None = None) -> Skin:
    """Read the meshes of a character and the joints that move them.

    Args:
        data: the file.
        name: what it is called, for messages.
        limits: beyond these it is refused.
        beside: reads a file that this one names.

    Raises:
        InputError: it is no glTF, is damaged, packed, or shows no mesh.
    """
    container = open_container(data, name=name, limits=limits, beside=beside)
    try:
        found = skin_of(container, read_nodes(container, limits))
    except InputError as error:
        raise (error if error.file else error.within(name)) from None
    if found is None:
        raise InputError("it shows no mesh", hint="--skin wants a character with its mesh", file=name)
    return found


def skin_of(container: Container, nodes: Nodes) -> Skin | None:
    """Take the meshes of an open file, and the joints that move them; None where it shows none.

    Args:
        container: the file.
        nodes: its nodes.

    Raises:
        InputError: the meshes are damaged.
    """
    world = _world(nodes)
    skins = [_skin(container, k) for k in range(len(container.tables["skins"]))]
    frames = _bound(nodes, world, skins)
    largest = set(max(skins, key=lambda skin: len(skin[0]))[0]) if skins else set()
    spaces = [_space(skin, frames, largest) for skin in skins]
    parts = []
    for k, row in enumerate(container.tables["nodes"]):
        mesh = index(row, "mesh", f"nodes[{k}]", len(container.tables["meshes"]))
        skin = index(row, "skin", f"nodes[{k}]", len(skins))
        if mesh is not None:
            space = frames[k] if skin is None else spaces[skin]
            parts += _of_mesh(container, mesh, k, None if skin is None else skins[skin][0], space)
    if not parts:
        return None
    most = max(part[2].shape[1] for part in parts)
    joints = np.concatenate([np.pad(part[2], ((0, 0), (0, most - part[2].shape[1]))) for part in parts])
    weights = np.concatenate([np.pad(part[3], ((0, 0), (0, most - part[3].shape[1]))) for part in parts])
    order = np.array(nodes.order, np.intp)
    number = np.empty(len(order), np.intp)
    number[order] = np.arange(len(order))
    parents = nodes.parents[order]
    return Skin(
        PurePath(container.name).name, tuple(nodes.names[k] for k in order.tolist()),
        np.where(parents < 0, -1, number[np.maximum(parents, 0)]), frames[order],
        np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts]),
        number[joints], weights,
    )  # fmt: skip


def _world(nodes: Nodes) -> Floats:
    """Compute where each node stands at rest, (N, 4, 4)."""
    local = np.zeros((len(nodes.names), 4, 4))
    local[:, :3, :3] = rotation.to_matrix(nodes.rotations) * nodes.scales[:, None, :]
    local[:, :3, 3], local[:, 3, 3] = nodes.translations, 1.0
    world = local.copy()
    for k in nodes.order:
        if nodes.parents[k] >= 0:
            world[k] = world[nodes.parents[k]] @ local[k]
    return world


def _skin(container: Container, number: int) -> tuple[list[int], Floats]:
    """Read the joints of a skin, as nodes, and their inverse bind matrices (J, 4, 4)."""
    row, where = container.tables["skins"][number], f"skins[{number}]"
    joints = indices(row, "joints", where, len(container.tables["nodes"]))
    if not joints:
        raise InputError(f"{where} has no joints")
    at = index(row, "inverseBindMatrices", where, len(container.tables["accessors"]))
    if at is None:
        return joints, np.tile(np.eye(4), (len(joints), 1, 1))
    matrices = np.asarray(read_accessor(container, at), dtype=np.float64)
    if matrices.shape[1:] != (4, 4) or len(matrices) < len(joints) or not np.isfinite(matrices).all():
        raise InputError(f"{where} has no inverse bind matrix for each joint")
    return joints, matrices[: len(joints)]


def _bound(nodes: Nodes, world: Floats, skins: Sequence[tuple[list[int], Floats]]) -> Floats:
    """Find where each node stood when the largest skin was bound, (N, 4, 4), in the space of its mesh.

    A node that it does not bind is relative to its parent, or above all bound nodes to its child, as at rest.
    """
    if not skins:
        return world
    joints, inverse = max(skins, key=lambda skin: len(skin[0]))
    frames = world.copy()
    known = np.zeros(len(world), np.bool_)
    frames[joints], known[joints] = _inverse(inverse), True
    for k in reversed(nodes.order):
        parent = int(nodes.parents[k])
        if parent >= 0 and known[k] and not known[parent]:
            frames[parent], known[parent] = frames[k] @ _inverse(world[k]) @ world[parent], True
    first = joints[0]
    for k in nodes.order:
        if not known[k]:
            parent = int(nodes.parents[k]) if nodes.parents[k] >= 0 else first
            frames[k], known[k] = frames[parent] @ _inverse(world[parent]) @ world[k], True
    return frames


def _inverse(matrices: Floats) -> Floats:
    try:
        return np.asarray(np.linalg.inv(matrices))
    except np.linalg.LinAlgError:
        raise InputError("a node of the character, or its bind matrix, is flattened to nothing") from None


def _space(skin: tuple[list[int], Floats], frames: Floats, largest: set[int]) -> Floats:
    """Find the matrix (4, 4) from the space of a skin to the common one, by a joint that the largest skin binds too."""
    joints, inverse = skin
    shared = next((k for k, node in enumerate(joints) if node in largest), 0)
    return np.asarray(frames[joints[shared]] @ inverse[shared])


_Part = tuple[Floats, Floats, Ints, Floats]  # vertices, normals, joints, weights


def _of_mesh(
    container: Container, mesh: int, node: int, joints_of: list[int] | None, to: Floats
) -> list[_Part]:  # fmt: skip
    """Read the primitives of a mesh into the space that all are bound in.

    Args:
        container: the file.
        mesh: its number.
        node: that shows it, and moves it where it has no skin.
        joints_of: its skin, as nodes; None without one.
        to: (4, 4) from its own space.
    """
    back = _inverse(to[:3, :3])
    found = []
    for k, row in enumerate(rows_of(container.tables["meshes"][mesh], "primitives", f"meshes[{mesh}]")):
        where = f"meshes[{mesh}].primitives[{k}]"
        named = child(row, "attributes", where)
        at = index(named, "POSITION", where, len(container.tables["accessors"]))
        if at is None:
            continue
        places = read_floats(container, at, 3)
        normals = _normals(container, row, named, places, where)
        if joints_of is None:
            joints, weights = np.full((len(places), 1), node, np.intp), np.ones((len(places), 1))
        else:
            joints, weights = _weights(container, named, joints_of, len(places), where)
        turned = normals @ back
        turned = turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-12)
        found.append((places @ to[:3, :3].T + to[:3, 3], turned, joints, weights))
    return found


def _normals(container: Container, row: dict[str, Any], named: dict[str, Any], places: Floats, where: str) -> Floats:
    """Read the normals (V, 3) of a primitive, or work them out from its triangles."""
    at = index(named, "NORMAL", where, len(container.tables["accessors"]))
    if at is not None:
        normals = read_floats(container, at, 3)
        if len(normals) != len(places):
            raise InputError(f"{where} has {len(places)} vertices and {len(normals)} normals")
        return normals
    listed = index(row, "indices", where, len(container.tables["accessors"]))
    corners = np.arange(len(places)) if listed is None else np.asarray(read_accessor(container, listed))
    normals = np.zeros_like(places)
    if corners.ndim != 1 or row.get("mode", _TRIANGLES) != _TRIANGLES:
        return normals
    corners = corners[: len(corners) // 3 * 3].astype(np.intp).reshape(-1, 3)
    if corners.size and int(corners.max()) >= len(places):
        raise InputError(f"{where} names vertex {int(corners.max())}, but there are {len(places)} of them")
    a, b, c = (places[corners[:, k]] for k in range(3))
    faces = np.cross(b - a, c - a)
    for k in range(3):
        np.add.at(normals, corners[:, k], faces)
    return normals


def _weights(
    container: Container, named: dict[str, Any], nodes: list[int], vertices: int, where: str
) -> tuple[Ints, Floats]:
    """Read (V, k) the nodes that move each vertex, and (V, k) their weights, which add up to 1."""
    joints, weights = [], []
    for k in range(4):
        ats = [index(named, f"{key}_{k}", where, len(container.tables["accessors"])) for key in ("JOINTS", "WEIGHTS")]
        if ats[0] is None or ats[1] is None:
            break
        joints.append(read_floats(container, ats[0], 4))
        weights.append(read_floats(container, ats[1], 4))
        if len(joints[-1]) != vertices or len(weights[-1]) != vertices:
            raise InputError(f"{where} has {vertices} vertices, and other numbers of joints or weights")
    if not joints:
        raise InputError(f"{where} hangs on a skin, but has no weights")
    which, share = np.concatenate(joints, axis=1).astype(np.intp), np.maximum(np.concatenate(weights, axis=1), 0.0)
    if np.any((which >= len(nodes)) & (share > 0.0)):
        raise InputError(f"{where} names joint {int(which.max())} of a skin that has {len(nodes)}")
    which = np.array(nodes, np.intp)[np.where(share > 0.0, which, 0)]
    return which, share / np.maximum(share.sum(axis=1, keepdims=True), 1e-9)

"""The node tree of a glTF file, and which of its nodes are joints. Source: glTF 2.0, 3.5."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from footfix.errors import InputError
from footfix.formats.bvh.text import Limits
from footfix.formats.gltf.container import Container
from footfix.formats.gltf.fields import Row, floats, index, indices, text
from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats, Ints

_NO_MATRIX = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]
_SHEAR = 1e-3  # of a matrix's columns, beyond which they stand at no right angles


@dataclass(frozen=True, eq=False)
class Nodes:
    """The nodes of a file at rest.

    Args:
        names: of the N nodes; "node 7" of those without one.
        parents: (N,) index of each node's parent, -1 for a root.
        order: (N,) the nodes, parents before their children.
        translations: (N, 3), rotations: (N, 4) xyzw, scales: (N, 3): where each stands in its parent's frame.
        sheared: (N,) whether a node's matrix is more than translation, rotation and scale.
        matrices: (N,) whether it is given by a matrix.
    """

    names: tuple[str, ...]
    parents: Ints
    order: tuple[int, ...]
    translations: Floats
    rotations: Floats
    scales: Floats
    sheared: Bools
    matrices: Bools


def read_nodes(container: Container, limits: Limits) -> Nodes:
    """Read the node tree.

    Args:
        container: the file.
        limits: how many nodes it may have, and how deep they may nest.

    Raises:
        InputError: a node is below itself, has two parents, or invalid numbers.
    """
    rows = container.tables["nodes"]
    if len(rows) > 20 * limits.joints:
        raise InputError(f"{len(rows)} nodes, more than {20 * limits.joints}", hint="limits.joints allows more")
    parents, order = _tree(rows, limits)
    count = len(rows)
    places, turns, sizes = np.zeros((count, 3)), rotation.identity((count,)), np.ones((count, 3))
    turns = np.array(turns)
    sheared, matrices = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    for k, row in enumerate(rows):
        where = f"nodes[{k}]"
        if "matrix" in row:
            matrices[k] = True
            matrix = floats(row, "matrix", where, _NO_MATRIX).reshape(4, 4).T
            places[k], turns[k], sizes[k], sheared[k] = decomposed(matrix)
            continue
        places[k] = floats(row, "translation", where, [0.0] * 3)
        turns[k] = _unit(floats(row, "rotation", where, [0.0, 0.0, 0.0, 1.0]))
        sizes[k] = floats(row, "scale", where, [1.0] * 3)
    names = tuple(text(row, "name") or f"node {k}" for k, row in enumerate(rows))
    return Nodes(names, parents, order, places, turns, sizes, sheared, matrices)


def joints_of(container: Container, nodes: Nodes, moved: Iterable[int]) -> tuple[int, ...]:
    """List the nodes that are joints, parents before their children.

    Joints are the nodes that a skin names or an animation moves, all nodes above these, and the nodes below these
    except meshes, cameras and lights.

    Args:
        container: the file.
        nodes: its nodes.
        moved: nodes that an animation moves.
    """
    rows, count = container.tables["nodes"], len(nodes.names)
    wanted = set(moved)
    for k, skin in enumerate(container.tables["skins"]):
        wanted.update(indices(skin, "joints", f"skins[{k}]", count))
    skinned = {k for k, row in enumerate(rows) if row.get("skin") is not None}
    carrying = np.zeros(count, np.bool_)
    for k in reversed(nodes.order):
        carrying[k] |= k in wanted and k not in skinned
        if carrying[k] and nodes.parents[k] >= 0:
            carrying[nodes.parents[k]] = True
    below = np.zeros(count, np.bool_)  # a joint, or below one without bearing anything
    for k in nodes.order:
        parent = int(nodes.parents[k])
        plain = not any(key in rows[k] for key in ("mesh", "camera", "extensions"))
        below[k] = k in wanted or (parent >= 0 and below[parent] and plain)
    return tuple(k for k in nodes.order if carrying[k] or (below[k] and k not in skinned))


def decomposed(matrix: Floats) -> tuple[Floats, Floats, Floats, bool]:
    """Split a matrix (4, 4) into translation, rotation and scale; tell whether it has shear, or no rotation at all."""
    sizes = np.linalg.norm(matrix[:3, :3], axis=0)
    if sizes.min() <= 0.0:
        return matrix[:3, 3], np.array([0.0, 0.0, 0.0, 1.0]), sizes, True
    turn = matrix[:3, :3] / sizes
    if np.linalg.det(turn) < 0.0:
        sizes, turn = -sizes, -turn
    sheared = bool(np.abs(turn.T @ turn - np.eye(3)).max() > _SHEAR)
    return matrix[:3, 3], rotation.from_matrix(turn), sizes, sheared


def node_at(row: Row, where: str, container: Container) -> int | None:
    """Get the node that an object names."""
    return index(row, "node", where, len(container.tables["nodes"]))


def _tree(rows: list[dict[str, object]], limits: Limits) -> tuple[Ints, tuple[int, ...]]:
    """Find each node's parent, and an order in which parents stand before their children."""
    count = len(rows)
    parents = np.full(count, -1, np.intp)
    children = []
    for k, row in enumerate(rows):
        own = indices(row, "children", f"nodes[{k}]", count)
        for each in own:
            if parents[each] >= 0 or each == k:
                raise InputError(f"nodes[{each}] has two parents, or is below itself")
            parents[each] = k
        children.append(own)
    order, depth = list[int](), np.zeros(count, np.intp)
    waiting = [k for k in range(count - 1, -1, -1) if parents[k] < 0]
    while waiting:
        k = waiting.pop()
        order.append(k)
        if depth[k] > limits.nesting:
            raise InputError(f"nodes nest more than {limits.nesting} deep", hint="limits.nesting allows more")
        for each in reversed(children[k]):
            depth[each] = depth[k] + 1
            waiting.append(each)
    if len(order) < count:
        lost = next(k for k in range(count) if k not in set(order))
        raise InputError(f"nodes[{lost}] is below itself")
    return parents, tuple(order)


def _unit(turn: Floats) -> Floats:
    size = float(np.linalg.norm(turn))
    return turn / size if size > 1e-9 else np.array([0.0, 0.0, 0.0, 1.0])

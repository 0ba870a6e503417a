"""glTF files made from clips: what stands in them is known, and each quirk of real files can be asked for."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats

_CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
_TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
_Z_UP = np.array([-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])  # lays a figure whose z is up on glTF's y


class Writer:
    """Gathers accessors, buffer views and bytes."""

    def __init__(self) -> None:
        self.tree: dict[str, Any] = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}
        self.data = bytearray()

    def view(self, raw: bytes, **more: Any) -> int:
        self.data += bytes(-len(self.data) % 4)
        self.tree["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(raw), **more})
        self.data += raw
        return len(self.tree["bufferViews"]) - 1

    def add(self, values: NDArray[Any], kind: str = "f4", **more: Any) -> int:
        """An accessor of (N,) or (N, w) values, stored as they are."""
        small = np.ascontiguousarray(values, dtype=f"<{kind}")
        width = 1 if small.ndim == 1 else small.shape[1]
        row = {"bufferView": self.view(small.tobytes()), "componentType": _CODES[kind], "count": len(small)}
        self.tree["accessors"].append({**row, "type": _TYPES[width], **more})
        return len(self.tree["accessors"]) - 1

    def glb(self) -> bytes:
        self.tree["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.tree, indent=1).encode()
        text += b" " * (-len(text) % 4)
        body = bytes(self.data) + bytes(-len(self.data) % 4)
        parts = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(body), 0x004E4942) + body
        return b"glTF" + struct.pack("<II", 2, 12 + len(parts)) + parts

    def gltf(self, uri: str = "") -> bytes:
        """The same as text; its bytes in a file of that name, or within."""
        inside = "data:application/octet-stream;base64," + base64.b64encode(bytes(self.data)).decode()
        self.tree["buffers"] = [{"byteLength": len(self.data), "uri": uri or inside}]
        return json.dumps(self.tree, indent=2).encode()


def character(
    clips: Mapping[str, Clip], *, scale: float = 1.0, z_up: bool = False, first: float = 0.0, mode: str = "LINEAR",
    normalised: bool = False, matrices: bool = False, every: int = 1, mid_step: bool = False,
    skins: int = 1,
) -> Writer:  # fmt: skip
    """A character with a mesh and some animations.

    Args:
        clips: name -> clip, all of one skeleton.
        scale: of the armature: 0.01 for joints in centimetres.
        z_up: whether the armature stands upright by a turn of its own.
        first: [s] time of the first key.
        mode: of what moves, "LINEAR", "STEP" or "CUBICSPLINE".
        normalised: rotations as whole numbers of two bytes.
        matrices: nodes that do not move at rest by matrices, and without channels.
        every: keys at every so manieth frame.
        mid_step: the nodes' rest pose is a frame of the first clip, as in files from Mixamo.
        skins: how many skins share the joints.
    """
    made, first_clip = Writer(), next(iter(clips.values()))
    skeleton = first_clip.skeleton
    names = skeleton.names
    nodes: list[dict[str, Any]] = [{"name": "Armature", "children": [], "scale": [scale] * 3}]
    if z_up:
        nodes[0]["rotation"] = _Z_UP.tolist()
    for j, name in enumerate(names):
        turn = first_clip.rotation(j)[len(first_clip) // 3] if mid_step else np.array([0.0, 0.0, 0.0, 1.0])
        place, turn = _local(first_clip, j, skeleton.offsets[j][None], turn[None], scale, z_up)
        still = all(_still(clip, j) for clip in clips.values())
        if matrices and still:
            place, turn = _local(first_clip, j, first_clip.position(j)[:1], first_clip.rotation(j)[:1], scale, z_up)
        nodes.append({"name": name, **_rest(place[0], turn[0], matrices and still)})
    for j, parent in enumerate(skeleton.parents.tolist()):
        nodes[parent + 1].setdefault("children", []).append(j + 1)
    _mesh(made, nodes, len(names), skins)
    made.tree |= {"nodes": nodes, "scenes": [{"nodes": [0]}], "scene": 0}
    made.tree["animations"] = [
        animation_of(
            made, name, clip, node=1, scale=scale, z_up=z_up, start=first, mode=mode, normalised=normalised,
            matrices=matrices, every=every,
        )
        for name, clip in clips.items()
    ]
    return made


def animation_of(
    made: Writer, name: str, clip: Clip, *, node: int, scale: float = 1.0, z_up: bool = False, start: float = 0.0,
    mode: str = "LINEAR", normalised: bool = False, matrices: bool = False, every: int = 1,
) -> dict[str, Any]:  # fmt: skip
    """Write the channels of a clip: `node` is its first joint's, `start` the first key, others as in `character`."""
    keys = np.arange(0, len(clip), every)
    times = start + clip.frame_time * keys
    both = made.add(times[[0, -1]], min=[float(times[0])], max=[float(times[-1])])
    all_of_them = made.add(times, min=[float(np.float32(times[0]))], max=[float(np.float32(times[-1]))])
    samplers, channels = [], []

    def put(of: int, path: str, values: Floats, kind: str = mode) -> None:
        moves = not np.all(values == values[0])
        if not moves:
            values, kind = values[[0, -1]], "STEP"
        elif kind == "CUBICSPLINE":
            values = _splines(values, clip.frame_time * every)
        if path == "rotation" and normalised:
            output = made.add(np.round(values * 32767.0), "i2", normalized=True)
        else:
            output = made.add(values)
        samplers.append({"input": all_of_them if moves else both, "output": output, "interpolation": kind})
        channels.append({"sampler": len(samplers) - 1, "target": {"node": of, "path": path}})

    for j in range(len(clip.skeleton)):
        if matrices and _still(clip, j):
            continue
        place, turn = _local(clip, j, clip.position(j), clip.rotation(j), scale, z_up)
        put(node + j, "translation", place[keys])
        put(node + j, "scale", np.ones((len(keys), 3)))
        put(node + j, "rotation", rotation.continuous(turn[keys]))
    return {"name": name, "samplers": samplers, "channels": channels}


def _local(
    clip: Clip, joint: int, place: Floats, turn: Floats, scale: float, z_up: bool
) -> tuple[Floats, Floats]:  # fmt: skip
    """A joint in the frame of its node's parent: of a root that is the armature's."""
    if clip.skeleton.parents[joint] < 0 and z_up:
        back = rotation.inverse(_Z_UP)
        place, turn = rotation.rotate(back, place), rotation.multiply(back, turn)
    return np.asarray(place / scale), turn


def _still(clip: Clip, joint: int) -> bool:
    return bool(np.ptp(clip.position(joint), axis=0).max() < 1e-9 and np.ptp(clip.rotation(joint), axis=0).max() < 1e-9)


def _rest(place: Floats, turn: Floats, matrix: bool) -> dict[str, Any]:
    if not matrix:
        return {"translation": place.tolist(), "rotation": turn.tolist()}
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = rotation.to_matrix(turn), place
    return {"matrix": whole.T.ravel().tolist()}


def _splines(values: Floats, step: float) -> Floats:
    """Keys with tangents, in and out: those of a curve through its neighbours."""
    slopes = np.gradient(values, step, axis=0)
    return np.stack([slopes, values, slopes], axis=1).reshape(-1, values.shape[1])


def _mesh(made: Writer, nodes: list[dict[str, Any]], joints: int, skins: int) -> None:
    """A mesh that means little, with materials and an image, so that there is something to leave alone."""
    places = made.add(np.linspace(0.0, 1.0, 36).reshape(12, 3), min=[0.0] * 3, max=[1.0] * 3)
    bound = made.add(np.zeros((12, 4)), "u1")
    weights = made.add(np.tile([1.0, 0.0, 0.0, 0.0], (12, 1)))
    inverse = made.add(np.tile(np.eye(4).ravel(), (joints, 1)))
    primitive = {"attributes": {"POSITION": places, "JOINTS_0": bound, "WEIGHTS_0": weights}, "material": 0}
    made.tree["meshes"] = [{"primitives": [primitive]}]
    made.tree["materials"] = [{"pbrMetallicRoughness": {"metallicFactor": 0.10000000149011612}}]
    made.tree["images"] = [{"bufferView": made.view(b"\x89PNG not really"), "mimeType": "image/png"}]
    made.tree["skins"] = [{"joints": list(range(1, joints + 1)), "inverseBindMatrices": inverse} for _ in range(skins)]
    for k in range(skins):
        nodes.append({"name": f"Body {k}", "mesh": 0, "skin": k})
        nodes[0]["children"].append(len(nodes) - 1)


def tree_of(data: bytes) -> dict[str, Any]:
    """The JSON of a GLB, read in the plainest way."""
    size = struct.unpack_from("<I", data, 12)[0]
    found: dict[str, Any] = json.loads(data[20 : 20 + size])
    return found


def binary_of(data: bytes) -> bytes:
    """The binary chunk of a GLB."""
    size = struct.unpack_from("<I", data, 12)[0]
    start = 20 + size
    return data[start + 8 : start + 8 + struct.unpack_from("<I", data, start)[0]]


def with_tree(data: bytes, tree: Mapping[str, Any]) -> bytes:
    """The GLB with another JSON."""
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    body = binary_of(data)
    parts = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(body), 0x004E4942) + body
    return b"glTF" + struct.pack("<II", 2, 12 + len(parts)) + parts


def world(data: bytes, animation: int, times: Sequence[float] | Floats) -> dict[str, Floats]:
    """Where the nodes of a GLB are in the world, read without footfix: name -> (F, 3). LINEAR and STEP alone."""
    tree, body = tree_of(data), binary_of(data)
    at = np.asarray(times, dtype=np.float64)

    def numbers(k: int) -> Floats:
        row = tree["accessors"][k]
        view = tree["bufferViews"][row["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[row["type"]]
        start = view.get("byteOffset", 0) + row.get("byteOffset", 0)
        flat = np.frombuffer(body, "<f4", row["count"] * width, start)
        return flat.reshape(-1, width).astype(np.float64)

    own: dict[tuple[int, str], Floats] = {}
    for channel in tree["animations"][animation]["channels"]:
        sampler = tree["animations"][animation]["samplers"][channel["sampler"]]
        keys, values = numbers(sampler["input"])[:, 0], numbers(sampler["output"])
        step = sampler.get("interpolation", "LINEAR") == "STEP"
        left = np.clip(np.searchsorted(keys, at + 1e-6, side="right") - 1, 0, len(keys) - 1)
        right = np.minimum(left + 1, len(keys) - 1)
        gap = keys[right] - keys[left]
        u = np.where(gap > 0.0, np.clip((at - keys[left]) / np.where(gap > 0.0, gap, 1.0), 0.0, 1.0), 0.0)[:, None]
        u = 0.0 * u if step else u
        a, b = values[left], values[right]
        if channel["target"]["path"] == "rotation":
            b = np.where(np.sum(a * b, axis=1, keepdims=True) < 0.0, -b, b)
        mixed = (1.0 - u) * a + u * b
        if channel["target"]["path"] == "rotation":
            mixed /= np.linalg.norm(mixed, axis=1, keepdims=True)
        own[channel["target"]["node"], channel["target"]["path"]] = mixed
    found: dict[str, Floats] = {}

    def walk(k: int, above: Floats) -> None:
        node = tree["nodes"][k]
        local = np.tile(np.eye(4), (len(at), 1, 1))
        if "matrix" in node:
            local[:] = np.array(node["matrix"]).reshape(4, 4).T
        else:
            turn = own.get((k, "rotation"), np.array(node.get("rotation", [0.0, 0.0, 0.0, 1.0]))[None])
            size = own.get((k, "scale"), np.array(node.get("scale", [1.0] * 3))[None])
            local[:, :3, :3] = rotation.to_matrix(turn) * size[:, None, :]
            local[:, :3, 3] = own.get((k, "translation"), np.array(node.get("translation", [0.0] * 3))[None])
        whole = above @ local
        found[node.get("name", f"node {k}")] = whole[:, :3, 3]
        for each in node.get("children", []):
            walk(each, whole)

    for root in tree["scenes"][0]["nodes"]:
        walk(root, np.tile(np.eye(4), (len(at), 1, 1)))
    return found

"""glTF: a clip that is written into a file is read from it again, and nothing else changes, whatever the file is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import SHARED
from glbmaker import Writer, binary_of, character, tree_of, with_tree, world
from walks import walk

from footfix.errors import InputError
from footfix.formats.document import clips_of, joined, open_document, rewrite, select_frames
from footfix.formats.gltf.accessors import read_accessor
from footfix.formats.gltf.container import open_container
from footfix.formats.suffixes import in_file
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import places

WALK = walk("walk", 30.0, 1.0).clip
OTHER = walk("run", 30.0, 1.0).clip

KINDS: dict[str, dict[str, Any]] = {
    "plain": {},
    "centimetres": {"scale": 0.01},
    "z up": {"scale": 0.01, "z_up": True},
    "late": {"first": 1.0 / 30.0},
    "splines": {"mode": "CUBICSPLINE"},
    "steps": {"mode": "STEP"},
    "matrices": {"matrices": True},
    "mid-step": {"mid_step": True, "scale": 0.01, "z_up": True, "skins": 2},
}


def made(**kind: Any) -> bytes:
    return character({"Walk": WALK, "Other": OTHER}, **kind).glb()


def same_joints(clip: Clip) -> Floats:
    """(F, J, 3) where the walker's joints are in a clip of its file."""
    at = [clip.skeleton.names.index(name) for name in WALK.skeleton.names]
    return places(clip)[:, at]


def bent(clip: Clip) -> tuple[Clip, int, int]:
    """The clip with one joint turned and another moved, in some frames; and which ones."""
    knee, hips = (clip.skeleton.names.index(name) for name in ("LeftLeg", "Hips"))
    turn, place = np.array(clip.rotation(knee)), np.array(clip.position(hips))
    turn[5:9] = rotation.multiply(turn[5:9], rotation.from_rotation_vector(np.tile([0.2, 0.0, 0.0], (4, 1))))
    place[10:15] += [0.0, 0.03, 0.01]
    return clip.with_joints({hips: place}, {knee: turn}), knee, hips


@pytest.mark.parametrize("kind", KINDS)
def test_a_walk_in_a_file_is_the_walk(kind: str) -> None:
    clip = open_document(made(**KINDS[kind]), name="x.glb#Walk").clip
    assert clip.fps == pytest.approx(30.0, rel=1e-5)
    np.testing.assert_allclose(same_joints(clip), places(WALK), atol=2e-6)


def test_rotations_of_two_bytes_are_near() -> None:
    clip = open_document(made(normalised=True), name="x.glb#Walk").clip
    np.testing.assert_allclose(same_joints(clip), places(WALK), atol=2e-4)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_written_is_read_again_and_all_else_stays(kind: str) -> None:
    data = made(**KINDS[kind])
    document = open_document(data, name="x.glb#Walk")
    changed, knee, hips = bent(document.clip)
    written, again = rewrite(document, changed)
    np.testing.assert_allclose(places(again), places(changed), atol=2e-6)
    np.testing.assert_array_equal(again.rotations, open_document(written, name="x.glb#Walk").clip.rotations)
    old, new = tree_of(data), tree_of(written)
    assert binary_of(written)[: len(binary_of(data))] == binary_of(data)
    for key in ("meshes", "materials", "images", "skins", "scenes"):
        assert new[key] == old[key]
    assert new["accessors"][: len(old["accessors"])] == old["accessors"]
    assert new["bufferViews"][: len(old["bufferViews"])] == old["bufferViews"]
    assert new["animations"][1] == old["animations"][1]
    nodes = {document.joints[knee], document.joints[hips]}  # type: ignore[attr-defined]
    for one, other in zip(old["animations"][0]["channels"], new["animations"][0]["channels"], strict=False):
        samplers = [each["animations"][0]["samplers"][c["sampler"]] for each, c in ((old, one), (new, other))]
        assert samplers[0] == samplers[1] or one["target"]["node"] in nodes


@pytest.mark.parametrize("kind", ["plain", "z up", "late", "matrices", "mid-step"])
def test_another_reader_finds_the_bones_where_we_do(kind: str) -> None:
    document = open_document(made(**KINDS[kind]), name="x.glb#Walk")
    written, again = rewrite(document, bent(document.clip)[0])
    seen = world(written, 0, document.grid.times)  # type: ignore[attr-defined]
    theirs = np.stack([seen[name] for name in WALK.skeleton.names], axis=1)
    np.testing.assert_allclose(same_joints(again), theirs, atol=1e-5)


def test_nothing_changed_is_the_same_file() -> None:
    data = made()
    document = open_document(data, name="x.glb#Walk")
    written, again = rewrite(document, document.clip)
    assert written is data and again is document.clip


def test_a_shared_sampler_is_split() -> None:
    data = made()
    tree = tree_of(data)
    legs = [k for k, node in enumerate(tree["nodes"]) if node.get("name") in ("LeftLeg", "RightLeg")]
    channels = [c for c in tree["animations"][0]["channels"]
                if c["target"]["node"] in legs and c["target"]["path"] == "rotation"]  # fmt: skip
    channels[1]["sampler"] = channels[0]["sampler"]
    document = open_document(with_tree(data, tree), name="x.glb#Walk")
    changed, knee, _ = bent(document.clip)
    _, again = rewrite(document, changed)
    other = again.skeleton.names.index("RightLeg")
    np.testing.assert_array_equal(again.rotation(other), document.clip.rotation(other))
    np.testing.assert_allclose(again.rotation(knee), changed.rotation(knee), atol=1e-6)


def test_a_channel_that_was_not_there_is_added() -> None:
    data = made(matrices=True)
    document = open_document(data, name="x.glb#Walk")
    head = document.clip.skeleton.names.index("Head")
    turn = np.tile(rotation.from_rotation_vector(np.array([0.0, 0.3, 0.0])), (document.frames, 1))
    written, again = rewrite(document, document.clip.with_joints({}, {head: turn}))
    np.testing.assert_allclose(again.rotation(head), turn, atol=1e-6)
    moved = {channel["target"]["node"] for channel in tree_of(written)["animations"][0]["channels"]}
    assert not any("matrix" in tree_of(written)["nodes"][k] for k in moved)


def test_a_gltf_file_with_its_bytes_within_or_beside_it() -> None:
    within, beside = (character({"Walk": WALK}).gltf(uri) for uri in ("", "walk%20data.bin"))
    body = bytes(character({"Walk": WALK}).data)
    for data, reads in ((within, None), (beside, {"walk data.bin": body}.__getitem__)):
        document = open_document(data, name="x.gltf", beside=reads)
        written, again = rewrite(document, bent(document.clip)[0])
        read = open_document(written, name="x.gltf", beside=reads)
        np.testing.assert_array_equal(read.clip.rotations, again.rotations)
    with pytest.raises(InputError, match="a file of its own"):
        open_document(beside, name="x.gltf")
    for uri in ("../x.bin", "/etc/passwd", "http://example.org/x.bin"):
        with pytest.raises(InputError, match="beside the file"):
            open_document(character({"Walk": WALK}).gltf(uri), name="x.gltf", beside=lambda name: body)


def test_frames_cut_out_start_at_time_zero_and_all_channels_end_with_them() -> None:
    document = open_document(made(first=1.0), name="x.glb#Walk")
    some = select_frames(document, np.arange(6, 21))
    written, again = rewrite(some, some.clip)
    np.testing.assert_allclose(again.rotations, document.clip.rotations[6:21], atol=1e-6)
    read = open_document(written, name="x.glb#Walk")
    assert read.frames == 15 and read.frame_time == pytest.approx(1.0 / 30.0, rel=1e-5)
    tree = tree_of(written)
    ends = {tree["accessors"][s["input"]]["max"][0] for s in tree["animations"][0]["samplers"]}
    assert max(ends) == pytest.approx(14.0 / 30.0, rel=1e-5) and len(ends) == 1


def test_changes_of_two_animations_make_one_file() -> None:
    data = made(scale=0.01)
    files, clips = [], []
    for name in clips_of(data, name="x.glb") or ():
        document = open_document(data, name=f"x.glb#{name}")
        written, again = rewrite(document, bent(document.clip)[0])
        files.append(written)
        clips.append(again)
    whole = joined(data, files[0], files[1], name="x.glb")
    for name, clip in zip(("Walk", "Other"), clips, strict=True):
        np.testing.assert_array_equal(open_document(whole, name=f"x.glb#{name}").clip.rotations, clip.rotations)
    assert binary_of(whole)[: len(binary_of(data))] == binary_of(data)


def test_keys_further_apart_than_frames_are_looked_at_in_between() -> None:
    document = open_document(made(every=6), name="x.glb#Walk")
    step = round(0.2 / document.frame_time)
    assert step >= 6
    np.testing.assert_allclose(same_joints(document.clip)[::step], places(WALK)[::6], atol=2e-6)


def test_accessors() -> None:
    made = Writer()
    plain = made.add(np.arange(12.0).reshape(4, 3))
    octets = made.add(np.array([[0, 255], [51, 102]]).reshape(4), "u1", normalized=True)
    signed = made.add(np.array([-32768, -32767, 0, 32767]), "i2", normalized=True)
    at, values = (
        made.view(np.array([1, 3], "<u2").tobytes()),
        made.view(np.array([[9, 9, 9], [8, 8, 8]], "<f4").tobytes()),
    )
    sparse = {"count": 2, "indices": {"bufferView": at, "componentType": 5123}, "values": {"bufferView": values}}
    made.tree["accessors"].append({"componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse})
    inter = made.view(np.arange(10.0, dtype="<f4").tobytes(), byteStride=20)
    made.tree["accessors"].append(
        {"bufferView": inter, "byteOffset": 4, "componentType": 5126, "count": 2, "type": "VEC3"}
    )
    matrix = made.add(np.arange(16.0).reshape(1, 16))
    container = open_container(made.glb())
    np.testing.assert_array_equal(read_accessor(container, plain), np.arange(12.0).reshape(4, 3))
    np.testing.assert_allclose(read_accessor(container, octets), [0.0, 1.0, 0.2, 0.4])
    np.testing.assert_allclose(read_accessor(container, signed), [-1.0, -1.0, 0.0, 1.0])
    np.testing.assert_array_equal(read_accessor(container, 3), [[0, 0, 0], [9, 9, 9], [0, 0, 0], [8, 8, 8]])
    np.testing.assert_array_equal(read_accessor(container, 4), [[1, 2, 3], [6, 7, 8]])
    np.testing.assert_array_equal(read_accessor(container, matrix)[0], np.arange(16.0).reshape(4, 4).T)


def _scaled(tree: dict[str, Any], name: str, scale: list[float]) -> None:
    number = next(k for k, node in enumerate(tree["nodes"]) if node.get("name") == name)
    tree["nodes"][number]["scale"] = scale
    channels = tree["animations"][0]["channels"]
    channels[:] = [c for c in channels if c["target"] != {"node": number, "path": "scale"}]


@pytest.mark.parametrize("name", ["LeftLeg", "Hips", "RightFoot"])
def test_uneven_scale_on_a_leg_is_refused_in_words(name: str) -> None:
    data = made()
    tree = tree_of(data)
    _scaled(tree, name, [1.0, 1.3, 1.0])
    (why,) = open_document(with_tree(data, tree), name="x.glb#Walk").unusable
    assert name in why.text and "unevenly" in why.text


def test_scale_that_is_animated_counts_on_a_leg_alone() -> None:
    for name, wrong in (("LeftLeg", True), ("Head", False)):
        writer = character({"Walk": WALK})
        number = next(k for k, node in enumerate(writer.tree["nodes"]) if node.get("name") == name)
        animation = writer.tree["animations"][0]
        output = writer.add(np.array([[1.0] * 3, [1.4] * 3]))
        (channel,) = (c for c in animation["channels"] if c["target"] == {"node": number, "path": "scale"})
        sampler = animation["samplers"][channel["sampler"]]
        sampler.update(output=output, interpolation="LINEAR")
        document = open_document(writer.glb(), name="x.glb")
        assert bool(document.unusable) is wrong


def test_an_even_scale_inside_the_skeleton_is_folded_in() -> None:
    data = made(matrices=True)
    tree = tree_of(data)
    _scaled(tree, "Hips", [2.0] * 3)
    clip = open_document(with_tree(data, tree), name="x.glb#Walk").clip
    seen = world(with_tree(data, tree), 0, np.arange(31) / 30.0)
    np.testing.assert_allclose(same_joints(clip), np.stack([seen[n] for n in WALK.skeleton.names], axis=1), atol=1e-5)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda t: t.update(extensionsRequired=["KHR_draco_mesh_compression"]), "Draco.*gltf-transform"),
        (lambda t: t["bufferViews"][0].update(extensions={"EXT_meshopt_compression": {}}), "meshopt.*gltf-transform"),
        (lambda t: t.pop("animations"), "no animation"),
        (lambda t: t["nodes"][3].update(children=[0]), "below itself"),
        (lambda t: t["nodes"][3].update(children=[3]), "two parents|below itself"),
        (lambda t: t["accessors"][6].update(count=1 << 33), "reaches beyond"),
        (lambda t: t["accessors"][6].update(bufferView=None, count=1 << 33), "no bytes for them"),
        (lambda t: t["bufferViews"][8].update(byteLength=1 << 33), "its buffer at"),
        (lambda t: t["buffers"][0].update(byteLength=1 << 33), "says .* bytes, and has"),
        (lambda t: t["animations"][0]["samplers"][4].update(output=999), "there are"),
        (lambda t: t["nodes"][2].update(rotation=[0, 0, "1", 0]), "4 numbers"),
        (lambda t: t["asset"].update(version="1.0"), "version 1.0"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_the_file(change: Any, says: str) -> None:
    data = made()
    tree = tree_of(data)
    change(tree)
    with pytest.raises(InputError, match=says) as caught:
        open_document(with_tree(data, tree), name="figure.glb#Walk")
    assert caught.value.file.startswith("figure.glb")


def test_times_that_stand_for_endless_frames_are_refused() -> None:
    writer = character({"Walk": WALK})
    times = writer.add(np.array([0.0, 0.001, 0.002, 1e7]))
    output = writer.add(np.arange(12.0).reshape(4, 3))
    animation = writer.tree["animations"][0]
    animation["samplers"].append({"input": times, "output": output})
    animation["channels"][0]["sampler"] = len(animation["samplers"]) - 1
    with pytest.raises(InputError, match="frames"):
        open_document(writer.glb(), name="x.glb")


@pytest.mark.parametrize("seed", range(60))
def test_any_damage_ends_in_words(seed: int) -> None:
    random, data = np.random.default_rng(seed), made(scale=0.01)
    at = int(random.integers(len(data)))
    if seed % 3 == 0:
        data = data[:at]
    elif seed % 3 == 1:
        data = data[:at] + bytes(random.integers(0, 256, 4, dtype=np.uint8)) + data[at + 4 :]
    else:
        data = data[:at] + data[at + int(random.integers(1, 40)) :]
    try:
        for name in clips_of(data, name="x.glb") or ():
            assert open_document(data, name=f"x.glb#{name}").clip is not None
    except InputError as error:
        assert error.file.startswith("x.glb") and str(error)


def test_a_name_says_file_and_clip() -> None:
    assert in_file("a#b/walk.glb#Walk #2") == ("a#b/walk.glb", "Walk #2")
    assert in_file("a#b/walk.bvh") == ("a#b/walk.bvh", "")
    assert in_file("walk.GLB#Run") == ("walk.GLB", "Run")


def test_shared_characters_keep_their_bytes() -> None:
    path = SHARED / "glb" / "horse-animations.glb"
    if not path.exists():
        pytest.skip(f"no file: {path} is absent")
    data = path.read_bytes()
    document = open_document(data, name="horse.glb#Walk")
    assert document.frames == 29 and document.grid.start == pytest.approx(1.0 / 30.0)  # type: ignore[attr-defined]
    hips = document.clip.skeleton.names.index("hips")
    place = document.clip.position(hips) + [0.0, 0.01, 0.0]
    written, again = rewrite(document, document.clip.with_joints({hips: place}, {}))
    np.testing.assert_allclose(again.position(hips), place, atol=1e-6)
    assert binary_of(written)[: len(binary_of(data))] == binary_of(data)
    for key in ("meshes", "materials", "images", "skins", "nodes"):
        assert tree_of(written)[key] == tree_of(data)[key]

"""Soles from a skin: where they are does not depend on the space it is modelled in, on names, or on bone frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from skinmaker import BEFORE, BEHIND, HALF, THICK, skin_of, zero_pose
from walks import walk

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.rig.find import find_rig
from footfix.rig.rig import Rig
from footfix.rig.skin import Skin, feet_of, legs_of, up_of

Z_UP = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
TILTED = rotation.to_matrix(rotation.from_rotation_vector(np.array([0.7, -0.5, 0.9])))
SPACES = {"metres": (np.eye(3), 1.0), "z up": (Z_UP, 1.0), "centimetres": (Z_UP, 100.0), "tilted": (TILTED, 0.3)}


@pytest.fixture(scope="module")
def clip() -> Clip:
    return walk().clip


def offsets(rig: Rig) -> Floats:
    return np.array([sole.offset for sole in rig.soles])


@pytest.mark.parametrize("space", SPACES)
def test_the_sole_is_the_box_that_was_made(clip: Clip, space: str) -> None:
    turn, scale = SPACES[space]
    skin = skin_of(clip, turn=turn, scale=scale)
    at, places = clip.skeleton.names.index, zero_pose(clip)
    for foot, side in zip(feet_of(skin, legs_of(skin)), ("Left", "Right"), strict=True):
        ankle, toe = places[at(side + "Foot")], places[at(side + "ToeBase")]
        ground = toe[1] - THICK
        wanted = {"heel": ankle[2] - BEHIND, "ball": toe[2], "tip": toe[2] + BEFORE}
        for name, z in wanted.items():
            found = getattr(foot, name) @ turn / scale
            assert found == pytest.approx([ankle[0], ground, z], abs=1e-9), name
        assert foot.thickness(foot.heel, scale * turn @ ankle) == pytest.approx(scale * (ankle[1] - ground))
        assert foot.vertices[foot.sole] @ foot.up == pytest.approx(np.full(foot.sole.sum(), foot.level))
        across = foot.vertices[foot.sole] @ foot.left / scale
        assert np.ptp(across) == pytest.approx(2 * HALF)


@pytest.mark.parametrize("space", SPACES)
def test_up_is_where_it_was_modelled(clip: Clip, space: str) -> None:
    turn, scale = SPACES[space]
    skin = skin_of(clip, turn=turn, scale=scale)
    assert up_of(skin, legs_of(skin)) == pytest.approx(turn @ [0.0, 1.0, 0.0], abs=1e-9)


@pytest.mark.parametrize("space", SPACES)
def test_the_soles_on_a_clip_do_not_depend_on_the_space_of_the_mesh(clip: Clip, space: str) -> None:
    turn, scale = SPACES[space]
    plain, other = (find_rig(clip, skin=skin_of(clip, turn=t, scale=s)) for t, s in ((np.eye(3), 1.0), (turn, scale)))
    assert offsets(other) == pytest.approx(offsets(plain), abs=1e-9)
    low, its = (each.lowest(each.pose(clip)) for each in (plain, other))
    assert np.array(its) == pytest.approx(np.array(low), abs=1e-9)


def test_names_that_say_nothing_change_nothing(clip: Clip) -> None:
    names = [f"bone {k}" for k in range(len(clip.skeleton))]
    found = find_rig(clip, skin=skin_of(clip, names=names))
    assert offsets(found) == pytest.approx(offsets(find_rig(clip, skin=skin_of(clip))), abs=1e-9)
    assert "shape" in found.origins["sole.left_heel"]


def with_frames(clip: Clip, seed: int) -> Clip:
    """The same motion with joints whose frames are turned anyhow."""
    parents = clip.skeleton.parents.tolist()
    turns = rotation.normalize(np.random.default_rng(seed).normal(size=(len(parents), 4)))
    above = [np.array([0.0, 0.0, 0.0, 1.0]) if p < 0 else turns[p] for p in parents]
    places, own, rest = [], [], []
    for j in range(len(parents)):
        back = rotation.inverse(above[j])
        places.append(rotation.rotate(back, clip.position(j)))
        rest.append(rotation.rotate(back, clip.skeleton.offsets[j]))
        own.append(rotation.multiply(rotation.multiply(back, clip.rotation(j)), turns[j]))
    ends = zip(clip.skeleton.end_parents.tolist(), clip.skeleton.end_offsets, strict=True)
    tips = [rotation.rotate(rotation.inverse(turns[parent]), offset) for parent, offset in ends]
    skeleton = replace(clip.skeleton, offsets=np.array(rest), end_offsets=np.array(tips).reshape(-1, 3))
    return Clip.from_tracks(skeleton, places, own, clip.frame_time)


@pytest.mark.parametrize("seed", [1, 2])
def test_other_bone_frames_are_met_by_places_of_joints(clip: Clip, seed: int) -> None:
    skin = skin_of(clip, names=[f"bone {k}" for k in range(len(clip.skeleton))])
    turned = with_frames(clip, seed)
    plain, found = find_rig(clip, skin=skin), find_rig(turned, skin=skin)
    wanted, got = plain.tracks(plain.pose(clip)), found.tracks(found.pose(turned))
    assert max(float(np.abs(a - b).max()) for a, b in zip(wanted, got, strict=True)) < 0.004


def test_the_sole_points_stand_where_the_lowest_vertex_does_in_flat_stance(clip: Clip) -> None:
    made = walk()
    rig = find_rig(clip, skin=skin_of(clip))
    pose, planted = rig.pose(clip), made.contacts.mask()
    tracks, lowest = rig.tracks(pose), rig.lowest(pose)
    for leg in range(2):
        own = [k for k, sole in enumerate(rig.soles) if sole.leg == leg]
        flat = planted[:, own].all(axis=1)
        assert flat.sum() > 10
        points = np.min([tracks[k][flat, 1] for k in own], axis=0)
        mesh = np.min([lowest[k][flat] for k in own], axis=0)
        assert np.abs(points - mesh).max() < 0.002


@pytest.mark.parametrize(("longer", "told"), [(1.0, False), (1.03, False), (1.12, True), (0.88, True)])
def test_feet_of_another_length_are_told(clip: Clip, longer: float, told: bool) -> None:
    notes = [note for note in find_rig(clip, skin=skin_of(clip, longer=longer)).notes if note.id == "skin-mismatch"]
    assert bool(notes) == told


def test_a_skin_without_feet_is_told_and_not_used(clip: Clip) -> None:
    skin = skin_of(clip)
    none = Skin(skin.name, skin.names, skin.parents, skin.frames, skin.vertices, skin.normals,
                np.zeros_like(skin.joints), skin.weights)  # fmt: skip
    rig, plain = find_rig(clip, skin=none), find_rig(clip)
    assert offsets(rig) == pytest.approx(offsets(plain))
    assert not rig.meshes
    assert [note.id for note in rig.notes if note.id.startswith("skin")] == ["skin-not-used"]


def test_lowest_is_the_lowest_of_all_tracks(clip: Clip) -> None:
    rig = find_rig(clip, skin=skin_of(clip))
    pose = rig.pose(clip)
    for mesh in rig.meshes:
        tracks = mesh.tracks(pose, np.arange(len(mesh)))
        assert mesh.lowest(pose) == pytest.approx(tracks[..., 1].min(axis=1))


def test_of_many_vertices_those_are_kept_that_can_be_the_lowest(clip: Clip, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = find_rig(clip, skin=skin_of(clip))
    monkeypatch.setattr("footfix.rig.skin_vertices._ALL", 8)
    few = find_rig(clip, skin=skin_of(clip))
    assert len(few.meshes[0]) < len(whole.meshes[0])
    for one, other in zip(whole.meshes, few.meshes, strict=True):
        assert other.lowest(few.pose(clip)) == pytest.approx(one.lowest(whole.pose(clip)), abs=1e-9)


def test_heel_ball_tip_and_thickness_of_each_foot_are_told(clip: Clip) -> None:
    skin = skin_of(clip)
    text = next(note.text for note in find_rig(clip, skin=skin).notes if note.id == "skin-soles")
    at, places = clip.skeleton.names.index, zero_pose(clip)
    for side in ("left", "right"):
        ankle, toe = places[at(side.title() + "Foot")], places[at(side.title() + "ToeBase")]
        thick = 1000 * (ankle[1] - toe[1] + THICK)
        assert (
            f"{side}: heel {1000 * BEHIND:.0f} mm behind and {thick:.0f} mm below the ankle, "
            f"ball {1000 * THICK:.0f} mm below the toe joint, tip {1000 * BEFORE:.0f} mm ahead of it"
        ) in text


def test_joints_that_all_have_one_name_are_matched_by_shape(clip: Clip) -> None:
    names = ("joint",) * len(clip.skeleton)
    alike = replace(clip, skeleton=replace(clip.skeleton, names=names))
    found = find_rig(alike, skin=skin_of(clip, names=list(names)))
    assert "shape" in found.origins["sole.left_heel"]
    assert offsets(found) == pytest.approx(offsets(find_rig(clip, skin=skin_of(clip))), abs=1e-9)


def test_legs_without_length_are_told_and_not_used(clip: Clip) -> None:
    skin = skin_of(clip)
    frames = np.array(skin.frames)
    frames[:, :3, 3] = 0.0
    rig = find_rig(clip, skin=replace(skin, frames=frames))
    assert not rig.meshes
    assert "skin-not-used" in [note.id for note in rig.notes]

"""Where a skin is given, no vertex of a planted foot stays below the floor; root-only correction looks at vertices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from skinmaker import skin_of
from walks import short_walk as walk

from footfix.enforce.correction import apply
from footfix.enforce.leg import calibrate, tracks
from footfix.enforce.mesh_floor import deeper, over_floor, skins_of, sunk
from footfix.enforce.params import EnforceParams
from footfix.enforce.pins import Pins
from footfix.enforce.run import enforce
from footfix.enforce.task import task_of
from footfix.enforce.vertices import Vertices, vertices_of
from footfix.measure.clip import measure
from footfix.motion import rotation
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contact
from footfix.rig.find import find_rig
from footfix.rig.rig import Rig


def spoiled(pitch: float) -> tuple[Clip, Rig]:
    """A walk whose feet point down by an angle [rad] more than they did, and its rig with the soles of a skin."""
    clip = walk().clip
    rig = find_rig(clip, skin=skin_of(clip))
    pitched = rotation.from_rotation_vector(np.array([pitch, 0.0, 0.0]))
    turns = {leg.ankle: rotation.multiply(clip.rotation(leg.ankle), pitched) for leg in rig.legs}
    return clip.with_joints({}, turns), rig


@pytest.mark.parametrize("pitch", [0.0, 0.1])
def test_no_vertex_of_a_planted_foot_is_deep_in_the_floor(pitch: float) -> None:
    clip, rig = spoiled(pitch)
    contacts = walk().contacts
    found = enforce(clip, rig, contacts, EnforceParams())
    before, after = (measure(each, rig, contacts)[0] for each in (clip, apply(clip, found.correction)))
    assert pitch == 0.0 or before.penetration_mm > 8.0
    assert after.penetration_mm < 3.0
    assert after.slide_mm < 5.0


def test_penetration_is_that_of_the_deepest_vertex() -> None:
    clip, rig = spoiled(0.1)
    contacts = walk().contacts
    pose, deepest = rig.pose(clip), 0.0
    for sole, effector in zip(rig.soles, contacts.effectors, strict=True):
        mesh = rig.meshes[sole.leg]
        heights = mesh.tracks(pose, np.arange(len(mesh)))[..., 1].min(axis=1)
        for contact in effector.contacts:
            trim = 1 if contact.end - contact.start >= 5 else 0
            deepest = max(deepest, float(rig.floor - heights[contact.start + trim : contact.end - trim].min()))
    assert measure(clip, rig, contacts)[0].penetration_mm == pytest.approx(1000.0 * deepest, abs=1e-6)


def test_a_heel_that_is_high_over_its_toes_has_no_floor_of_its_own() -> None:
    clip, rig = spoiled(0.6)
    name = "left_heel"
    contacts = walk().contacts
    heel = next(each for each in contacts.effectors if each.name == name)
    own = replace(heel, contacts=(Contact(heel.contacts[1].start, heel.contacts[1].start + 12),))
    contacts = replace(contacts, effectors=tuple(own if each.name == name else each for each in contacts.effectors))
    # the floor is under the toes, which a foot that is pitched so far stands on
    deep = rig.meshes[0].lowest(rig.pose(clip))[own.contacts[0].start + 1 : own.contacts[0].end - 1]
    found = next(
        each for each in measure(clip, replace(rig, floor=float(deep.min())), contacts)[1] if each.effector == name
    )
    assert found.penetration_mm == pytest.approx(0.0, abs=1e-6)
    assert found.float_mm > 60.0


def test_heel_and_toe_are_drawn_up_by_as_much_as_floor_and_step_are_high() -> None:
    clip, rig = spoiled(0.1)
    pose, none = rig.pose(clip), np.zeros(len(clip))
    off, low = none.astype(bool), none - 9.0
    pin = Pins(none[1:], np.zeros((3, len(clip) - 1)), off, low, none, low, np.zeros((3, len(clip))), off)
    pins = [(pin, pin)] * 2
    plain = over_floor(pins, rig, pose, [none, none])
    raised = over_floor(pins, replace(rig, floor=rig.floor + 0.3), pose, [none + 0.2, none])
    for leg, up in ((0, 0.5), (1, 0.3)):
        for one, other in zip(plain[leg], raised[leg], strict=True):
            assert np.allclose(other.level - one.level, up, atol=1e-12)


def test_over_a_step_a_foot_need_not_be_much_higher_than_it_was() -> None:
    """A step is only where a foot once stood: what comes up to it or leaves it need not be over it."""
    clip, rig = spoiled(0.0)
    pose, none = rig.pose(clip), np.zeros(len(clip))
    legs = tracks(clip, rig, pose, calibrate(rig, pose, clip))
    flat, high = (skins_of(rig, legs, pose, 0.0, [none + step] * 2, clip.skeleton) for step in (0.0, 0.5))
    for mesh in rig.meshes:
        floor, captured = flat[mesh.leg].lowest[0], mesh.lowest(pose)
        assert np.ptp(floor) == 0.0 and abs(floor[0] - rig.floor) < 0.01 * rig.leg_length
        bound = high[mesh.leg].lowest[0]
        assert (bound >= floor).all() and (bound <= np.maximum(captured + 0.05 * rig.leg_length, floor)).all()
        assert bound.max() > floor[0] + 0.03, "it swings over the floor, and there it is to stay over its way"


@pytest.mark.parametrize("size", [1.0, 2.0])
def test_a_mesh_deeper_than_two_millimetres_of_a_grown_up_does_not_stay(size: float) -> None:
    clip, rig = spoiled(0.0)
    task = task_of(clip, rig, walk().contacts, EnforceParams())
    one = max(task.footing.plants, key=lambda plant: plant.end - plant.start)
    lowest = rig.lowest(task.pose)[one.effector][one.frames].min()
    for share, deep in ((0.0022, False), (0.0028, True)):  # leg lengths
        leg = size * rig.leg_length
        sized = replace(rig, floor=float(lowest) + share * leg, leg_length=leg)
        assert bool(sunk(task.footing.plants, sized, task.pose, 0.0, task.footing.floors, near=1.0)[one.id]) is deep
        # raised by as much, it is not in the floor
        assert not sunk(task.footing.plants, sized, task.pose, share * leg, task.footing.floors, near=1.0)[one.id]


def test_root_alone_puts_vertices_at_their_floor() -> None:
    clip, rig = spoiled(0.0)
    raised = clip.with_joints({rig.root: clip.position(rig.root) + np.array([0.0, 0.03, 0.0])}, {})
    contacts = walk().contacts
    found = enforce(raised, rig, contacts, EnforceParams(method="root"))
    done = apply(raised, found.correction)
    pose, planted = rig.pose(done), contacts.mask().any(axis=1)
    lowest = np.min(rig.lowest(pose), axis=0)[planted] - rig.floor
    assert abs(float(lowest.mean())) < 0.008
    assert found.correction.joints == ()


def test_what_is_not_over_a_step_has_the_floor_below_it() -> None:
    """A step is only where a foot once stood: a vertex deep below its level is lifted by a little at the most."""
    clip, rig = spoiled(0.0)
    pose, leg = rig.pose(clip), rig.leg_length
    legs = tracks(clip, rig, pose, calibrate(rig, pose, clip))
    step = np.where(np.arange(len(clip)) < 60, 0.0, np.linspace(0.0, 0.3, len(clip)))  # [m]
    found = skins_of(rig, legs, pose, 0.0, [step, 0.0 * step], clip.skeleton)
    sink = 0.0006 * leg
    own = next(mesh for mesh in rig.meshes if mesh.leg == 0).lowest(pose) + 0.03 * leg
    expected = np.where(step > 0.0, np.maximum(np.minimum(step, own - rig.floor + sink), 0.0), 0.0) + rig.floor - sink
    assert np.any(own[step > 0.0] < rig.floor + step[step > 0.0] - sink)
    assert np.allclose(found[0].lowest, expected) and np.allclose(found[1].lowest, rig.floor - sink)


@pytest.mark.parametrize("frame_time", [1.0 / 30.0, 1.0 / 100.0])
def test_a_vertex_in_the_floor_lets_joints_turn_a_fifth_of_a_second_before_and_after(frame_time: float) -> None:
    clip, rig = spoiled(0.0)
    pose = rig.pose(clip)
    legs = tracks(clip, rig, pose, calibrate(rig, pose, clip))
    base = -np.array(legs[0].ankle)[None]  # (1, 3, F) one vertex at the origin
    lowest = np.zeros((1, len(clip)))
    lowest[0, 60] = 0.02  # [m] it is so deep in one frame
    fault = np.full(len(clip), 0.005)
    found = deeper(fault, {0: Vertices(base, None, lowest)}, legs, frame_time)
    around = round(0.2 / frame_time)
    expected = fault.copy()
    expected[60 - around : 61 + around] = 0.02
    assert found == pytest.approx(expected)
    assert deeper(fault, {}, legs, frame_time) is fault


@pytest.mark.parametrize("pitch", [0.0, 0.3])
def test_one_of_the_few_vertices_chosen_is_the_lowest_however_the_foot_turns_near_the_floor(pitch: float) -> None:
    clip, rig = spoiled(pitch)
    pose = rig.pose(clip)
    legs = tracks(clip, rig, pose, calibrate(rig, pose, clip))
    for mesh in rig.meshes:
        leg = legs[mesh.leg]
        own = vertices_of(mesh, leg, pose, 0.0, np.full(len(clip), rig.floor), clip.skeleton)
        assert own.toes is not None
        near = np.flatnonzero(mesh.lowest(pose) < rig.floor + 0.05)
        few = (own.base + own.toes)[..., near].transpose(2, 0, 1)  # (f, N, 3) from the ankle
        every = mesh.tracks(pose, np.arange(len(mesh)))[near] - leg.ankle.T[near, None]
        assert 3 < few.shape[1] < every.shape[1]
        for roll in (-0.4, 0.0, 0.4):
            for tilt in (-0.4, 0.0, 0.4):
                turn = rotation.from_rotation_vector(np.array([tilt, 0.0, roll]))
                low = [rotation.rotate(turn, each)[..., 1].min(axis=1) for each in (few, every)]
                assert np.abs(low[0] - low[1]).max() < 0.004  # [m]


def test_vertices_as_captured_are_what_the_foot_and_its_toes_carry() -> None:
    """What turns with the toes and what turns with the rest of the foot are together the mesh."""
    clip, rig = spoiled(0.0)
    pose = rig.pose(clip)
    legs = tracks(clip, rig, pose, calibrate(rig, pose, clip))
    for mesh in rig.meshes:
        own = vertices_of(mesh, legs[mesh.leg], pose, 0.0, np.full(len(clip), rig.floor), clip.skeleton)
        assert own.toes is not None
        places = own.base + own.toes + legs[mesh.leg].ankle
        every = mesh.tracks(pose, np.arange(len(mesh))).transpose(1, 2, 0)  # (V, 3, F)
        off = np.abs(places[:, None] - every[None]).max(axis=(2, 3)).min(axis=1)
        assert off.max() < 1e-9

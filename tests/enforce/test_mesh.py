"""Where a skin is given, no vertex of a planted foot stays below the floor; root-only correction looks at vertices."""

from __future__ import annotations

import numpy as np
import pytest
from skinmaker import skin_of
from walks import short_walk as walk

from footfix.enforce.correction import apply
from footfix.enforce.leg import calibrate, tracks
from footfix.enforce.params import EnforceParams
from footfix.enforce.run import enforce
from footfix.enforce.vertices import vertices_of
from footfix.measure.clip import measure
from footfix.motion import rotation
from footfix.motion.clip import Clip
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

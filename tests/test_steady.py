"""Legs that shake from frame to frame, and legs that do not."""

from __future__ import annotations

from dataclasses import replace

import artefacts
import numpy as np
import pytest
from walker import Walk, make
from walker_gaits import Gait

from footfix import api
from footfix.enforce.correction import apply
from footfix.enforce.foot import feet, posed
from footfix.enforce.run import EnforceParams, enforce
from footfix.enforce.steady import SteadyParams, settle_of, settled, shaking, steadied
from footfix.formats.bvh import compose, decode, encode
from footfix.measure.clip import peak_acceleration
from footfix.motion.clip import Clip
from footfix.rig.rig import Rig

DT = 1.0 / 120.0


def steady(clip: Clip, strength: float = 1.0) -> tuple[Clip, tuple[int, ...], Rig]:
    rig = api.find_rig(clip)
    calm, joints, _ = steadied(clip, rig, feet(rig, posed(clip, rig)), strength, SteadyParams())
    return calm, joints, rig


def test_noise_is_measured_under_a_motion() -> None:
    random, t = np.random.default_rng(3), DT * np.arange(4000)
    motion = 0.3 * np.stack([np.sin(2 * np.pi * t), np.cos(4 * np.pi * t), np.sin(3.0 * t)], axis=1)
    found = shaking(motion + random.normal(scale=0.002, size=motion.shape))
    assert found.sigma == pytest.approx(0.002 * np.sqrt(3.0), rel=0.05)
    assert found.white == pytest.approx(-0.8, abs=0.06)


@pytest.mark.parametrize("hertz", [3.0, 10.0, 25.0])
def test_an_oscillation_is_as_white_as_its_cosine(hertz: float) -> None:
    t = DT * np.arange(4000)
    circle = np.stack([np.cos(2 * np.pi * hertz * t), np.sin(2 * np.pi * hertz * t)], axis=1)
    assert shaking(circle).white == pytest.approx(np.cos(2 * np.pi * hertz * DT), abs=1e-3)


@pytest.mark.parametrize("settle", [0.015, 0.025, 0.04])
def test_what_noise_is_left_is_what_is_reckoned_with(settle: float) -> None:
    noise = np.random.default_rng(5).normal(size=(20000, 1))
    acceleration = np.diff(settled(noise, DT, settle), n=2, axis=0)[200:-200] / DT**2
    expected = np.sqrt(DT * np.sqrt(2.0) / 16.0) * settle**-2.5
    assert float(acceleration.std()) == pytest.approx(float(expected), rel=0.1)


@pytest.mark.parametrize("gait", ["walk", "run", "turn", "backwards"])
@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_clean_motion_is_left_alone(gait: str, fps: float) -> None:
    clip = make(Gait(name=gait, fps=fps)).clip  # type: ignore[arg-type]
    calm, joints, _ = steady(clip)
    assert calm is clip and joints == ()


@pytest.fixture(scope="module")
def walk() -> Walk:
    return make(Gait(name="walk", fps=120.0, duration=4.0))


@pytest.mark.parametrize("degrees", [0.1, 0.5])
def test_a_shaking_walk_comes_out_calm(walk: Walk, degrees: float) -> None:
    document = decode(compose(artefacts.shake(walk.clip, degrees), unit_m=0.01)).placed(unit_m=0.01, up="y")
    clip = document.clip
    rig = api.find_rig(clip)
    found = enforce(clip, rig, replace(walk.contacts, method="labels"), EnforceParams())
    assert [note.id for note in found.notes if note.id == "legs-steadied"]
    text = encode(document, apply(clip, found.correction))
    after = decode(text).placed(unit_m=0.01, up="y").clip
    clean = peak_acceleration(rig, rig.pose(walk.clip), walk.clip.frame_time)
    before = peak_acceleration(rig, rig.pose(clip), clip.frame_time) / clean
    now = peak_acceleration(rig, rig.pose(after), clip.frame_time) / clean
    assert now < 1.5 < before
    true, shaken, calm = (rig.pose(each) for each in (walk.clip, clip, steady(clip)[0]))
    for leg in rig.legs:  # and nearer to where it truly is
        error = [np.linalg.norm(p.position(leg.knee) - true.position(leg.knee), axis=1).mean() for p in (shaken, calm)]
        assert error[1] < 0.7 * error[0]
    moved = set(found.correction.joints)
    for joint in range(len(clip.skeleton)):  # what hangs above the legs keeps its numbers
        if joint not in moved:
            assert np.array_equal(clip.turn(joint), after.turn(joint))
    names = {clip.skeleton.names[joint] for joint in moved}
    assert not any("Arm" in name or "Spine" in name or "Head" in name for name in names)


def test_the_root_alone_steadies_nothing(walk: Walk) -> None:
    clip = artefacts.shake(walk.clip, 0.3)
    found = enforce(clip, api.find_rig(clip), walk.contacts, EnforceParams(method="root"))
    assert found.correction.joints == ()


def test_no_strength_and_no_share_steady_nothing(walk: Walk) -> None:
    clip = artefacts.shake(walk.clip, 0.3)
    assert steady(clip, 0.0)[0] is clip
    rig = api.find_rig(clip)
    foot = feet(rig, posed(clip, rig))[0]
    track = foot.ankle - foot.hip
    assert settle_of(track, DT, rig.leg_length, SteadyParams(share=0.0)) == 0.0
    assert settle_of(track, DT, rig.leg_length, SteadyParams()) > 0.0


def test_steadying_twice_is_steadying_once(walk: Walk) -> None:
    calm, joints, _ = steady(artefacts.shake(walk.clip, 0.3))
    assert joints
    again, more, _ = steady(calm)
    assert again is calm and more == ()

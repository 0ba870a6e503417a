"""What holds of the legs whichever paper's way leads them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import artefacts
import numpy as np
import pytest
from footplants import plants_of, strays
from walks import rig_of, straightness
from walks import short_walk as walk

from footfix.enforce.correction import Correction, apply
from footfix.enforce.papers import glardon, kim_neff
from footfix.enforce.papers.glardon import GlardonParams
from footfix.enforce.papers.kim_neff import KimNeffParams
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.rig.rig import Rig


def by_glardon(clip: Clip, rig: Rig, plants: list[Any], ground: Floats | None = None) -> Correction:
    return glardon.correct(clip, rig, plants, GlardonParams(), ground=ground)


def by_kim_and_neff(clip: Clip, rig: Rig, plants: list[Any], ground: Floats | None = None) -> Correction:
    return kim_neff.correct(clip, rig, plants, KimNeffParams(), ground=ground)


Way = Callable[..., Correction]
WAYS = pytest.mark.parametrize("way", [by_glardon, by_kim_and_neff])


@WAYS
def test_on_a_belt_plants_go_with_the_belt(way: Way) -> None:
    made = walk("treadmill")
    rig = rig_of(made)
    plants = plants_of(rig, made.contacts)
    ground = (np.arange(len(made.clip)) * made.clip.frame_time)[:, None] * np.array(made.belt)
    clip = artefacts.wander(made.clip, 0.02, slowest=1.0)
    after = apply(clip, way(clip, rig, plants, ground))
    assert strays(clip, rig, plants, ground).max() > 0.005
    assert strays(after, rig, plants, ground).max() < 1e-6


@WAYS
def test_a_clip_whose_feet_stand_is_left_as_it_is(way: Way) -> None:
    made = walk()
    rig = rig_of(made)
    found = way(made.clip, rig, plants_of(rig, made.contacts))
    for k, joint in enumerate(found.joints):
        turn = rotation.multiply(rotation.inverse(made.clip.rotation(joint)), found.rotations[:, k])
        assert rotation.angle(turn).max() < (1e-7 if way is by_glardon else 1e-6)
    none = way(made.clip, rig, [])
    assert none.joints == () and not none.root_shift.any()


@WAYS
def test_no_leg_becomes_straighter_than_captured_or_nearly_straight(way: Way) -> None:
    made = walk(duration=3.0)
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.15, slowest=1.0)  # so far that plants are out of reach
    after = apply(clip, way(clip, rig, plants_of(rig, made.contacts)))
    slack = 1e-6 if way is by_glardon else 1e-9  # steps against a closed form
    assert np.all(straightness(after, rig) <= np.maximum(straightness(clip, rig), 0.9995) + slack)
    assert np.any(straightness(after, rig) > 0.9994)


@WAYS
@pytest.mark.parametrize("fixed", ["knee", "ankle"])
def test_a_leg_that_the_file_cannot_turn_is_left_alone(way: Way, fixed: str) -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.03, slowest=1.0)
    rotates = np.ones(len(clip.skeleton), dtype=bool)
    rotates[getattr(rig.legs[0], fixed)] = False
    stiff = replace(clip, skeleton=replace(clip.skeleton, rotates=rotates))
    assert set(way(stiff, rig, plants_of(rig, made.contacts)).joints) == set(rig.legs[1].chain)

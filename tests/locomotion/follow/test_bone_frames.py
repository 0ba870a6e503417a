"""Walks whose joints have frames of another make: they look the same, and are blended as if they were the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from strides import stride

from footfix.enforce.params import EnforceParams
from footfix.formats.floor_paths import shape
from footfix.locomotion.follow.bone_frames import in_frames_of, in_frames_of_first
from footfix.locomotion.follow.params import FollowParams
from footfix.locomotion.follow.prepared_walk import Walk
from footfix.locomotion.follow.run import follow_path
from footfix.locomotion.follow.transitions import At
from footfix.locomotion.loop.root_motion import with_root
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import forward, places
from footfix.motion.vectors import unit


def spun(found: Walk, degrees: float) -> Walk:
    """The same figure, each thigh's frame turned about the thigh."""
    clip = found.clip
    for leg in found.rig.legs:
        bone = unit(clip.position(leg.knee)[0])
        turn = rotation.from_axis_angle(bone, np.array(np.radians(degrees)))
        back = rotation.multiply(rotation.inverse(turn), clip.rotation(leg.knee))
        clip = clip.with_joints({}, {leg.hip: rotation.multiply(clip.rotation(leg.hip), turn), leg.knee: back})
    return replace(found, clip=clip)


def thighs(clip: Clip, found: Walk) -> Floats:
    joints = [leg.hip for leg in found.rig.legs]
    return forward(clip, joints).rotations


def test_frames_of_another_make_are_led_over_and_the_figure_stays_where_it_is() -> None:
    one, other = stride("walk"), spun(stride("walk"), 120.0)
    assert np.allclose(places(other.clip), places(one.clip), atol=1e-12)
    led = in_frames_of(one, other)
    assert np.allclose(places(led.clip), places(one.clip), atol=1e-12)
    assert np.allclose(rotation.apart(thighs(led.clip, one), thighs(one.clip, one)), 0.0, atol=1e-6)


def test_frames_of_one_make_stay_as_they_are_whatever_the_walk() -> None:
    walks = (stride("walk"), stride("run"), stride("tiptoe"), spun(stride("walk"), 30.0), stride("run"))
    assert all(led is given for led, given in zip(in_frames_of_first(walks), walks, strict=True))


def test_who_walks_backwards_is_of_the_same_make() -> None:
    one = stride("walk")
    round_about = rotation.about_vertical(np.array(np.pi))
    position, turn = one.clip.position(0), one.clip.rotation(0)
    back = with_root(one.clip, 0, rotation.rotate(round_about, position), rotation.multiply(round_about, turn))
    other = replace(one, clip=back)
    assert in_frames_of(one, other) is other


def test_a_blend_does_not_depend_on_the_frames_of_thighs() -> None:
    path, one, other = shape("line:8"), stride("walk"), stride("run")
    assert path is not None
    found = [
        follow_path(path.points, [one, each], [At(), At(seconds=1.5)], FollowParams(), EnforceParams(), relative=True)
        for each in (other, spun(other, 150.0))
    ]
    a, b = (places(each.clip) for each in found)
    assert np.abs(a - b).max() < 0.05  # the mean turn of a thigh is not the same in both walks
    assert found[1].transitions[0].peak is not None
    assert found[1].transitions[0].peak < 1.2

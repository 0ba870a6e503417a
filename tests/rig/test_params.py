"""What the settings say about a rig stands in place of what would be found."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from rigmaker import hung, legs, nameless, scaled, together, with_names
from walker import make
from walker_plan import Gait

from footfix.errors import UsageError
from footfix.motion.clip import Clip
from footfix.rig.find import find_rig, find_rigs
from footfix.rig.params import LegParams, RigParams, SoleParams
from footfix.rig.units import infer_units

LEFT = LegParams(hip="LeftUpLeg", knee="LeftLeg", ankle="LeftFoot", toe="LeftToeBase")
RIGHT = LegParams(hip="RightUpLeg", knee="RightLeg", ankle="RightFoot", toe="RightToeBase")


@cache
def walk() -> Clip:
    return make(Gait(duration=2.0)).clip


def test_legs_given_in_full_are_taken_as_they_are() -> None:
    given = find_rig(walk(), RigParams(legs={"right": RIGHT, "left": LEFT}))
    assert legs(given) == legs(find_rig(walk()))
    assert [leg.name for leg in given.legs] == ["left", "right"]
    assert given.origins["leg.left.knee"] == "config"
    assert given.pelvis == 0


def test_an_ankle_is_enough() -> None:
    params = RigParams(legs={"left": LegParams(ankle="LeftFoot"), "right": LegParams(ankle="RightFoot")})
    assert legs(find_rig(walk(), params)) == legs(find_rig(walk()))
    arms = RigParams(legs={"left": LegParams(ankle="LeftHand"), "right": LegParams(ankle="RightHand")})
    names = walk().skeleton.names
    assert [names[leg.hip] for leg in find_rig(walk(), arms).legs] == ["LeftArm", "RightArm"]


def test_any_number_of_legs_with_names_of_their_own() -> None:
    params = RigParams(
        legs={
            "front_left": LegParams(hip="LeftArm", knee="LeftForeArm", ankle="LeftHand"),
            "front_right": LegParams(hip="RightArm", knee="RightForeArm", ankle="RightHand"),
            "hind_left": LEFT,
            "hind_right": RIGHT,
            "fifth": LegParams(hip="LeftUpLeg", knee="LeftLeg", ankle="LeftFoot", toe="none"),
        }
    )
    rig = find_rig(walk(), params)
    assert [leg.name for leg in rig.legs] == list(params.legs)
    assert [leg.side for leg in rig.legs] == ["left", "right", "left", "right", "left"]
    assert [sole.name for sole in rig.soles][:4] == [
        "front_left_heel",
        "front_left_toe",
        "front_right_heel",
        "front_right_toe",
    ]
    assert rig.legs[-1].toe is None
    assert infer_units(walk(), params).up == "y"


def test_one_leg_will_do() -> None:
    rig = find_rig(walk(), RigParams(legs={"wooden": LegParams(ankle="LeftFoot", side="left")}))
    assert [(leg.name, leg.side) for leg in rig.legs] == [("wooden", "left")]


def test_sides_of_two_given_legs_are_found() -> None:
    clip = nameless(walk())
    at = walk().skeleton.names.index
    params = RigParams(
        legs={
            f"leg{k}": LegParams(ankle=clip.skeleton.names[at(name)])
            for k, name in enumerate(["RightFoot", "LeftFoot"])
        }
    )
    rig = find_rig(clip, params)
    assert [(leg.name, leg.side) for leg in rig.legs] == [("leg1", "left"), ("leg0", "right")]


def test_a_toe_can_be_denied() -> None:
    params = RigParams(
        legs={"left": LegParams(ankle="LeftFoot", toe="none"), "right": LegParams(ankle="RightFoot", toe="none")}
    )
    rig = find_rig(walk(), params)
    assert [leg.toe for leg in rig.legs] == [None, None]
    assert {sole.joint for sole in rig.soles} == {leg.ankle for leg in rig.legs}


def test_names_may_leave_out_namespace_and_case() -> None:
    clip = with_names(walk(), [f"mixamorig:{name}" for name in walk().skeleton.names])
    for spelling in ("mixamorig:LeftFoot", "LeftFoot", "leftfoot"):
        rig = find_rig(clip, RigParams(legs={"left": LegParams(ankle=spelling), "right": LegParams(ankle="RightFoot")}))
        assert legs(rig) == legs(find_rig(walk()))


def test_soles() -> None:
    soles = {
        "left_heel": SoleParams(offset=(0.01, -0.02, -0.03)),
        "right_toe": SoleParams(joint="RightFoot", offset=(0.0, -0.08, 0.14)),
    }
    one, two = find_rig(walk()), find_rig(walk(), RigParams(soles=soles))
    assert two.soles[0].offset == (0.01, -0.02, -0.03)
    assert two.soles[0].joint == one.soles[0].joint
    assert two.soles[3].joint == two.legs[1].ankle
    assert two.soles[1:3] == one.soles[1:3]
    assert two.origins["sole.left_heel"] == "config" != two.origins["sole.left_toe"]


def test_floor_root_unit_and_up() -> None:
    movable = np.isin(walk().skeleton.names, ["Hips", "Spine"])
    clip = replace(walk(), skeleton=replace(walk().skeleton, translates=movable))
    rig = find_rig(clip, RigParams(floor=0.25, root="Spine"))
    assert rig.floor == 0.25
    assert clip.skeleton.names[rig.root] == "Spine"
    assert (rig.origins["floor"], rig.origins["root"]) == ("config", "config")
    found = infer_units(scaled(walk(), 4.0), RigParams(unit_m=0.25, up="-z"))
    assert (found.unit_m, found.up, found.notes) == (0.25, "-z", ())
    assert (found.origins["unit_m"], found.origins["up"]) == ("config", "config")


def test_the_figure_whose_legs_are_given_is_the_one_that_is_done() -> None:
    both = together(walk(), walk(), (2.0, 0.0, 0.0))
    params = RigParams(legs={"left": LegParams(ankle="B_LeftFoot"), "right": LegParams(ankle="B_RightFoot")})
    (rig,) = find_rigs(both, params)
    assert rig.root == len(walk().skeleton)


WRONG = {
    "no joint is called 'LeftFot'; did you mean 'LeftFoot'": RigParams(legs={"left": LegParams(ankle="LeftFot")}),
    "rig.legs.left names no ankle": RigParams(legs={"left": LegParams(hip="LeftUpLeg")}),
    "LeftUpLeg is not above RightFoot": RigParams(legs={"x": LegParams(hip="LeftUpLeg", ankle="RightFoot")}),
    "no thigh and shin found above Hips": RigParams(legs={"x": LegParams(ankle="Hips")}),
    "side must be left or right": RigParams(legs={"x": LegParams(ankle="LeftFoot", side="port")}),
    "rig.root: no joint is called": RigParams(root="Pelvis"),
    "Spine has no position channels to move it by; Hips": RigParams(root="Spine"),
    "rig.soles.left_hoof is no sole point": RigParams(soles={"left_hoof": SoleParams()}),
    "rig.soles.left_toe.joint: no joint": RigParams(soles={"left_toe": SoleParams(joint="Nowhere")}),
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_not_there_is_said(text: str) -> None:
    with pytest.raises(UsageError, match=text):
        find_rig(walk(), WRONG[text])


def test_a_name_that_several_joints_have_is_said() -> None:
    clip = hung(walk(), "Hips", [("LeftFoot", (0.0, 0.1, 0.0))])
    with pytest.raises(UsageError, match="2 joints are called 'LeftFoot'"):
        find_rig(clip, RigParams(legs={"left": LEFT}))


def test_an_axis_that_is_none_is_said() -> None:
    with pytest.raises(UsageError, match=r"rig\.up must be one of"):
        infer_units(walk(), RigParams(up="w"))


def test_given_legs_may_be_longer_chains() -> None:
    clip = walk()
    params = RigParams(legs={"left": LegParams(hip="Hips", knee="LeftLeg", ankle="LeftFoot")})
    rig = find_rig(clip, params)
    assert len(rig.legs[0].chain) == 4
    assert rig.leg_length == pytest.approx(float(np.linalg.norm(clip.skeleton.offsets[1:4], axis=1).sum()))

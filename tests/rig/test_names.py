"""What names say: side and part of a body, in the schemes that are about."""

from __future__ import annotations

import pytest

from footfix.rig.names import bare, read

SAID = """
LeftUpLeg left thigh|LeftLeg left leg|LeftFoot left ankle|LeftToeBase left toe|lThigh left thigh|rShin right knee
lfemur left thigh|rtibia right knee|ltoes left toe|LHipJoint left |lButtock left |mixamorig1:RightToeBase right toe
Bip01_L_Thigh left thigh|Bip01 R Calf right knee|Bip01 L Foot left ankle|Bip01 L Toe0 left toe|thigh_l left thigh
calf_r right knee|foot_l left ankle|ball_r right toe|Character1_LeftLeg left leg|CC_Base_R_Foot right ankle
LeftHip left thigh|LeftKnee left knee|RightAnkle right ankle|J_Bip_L_UpperLeg left thigh|J_Bip_R_ToeBase right toe
left_hip left thigh|right_knee right knee|left_ankle left ankle|HIP_LEFT left thigh|KNEE_RIGHT right knee
UpLeg_L left thigh|LoLeg_R right knee|Toe_L left toe|upperleg01.L left thigh|lowerleg02.R right knee|toe1-1.L left toe
shin.L left knee|DEF-thigh.R right thigh|b_l_upleg left thigh|L_lowLeg_jnt left knee|RightLowLeg right knee
LeftForeFoot left toe|heel.02.L left heel|左足 left leg|右ひざ right knee|左足首 left ankle|右つま先 right toe
左腕 left arm|LeftForeArm left arm|rShldr right arm|LeftHandIndex1 left arm|clavicle_r right arm|LeftEye left other
Bip01 Tail  other|Head  other|Spine1  other|Hips  |hip  |pelvis  |bone_123  |joint07  |Armature_root  arm
"""
HELPERS = (
    "calf_twist_01_l",
    "ik_foot_r",
    "LeftLegTwist",
    "RightToe_End",
    "L_Talus_RIGMESH",
    "LeftFootTarget",
    "左足ＩＫ",
)
NO_HELPERS = ("lThighBend", "LeftFoot", "Legend", "右足", "Bip01 L Foot")


@pytest.mark.parametrize("said", [part for line in SAID.strip().splitlines() for part in line.split("|")])
def test_readings(said: str) -> None:
    name, side, part = said.rsplit(" ", 2)
    reading = read(name)
    assert (reading.side, reading.part) == (side, part)


def test_helpers() -> None:
    assert [name for name in HELPERS if not read(name).helper] == []
    assert [name for name in NO_HELPERS if read(name).helper] == []


def test_a_namespace_is_no_part_of_a_name() -> None:
    assert bare("mixamorig:Hips") == bare("char|mixamorig:Hips") == bare(" Hips ") == "Hips"

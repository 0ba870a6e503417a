"""The rig of walkers, of which everything is known: whatever names, order, unit, axes and extra joints they have."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from exports import SCHEMES, renamed, with_twists, without_toes
from hypothesis import given, settings
from hypothesis import strategies as st
from rigmaker import (
    LEGS,
    called,
    hung,
    legs,
    mirrored,
    moved,
    nameless,
    scaled,
    shuffled,
    together,
    with_names,
    with_up,
    without,
)
from walker import Walk, make
from walker_plan import STYLES, Gait

from footfix.errors import NoLegsError
from footfix.motion import rotation
from footfix.motion.clip import Clip, Skeleton
from footfix.rig.find import find_rig, find_rigs
from footfix.rig.soles import SoleEstimate, alike
from footfix.rig.units import AXES, infer_units

ON_ONE_LEVEL = sorted(set(STYLES) - {"stairs", "stairs-down"})


@cache
def walk(name: str = "walk", leg: float = 0.88) -> Walk:
    return make(Gait(name=name, duration=3.0, leg=leg))  # type: ignore[arg-type]


def known_legs(clip: Clip) -> set[tuple[str, int, int, int, int | None]]:
    at = clip.skeleton.names.index
    return {
        (side.lower(), at(f"{side}UpLeg"), at(f"{side}Leg"), at(f"{side}Foot"), at(f"{side}ToeBase"))
        for side in ("Left", "Right")
    }


@pytest.mark.parametrize("scheme", [*SCHEMES, *LEGS])
def test_names_of_every_scheme(scheme: str) -> None:
    clip = walk().clip
    other = renamed(clip, scheme) if scheme in SCHEMES else called(clip, scheme)
    rig = find_rig(other)
    assert legs(rig) == known_legs(clip)
    assert rig.root == rig.pelvis == 0
    assert rig.origins["legs"] == "names and geometry"
    assert rig.origins["sides"] == "names"


@pytest.mark.parametrize("name", STYLES)
def test_names_that_say_nothing(name: str) -> None:
    clip = walk(name).clip
    other, order = shuffled(nameless(clip), seed=5)
    rig = find_rig(other)
    assert legs(rig, order) == known_legs(clip)
    assert rig.origins["legs"] == rig.origins["sides"] == "geometry"


@pytest.mark.parametrize("seed", range(5))
def test_the_order_of_siblings_does_not_matter(seed: int) -> None:
    clip = walk("turn").clip
    other, order = shuffled(clip, seed)
    one, two = find_rig(clip), find_rig(other)
    assert legs(two, order) == legs(one)
    assert two.floor == pytest.approx(one.floor)
    assert np.allclose([sole.offset for sole in two.soles], [sole.offset for sole in one.soles])


@pytest.mark.parametrize("unit_m", [1.0, 0.01, 0.001, 0.0254, 0.1, 1 / 17.7])
def test_units(unit_m: float) -> None:
    found = infer_units(scaled(walk().clip, 1.0 / unit_m))
    assert found.unit_m == pytest.approx(unit_m)
    assert found.notes == ()


@pytest.mark.parametrize("leg", [0.42, 0.6, 1.25])
@pytest.mark.parametrize("unit_m", [1.0, 0.01, 0.001])
def test_children_and_giants(unit_m: float, leg: float) -> None:
    clip = walk(leg=leg).clip
    assert infer_units(scaled(clip, 1.0 / unit_m)).unit_m == pytest.approx(unit_m)
    assert find_rig(clip).leg_length == pytest.approx(leg)


def test_a_unit_that_might_be_another_is_said() -> None:
    found = infer_units(scaled(walk(leg=1.02).clip, 1.0 / 0.0254))  # a tall man in inches, or a child in centimetres
    assert [note.id for note in found.notes] == ["unit-ambiguous"]


def test_a_unit_of_no_name_is_scaled_by_the_leg_and_said() -> None:
    found = infer_units(scaled(walk().clip, 4.0))
    assert found.unit_m * 4.0 * 0.88 == pytest.approx(0.9)
    assert [note.id for note in found.notes] == ["unit-unknown"]


@pytest.mark.parametrize("up", AXES)
@pytest.mark.parametrize("name", ["walk", "run", "turn", "jump", "stand", "stairs", "treadmill"])
def test_up_axes(name: str, up: str) -> None:
    clip = with_up(walk(name).clip, up)
    found = infer_units(nameless(clip))
    assert found.up == up
    assert found.notes == ()


def test_a_rig_is_the_same_wherever_the_clip_is_on_the_floor() -> None:
    clip = walk("turn").clip
    one, two = find_rig(clip), find_rig(moved(clip, 2.1, (5.0, 0.0, -3.0)))
    assert legs(one) == legs(two)
    assert two.floor == pytest.approx(one.floor, abs=1e-9)
    for a, b in zip(one.soles, two.soles, strict=True):
        assert np.allclose(a.offset, b.offset, atol=1e-9)


@pytest.mark.parametrize("factor", [0.7, 1.4])
def test_a_scaled_clip_has_the_scaled_rig(factor: float) -> None:
    clip = walk("run").clip
    one, two = find_rig(clip), find_rig(scaled(clip, factor))
    assert two.leg_length == pytest.approx(factor * one.leg_length)
    assert two.floor == pytest.approx(factor * one.floor)
    for a, b in zip(one.soles, two.soles, strict=True):
        assert np.allclose(factor * np.array(a.offset), b.offset, atol=1e-9)


@pytest.mark.parametrize("name", ["walk", "turn", "sideways"])
def test_a_mirrored_clip_has_the_mirrored_rig(name: str) -> None:
    clip = nameless(walk(name).clip)
    one, two = find_rig(clip), find_rig(mirrored(clip))
    swapped = {({"left": "right", "right": "left"}[name], *joints) for name, *joints in legs(one)}
    assert legs(two) == swapped
    for sole in one.soles:
        other = next(each for each in two.soles if each.joint == sole.joint and each.part == sole.part)
        assert np.allclose(np.array(other.offset) * [-1.0, 1.0, 1.0], sole.offset, atol=1e-9)


@pytest.mark.parametrize("name", ON_ONE_LEVEL)
def test_soles_and_floor_are_where_the_walker_has_them(name: str) -> None:
    made = walk(name)
    clip, names = made.clip, made.clip.skeleton.names
    rig = find_rig(clip)
    assert rig.floor == pytest.approx(0.0, abs=0.005)
    assert [note.id for note in rig.notes] == []
    for sole, (joint, offset) in zip(rig.soles, made.soles, strict=True):
        assert names[sole.joint] == joint
        # one who never lies a heel down does not show how it would lie
        assert np.linalg.norm(np.array(sole.offset) - offset) < (0.03 if name in ("tiptoe", "sprint") else 0.015)


@pytest.mark.parametrize("times", [2, 3, 4])
def test_frames_that_stand_several_times_change_nothing(times: int) -> None:
    clip = walk().clip.frames(slice(None, None, 4))
    clip = replace(clip, frame_time=4.0 * clip.frame_time)
    long = replace(clip.frames(np.repeat(np.arange(len(clip)), times)), frame_time=clip.frame_time / times)
    one, other = find_rig(clip), find_rig(long)
    assert one.floor == pytest.approx(other.floor, abs=1e-9)
    for a, b in zip(one.soles, other.soles, strict=True):
        assert a.offset == pytest.approx(b.offset, abs=1e-9)


@pytest.mark.parametrize("name", ["stairs", "stairs-down"])
def test_stairs_stand_on_the_lowest_floor_and_say_so(name: str) -> None:
    made = walk(name)
    rig = find_rig(made.clip)
    lowest = min(float(track[effector_start, 1]) for track, effector_start in _planted(made))
    assert rig.floor == pytest.approx(lowest, abs=0.01)
    assert "floor-ambiguous" in [note.id for note in rig.notes]


def _planted(made: Walk) -> list[tuple[np.ndarray, int]]:
    return [
        (track, contact.start)
        for track, effector in zip(made.tracks, made.contacts.effectors, strict=True)
        for contact in effector.contacts
        if contact.end - contact.start > 20
    ]


@pytest.mark.parametrize("ends", [True, False])
def test_feet_without_toe_joints(ends: bool) -> None:
    made = walk()
    clip = without_toes(made.clip, ends=ends)
    rig = find_rig(nameless(clip))
    assert [leg.toe for leg in rig.legs] == [None, None]
    for sole, (_, offset), part in zip(rig.soles, made.soles, ("heel", "toe") * 2, strict=True):
        assert sole.part == part
        assert sole.joint in (leg.ankle for leg in rig.legs)
        if part == "heel":
            assert np.linalg.norm(np.array(sole.offset) - offset) < 0.03
        else:
            assert sole.offset[2] == pytest.approx(0.15 * 0.88, abs=0.02)
            assert sole.offset[1] == pytest.approx(-0.095 * 0.88, abs=0.02)
    assert [note.id for note in rig.notes] == ([] if ends else ["feet-without-toes"])


@pytest.mark.parametrize("name", ["{side}FootEnd", "{side}Foot_End", "{side} SoleEstimate Nub", "{side}ToeEnd_01"])
def test_a_joint_in_place_of_an_end_site_is_no_toe(name: str) -> None:
    clip = without_toes(walk().clip, ends=False)
    for side in ("Left", "Right"):
        clip = hung(clip, f"{side}Foot", [(name.format(side=side), (0.0, -0.07, 0.22))])
    rig = find_rig(clip)
    assert [leg.toe for leg in rig.legs] == [None, None]
    assert rig.notes == ()


def test_twist_bones_are_in_the_chain_but_are_no_knees() -> None:
    clip = with_twists(walk().clip)
    for other in (clip, nameless(clip)):
        rig = find_rig(other)
        assert legs(rig) == known_legs(clip)
        assert [len(leg.chain) for leg in rig.legs] == [5, 5]
        assert all((leg.chain[0], leg.chain[-1]) == (leg.hip, leg.ankle) for leg in rig.legs)


Triple = tuple[float, float, float]


def _both(name: str, first: Triple, step: Triple, count: int) -> Iterator[tuple[str, list[tuple[str, Triple]]]]:
    """The same chain left and right: (side, chain) twice."""
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        flip = np.array([sign, 1.0, 1.0])
        chain = [(f"{side}{name}{k}", tuple(flip * (first if k == 0 else step))) for k in range(count)]
        yield side, chain


EXTRAS = {
    "skirt": ("Hips", "Skirt", (0.12, -0.02, 0.0), (0.02, -0.17, 0.0), 4),
    "coat": ("Hips", "Coat", (0.12, -0.02, -0.05), (0.02, -0.28, 0.0), 4),
    "pigtails": ("Head", "Hair", (0.08, 0.0, -0.05), (0.0, -0.25, -0.05), 5),
    "thigh helpers": ("{side}UpLeg", "Bulge", (0.0, -0.2, 0.0), (0.0, -0.1, 0.0), 1),
    "calf helpers": ("{side}Leg", "Calf", (0.0, -0.2, -0.03), (0.0, 0.0, 0.0), 1),
    "heel joints": ("{side}Foot", "Heel", (0.0, -0.08, -0.05), (0.0, 0.0, 0.0), 1),
    "fingers": ("{side}Hand", "Finger", (0.09, 0.0, 0.0), (0.03, 0.0, 0.0), 4),
    "toe fingers": ("{side}ToeBase", "Digit", (0.02, -0.01, 0.03), (0.0, 0.0, 0.03), 3),
    "ears": ("Head", "Ear", (0.08, 0.1, 0.0), (0.1, 0.1, 0.0), 3),
}


@pytest.mark.parametrize("named", [True, False])
@pytest.mark.parametrize("what", EXTRAS)
def test_what_hangs_from_a_body_is_no_leg(what: str, named: bool) -> None:
    clip = walk().clip
    parent, *chain = EXTRAS[what]
    larger = clip
    for side, joints in _both(*chain):
        larger = hung(larger, parent.format(side=side), joints)
    assert legs(find_rig(larger if named else nameless(larger))) == known_legs(clip)


@pytest.mark.parametrize("named", [True, False])
def test_nor_is_a_tail_or_a_sword(named: bool) -> None:
    clip = walk().clip
    larger = hung(clip, "Hips", [(f"Tail{k}", (0.0, 0.0, -0.1) if k == 0 else (0.0, -0.05, -0.25)) for k in range(5)])
    larger = hung(larger, "RightHand", [("Sword", (0.0, 0.0, 0.1)), ("SwordTip", (0.0, 0.0, 1.2))])
    assert legs(find_rig(larger if named else nameless(larger))) == known_legs(clip)


def _headed(clip: Clip, positions: np.ndarray, *, moves: bool) -> Clip:
    """The clip with a joint above its root; `positions` (F, 3) of it, the old root keeping its place in the world."""
    skeleton = clip.skeleton
    larger = Skeleton(
        names=("Reference", *skeleton.names),
        parents=np.concatenate([[-1], skeleton.parents + 1]),
        offsets=np.concatenate([np.zeros((1, 3)), skeleton.offsets]),
        end_parents=skeleton.end_parents + 1,
        end_offsets=skeleton.end_offsets,
        translates=np.array([True, moves, *([False] * (len(skeleton) - 1))]),
    )
    places = np.concatenate([positions[:, None], clip.positions], axis=1)
    places[:, 1] -= positions
    turns = np.concatenate([rotation.identity((len(clip), 1)), clip.rotations], axis=1)
    return Clip(larger, places, turns, clip.frame_time)


def test_the_root_is_what_carries_the_figure() -> None:
    clip = walk().clip
    still = np.zeros((len(clip), 3))
    assert find_rig(_headed(clip, still, moves=True)).root == 1  # a reference that never moves
    assert find_rig(_headed(clip, 0.9 * clip.positions[:, 0], moves=True)).root == 1  # both move: the nearer one
    assert find_rig(_headed(clip, clip.positions[:, 0], moves=False)).root == 0  # only the upper one can
    assert find_rig(_headed(clip, clip.positions[:, 0], moves=True)).root == 0  # only the upper one does


def test_a_figure_that_cannot_be_moved_says_so() -> None:
    clip = walk().clip
    fixed = replace(clip, skeleton=replace(clip.skeleton, translates=np.zeros(len(clip.skeleton), bool)))
    rig = find_rig(fixed)
    assert rig.root == 0
    assert "root-fixed" in [note.id for note in rig.notes]


@pytest.mark.parametrize("named", [True, False])
def test_ik_bones_beside_the_pelvis(named: bool) -> None:
    clip = walk().clip
    on_floor = clip.positions[:, 0] * [1.0, 0.0, 1.0]
    larger = _headed(clip, on_floor, moves=True)
    for part, place in (("foot", (0.1, 0.1, 0.0)), ("hand", (0.6, 1.4, 0.0))):
        larger = hung(larger, "Reference", [(f"ik_{part}_root", (0.0, 0.0, 0.0)), (f"ik_{part}_l", place)])
        larger = hung(larger, f"ik_{part}_root", [(f"ik_{part}_r", (-place[0], *place[1:]))])
    rig = find_rig(larger if named else nameless(larger))
    assert {leg.ankle for leg in rig.legs} == {1 + leg[3] for leg in known_legs(clip)}
    assert rig.root == 1


@pytest.mark.parametrize("named", [True, False])
def test_a_leg_that_is_there_twice_is_taken_with_its_foot(named: bool) -> None:
    clip = walk().clip
    larger = clip
    for side in ("Left", "Right"):
        own = [clip.skeleton.names.index(f"{side}{part}") for part in ("UpLeg", "Leg", "Foot")]
        chain = [(f"{clip.skeleton.names[j]}D", tuple(clip.skeleton.offsets[j].tolist())) for j in own]
        larger = hung(larger, "Hips", chain)
        turns = larger.rotations.copy()
        turns[:, -3:] = clip.rotations[:, own]
        larger = Clip(larger.skeleton, larger.positions, turns, larger.frame_time)
    assert legs(find_rig(larger if named else nameless(larger))) == known_legs(clip)


def test_each_figure_of_a_file_has_its_rig() -> None:
    clip = walk().clip
    both = together(clip, walk("turn").clip.frames(slice(0, len(clip))), (2.0, 0.0, 0.0))
    rigs = find_rigs(both)
    assert [rig.root for rig in rigs] == [0, len(clip.skeleton)]
    assert legs(rigs[0]) == known_legs(clip)
    assert find_rig(both).root == 0


@pytest.mark.parametrize("named", [True, False])
def test_two_figures_below_one_root_have_a_rig_each(named: bool) -> None:
    both = together(walk().clip, walk("turn").clip, (2.0, 0.0, 0.0))
    still = np.zeros((len(both), 3))
    one_root = _headed(both, still, moves=True)
    parents = one_root.skeleton.parents.copy()
    parents[1 + len(walk().clip.skeleton)] = 0
    translates = parents <= 0
    one_root = replace(one_root, skeleton=replace(one_root.skeleton, parents=parents, translates=translates))
    rigs = find_rigs(one_root if named else nameless(one_root))
    assert [rig.root for rig in rigs] == [1, 1 + len(walk().clip.skeleton)]
    assert {leg.ankle - 1 for leg in rigs[0].legs} == {leg[3] for leg in known_legs(walk().clip)}


@pytest.mark.parametrize("named", [True, False])
@pytest.mark.parametrize("gone", [("LeftUpLeg", "RightUpLeg"), ("LeftUpLeg",), ("LeftLeg", "RightLeg")])
def test_no_legs(gone: tuple[str, ...], named: bool) -> None:
    clip = without(walk().clip, *gone)
    if not named and gone[0] == "LeftUpLeg" and len(gone) == 2:
        pytest.skip("arms alone, with names that say nothing, could be legs")
    for function in (find_rig, infer_units):
        with pytest.raises(NoLegsError, match="no legs"):
            function(clip if named else nameless(clip))


@pytest.mark.parametrize("frames", [0, 1, 2, 5])
def test_short_clips_have_rigs_too(frames: int) -> None:
    clip = walk().clip.frames(slice(0, frames))
    assert legs(find_rig(clip)) == known_legs(clip)
    assert infer_units(clip).up == "y"


def test_holes_and_spikes_do_not_matter() -> None:
    clip = walk().clip
    positions, turns = clip.positions.copy(), clip.rotations.copy()
    positions[7, 0] = np.nan
    positions[30, 0] = 1e30
    turns[50] = np.nan
    broken = Clip(clip.skeleton, positions, turns, clip.frame_time)
    one, two = find_rig(clip), find_rig(broken)
    assert legs(one) == legs(two)
    assert two.floor == pytest.approx(one.floor, abs=0.003)


def test_a_file_of_zeros_on_every_joint_shows_its_rest_pose() -> None:
    clip = walk().clip
    zeros = Clip(clip.skeleton, np.zeros((3, len(clip.skeleton), 3)), clip.rotations[:3], clip.frame_time)
    assert legs(find_rig(zeros)) == known_legs(clip)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_any_tree_of_joints_has_a_rig_or_no_legs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    joints, frames, ends = rng.integers(1, 30), rng.integers(0, 30), rng.integers(0, 10)
    offsets = rng.normal(size=(joints, 3)) * rng.choice([0.0, 1e-3, 1.0, 100.0], size=(joints, 1))
    skeleton = Skeleton(
        names=tuple(rng.choice(["a", "LeftFoot", "RightFoot", "leg_l", "Hip", ""]) for _ in range(joints)),
        parents=np.array([-1, *(rng.integers(max(-1, joint - 6), joint) for joint in range(1, joints))]),
        offsets=offsets,
        end_parents=rng.integers(0, joints, ends),
        end_offsets=rng.normal(size=(ends, 3)),
    )
    positions = np.tile(offsets, (frames, 1, 1))
    positions[rng.random(positions.shape) < 0.02] = rng.choice([np.nan, np.inf, 1e30])
    turns = rotation.normalize(rng.normal(size=(frames, joints, 4)))
    _rig_or_no_legs(Clip(skeleton, positions, turns, float(rng.choice([1e-4, 1 / 30, 10.0]))))


@settings(max_examples=16, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["tumble", "holes", "frozen", "no turns", "leaps", "short bones"]))
def test_damaged_motion_has_a_rig_or_no_legs(seed: int, damage: str) -> None:
    rng, clip = np.random.default_rng(seed), walk("turn").clip
    positions, turns = clip.positions.copy(), clip.rotations.copy()
    if damage == "tumble":
        turns = rotation.normalize(rng.normal(size=turns.shape))
    elif damage == "holes":
        turns[rng.random(turns.shape) < 0.02] = np.nan
    elif damage == "frozen":
        positions[:], turns[:] = positions[:1], turns[:1]
    elif damage == "no turns":
        turns = rotation.identity(turns.shape[:-1])
    elif damage == "leaps":
        positions[:, 0] += 30.0 * rng.normal(size=positions[:, 0].shape)
    else:
        positions[:, rng.integers(1, positions.shape[1], 3)] *= rng.choice([0.0, 1e-9, 0.5])
    _rig_or_no_legs(Clip(clip.skeleton, positions, turns, clip.frame_time))


def _rig_or_no_legs(clip: Clip) -> None:
    try:
        rigs = (infer_units(clip), find_rigs(clip))[1]
    except NoLegsError:
        return
    for rig in rigs:
        assert np.isfinite([rig.floor, rig.leg_length, *(x for sole in rig.soles for x in sole.offset)]).all()
        assert len(rig.soles) == 2 * len(rig.legs)


def test_duplicate_names_are_no_matter() -> None:
    clip = walk().clip
    names = ["LeftFoot" if name == "RightFoot" else name for name in clip.skeleton.names]
    assert legs(find_rig(with_names(clip, names))) == known_legs(clip)


def test_left_and_right_feet_are_alike() -> None:
    def foot(height: float, *guessed: str, ahead: float = 0.16) -> SoleEstimate:
        up, forward = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
        return SoleEstimate(up, forward, up, height, 0.04, 0.06, ahead, height - 0.04, 0.045, guessed)

    left, right, paw = foot(0.144), foot(0.109), foot(0.2, ahead=0.05)
    ends = ["", "", "front_"]
    made = alike([left, right, paw], ends)
    assert np.isclose(made[0].ankle_height, 0.1265) and made[0].ankle_height == made[1].ankle_height
    assert made[2].ankle_height == 0.2 and made[0].up is left.up
    sure, guess = alike([left, foot(0.095, "slope")], ["", ""])
    assert sure.ankle_height == guess.ankle_height == 0.144

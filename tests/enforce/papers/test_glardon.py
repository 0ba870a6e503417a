"""Glardon's enforcement: easing, targets, prioritised inverse kinematics."""

from __future__ import annotations

from dataclasses import replace

import artefacts
import numpy as np
import pytest
from footplants import near_plants, plants_of, strays
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce.correction import apply
from footfix.enforce.easing import eased, gamma, replanned
from footfix.enforce.papers.glardon import GlardonParams, correct
from footfix.enforce.papers.priorities import Chain, SolverParams, jacobians, leg_chain, posed, solve, turned
from footfix.enforce.papers.targets import TargetParams, targets
from footfix.enforce.two_bone_ik import CapturedLeg, captured_leg, flexion_for, two_bones
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import runs
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig

PARAMS = GlardonParams()
SOLVER = SolverParams()


def skated(gait: str = "walk", distance: float = 0.03, fps: float = 60.0) -> tuple[Clip, Rig, list]:  # type: ignore[type-arg]
    made = walk(gait, fps=fps)
    rig = rig_of(made)
    return artefacts.wander(made.clip, distance, slowest=1.0), rig, plants_of(rig, made.contacts)


def test_gamma_falls_from_one_to_zero_flat_at_both_ends() -> None:
    u = np.linspace(0.0, 1.0, 1001)
    values = gamma(u)
    assert values[0] == 1.0 and values[-1] == 0.0 and np.all(np.diff(values) <= 0.0)
    assert np.allclose(values, 2 * u**3 - 3 * u**2 + 1, atol=1e-15)
    assert abs(values[1] - 1.0) < 1e-5 and abs(values[-2]) < 1e-5
    assert np.allclose(values + values[::-1], 1.0)
    assert gamma(np.array([-3.0, 4.0])).tolist() == [1.0, 0.0]


def test_eases_are_glardons_equation_nine() -> None:
    frames, start, end, sigma = 200, 80, 120, 30
    values = np.tile([[0.03, 0.0, -0.02]], (frames, 1))
    values[start] += 0.01
    found = eased([(start, end)], values, sigma)
    t1, t2 = start, end - 1
    for t in range(frames):
        if t1 - sigma <= t < t1:
            expected = (1 - gamma(np.array((t - t1 + sigma) / sigma))) * values[t1]
        elif t1 <= t <= t2:
            expected = values[t]
        elif t2 < t <= t2 + sigma:
            expected = gamma(np.array((t - t2) / sigma)) * values[t2]
        else:
            expected = np.zeros(3)
        assert np.allclose(found[t], expected, atol=1e-15)
    assert not found[: start - sigma + 1].any() and not found[end - 1 + sigma :].any()


def test_time_reversed_eases_are_the_eases_reversed() -> None:
    frames = 240
    values = np.random.default_rng(0).normal(size=(frames, 3))
    spans = [(20, 60), (75, 100), (180, 200)]
    back = [(frames - b, frames - a) for a, b in reversed(spans)]
    assert np.allclose(eased(back, values[::-1], 25)[::-1], eased(spans, values, 25), atol=1e-12)


def test_close_contacts_are_led_over_and_never_add_up() -> None:
    frames, spans = 200, [(20, 80), (100, 180)]
    values = np.where(np.arange(frames) < 90, 0.05, 0.03)[:, None]
    found = eased(spans, values, 30)
    between = found[80:100, 0]
    assert between.max() <= 0.05 and between.min() >= 0.03 and np.all(np.diff(between) <= 0.0)
    # two sigma apart, each has its own ease and nothing is left in between
    apart = eased([(20, 60), (120, 180)], values, 30)
    assert not apart[89:91].any() and apart[88].any() and apart[91].any()


def test_a_plan_changed_in_mid_ease_goes_on_from_where_it_was_to_its_new_target() -> None:
    t = np.linspace(0.0, 1.0, 101)[:, None]
    free = np.concatenate([0.4 * t, 0.1 * np.sin(3.0 * t), 1.2 * t**2], axis=1)  # E_0' from t' to t_1'
    reached, target = np.array([0.05, 0.08, -0.1]), np.array([0.5, 0.0, 1.1])
    fall = gamma(t)
    new = free + (1.0 - fall) * (target - free[-1])  # the new motion with its own ease-in
    found = replanned(new, t[:, 0], reached - new[0])
    assert np.allclose(found[0], reached, atol=1e-15) and np.allclose(found[-1], target, atol=1e-15)
    # it leaves with the velocity of the new motion, and arrives with it
    assert np.allclose(np.diff(found, axis=0)[[0, -1]], np.diff(free, axis=0)[[0, -1]], atol=5e-4)
    # as printed it would stand on its target at once: a jump
    printed = free + (1.0 - fall) * (free[0] - reached) + fall * (target - free[0])
    assert np.allclose(printed[0], target) and np.linalg.norm(printed[0] - reached) > 0.5
    # frame by frame it is the same curve
    assert np.array_equal(replanned(new[40:41], t[40:41, 0], reached - new[0]), found[40:41])


@pytest.mark.parametrize("gait", ["walk", "turn", "stairs", "tiptoe", "backwards", "stand"])
def test_effectors_stay_on_their_targets(gait: str) -> None:
    clip, rig, plants = skated(gait)
    after = apply(clip, correct(clip, rig, plants, PARAMS))
    pose = rig.pose(clip)
    before, found = rig.held(pose), rig.held(rig.pose(after))
    wanted = targets(rig, rig.tracks(pose), before, plants, np.zeros((len(clip), 3)), TargetParams())
    assert strays(clip, rig, plants).max() > 0.008
    for plant, place in zip(plants, wanted, strict=True):
        assert np.abs(found[plant.effector][plant.frames] - place).max() < 1e-6
        assert np.linalg.norm(place - np.median(before[plant.effector][plant.frames], axis=0)) < 0.04


def test_beyond_the_eases_the_numbers_are_the_clips_own() -> None:
    clip, rig, plants = skated()
    clip = replace(clip, rotations=clip.rotations * np.where(np.arange(len(clip)) < 90, 1.0, -1.0)[:, None, None])
    params = replace(PARAMS, ease=0.1)
    found = correct(clip, rig, plants, params)
    assert not found.root_shift.any()
    assert set(found.joints) == {joint for leg in rig.legs for joint in leg.chain}
    for number, leg in enumerate(rig.legs):
        near = near_plants(plants, number, len(clip), 6)
        assert np.count_nonzero(~near) > 10
        for joint in leg.chain:
            new = found.rotations[:, found.joints.index(joint)]
            assert np.array_equal(new[~near], clip.rotation(joint)[~near])
            assert np.any(new[near] != clip.rotation(joint)[near])
            assert np.all(np.sum(new * clip.rotation(joint), axis=1) > 0.0)  # of q and -q the one beside the captured


@pytest.mark.parametrize("gait", ["walk", "run", "tiptoe"])
def test_corrected_motion_has_no_jump_at_the_edges(gait: str) -> None:
    clip, rig, plants = skated(gait, fps=120.0)
    found = correct(clip, rig, plants, PARAMS)
    for k, joint in enumerate(found.joints):
        turn = rotation.multiply(rotation.inverse(clip.rotation(joint)), found.rotations[:, k])
        added = np.degrees(rotation.to_rotation_vector(turn))
        steps = [np.linalg.norm(np.diff(added, order, axis=0), axis=1).max() for order in (1, 2)]
        assert steps[0] < 0.7 and steps[1] < 0.5  # [degrees in a frame, and its change]


def test_turned_and_shifted_clips_give_the_turned_result() -> None:
    clip, rig, plants = skated()
    there = correct(artefacts.turned(clip, 1.9, (3.0, -2.0)), rig, plants, PARAMS)
    here = correct(clip, rig, plants, PARAMS)
    assert here.joints == there.joints
    assert np.abs(here.rotations - there.rotations).max() < 1e-8


def test_a_child_and_a_giant_get_the_same_rotations() -> None:
    clip, rig, plants = skated()
    here = correct(clip, rig, plants, PARAMS)
    for size in (0.5, 20.0):
        soles = tuple(replace(s, offset=tuple(size * x for x in s.offset)) for s in rig.soles)
        larger = replace(rig, soles=soles, leg_length=size * rig.leg_length, floor=size * rig.floor)
        there = correct(artefacts.scaled(clip, size), larger, plants, PARAMS)
        assert np.abs(here.rotations - there.rotations).max() < 1e-7


def test_plants_on_the_floor_share_one_height_and_steps_keep_theirs() -> None:
    for gait, least in (("walk", 8), ("stairs", 1)):
        made = walk(gait)
        rig = rig_of(made)
        plants = plants_of(rig, made.contacts)
        pose = rig.pose(artefacts.shake(made.clip, 1.0, slowest=0.5))
        tracks, soles = rig.held(pose), rig.tracks(pose)
        places = targets(rig, soles, tracks, plants, np.zeros((len(made.clip), 3)), TargetParams())
        usual = [np.median(tracks[plant.effector][plant.frames, 1]) for plant in plants]
        on_floor = [
            abs(np.median(soles[plant.effector][plant.frames, 1]) - rig.floor) <= 0.067 * rig.leg_length
            for plant in plants
        ]
        assert sum(on_floor) >= least and all(on_floor) == (gait == "walk")
        for k, plant in enumerate(plants):
            same = [h for h, f, p in zip(usual, on_floor, plants, strict=True) if f and p.effector == plant.effector]
            assert abs(places[k][1] - (np.median(same) if on_floor[k] else usual[k])) < 1e-12


def test_a_place_asked_for_is_taken_and_the_other_end_gives_way() -> None:
    made = walk()
    rig = rig_of(made)
    plants = plants_of(rig, made.contacts)
    k = next(k for k, plant in enumerate(plants) if plant.name == "left_toe" and plant.start > 5)
    pose = rig.pose(made.clip)
    sole = np.median(rig.tracks(pose)[plants[k].effector][plants[k].frames], axis=0)
    asked = sole + [0.02, 0.0, 0.01]
    plants[k] = replace(plants[k], asked=tuple(asked))
    after = apply(made.clip, correct(made.clip, rig, plants, PARAMS))
    toe = rig.held(rig.pose(after))[plants[k].effector][plants[k].frames]
    before = np.median(rig.held(pose)[plants[k].effector][plants[k].frames], axis=0)
    assert np.abs(toe - before - [0.02, 0.0, 0.01]).max() < 1e-6
    assert strays(after, rig, plants).max() < 1e-6


def leg_of(clip: Clip, rig: Rig) -> tuple[Pose, CapturedLeg]:
    pose = rig.pose(clip)
    return pose, captured_leg(rig, pose, 0, rig.held(pose))


@pytest.mark.parametrize("amount", [0.01, 0.05])
def test_solver_and_closed_form_agree_on_a_plain_leg(amount: float) -> None:
    made = walk()
    rig = rig_of(made)
    pose, leg = leg_of(made.clip, rig)
    ankle = leg.ankle + amount * np.random.default_rng(5).uniform(-1, 1, leg.ankle.shape)
    line = ankle - leg.hip
    ankle = leg.hip + line * np.minimum(1.0, 0.995 * rig.leg_length / np.linalg.norm(line, axis=1))[:, None]
    turns = two_bones(leg, ankle)
    knee = leg.hip + rotation.rotate(turns.swing, leg.knee - leg.hip)
    chain = leg_chain(made.clip, pose, leg, (leg.heel, leg.toe, leg.ankle), np.arange(len(leg)))
    goals = [point + ankle - leg.ankle for point in (leg.heel, leg.toe, leg.ankle)]  # the foot is not turned
    found = posed(chain, turned(chain, solve(chain, goals, rig.leg_length, SOLVER)))
    assert np.abs(found.effectors[2] - ankle).max() < 1e-7
    assert np.abs(found.places[1] - knee).max() < 1e-5
    assert rotation.angle(rotation.multiply(rotation.inverse(leg.turn), found.turns[-1])).max() < 1e-6


def plain_chain(bones: int, bend: float) -> Chain:
    """One frame of a chain of equal bones in a plane, each bent against the last; it may bend about x only."""
    turns = [rotation.from_axis_angle(np.array([[1.0, 0.0, 0.0]]), np.array([(-1) ** k * bend])) for k in range(bones)]
    down = np.array([[0.0, -1.0 / bones, 0.0]])
    return Chain(
        np.zeros((1, 3)), rotation.identity((1,)), (down,) * bones,
        (np.zeros((1, 3)), np.array([[0.0, -0.05, 0.1]])), np.stack([*turns, rotation.identity((1,))], axis=1),
        np.tile([1.0, 0.0, 0.0], (bones + 1, 1, 1)), np.arange(bones + 1),
    )  # fmt: skip


def ends(chain: Chain, q: Floats | None = None) -> tuple[Floats, ...]:
    q = np.zeros((len(chain.base), len(chain.owner))) if q is None else q
    return posed(chain, turned(chain, q)).effectors


@pytest.mark.parametrize("bones", [2, 3, 4, 6])
def test_chains_of_any_length_meet_both_goals(bones: int) -> None:
    chain = plain_chain(bones, 0.5)
    goals = [end + np.array([[0.0, 0.05, 0.08]]) for end in ends(chain)]
    found = ends(chain, solve(chain, goals, 1.0, SOLVER))
    assert np.abs(np.array(found) - np.array(goals)).max() < 1e-7


def test_what_no_goal_needs_comes_back_to_the_captured_pose() -> None:
    chain = plain_chain(6, 0.4)
    start = np.random.default_rng(3).normal(scale=0.15, size=(1, 7))
    q = solve(chain, ends(chain), 1.0, replace(SOLVER, iterations=300), start)
    assert np.abs(start).max() > 0.2 and np.abs(q).max() < 1e-5


def test_the_first_goal_is_met_exactly_where_the_second_cannot_be() -> None:
    chain = plain_chain(2, 0.5)
    first, second = ends(chain)
    goals = [first + np.array([[0.0, 0.03, 0.02]]), second + np.array([[0.0, 0.9, 0.0]])]
    found = ends(chain, solve(chain, goals, 1.0, SOLVER))
    assert np.abs(found[0] - goals[0]).max() < 1e-7
    # and the second comes as near as its distance from the first allows
    reach = float(np.linalg.norm(second - first))
    assert abs(np.linalg.norm(goals[1] - found[1]) - (np.linalg.norm(goals[1] - goals[0]) - reach)) < 1e-5


def test_out_of_reach_the_solver_stays_calm() -> None:
    chain = plain_chain(3, 0.4)
    found = ends(chain, solve(chain, [np.array([[0.0, -1.5, 0.0]]), np.array([[0.0, -1.6, 0.1]])], 1.0, SOLVER))
    assert np.isfinite(found[0]).all() and np.linalg.norm(found[0]) > 0.97


def test_jacobians_are_their_finite_differences() -> None:
    made = walk()
    rig = rig_of(made)
    pose, leg = leg_of(made.clip, rig)
    chain = leg_chain(made.clip, pose, leg, (leg.heel, leg.toe, leg.ankle), np.arange(0, len(leg), 30))
    q = np.random.default_rng(1).normal(scale=0.4, size=(len(chain.base), len(chain.owner)))
    found = jacobians(chain, q, posed(chain, turned(chain, q)))
    h = 1e-6
    for k in range(q.shape[1]):
        push = h * np.eye(q.shape[1])[k]
        for jacobian, up, down in zip(found, ends(chain, q + push), ends(chain, q - push), strict=True):
            assert np.abs(jacobian[:, :, k] - (up - down) / (2 * h)).max() < 1e-8


def with_bone(clip: Clip, rig: Rig, bend: float) -> tuple[Clip, Rig]:
    """The same figure with one more joint half way down each thigh; it bends to and fro by `bend` [rad]."""
    skeleton = clip.skeleton
    for side in (0, 1):
        leg = rig.legs[side]
        at = leg.knee

        def later(joint: int, at: int = at) -> int:
            return joint + (joint >= at)

        moved = np.where(skeleton.parents >= at, skeleton.parents + 1, skeleton.parents)
        parents = np.insert(moved, at, leg.hip)
        parents[at + 1] = at
        offsets = np.insert(skeleton.offsets, at, 0.5 * skeleton.offsets[at], axis=0)
        offsets[at + 1] *= 0.5
        positions = np.insert(clip.positions, at, 0.5 * clip.positions[:, at], axis=1)
        positions[:, at + 1] *= 0.5
        angle = bend * np.sin(np.arange(len(clip)) / 9.0) ** 2
        turn = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), angle)
        rotations = np.insert(clip.rotations, at, turn, axis=1)
        ends_ = np.where(skeleton.end_parents >= at, skeleton.end_parents + 1, skeleton.end_parents)
        skeleton = replace(
            skeleton, names=(*skeleton.names[:at], "More", *skeleton.names[at:]), parents=parents, offsets=offsets,
            end_parents=ends_, translates=None, rotates=None,
        )  # fmt: skip
        clip = Clip(skeleton, positions, rotations, clip.frame_time)
        legs = []
        for other in rig.legs:
            hip, knee, ankle, toe = (later(j) for j in (other.hip, other.knee, other.ankle, other.toe or 0))
            chain = tuple(later(j) for j in other.chain)
            chain = (hip, at, *chain[1:]) if other is leg else chain
            legs.append(replace(other, hip=hip, knee=knee, ankle=ankle, toe=toe, chain=chain))
        soles = tuple(replace(sole, joint=later(sole.joint)) for sole in rig.soles)
        rig = replace(rig, legs=tuple(legs), soles=soles)
    return clip, rig


def test_twist_bones_ride_along() -> None:
    clip, rig, plants = skated()
    clip, rig = with_bone(clip, rig, 0.0)
    found = correct(clip, rig, plants, PARAMS)
    assert strays(apply(clip, found), rig, plants).max() < 1e-6
    assert not {leg.chain[1] for leg in rig.legs} & set(found.joints)


def test_legs_of_four_bones_bend_in_every_joint() -> None:
    clip, rig, plants = skated("stand")
    clip, rig = with_bone(clip, rig, 0.12)
    found = correct(clip, rig, plants, PARAMS)
    after = apply(clip, found)
    assert {leg.chain[1] for leg in rig.legs} <= set(found.joints)
    assert strays(clip, rig, plants).min() > 0.02 and strays(after, rig, plants).max() < 1e-5
    assert np.array_equal(after.positions, clip.positions)


def test_a_leg_without_a_toe_joint_stands_on_the_ball_of_its_sole() -> None:
    clip, rig, plants = skated()
    legs = tuple(replace(leg, toe=None) for leg in rig.legs)
    ankles = [leg.ankle for leg in rig.legs]
    soles = tuple(
        sole if sole.part == "heel" else replace(sole, joint=ankles[sole.leg], offset=(0.0, -0.08, 0.13))
        for sole in rig.soles
    )
    rig = replace(rig, legs=legs, soles=soles)
    heels = [plant for plant in plants if plant.part == "heel"]
    heels = [replace(plant, start=min(plant.start + 6, plant.end - 3)) for plant in heels]  # when it lies flat
    flat = [replace(plant, effector=plant.effector + 1, part="toe") for plant in heels]
    both = [replace(plant, id=k) for k, plant in enumerate([*heels, *flat])]
    assert strays(apply(clip, correct(clip, rig, both, PARAMS)), rig, both).max() < 1e-6


def test_overlapping_eases_of_heel_and_toe_leave_no_gap() -> None:
    clip, rig, plants = skated("run")
    found = correct(clip, rig, plants, PARAMS)
    for number in (0, 1):
        changed = np.any([
            np.any(found.rotations[:, found.joints.index(joint)] != clip.rotation(joint), axis=1)
            for joint in rig.legs[number].chain
        ], axis=0)  # fmt: skip
        for plant in plants:
            if plant.leg == number and plant.part == "toe":
                assert any(a <= plant.start and plant.end <= b for a, b in runs(changed))


def test_flexion_is_the_law_of_cosines() -> None:
    made = walk()
    _pose, leg = leg_of(made.clip, rig_of(made))
    assert np.abs(flexion_for(leg, leg.ankle) - leg.flexion).max() < 1e-6

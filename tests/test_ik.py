"""The closed-form leg and the prioritised solver."""

from __future__ import annotations

from dataclasses import replace

import artefacts
import numpy as np
import pytest
from walks import cleaned, rig_of, slides, walk

from footfix.enforce import ik
from footfix.enforce.foot import Foot, feet, posed
from footfix.enforce.priorities import Chain, leg_chain, solve
from footfix.enforce.run import EnforceParams
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import forward
from footfix.motion.vectors import dot, norm, unit
from footfix.rig.rig import Rig

E = tuple(np.eye(3))


def pushed(rig: Rig, clip: Clip, amount: float, seed: int) -> tuple:  # type: ignore[type-arg]
    """A leg, its pose, and ankle places off the captured ones but within reach."""
    pose = posed(clip, rig)
    foot = feet(rig, pose)[0]
    ankle = foot.ankle + amount * np.random.default_rng(seed).uniform(-1, 1, foot.ankle.shape)
    line = ankle - foot.hip
    length = norm(foot.knee - foot.hip) + norm(foot.ankle - foot.knee)
    return pose, foot, foot.hip + line * np.minimum(1.0, 0.995 * length / norm(line))[:, None]


def bent_to(foot: Foot, axis: Floats, hip: Floats, ankle: Floats) -> ik.LegTurns:
    """The leg held at `ankle` in every frame."""
    held = np.ones(len(foot), dtype=bool)
    hinge = ik.hinge(foot, axis)
    return ik.two_bones(foot, hinge, ik.flexion(hinge, hip, ankle, held), hip, ankle)


@pytest.mark.parametrize("amount", [0.02, 0.1, 0.25])
def test_two_bones_reach_any_place_and_keep_the_foot(amount: float) -> None:
    made = walk()
    rig = rig_of(made)
    clip = made.clip
    pose, foot, ankle = pushed(rig, clip, amount, 3)
    axis = ik.knee_axis(foot, pose.rotation(foot.leg.hip))
    turns = bent_to(foot, axis, foot.hip, ankle)
    rotations = clip.rotations.copy()
    for joint, q in ik.local_rotations(clip, pose, foot, turns, foot.turn).items():
        rotations[:, joint] = q
    after = forward(replace(clip, rotations=rotations))
    assert np.abs(after.position(foot.leg.ankle) - ankle).max() < 1e-9
    assert rotation.angle(
        rotation.multiply(after.rotation(foot.leg.ankle), rotation.inverse(foot.turn))
    ).max() < 1e-7  # fmt: skip
    others = [j for j in range(len(clip.skeleton)) if foot.leg.hip not in clip.skeleton.ancestors(j)]
    before = forward(clip)
    assert np.array_equal(after.positions[:, others], before.positions[:, others])


def test_the_knee_stays_in_its_plane() -> None:
    made = walk()
    rig = rig_of(made)
    pose, foot, _ = pushed(rig, made.clip, 0.0, 0)
    axis = ik.knee_axis(foot, pose.rotation(foot.leg.hip))
    nearer = foot.hip + 0.93 * (foot.ankle - foot.hip)  # along the captured line: the plane can't turn
    turns = bent_to(foot, axis, foot.hip, nearer)
    knee = foot.hip + rotation.rotate(turns.swing, foot.knee - foot.hip)
    normal = unit(np.cross(foot.knee - foot.hip, foot.ankle - foot.hip))
    bent = norm(np.cross(foot.knee - foot.hip, foot.ankle - foot.hip)) > 0.02
    assert np.abs(dot(knee - foot.hip, normal))[bent].max() < 0.004
    before = dot(np.cross(foot.knee - foot.hip, foot.ankle - foot.hip), normal)
    after = dot(np.cross(knee - foot.hip, nearer - foot.hip), normal)
    assert np.all(before[bent] * after[bent] > 0.0)


def test_a_knee_through_straight_does_not_flip() -> None:
    frames = 61
    bend = np.radians(np.linspace(-4.0, 4.0, frames))  # overstretched to bent
    side = np.tile([1.0, 0.0, 0.0], (frames, 1))
    made = walk()
    _pose, foot, _ = pushed(rig_of(made), made.clip, 0.0, 0)
    hip = np.tile([0.0, 1.0, 0.0], (frames, 1))
    thigh = np.tile([0.0, -0.45, 0.0], (frames, 1))
    shank = rotation.rotate(rotation.from_axis_angle(side, bend), np.tile([0.0, -0.43, 0.0], (frames, 1)))
    still = rotation.identity((frames,))
    foot = replace(
        foot, hip=hip, knee=hip + thigh, ankle=hip + thigh + shank, turn=still, heel=hip, ball=hip + [0.0, 0.0, 0.1]
    )
    axis = ik.knee_axis(foot, still)
    assert np.all(dot(axis, side) > 0.99)
    ankle = hip + [0.0, -0.86, 0.0]
    turns = bent_to(foot, axis, hip, ankle)
    flexion = bend + rotation.to_rotation_vector(turns.bend)[:, 0]
    assert flexion.min() > 0.2 and np.ptp(flexion) < 1e-6


@pytest.mark.parametrize("amount", [0.01, 0.05])
def test_solver_and_closed_form_agree_on_a_plain_leg(amount: float) -> None:
    made = walk()
    rig = rig_of(made)
    pose, foot, ankle = pushed(rig, made.clip, amount, 5)
    axis = ik.knee_axis(foot, pose.rotation(foot.leg.hip))
    turns = bent_to(foot, axis, foot.hip, ankle)
    knee = foot.hip + rotation.rotate(turns.swing, foot.knee - foot.hip)
    ball = ankle + rotation.rotate(foot.turn, foot.ball_in_foot)
    chain = leg_chain(made.clip, pose, foot, axis, np.ones(len(foot), dtype=bool))
    found = solve(chain, ankle, ball, 0.88)
    assert np.abs(found.first - ankle).max() < 1e-5 and np.abs(found.second - ball).max() < 1e-5
    turn = rotation.multiply(chain.base_turn, found.locals_[:, 0])
    assert np.abs(foot.hip + rotation.rotate(turn, chain.bones[0]) - knee).max() < 1e-4


def plain_chain(bones: int, bend: float, limits: tuple[float, ...] | None = None) -> Chain:
    """One frame of a chain of equal bones in a plane, each bent against the last; it may bend about x only."""
    turns = [rotation.from_axis_angle(np.array([[1.0, 0.0, 0.0]]), np.array([(-1) ** k * bend])) for k in range(bones)]
    down = np.array([[0.0, -1.0 / bones, 0.0]])
    ahead = np.array([[0.0, -0.05, 0.1]])
    free = tuple((np.array([1.0, 0.0, 0.0]),) for _ in range(bones + 1))
    return Chain(
        np.zeros((1, 3)), rotation.identity((1,)), (*[down] * bones, ahead),
        np.stack([*turns, rotation.identity((1,))], axis=1), free, (limits,) * (bones + 1),
    )  # fmt: skip


def ends(chain: Chain) -> tuple[Floats, Floats]:
    place, turn = chain.base, chain.base_turn
    places = []
    for k, bone in enumerate(chain.bones):
        turn = rotation.multiply(turn, chain.locals_[:, k])
        place = place + rotation.rotate(turn, bone)
        places.append(place)
    return places[-2], places[-1]


@pytest.mark.parametrize("bones", [2, 3, 4, 6])
def test_chains_of_any_length_meet_both_goals(bones: int) -> None:
    chain = plain_chain(bones, 0.5)
    first, second = ends(chain)
    goal = first + np.array([[0.0, 0.05, 0.08]])
    found = solve(chain, goal, second + np.array([[0.0, 0.05, 0.08]]), 1.0)
    assert np.abs(found.first - goal).max() < 1e-5
    assert np.abs(found.second - second - np.array([[0.0, 0.05, 0.08]])).max() < 1e-4


def test_the_ankle_comes_first_when_the_toe_cannot() -> None:
    chain = plain_chain(2, 0.5)
    first, second = ends(chain)
    found = solve(chain, first + np.array([[0.0, 0.03, 0.02]]), second + np.array([[0.0, 0.9, 0.0]]), 1.0)
    assert np.abs(found.first - first - np.array([[0.0, 0.03, 0.02]])).max() < 1e-4
    assert np.linalg.norm(found.second - second) > 0.02  # it came as far as it could


def test_out_of_reach_the_solver_stays_calm() -> None:
    chain = plain_chain(3, 0.4)
    _first, _second = ends(chain)
    found = solve(chain, np.array([[0.0, -1.5, 0.0]]), np.array([[0.0, -1.6, 0.1]]), 1.0)
    assert np.isfinite(found.locals_).all()
    assert np.linalg.norm(found.first) > 0.97


def test_joint_limits_hold() -> None:
    free, limited = plain_chain(3, 0.5), plain_chain(3, 0.5, limits=(0.1,))
    first, second = ends(free)
    goal, beyond = first + np.array([[0.0, 0.15, 0.1]]), second + np.array([[0.0, 0.15, 0.1]])
    assert np.abs(solve(free, goal, beyond, 1.0).first - goal).max() < 1e-4
    found = solve(limited, goal, beyond, 1.0)
    turned = rotation.angle(rotation.multiply(rotation.inverse(limited.locals_), found.locals_))
    assert turned.max() <= 0.1 + 1e-9
    assert np.linalg.norm(found.first - goal) < np.linalg.norm(first - goal)


def test_both_solvers_clean_alike() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.05, slowest=1.0)
    closed, _ = cleaned(clip, rig, made.contacts)
    solved, _ = cleaned(clip, rig, made.contacts, EnforceParams(solver="priorities"))
    assert max(slides(solved, rig, made.contacts)["toe"]) < 1.0
    joints = [joint for leg in rig.legs for joint in leg.chain]
    a, b = forward(closed, joints), forward(solved, joints)
    assert np.abs(a.positions - b.positions).max() < 1e-4


def test_the_priorities_of_a_clip_that_needs_nothing_are_no_trouble() -> None:
    made = walk("stand")
    rig = rig_of(made)
    clip, _ = cleaned(made.clip, rig, made.contacts)
    again, _ = cleaned(clip, rig, made.contacts, EnforceParams(solver="priorities"))
    assert np.array_equal(again.rotations, clip.rotations)


def with_twist(clip: Clip, rig: Rig) -> tuple[Clip, Rig]:
    """The same walk with a twist bone in each thigh, half way down, as game skeletons have."""
    skeleton = clip.skeleton
    for side in (0, 1):
        leg = rig.legs[side]
        names = (*skeleton.names[: leg.knee], "Twist", *skeleton.names[leg.knee :])
        moved = np.where(skeleton.parents >= leg.knee, skeleton.parents + 1, skeleton.parents)
        parents = np.insert(moved, leg.knee, leg.hip)
        parents[leg.knee + 1] = leg.knee
        half = 0.5 * skeleton.offsets[leg.knee]
        offsets = np.insert(skeleton.offsets, leg.knee, half, axis=0)
        offsets[leg.knee + 1] = half
        positions = np.insert(clip.positions, leg.knee, 0.5 * clip.positions[:, leg.knee], axis=1)
        positions[:, leg.knee + 1] *= 0.5
        rotations = np.insert(clip.rotations, leg.knee, [0.0, 0.0, 0.0, 1.0], axis=1)
        ends_ = np.where(skeleton.end_parents >= leg.knee, skeleton.end_parents + 1, skeleton.end_parents)
        skeleton = replace(
            skeleton, names=names, parents=parents, offsets=offsets, end_parents=ends_, translates=None, rotates=None
        )
        clip = Clip(skeleton, positions, rotations, clip.frame_time)
        at = leg.knee

        def later(joint: int, at: int = at) -> int:
            return joint + (joint >= at)

        legs = []
        for other in rig.legs:
            hip, knee, ankle, toe = (later(j) for j in (other.hip, other.knee, other.ankle, other.toe or 0))
            chain = tuple(later(j) for j in other.chain)
            chain = (hip, at, *chain[1:]) if other is leg else chain
            legs.append(replace(other, hip=hip, knee=knee, ankle=ankle, toe=toe, chain=chain))
        soles = tuple(replace(sole, joint=later(sole.joint)) for sole in rig.soles)
        rig = replace(rig, legs=tuple(legs), soles=soles)
    return clip, rig


@pytest.mark.parametrize("solver", ["closed", "priorities"])
def test_twist_bones_ride_along(solver: str) -> None:
    made = walk()
    clip, rig = with_twist(artefacts.wander(made.clip, 0.05, slowest=1.0), rig_of(made))
    assert slides(clip, rig, made.contacts)["toe"] != []
    after, _ = cleaned(clip, rig, made.contacts, EnforceParams(solver=solver))  # type: ignore[arg-type]
    slid = slides(after, rig, made.contacts)
    assert max(slid["toe"] + slid["heel"]) < 1.0
    for leg in rig.legs:
        assert np.array_equal(after.rotations[:, leg.chain[1]], clip.rotations[:, leg.chain[1]])

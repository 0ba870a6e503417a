"""Kim and Neff's enforcement: Hermite joins, mean swivel, the leg in closed form."""

from __future__ import annotations

from dataclasses import replace

import artefacts
import numpy as np
import pytest
from footplants import near_plants, plants_of, strays
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce.correction import apply
from footfix.enforce.papers.kim_neff import Join, KimNeffParams, _join, _joined, correct, joins, mean_swivel, spline
from footfix.enforce.two_bone_ik import CapturedLeg, captured_leg, local_rotations, two_bones
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import runs
from footfix.motion.kinematics import Pose, forward
from footfix.motion.vectors import dot, norm, unit
from footfix.rig.rig import Rig

PARAMS = KimNeffParams()


def skated(gait: str = "walk", distance: float = 0.03) -> tuple[Clip, Rig, list]:  # type: ignore[type-arg]
    made = walk(gait)
    rig = rig_of(made)
    return artefacts.wander(made.clip, distance, slowest=1.0), rig, plants_of(rig, made.contacts)


def leg_of(clip: Clip, rig: Rig) -> tuple[Pose, CapturedLeg]:
    pose = rig.pose(clip)
    return pose, captured_leg(rig, pose, 0, rig.held(pose))


@pytest.mark.parametrize("gait", ["walk", "turn", "tiptoe", "backwards", "stand"])
def test_effectors_stay_in_one_place(gait: str) -> None:
    clip, rig, plants = skated(gait)
    after = apply(clip, correct(clip, rig, plants, PARAMS))
    assert strays(clip, rig, plants).max() > 0.008
    assert strays(after, rig, plants).max() < 1e-6


def test_a_planted_foot_keeps_the_mean_direction_of_its_plant() -> None:
    made = walk("stand")
    rig = rig_of(made)
    plants = plants_of(rig, made.contacts)
    names = made.clip.skeleton.names
    spin = np.radians(6.0) * np.sin(np.arange(len(made.clip)) / 15.0)
    hips = [names.index(side + "UpLeg") for side in ("Left", "Right")]
    about_y = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), spin)
    clip = made.clip.with_joints({}, {hip: rotation.multiply(about_y, made.clip.rotation(hip)) for hip in hips})
    after = apply(clip, correct(clip, rig, plants, PARAMS))
    (_, before), (_, found) = leg_of(clip, rig), leg_of(after, rig)
    spans = runs(near_plants(plants, 0, len(clip), 0))
    spread = []
    for start, end in spans:
        ahead = [(each.toe - each.heel)[start:end] * [1.0, 0.0, 1.0] for each in (before, found)]
        heading = [np.arctan2(each[:, 0], each[:, 2]) for each in ahead]
        mean = ahead[0].mean(axis=0)
        assert np.abs(heading[1] - np.arctan2(mean[0], mean[2])).max() < np.radians(0.1)
        spread.append(np.ptp(heading[0]))
    assert max(spread) > np.radians(6.0)
    # the whole leg swivels: the foot hardly turns in the ankle for that
    ankle = rig.legs[0].ankle
    in_ankle = rotation.angle(rotation.multiply(rotation.inverse(clip.rotation(ankle)), after.rotation(ankle)))
    assert np.degrees(in_ankle.max()) < 2.0


def test_the_mean_of_directions_on_either_side_of_the_seam_is_between_them() -> None:
    made = walk("stand")
    _, leg = leg_of(artefacts.turned(made.clip, np.pi), rig_of(made))
    angle = np.pi + np.radians(10.0) * np.where(np.arange(len(leg)) % 2, 1.0, -1.0)
    ahead = 0.2 * np.stack([np.sin(angle), np.zeros(len(leg)), np.cos(angle)], axis=1)
    swivel = mean_swivel(replace(leg, toe=leg.heel + ahead), [(10, 50)], 5)
    assert np.allclose(np.abs(swivel[10:50]), np.radians(10.0))
    assert not swivel[:5].any() and not swivel[55:].any() and abs(swivel[5:10]).max() < np.radians(10.0)


def test_a_foot_that_stands_upright_has_no_heading_to_keep() -> None:
    made = walk("stand")
    _, leg = leg_of(made.clip, rig_of(made))
    random = np.random.default_rng(0).normal(size=(len(leg), 3))
    upright = 0.2 * np.array([0.0, -1.0, 0.0]) + 0.004 * random
    assert np.abs(mean_swivel(replace(leg, toe=leg.heel + upright), [(10, 50)], 5)).max() < np.radians(3.0)


@pytest.mark.parametrize(("away", "frames"), [(0.0, 0), (0.01, 5), (0.0152, 8), (0.5, 10)])  # [m]
def test_a_join_takes_as_many_frames_as_the_ankle_would_at_the_pace_of_the_plant(away: float, frames: int) -> None:
    """N_b: the distance of plant and free motion over the ankle's mean way from frame to frame, and at most so many."""
    _, leg = leg_of(walk("stand").clip, rig_of(walk("stand")))
    ankle = np.outer(0.002 * np.arange(len(leg)), [0.6, 0.0, 0.8])  # 2 mm a frame
    needed = np.zeros((len(leg), 3))
    needed[40:60, 1] = away
    found = _joined(replace(leg, ankle=ankle), "heel", [(40, 60)], needed, 10)
    assert np.flatnonzero(norm(found.shift)).tolist() == (list(range(40 - frames, 60 + frames)) if away else [])


def test_joins_are_kim_and_neffs_spline() -> None:
    t = np.arange(60)[:, None]
    track = t * np.array([[0.01, 0.004, 0.0]])
    needed = np.zeros((60, 3))
    needed[30:40] = [0.05, -0.02, 0.03]
    before, after = joins([(30, 40)], np.full(60, 6), 10)
    assert before.frames.tolist() == [29, 28, 27, 26, 25, 24] and (before.free, before.beyond) == (23, 22)
    assert after.frames.tolist() == [40, 41, 42, 43, 44, 45] and (after.free, after.beyond) == (46, 47)
    i = np.arange(6)
    assert np.allclose(before.weight, 1 - np.cos(0.5 * (i + 0.5) / 6 * np.pi))
    F_u, F_c, T = track[23], track[30] + needed[30], track[23] - track[22]
    size = np.linalg.norm(F_u - F_c) / np.linalg.norm(T)
    # ends and tangents, read off a join that is as fine as one likes
    h = 1e-5
    fine = Join(30, np.arange(4), np.array([0.0, h, 1.0 - h, 1.0]), 23, 22)
    at = spline(track, needed, fine)
    assert np.allclose(at[[0, 3]], [F_c, F_u], atol=1e-14)
    assert np.allclose((at[0] - at[1]) / h, 0.1 * size * T * [0.0, 1.0, 0.0], atol=1e-4)
    assert np.allclose((at[2] - at[3]) / h, 0.5 * size * T, atol=1e-4)


def test_a_join_takes_as_many_frames_as_the_gap_has_steps_of_the_ankle() -> None:
    clip, rig, plants = skated("tiptoe")
    one = [next(plant for plant in plants if plant.name == "left_toe" and plant.start > 30)]
    found = correct(clip, rig, one, replace(PARAMS, longest=0.25))
    changed = np.any(found.rotations != np.stack([clip.rotation(joint) for joint in found.joints], axis=1), axis=(1, 2))
    assert changed[one[0].frames].all()
    _, leg = leg_of(clip, rig)
    step = norm(np.diff(leg.ankle[one[0].frames], axis=0)).mean()
    _, moved = leg_of(apply(clip, found), rig)
    for edge, outside in ((one[0].start, slice(0, one[0].start)), (one[0].end - 1, slice(one[0].end, None))):
        count = min(np.linalg.norm((moved.toe - leg.toe)[edge]) / step, round(0.25 / clip.frame_time))
        # the swivel fades over the longest join, the place over its own
        off = norm((moved.ankle - leg.ankle)[outside]) > 0.004
        assert np.count_nonzero(off) <= count + 1


def test_where_the_clip_ends_before_the_free_motion_the_displacement_goes_on() -> None:
    clip, rig, plants = skated()
    first = next(plant for plant in plants if plant.name == "left_heel")
    clip = clip.frames(slice(first.start - 2, len(clip)))
    one = [replace(first, start=2, end=first.end - first.start + 2)]
    found = correct(clip, rig, one, PARAMS)
    _, before = leg_of(clip, rig)
    _, after = leg_of(apply(clip, found), rig)
    shift = after.heel - before.heel
    assert np.abs(shift[:2] - shift[2]).max() < 0.002 < np.abs(shift[2]).max()


def test_beyond_the_joins_the_numbers_are_the_clips_own() -> None:
    clip, rig, plants = skated()
    found = correct(clip, rig, plants, PARAMS)
    assert not found.root_shift.any()
    for number, leg in enumerate(rig.legs):
        near = near_plants(plants, number, len(clip), 6)
        assert np.count_nonzero(~near) > 10
        for joint in (leg.hip, leg.knee, leg.ankle):
            new = found.rotations[:, found.joints.index(joint)]
            assert np.array_equal(new[~near], clip.rotation(joint)[~near])


def test_turned_and_shifted_clips_give_the_turned_result() -> None:
    clip, rig, plants = skated()
    there = correct(artefacts.turned(clip, 1.9, (3.0, -2.0)), rig, plants, PARAMS)
    here = correct(clip, rig, plants, PARAMS)
    assert here.joints == there.joints and np.abs(here.rotations - there.rotations).max() < 1e-7


def pushed(leg: CapturedLeg, amount: float, seed: int) -> Floats:
    """Ankle places off the captured ones but within reach."""
    ankle = leg.ankle + amount * np.random.default_rng(seed).uniform(-1, 1, leg.ankle.shape)
    line = ankle - leg.hip
    length = norm(leg.knee - leg.hip) + norm(leg.ankle - leg.knee)
    return np.asarray(leg.hip + line * np.minimum(1.0, 0.995 * length / norm(line))[:, None])


@pytest.mark.parametrize("amount", [0.02, 0.1, 0.25])
def test_two_bones_reach_any_place_and_keep_the_foot(amount: float) -> None:
    made = walk()
    rig, clip = rig_of(made), made.clip
    pose, leg = leg_of(clip, rig)
    ankle = pushed(leg, amount, 3)
    swivel = np.linspace(-1.0, 1.0, len(leg))
    new = local_rotations(clip, pose, leg, two_bones(leg, ankle, swivel), leg.turn)
    before, after = forward(clip), forward(clip.with_joints({}, new))
    assert np.abs(after.position(leg.leg.ankle) - ankle).max() < 1e-9
    assert np.abs(after.rotation(leg.leg.ankle) - leg.turn).max() < 1e-9
    others = [j for j in range(len(clip.skeleton)) if leg.leg.hip not in clip.skeleton.ancestors(j)]
    assert np.array_equal(after.positions[:, others], before.positions[:, others])


def test_the_knee_stays_in_its_plane_and_leaves_it_by_the_swivel() -> None:
    made = walk()
    _, leg = leg_of(made.clip, rig_of(made))
    nearer = leg.hip + 0.93 * (leg.ankle - leg.hip)  # along the captured line: the plane can't turn
    line = unit(leg.hip - leg.ankle)
    bent = norm(np.cross(leg.knee - leg.hip, leg.ankle - leg.hip)) > 0.02

    def out_of_line(swivel: float) -> Floats:
        turns = two_bones(leg, nearer, np.full(len(leg), swivel))
        arm = rotation.rotate(turns.swing, leg.knee - leg.hip)
        return unit(arm - dot(arm, line)[:, None] * line)

    captured = leg.knee - leg.hip
    captured = unit(captured - dot(captured, line)[:, None] * line)
    assert np.abs(dot(out_of_line(0.0), captured)[bent] - 1.0).max() < 1e-3
    turned = rotation.rotate(rotation.from_axis_angle(line, np.full(len(leg), 0.4)), out_of_line(0.0))
    assert np.abs(out_of_line(0.4) - turned)[bent].max() < 1e-9


def test_a_knee_through_straight_does_not_flip() -> None:
    frames = 61
    bend = np.radians(np.linspace(-4.0, 4.0, frames))  # overstretched to bent
    made = walk()
    rig = rig_of(made)
    leg = rig.legs[0]
    thigh = rotation.identity((frames,))
    knee = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), bend)
    clip = made.clip.frames(slice(0, frames)).with_joints({}, {leg.hip: thigh, leg.knee: knee})
    _, captured = leg_of(clip, rig)
    shorter = captured.hip + 0.98 * (captured.ankle - captured.hip)
    turns = two_bones(captured, shorter)
    flexion = captured.flexion + dot(rotation.to_rotation_vector(turns.bend), captured.knee_axis)
    assert flexion.min() > 0.2 and np.ptp(flexion) < 0.02


def test_a_join_that_would_leave_the_clip_goes_on_to_its_end() -> None:
    inside = _join(5, -1, 3, 20)
    assert (inside.free, inside.beyond, inside.frames.tolist()) == (1, 0, [4, 3, 2])
    outside = _join(5, -1, 4, 20)
    assert (outside.free, outside.frames.tolist(), outside.weight.tolist()) == (-1, [0, 1, 2, 3, 4], [0.0] * 5)
    inside = _join(14, 1, 3, 20)
    assert (inside.free, inside.beyond, inside.frames.tolist()) == (18, 19, [15, 16, 17])
    outside = _join(14, 1, 4, 20)
    assert (outside.free, outside.frames.tolist(), outside.weight.tolist()) == (-1, [15, 16, 17, 18, 19], [0.0] * 5)


def test_plants_at_the_ends_of_the_clip_have_joins_and_close_ones_have_none_between_them() -> None:
    count = np.full(60, 3)
    found = joins([(2, 10), (29, 40), (55, 58)], count, 10)
    assert [join.edge for join in found] == [2, 57]  # 19 frames between the first two, 15 between the others
    assert [join.edge for join in joins([(2, 10), (30, 40)], count, 10)] == [2, 9, 30, 39]
    assert [join.edge for join in joins([(2, 10)], 0 * count, 10)] == []

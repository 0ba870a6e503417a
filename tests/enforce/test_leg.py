"""A leg as captured, and its sole points: what is stated of them is what kinematics does, and what differences say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from exports import without_toes
from legmaker import KINDS, Figure, figure, figure_of, with_knees
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce.correction import Correction, apply
from footfix.enforce.leg import (
    ANKLE,
    HEEL,
    LEG,
    POINTS,
    ROOT,
    TIP,
    TOE,
    K,
    LegTracks,
    knee_axis,
    noise_of,
    raise_leg,
)
from footfix.enforce.leg_state import LegState, cross, exponential, local_rotations, places_of, state_of
from footfix.motion import rotation
from footfix.motion.clip import Floats
from footfix.motion.kinematics import forward
from footfix.rig.find import find_rig

SIZES = (0.0, 1e-9, 1e-6, 4e-4, 0.999e-3, 1.001e-3, 0.03, 0.5, 2.0, 3.1)  # [rad] of rotation vectors


def directions(count: int, seed: int) -> Floats:
    """(3, count) random unit vectors."""
    vectors = np.random.default_rng(seed).normal(size=(3, count))
    return np.asarray(vectors / np.linalg.norm(vectors, axis=0))


def states(leg: LegTracks, seed: int, size: float) -> tuple[Floats, Floats]:
    """A shift of the root (3, F) [m], and the unknowns of a leg (8, F), its line and foot turned by `size` [rad]."""
    random, frames = np.random.default_rng(seed), len(leg.flexion)
    x = random.normal(size=(LEG, frames)) * min(size, 0.4)
    x[:3], x[4:7] = size * directions(frames, seed), size * directions(frames, seed + 1)
    return 0.05 * random.normal(size=(3, frames)), x


@pytest.mark.parametrize("bare", [False, True])
def test_heel_and_toe_of_a_leg_are_what_plants_hold(bare: bool) -> None:
    clip = without_toes(walk().clip) if bare else walk().clip
    rig = find_rig(clip)
    made = figure_of(clip, rig, rig.no_contacts(clip))
    held = rig.held(rig.pose(clip))
    for sole, track in zip(rig.soles, held, strict=True):
        assert np.allclose(made.legs[sole.leg].place(POINTS.index(sole.part)).T, track, atol=1e-12)
    apart = [np.linalg.norm(a - b, axis=1) for a, b in zip(held, rig.tracks(rig.pose(clip)), strict=True)]
    heights = [rig.held_height(sole) for sole in rig.soles]
    assert all(np.allclose(each, height) for each, height in zip(apart, heights, strict=True))


@pytest.mark.parametrize("size", SIZES)
def test_jacobians_are_what_differences_say(size: float) -> None:
    leg = figure().legs[0].frames(np.arange(0, 180, 6))
    root, x = states(leg, 5, size)
    check_jacobians(leg, root, x)


@pytest.mark.parametrize("degrees", [-12.0, -0.5, 0.0, 0.01, 4.0, 60.0, 130.0])
def test_jacobians_of_a_knee_however_it_is_bent(degrees: float) -> None:
    made = walk(duration=3.0)
    angles = np.where(np.arange(len(made.clip)) < 90, 50.0, degrees)  # the first half tells how it bends
    clip = with_knees(made.clip, rig_of(made), np.radians(angles))
    leg = figure_of(clip, rig_of(made), made.contacts).legs[1].frames(np.arange(90, 180, 10))
    assert np.allclose(np.degrees(leg.flexion), degrees, atol=1e-6)
    root, x = states(leg, 8, 0.2)
    check_jacobians(leg, root, np.zeros_like(x))
    check_jacobians(leg, root, x)


@pytest.mark.parametrize("kind", ["four bones", "no toes", "stiff toes"])
def test_jacobians_of_other_legs(kind: str) -> None:
    leg = figure(kind).legs[1].frames(np.arange(0, 180, 20))
    check_jacobians(leg, *states(leg, 2, 0.7))


def jacobian_of(at: LegState, point: int) -> Floats:
    """(3, 11, F) derivatives of a point by the root's three unknowns and the leg's eight, as `LegState` puts them."""
    out, arm = np.zeros((3, ROOT + LEG, at.ankle.shape[2])), at.arms[point]
    out[range(3), range(3)] = 1.0
    out[:, ROOT : ROOT + 4] = at.ankle
    if arm is not None:
        out[:, ROOT + 4 : ROOT + 7] = np.stack([cross(at.turn[:, j], arm) for j in range(3)], axis=1)
    if point == TIP and at.hinge is not None:
        out[:, ROOT + 7] = at.hinge
    return out


def check_jacobians(leg: LegTracks, root: Floats, x: Floats) -> None:
    found, whole, h = state_of(leg, root, x), np.concatenate([root, x]), 2e-5
    for u in range(ROOT + LEG):
        sides = []
        for step in (h, -h, 2.0 * h, -2.0 * h):
            moved = whole.copy()
            moved[u] += step
            sides.append(places_of(leg, moved[:ROOT], moved[ROOT:]))
        for point in range(len(found.places)):
            jacobian = jacobian_of(found, point)
            one, two = sides[0][point] - sides[1][point], sides[2][point] - sides[3][point]
            difference = (8.0 * one - two) / (12.0 * h)  # of the fourth order
            scale = max(float(np.abs(jacobian).max()), 0.1)
            assert np.abs(jacobian[:, u] - difference).max() <= 1e-6 * scale, (point, u)


def test_places_do_not_depend_on_whether_derivatives_are_wanted() -> None:
    leg = figure().legs[0]
    root, x = states(leg, 3, 0.3)
    for a, b in zip(state_of(leg, root, x).places, places_of(leg, root, x), strict=True):
        assert np.array_equal(a, b)


@pytest.mark.parametrize("size", SIZES)
def test_turning_is_what_quaternions_do(size: float) -> None:
    vector, v = size * directions(50, 1), 3.0 * directions(50, 2)
    expected = rotation.rotate(rotation.from_rotation_vector(vector.T), v.T).T
    assert np.allclose(np.einsum("cjf,jf->cf", exponential(vector), v), expected, atol=1e-12)


# ---- states in the clip -----------------------------------------------------------------------------


def points_of(made: Figure, clip_pose: object, k: int) -> list[Floats]:
    """The sole points of a leg by kinematics, (F, 3) [m] each: heel, toe joint (or ball), ankle, tip of the toes."""
    leg, skeleton = made.rig.legs[k], made.clip.skeleton
    heel, ball = (sole for sole in made.rig.soles if sole.leg == k)
    places = [clip_pose.point(heel.joint, np.array(heel.offset))]  # type: ignore[attr-defined]
    if leg.toe is None:
        places.append(clip_pose.point(ball.joint, np.array(ball.offset)))  # type: ignore[attr-defined]
    else:
        places.append(clip_pose.position(leg.toe))  # type: ignore[attr-defined]
    places.append(clip_pose.position(leg.ankle))  # type: ignore[attr-defined]
    ends = np.flatnonzero(skeleton.end_parents == leg.toe)
    if leg.toe is not None and len(ends):
        places.append(clip_pose.point(leg.toe, skeleton.end_offsets[ends[0]]))  # type: ignore[attr-defined]
    return places


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", [0.0, 1e-7, 0.02, 0.6])
def test_kinematics_puts_the_sole_points_where_the_state_says(kind: str, size: float) -> None:
    made = figure(kind)
    joints: list[int] = []
    rotations: list[Floats] = []
    root, stated = np.zeros((3, len(made.clip))), []
    for k, leg in enumerate(made.legs):
        x = states(leg, 20 + k, size)[1]
        x[K] = np.maximum(x[K], 0.05 - leg.flexion)
        if not leg.bends:
            x[-1] = 0.0
        root = states(made.legs[0], 20, size)[0]
        stated.append(places_of(leg, root, x))
        for joint, turn in local_rotations(made.clip, made.pose, leg, x).items():
            joints.append(joint)
            rotations.append(turn)
    change = Correction(made.rig.root, root.T, tuple(joints), np.stack(rotations, axis=1))
    after = apply(made.clip, change)
    pose = forward(after)
    for k in range(2):
        found = points_of(made, pose, k)
        assert len(found) == len(stated[k])
        for point, (place, track) in enumerate(zip(stated[k], found, strict=True)):
            assert np.abs(place.T - track).max() < 1e-9, (kind, k, point)
    # what a leg consists of keeps its lengths and what lies beside it its numbers
    moved = set(joints)
    for joint in range(len(made.clip.skeleton)):
        if joint not in moved:
            assert np.array_equal(after.rotation(joint), made.clip.rotation(joint))
    assert {leg.hip for leg in made.rig.legs} < moved


@pytest.mark.parametrize("kind", KINDS)
def test_places_as_captured_are_those_of_the_clip(kind: str) -> None:
    made = figure(kind)
    pose = forward(made.clip)
    for k, leg in enumerate(made.legs):
        wanted = points_of(made, pose, k)
        for point, track in enumerate(wanted):
            assert np.allclose(leg.place(point).T, track, atol=1e-12)
        assert len(leg.points) == len(wanted) - 1  # the ankle is where it is
        assert leg.bends == (kind not in ("no toes", "stiff toes", "bare toes"))


def test_a_knee_bent_in_a_state_is_bent_in_the_clip() -> None:
    made = figure()
    leg, rig = made.legs[0], made.rig
    x = np.zeros((LEG, len(made.clip)))
    x[K] = 0.2
    new = local_rotations(made.clip, made.pose, leg, x)
    after = made.clip.with_joints({}, new)

    def inner(clip: object) -> Floats:
        hip, knee, ankle = (rig.pose(clip).position(j) for j in rig.legs[0].chain)  # type: ignore[arg-type]
        thigh, shank = knee - hip, ankle - knee
        cosine = np.sum(thigh * shank, axis=1) / np.linalg.norm(thigh, axis=1) / np.linalg.norm(shank, axis=1)
        return np.arccos(cosine)

    assert np.allclose(inner(after) - inner(made.clip), 0.2, atol=1e-9)
    before, now = (rig.pose(clip).rotation(rig.legs[0].ankle) for clip in (made.clip, after))
    assert rotation.angle(rotation.multiply(rotation.inverse(before), now)).max() < 1e-9  # the foot keeps its turn
    # toes turn up, not down, with a bend above zero
    x[:] = 0.0
    x[-1] = 0.3
    lifted = places_of(leg, np.zeros((3, len(made.clip))), x)[TIP] - leg.place(TIP)
    flat = made.contacts.mask()[:, :2].all(axis=1)
    assert np.all(lifted[1, flat] > 0.01)
    up = made.clip.with_joints({}, local_rotations(made.clip, made.pose, leg, x))
    bend = rotation.multiply(rotation.inverse(made.clip.rotation(rig.legs[0].toe)), up.rotation(rig.legs[0].toe))
    assert np.allclose(rotation.angle(bend), 0.3, atol=1e-9)


# ---- as captured ------------------------------------------------------------------------------------


def test_a_bent_knee_has_the_axis_of_its_plane_and_a_straight_one_that_of_the_whole() -> None:
    made = walk()
    rig = rig_of(made)
    angles = np.radians(np.linspace(-10.0, 90.0, len(made.clip)))
    clip = with_knees(made.clip, rig, angles)
    found = figure_of(clip, rig, made.contacts)
    for leg, known, of in zip(found.legs, found.calibration, rig.legs, strict=True):
        x = rotation.rotate(found.pose.rotation(of.hip), np.array([1.0, 0.0, 0.0]))
        assert np.allclose(leg.axis.T, x, atol=1e-9)
        assert np.allclose(leg.flexion, angles, atol=1e-9)
        assert np.allclose(known.knee_axis, [1.0, 0.0, 0.0], atol=1e-9)
        assert np.isclose(known.straightest, np.percentile(angles, 1.0), atol=0.02)
        at = np.radians(3.6)  # or as straight as the leg ever is, if that is more; or as it is
        assert np.allclose(leg.least, np.minimum(angles, max(known.straightest, at)))
        hip, ankle = leg.hip, leg.ankle
        c0, c1, c2 = leg.reach
        for more in (0.0, 0.1, -0.2):
            shank = rotation.rotate(rotation.from_rotation_vector((more * leg.axis).T), leg.shank.T)
            distance = np.linalg.norm(leg.thigh.T + shank, axis=1)
            assert np.allclose(np.sqrt(c0 + c1 * np.cos(more) + c2 * np.sin(more)), distance, atol=1e-12)
        assert np.allclose(np.sqrt(c0 + c1), np.linalg.norm(ankle - hip, axis=0))


def test_the_axis_of_a_knee_comes_over_smoothly_as_the_leg_straightens() -> None:
    """A knee that gives sideways while it is nearly straight doesn't turn its axis about."""
    made = walk()
    rig = rig_of(made)
    clip = with_knees(made.clip, rig, np.radians(np.linspace(60.0, 0.0, len(made.clip))))
    aside = rotation.from_axis_angle(np.array([0.0, 0.0, 1.0]), np.full(len(clip), np.radians(2.0)))
    knee = rig.legs[0].knee
    clip = clip.with_joints({}, {knee: rotation.multiply(clip.rotation(knee), aside)})
    found = figure_of(clip, rig, made.contacts)
    leg, hip = found.legs[0], found.pose.rotation(rig.legs[0].hip)
    in_thigh = rotation.rotate(rotation.inverse(hip), leg.axis.T)
    turn = np.arccos(np.clip(np.sum(in_thigh[1:] * in_thigh[:-1], axis=1), -1.0, 1.0))
    assert np.degrees(turn.max()) < 0.3
    assert in_thigh[-1] @ found.calibration[0].knee_axis > 0.999  # the plane's normal is 90 degrees away from it
    assert np.allclose(np.linalg.norm(leg.axis, axis=0), 1.0)
    assert np.abs(np.sum(leg.axis * leg.thigh, axis=0)).max() < 1e-12


@pytest.mark.parametrize("noise", [0.0, 1e-3])  # [rad]
def test_a_leg_that_never_bends_bends_away_from_its_toes(noise: float) -> None:
    made = walk("stand")
    rig = rig_of(made)
    clip = with_knees(made.clip, rig, noise * np.where(np.arange(len(made.clip)) % 7 < 3, 1.0, -1.0))
    for leg in rig.legs:  # the figure stands with its feet level
        flat = rotation.multiply(clip.rotation(leg.ankle), made.clip.rotation(leg.knee))
        clip = clip.with_joints({}, {leg.ankle: flat})
    found = figure_of(clip, rig, made.contacts)
    for leg in found.legs:
        bend = rotation.from_rotation_vector((0.3 * leg.axis).T)
        shank = rotation.rotate(bend, leg.shank.T)
        toes = leg.points[TOE].T - leg.points[HEEL].T
        assert np.all(np.sum((shank - leg.shank.T) * toes, axis=1) < -0.01)


def test_noise_is_measured_under_a_motion() -> None:
    random, t = np.random.default_rng(3), np.arange(4000) / 120.0
    motion = 0.3 * np.stack([np.sin(2 * np.pi * t), np.cos(3 * np.pi * t), np.sin(3.0 * t)], axis=1)
    strikes = np.where(np.arange(4000) % 60 < 2, 0.05, 0.0)[:, None]
    noise = 0.002 * random.normal(size=motion.shape)
    for track, rel, white in (
        (noise, 0.05, True), (motion + noise, 0.1, True), (motion + strikes + noise, 0.35, None)
    ):  # fmt: skip
        found = noise_of(track)
        assert found.sigma == pytest.approx(0.002, rel=rel)
        assert white is None or found.white is white
    assert noise_of(motion).sigma < 1e-5 and not noise_of(motion).white
    assert noise_of(noise[:8]).sigma == 0.0 and not noise_of(noise[:8]).white


@pytest.mark.parametrize("hertz", [3.0, 10.0, 25.0])
def test_quick_motion_is_not_white(hertz: float) -> None:
    t = np.arange(4000) / 120.0
    circle = np.stack([np.cos(2 * np.pi * hertz * t), np.sin(2 * np.pi * hertz * t)], axis=1)
    assert not noise_of(circle).white


def test_each_noise_is_that_of_its_unknowns() -> None:
    made = walk("stand", fps=120.0)
    rig = rig_of(made)
    random, frames = np.random.default_rng(1), len(made.clip)

    def noises(joint: int, sigma: float) -> list[float]:
        shake = rotation.from_rotation_vector(sigma * random.normal(size=(frames, 1)) * [1.0, 0.0, 0.0])
        clip = made.clip.with_joints({}, {joint: rotation.multiply(made.clip.rotation(joint), shake)})
        return [each.sigma for each in figure_of(clip, rig, made.contacts).calibration[0].noise]

    leg, sigma = rig.legs[0], 0.01
    line, knee, foot = noises(leg.knee, sigma)
    assert knee == pytest.approx(sigma, rel=0.2) and 0.0 < line < knee and foot > 0.0
    line, knee, foot = noises(leg.ankle, sigma)
    assert foot > 0.3 * sigma and line < 1e-6 and knee < 1e-6
    line, knee, _ = noises(leg.hip, sigma)
    assert 0.3 * sigma < line < sigma and knee < 1e-6


def test_a_raised_leg_is_the_leg_higher_up() -> None:
    leg = figure().legs[0]
    up = raise_leg(leg, 0.03)
    for point in (HEEL, TOE, ANKLE, TIP):
        assert np.allclose(up.place(point) - leg.place(point), [[0.0], [0.03], [0.0]])
    root, x = states(leg, 3, 0.2)
    lifted, plain = state_of(up, root, x).places, state_of(leg, root, x).places
    assert all(np.allclose(a - b, [[0.0], [0.03], [0.0]]) for a, b in zip(lifted, plain, strict=True))


def test_some_frames_of_a_leg_are_those_of_the_whole() -> None:
    leg = figure().legs[1]
    which = np.array([3, 50, 51, 120])
    root, x = states(leg, 3, 0.2)
    some, whole = state_of(leg.frames(which), root[:, which], x[:, which]), state_of(leg, root, x)
    parts = ((*each.places, each.ankle, each.turn, each.hinge) for each in (some, whole))
    for a, b in zip(*parts, strict=True):
        assert np.allclose(a, b[..., which], atol=1e-15)
    part = leg.frames(which)
    for name in ("flexion", "least", "axis", "thigh", "shank"):
        assert np.array_equal(getattr(part, name), getattr(leg, name)[..., which])


def test_a_leg_that_lacks_a_channel_is_one_that_cannot_turn() -> None:
    made = figure()
    for joint in made.rig.legs[0].chain:
        rotates = np.ones(len(made.clip.skeleton), dtype=bool)
        rotates[joint] = False
        clip = replace(made.clip, skeleton=replace(made.clip.skeleton, rotates=rotates))
        assert [leg.turns for leg in figure_of(clip, made.rig, made.contacts).legs] == [False, True]


@pytest.mark.parametrize("bend", [0.05, 0.4, 1.2])
@pytest.mark.parametrize("aside", [0.0, 0.3, -0.8, 1.5])
def test_a_knees_axis_comes_from_its_usual_one_to_its_planes_normal_as_it_bends(bend: float, aside: float) -> None:
    """The normal is turned from the usual axis x about the thigh by `aside`, and as long as the sine of the bend."""
    thigh = np.array([[0.0, -0.4, 0.0]])
    normal = np.array([np.cos(aside), 0.0, np.sin(aside)])
    shank = rotation.rotate(rotation.from_axis_angle(normal[None], np.array([bend])), thigh)
    found = knee_axis(thigh, shank, np.array([[1.0, 0.0, 0.0]]))[0]
    c, s = np.sin(bend) * np.cos(aside), np.sin(bend) * np.sin(aside)
    square = c * c + 0.4**2
    expected = np.array([np.sqrt(square), 0.0, c * abs(c) / square * s])
    assert found == pytest.approx(expected / np.linalg.norm(expected))

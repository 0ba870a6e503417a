"""The floor is the file's zero plane where the toes rest on it; what lies between joint and plane is the sole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from exports import without_toes
from rigmaker import mirrored, moved, nameless, scaled, with_up
from skinmaker import skin_of
from walker import Walk, make
from walker_plan import Gait

from footfix.config import load_config
from footfix.errors import UsageError
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Skeleton
from footfix.rig.find import find_rig
from footfix.rig.frame_sample import Sample
from footfix.rig.params import RigParams, SoleParams
from footfix.rig.rig import Rig
from footfix.rig.soles import MESH_OVER_LOW, SoleEstimate, floor
from footfix.rig.units import infer_units
from footfix.rig.zero_plane import on_zero_plane, skin_on_zero_plane

LEG = 0.88  # [m]
ON_ZERO = "the file's zero plane, on which the toes rest"
ELSEWHERE = "where the soles rest most"


@cache
def walk(name: str = "walk") -> Walk:
    return make(Gait(name=name, duration=3.0, leg=LEG))  # type: ignore[arg-type]


def raised(metres: float, clip: Clip | None = None) -> Clip:
    return moved(walk().clip if clip is None else clip, 0.0, (0.0, metres, 0.0))


def depths(rig: Rig) -> dict[str, float]:
    """[m] how far each sole point lies from its joint."""
    return {sole.name: float(np.linalg.norm(sole.offset)) for sole in rig.soles}


@cache
def toe_rest() -> float:
    """[m] the usual height of the walker's toe joints while its toes are known to stand."""
    made = walk()
    rig = find_rig(made.clip)
    pose = rig.pose(made.clip)
    known = made.contacts.mask()
    return float(np.mean([np.median(pose.position(leg.toe)[known[:, 2 * k + 1], 1]) for k, leg in enumerate(rig.legs)]))  # type: ignore[arg-type]


def test_a_clip_on_its_zero_plane_has_its_floor_at_zero_exactly() -> None:
    rig = find_rig(walk().clip)
    assert rig.floor == 0.0
    assert rig.origins["floor"] == ON_ZERO
    assert all("the file's zero plane" in rig.origins[f"sole.{sole.name}"] for sole in rig.soles)
    assert depths(rig)["left_toe"] == pytest.approx(toe_rest(), abs=0.002)
    assert depths(rig)["left_toe"] == pytest.approx(depths(rig)["right_toe"], abs=1e-9)


def test_a_little_higher_the_soles_are_that_much_thicker() -> None:
    low, high = find_rig(walk().clip), find_rig(raised(0.01 * LEG))
    assert high.floor == 0.0
    for one, two in zip(low.soles, high.soles, strict=True):
        longer = np.array(two.offset) - np.array(one.offset)
        assert np.linalg.norm(longer) == pytest.approx(0.01 * low.leg_length, rel=1e-6)
        if one.part == "toe":
            assert longer @ one.offset > 0.0


@pytest.mark.parametrize("metres", [0.05, -0.06, 3.0, -0.9])
def test_a_clip_off_its_zero_plane_has_its_floor_where_its_feet_are(metres: float) -> None:
    far, rig = find_rig(raised(10.0)), find_rig(raised(metres))
    assert rig.floor == pytest.approx(metres, abs=0.006)
    assert rig.floor - metres == pytest.approx(far.floor - 10.0, abs=1e-9)
    assert rig.origins["floor"] == ELSEWHERE
    assert not any("zero plane" in origin for origin in rig.origins.values())
    for one, two in zip(far.soles, rig.soles, strict=True):
        assert np.allclose(one.offset, two.offset, atol=1e-9)


@pytest.mark.parametrize(
    ("share", "on_zero"), [(-0.008, False), (-0.002, True), (0.02, True), (0.066, True), (0.074, False)]
)
def test_toes_rest_on_the_plane_from_just_below_it_to_a_foot_above_it(share: float, on_zero: bool) -> None:
    rig = find_rig(raised(share * LEG - toe_rest()))
    assert (rig.origins["floor"] == ON_ZERO) == on_zero
    if on_zero:
        assert depths(rig)["left_toe"] == pytest.approx(max(share, 0.0) * LEG, abs=0.002)


def test_it_is_the_same_in_any_unit_and_with_any_axis_up() -> None:
    one = find_rig(raised(0.01))
    for unit, up in ((100.0, "y"), (1000.0, "y"), (100.0, "z"), (1.0, "-z")):
        clip = with_up(scaled(raised(0.01), unit), up)
        found = infer_units(clip)
        assert found.up == up
        back = scaled(with_up(clip, {"y": "y", "z": "-z", "-z": "z"}[up]), found.unit_m)
        two = find_rig(back)
        assert two.floor == 0.0
        for name, depth in depths(one).items():
            assert depths(two)[name] == pytest.approx(depth, rel=1e-6)


def test_it_is_the_same_wherever_the_clip_is_on_the_plane_and_whichever_way_it_goes() -> None:
    one, two = find_rig(raised(0.01)), find_rig(moved(raised(0.01), 1.1, (2.0, 0.0, -3.0)))
    assert two.floor == 0.0
    for a, b in zip(one.soles, two.soles, strict=True):
        assert np.allclose(a.offset, b.offset, atol=1e-6)


def test_a_mirror_swaps_the_feet() -> None:
    clip = nameless(raised(0.01))
    one, two = find_rig(clip), find_rig(mirrored(clip))
    assert two.floor == 0.0
    for sole in one.soles:
        other = next(each for each in two.soles if (each.joint, each.part) == (sole.joint, sole.part))
        assert one.legs[sole.leg].side != two.legs[other.leg].side
        assert np.allclose(np.array(other.offset) * [-1.0, 1.0, 1.0], sole.offset, atol=1e-9)


def test_feet_without_toe_joints_rest_with_their_tips() -> None:
    clip = without_toes(walk().clip)  # their End Sites are where the toe joints were
    low, high, far = find_rig(clip), find_rig(raised(0.01 * LEG, clip)), find_rig(raised(0.05, clip))
    assert (low.floor, high.floor) == (0.0, 0.0)
    assert far.origins["floor"] == ELSEWHERE
    for one, two in zip(low.soles, high.soles, strict=True):
        longer = np.linalg.norm(np.array(two.offset) - np.array(one.offset))
        assert longer == pytest.approx(0.01 * low.leg_length, rel=1e-6)
    nothing = find_rig(without_toes(walk().clip, ends=False))
    assert nothing.origins["floor"] == ELSEWHERE


def test_a_foot_without_toe_joint_is_held_where_that_joint_was() -> None:
    made, metres = walk(), 0.01 * LEG
    known = find_rig(made.clip)
    toes = [known.pose(made.clip).position(leg.toe) for leg in known.legs if leg.toe is not None]
    for lift in (0.0, metres):
        clip = raised(lift, without_toes(made.clip))
        rig = find_rig(clip)
        held = [track for track, sole in zip(rig.held(rig.pose(clip)), rig.soles, strict=True) if sole.part == "toe"]
        for track, toe in zip(held, toes, strict=True):
            # left and right are alike only to rounding in this walk
            assert np.linalg.norm(track - toe - [0.0, lift, 0.0], axis=1).max() < 0.002
        heights = [rig.held_height(sole) for sole in rig.soles if sole.part == "toe"]
        assert heights == pytest.approx([toe_rest() + lift] * 2, abs=0.002)


@pytest.mark.parametrize("ends", [True, False])
def test_the_height_of_a_guessed_toe_joint_is_one_that_toe_joints_have(ends: bool) -> None:
    rig = find_rig(raised(0.3, without_toes(walk().clip, ends=ends)))
    assert rig.origins["floor"] == ELSEWHERE
    heights = [rig.held_height(sole) / rig.leg_length for sole in rig.soles]
    assert heights[::2] == [0.0, 0.0]
    assert all(0.025 <= height <= 0.06 for height in heights[1::2])


def with_ends(change: Callable[[Floats], Floats]) -> Clip:
    """The walker without toe joints, the End Sites of its feet changed from where these were."""
    clip = without_toes(walk().clip)
    skeleton, ends = clip.skeleton, clip.skeleton.end_offsets.copy()
    feet = [k for k, joint in enumerate(skeleton.end_parents.tolist()) if skeleton.names[joint].endswith("Foot")]
    ends[feet] = change(ends[feet])
    return replace(clip, skeleton=replace(skeleton, end_offsets=ends))


def test_a_tip_far_ahead_of_the_toe_joint_is_not_taken_for_it() -> None:
    rig, known = find_rig(with_ends(lambda ends: ends / 0.72)), find_rig(walk().clip)  # as far as tips of toes are
    for leg, sole in zip(known.legs, rig.soles[1::2], strict=True):
        assert leg.toe is not None and sole.held is not None
        away = np.array(sole.held) - walk().clip.skeleton.offsets[leg.toe]
        assert np.linalg.norm(away) < 0.001 * LEG


def test_a_tip_level_with_the_ankle_leaves_the_toe_joint_at_its_usual_height() -> None:
    rig = find_rig(with_ends(lambda ends: ends / 0.72 * [1.0, 0.0, 1.0]))
    assert [rig.held_height(sole) / rig.leg_length for sole in rig.soles[1::2]] == pytest.approx([0.045, 0.045])


@pytest.mark.parametrize("metres", [0.0, 0.3])
def test_a_foot_that_stands_on_the_tips_of_its_toes_is_held_at_its_sole(metres: float) -> None:
    clip = with_ends(lambda ends: ends * [1.0, 4.0, 1.0])
    low = find_rig(clip, RigParams(floor=0.0)).tracks(find_rig(clip).pose(clip))
    rig = find_rig(raised(metres - min(float(track[:, 1].min()) for track in low), clip))
    assert (rig.origins["floor"] == ON_ZERO) == (metres == 0.0)
    assert [rig.held_height(sole) for sole in rig.soles] == [0.0] * 4


def test_a_toe_placed_by_the_config_is_held_as_high_over_its_sole_as_any_other() -> None:
    clip = without_toes(walk().clip)
    plain = find_rig(clip)
    sole = plain.soles[1]
    moved_to = tuple(np.array(sole.offset) + [0.0, 0.0, 0.01])
    given = find_rig(clip, RigParams(soles={sole.name: SoleParams(offset=moved_to)})).soles[1]
    assert given.offset == pytest.approx(moved_to) and sole.held is not None
    assert given.held == pytest.approx(np.array(sole.held) + [0.0, 0.0, 0.01])


@pytest.mark.parametrize("name", ["stairs", "stairs-down"])
def test_stairs_on_the_plane_have_the_lowest_of_their_levels_on_it(name: str) -> None:
    made = walk(name)
    heights = [
        float(np.median(track[contact.start : contact.end, 1]))
        for track, effector in zip(made.tracks, made.contacts.effectors, strict=True)
        for contact in effector.contacts
        if contact.end - contact.start > 20
    ]
    rig = find_rig(raised(-min(heights), made.clip))
    assert rig.floor == 0.0
    assert "floor-ambiguous" in [note.id for note in rig.notes]


@pytest.mark.parametrize("metres", [0.0, 0.3, -0.3])
def test_the_zero_plane_can_be_asked_for(metres: float) -> None:
    rig, unasked = find_rig(raised(metres), RigParams(floor="zero")), find_rig(raised(metres))
    assert (rig.floor, rig.origins["floor"]) == (0.0, "config")
    assert rig.soles == unasked.soles
    assert "floor-ambiguous" not in [note.id for note in rig.notes]


def test_a_height_that_is_given_leaves_the_soles_to_be_guessed() -> None:
    assert find_rig(walk().clip, RigParams(floor=0.1)).soles != find_rig(walk().clip).soles
    far = find_rig(raised(10.0))
    for one, two in zip(far.soles, find_rig(walk().clip, RigParams(floor=0.1)).soles, strict=True):
        assert np.allclose(one.offset, two.offset, atol=1e-9)


def test_settings_take_a_height_or_zero() -> None:
    assert load_config(sets=["rig.floor=zero"]).settings().rig.floor == "zero"
    assert load_config(sets=["rig.floor=-0.02"]).settings().rig.floor == -0.02
    assert load_config(sets=["rig.floor=null"], preset="ml-generated").settings().rig.floor is None
    assert load_config(preset="ml-generated").settings().rig.floor == "zero"
    assert load_config(preset="video").settings().rig.floor is None
    with pytest.raises(UsageError, match=r"rig\.floor must be a number or 'zero', not 'ground'"):
        load_config(sets=["rig.floor=ground"])


# Two stiff feet, each an ankle and a toe joint 0.1 ahead and 0.05 below it, on legs of 1 m.
UP, AHEAD = np.eye(3)[1], np.eye(3)[2]
FEET = 2 * (SoleEstimate(UP, AHEAD, UP, 0.095, 0.045, 0.07, 0.1, 0.05, 0.045, ()),)
JOINTS = ((0, 1), (2, 3))


def standing(*levels: tuple[float, float]) -> Sample:
    """A sample of 10 frames at each pair of heights [m] of the left and the right toe joint, all at rest."""
    toes = np.repeat(np.array(levels), 10, axis=0)  # (S, 2) [m]
    places = np.zeros((len(toes), 4, 3))
    places[:, 1::2, 1], places[:, 0::2, 1] = toes, toes + 0.05
    places[:, 1::2, 2] = 0.1
    skeleton = Skeleton(
        names=("LeftFoot", "LeftToe", "RightFoot", "RightToe"),
        parents=np.array([-1, 0, -1, 2]),
        offsets=np.zeros((4, 3)),
        end_parents=np.zeros(0, np.intp),
        end_offsets=np.zeros((0, 3)),
    )
    still, ends = np.zeros_like(places), np.zeros((len(toes), 0, 3))
    turns = np.tile([0.0, 0.0, 0.0, 1.0], (len(toes), 4, 1))
    return Sample(skeleton, places, turns, still, ends, ends, np.zeros(4), places)


@pytest.mark.parametrize(
    ("levels", "ball"),
    [
        ([(0.03, 0.03)], 0.03),
        ([(0.02, 0.04)], 0.03),  # both stand: the mean of the two
        ([(0.03, 0.30)], 0.03),  # one foot on a box
        ([(0.45, 0.45), (0.02, 0.02), (0.45, 0.45)], 0.02),  # down from a box and up again
        ([(-0.003, -0.003)], 0.0),  # the joint itself is the sole
        ([(-0.008, -0.008)], None),
        ([(0.08, 0.08)], None),
    ],
)
def test_heights_of_feet_at_rest(levels: list[tuple[float, float]], ball: float | None) -> None:
    measured = on_zero_plane(standing(*levels), FEET, JOINTS, 1.0)
    if ball is None:
        assert measured is None
        return
    assert measured is not None
    rest = -0.003 if ball == 0.0 else ball
    for foot in measured:
        assert foot.ball_height == pytest.approx(ball, abs=1e-12)
        assert foot.ankle_height == pytest.approx(rest + 0.05, abs=1e-12)
        assert foot.measured


def stood(*heights: float) -> Floats:
    """(S, L) [m] feet that stand at some heights."""
    return np.tile(np.asarray(heights), (60, 1))


@pytest.mark.parametrize(
    ("fore", "hind", "on"),
    [(0.0, 0.0, True), (0.006, -0.054, True), (0.03, -0.054, False), (0.005, -0.2, False), (0.1, 0.1, False)],
)
def test_feet_of_a_skin_that_are_in_the_plane_stand_on_it_if_others_do(fore: float, hind: float, on: bool) -> None:
    heights = stood(fore, fore, hind, hind)
    assert skin_on_zero_plane(heights, np.zeros((60, 4, 3)), min(fore, hind), 0.9) is on


def test_a_skin_that_comes_down_from_the_plane_stands_below_it() -> None:
    heights = stood(0.0, 0.0)
    heights[20:] = -0.1
    assert not skin_on_zero_plane(heights, np.zeros((60, 2, 3)), -0.1, 0.9)


def test_a_figure_that_lies_on_the_backs_of_its_feet_has_its_floor_below_them() -> None:
    clip = walk("stand").clip
    lying = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(1.2))
    own = find_rig(clip, skin=skin_of(clip))
    pitched = clip.with_joints({}, {leg.ankle: rotation.multiply(clip.rotation(leg.ankle), lying) for leg in own.legs})
    rig = find_rig(pitched, skin=skin_of(clip))
    lowest = np.min([mesh.lowest(rig.pose(pitched)) for mesh in rig.meshes], axis=0)
    assert rig.floor == pytest.approx(float(np.median(lowest)), abs=0.002)


def test_the_floor_of_a_mesh_is_where_feet_stand_not_where_toes_are_driven_into_it() -> None:
    """In place, with toes that go 5 cm into the ground at each step: most of the time the foot stands 2 cm over it."""
    step = np.concatenate([np.full(20, 0.02), np.linspace(0.02, -0.05, 6), np.full(2, -0.05), np.full(8, 0.04)])
    heights = np.stack([step, np.roll(step, len(step) // 2)], axis=1)
    velocities = np.zeros((*heights.shape, 3))
    velocities[..., 1] = np.gradient(heights, 1.0 / 30.0, axis=0)
    velocities[..., 2] = -1.2
    level, _ = floor(heights, velocities, 0.9, MESH_OVER_LOW)
    assert level == pytest.approx(0.02, abs=0.005)

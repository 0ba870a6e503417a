"""Walks along a path: straight they are the walk, on curves they stand as firmly."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from strides import stances, stride

from footfix.enforce.params import EnforceParams
from footfix.errors import InputError, UsageError
from footfix.formats.floor_paths import shape
from footfix.locomotion.follow.blend_weight import ease
from footfix.locomotion.follow.key_times import align
from footfix.locomotion.follow.params import FollowParams
from footfix.locomotion.follow.prepared_walk import Walk, check_alike, make_walk
from footfix.locomotion.follow.run import Follow, follow_path
from footfix.locomotion.follow.transitions import At
from footfix.locomotion.loop.root_motion import root_in_world, with_root
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Skeleton
from footfix.motion.kinematics import forward, places


@cache
def along(path: str, *names: str, at: float = 2.0, **asked: object) -> Follow:
    drawn = shape(path)
    assert drawn is not None
    walks = [stride(name) for name in names or ("walk",)]
    ats = [At(), *(At(seconds=at + k) for k in range(len(walks) - 1))]
    return follow_path(drawn.points, walks, ats, FollowParams(**asked), EnforceParams(), relative=True)  # type: ignore[arg-type]


def standing(found: Follow) -> list[tuple[float, float]]:
    """[mm], [degrees] by which each planted toe joint slides, and its foot turns, without 15 ms at both ends."""
    out = []
    for pose, leg, some in stances(found):
        place, turn = pose.position(leg.toe)[some][:, [0, 2]], pose.rotation(leg.ankle)[some]
        far = np.linalg.norm(place - np.median(place, axis=0), axis=1).max()
        yaw = rotation.yaw(rotation.multiply(turn, rotation.inverse(turn[[len(turn) // 2]])))
        out.append((1000.0 * float(far), float(np.degrees(np.ptp(yaw)))))
    return out


def jerk(clip: Clip) -> float:
    return float(np.linalg.norm(np.diff(places(clip), n=3, axis=0), axis=2).mean()) / clip.frame_time**3


def longest_legs(clip: Clip, found: Follow) -> list[float]:
    pose = forward(clip, range(len(clip.skeleton)))
    lines = (pose.position(leg.hip) - pose.position(leg.ankle) for leg in found.rig.legs)
    return [float(np.linalg.norm(line, axis=1).max()) for line in lines]


def test_a_straight_path_gives_the_walk_back() -> None:
    found = along("line:4")
    loop = stride().loop.round
    rounds = places(found.clip)[: len(loop)]
    assert np.allclose(rounds, places(loop)[: len(rounds)], atol=1e-9)
    assert not np.any(found.walked.lean)
    assert np.all(found.walked.scale == 1.0)
    assert {plant.outcome for plant in found.plants} == {"kept"}


@pytest.mark.parametrize("path", ["circle:4", "circle:-2", "circle:1", "sine:1x6"])
def test_feet_stand_on_curves(path: str) -> None:
    found = along(path)
    slides, turns = np.array(standing(found)).T
    assert len(slides) > 5
    assert slides.max() <= 1.0
    assert turns.max() <= 2.0
    now, before = (longest_legs(clip, found) for clip in (found.clip, stride().clip))
    assert all(a <= 1.005 * b for a, b in zip(now, before, strict=True))
    assert jerk(found.clip) <= 1.05 * jerk(along("line:6").clip)


@pytest.mark.parametrize(("path", "radius", "side"), [("circle:4", 4.0, 1.0), ("circle:-2", 2.0, -1.0)])
def test_on_a_circle_the_root_keeps_to_it_and_the_body_leans(path: str, radius: float, side: float) -> None:
    found = along(path)
    walked = found.walked
    assert np.abs(walked.off).max() <= 0.01
    assert walked.arc[-1] == pytest.approx(found.path.length, rel=1e-6)
    speed = walked.arc[-1] / ((len(found.clip) - 1) * found.clip.frame_time)
    wanted = np.degrees(np.arctan(speed**2 / radius / 9.81))
    middle = slice(60, -60)
    assert np.allclose(side * np.degrees(walked.lean[middle]), wanted, atol=0.5)
    assert np.abs(walked.balance[middle]).max() <= 0.01
    assert np.all(side * walked.aside < 0.0)  # outwards
    upright = along(path, lean=False)
    assert not np.any(upright.walked.lean)
    assert not np.any(upright.walked.aside)


def test_the_body_is_turned_by_the_lean_and_the_head_is_not() -> None:
    found, upright = along("circle:2"), along("circle:2", lean=False)
    names = found.clip.skeleton.names
    spine, head = names.index("Spine"), names.index("Head")
    tilted = [forward(each.clip, [spine, head]) for each in (found, upright)]
    for joint, share in ((spine, 1.0), (head, 0.0)):
        between = rotation.multiply(tilted[0].rotation(joint), rotation.inverse(tilted[1].rotation(joint)))
        assert np.allclose(rotation.angle(between), share * np.abs(found.walked.lean), atol=1e-6)


def test_strides_shrink_with_curvature_and_not_where_that_is_unwanted() -> None:
    shrunk = along("circle:1").walked.scale
    size = stride().rig.leg_length
    assert np.allclose(shrunk, 1.0 - 0.28 * size, atol=2e-3)
    assert np.allclose(along("circle:1", stride=False).walked.scale, 1.0, atol=5e-3)
    assert along("circle:4").walked.scale.mean() > shrunk.mean()


@pytest.mark.parametrize("times", [0.7, 1.0, 1.3])
def test_speed_is_shared_by_time_and_stride(times: float) -> None:
    found = along("line:6", speed=times)
    walked = found.walked
    assert np.allclose(walked.speed, times * stride().speed, rtol=0.01)
    assert max(slide for slide, _ in standing(found)) <= 1.0
    strikes = [c.start for c in found.contacts.effectors[0].contacts if c.start > 0]
    frames = stride().stride_seconds * times**-0.42 / found.clip.frame_time
    assert np.allclose(np.diff(strikes), frames, atol=1.0)


def test_a_walk_blended_with_itself_is_itself() -> None:
    alone, twice = along("circle:4"), along("circle:4", "walk", "walk")
    assert len(twice.transitions) == 1
    assert np.allclose(places(alone.clip), places(twice.clip), atol=1e-9)


@pytest.mark.parametrize(("path", "names"), [
    ("line:9", ("walk", "run")), ("line:12", ("run", "walk")), ("circle:3", ("walk", "run"))
])  # fmt: skip
def test_strikes_come_together_and_feet_stand_while_one_walk_takes_over(path: str, names: tuple[str, str]) -> None:
    pair = stride(names[0]), stride(names[1])
    keys = align(pair)
    for leg in (0, 1):
        times = [key.time(each.strikes(leg)[0].astype(np.float64)) for key, each in zip(keys, pair, strict=True)]
        frames = [pair[1].frames * np.abs((t - times[0][0] + 0.5) % 1.0 - 0.5) for t in times]
        assert max(float(each.max()) for each in frames) <= 1.0
    found = along(path, *names)
    change = found.transitions[0]
    assert 0.2 <= change.end - change.start <= 2.0 * max(each.stride_seconds for each in pair)
    slides = np.array([slide for slide, _ in standing(found)])
    assert slides.max() <= 1.0  # though feet stand for longer in one of the two
    assert found.walked.speed[-1] == pytest.approx(pair[1].speed * found.walked.scale[-1], rel=0.02)
    second = np.linalg.norm(np.diff(places(found.clip), n=2, axis=0), axis=2).mean(axis=1) / found.clip.frame_time**2
    usual = [np.linalg.norm(np.diff(places(each.clip), n=2, axis=0), axis=2).mean(axis=1) / each.clip.frame_time**2
             for each in pair]  # fmt: skip
    some = slice(round(change.start / found.clip.frame_time), round(change.end / found.clip.frame_time))
    last, own = (places(each) - places(each)[:, :1] for each in (found.straight.frames(np.array([-1])), pair[1].clip))
    assert min(float(np.abs(last - each).max()) for each in own) < 1e-9  # its very frames, not between them
    assert second[some].max() <= 1.1 * max(float(np.percentile(each, 99)) for each in usual)


@pytest.mark.parametrize(("path", "names"), [
    ("line:9", ("walk", "run")), ("line:12", ("run", "walk")), ("line:9", ("walk", "tiptoe")),
    ("line:9", ("tiptoe", "walk")),
])  # fmt: skip
def test_no_joint_is_jolted_while_one_walk_takes_over(path: str, names: tuple[str, str]) -> None:
    usual = np.max([np.percentile(accelerations(along(path, name).clip), 99, axis=0) for name in names], axis=0)
    found = along(path, *names)
    change, dt = found.transitions[0], found.clip.frame_time
    most = accelerations(found.clip)[round(change.start / dt) : round(change.end / dt)].max(axis=0)
    assert np.all(most <= 1.1 * np.maximum(usual, 0.05 * usual.max()))
    assert change.peak is not None
    assert change.asked_peak is not None
    assert change.peak <= max(change.asked_peak, 1.05)


def repeated(one: Walk, times: int) -> Walk:
    """A walk whose round is as many of its rounds."""
    frames = np.append(np.tile(np.arange(one.frames), times), 0)
    contacts = replace(one.contacts, frames=len(frames)).with_mask(one.contacts.mask()[frames])
    more = {"strides": times * one.strides, "length": times * one.length}
    return replace(one, clip=one.clip.frames(frames), contacts=contacts, **more)  # type: ignore[arg-type]


def test_where_a_walk_is_jolted_just_there_the_next_begins_later_if_there_is_time() -> None:
    one, at = repeated(stride(), 8), 2.0
    neck = int(one.clip.skeleton.parents[one.clip.skeleton.names.index("Head")])
    nod = np.zeros(len(one.clip))
    nod[round((at + 0.05) / one.clip.frame_time)] = 0.2  # once in all rounds: nothing that is usual
    turned = rotation.multiply(one.clip.rotation(neck), rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), nod))
    nodding = replace(one, name="nodding.bvh", clip=one.clip.with_joints({}, {neck: turned}))
    drawn = shape("line:9")
    assert drawn is not None
    begun = []
    for seconds in (5.0, at + 0.3):
        params, walks = FollowParams(seconds=seconds), [nodding, stride("run")]
        found = follow_path(drawn.points, walks, [At(), At(seconds=at)], params, EnforceParams(), relative=True)
        begun.append(found.transitions[0].start)
        assert any(note.id == "blend-waits" for note in found.notes) == (begun[-1] > at)
    assert begun[1] == along("line:9", "walk", "run").transitions[0].start == at
    assert at < begun[0] <= at + 0.4 * one.stride_seconds + one.clip.frame_time


def accelerations(clip: Clip) -> Floats:
    return np.asarray(np.linalg.norm(np.diff(places(clip), n=2, axis=0), axis=2) / clip.frame_time**2)


def test_a_walk_that_goes_round_in_its_cycle_is_refused() -> None:
    loop = stride().loop
    root = stride().root
    position, turn = root_in_world(loop.round, root)
    around = rotation.about_vertical(np.linspace(0.0, 2.0 * np.pi, len(turn)))
    spun = with_root(loop.round, root, position, rotation.multiply(around, turn))
    with pytest.raises(InputError, match="turns by 360 degrees"):
        make_walk(replace(loop, round=spun), "spun.bvh")


def test_a_walk_in_place_on_a_belt_goes_as_far_as_the_belt_would() -> None:
    found = along("circle:3", "treadmill")
    assert stride("treadmill").speed == pytest.approx(1.2, rel=0.02)
    assert found.walked.arc[-1] == pytest.approx(found.path.length, rel=1e-6)
    assert max(slide for slide, _ in standing(found)) <= 1.0


def test_what_a_figure_could_not_do_is_said() -> None:
    assert "too-fast" in {note.id for note in along("circle:2", "sprint").notes}
    assert not {"too-fast", "feet-let-go"} & {note.id for note in along("circle:2").notes}


def test_keys_are_there_and_back() -> None:
    key = align((stride("walk"), stride("run")))[1]
    frames = np.linspace(-40.0, 90.0, 200)
    assert np.allclose(key.frame(key.time(frames)), frames, atol=1e-6)
    assert np.all(np.diff(key.frame(np.linspace(-3.0, 3.0, 500))) > 0.0)


def test_contacts_of_a_walk_are_those_of_its_loop() -> None:
    found = along("line:4")
    once, loop = found.contacts.mask(), stride().contacts.mask()
    n = stride().frames
    assert all(np.array_equal(once[k : k + n][:n], loop[:n][: len(once) - k]) for k in range(0, len(once), n))


def test_seconds_say_how_long_and_an_open_path_ends() -> None:
    assert len(along("circle:1", seconds=12.0).clip) == 721
    short = along("line:3", seconds=60.0)
    assert "path-ends" in {note.id for note in short.notes}
    assert short.walked.arc[-1] == pytest.approx(3.0, abs=0.03)


def test_a_walk_that_begins_after_the_end_is_refused() -> None:
    with pytest.raises(UsageError, match="the walk ends after"):
        along("line:3", "walk", "run", at=30.0)


def renamed(one: Walk, **changes: object) -> Walk:
    own = one.clip.skeleton
    names = tuple(str(changes.get(name, name)) for name in own.names)
    skeleton = Skeleton(names, own.parents, own.offsets, own.end_parents, own.end_offsets, own.translates, own.rotates)
    clip = Clip(skeleton, one.clip.positions, one.clip.rotations, one.clip.frame_time)
    return Walk("other.bvh", clip, one.rig, one.contacts, one.strides, one.length, one.start, stride("run").loop)


def test_walks_of_two_skeletons_are_refused_with_the_first_difference() -> None:
    with pytest.raises(InputError, match="'Rump', not 'LeftUpLeg'"):
        check_alike([stride(), renamed(stride(), LeftUpLeg="Rump")])
    check_alike([stride(), stride("run")])


def test_a_step_is_at_rest_at_both_ends() -> None:
    u: Floats = np.linspace(0.0, 1.0, 1001)
    assert ease(np.array([-1.0, 0.0, 0.5, 1.0, 2.0])).tolist() == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0])
    first = np.gradient(ease(u), u)
    assert abs(first[0]) < 1e-3
    assert all(a <= b + 1e-12 for a, b in pairwise(ease(u)))

"""Cycles: found, solved as one, and closed at their seam wherever that is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from legmaker import largest_turn
from walks import cleaned, rig_of
from walks import short_walk as walk

from footfix.enforce.cyclic_clip import cycle_note
from footfix.enforce.params import EnforceParams
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import forward
from footfix.rig.cyclic_clip import find_cycle
from footfix.rig.repeated_rounds import rounds_of

FRAMES = 60  # of one round, of one second
X, Y = np.eye(3)[:2]


def striding(
    start: float = 0.0, *, closed: bool = True, yaw: float = 0.0, rounds: float = 1.0
) -> tuple[Clip, Contacts]:
    """A figure that strides on and on, from a phase [rounds] of it, turning by `yaw` [rad] a round; its feet skate."""
    made = walk()
    frames = round(FRAMES * rounds) + closed
    t = start + np.arange(frames) / FRAMES  # [rounds]
    phase = 2.0 * np.pi * t
    frame = rotation.from_axis_angle(Y, yaw * t)
    height = 0.86 + 0.01 * np.cos(2.0 * phase)
    place = np.stack([0.0 * t, height, 1.1 * t], axis=1)
    if yaw:  # on a circle
        place = np.stack([1.1 * (1.0 - np.cos(yaw * t)) / yaw, height, 1.1 * np.sin(yaw * t) / yaw], axis=1)
    turns = made.clip.rotations[:1].repeat(frames, axis=0).copy()
    turns[:, 0] = frame
    positions = made.clip.positions[:1].repeat(frames, axis=0).copy()
    positions[:, 0] = place
    names, mask = made.clip.skeleton.names, np.zeros((frames, 4), dtype=bool)
    for k, side in enumerate(("Left", "Right")):
        own = phase + np.pi * k
        knee = np.radians(25.0 - 18.0 * np.cos(own + 0.6))
        thigh = np.radians(-24.0 * np.sin(own)) - 0.5 * knee
        for name, angle in (("UpLeg", thigh), ("Leg", knee), ("Foot", -thigh - knee)):
            turns[:, names.index(side + name)] = rotation.from_axis_angle(X, angle)
        where = (t + 0.5 * k) % 1.0
        mask[:, 2 * k] = mask[:, 2 * k + 1] = (where > 0.30) & (where < 0.72)
    clip = Clip(made.clip.skeleton, positions, turns, 1.0 / FRAMES)
    return clip, replace(made.contacts, frames=frames).with_mask(mask)


def found_in(clip: Clip) -> object:
    rig = rig_of(walk())
    return find_cycle(clip, rig, rig.pose(clip))


@pytest.mark.parametrize("yaw", [0.0, 0.5, -1.2])
@pytest.mark.parametrize("closed", [True, False])
def test_a_round_is_found_with_its_turn(closed: bool, yaw: float) -> None:
    for start in (0.0, 0.37):
        found = found_in(striding(start, closed=closed, yaw=yaw)[0])
        assert found is not None
        assert found.frames == FRAMES and found.yaw == pytest.approx(yaw, abs=1e-3)  # type: ignore[attr-defined]


def test_a_round_of_few_frames_is_found_and_a_round_that_lacks_more_than_one_is_none() -> None:
    clip = striding(0.1, closed=False)[0].frames(slice(None, None, 6))
    shin = clip.skeleton.names.index("LeftLeg")
    kick = rotation.from_axis_angle(X, 0.6 * np.sin(6.0 * np.pi * np.arange(len(clip)) / len(clip) + 3.0))
    clip = clip.with_joints({}, {shin: rotation.multiply(clip.rotation(shin), kick)})
    found = found_in(clip)
    assert found is not None and found.frames == len(clip)  # type: ignore[attr-defined]
    assert found_in(clip.frames(slice(0, -2))) is None


def test_a_round_of_few_frames_is_found_though_a_joint_is_quickest_over_the_seam() -> None:
    clip = striding(0.1, closed=False)[0].frames(slice(None, None, 5))
    arm = clip.skeleton.names.index("LeftArm")
    swing = rotation.from_axis_angle(X, np.sin(4.0 * np.pi * (np.arange(len(clip)) + 0.5) / len(clip)))
    found = found_in(clip.with_joints({}, {arm: swing}))
    assert found is not None and found.frames == len(clip)  # type: ignore[attr-defined]


@pytest.mark.parametrize("travel", [1.1, 0.0])
@pytest.mark.parametrize("every", [1, 3])
def test_a_round_without_its_last_frame_goes_as_far_as_one_with_it(travel: float, every: int) -> None:
    whole, _ = striding(0.2)
    t = np.arange(len(whole)) / FRAMES
    sways = [0.02 * np.sin(2.0 * np.pi * t + 1.0), 0.0 * t, (travel - 1.1) * t + 0.05 * np.sin(4.0 * np.pi * t)]
    whole = whole.with_joints({0: whole.position(0) + np.stack(sways, axis=1)}, {}).frames(slice(None, None, every))
    rig = rig_of(walk())
    closed, unclosed = (rounds_of(clip, rig, "yes") for clip in (whole, whole.frames(slice(0, -1))))
    assert closed is not None and unclosed is not None
    unclosed = replace(unclosed, cycle=replace(unclosed.cycle, frames=len(unclosed.whole), yaw=0.0))
    n = len(unclosed.whole)
    a, b = (laid.clip.position(0)[laid.within.start :][: 2 * n] for laid in (closed, unclosed))
    assert b == pytest.approx(a, abs=1e-3 if travel else 1e-9)


def test_what_the_last_frame_lacks_to_the_first_is_said() -> None:
    clip, _ = striding(closed=True)
    shin = clip.skeleton.names.index("LeftLeg")
    turns = clip.rotation(shin).copy()
    turns[-1] = rotation.multiply(turns[-1], rotation.from_axis_angle(X, 0.02))
    rig = rig_of(walk())
    plain, off = (rounds_of(c, rig, "find") for c in (clip, clip.with_joints({}, {shin: turns})))
    assert plain is not None and off is not None
    assert "stay" not in cycle_note(plain).text
    pose = forward(clip)
    below = [j for j in range(len(clip.skeleton)) if shin in clip.skeleton.ancestors(j)]
    reach = np.linalg.norm((pose.positions[-1, below] - pose.position(shin)[-1])[:, 1:], axis=1)  # about the x axis
    moved = 1000.0 * 2.0 * np.sin(0.01) * reach.max()  # [mm]
    name = clip.skeleton.names[below[int(np.argmax(reach))]]
    assert f"but for {moved:.0f} mm at {name}, which stay" in cycle_note(off).text


def test_what_is_no_cycle_is_none() -> None:
    assert found_in(striding(rounds=1.3)[0]) is None
    assert found_in(walk().clip) is None
    stand = walk("stand").clip
    assert found_in(stand.frames(np.zeros(60, dtype=int))) is None  # nothing moves
    clip = striding()[0]
    positions = clip.positions.copy()
    positions[:, 0, 1] += np.linspace(0.0, 0.1, len(clip))  # a step up
    assert found_in(replace(clip, positions=positions)) is None
    lean = rotation.from_axis_angle(X, np.linspace(0.0, 0.2, len(clip)))
    turns = clip.rotations.copy()
    turns[:, 0] = rotation.multiply(lean, turns[:, 0])
    assert found_in(replace(clip, rotations=turns)) is None


@pytest.mark.parametrize(("start", "yaw"), [(0.0, 0.5), (0.25, 0.5), (0.61, 0.0)])  # with and without a plant across it
def test_a_cycles_seam_stays_closed_and_that_is_said(start: float, yaw: float) -> None:
    rig = rig_of(walk())
    clip, contacts = striding(start, yaw=yaw)
    after, found = cleaned(clip, rig, contacts)
    assert "cycle" in {note.id for note in found.notes}
    assert largest_turn(clip, after, rig) > 3.0, "there was to be something to do"
    for leg in rig.legs:
        for joint in leg.chain:
            over = rotation.multiply(rotation.inverse(after.rotation(joint)[:1]), after.rotation(joint)[-1:])
            assert np.degrees(rotation.angle(over)[0]) < 0.001
    turn = rotation.from_axis_angle(Y, np.array([yaw]))
    shift = found.correction.root_shift
    assert np.allclose(shift[-1], rotation.rotate(turn, shift[:1])[0], atol=1e-6)
    _, left = cleaned(clip, rig, contacts, EnforceParams(cycle="no"))
    assert "cycle" not in {note.id for note in left.notes}


@pytest.mark.parametrize(("closed", "yaw"), [(True, 0.0), (True, 0.5), (False, 0.5)])
def test_a_foot_that_stands_across_the_seam_stands_there_too(closed: bool, yaw: float) -> None:
    rig = rig_of(walk())
    clip, contacts = striding(0.0, closed=closed, yaw=yaw)
    assert contacts.mask()[[0, -1], 3].all()
    after, _ = cleaned(clip, rig, contacts)
    toe = [rig.pose(each).position(rig.legs[1].toe) for each in (clip, after)]  # type: ignore[arg-type]
    turn = rotation.from_axis_angle(Y, np.array([yaw]))
    # where a round leads a point: with the figure that strides on
    travel = striding(1.0, yaw=yaw)[0].positions[0, 0] - rotation.rotate(turn, clip.positions[:1, 0])[0]
    before, now = (
        np.linalg.norm((rotation.rotate(turn, each[:1])[0] + travel - each[-1])[[0, 2]]) * 1000.0 for each in toe
    )
    assert (closed or before > 15.0) and now < 1.6
    steps = np.linalg.norm(np.diff(toe[1][-6:, [0, 2]], axis=0), axis=1) * 1000.0
    assert steps.max() < 1.6


def test_a_foot_is_held_up_to_the_last_frame_of_a_cycle_whose_ends_are_apart() -> None:
    rig = rig_of(walk())
    clip, contacts = striding(0.0)
    thigh = clip.skeleton.names.index("RightUpLeg")
    drift = rotation.from_axis_angle(X, np.linspace(0.0, 0.02, len(clip)))
    clip = clip.with_joints({}, {thigh: rotation.multiply(clip.rotation(thigh), drift)})
    after, found = cleaned(clip, rig, contacts)
    assert "cycle" in {note.id for note in found.notes}
    toe = rig.pose(after).position(rig.legs[1].toe)  # type: ignore[arg-type]
    assert np.linalg.norm(np.diff(toe[-6:, [0, 2]], axis=0), axis=1).max() < 0.0016


def test_an_idle_that_nearly_ends_as_it_begins_is_a_cycle_if_its_kind_mostly_is_one() -> None:
    """It moves so little in a frame that a gap nobody sees is many of its steps."""
    rig, stand = rig_of(walk()), striding()[0].frames(np.zeros(61, dtype=int))
    spine, t = stand.skeleton.names.index("Spine"), np.linspace(0.0, 1.0, 61)

    def swaying(apart: float) -> Clip:  # [rad]
        angle = 0.02 * np.sin(2.0 * np.pi * t) + apart * (t == 1.0)
        turns = rotation.multiply(stand.rotation(spine), rotation.from_axis_angle(X, angle))
        return stand.with_joints({}, {spine: turns})

    for apart, likely, is_one in ((0.02, True, True), (0.02, False, False), (0.2, True, False)):
        clip = swaying(apart)
        found = find_cycle(clip, rig, rig.pose(clip), likely=likely)
        assert (found is not None) is is_one, (apart, likely)
        assert found is None or found.frames == 60


@pytest.mark.parametrize("yaw", [0.0, 0.5, -1.2])
@pytest.mark.parametrize("closed", [True, False])
def test_rounds_go_on_where_the_one_before_ended(closed: bool, yaw: float) -> None:
    """A figure that strides on and on is what the rounds of one of its strides are."""
    rig = rig_of(walk())
    clip, _ = striding(0.2, closed=closed, yaw=yaw)
    rounds = rounds_of(clip, rig, "find")
    assert rounds is not None and rounds.cycle.frames == FRAMES
    start = rounds.within.start
    assert start >= FRAMES + 2.0 / clip.frame_time
    long, _ = striding(0.2 - start / FRAMES, yaw=yaw, rounds=(len(rounds.clip) - 1) / FRAMES)
    joints = [rig.root, *rig.legs[0].chain]
    laid, there = (forward(each, joints).positions for each in (rounds.clip, long))
    assert np.abs(laid - there).max() < 1e-3
    for whole, part in ((clip.positions, rounds.clip.positions), (clip.rotations, rounds.clip.rotations)):
        assert np.array_equal(part[rounds.within], whole)


def test_a_stand_that_the_seam_cuts_is_one_among_the_rounds_and_two_in_the_clip() -> None:
    rig = rig_of(walk())
    clip, contacts = striding(0.0)
    rounds = rounds_of(clip, rig, "find")
    assert rounds is not None
    own, laid = contacts["right_toe"].contacts, rounds.contacts(contacts)["right_toe"].contacts
    assert len(own) == 2 and own[0].start == 0 and own[1].end == len(clip)
    lengths = {c.end - c.start for c in laid[1:-1]}
    assert lengths == {own[0].end + FRAMES - own[1].start}
    back = rounds.contacts_back(rounds.contacts(contacts))
    assert back == contacts
    _, found = cleaned(clip, rig, contacts)
    first, last = (plant for plant in found.plants if plant.name == "right_toe")
    assert (first.start, first.end, last.start, last.end) == (0, own[0].end, own[1].start, len(clip))
    assert first.outcome == last.outcome == "pinned"
    assert first.held[0][0] == 0 and last.held[-1][1] == len(clip)


def test_what_is_forbidden_stays_apart_and_what_is_asked_for_is_asked_for_in_each_round() -> None:
    rig = rig_of(walk())
    clip, contacts = striding(0.0)  # a round leads 1.1 m on
    rounds = rounds_of(clip, rig, "find")
    assert rounds is not None
    head, tail = contacts["right_toe"].contacts
    tail = replace(tail, wish="forbid")
    asked = replace(head, position=(0.1, 0.0, 0.2))
    effectors = [replace(e, contacts=(asked, tail)) if e.name == "right_toe" else e for e in contacts.effectors]
    laid = rounds.contacts(replace(contacts, effectors=tuple(effectors)))["right_toe"].contacts
    assert {c.end - c.start for c in laid[1:-1]} == {head.end - head.start, FRAMES - tail.start}
    for c in laid:
        if c.wish != "forbid":
            on = (c.start - rounds.within.start) // FRAMES
            assert c.position == pytest.approx((0.1, 0.0, 0.2 + 1.1 * on), abs=1e-9)


def test_the_same_frame_at_both_ends_makes_a_cycle_of_a_longer_clip_that_pauses_there() -> None:
    clip = striding()[0]
    pauses = np.concatenate([np.zeros(6, dtype=int), np.arange(61), np.full(6, 60)])
    assert found_in(clip.frames(pauses)) is not None
    assert found_in(replace(clip.frames(pauses), frame_time=1.0)) is not None
    assert found_in(replace(clip.frames(pauses), frame_time=2.0)) is None
    turns = clip.rotations.copy()
    turns[-1, 1:] = rotation.multiply(rotation.from_axis_angle(X, np.array([2e-3])), turns[-1, 1:])
    near = replace(clip, rotations=turns)
    assert found_in(near) is not None and found_in(near.frames(pauses)) is None


@pytest.mark.parametrize("yaw", [0.0, 0.5])
def test_a_cycle_comes_out_the_same_wherever_it_is_cut(yaw: float) -> None:
    """One round from a quarter of it later is the same round, later by a quarter."""
    rig = rig_of(walk())
    later = FRAMES // 4
    one, other = (
        cleaned(clip, rig, contacts)[0]
        for clip, contacts in (striding(start, closed=False, yaw=yaw) for start in (0.0, 0.25))
    )
    off = []
    for leg in rig.legs:
        for joint in leg.chain:
            moved = np.roll(one.rotation(joint), -later, axis=0)
            off.append(rotation.angle(rotation.multiply(rotation.inverse(moved), other.rotation(joint))).max())
    assert np.degrees(max(off)) < 1.0


def test_it_is_taken_for_a_cycle_where_somebody_says_so() -> None:
    rig = rig_of(walk())
    clip, contacts = striding()
    lean = rotation.from_axis_angle(X, np.linspace(0.0, 0.2, len(clip)))
    turns = clip.rotations.copy()
    turns[:, 0] = rotation.multiply(lean, turns[:, 0])
    clip = replace(clip, rotations=turns)
    for how, is_one in (("find", False), ("no", False), ("yes", True)):
        _, found = cleaned(clip, rig, contacts, EnforceParams(cycle=how))  # type: ignore[arg-type]
        assert ("cycle" in {note.id for note in found.notes}) is is_one


@pytest.mark.parametrize("closed", [True, False])
def test_what_is_asked_for_in_a_cycle_is_where_it_is_asked_for(closed: bool) -> None:
    rig = rig_of(walk())
    clip, contacts = striding(closed=closed)
    track = rig.pose(clip).position(rig.legs[0].toe)  # type: ignore[arg-type]
    toe = contacts.effectors[1]
    contact = toe.contacts[0]
    place: Floats = np.median(track[contact.start : contact.end], axis=0) + [0.01, 0.0, 0.0]
    asked = (float(place[0]), rig.floor, float(place[2]))
    effectors = list(contacts.effectors)
    effectors[1] = replace(toe, contacts=(replace(contact, position=asked, wish="force"), *toe.contacts[1:]))
    after, _ = cleaned(clip, rig, replace(contacts, effectors=tuple(effectors)))
    there = rig.pose(after).position(rig.legs[0].toe)[contact.start : contact.end]  # type: ignore[arg-type]
    assert np.abs(there[:, [0, 2]] - [asked[0], asked[2]]).max() < 0.005

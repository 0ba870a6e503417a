"""Laws of enforcement, on walkers whose contacts are exactly known."""

from __future__ import annotations

from dataclasses import replace

import artefacts
import numpy as np
import pytest
from walks import cleaned, extension, heights, rig_of, slides, walk

from footfix.enforce.aims import levelled
from footfix.enforce.ease import EaseParams
from footfix.enforce.foot import feet, posed
from footfix.enforce.ground import carried
from footfix.enforce.plants import PlantParams, stances
from footfix.enforce.run import EnforceParams, enforce
from footfix.enforce.style import StyleParams
from footfix.measure.clip import peak_acceleration
from footfix.motion import rotation
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contact, Contacts
from footfix.motion.leadin import motion_proper

GAITS = ("walk", "run", "turn", "backwards")
ARTEFACTS = {
    "drift": lambda clip: artefacts.drift(clip, 0.05),
    "wander": lambda clip: artefacts.wander(clip, 0.05, slowest=1.0),
    "smaller": lambda clip: artefacts.scale_root(clip, 0.9, height=False),
    "larger": lambda clip: artefacts.scale_root(clip, 1.1, height=False),
    "sunk": lambda clip: artefacts.sink(clip, 0.03),
    "floating": lambda clip: artefacts.sink(clip, -0.03),
    "shaken": lambda clip: artefacts.shake(clip, 0.5, slowest=0.3),
}


def changed_joints(before: Clip, after: Clip) -> set[int]:
    return set(np.flatnonzero(np.any(before.rotations != after.rotations, axis=(0, 2))).tolist())


@pytest.mark.parametrize("gait", GAITS)
@pytest.mark.parametrize("artefact", ARTEFACTS)
def test_plants_hold_and_nothing_else_shows(gait: str, artefact: str) -> None:
    made = walk(gait)
    rig = rig_of(made)
    clip = ARTEFACTS[artefact](made.clip)
    after, _ = cleaned(clip, rig, made.contacts)
    slid = slides(after, rig, made.contacts)
    assert np.percentile(slid["toe"], 95) <= 1.0
    assert np.percentile(slid["heel"], 95) <= 2.0
    assert max(slid["toe"] + slid["heel"]) <= 6.0
    assert np.percentile(np.abs(heights(after, rig, made.contacts)), 95) <= 4.0
    assert heights(after, rig, made.contacts).min() >= -5.0
    assert extension(after, rig) <= max(0.9995, extension(clip, rig))
    clean = peak_acceleration(rig, rig.pose(made.clip), clip.frame_time)
    assert peak_acceleration(rig, rig.pose(after), clip.frame_time) <= 2.0 * clean


@pytest.mark.parametrize("gait", GAITS)
def test_what_stands_well_is_left_alone(gait: str) -> None:
    made = walk(gait)
    found = enforce(made.clip, rig_of(made), made.contacts, EnforceParams())
    assert not found.correction.root_shift.any()
    assert {plant.outcome for plant in found.plants} == {"kept"}
    for column, joint in enumerate(found.correction.joints):
        assert np.array_equal(found.correction.rotations[:, column], made.clip.rotations[:, joint])


@pytest.mark.parametrize("artefact", ["wander", "larger", "shaken", "sunk"])
@pytest.mark.parametrize("method", ["ik", "both", "root"])
def test_cleaning_a_cleaned_clip_changes_nothing(artefact: str, method: str) -> None:
    if method == "root" and artefact == "shaken":
        pytest.skip("the root alone cannot still feet that shake")
    made = walk()
    rig = rig_of(made)
    params = EnforceParams(method=method)  # type: ignore[arg-type]
    once, _ = cleaned(ARTEFACTS[artefact](made.clip), rig, made.contacts, params)
    twice, _ = cleaned(once, rig, made.contacts, params)
    for a, b in zip(rig.tracks(rig.pose(once)), rig.tracks(rig.pose(twice)), strict=True):
        assert np.abs(a - b).max() <= 0.002


def test_only_legs_and_the_roots_place_change() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.scale_root(made.clip, 1.1, height=False)
    after, _ = cleaned(clip, rig, made.contacts)
    assert changed_joints(clip, after) == {joint for leg in rig.legs for joint in leg.chain}
    assert np.array_equal(after.positions[:, 1:], clip.positions[:, 1:])
    root_only, _ = cleaned(clip, rig, made.contacts, EnforceParams(method="root"))
    assert not changed_joints(clip, root_only)


@pytest.mark.parametrize("ease", ["smooth", "cubic", "hermite"])
def test_outside_plants_and_eases_the_output_is_the_input(ease: str) -> None:
    made = walk("stand", duration=4.0)
    rig = rig_of(made)
    effectors = tuple(replace(e, contacts=(Contact(100, 140),)) for e in made.contacts.effectors)
    contacts = replace(made.contacts, effectors=effectors)
    clip = artefacts.drift(made.clip, 0.20)
    params = EnforceParams(ease=EaseParams(method=ease, seconds=0.3))  # type: ignore[arg-type]
    after, found = cleaned(clip, rig, contacts, params)
    assert any(plant.outcome == "pinned" for plant in found.plants)
    far = np.ones(len(clip), dtype=bool)
    far[100 - 18 : 140 + 18] = False
    still = ~np.any(found.correction.root_shift != 0.0, axis=1) & far
    assert still.sum() > 100
    assert np.array_equal(after.rotations[still], clip.rotations[still])
    assert not np.array_equal(after.rotations[~far], clip.rotations[~far])


def test_turned_shifted_and_mirrored_clips_give_the_turned_and_mirrored_result() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.05, slowest=1.0)
    plain, _ = cleaned(clip, rig, made.contacts)
    turned, _ = cleaned(artefacts.turned(clip, 1.2, (3.0, -2.0)), rig, made.contacts)
    expected = artefacts.turned(plain, 1.2, (3.0, -2.0))
    assert np.allclose(turned.positions[:, 0], expected.positions[:, 0], atol=1e-6)
    for leg in rig.legs:
        for joint in leg.chain:
            off = rotation.multiply(turned.rotations[:, joint], rotation.inverse(expected.rotations[:, joint]))
            assert rotation.angle(off).max() < 1e-5
    swapped = tuple(made.contacts.effectors[e] for e in (2, 3, 0, 1))
    names = [replace(e, name=o.name) for e, o in zip(swapped, made.contacts.effectors, strict=True)]
    soles = tuple(replace(s, offset=(-s.offset[0], *s.offset[1:])) for s in rig.soles)
    mirror, _ = cleaned(
        artefacts.mirrored(clip), replace(rig, soles=soles), replace(made.contacts, effectors=tuple(names))
    )
    expected = artefacts.mirrored(plain)
    assert np.allclose(mirror.positions[:, 0], expected.positions[:, 0], atol=1e-6)


def test_a_giant_is_cleaned_like_a_child() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.05, slowest=1.0)
    plain, _ = cleaned(clip, rig, made.contacts)
    soles = tuple(replace(s, offset=tuple(2.5 * v for v in s.offset)) for s in rig.soles)
    giant_rig = replace(rig, soles=soles, leg_length=2.5 * rig.leg_length, floor=2.5 * rig.floor)
    giant, _ = cleaned(artefacts.scaled(clip, 2.5), giant_rig, made.contacts)
    for leg in rig.legs:
        for joint in leg.chain:
            off = rotation.multiply(giant.rotations[:, joint], rotation.inverse(plain.rotations[:, joint]))
            assert rotation.angle(off).max() < 1e-4


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_other_frame_rates_hold_as_well(fps: float) -> None:
    made = walk("walk", fps)
    rig = rig_of(made)
    after, _ = cleaned(artefacts.scale_root(made.clip, 1.1, height=False), rig, made.contacts)
    slid = slides(after, rig, made.contacts)
    assert max(slid["toe"] + slid["heel"]) <= 2.0


def test_no_strength_no_change_and_half_strength_half_way() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.05, slowest=1.0)
    none, _ = cleaned(clip, rig, made.contacts, EnforceParams(strength=0.0))
    assert np.array_equal(none.rotations, clip.rotations) and np.array_equal(none.positions, clip.positions)
    before = slides(clip, rig, made.contacts)["toe"]
    half = slides(cleaned(clip, rig, made.contacts, EnforceParams(strength=0.5))[0], rig, made.contacts)["toe"]
    assert np.allclose(half, 0.5 * np.array(before), atol=1.0)


def test_forbidden_contacts_are_none_and_places_asked_for_are_taken() -> None:
    made = walk()
    rig = rig_of(made)
    toe = made.contacts.effectors[1]
    where = made.tracks[1][toe.contacts[1].start]
    asked = (float(where[0]) + 0.02, 0.0, float(where[2]))
    first, second, *others = toe.contacts
    changed = (replace(first, wish="forbid"), replace(second, position=asked, wish="force"), *others)
    contacts = with_toes(made.contacts, changed)
    after, found = cleaned(made.clip, rig, contacts)
    assert not [p for p in found.plants if p.effector == "left_toe" and p.start == first.start]
    track = rig.tracks(rig.pose(after))[1][second.start : second.end]
    assert np.abs(track - asked).max() < 0.001


def with_toes(contacts: Contacts, changed: tuple[Contact, ...]) -> Contacts:
    effectors = list(contacts.effectors)
    effectors[1] = replace(effectors[1], contacts=changed)
    return replace(contacts, effectors=tuple(effectors))


def test_a_treadmill_is_no_skate() -> None:
    made = walk("treadmill")
    rig = rig_of(made)
    after, found = cleaned(made.clip, rig, made.contacts)
    assert [note.id for note in found.notes] == ["in-place"]
    assert np.array_equal(after.rotations, made.clip.rotations)
    shaken, _ = cleaned(artefacts.wander(made.clip, 0.03, slowest=1.0), rig, made.contacts)
    ride = np.arange(len(shaken))[:, None] * shaken.frame_time * np.array(made.belt)
    for track, effector in zip(rig.tracks(rig.pose(shaken)), made.contacts.effectors, strict=True):
        for contact in effector.contacts:
            on_belt = (track - ride)[contact.start : contact.end]
            speeds = np.linalg.norm(np.diff(on_belt, axis=0), axis=1) / shaken.frame_time
            assert speeds.max(initial=0.0) < 0.05


def test_stairs_keep_their_levels() -> None:
    made = walk("stairs", duration=4.0)
    rig = rig_of(made)
    _, found = cleaned(artefacts.wander(made.clip, 0.04, slowest=1.0), rig, made.contacts)
    for plant, effector in ((p, made.contacts.names.index(p.effector)) for p in found.plants):
        assert abs(plant.target[1] - made.tracks[effector][plant.start, 1]) < 0.003


def test_a_long_slide_is_meant_and_said() -> None:
    made = walk("stand")
    rig = rig_of(made)
    clip = artefacts.drift(made.clip, 1.2)
    after, found = cleaned(clip, rig, made.contacts)
    assert {plant.outcome for plant in found.plants} == {"released"}
    assert all("meant" in plant.reason for plant in found.plants)
    assert np.array_equal(after.rotations, clip.rotations)


@pytest.mark.parametrize("given", [False, True])
def test_a_foot_that_rests_on_its_heel_is_not_slammed_flat(given: bool) -> None:
    made = walk("stand")
    rig = rig_of(made)
    ankle = rig.legs[0].ankle
    rotations = made.clip.rotations.copy()
    toe_up = rotation.from_axis_angle(np.array([[1.0, 0.0, 0.0]]), np.radians([-35.0]))
    rotations[:, ankle] = rotation.multiply(rotations[:, ankle], toe_up)
    clip = artefacts.wander(replace(made.clip, rotations=rotations), 0.03)
    before = rig.tracks(rig.pose(clip))[1][:, 1] - rig.tracks(rig.pose(clip))[0][:, 1]
    assert before.min() > 0.05
    after, found = cleaned(clip, rig, made.contacts if given else replace(made.contacts, method="auto"))
    heel, ball = rig.tracks(rig.pose(after))[:2]
    left = {plant.effector: plant for plant in found.plants if plant.effector.startswith("left")}
    stands = slice(left["left_heel"].start, left["left_heel"].end)
    assert left["left_heel"].outcome == "pinned" and np.ptp(heel[stands], axis=0).max() < 0.001
    if given:  # somebody says that it lies flat
        assert left["left_toe"].outcome == "pinned" and np.abs(ball[stands, 1] - heel[stands, 1]).max() < 0.001
    else:
        assert left["left_toe"].outcome == "released" and "above its heel" in left["left_toe"].reason
        assert np.abs(ball[:, 1] - heel[:, 1] - before).max() < 0.01


def test_a_foot_that_turns_on_its_ball_keeps_turning() -> None:
    made = walk("stand")
    rig = rig_of(made)
    angle = np.radians(60.0) * np.linspace(0.0, 1.0, len(made.clip))
    clip = spun(made.clip, rig.tracks(rig.pose(made.clip))[1][0], angle)
    contacts = replace(made.contacts, effectors=tuple(
        e if e.side == "left" else replace(e, contacts=()) for e in made.contacts.effectors
    ))  # fmt: skip
    after, found = cleaned(clip, rig, contacts)
    outcomes = {plant.effector: plant.outcome for plant in found.plants}
    assert outcomes["left_heel"] == "released"
    assert "ball" in next(plant.reason for plant in found.plants if plant.effector == "left_heel")
    heel, ball = rig.tracks(rig.pose(after))[:2]
    turned = np.unwrap(np.arctan2(*(ball - heel)[:, [0, 2]].T))
    assert np.isclose(turned[-1] - turned[0], angle[-1], atol=np.radians(3.0))
    assert np.ptp(ball, axis=0).max() < 0.002


@pytest.mark.parametrize("about", ["heel", "toe"])
def test_a_foot_that_swivels_stands_before_and_after(about: str) -> None:
    made = walk("stand", duration=5.0)
    rig = rig_of(made)
    frames, fps = len(made.clip), made.clip.fps
    middle = 0.5 * (1.0 + np.tanh((np.arange(frames) / fps - 3.5) / 0.12))
    angle = np.radians(50.0) * middle
    pivot = 0 if about == "heel" else 1
    clip = spun(made.clip, rig.tracks(rig.pose(made.clip))[pivot][0], angle)
    clip = artefacts.wander(clip, 0.02, slowest=1.0)
    contacts = replace(made.contacts, method="auto", effectors=tuple(
        replace(e, contacts=(Contact(0, frames, 0.9),) if e.side == "left" else ()) for e in made.contacts.effectors
    ))  # fmt: skip
    after, found = cleaned(clip, rig, contacts)
    stands, moves = ("left_heel", "left_toe") if about == "heel" else ("left_toe", "left_heel")
    assert [plant.outcome for plant in found.plants if plant.effector == stands] == ["pinned"]
    parts = [plant for plant in found.plants if plant.effector == moves]
    assert [plant.outcome for plant in parts] == ["pinned", "released", "pinned"]
    assert f"about its {'heel' if about == 'heel' else 'ball'}" in parts[1].reason
    assert len(found.plants) == sum(len(effector.contacts) for effector in found.contacts.effectors)
    tracks = rig.tracks(rig.pose(after))
    assert np.ptp(tracks[pivot], axis=0).max() < 0.001
    for part in (parts[0], parts[2]):
        assert np.ptp(tracks[1 - pivot][part.start : part.end], axis=0).max() < 0.001
    turned = np.unwrap(np.arctan2(*(tracks[1] - tracks[0])[:, [0, 2]].T))
    assert np.isclose(turned[-1] - turned[0], angle[-1], atol=np.radians(3.0))


def test_the_end_that_turns_has_no_place_while_the_other_is_not_held() -> None:
    made = walk("stand")
    rig = rig_of(made)
    frames = len(made.clip)
    angle = np.radians(70.0) * np.linspace(0.0, 1.0, frames)
    clip = spun(made.clip, rig.tracks(rig.pose(made.clip))[0][0], angle)  # about the left heel
    early = frames // 3
    spans = {"left_heel": (early, frames), "left_toe": (0, frames)}
    contacts = replace(made.contacts, effectors=tuple(
        replace(e, contacts=(Contact(*spans[e.name], 1.0),) if e.name in spans else ())
        for e in made.contacts.effectors
    ))  # fmt: skip
    after, found = cleaned(clip, rig, contacts)
    assert "about its heel" in next(plant.reason for plant in found.plants if plant.effector == "left_toe")
    moved = np.linalg.norm(
        rig.pose(after).position(rig.legs[0].ankle) - rig.pose(clip).position(rig.legs[0].ankle), axis=1
    )
    assert moved[:early].max() < moved[early:].max() + 0.005


def test_legs_that_go_on_through_a_cut_are_not_cut() -> None:
    """Only the arms of the first frame are those of another pose: the correction comes in as everywhere else."""
    made = walk("stand")
    rig = rig_of(made)
    clip = artefacts.sink(made.clip, 0.03)
    rotations = clip.rotations.copy()
    arms = [j for j, name in enumerate(clip.skeleton.names) if "Arm" in name or "Hand" in name or "Shoulder" in name]
    assert arms
    rotations[0, arms] = rotation.identity((len(arms),))
    turned = rotation.from_axis_angle(np.array([[0.0, 0.0, 1.0]]), np.radians([80.0]))
    rotations[1:, arms] = rotation.multiply(turned[:, None], clip.rotations[1:, arms])
    clip = replace(clip, rotations=rotations)
    assert motion_proper(clip).start == 1
    after, _ = cleaned(clip, rig, made.contacts)
    ankle = rig.pose(after).position(rig.legs[0].ankle)
    assert np.linalg.norm(np.diff(ankle[:10], axis=0), axis=1).max() < 0.002


def test_straight_legs_stay_straight_on_uneven_feet() -> None:
    made = walk("stand")
    rig = rig_of(made)
    legs = []
    for foot, up in zip(feet(rig, posed(made.clip, rig)), (0.03, 0.01), strict=True):
        # the knee between hip and ankle, all of them as high as the foot is
        whole = carried(replace(foot, knee=0.5 * (foot.hip + foot.ankle)), np.array([0.0, up, 0.0]))
        legs.append(whole)
    whole_clip = Contact(0, len(made.clip), 1.0)
    contacts = replace(
        made.contacts, effectors=tuple(replace(e, contacts=(whole_clip,)) for e in made.contacts.effectors)
    )
    stands = stances(contacts, legs, made.clip.frame_time, rig.leg_length, PlantParams())
    level = [s.level - rig.floor for s in levelled(stands, legs, rig.floor, rig.leg_length, PlantParams())]
    assert np.isclose(min(level), 0.0, atol=1e-6) and np.isclose(np.ptp(level), 0.02, atol=0.002)
    bent = [replace(leg, knee=leg.knee + [0.0, 0.0, 0.05]) for leg in legs]
    stands = stances(contacts, bent, made.clip.frame_time, rig.leg_length, PlantParams())
    level = [s.level - rig.floor for s in levelled(stands, bent, rig.floor, rig.leg_length, PlantParams())]
    assert np.allclose(level, 0.0)


def test_contacts_of_a_frame_or_two_are_let_go() -> None:
    made = walk("stand")
    rig = rig_of(made)
    frames = len(made.clip)
    spans = {
        "left_heel": [(0, 1), (60, 61), (100, 102)], "left_toe": [(0, frames)],
        "right_heel": [(40, 60), (frames - 1, frames)],
        "right_toe": [(40, 60), (frames - 3, frames)],
    }  # fmt: skip
    contacts = replace(made.contacts, method="auto", effectors=tuple(
        replace(e, contacts=tuple(Contact(*span, 0.9) for span in spans[e.name])) for e in made.contacts.effectors
    ))  # fmt: skip
    _, found = cleaned(artefacts.wander(made.clip, 0.02), rig, contacts)
    brief = {(p.effector, p.start) for p in found.plants if "too short" in p.reason}
    assert brief == {("left_heel", 60), ("left_heel", 100)}  # those at the ends may go on beyond them


@pytest.mark.parametrize(("left", "right", "floors"), [
    (-0.03, -0.05, (None, None)),
    (0.013, -0.007, (0.0047, 0.0047)),  # one would be drawn to the rig's floor, the other not
    (0.02, -0.015, (0.02, -0.015)),  # nor both, if they are uneven
    (0.006, -0.012, (None, None)),
    (0.12, -0.01, (0.12, None)),  # a step apart
])  # fmt: skip
def test_feet_side_by_side_stand_on_one_floor(
    left: float, right: float, floors: tuple[float | None, float | None]
) -> None:
    """Heights beyond the one up to which plants are drawn to the rig's floor; None for that floor itself."""
    made = walk("stand")
    rig = rig_of(made)
    snap = PlantParams.snap * rig.leg_length
    legs = [
        carried(foot, np.array([0.0, up, 0.0]))
        for foot, up in zip(feet(rig, posed(made.clip, rig)), (snap + left, snap + right), strict=True)
    ]
    whole = Contact(0, len(made.clip), 1.0)
    contacts = replace(made.contacts, effectors=tuple(replace(e, contacts=(whole,)) for e in made.contacts.effectors))
    params = PlantParams(hovers=0.0)  # what they are off the floor, not all of the clip is
    stands = stances(contacts, legs, made.clip.frame_time, rig.leg_length, params)
    found = levelled(stands, legs, rig.floor, rig.leg_length, params)
    wanted = [0.0 if floor is None else snap + floor for floor in floors]
    assert np.allclose([stance.level - rig.floor for stance in found], wanted, atol=0.003)


def spun(clip: Clip, about: np.ndarray, angle: np.ndarray) -> Clip:
    """The whole figure turned about a vertical line through a place, farther from frame to frame."""
    turn = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), angle)
    positions, rotations = clip.positions.copy(), clip.rotations.copy()
    positions[:, 0] = about + rotation.rotate(turn, positions[:, 0] - about)
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    return replace(clip, positions=positions, rotations=rotations)


def test_toes_turn_out_as_asked() -> None:
    made = walk()
    rig = rig_of(made)
    after, _ = cleaned(made.clip, rig, made.contacts, EnforceParams(style=StyleParams(toe_out={"left": 15.0})))
    flat = made.contacts.mask()[:, :2].all(axis=1)
    before, now = (
        np.unwrap(np.arctan2(*(tracks[1] - tracks[0])[flat][:, [0, 2]].T))
        for tracks in (rig.tracks(rig.pose(made.clip)), rig.tracks(rig.pose(after)))
    )
    assert np.allclose(np.degrees(now - before), 15.0, atol=0.5)
    assert changed_joints(made.clip, after) <= {*rig.legs[0].chain, *rig.legs[1].chain}


def test_frames_of_a_t_pose_stay_as_they_are() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.t_pose_first(artefacts.wander(made.clip, 0.05, slowest=1.0), 2)
    mask = np.concatenate([np.zeros((2, 4), dtype=bool), made.contacts.mask()])
    contacts = replace(made.contacts, frames=len(clip)).with_mask(mask)
    after, found = cleaned(clip, rig, contacts)
    assert np.array_equal(after.rotations[:2], clip.rotations[:2])
    assert np.array_equal(after.positions[:2], clip.positions[:2])
    assert max(slides(after, rig, contacts)["toe"]) < 1.0
    assert found.contacts.frames == len(clip)


def test_frames_that_lead_from_a_t_pose_to_the_motion_lead_to_what_is_corrected() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.t_pose_first(artefacts.turned(artefacts.sink(made.clip, 0.03), 0.0, (4.0, 4.0)), 3)
    rotations, positions = clip.rotations.copy(), clip.positions.copy()
    for frame in (1, 2):
        share = frame / 3.0
        rotations[frame] = rotation.slerp(rotations[0], rotations[3], np.array(share))
        positions[frame] = (1.0 - share) * positions[0] + share * positions[3]
    clip = replace(clip, rotations=rotations, positions=positions)
    assert motion_proper(clip).start == 3
    mask = np.concatenate([np.zeros((3, 4), dtype=bool), made.contacts.mask()])
    after, _ = cleaned(clip, rig, replace(made.contacts, frames=len(clip)).with_mask(mask))
    rise = (after.positions - clip.positions)[:, rig.root, 1]
    assert np.array_equal(after.positions[0], clip.positions[0]) and np.isclose(rise[3], 0.03, atol=0.003)
    assert np.allclose(rise[1:3] / rise[3], (1.0 / 3.0, 2.0 / 3.0), atol=0.05)


def test_a_clip_without_contacts_needs_nothing() -> None:
    made = walk()
    rig = rig_of(made)
    found = enforce(made.clip, rig, rig.no_contacts(made.clip), EnforceParams())
    assert found.plants == () and not found.correction.root_shift.any()


@pytest.mark.parametrize("method", ["ik", "root", "both"])
@pytest.mark.parametrize("frames", [1, 2, 3])
def test_a_handful_of_frames_is_no_trouble(method: str, frames: int) -> None:
    made = walk()
    rig = rig_of(made)
    clip = made.clip.frames(slice(0, frames))
    whole = replace(made.contacts, frames=frames).with_mask(np.ones((frames, 4), dtype=bool))
    after, _ = cleaned(clip, rig, whole, EnforceParams(method=method))  # type: ignore[arg-type]
    assert np.isfinite(after.positions).all() and np.isfinite(after.rotations).all()


def test_stiff_toes_bend_rather_than_enter_the_floor() -> None:
    made = walk()
    rig = rig_of(made)
    skeleton = made.clip.skeleton
    stiff = made.clip.rotations.copy()
    for leg in rig.legs:
        stiff[:, leg.toe] = [0.0, 0.0, 0.0, 1.0]
    clip = replace(made.clip, rotations=stiff)
    after, _ = cleaned(clip, rig, made.contacts)
    for leg in rig.legs:
        tip = skeleton.end_offsets[list(skeleton.end_parents).index(leg.toe)]
        planted = made.contacts.mask()[:, [1, 3][rig.legs.index(leg)]]
        deep, now = (rig.pose(each).point(leg.toe, tip)[planted, 1].min() for each in (clip, after))
        assert deep < -0.02 and now > -0.012
    slid = slides(after, rig, made.contacts)
    assert np.percentile(slid["toe"] + slid["heel"], 95) < 2.0


def test_a_leg_that_the_file_cannot_turn_is_released_and_said() -> None:
    made = walk()
    rig = rig_of(made)
    rotates = np.ones(len(made.clip.skeleton), dtype=bool)
    rotates[rig.legs[0].knee] = False
    clip = replace(artefacts.drift(made.clip, 0.05), skeleton=replace(made.clip.skeleton, rotates=rotates))
    after, found = cleaned(clip, rig, made.contacts)
    left = [plant for plant in found.plants if plant.effector.startswith("left") and plant.outcome != "kept"]
    assert left and all(plant.outcome == "released" and "channels" in plant.reason for plant in left)
    assert changed_joints(clip, after) <= set(rig.legs[1].chain)


def test_toes_that_quiver_slide_no_heel() -> None:
    """Toes that carry the ball wriggle by some degrees: heel and ball of a flat foot hold still all the same."""
    made = walk("walk", 120.0)
    rig = rig_of(made)
    random = np.random.default_rng(0)
    rotations = made.clip.rotations.copy()
    for leg in rig.legs:
        shake = rotation.from_rotation_vector(np.radians(4.0) * random.normal(size=(len(made.clip), 3)))
        rotations[:, leg.toe] = rotation.multiply(rotations[:, leg.toe], shake)
    clip = artefacts.drift(replace(made.clip, rotations=rotations), 0.05)
    after, _ = cleaned(clip, rig, made.contacts)
    slid = slides(after, rig, made.contacts)
    assert max(slides(clip, rig, made.contacts)["toe"]) > 3.0
    assert max(slid["toe"] + slid["heel"]) < 0.5


def test_without_strength_nothing_is_lifted_either() -> None:
    made = walk("run")
    rig = rig_of(made)
    clip = artefacts.shake(artefacts.sink(made.clip, 0.02), 1.0, slowest=0.3)
    none, _ = cleaned(clip, rig, made.contacts, EnforceParams(strength=0.0))
    for joint in range(len(clip.skeleton)):
        assert np.array_equal(none.turn(joint), clip.turn(joint))
        assert np.array_equal(none.place(joint), clip.place(joint))


def test_labels_as_a_detector_wrote_them_are_taken_as_a_detectors() -> None:
    made = walk()
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.05)
    unsure = tuple(
        replace(e, contacts=tuple(replace(c, confidence=0.9) for c in e.contacts)) for e in made.contacts.effectors
    )
    detected = replace(made.contacts, method="auto", effectors=unsure)
    after, found = cleaned(clip, rig, detected)
    read, again = cleaned(clip, rig, replace(detected, method="labels"))
    assert found.plants == again.plants
    for joint in range(len(clip.skeleton)):
        assert np.array_equal(after.turn(joint), read.turn(joint))

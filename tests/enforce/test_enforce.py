"""Laws of enforcement, on walkers whose contacts are exactly known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import artefacts
import numpy as np
import pytest
from exports import without_toes
from legmaker import KINDS, changed, changes, largest_turn
from walker import Walk
from walks import cleaned, extension, heights, rig_of, slides, straightness
from walks import short_walk as walk

from footfix.enforce.correction import Correction, apply
from footfix.enforce.costs import CostParams
from footfix.enforce.leg import HEEL, TIP, TOE, calibrate, tracks
from footfix.enforce.params import EnforceParams
from footfix.enforce.run import enforce
from footfix.enforce.style import StyleParams
from footfix.enforce.task import pose_of
from footfix.measure.clip import peak_acceleration
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Skeleton
from footfix.motion.contacts import Contact, Contacts
from footfix.motion.kinematics import forward
from footfix.rig.find import find_rig
from footfix.rig.rig import Rig

GAITS = ("walk", "run", "turn", "backwards")
Method = Literal["ik", "root", "both"]
Solver = Literal["whole_clip", "glardon", "kim_neff"]
WAYS: tuple[tuple[Method, Solver], ...] = (
    ("ik", "whole_clip"), ("both", "whole_clip"), ("root", "whole_clip"), ("ik", "glardon"), ("ik", "kim_neff"),
)  # fmt: skip
ARTEFACTS: dict[str, Callable[[Clip], Clip]] = {
    "drift": lambda clip: artefacts.drift(clip, 0.05),
    "wander": lambda clip: artefacts.wander(clip, 0.05, slowest=1.0),
    "smaller": lambda clip: artefacts.scale_root(clip, 0.9, height=False),
    "larger": lambda clip: artefacts.scale_root(clip, 1.1, height=False),
    "sunk": lambda clip: artefacts.sink(clip, 0.03),
    "floating": lambda clip: artefacts.sink(clip, -0.03),
    "shaken": lambda clip: artefacts.shake(clip, 0.5, slowest=0.3),
}


def wandering(made: Walk) -> Clip:
    return artefacts.wander(made.clip, 0.05, slowest=1.0)


def point(clip: Clip, rig: Rig, leg: int, which: int) -> Floats:
    """(F, 3) [m] the track of a point of a foot: heel, toe joint, or tip of the toes."""
    pose = pose_of(clip, rig)
    return tracks(clip, rig, pose, calibrate(rig, pose, clip))[leg].place(which).T


def strays(clip: Clip, rig: Rig, contacts: Contacts, belt: Floats | None = None) -> dict[str, list[float]]:
    """[mm] for heels and for toe joints, how far each planted one is from its median place over the floor."""
    found: dict[str, list[float]] = {"heel": [], "toe": []}
    for sole, effector in zip(rig.soles, contacts.effectors, strict=True):
        track = point(clip, rig, sole.leg, HEEL if sole.part == "heel" else TOE)
        track = track if belt is None else track - belt
        for c in effector.contacts:
            places = track[c.start : c.end][:, [0, 2]]
            far = np.linalg.norm(places - np.median(places, axis=0), axis=1).max()
            found[sole.part].append(1000.0 * float(far))
    return found


def in_order(slid: dict[str, list[float]], contacts: Contacts) -> list[float]:
    """What `strays` found, in the order of the plants."""
    left = {part: list(values) for part, values in slid.items()}
    return [left[effector.part].pop(0) for effector in contacts.effectors for _ in effector.contacts]


def same(one: Clip, other: Clip) -> bool:
    """Whether two clips are the same to the digit."""
    return np.array_equal(one.rotations, other.rotations) and np.array_equal(one.positions, other.positions)


# ---- what stands, stands ----------------------------------------------------------------------------


@pytest.mark.parametrize("gait", GAITS)
def test_a_clean_walk_stays_as_it_is_whether_its_feet_have_toe_joints_or_not(gait: str) -> None:
    made = walk(gait)
    for clip in (made.clip, without_toes(made.clip)):
        rig = find_rig(clip)
        done = enforce(clip, rig, made.contacts, EnforceParams())
        assert {plant.outcome for plant in done.plants} == {"kept"}
        assert not changes(clip, apply(clip, done.correction)).any()



@pytest.mark.parametrize(("gait", "artefact"), [
    *(("walk", artefact) for artefact in ARTEFACTS),
    ("run", "wander"), ("turn", "larger"), ("backwards", "larger"),
])  # fmt: skip
def test_plants_hold_and_nothing_else_shows(gait: str, artefact: str) -> None:
    made = walk(gait, duration=2.0)
    rig = rig_of(made)
    clip = ARTEFACTS[artefact](made.clip)
    after, found = cleaned(clip, rig, made.contacts)
    slid = strays(after, rig, made.contacts)  # kept plants and all
    assert np.percentile(slid["toe"], 95) <= 0.5 and np.percentile(slid["heel"], 95) <= 2.0
    assert max(slid["toe"] + slid["heel"]) <= 3.0
    assert np.percentile(np.abs(heights(after, rig, made.contacts)), 95) <= 7.0
    assert heights(after, rig, made.contacts).min() >= -12.0
    assert extension(after, rig) <= max(0.9995, extension(clip, rig)) + 1e-6
    clean = peak_acceleration(rig, rig.pose(made.clip), clip.frame_time)
    assert peak_acceleration(rig, rig.pose(after), clip.frame_time) <= 2.0 * clean
    assert {plant.outcome for plant in found.plants} <= {"kept", "pinned", "partly"}


@pytest.mark.parametrize("artefact", ["sunk", "floating"])
def test_a_sunk_or_floating_figure_is_lifted_as_a_whole_and_says_so(artefact: str) -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    after, found = cleaned(ARTEFACTS[artefact](made.clip), rig, made.contacts)
    up = 0.03 if artefact == "sunk" else -0.03
    assert np.allclose(found.correction.root_shift, [0.0, up, 0.0], atol=1e-4)
    (note,) = (note for note in found.notes if note.id == "height-moved")
    assert ("raised" if up > 0.0 else "lowered") in note.text and "30 mm" in note.text
    assert largest_turn(made.clip, after, rig) < 0.1
    level = [np.median(point(after, rig, leg, TOE)[:, 1][made.contacts.mask()[:, 1 + 2 * leg]]) for leg in (0, 1)]
    assert np.ptp(level) < 1e-4
    kept, told = cleaned(ARTEFACTS[artefact](made.clip), rig, made.contacts, EnforceParams(heights="keep"))
    assert same(kept, ARTEFACTS[artefact](made.clip)) and not told.notes


@pytest.mark.parametrize(("kind", "method"), [*((kind, "ik") for kind in KINDS), ("four bones", "both")])
def test_legs_of_all_kinds_stand(kind: str, method: Method) -> None:
    made = walk(duration=2.0)
    clip, rig = changed(kind, wandering(made), rig_of(made))
    after, found = cleaned(clip, rig, made.contacts, EnforceParams(method=method))
    before, now = strays(clip, rig, made.contacts), strays(after, rig, made.contacts)
    assert np.median(before["toe"]) > 8.0
    assert np.percentile(now["toe"], 95) <= 1.5 and np.percentile(now["heel"], 95) <= 2.0
    moved = {joint for leg in rig.legs for joint in (leg.hip, leg.knee, leg.ankle, leg.toe)} - {None}
    if kind in ("no toes", "stiff toes", "bare toes"):
        moved -= {leg.toe for leg in rig.legs}
    turned = set(np.flatnonzero(np.any(after.rotations != clip.rotations, axis=(0, 2))).tolist())
    assert turned == moved and set(found.correction.joints) == moved


@pytest.mark.parametrize(("method", "solver"), WAYS)
def test_every_way_to_hold_holds(method: Method, solver: Solver) -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    clip = artefacts.scale_root(made.clip, 1.08, height=False)
    after, found = cleaned(clip, rig, made.contacts, EnforceParams(method=method, solver=solver))
    before, now = strays(clip, rig, made.contacts), strays(after, rig, made.contacts)
    assert np.median(now["toe"]) < 0.5 * np.median(before["toe"])
    if method != "root":
        assert max(now["toe"]) < 6.0
    else:
        assert not found.correction.joints
        assert np.array_equal(after.rotations, clip.rotations)
    assert [plant.id for plant in found.plants] == list(range(sum(len(e.contacts) for e in made.contacts.effectors)))
    # only legs and the root's place change
    legs = {joint for leg in rig.legs for joint in (*leg.chain, leg.toe)}
    others = [joint for joint in range(len(clip.skeleton)) if joint not in legs]
    assert np.array_equal(after.rotations[:, others], clip.rotations[:, others])
    assert np.array_equal(after.positions[:, 1:], clip.positions[:, 1:])
    assert not same(after, clip)


def test_both_shares_between_root_and_legs() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    clip = artefacts.scale_root(made.clip, 1.1, height=False)
    turned = {}
    for method in ("ik", "both"):
        after, found = cleaned(clip, rig, made.contacts, EnforceParams(method=method))  # type: ignore[arg-type]
        turned[method] = largest_turn(clip, after, rig), np.abs(found.correction.root_shift).max()
    assert turned["both"][0] < turned["ik"][0] and turned["both"][1] > 1.5 * turned["ik"][1]


def test_stiff_toes_bend_rather_than_enter_the_floor() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    stiff = made.clip.rotations.copy()
    for leg in rig.legs:
        stiff[:, leg.toe] = [0.0, 0.0, 0.0, 1.0]
    clip = replace(made.clip, rotations=stiff)
    clip = wandering(replace(made, clip=clip))
    after, _ = cleaned(clip, rig, made.contacts)
    for leg in (0, 1):
        planted = made.contacts.mask()[:, 1 + 2 * leg]
        deep, now = (point(each, rig, leg, TIP)[planted, 1].min() for each in (clip, after))
        assert deep < -0.02 and now > deep + 0.003
    assert np.percentile(strays(after, rig, made.contacts)["toe"], 95) < 2.0


def test_straight_knees_stay_as_straight_and_no_straighter() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    clip = artefacts.scale_root(made.clip, 1.1, height=False)
    after, _ = cleaned(clip, rig, made.contacts)
    assert np.all(straightness(after, rig) <= straightness(clip, rig).max(axis=0) + 2e-4)


# ---- nothing to do is nothing done ------------------------------------------------------------------


@pytest.mark.parametrize("gait", GAITS)
def test_what_stands_well_is_left_alone(gait: str) -> None:
    made = walk(gait, duration=2.0)
    found = enforce(made.clip, rig_of(made), made.contacts, EnforceParams())
    assert not found.correction.root_shift.any() and found.correction.joints == ()
    assert {plant.outcome for plant in found.plants} == {"kept"}
    assert all(plant.reason == "" and plant.residual < 0.002 for plant in found.plants)
    assert not found.notes and not found.ground.any()


@pytest.mark.parametrize("artefact", ["wander", "larger", "shaken", "sunk"])
@pytest.mark.parametrize("method", ["ik", "root"])
def test_cleaning_a_cleaned_clip_changes_little(artefact: str, method: Method) -> None:
    if method == "root" and artefact == "shaken":
        pytest.skip("the root alone cannot still feet that shake")
    made = walk(duration=2.0)
    rig = rig_of(made)
    once, _ = cleaned(ARTEFACTS[artefact](made.clip), rig, made.contacts, EnforceParams(method=method))
    twice, _ = cleaned(once, rig, made.contacts, EnforceParams(method=method))
    for leg in (0, 1):
        assert np.abs(point(once, rig, leg, TOE) - point(twice, rig, leg, TOE)).max() <= 0.003


def test_a_clip_without_contacts_needs_nothing() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    found = enforce(wandering(made), rig, rig.no_contacts(made.clip), EnforceParams())
    assert found.plants == () and not found.correction.root_shift.any() and found.correction.joints == ()


def test_away_from_contacts_frames_keep_their_very_numbers() -> None:
    made = walk("stand", 30.0, 14.0)
    rig = rig_of(made)
    effectors = tuple(replace(e, contacts=(Contact(200, 220),)) for e in made.contacts.effectors)
    clip = artefacts.drift(made.clip, 0.60)
    after, found = cleaned(clip, rig, replace(made.contacts, effectors=effectors))
    assert {plant.outcome for plant in found.plants} == {"pinned"}
    at = np.flatnonzero(changes(clip, after).any(axis=1))
    assert 30 < at[0] <= 200 and 219 <= at[-1] < 390
    fixed = replace(clip, skeleton=replace(clip.skeleton, translates=np.zeros(len(clip.skeleton), dtype=bool)))
    after, _ = cleaned(fixed, rig, replace(made.contacts, effectors=effectors))
    at = np.flatnonzero(changes(fixed, after).any(axis=1))
    assert 100 < at[0] <= 200 and 219 <= at[-1] < 320


@pytest.mark.parametrize("strength", [0.0, 0.5])
@pytest.mark.parametrize(("method", "solver"), WAYS)
def test_no_strength_no_change_and_half_strength_half_way(method: Method, solver: Solver, strength: float) -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    clip = wandering(made)
    after, found = cleaned(clip, rig, made.contacts, EnforceParams(strength=strength, method=method, solver=solver))
    if strength == 0.0:
        for joint in range(len(clip.skeleton)):
            turned = rotation.multiply(rotation.inverse(clip.rotation(joint)), after.rotation(joint))
            assert rotation.angle(turned).max() < 1e-6
        assert np.array_equal(after.positions, clip.positions)
    else:
        whole, _ = cleaned(clip, rig, made.contacts, EnforceParams(method=method, solver=solver))
        for leg in (0, 1):
            a, b, c = (point(each, rig, leg, TOE) for each in (clip, after, whole))
            assert np.abs(b - 0.5 * (a + c)).max() < 0.003
    if solver == "whole_clip" and strength == 0.0:
        assert same(after, clip) and found.correction.joints == ()


def test_half_strength_lifts_half_way() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    after, found = cleaned(artefacts.sink(made.clip, 0.03), rig, made.contacts, EnforceParams(strength=0.5))
    assert np.allclose(found.correction.root_shift, [0.0, 0.015, 0.0], atol=1e-4)
    assert heights(after, rig, made.contacts).min() == pytest.approx(-15.0, abs=0.5)


def test_of_a_figure_that_is_lifted_half_way_it_is_told_where_its_feet_stand() -> None:
    made = walk(duration=2.0)
    _, found = cleaned(artefacts.sink(made.clip, 0.03), rig_of(made), made.contacts, EnforceParams(strength=0.5))
    assert [plant.target[1] for plant in found.plants] == pytest.approx([-0.015] * len(found.plants), abs=1e-3)


@pytest.mark.parametrize("solver", ["glardon", "kim_neff"])
def test_what_is_said_to_be_lifted_is_lifted(solver: Solver) -> None:
    made = walk(duration=2.0)
    _, found = cleaned(artefacts.sink(made.clip, 0.03), rig_of(made), made.contacts, EnforceParams(solver=solver))
    said = any(note.id == "height-moved" for note in found.notes)
    assert bool(found.correction.root_shift.any()) is said


# ---- symmetries -------------------------------------------------------------------------------------


def test_turned_and_shifted_clips_give_the_turned_and_shifted_result() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    clip = wandering(made)
    plain, one = cleaned(clip, rig, made.contacts)
    for heading, shift in ((1.2, (3.0, -2.0)), (np.pi / 2, (0.0, 0.0)), (-2.5, (100.0, 5.0))):
        found, other = cleaned(artefacts.turned(clip, heading, shift), rig, made.contacts)
        expected = artefacts.turned(plain, heading, shift)
        assert np.allclose(found.positions[:, 0], expected.positions[:, 0], atol=1e-5)
        assert largest_turn(found, expected, rig) < 0.01
        assert [p.outcome for p in other.plants] == [p.outcome for p in one.plants]


def test_a_mirrored_clip_gives_the_mirrored_result() -> None:
    made = walk("turn")
    rig = rig_of(made)
    clip = wandering(made)
    plain, one = cleaned(clip, rig, made.contacts)
    swapped = tuple(made.contacts.effectors[e] for e in (2, 3, 0, 1))
    names = tuple(replace(e, name=o.name) for e, o in zip(swapped, made.contacts.effectors, strict=True))
    found, other = cleaned(artefacts.mirrored(clip), rig, replace(made.contacts, effectors=names))
    expected = artefacts.mirrored(plain)
    assert np.allclose(found.positions[:, 0], expected.positions[:, 0], atol=1e-5)
    assert largest_turn(found, expected, rig) < 0.01
    left = {(p.part, p.start, p.outcome) for p in one.plants if p.leg == 0}
    assert left == {(p.part, p.start, p.outcome) for p in other.plants if p.leg == 1}


def test_a_giant_that_walks_as_giants_do_is_cleaned_like_a_child() -> None:
    """Twice as large in sqrt(2) times the time: accelerations of places are the same."""
    made = walk(duration=2.0)
    rig = rig_of(made)
    clip = wandering(made)
    soles = tuple(replace(s, offset=tuple(2.0 * v for v in s.offset)) for s in rig.soles)
    giant_rig = replace(rig, soles=soles, leg_length=2.0 * rig.leg_length, floor=2.0 * rig.floor)
    giant = replace(artefacts.scaled(clip, 2.0), frame_time=np.sqrt(2.0) * clip.frame_time)
    plain, _ = cleaned(clip, rig, made.contacts)
    after, _ = cleaned(giant, giant_rig, replace(made.contacts, frame_time=giant.frame_time))
    assert np.median(strays(after, giant_rig, made.contacts)["toe"]) < 1.0
    assert np.abs(0.5 * after.positions[:, 0] - plain.positions[:, 0]).max() < 0.01


def test_frame_rates_give_nearly_the_same() -> None:
    results = []
    for fps in (60.0, 120.0):
        made = walk("walk", fps)
        rig = rig_of(made)
        after, _ = cleaned(artefacts.scale_root(made.clip, 1.08, height=False), rig, made.contacts)
        slid = strays(after, rig, made.contacts)
        assert np.percentile(slid["toe"], 95) <= 1.0
        results.append((point(after, rig, 0, TOE), after.positions[:, 0], rig))
    (slow, root, _), (fast, fast_root, _) = results
    assert np.linalg.norm(fast[::2] - slow, axis=1).max() < 0.012
    assert np.linalg.norm(fast_root[::2] - root, axis=1).max() < 0.006


@pytest.mark.parametrize("fps", [24.0, 30.0, 240.0])
def test_other_frame_rates_hold_as_well(fps: float) -> None:
    made = walk("walk", fps)
    rig = rig_of(made)
    after, _ = cleaned(artefacts.scale_root(made.clip, 1.08, height=False), rig, made.contacts)
    slid = strays(after, rig, made.contacts)  # of few frames contacts are too short to hold
    assert np.percentile(slid["toe"], 75) <= 2.2 and np.percentile(slid["heel"], 75) <= 2.5


# ---- what is asked for ------------------------------------------------------------------------------


def with_toes(contacts: Contacts, made: tuple[Contact, ...]) -> Contacts:
    """The contacts with others of the left toe."""
    effectors = list(contacts.effectors)
    effectors[1] = replace(effectors[1], contacts=made)
    return replace(contacts, effectors=tuple(effectors))


@pytest.mark.parametrize(("wish", "within"), [(None, 0.004), ("force", 0.001)])
def test_forbidden_contacts_are_none_and_places_asked_for_are_taken(wish: None, within: float) -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    first, second, *others = made.contacts.effectors[1].contacts
    where = made.tracks[1][second.start]
    asked = (float(where[0]) + 0.02, 0.0, float(where[2]))
    contacts = with_toes(
        made.contacts, (replace(first, wish="forbid"), replace(second, position=asked, wish=wish), *others)
    )
    after, found = cleaned(made.clip, rig, contacts)
    assert not [p for p in found.plants if p.name == "left_toe" and p.start == first.start]
    track = point(after, rig, 0, TOE)[second.start : second.end]
    assert np.abs(track[:, [0, 2]] - [asked[0], asked[2]]).max() < within
    (plant,) = (p for p in found.plants if p.name == "left_toe" and p.start == second.start)
    assert plant.asked == asked and np.allclose(plant.target, asked, atol=within)


def test_a_plant_that_was_brought_elsewhere_was_not_kept() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    _, second, *_ = made.contacts.effectors[1].contacts
    where = made.tracks[1][second.start]
    asked = (float(where[0]) + 0.02, 0.0, float(where[2]))
    _, found = cleaned(made.clip, rig, with_toes(made.contacts, (replace(second, position=asked),)))
    (plant,) = (p for p in found.plants if p.name == "left_toe")
    assert plant.outcome == "pinned"


def test_what_is_forced_is_held_whatever_it_costs() -> None:
    made = walk("stand", duration=3.0)
    rig = rig_of(made)
    clip = artefacts.drift(made.clip, 1.2)
    cheap = EnforceParams(costs=CostParams(slide=20.0))
    strays_of = {}
    for wish in (None, "force"):
        contact = Contact(40, 120, 0.3, wish=wish)  # type: ignore[arg-type]
        contacts = replace(made.contacts, method="auto", effectors=tuple(
            replace(e, contacts=(contact,) if e.name == "left_toe" else (Contact(0, len(clip), 0.3),))
            for e in made.contacts.effectors
        ))  # fmt: skip
        _, found = cleaned(clip, rig, contacts, cheap)
        (plant,) = (plant for plant in found.plants if plant.name == "left_toe")
        strays_of[wish] = plant.residual
        assert plant.force is (wish == "force")
    assert strays_of["force"] < 0.02 and strays_of[None] > 0.05


def test_labels_as_a_detector_wrote_them_are_taken_as_a_detectors() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.05)
    unsure = tuple(
        replace(e, contacts=tuple(replace(c, confidence=0.9) for c in e.contacts)) for e in made.contacts.effectors
    )
    detected = replace(made.contacts, method="auto", effectors=unsure)
    after, found = cleaned(clip, rig, detected)
    read, again = cleaned(clip, rig, replace(detected, method="labels"))
    assert found.plants == again.plants and same(after, read)


def test_heights_are_kept_where_that_is_asked_for() -> None:
    made = walk("stand")
    rig = rig_of(made)
    clip = wandering(made)
    up = clip.positions.copy()
    up[:, 0, 1] += 0.012 * np.sin(np.arange(len(clip)) * 0.03)
    clip = replace(clip, positions=up)
    level = {}
    for how in ("floor", "keep"):
        after, _ = cleaned(clip, rig, made.contacts, EnforceParams(heights=how))  # type: ignore[arg-type]
        assert max(strays(after, rig, made.contacts)["toe"]) < 2.0
        level[how] = point(after, rig, 0, TOE)[:, 1]
    captured = point(clip, rig, 0, TOE)[:, 1]
    assert np.ptp(level["floor"]) < 0.6 * np.ptp(captured)
    assert abs(np.median(level["keep"]) - np.median(captured)) < 0.012


def test_heights_that_are_kept_are_kept_in_every_frame() -> None:
    made = walk("stand")
    rig = rig_of(made)
    up = wandering(made).positions.copy()
    up[:, 0, 1] += 0.012 * np.sin(np.arange(len(up)) * 0.03)
    clip = replace(made.clip, positions=up)
    after, _ = cleaned(clip, rig, made.contacts, EnforceParams(heights="keep"))
    assert np.abs(point(after, rig, 0, TOE)[:, 1] - point(clip, rig, 0, TOE)[:, 1]).max() < 0.004


def test_toes_turn_out_as_asked() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    after, _ = cleaned(made.clip, rig, made.contacts, EnforceParams(style=StyleParams(toe_out={"left": 15.0})))
    flat = made.contacts.mask()[:, :2].all(axis=1)
    before, now = (
        np.unwrap(np.arctan2(*(point(each, rig, 0, TOE) - point(each, rig, 0, HEEL))[flat][:, [0, 2]].T))
        for each in (made.clip, after)
    )
    assert np.allclose(np.degrees(now - before), 15.0, atol=1.0)
    right = rig.tracks(rig.pose(after))[3] - rig.tracks(rig.pose(made.clip))[3]
    assert np.abs(right[made.contacts.mask()[:, 3]]).max() < 0.003


@pytest.mark.parametrize("side", ["left", "right"])
def test_feet_are_put_aside_as_asked(side: str) -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    leg = 0 if side == "left" else 1
    wish = dict.fromkeys((f"{side}_heel", f"{side}_toe"), (0.03, 0.0, 0.02))
    after, found = cleaned(made.clip, rig, made.contacts, EnforceParams(style=StyleParams(offset=wish)))
    planted = made.contacts.mask()[:, 2 * leg : 2 * leg + 2].all(axis=1)
    moved = (point(after, rig, leg, TOE) - point(made.clip, rig, leg, TOE))[planted]
    ahead = (point(made.clip, rig, leg, TOE) - point(made.clip, rig, leg, HEEL))[planted] * [1.0, 0.0, 1.0]
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    outwards = np.cross([0.0, 1.0, 0.0], ahead) * (1.0 if side == "left" else -1.0)
    assert np.allclose(np.sum(moved * ahead, axis=1), 0.02 * rig.leg_length, atol=0.004)
    assert np.allclose(np.sum(moved * outwards, axis=1), 0.03 * rig.leg_length, atol=0.004)
    assert all((p.asked is not None) is (p.leg == leg) for p in found.plants)


def test_feet_that_are_put_aside_stay_on_the_floor() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    wish = dict.fromkeys(("left_heel", "left_toe"), (0.03, 0.0, 0.0))
    after, _ = cleaned(made.clip, rig, made.contacts, EnforceParams(style=StyleParams(offset=wish)))
    rise = (point(after, rig, 0, TOE) - point(made.clip, rig, 0, TOE))[made.contacts.mask()[:, 1], 1]
    assert np.abs(rise).max() < 0.004


# ---- grounds ----------------------------------------------------------------------------------------


def test_a_treadmill_is_no_skate() -> None:
    made = walk("treadmill")
    rig = rig_of(made)
    after, found = cleaned(made.clip, rig, made.contacts)
    assert [note.id for note in found.notes] == ["in-place"]
    assert same(after, made.clip)
    ride = np.arange(len(after))[:, None] * after.frame_time * np.array(made.belt)
    assert np.allclose(found.ground, ride, atol=1e-6)
    shaken, again = cleaned(artefacts.wander(made.clip, 0.03, slowest=1.0), rig, made.contacts)
    slid = strays(shaken, rig, made.contacts, again.ground)
    assert np.percentile(slid["toe"], 95) < 1.0
    assert np.allclose(again.ground, ride, atol=0.1)


def test_stairs_keep_their_levels() -> None:
    made = walk("stairs", duration=4.0)
    rig = rig_of(made)
    after, found = cleaned(artefacts.wander(made.clip, 0.04, slowest=1.0), rig, made.contacts)
    for plant in found.plants:
        assert abs(plant.target[1] - made.tracks[plant.effector][plant.start, 1]) < 0.004
    assert np.percentile(strays(after, rig, made.contacts)["toe"], 95) < 1.0


def test_a_foot_that_turns_on_its_ball_keeps_turning() -> None:
    made = walk("stand")
    rig = rig_of(made)
    angle = np.radians(60.0) * np.linspace(0.0, 1.0, len(made.clip))
    turn = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), angle)
    about = point(made.clip, rig, 0, TOE)[0]
    positions, rotations = made.clip.positions.copy(), made.clip.rotations.copy()
    positions[:, 0] = about + rotation.rotate(turn, positions[:, 0] - about)
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    clip = replace(made.clip, positions=positions, rotations=rotations)
    contacts = replace(made.contacts, method="auto", effectors=tuple(
        replace(e, contacts=(Contact(0, len(clip), 0.9),) if e.name == "left_toe" else ())
        for e in made.contacts.effectors
    ))  # fmt: skip
    after, found = cleaned(clip, rig, contacts)
    assert same(after, clip) and found.plants[0].outcome == "kept"


# ---- corrections ------------------------------------------------------------------------------------


def test_a_shift_in_the_world_is_one_in_the_frame_of_the_roots_parent() -> None:
    """Many files have a joint above the one that carries the figure, turned and moved as it likes."""
    made = walk(duration=2.0)
    skeleton, frames = made.clip.skeleton, len(made.clip)
    above = Skeleton(
        names=("World", *skeleton.names), parents=np.append(-1, skeleton.parents + 1),
        offsets=np.concatenate([np.zeros((1, 3)), skeleton.offsets]), end_parents=skeleton.end_parents + 1,
        end_offsets=skeleton.end_offsets, translates=np.append([True, True], np.zeros(len(skeleton) - 1, dtype=bool)),
    )  # fmt: skip
    t = np.arange(frames) / frames
    turn = rotation.from_rotation_vector(np.stack([0.4 * t, 2.0 * t - 0.7, 0.3 + 0.0 * t], axis=1))
    positions = np.concatenate([np.zeros((frames, 1, 3)), made.clip.positions], axis=1)
    rotations = np.concatenate([turn[:, None], made.clip.rotations], axis=1)
    clip = Clip(above, positions, rotations, made.clip.frame_time)
    shift = np.stack([0.05 * np.sin(9.0 * t), 0.02 * t, 0.03 + 0.0 * t], axis=1)
    shift[:40] = 0.0
    after = apply(clip, Correction(1, shift, (), np.zeros((frames, 0, 4))))
    assert np.allclose(forward(after).positions[:, 1:] - forward(clip).positions[:, 1:], shift[:, None], atol=1e-12)
    assert np.array_equal(after.positions[:40], clip.positions[:40])
    assert np.array_equal(after.positions[:, 2:], clip.positions[:, 2:])
    assert apply(clip, Correction(1, 0.0 * shift, (), np.zeros((frames, 0, 4)))) is clip


# ---- files that lack something ----------------------------------------------------------------------


def test_a_leg_that_the_file_cannot_turn_is_released_and_said() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    rotates = np.ones(len(made.clip.skeleton), dtype=bool)
    rotates[rig.legs[0].knee] = False
    clip = replace(artefacts.drift(made.clip, 0.05), skeleton=replace(made.clip.skeleton, rotates=rotates))
    after, found = cleaned(clip, rig, made.contacts)
    left = [plant for plant in found.plants if plant.leg == 0 and plant.outcome not in ("kept", "pinned")]
    assert left and all(plant.outcome == "released" and "channels" in plant.reason for plant in left)
    turned = set(np.flatnonzero(np.any(after.rotations != clip.rotations, axis=(0, 2))).tolist())
    assert turned == {*rig.legs[1].chain, rig.legs[1].toe}
    assert np.percentile([1000.0 * p.residual for p in found.plants if p.leg == 1], 90) < 2.0


def test_a_root_that_cannot_move_stays_and_the_legs_hold() -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    fixed = replace(made.clip.skeleton, translates=np.zeros(len(made.clip.skeleton), dtype=bool))
    for artefact in ("wander", "sunk"):
        clip = replace(ARTEFACTS[artefact](made.clip), skeleton=fixed)
        for method in ("ik", "both"):
            after, found = cleaned(clip, rig, made.contacts, EnforceParams(method=method))  # type: ignore[arg-type]
            assert not found.correction.root_shift.any() and np.array_equal(after.positions, clip.positions)
            assert np.percentile(strays(after, rig, made.contacts)["toe"], 95) < 2.0


@pytest.mark.parametrize(("method", "solver"), WAYS)
@pytest.mark.parametrize("frames", [1, 2, 3, 5])
def test_a_handful_of_frames_is_no_trouble(method: Method, solver: Solver, frames: int) -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    clip = artefacts.drift(made.clip, 1.0).frames(slice(0, frames))
    whole = replace(made.contacts, frames=frames).with_mask(np.ones((frames, 4), dtype=bool))
    after, found = cleaned(clip, rig, whole, EnforceParams(method=method, solver=solver))
    assert np.isfinite(after.positions).all() and np.isfinite(after.rotations).all()
    assert len(found.plants) == 4


@pytest.mark.parametrize(("method", "solver", "what"), [
    (*way, what) for k, what in enumerate(("teleport", "spike", "frozen", "huge"))
    for n, way in enumerate(WAYS) if n in (0, 1 + k, 1 + (k + 1) % 4)
])  # fmt: skip
def test_teleports_and_spikes_leave_numbers(method: Method, solver: Solver, what: str) -> None:
    made = walk(duration=2.0)
    rig = rig_of(made)
    positions, clip = made.clip.positions.copy(), made.clip
    if what == "teleport":
        positions[90:, 0] += [4.0, 0.5, -3.0]
    elif what == "huge":
        positions[70, 0] += 1e5
    clip = replace(clip, positions=positions)
    if what == "spike":
        clip = artefacts.spikes(clip, 170.0, 40)
    elif what == "frozen":
        clip = clip.frames(np.where(np.arange(len(clip)) < 60, np.arange(len(clip)), 60))
    after, found = cleaned(clip, rig, made.contacts, EnforceParams(method=method, solver=solver))
    assert np.isfinite(after.positions).all() and np.isfinite(after.rotations).all()
    assert np.allclose(np.linalg.norm(after.rotations, axis=2), 1.0, atol=1e-9)
    assert all(np.isfinite([*plant.target, plant.residual]).all() for plant in found.plants)


def test_a_spike_is_not_felt_far_away() -> None:
    """A knee that is wrong by 50 degrees in one frame, while its foot is planted."""
    made = walk(duration=3.0)
    rig = rig_of(made)
    clip = artefacts.scale_root(made.clip, 1.08, height=False)
    rotations = clip.rotations.copy()
    knee = rig.legs[0].knee
    turn = rotation.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.radians(50.0))
    rotations[150, knee] = rotation.multiply(rotations[150, knee], turn)
    plain, _ = cleaned(clip, rig, made.contacts)
    spiked, found = cleaned(replace(clip, rotations=rotations), rig, made.contacts)
    off = np.linalg.norm(point(plain, rig, 0, TOE) - point(spiked, rig, 0, TOE), axis=1)
    assert off[:60].max() < 0.04
    assert np.linalg.norm(found.correction.root_shift, axis=1).max() < 0.15  # nor does the root go far for it


def test_where_a_pose_was_cut_off_the_correction_starts_small() -> None:
    made = walk("stand", duration=3.0)
    rig = rig_of(made)
    positions = made.clip.positions.copy()
    positions[:, 0, 0] += 0.03 * np.exp(-np.arange(len(made.clip)) / 20.0)
    clip = replace(made.clip, positions=positions)
    sizes = {}
    for cut in ((False, False), (True, False)):
        found = enforce(clip, rig, replace(made.contacts, method="auto"), EnforceParams(), cut=cut)
        shift = np.linalg.norm(found.correction.root_shift[0])
        turns = [
            rotation.angle(rotation.multiply(rotation.inverse(clip.rotation(j)), found.correction.rotations[:, k]))[0]
            for k, j in enumerate(found.correction.joints)
        ]
        sizes[cut[0]] = float(shift), float(np.degrees(max(turns)))
    assert sizes[True][1] < 0.9 * sizes[False][1] and sizes[True][1] < 2.8
    assert sizes[True][0] < 0.004


def test_contacts_at_the_very_ends_are_held_to_the_ends() -> None:
    made = walk("stand")
    rig = rig_of(made)
    clip = wandering(made)
    after, _ = cleaned(clip, rig, made.contacts)
    assert max(slides(clip, rig, made.contacts)["heel"]) > 10.0
    toe = point(after, rig, 0, TOE)[:, [0, 2]]
    assert np.linalg.norm(toe[[0, -1]] - toe[len(toe) // 2], axis=1).max() < 0.001

"""What becomes of footplants: told from tracks that are made by hand."""

from __future__ import annotations

import re
from dataclasses import replace

import artefacts
import numpy as np
import pytest
from legmaker import Figure, figure_of
from walks import cleaned, rig_of
from walks import short_walk as walk

from footfix.enforce.footing import Footing
from footfix.enforce.footplant import Footplant
from footfix.enforce.leg import HEEL, TOE, LegTracks
from footfix.enforce.outcomes import CorrectedLeg, outcomes
from footfix.enforce.params import EnforceParams
from footfix.enforce.standing_heights import Floors
from footfix.enforce.task import pose_of
from footfix.motion.clip import Floats
from footfix.motion.contacts import Contact

FRAMES = 100
DT = 1.0 / 60.0


def still() -> Figure:
    made = walk("stand", 60.0, 2.0)
    return figure_of(made.clip.frames(np.zeros(FRAMES, dtype=int)), rig_of(made), replace(made.contacts, frames=FRAMES))


def told(
    shift: Floats, *, keep: bool = False, ground: Floats | None = None, part: str = "toe", turns: bool = True,
    span: tuple[int, int] = (20, 80), rest: float | None = None,
) -> Footplant:  # fmt: skip
    """What is said of a left plant whose point is shifted over the floor by (F, 3) [m]."""
    made = still()
    legs: list[LegTracks] = [replace(leg, turns=turns) for leg in made.legs]
    after = [
        CorrectedLeg(leg.hip, leg.ankle + shift.T, leg.place(HEEL) + shift.T, leg.place(TOE) + shift.T) for leg in legs
    ]
    e = 0 if part == "heel" else 1
    plant = Footplant(0, e, f"left_{part}", 0, part, *span)  # type: ignore[arg-type]
    usual = float(legs[0].place(HEEL if part == "heel" else TOE)[1, 0])
    floors = Floors(np.full(4, usual if rest is None else rest), np.zeros(2), (usual,))
    moves = np.zeros((FRAMES, 3)) if ground is None else ground
    (found,) = outcomes(Footing((plant,), floors, moves, (keep,), (False,)), legs, after, made.rig, DT)
    assert replace(found, target=plant.target, outcome=plant.outcome, reason="", residual=0.0, held=()) == plant
    return found


def slid(distance: float, first: int, last: int) -> Floats:
    """(F, 3) [m] a slide of so far, evenly from one frame to another."""
    way = np.interp(np.arange(FRAMES), [first, last], [0.0, distance])
    return np.asarray(way[:, None] * [0.6, 0.0, 0.8])


def own_place(part: int = TOE) -> Floats:
    return np.asarray(still().legs[0].place(part)[:, 0])


def test_what_does_not_move_is_pinned_where_it_stands() -> None:
    for part, point in (("toe", TOE), ("heel", HEEL)):
        found = told(np.tile([0.02, 0.0, 0.01], (FRAMES, 1)), part=part)
        assert (found.outcome, found.reason, found.held) == ("pinned", "", ((20, 80),))
        assert found.residual == pytest.approx(0.0, abs=1e-12)
        place = own_place(point) + [0.02, 0.0, 0.01]
        assert found.target == pytest.approx((place[0], still().rig.floor, place[2]))  # of the sole, not of the joint


def test_on_a_step_the_target_is_as_high_as_the_step() -> None:
    rest = float(own_place()[1])
    found = told(np.tile([0.0, 0.2, 0.0], (FRAMES, 1)), rest=rest)
    assert found.target[1] == pytest.approx(still().rig.floor + 0.2)


def test_what_stays_as_it_was_is_kept() -> None:
    found = told(slid(0.05, 20, 79), keep=True)
    assert (found.outcome, found.reason) == ("kept", "at rest in 0 of 59 frames")
    assert told(slid(0.0, 20, 79), keep=True).reason == ""
    assert found.residual == pytest.approx(0.025, rel=0.05)


def test_what_stands_in_most_frames_is_partly_held_and_says_where() -> None:
    found = told(slid(0.04, 30, 40))
    assert found.outcome == "partly" and found.held == ((20, 31), (40, 80))
    assert found.residual == pytest.approx(0.04)  # from where it stands most of the time
    assert found.reason.startswith("at rest in 49 of 59 frames")
    x, _, z = own_place() + [0.024, 0.0, 0.032]
    assert (found.target[0], found.target[2]) == pytest.approx((x, z))


def test_what_slides_in_most_frames_is_released_and_says_why() -> None:
    found = told(slid(0.10, 22, 75))
    assert found.outcome == "released" and found.held == ((20, 23), (75, 80))
    assert "at rest in only 6 of 59 frames" in found.reason and "the left knee would turn" in found.reason
    assert not found.reason.endswith(".")
    everywhere = told(slid(0.10, 0, 99))
    assert everywhere.outcome == "released" and everywhere.held == ()
    assert everywhere.residual == pytest.approx(0.5 * 0.10 * 59 / 99, rel=1e-6)


def bend(distance: Floats, leg: LegTracks) -> Floats:
    """[degrees] flexion of a knee whose hip and ankle are so far apart."""
    thigh, shank = (float(np.linalg.norm(each[:, 0])) for each in (leg.thigh, leg.shank))
    return np.degrees(np.arccos((distance**2 - thigh**2 - shank**2) / (2.0 * thigh * shank)))


def test_what_holding_throughout_would_ask_of_the_knee_is_said_with_its_frame() -> None:
    """An ankle that goes straight away from below its hip and is to come back to there: by the law of cosines."""
    made = still()
    leg = made.legs[0]
    below = (leg.hip - leg.ankle)[:, 0]
    shift = np.zeros((FRAMES, 3))
    shift[:, [0, 2]] = np.array([0.0, -0.05])  # behind the hip by some
    shift[60:, 2] -= 0.06  # from frame 60 on: most of its frames before that
    said = re.findall(r"left knee would turn (\d+) degrees/s faster at frame (\d+)", told(shift).reason)
    speed, frame = (float(number) for number in said[0])
    # held where it stood at first it comes back to its way in 0.1 s, once the plant ends
    ease = round(0.1 / DT)
    back = shift[:ease + 2] - below
    back[:, 2] = np.linspace(shift[59, 2], shift[60, 2], ease + 2) - below[2]
    expected = np.abs(np.diff(bend(np.linalg.norm(back, axis=1), leg))) / DT
    assert expected[:-1].min() * 0.98 < speed < expected.max() * 1.02
    assert 80 <= frame <= 80 + ease


def test_a_leg_that_would_be_too_short_says_by_how_much() -> None:
    """It stands a metre away from its hip for most of its frames, and comes back under it."""
    leg = still().legs[0]
    shift = np.zeros((FRAMES, 3))
    shift[:60, 2] = 1.0
    reach = sum(float(np.linalg.norm(each[:, 0])) for each in (leg.thigh, leg.shank))
    lacks = float(np.linalg.norm((leg.ankle - leg.hip)[:, 0] + [0.0, 0.0, 1.0])) - reach
    assert lacks > 0.2 and f"the leg would be {1000.0 * lacks:.0f} mm too short" in told(shift).reason


def test_a_leg_in_reach_of_what_it_lacks_is_not_too_short() -> None:
    """An ankle too far away from its hip in the middle of a plant, which holding it would bring back."""
    shift = np.zeros((FRAMES, 3))
    shift[40:45, 2] = 1.0  # out of reach, five frames of sixty
    found = told(shift)
    assert found.outcome == "partly" and "too short" not in found.reason
    leg = still().legs[0]
    reach = sum(float(np.linalg.norm(each[:, 0])) for each in (leg.thigh, leg.shank))
    assert float(np.linalg.norm((leg.ankle - leg.hip)[:, 0] + shift[40])) > reach + 0.2


def test_a_leg_that_cannot_turn_says_so() -> None:
    found = told(slid(0.04, 30, 40), turns=False)
    assert found.outcome == "released" and "rotation channels" in found.reason
    assert told(0.0 * slid(0.04, 30, 40), turns=False).outcome == "pinned"


def test_a_short_stray_is_none() -> None:
    leg = still().rig.leg_length
    assert told(slid(0.004 * leg, 30, 34)).outcome == "pinned"
    assert told(slid(0.02 * leg, 30, 34)).outcome == "partly"


def test_up_and_down_is_no_slide() -> None:
    up = np.zeros((FRAMES, 3))
    up[:, 1] = 0.05 * np.sin(np.arange(FRAMES) / 5.0)
    found = told(up)
    assert found.outcome == "pinned" and found.residual < 1e-12 and found.held == ((20, 80),)


def test_on_a_belt_what_goes_along_stands() -> None:
    belt = np.arange(FRAMES)[:, None] * np.array([0.01, 0.0, 0.0])
    found = told(belt, ground=belt)
    assert found.outcome == "pinned" and found.held == ((20, 80),)
    assert found.target[0] == pytest.approx(own_place()[0] + belt[50, 0])  # where the belt has it in its middle
    assert told(belt).outcome == "released"


@pytest.mark.parametrize("frames", [1, 2])
def test_contacts_of_a_frame_or_two_are_told_of_too(frames: int) -> None:
    found = told(slid(2.0, 0, 99), span=(50, 50 + frames))
    assert found.outcome == ("pinned" if frames == 1 else "released")
    assert np.isfinite(found.residual)


# ---- of what enforcement did ------------------------------------------------------------------------


@pytest.mark.parametrize("strength", [1.0, 0.5])
def test_what_is_said_is_what_the_clip_does(strength: float) -> None:
    made = walk("run")
    rig = rig_of(made)
    clip = artefacts.wander(made.clip, 0.08, slowest=0.6)
    sure = replace(made.contacts, method="auto")
    after, found = cleaned(clip, rig, sure, EnforceParams(strength=strength))
    pose = pose_of(after, rig)
    for plant in found.plants:
        joint = rig.legs[plant.leg].toe
        heel = rig.soles[plant.effector]
        track = pose.position(joint) if plant.part == "toe" else pose.point(heel.joint, np.array(heel.offset))  # type: ignore[arg-type]
        flat = track[plant.frames][:, [0, 2]]
        far = np.linalg.norm(flat - [plant.target[0], plant.target[2]], axis=1).max()
        assert plant.residual == pytest.approx(far, abs=1e-6)
        steps = np.linalg.norm(np.diff(track[:, [0, 2]], axis=0), axis=1) / clip.frame_time
        inside = np.zeros(len(clip), dtype=bool)
        for start, end in plant.held:
            assert plant.start <= start < end <= plant.end
            assert steps[start : end - 1].max() <= 0.05 * rig.leg_length + 1e-9
            inside[start:end] = True
        loose = ~(inside[1:] & inside[:-1])[plant.start : plant.end - 1]
        assert np.all(steps[plant.start : plant.end - 1][loose] > 0.05 * rig.leg_length - 1e-9)
        assert bool(plant.reason) is (plant.outcome in ("partly", "released")) or plant.outcome == "kept"
    assert {plant.outcome for plant in found.plants} & {"pinned", "partly", "released"}
    assert [plant.id for plant in found.plants] == list(range(len(found.plants)))


def test_a_slide_across_a_room_is_released_in_words() -> None:
    made = walk("stand")
    rig = rig_of(made)
    clip = artefacts.drift(made.clip, 2.5)
    contacts = replace(made.contacts, method="auto", effectors=tuple(
        replace(e, contacts=(Contact(20, len(clip) - 20, 0.9),)) for e in made.contacts.effectors
    ))  # fmt: skip
    _, found = cleaned(clip, rig, contacts)
    assert {plant.outcome for plant in found.plants} == {"released"}
    for plant in found.plants:
        assert "at rest in" in plant.reason and ("too short" in plant.reason or "faster" in plant.reason)


def test_a_slide_across_a_room_does_not_drag_the_root_along() -> None:
    made = walk("stand")
    rig = rig_of(made)
    _, found = cleaned(artefacts.drift(made.clip, 2.5), rig, made.contacts)
    assert np.linalg.norm(found.correction.root_shift, axis=1).max() < 0.25 * rig.leg_length


def test_a_stray_while_the_foot_lands_or_leaves_is_of_no_account() -> None:
    for frame in (20, 79):
        shift = np.zeros((FRAMES, 3))
        shift[frame, 0] = 0.05
        found = told(shift)
        assert (found.outcome, found.reason, found.residual) == ("pinned", "", pytest.approx(0.05))
    for frame in (21, 78):
        shift = np.zeros((FRAMES, 3))
        shift[frame, 0] = 0.05
        assert told(shift).outcome == "partly"


def test_a_leg_in_a_state_hangs_from_the_hip_that_the_root_carries() -> None:
    leg = still().legs[0]
    root = np.tile([[0.01], [0.02], [-0.03]], (1, FRAMES))
    found, as_it_is = CorrectedLeg.of_state(leg, root, np.zeros((8, FRAMES))), CorrectedLeg.of_tracks(leg)
    for name in ("hip", "ankle", "heel", "toe"):
        assert getattr(found, name) == pytest.approx(getattr(as_it_is, name) + root)

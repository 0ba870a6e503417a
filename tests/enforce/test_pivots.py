"""Feet that turn on the floor keep the end they turn about, however sure the contacts of heel and toe are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from legmaker import changed, figure_of
from walks import rig_of, walk

import footfix
from footfix.enforce.pivots import ankle_stiller, held_alike, share_held, shared_behind, turn_rate
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contact, Contacts
from footfix.rig.rig import Rig

FPS, FRAMES = 60.0, 121
QUICK = 4.0  # [rad/s]


def turned(about: str, angle: Floats, drift: float = 0.0, kind: str = "plain") -> tuple[Clip, Rig]:
    """A figure with legs of some kind that stands, drifts and turns by (F,) [rad] about a sole point of its left foot.
    """
    made = walk("stand", FPS, 2.0)
    clip, rig = changed(kind, made.clip.frames(np.zeros(FRAMES, dtype=int)), rig_of(made))
    centre = rig.tracks(rig.pose(clip))[[sole.name for sole in rig.soles].index(f"left_{about}")][0] * [1.0, 0.0, 1.0]
    yaw = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), angle)
    place = centre + rotation.rotate(yaw, clip.position(rig.root) - centre)
    place = place + np.outer(drift * np.linspace(0.0, 1.0, FRAMES), [0.6, 0.0, 0.8])
    return clip.with_joints({rig.root: place}, {rig.root: rotation.multiply(yaw, clip.rotation(rig.root))}), rig


def contacts_of(contacts: Contacts, heel: float, toe: float) -> Contacts:
    """Heel and toe of the left foot stand all along, more or less surely; the right foot does not."""
    sure = {"left_heel": heel, "left_toe": toe}
    effectors = tuple(
        replace(e, contacts=(Contact(0, FRAMES, sure[e.name]),) if e.name in sure else ()) for e in contacts.effectors
    )
    return replace(contacts, frames=FRAMES, effectors=effectors, method="auto")


@pytest.mark.parametrize("kind", ["plain", "bare toes"])
@pytest.mark.parametrize("about", ["heel", "toe"])
@pytest.mark.parametrize(("heel", "toe"), [(0.3, 0.97), (0.97, 0.3)])
def test_a_foot_turns_about_the_end_it_turned_about(about: str, heel: float, toe: float, kind: str) -> None:
    u = np.clip(np.arange(FRAMES) / FPS - 0.8, 0.0, 0.4) / 0.4
    clip, rig = turned(about, 2.6 * u**2 * (3.0 - 2.0 * u), 0.03, kind)
    contacts = contacts_of(walk("stand", FPS, 2.0).contacts, heel, toe)
    cleaned = footfix.clean(clip, rig=rig, contacts=contacts).clip
    names = [sole.name for sole in rig.soles]
    ends = [names.index(f"left_{each}") for each in (about, "toe" if about == "heel" else "heel")]
    tracks = [np.stack(rig.tracks(rig.pose(each)))[ends][:, :, [0, 2]] for each in (clip, cleaned)]  # (2, F, 2) [m]
    stays, sweeps = (np.hypot(*(tracks[1][k] - tracks[1][k, 0]).T).max() for k in (0, 1))
    assert stays < 0.4 * sweeps
    assert np.hypot(*(tracks[1] - tracks[0])[0].T).max() < 0.06


@pytest.mark.parametrize("rate", [0.0, 1.0, 4.0])
def test_the_rate_is_that_of_the_figure_which_turns(rate: float) -> None:
    clip, rig = turned("heel", rate * np.arange(FRAMES) / FPS)
    leg = figure_of(clip, rig, walk("stand", FPS, 2.0).contacts).legs[0]
    assert turn_rate(leg, 1.0 / FPS) == pytest.approx(rate, rel=0.01, abs=1e-9)
    both = np.arange(FRAMES - 1) >= 60
    share = share_held(leg, both, 1.0 / FPS, QUICK)
    assert share[:60] == pytest.approx(1.0)
    assert share[60:] == pytest.approx(1.0 / (1.0 + (rate / QUICK) ** 2), rel=0.01)


@pytest.mark.parametrize("ends", [False, True])
def test_a_step_turns_as_the_slower_of_its_two_frames_does(ends: bool) -> None:
    """So a foot that begins or ends to turn is held in full up to the very frame."""
    time = np.arange(FRAMES) / FPS
    clip, rig = turned("heel", 0.5 * (time[::-1] if ends else time) ** 2)  # 1 rad/s^2, away from or towards rest
    rate = turn_rate(figure_of(clip, rig, walk("stand", FPS, 2.0).contacts).legs[0], 1.0 / FPS)
    slower = (time[::-1] if ends else time)[slice(1, None) if ends else slice(None, -1)]
    inner = slice(5, -5)  # the window of the rate has both sides
    assert np.abs(rate - slower)[inner].max() < 0.25 / FPS


@pytest.mark.parametrize("up", [-0.2, 0.2])
def test_a_foot_on_its_tip_hardly_counts_as_turning(up: float) -> None:
    """A line that is nearly upright is taken to be half as long over the floor as it is."""
    rate, flat, leg = 2.0, 0.02, figure_of(*turned("heel", np.zeros(FRAMES)), walk("stand", FPS, 2.0).contacts).legs[0]
    angle = rate * np.arange(FRAMES) / FPS
    line = np.stack([flat * np.cos(angle), np.full(FRAMES, up), flat * np.sin(angle)])  # (3, F) [m]
    upright = replace(leg, points=(np.zeros_like(line), line, *leg.points[2:]))
    assert turn_rate(upright, 1.0 / FPS) == pytest.approx(rate * flat**2 / (0.25 * (flat**2 + up**2)), rel=0.01)


def test_heel_and_toe_are_held_alike_while_both_stand() -> None:
    heel, toe = np.array([0.0, 0.5, 0.5]), np.array([0.9, 0.9, 0.2])
    both, share = np.array([False, True, True]), np.array([1.0, 1.0, 0.5])
    found = held_alike(heel, toe, both, share)
    assert found[0].tolist() == [0.0, 0.9, 0.25]
    assert found[1].tolist() == [0.9, 0.9, 0.25]


def test_the_ankle_has_the_weight_behind_where_it_rests_and_the_heel_does_not() -> None:
    leg = figure_of(*turned("heel", np.zeros(FRAMES)), walk("stand", FPS, 2.0).contacts).legs[0]
    ground, both = np.zeros((FRAMES, 3)), np.arange(FRAMES - 1) >= 40
    along = np.outer([1.0, 0.0, 0.0], np.linspace(0.0, 0.05, FRAMES))  # (3, F) [m]
    skates = replace(leg, ankle=leg.ankle + along)
    rolls = replace(leg, points=(leg.points[0] + along, *leg.points[1:]))
    stands = replace(leg, ankle=leg.ankle + along, points=(leg.points[0] - along, *leg.points[1:]))
    for each in (leg, skates, stands):
        assert np.all(ankle_stiller(each, ground, both, 0.9) == 1.0)
    carried = replace(rolls, ankle=rolls.ankle + along)  # the same on a belt
    for each, belt in ((rolls, ground), (carried, along.T)):
        found = ankle_stiller(each, belt, both, 0.9)
        assert np.all(found[~both] == 1.0) and np.all(found[both] > 20.0)


def test_weight_that_the_ankle_gets_is_the_heels() -> None:
    heel, ankle = np.array([0.9, 0.9, 0.5, 0.0]), np.array([0.4, 0.4, 0.2, 0.0])
    found = shared_behind(heel, ankle, np.array([1.0, 3.0, 1e6, 1.0]))
    assert found[0] + found[1] == pytest.approx(heel + ankle)
    assert found[0][0] == heel[0] and found[1][0] == ankle[0]
    assert found[1][1] / found[0][1] == pytest.approx(3.0 * 0.4 / 0.9)
    assert found[0][2] == pytest.approx(0.0, abs=1e-5)
    assert found[1][3] == 0.0


def test_an_ankle_that_rests_still_rests_when_its_heel_has_rolled() -> None:
    """The root is carried along with the foot's roll about its ankle, as where a heel was guessed too far from it."""
    made = walk("stand", FPS, 2.0)
    clip, rig = made.clip.frames(np.zeros(FRAMES, dtype=int)), rig_of(made)
    roll = 0.25 * np.sin(np.linspace(0.0, np.pi, FRAMES)) ** 2  # [rad]
    ankle = rig.legs[0].ankle
    turn = rotation.from_axis_angle(np.array([0.0, 0.0, 1.0]), roll)
    clip = clip.with_joints({}, {ankle: rotation.multiply(turn, clip.rotation(ankle))})
    cleaned = footfix.clean(clip, rig=rig, contacts=contacts_of(made.contacts, 0.95, 0.95)).clip
    before, after = (rig.pose(each).position(ankle)[:, [0, 2]] for each in (clip, cleaned))
    assert np.hypot(*np.ptp(before, axis=0)) < 1e-9
    assert np.hypot(*np.ptp(after, axis=0)) < 0.002  # [m]

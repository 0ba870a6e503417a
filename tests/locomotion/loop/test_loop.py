"""Loops: closed, calm at the seam, and their feet stand over it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache

import artefacts
import numpy as np
import pytest
from walker import make
from walker_gaits import Gait
from walks import rig_of, walk

import footfix
from footfix.enforce.params import EnforceParams
from footfix.locomotion.loop.cyclic_enforcement import laid_contacts, lay
from footfix.locomotion.loop.params import LoopParams
from footfix.locomotion.loop.residual_slide import settled
from footfix.locomotion.loop.root_motion import Travel, carrier, root_in_world, with_root
from footfix.locomotion.loop.run import Loop, as_round, make_loop
from footfix.locomotion.loop.seam import ratios, slide
from footfix.locomotion.loop.strides import find_strides
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.kinematics import places


@cache
def skating(name: str = "walk", fps: float = 60.0) -> Clip:
    return artefacts.wander(artefacts.drift(walk(name, fps).clip, 0.1), 0.03)


@cache
def loop(name: str = "walk", fps: float = 60.0, **asked: object) -> Loop:
    made = walk(name, fps)
    return make_loop(
        skating(name, fps), rig_of(made), made.contacts, LoopParams(**asked), EnforceParams()  # type: ignore[arg-type]
    )  # fmt: skip


def over_the_seam(found: Loop, trim: int) -> Iterator[Floats]:
    """The ways (n, 2) [m] over the floor of toe joints that stand over the seam of two rounds laid end to end."""
    two, length = places(lay(found.round, 0, found.travel, range(2))), len(found.round) - 1
    for sole, effector in zip(found.rig.soles, found.contacts.effectors, strict=True):
        first = [c for c in effector.contacts if c.start == 0]
        last = [c for c in effector.contacts if c.end == length + 1]
        if sole.part == "toe" and first and last and first != last:
            stands = slice(last[0].start + trim, length + first[0].end - trim)
            yield two[stands, found.rig.legs[sole.leg].toe][:, [0, 2]]


def strays(found: Loop) -> list[float]:
    """[mm] how far each of these toe joints strays."""
    tracks = over_the_seam(found, trim=2)
    return [1000.0 * float(np.linalg.norm(track - np.median(track, axis=0), axis=1).max()) for track in tracks]


@pytest.mark.parametrize("name", ["walk", "run", "curve"])
def test_a_loop_closes_and_what_stands_over_its_seam_stands(name: str) -> None:
    found = loop(name)
    place = places(found.clip)
    assert np.allclose(place[-1], found.travel.places(place[0]), atol=1e-9)
    assert len(strays(found)) == 1
    assert max(strays(found)) <= 0.1
    assert found.seam.slide_mm is not None
    assert found.seam.slide_mm <= 0.1


@pytest.mark.parametrize("name", ["walk", "run", "curve"])
def test_nothing_at_the_seam_gives_it_away(name: str) -> None:
    found = loop(name)
    assert found.seam.median_ratio <= 1.0
    assert found.seam.worst_ratio <= 1.5
    assert found.seam.changed_mm <= max(0.65 * found.seam.gap_mm, 8.0)  # where poses hardly differ, velocities do


def test_a_seam_that_is_only_cut_gives_itself_away() -> None:
    found = loop()
    median, worst = ratios(found.captured, found.rig, found.travel)
    assert median > 1.5 * found.seam.median_ratio
    assert worst > 2.0


def test_speed_travel_and_turn_are_the_walkers() -> None:
    straight, curve = loop(), loop("curve")
    assert straight.speed == pytest.approx(1.3, rel=0.08)
    assert straight.distance == pytest.approx(np.hypot(*straight.travel_of_root), rel=1e-3)
    assert np.degrees(straight.turn) == pytest.approx(0.0, abs=3.0)
    turned = np.degrees(walk("curve").gait.turn) / walk("curve").gait.duration * curve.seconds
    assert np.degrees(curve.turn) == pytest.approx(turned, rel=0.2)


@pytest.mark.parametrize("asked", [{}, {"in_place": True}, {"open": True}, {"straighten": True}],
                         ids=["closed", "in place", "open", "straightened"])  # fmt: skip
def test_a_loop_of_a_loop_is_the_very_clip(asked: dict[str, bool]) -> None:
    found = loop("curve", **asked)
    again = make_loop(found.clip, found.rig, clipped(found), LoopParams(**asked), EnforceParams())  # type: ignore[arg-type]
    assert np.allclose(again.clip.positions, found.clip.positions, atol=1e-9)
    assert rotation.angle(rotation.multiply(again.clip.rotations, rotation.inverse(found.clip.rotations))).max() < 1e-7
    assert [note.id for note in again.notes] == ["loop-already"]


def clipped(found: Loop) -> footfix.Contacts:
    frames = len(found.clip)
    effectors = tuple(
        replace(e, contacts=tuple(replace(c, end=min(c.end, frames)) for c in e.contacts if c.start < frames))
        for e in found.contacts.effectors
    )
    return replace(found.contacts, frames=frames, effectors=effectors)


@pytest.mark.parametrize("asked", [{"in_place": True}, {"open": True}, {"in_place": True, "open": True}],
                         ids=["in place", "open", "both"])  # fmt: skip
def test_what_is_written_tells_the_round_again(asked: dict[str, bool]) -> None:
    found = loop("curve", **asked)
    again = as_round(found.clip, found.rig, found.travel, LoopParams(**asked))  # type: ignore[arg-type]
    assert np.allclose(places(again), places(found.round), atol=1e-9)
    assert len(found.frames) == len(found.clip)


def test_in_place_the_figure_stays_and_straightened_it_turns_no_more() -> None:
    spot, straight = loop("curve", in_place=True).clip, loop("curve", straighten=True)
    place = places(spot)
    assert np.allclose(place[-1], place[0], atol=1e-9)
    assert np.ptp(place[:, 0, [0, 2]], axis=0).max() < 0.15
    assert straight.turn == 0.0
    assert straight.distance == pytest.approx(loop("curve").distance, rel=2e-3)
    assert max(strays(straight)) <= 0.1


def test_rounds_laid_end_to_end_go_on_and_one_plant_lies_over_each_seam() -> None:
    found = loop("curve")
    three = lay(found.round, 0, found.travel, range(-1, 2))
    length = len(found.round) - 1
    place = places(three)
    assert np.allclose(place[length : 2 * length + 1], places(found.round), atol=1e-9)
    assert np.allclose(place[2 * length :], found.travel.places(place[length : 2 * length + 1]), atol=1e-9)
    for own, effector in zip(laid_contacts(found.contacts, 3), found.contacts.effectors, strict=True):
        mask = np.zeros(3 * length + 1, dtype=bool)
        for each in own:
            mask[each.contact.start : each.contact.end] = True
        once = np.zeros(length + 1, dtype=bool)
        for contact in effector.contacts:
            once[contact.start : contact.end] = True
        assert np.array_equal(mask, np.append(np.tile(once[:-1], 3), once[0]))


def test_the_papers_blend_makes_a_loop_too() -> None:
    found = loop(method="kim-neff")
    place = places(found.clip)
    assert np.allclose(place[-1], found.travel.places(place[0]), atol=1e-9)
    assert max(strays(found)) <= 0.1


def test_the_interface_of_python_finds_rig_and_contacts() -> None:
    found = footfix.loop(skating())
    assert isinstance(found, footfix.Loop)
    assert found.strides == 1
    assert (len(found.round) - 1) == pytest.approx(65, abs=2)
    assert len(found.others) == 3


def drifting_on_a_belt() -> footfix.Clip:
    """A walker on a treadmill who comes forward and turns, slowly."""
    made = walk("treadmill", duration=5.0)
    root = carrier(made.clip, rig_of(made))
    place, turn = root_in_world(made.clip, root)
    part = np.linspace(0.0, 1.0, len(made.clip))
    turns, shifts = Travel(np.radians(6.0), 0.0, 0.15).share(part)
    return with_root(made.clip, root, rotation.rotate(turns, place) + shifts, rotation.multiply(turns, turn))


def test_on_a_belt_a_loop_stays_in_its_place_and_feet_go_on_with_the_belt_over_the_seam() -> None:
    made = walk("treadmill", duration=5.0)
    found = make_loop(drifting_on_a_belt(), rig_of(made), made.contacts, LoopParams(), EnforceParams())
    assert (found.turn, found.distance) == (0.0, 0.0)
    strays = []
    for track in over_the_seam(found, trim=1):
        time = np.arange(len(track))
        even = np.stack([np.polyval(np.polyfit(time, axis, 1), time) for axis in track.T], axis=1)
        assert np.linalg.norm(even[-1] - even[0]) * 60.0 / (len(track) - 1) == pytest.approx(1.2, rel=0.15)
        strays.append(1000.0 * np.linalg.norm(track - even, axis=1).max())
    assert len(strays) > 0
    assert max(strays) <= 0.1


def test_a_pinned_toe_that_strays_a_little_stands_when_it_is_settled() -> None:
    found = loop()
    root = carrier(found.round, found.rig)
    sway = 0.002 * np.sin(np.linspace(0.0, 2.0 * np.pi, len(found.round)))[:, None] * [1.0, 0.0, 0.5]
    place, turn = root_in_world(found.round, root)
    swayed = with_root(found.round, root, place + sway, turn)
    pinned = tuple(plant for plant in found.plants if plant.outcome in ("pinned", "kept"))
    before = slide(swayed, found.rig, pinned, found.travel, found.ground)
    after = slide(settled(swayed, found.rig, pinned, found.travel, found.ground), found.rig, pinned, found.travel,
                  found.ground)  # fmt: skip
    assert before is not None and before > 1e-3
    assert after is not None and after < 1e-6


def test_at_more_frames_a_second_a_loop_stands_and_closes_as_well() -> None:
    found = loop("walk", 120.0)
    place = places(found.clip)
    assert np.allclose(place[-1], found.travel.places(place[0]), atol=1e-9)
    assert max(strays(found)) <= 0.1
    assert found.seconds == pytest.approx(loop("walk", 60.0).seconds, abs=0.02)
    assert found.seam.worst_ratio <= 1.5


def test_a_shaken_walkers_period_is_a_strides_to_the_frame() -> None:
    made = make(Gait(name="tiptoe", fps=120.0, duration=5.0, seed=1, variation=1.0))
    shaken = artefacts.wander(artefacts.shake(made.clip, 0.15, seed=3, slowest=0.1), 0.04, seed=2)
    found = footfix.loop(shaken)
    told = [s.frames for own in find_strides(made.contacts, rig_of(made)) for s in own]
    assert min(abs(len(found.round) - 1 - each) for each in told) <= 1

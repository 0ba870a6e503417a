"""A clip that was cleaned before is known by its feet, and is left as it is."""

from __future__ import annotations

from dataclasses import replace

import artefacts
import numpy as np
import pytest
from walks import cleaned, heights, rig_of, slides, walk

from footfix.detect.run import detect
from footfix.enforce.cleaned import as_rows
from footfix.enforce.foot import feet, posed
from footfix.enforce.plants import Plant, PlantParams, Stance
from footfix.enforce.rest import LEFT, locked, new_since, off_their_floor, resting
from footfix.enforce.run import EnforceParams
from footfix.motion import rotation
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contact
from footfix.rig.find import find_rig
from footfix.settings import Settings

LEG = 0.88


def same(one: Clip, other: Clip) -> bool:
    """Whether two clips are the same to the digit."""
    return np.array_equal(one.rotations, other.rotations) and np.array_equal(one.positions, other.positions)


def rolling(frames: int, point: np.ndarray, *, noise: float = 0.0, steps: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """A joint that rolls about a point fixed in it and on the floor; each pose is held for some frames."""
    t = np.repeat(np.arange(-(-frames // steps)), steps)[:frames] * steps / 60.0
    turn = rotation.from_rotation_vector(np.stack([0.5 * np.sin(3.0 * t), 0.2 * t, 0.1 * np.cos(2.0 * t)], axis=1))
    place = np.array([0.3, 0.02, -0.1]) - rotation.rotate(turn, point)
    return place + noise * np.random.default_rng(0).normal(size=place.shape), turn


def test_a_foot_that_rolls_about_a_point_of_its_own_rests() -> None:
    point = np.array([0.01, -0.05, 0.12])
    place, turn = rolling(60, point)
    planted = np.zeros(60, dtype=bool)
    planted[5:55] = True
    guessed = point + [0.015, -0.01, 0.02]  # where the sole is thought to be
    rests = resting(place, turn, guessed, planted, LEG, 2e-5)
    assert np.array_equal(rests, planted[1:] & planted[:-1])
    far = resting(place, turn, point + [0.0, 0.2, 0.0], planted, LEG, 2e-5)
    assert not np.any(far)  # that point is none of this foot's


def test_captured_feet_do_not_rest() -> None:
    point = np.array([0.01, -0.05, 0.12])
    planted = np.ones(60, dtype=bool)
    shaking, turn = rolling(60, point, noise=1e-4)  # a tenth of a millimetre
    assert not np.any(resting(shaking, turn, point, planted, LEG, 2e-5))
    made = walk()
    rig, clip = rig_of(made), artefacts.drift(made.clip, 0.05)
    pose = rig.pose(clip)
    for sole, on in zip(rig.soles, made.contacts.mask().T, strict=True):
        at = pose.position(sole.joint), pose.rotation(sole.joint), np.array(sole.offset)
        assert resting(*at, on, LEG, 2e-5).sum() < 0.2 * on.sum()


@pytest.mark.parametrize("gait", ["walk", "run", "backwards"])
@pytest.mark.parametrize("artefact", ["drift", "wander", "shaken"])
def test_a_cleaned_clip_comes_through_once_more_as_it_is(gait: str, artefact: str) -> None:
    """With everything found and detected anew, as by somebody who has only the cleaned file."""
    spoilt = {
        "drift": lambda clip: artefacts.drift(clip, 0.05),
        "wander": lambda clip: artefacts.wander(clip, 0.05, slowest=1.0),
        "shaken": lambda clip: artefacts.shake(clip, 0.3),
    }[artefact](walk(gait, 120.0).clip)
    rig = find_rig(spoilt)
    once, found = cleaned(spoilt, rig, detect(spoilt, rig, Settings().detect))
    assert sum(plant.outcome == "pinned" for plant in found.plants) > 0.6 * len(found.plants)
    rig = find_rig(once)
    contacts = detect(once, rig, Settings().detect)
    twice, again = cleaned(once, rig, contacts)
    assert same(twice, once)
    assert [note.id for note in again.notes] == ["cleaned-before"]
    assert not any(plant.outcome in ("pinned", "partly") for plant in again.plants)


def test_it_is_looked_at_again_where_that_is_asked_for() -> None:
    made = walk()
    rig = rig_of(made)
    contacts = replace(made.contacts, method="auto")
    broken = made.clip.positions.copy()
    broken[100:, 0, 2] += np.minimum(np.arange(len(broken) - 100) * 0.002, 0.04)  # one stand of many was spoilt
    clip = replace(made.clip, positions=broken)
    before = max(slides(clip, rig, contacts)["toe"])
    left, found = cleaned(clip, rig, contacts)
    assert "cleaned-before" in [note.id for note in found.notes] and same(left, clip)
    after, found = cleaned(clip, rig, contacts, EnforceParams(again=True))
    assert before > 10.0 and max(slides(after, rig, found.contacts)["toe"]) < 1.0


def test_feet_that_rest_below_the_floor_are_raised_to_it() -> None:
    made = walk()
    rig = rig_of(made)
    after, found = cleaned(artefacts.sink(made.clip, 0.03), rig, replace(made.contacts, method="auto"))
    assert "height-moved" in [note.id for note in found.notes]
    assert np.percentile(np.abs(heights(after, rig, made.contacts)), 95) < 1.0


def test_only_a_clip_that_is_off_its_floor_as_a_whole_is_off_it() -> None:
    def rests(level: float) -> Stance:
        return Stance(0, (Plant(0, "toe", Contact(0, 9, 1.0), 0, 9, np.zeros(3)),), level=level, cleaned=True)

    params = PlantParams()
    assert off_their_floor([rests(0.033), rests(0.031), rests(0.035)], 0.0, 1.0, params)
    assert off_their_floor([rests(-0.03), rests(-0.03), rests(-0.03), rests(-0.029)], 0.0, 1.0, params)
    assert not off_their_floor([rests(0.034), rests(0.033), rests(0.034), rests(0.001), rests(0.003)], 0.0, 1.0, params)
    assert not off_their_floor([rests(0.002), rests(0.001)], 0.0, 1.0, params)
    assert not off_their_floor([], 0.0, 1.0, params)


@pytest.mark.parametrize("gait", ["walk", "turn"])
def test_what_was_put_into_a_cleaned_clip_is_cleaned_too(gait: str) -> None:
    made = walk(gait, fps=60.0, duration=8.0)
    rig, first = rig_of(made), artefacts.drift(made.clip, 0.05)
    clean, _ = cleaned(first, rig, replace(made.contacts, method="auto"))
    cut = int(0.65 * len(clean))
    late = np.where(np.arange(len(clean)) < cut, 0.0, (np.arange(len(clean)) - cut) / (len(clean) - cut))
    positions = clean.positions.copy()
    positions[:, 0, 0] += 0.2 * late  # the rest of the clip slides on
    spliced = replace(clean, positions=positions)
    after, found = cleaned(spliced, rig, replace(made.contacts, method="auto"))
    assert "cleaned-before" in [note.id for note in found.notes]
    assert len(found.plants) == sum(len(effector.contacts) for effector in found.contacts.effectors)
    assert max(slides(spliced, rig, found.contacts)["toe"]) > 10.0
    assert max(slides(after, rig, found.contacts)["toe"]) < 1.0
    assert np.array_equal(after.rotations[: cut // 2], clean.rotations[: cut // 2])


def test_only_several_stands_in_a_row_are_new() -> None:
    def stand(start: int, rests: bool) -> Stance:
        plant = Plant(0, "toe", Contact(start, start + 9, 1.0), start, start + 9, np.zeros(3))
        return Stance(0, (plant,), cleaned=rests)

    def rows(*rests: bool, in_part: tuple[int, ...] = ()) -> list[int]:
        stands = [stand(20 * k, each) for k, each in enumerate(rests)]
        rows = new_since(stands, [each or k in in_part for k, each in enumerate(rests)])
        backwards = new_since(stands[::-1], [each or k in in_part for k, each in enumerate(rests)][::-1])
        assert np.array_equal(np.array(rows) > 0, np.array(backwards[::-1]) > 0)
        return rows

    rests = (True,) * 9
    new = np.array(rows(*rests, False, False, *rests, *(False,) * 4, *rests))
    assert np.flatnonzero(new).tolist() == [20, 21, 22, 23] and len(set(new[20:24])) == 1
    # where as many are let go elsewhere, four in a row are chance
    assert not any(rows(True, False, False, True, False, False, False, False, True))
    # one that rests as far as the cut
    new = np.array(rows(*rests, False, *(False,) * 4, *rests, in_part=(9,)))
    assert np.flatnonzero(new).tolist() == [9, 10, 11, 12, 13]


def test_of_what_was_put_in_together_few_give_way() -> None:
    def stand(row: int, reason: str = "") -> Stance:
        return Stance(0, (Plant(0, "toe", Contact(0, 9, 1.0), 0, 9, np.zeros(3), reason=reason),), row=row)

    few = as_rows([stand(0, "far"), *[stand(1)] * 7, stand(1, "far"), stand(2), stand(2), stand(2, "far")])
    assert [stance.released for stance in few] == [True, *[False] * 7, True, True, True, True]
    assert few[-2].plants[0].reason == LEFT


def test_rows_at_rest_are_locked_while_the_hip_goes_on() -> None:
    made = walk()
    rig = rig_of(made)
    legs = feet(rig, posed(made.clip, rig))
    rests = np.zeros(len(made.clip) - 1, dtype=bool)
    rests[10:30] = True
    rests[40:44] = True  # too short
    assert locked(rests, legs[0].hip, made.clip.frame_time, rig.leg_length) == [(10, 31)]
    assert not locked(rests, np.zeros_like(legs[0].hip), made.clip.frame_time, rig.leg_length)

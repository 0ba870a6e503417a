"""Feet that move by themselves step; what all of the figure does is skate, and stays a contact."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import artefacts
import numpy as np
import pytest
from walker import make
from walker_gaits import Gait

from footfix.detect.auto import AutoParams, log_probabilities
from footfix.detect.evidence import resample
from footfix.detect.network import SWING
from footfix.detect.run import DetectParams, find
from footfix.detect.stepping import (
    SteppingParams,
    from_rest_to_rest,
    parting,
    planted_throughout,
    resting_speed,
    slowest,
    stepping,
    velocities,
    velocities_of,
)
from footfix.detect.tracks import FootTracks, Tracks, tracks_of
from footfix.detect.weights import network
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.rig.find import find_rig

FPS = 60.0
SECONDS = 4.0
BLIND = AutoParams(stepping=SteppingParams(parting=1e6, length=1e6, fast=1e6))


@cache
def standing() -> Tracks:
    """A figure that stands still, hips level and knees a little bent."""
    shape = (round(SECONDS * FPS), 3)

    def at(x: float, y: float, z: float) -> Floats:
        return np.broadcast_to(np.array([x, y, z]), shape).copy()

    feet = tuple(
        FootTracks(side, at(x, 0.88, 0.0), at(x, 0.08, 0.0), at(x, 0.0, -0.05), at(x, 0.0, 0.13), at(x, 0.46, 0.06))
        for side, x in (("left", 0.1), ("right", -0.1))
    )
    return Tracks(at(0.0, 0.93, 0.0), feet, 0.88, 1.0 / FPS)


def shift(foot: FootTracks, by: Floats) -> FootTracks:
    return replace(foot, ankle=foot.ankle + by, heel=foot.heel + by, toe=foot.toe + by)


def eased(seconds: float) -> Floats:
    """(F,) from 0 to 1 about the middle of the clip, at rest before and after."""
    t = np.arange(len(standing())) / FPS
    u = np.clip((t - 0.5 * (SECONDS - seconds)) / seconds, 0.0, 1.0)
    return np.asarray(u**3 * (10.0 - 15.0 * u + 6.0 * u**2))


def shuffled(distance: float, seconds: float, height: float, heading: float = 0.8) -> Tracks:
    """The left foot moved over the floor [m], all else still."""
    u = eased(seconds)
    way = u[:, None] * distance * np.array([np.sin(heading), 0.0, np.cos(heading)])
    way[:, 1] = height * np.sin(np.pi * u) ** 2
    left, right = standing().feet
    return replace(standing(), feet=(shift(left, way), right))


def slides(tracks: Tracks, mask: Bools) -> list[float]:
    """[m] how far heels and toes in contact are from their median places, at most."""
    points = [point for foot in tracks.feet for point in foot.soles]
    stands = [point[a:b, ::2] for k, point in enumerate(points) for a, b in runs(mask[:, k])]
    return [float(np.linalg.norm(stand - np.median(stand, axis=0), axis=1).max()) for stand in stands]


@pytest.mark.parametrize(("distance", "seconds"), [(0.05, 0.15), (0.2, 0.3), (0.15, 0.6), (0.25, 1.0), (0.4, 2.0)])
@pytest.mark.parametrize("height", [0.0, 0.03])
def test_a_foot_moved_beside_a_still_figure_is_two_plants(distance: float, seconds: float, height: float) -> None:
    tracks = shuffled(distance, seconds, height)
    mask = _found(tracks)
    assert max(slides(tracks, mask)) < 0.021
    assert mask[:, 2:].all(), "the foot that was left alone stands all along"
    left = mask[:, 0] | mask[:, 1]
    assert len(runs(left)) == 2
    assert np.mean(left) > 1.0 - (seconds + 0.2) / SECONDS, "it stands before and after"


def swaying(amount: float) -> Tracks:
    """The same figure alive: each foot creeps by some [m] to and fro, slowly and by itself."""
    t = np.arange(len(standing())) / FPS
    left, right = standing().feet
    ways = [amount * np.sin(2.0 * np.pi * rate * t)[:, None] * np.array([0.6, 0.0, 0.8]) for rate in (0.7, 0.9)]
    return replace(standing(), feet=(shift(left, ways[0]), shift(right, ways[1])))


@pytest.mark.parametrize(("distance", "seconds"), [(0.06, 0.7), (0.07, 1.4), (0.12, 2.0)])
def test_a_slow_step_of_a_figure_that_sways_is_a_step(distance: float, seconds: float) -> None:
    tracks = swaying(0.002)
    way = eased(seconds)[:, None] * np.array([0.6 * distance, 0.0, 0.8 * distance])
    stepped = replace(tracks, feet=(shift(tracks.feet[0], way), tracks.feet[1]))
    mask = _found(stepped)
    assert len(runs(mask[:, 0] | mask[:, 1])) == 2
    assert max(slides(stepped, mask)) < 0.021
    assert _found(tracks).all(), "swaying is no step"


@pytest.mark.parametrize(("distance", "seconds"), [(0.06, 0.3), (0.09, 0.45), (0.12, 0.3), (0.2, 0.45), (0.3, 0.7)])
@pytest.mark.parametrize("sway", [0.0, 0.002])
def test_contacts_take_in_less_than_a_fifth_of_a_short_step(distance: float, seconds: float, sway: float) -> None:
    """What a contact takes in of a step is held in place with it, so the step is shorter by as much."""
    way = eased(seconds)[:, None] * np.array([0.6 * distance, 0.0, 0.8 * distance])
    figure = swaying(sway)
    mask = _found(replace(figure, feet=(shift(figure.feet[0], way), figure.feet[1])))
    before, after = runs(mask[:, 0] | mask[:, 1])
    assert np.linalg.norm(way[after[0]] - way[before[1] - 1]) > 0.8 * distance


def test_feet_that_creep_as_far_at_rest_do_not_step() -> None:
    np.testing.assert_array_equal(_found(swaying(0.03)), _found(swaying(0.03), BLIND))


@pytest.mark.parametrize(("distance", "seconds", "height"), [(0.3, 0.8, 0.0), (0.09, 0.7, 0.03), (0.06, 1.0, 0.02)])
def test_a_step_lasts_from_rest_to_rest(distance: float, seconds: float, height: float) -> None:
    tracks = shuffled(distance, seconds, height)
    mask = _found(tracks)
    gap = ~(mask[:, 0] | mask[:, 1])
    moved = np.linalg.norm(np.diff(tracks.feet[0].toe[:, ::2], axis=0), axis=1)[gap[1:] | gap[:-1]].sum()
    assert moved > 0.8 * distance, "contacts take in a little of the way at both ends"


@pytest.mark.parametrize(("distance", "seconds"), [(0.16, 0.3), (0.1, 0.5), (0.15, 0.8)])
def test_both_feet_may_step_at_once(distance: float, seconds: float) -> None:
    left, right = standing().feet
    way = eased(seconds)[:, None] * distance * np.array([0.95, 0.0, 0.3])
    tracks = replace(standing(), feet=(shift(left, way), shift(right, -way)))
    mask = _found(tracks)
    assert [len(runs(mask[:, k] | mask[:, k + 1])) for k in (0, 2)] == [2, 2]
    assert max(slides(tracks, mask)) < 0.021


def one_slides(mate: Floats, pelvis: Floats, slides: Floats, speed: float = 1.0) -> Floats:
    """(n,) probability that a foot stands which looks planted and moves for 0.3 s, and the other swings all along.

    Args:
        mate, pelvis: (n, 2) [leg lengths/s] velocities of the other foot, and of the pelvis.
        slides: (n, 2) [leg lengths/s] velocity of the foot at other times.
        speed: [leg lengths/s] in between.
    """
    feet = np.stack([slides, mate])[:, :, None].repeat(2, axis=2)
    feet[0, 150:180, :, 0] += speed
    looks = np.array([[0.01, 0.4, 0.4, 0.19], [0.99, 0.004, 0.003, 0.003]])
    answers = tuple(np.log(np.tile(one, (len(mate), 1))) for one in looks)
    found = stepping(answers, (1, 0), pelvis, list(feet), SteppingParams())
    return np.asarray(1.0 - np.exp(found[0][:, SWING]))


def test_a_foot_that_rests_before_and_after_steps_though_the_other_swings() -> None:
    still = np.zeros((400, 2))
    for pelvis in (still, still + [0.7, 0.0], still + [-0.7, 0.0]):
        stands = one_slides(still + [3.0, 0.0], pelvis, still)
        assert stands[150:180].max() < 0.1
        assert min(stands[:150].min(), stands[180:].min()) > 0.9
    assert one_slides(still + [3.0, 0.0], still, still, speed=0.2)[150:180].min() > 0.9, "a slow one may skate"
    skates = one_slides(still + [3.0, 0.0], still + [0.5, 0.0], still + [0.3, 0.0])
    assert skates.min() > 0.9, "a foot that skates before and after is no more at rest"


def test_what_a_foot_has_in_common_with_the_pelvis_and_the_other_foot_is_no_step() -> None:
    glides = np.zeros((400, 2))
    glides[150:180, 0] = 1.0
    assert one_slides(glides, glides, 0.0 * glides).min() > 0.9
    assert one_slides(0.0 * glides, glides, 0.0 * glides)[150:180].max() < 0.1
    partly = glides.copy()
    partly[:160] = partly[170:] = 0.0  # going along for a moment is no rest
    assert one_slides(partly, partly, 0.0 * glides)[150:180].max() < 0.1


def test_a_foot_that_is_thrown_and_is_soon_back_has_not_stepped() -> None:
    still = np.zeros((400, 2))
    thrown = still.copy()
    thrown[163:167, 0] = -7.5  # in all as far as the other way in the 30 frames
    assert one_slides(still + [3.0, 0.0], still, thrown)[150:180].min() > 0.9


def _found(tracks: Tracks, params: AutoParams | None = None) -> Bools:
    return find(tracks, DetectParams(auto=params or AutoParams())).mask


@pytest.mark.parametrize("seconds", [0.3, 1.0])
def test_what_the_whole_figure_does_is_no_step(seconds: float) -> None:
    way = eased(seconds)[:, None] * np.array([0.2, 0.0, 0.1])
    still = standing()
    feet = tuple(replace(shift(foot, way), hip=foot.hip + way) for foot in still.feet)
    tracks = replace(still, pelvis=still.pelvis + way, feet=feet)
    np.testing.assert_array_equal(_found(tracks), _found(tracks, BLIND))


@pytest.mark.parametrize("gait", ["walk", "run", "backwards"])
def test_a_figure_on_a_belt_steps_no_more_than_one_that_walks(gait: str) -> None:
    walk = make(Gait(name=gait, fps=FPS, duration=3.0, seed=2))  # type: ignore[arg-type]
    clip = artefacts.scale_root(walk.clip, 0.0, height=False)
    tracks = tracks_of(clip, find_rig(clip))
    with_it, without = _found(tracks), _found(tracks, BLIND)
    assert np.mean(with_it != without) < 0.01


def test_left_and_right_are_treated_alike() -> None:
    tracks = shuffled(0.2, 0.3, 0.01)
    swapped = replace(tracks, feet=tracks.feet[::-1])
    np.testing.assert_array_equal(_found(swapped), np.roll(_found(tracks), 2, axis=1))


def test_the_foot_that_steps_is_sure_to_and_the_other_sure_to_stand() -> None:
    sampled = resample(shuffled(0.2, 0.3, 0.0))
    _, (left, right) = log_probabilities(sampled, AutoParams(), network())
    middle = round(0.5 * SECONDS / 0.01)
    assert np.exp(left[middle, SWING]) > 0.95
    assert np.exp(right[middle, SWING]) < 0.05


def test_probabilities_stay_probabilities() -> None:
    random = np.random.default_rng(3)
    sampled = resample(shuffled(0.2, 0.3, 0.0))
    raw = random.normal(scale=6.0, size=(2, len(sampled.tracks), 4))
    answers = tuple(one - np.logaddexp.reduce(one, axis=1)[:, None] for one in raw)
    after = stepping(answers, sampled.mates, *velocities_of(sampled.tracks), SteppingParams())
    for one, before in zip(after, answers, strict=True):
        np.testing.assert_allclose(np.exp(one).sum(axis=1), 1.0, atol=1e-9)
        assert (np.exp(one[:, SWING]) >= np.exp(before[:, SWING]) - 1e-9).all(), "it never makes a foot stand"


def test_two_soles_part_by_how_they_move_against_each_other() -> None:
    random = np.random.default_rng(4)
    one, other = random.normal(size=(2, 50, 2, 2))
    common = random.normal(size=(50, 1, 2))
    np.testing.assert_allclose(parting(one, other), parting(other, one), atol=1e-12)
    np.testing.assert_allclose(parting(one + common, other + common), parting(one, other), atol=1e-9)
    np.testing.assert_allclose(parting(one, one), 0.0, atol=1e-12)
    s = np.linspace(0.0, 1.0, 101)
    points = [v[:, :1] + s[:, None] * (v[:, 1:] - v[:, :1]) for v in (one, other)]  # (50, 101, 2)
    brute = np.linalg.norm(points[0][:, :, None] - points[1][:, None], axis=-1).min(axis=(1, 2))
    np.testing.assert_allclose(parting(one, other), brute, atol=0.05)
    assert (parting(one, other) <= brute + 1e-12).all()


def test_a_sole_that_turns_about_a_point_of_it_is_as_slow_as_that_point() -> None:
    velocity = np.array([[[0.3, 0.0], [-0.1, 0.0]], [[0.3, 0.4], [0.3, 0.4]]])
    np.testing.assert_allclose(slowest(velocity), [0.0, 0.5], atol=1e-12)


def test_velocities_are_in_leg_lengths_a_second() -> None:
    foot = standing().feet[0]
    steps = np.arange(len(foot.heel))[:, None] * 0.01
    moved = shift(foot, steps * np.array([0.3, 5.0, -0.4]))
    np.testing.assert_allclose(velocities(moved), np.broadcast_to([0.3, -0.4], (len(steps), 2, 2)), atol=1e-9)


def test_a_foot_rests_as_fast_as_at_the_worse_of_the_rests_around_it() -> None:
    speed = np.concatenate([np.full(50, 0.1), np.full(30, 2.0), np.full(50, 0.3)])
    found = resting_speed(speed, SteppingParams())
    np.testing.assert_allclose(found[55:75], 0.3)
    on_belt = np.full(200, 1.2)
    np.testing.assert_allclose(resting_speed(on_belt, SteppingParams()), 1.2)


def test_of_two_feet_that_part_equally_fast_the_less_likely_to_stand_steps() -> None:
    t = np.arange(len(standing()))[:, None] / FPS
    left, right = standing().feet
    away = t * [0.0, 0.0, 0.3]
    sampled = resample(replace(standing(), feet=(shift(left, away), shift(right, -away))))
    stand = np.array([0.99, 0.6])
    answers = tuple(
        np.tile(np.log([1.0 - p, 0.5 * p, 0.3 * p, 0.2 * p]), (len(sampled.tracks), 1)) for p in stand
    )  # fmt: skip
    params = SteppingParams(parting=1e-6, travel=0.0, noise=0.0)
    found = stepping(answers, sampled.mates, *velocities_of(sampled.tracks), params)
    odds = (0.01 / 0.99) / (0.4 / 0.6)  # that it is the left one
    share = odds / (1.0 + odds)
    for answer, expected in zip(found, (0.99 * (1.0 - 0.6 * share), 0.6 * (1.0 - 0.99 * (1.0 - share))), strict=True):
        assert 1.0 - np.exp(answer[100:-100, SWING]) == pytest.approx(expected, abs=1e-6)


def test_a_foot_leaves_from_rest_to_rest_by_hand() -> None:
    leaves, creeps, planted = np.zeros(12), np.full(12, 0.5), np.ones(12)
    leaves[2:5], leaves[7:10] = 0.1, 1.0
    assert set(from_rest_to_rest(leaves, creeps, planted)) == {(2, 5), (7, 10)}
    lifted = planted.copy()
    lifted[[3, 8]] = 0.2  # off the floor meanwhile: then it has to leave faster than one at rest may creep
    assert from_rest_to_rest(leaves, creeps, lifted) == [(7, 10)]
    for at in (6, 10):  # no rest before, or after
        assert from_rest_to_rest(leaves, creeps, np.where(np.arange(12) == at, 0.2, lifted)) == []
    assert from_rest_to_rest(leaves[2:], creeps[2:], planted[2:]) == [(5, 8), (5, 8)]
    assert from_rest_to_rest(leaves[:5], creeps[:5], planted[:5]) == []


def test_a_foot_looks_planted_throughout_from_rest_to_rest_by_hand() -> None:
    leaves, planted = np.zeros(12), np.ones(12)
    leaves[2:5], leaves[7:10] = 0.1, 1.0
    assert planted_throughout(leaves, planted) == [(2, 5), (7, 10)]
    for at in (6, 8, 10):  # at rest before, in between, at rest after
        assert planted_throughout(leaves, np.where(np.arange(12) == at, 0.2, planted)) == [(2, 5)]
    assert planted_throughout(leaves[2:10], planted[2:10]) == []


@pytest.mark.parametrize(("rest", "fast", "still", "calm", "steps"), [
    (0.0, 0.08, 0.1, 2.0, False), (0.0, 0.08, 0.05, 2.0, True),
    (0.2, 0.35, 0.1, 2.0, False), (0.2, 0.35, 0.1, 1.2, True),
])  # fmt: skip
def test_a_foot_rests_below_the_larger_of_two_speeds(
    rest: float, fast: float, still: float, calm: float, steps: bool
) -> None:
    velocity = np.zeros((400, 2, 2))
    velocity[..., 1] = rest
    velocity[150:250, :, 1] = fast
    answer = np.tile(np.log([0.01, 0.5, 0.3, 0.19]), (400, 1))
    params = SteppingParams(parting=10.0, travel=0.0, noise=0.0, creeping=0.0, length=0.01, still=still, calm=calm)
    found = stepping((answer, answer), (1, 0), np.zeros((400, 2)), (velocity, 0.0 * velocity), params)
    assert bool(np.exp(found[0][200, SWING]) > 0.5) is steps

"""Detection that goes along says of the newest frames what detection says of a clip that ends with them."""

from __future__ import annotations

import numpy as np
import pytest
from streams import cut, sample

import footfix
from footfix.detect import weights
from footfix.detect.auto import AutoParams, auto
from footfix.detect.evidence import STEP, evidence, floors, resample
from footfix.detect.overtaking import overtaking as overtaking_of_clip
from footfix.detect.stepping import slowest, stands, velocities, velocities_of, velocity_of
from footfix.detect.stepping import stepping as stepping_of_clip
from footfix.detect.tracks import Tracks, tracks_of
from footfix.motion.clip import Floats
from footfix.motion.smoothing import savgol
from footfix.stream.detection import Detector, logits
from footfix.stream.evidence import newest_evidence
from footfix.stream.filters import Lowest, filtered
from footfix.stream.ground_velocities import Complexes, OverGround
from footfix.stream.stepping import overtaking, stepping
from footfix.stream.time_grid import Grid


def tracks(name: str) -> Tracks:
    clip = sample(name).clip
    return tracks_of(clip, footfix.find_rig(clip))


@pytest.mark.parametrize("hop", [1, 3, 7])
def test_the_grid_is_the_one_of_the_whole_clip(hop: int) -> None:
    whole = cut(tracks("walk_skate"), 0, 120)
    grid = Grid(2, whole.leg_length, whole.frame_time)
    for start in range(0, len(whole), hop):
        grid.add(cut(whole, start, start + hop))
    known = resample(whole).tracks
    assert np.allclose(grid.steps.view(0)[:, 4], known.feet[0].toe, atol=1e-12)
    assert np.allclose(grid.steps.view(0)[:, 0], known.pelvis, atol=1e-12)


def plane(pelvis: Floats, feet: Floats) -> Complexes:
    """(n, 1 + 2 feet) velocities of a pelvis (n, 2), heels and toes (feet, n, 2, 2) as complex numbers."""
    both = np.concatenate([pelvis[:, None], *feet.transpose(2, 1, 0, 3)], axis=1)
    return np.asarray(both[..., 0] + 1j * both[..., 1])


@pytest.mark.parametrize("hop", [1, 4, 30])
def test_velocities_and_facing_that_are_kept_are_those_of_the_whole_clip(hop: int) -> None:
    whole = cut(tracks("turn"), 0, 130)
    sampled = resample(whole)
    grid, over = Grid(2, whole.leg_length, whole.frame_time), OverGround(sampled.mates)
    for start in range(0, len(whole), hop):
        over.follow(grid.steps, grid.add(cut(whole, start, start + hop)))
    n = grid.steps.end
    feet = np.stack([velocities(foot) for foot in sampled.tracks.feet])
    assert np.allclose(over.velocity(n), plane(velocity_of(sampled.tracks.pelvis[:, ::2]), feet), atol=1e-9)
    assert np.allclose(over.speed(n), np.stack([slowest(foot) for foot in feet], axis=1), atol=1e-9)
    facing = over.facing()
    forward, outward = sampled.axes[1]
    assert np.allclose(facing.outward[:, 1], outward[:, 0] + 1j * outward[:, 1], atol=1e-9)
    along = sampled.tracks.feet[1].toe - sampled.tracks.feet[1].heel
    assert np.allclose(facing.ahead[:, 1], np.sum(along[:, ::2] * forward, axis=1), atol=1e-9)


def test_evidence_of_the_newest_steps_is_that_of_the_whole_clip() -> None:
    whole = cut(tracks("walk_skate"), 0, 110)
    grid = Grid(2, whole.leg_length, whole.frame_time)
    grid.add(whole)
    sampled = resample(whole)
    over = OverGround(sampled.mates)
    over.follow(grid.steps, 0)
    found = newest_evidence(grid.steps.view(0), over.facing(), 60, sampled.mates, sampled.jitter)
    network = weights.network()
    for ours, theirs in zip(found, evidence(sampled), strict=True):
        assert np.allclose(ours, theirs[-60:], atol=1e-9)
    answers = logits(network, found, 20)
    assert np.allclose(answers[1], network.logits(evidence(sampled)[1])[-20:], atol=1e-9)


@pytest.mark.parametrize("name", ["walk_skate", "turn"])
def test_steps_of_feet_that_look_planted_are_those_of_the_whole_clip(name: str) -> None:
    whole = cut(tracks(name), 0, 200)
    sampled, params = resample(whole), AutoParams().stepping
    n = len(sampled.tracks)
    feet = np.stack([velocities(foot) for foot in sampled.tracks.feet])  # (feet, n, 2, 2)
    pelvis = velocity_of(sampled.tracks.pelvis[:, ::2])
    answers = np.log(np.random.default_rng(2).dirichlet(np.ones(4), (2, n)))
    known = stepping_of_clip(tuple(answers), sampled.mates, pelvis, list(feet), params)
    velocity, speeds = plane(pelvis, feet), np.stack([slowest(foot) for foot in feet], axis=1)
    for count in (n, 60):
        steps = stepping(answers[:, -count:], sampled.mates, velocity[-count:], speeds, params)
        found = stands(answers[:, -count:], steps)
        assert np.allclose(found[:, 30:], np.stack(known)[:, -count:][:, 30:], atol=1e-9)  # steps begun before that


@pytest.mark.parametrize("foot", [0, 1, 2, 3])
@pytest.mark.parametrize(("speeds", "swings", "steps"), [
    ((1.0, 0.0, 0.0), 0.97, True), ((1.0, 1.0, 1.0), 0.97, False),  # fast: alone, or with all of the figure
    ((0.4, -0.4, 0.0), 0.01, True), ((0.4, 0.4, 0.4), 0.01, False),  # not so fast: both apart, or all skate
])  # fmt: skip
def test_steps_of_any_foot_of_four_are_those_of_the_whole_clip(
    foot: int, speeds: tuple[float, float, float], swings: float, steps: bool
) -> None:
    n, mates, params = 400, (1, 0, 3, 2), AutoParams().stepping
    pelvis, feet = np.zeros((n, 2)), np.zeros((4, n, 2, 2))
    feet[foot, 150:180, :, 0], feet[mates[foot], 150:180, :, 0], pelvis[150:180, 0] = speeds
    swing = np.where(np.arange(4) == mates[foot], swings, 0.01)[:, None]
    answers = np.log(np.repeat(np.concatenate([swing, *[(1.0 - swing) / 3.0] * 3], axis=1)[:, None], n, axis=1))
    known = np.stack(stepping_of_clip(tuple(answers), mates, pelvis, list(feet), params))
    slow = np.stack([slowest(each) for each in feet], axis=1)
    found = stands(answers, stepping(answers, mates, plane(pelvis, feet), slow, params))
    assert np.allclose(found, known, atol=1e-9)
    assert (np.exp(known[foot, 165, 0]) > 0.9) == steps


def test_feet_that_go_ahead_of_the_pelvis_are_those_of_the_whole_clip_where_its_travel_is_known() -> None:
    whole = cut(tracks("walk_skate"), 0, 200)
    sampled, params = resample(whole), AutoParams().overtaking
    places, n = sampled.tracks.pelvis[:, ::2], len(sampled.tracks)
    velocity = plane(velocity_of(places), np.stack([velocities(foot) for foot in sampled.tracks.feet]))
    answers = np.log(np.random.default_rng(4).dirichlet(np.ones(4), (2, n)))
    known = np.stack(
        overtaking_of_clip(tuple(answers), sampled.tracks.pelvis[:, ::2], *velocities_of(sampled.tracks), params)
    )
    assert np.abs(known - answers).max() > 1.0, "some go ahead"
    assert np.allclose(stands(answers, overtaking(places, velocity, params)), known, atol=1e-9)
    early = round(params.lasting / STEP)  # the stream is this far from the end
    found = stands(answers[:, : n - early], overtaking(places[: n - early], velocity[: n - early], params))
    assert np.allclose(found[:, : n - 2 * early], known[:, : n - 2 * early], atol=1e-9)
    decided = np.exp(found[:, n - 2 * early :, 0]) - np.exp(known[:, n - 2 * early : n - early, 0])
    assert np.abs(decided).mean() < 0.02, "one who walks on travels before as after"


def test_a_filter_of_few_values_is_that_of_a_clip() -> None:
    x = np.random.default_rng(3).normal(size=(50, 2, 3))
    for window in ({"seconds": 0.09, "degree": 2, "derivative": 2}, {"seconds": 0.25, "degree": 1}):
        assert np.allclose(filtered(x, **window), savgol(x, STEP, **window), atol=1e-9)  # type: ignore[arg-type]


@pytest.mark.parametrize("count", [20, 90])
def test_floors_of_the_newest_steps_are_those_of_a_clip(count: int) -> None:
    x = np.random.default_rng(6).normal(size=(3, 90))
    lowest = Lowest(x, 0.6, count)
    ahead, behind = floors(x[2], 0.4)
    assert np.array_equal(lowest.ahead(0.4, slice(2, 3))[0], ahead[-count:])
    assert np.array_equal(lowest.behind(0.4, slice(2, 3))[0], behind[-count:])
    assert np.array_equal(lowest.behind(0.6, slice(0, 1))[0], floors(x[0], 0.6)[1][-count:])


@pytest.mark.parametrize("name", ["walk_skate", "run", "stairs"])
def test_contacts_are_those_of_the_whole_clip_but_for_a_few_frames(name: str) -> None:
    whole = cut(tracks(name), 0, 140)
    sampled = resample(whole)
    detector = Detector(
        [foot.side for foot in whole.feet], sampled.mates, sampled.jitter, whole.leg_length, whole.frame_time, 0.15,
        AutoParams(),
    )  # fmt: skip
    ahead = round(0.15 / whole.frame_time)
    told = np.zeros((len(whole), 4), dtype=np.bool_)
    for frame in range(len(whole)):
        detector.add(cut(whole, frame, frame + 1))
        detector.compute_evidence()
        detector.compute_probabilities()
        if frame >= ahead:
            told[frame - ahead] = detector.find_contacts(frame - ahead).down[0]
    told[-ahead:] = detector.find_contacts(len(whole) - ahead).down
    assert np.mean(told == auto(whole, AutoParams()).mask) > 0.97

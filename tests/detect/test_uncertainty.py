"""Frame rates that a motion can't have: steps that last too long or too short, and falls slower than gravity."""

from __future__ import annotations

import numpy as np
import pytest
from walker import make
from walker_plan import Gait

from footfix.detect.tracks import FootTracks, Tracks, tracks_of
from footfix.detect.uncertainty import DoubtParams, frame_rate
from footfix.notes import Note
from footfix.rig.find import find_rig


def told(name: str, slower: float, duration: float = 3.0) -> tuple[Note, ...]:
    """What is said of a walker's clip at 120 fps whose declared rate is so many times lower."""
    clip = make(Gait(name=name, fps=120.0, duration=duration)).clip  # type: ignore[arg-type]
    tracks = tracks_of(clip, find_rig(clip))
    slow = Tracks(tracks.pelvis, tracks.feet, tracks.leg_length, tracks.frame_time * slower)
    return frame_rate(slow, DoubtParams())


@pytest.mark.parametrize("name", ["walk", "run", "backwards", "curve", "jump"])
def test_data_of_120_fps_declared_as_30_or_24_is_doubted_and_as_it_is_not(name: str) -> None:
    assert told(name, 1.0) == ()
    for slower in (4.0, 5.0):
        (note,) = told(name, slower)
        assert note.id == "frame-rate-implausible" and note.severity == "warning"
        assert f"{120.0 / slower:g} fps" in note.text


def leap(seconds: float, fps: float, fall: float = 9.81, lift: float = 0.4) -> Tracks:
    """A figure that stands, leaps with both feet, and stands; the pelvis flies a parabola of `fall` [m/s^2]."""
    t = (np.arange(round(3.0 * seconds * fps)) / fps - 1.5 * seconds) / (0.5 * seconds)
    flight = np.maximum(1.0 - t**2, 0.0)
    up = np.stack([0.0 * t, flight, 0.0 * t], axis=1)
    pelvis = [0.0, 0.9, 0.0] + 0.5 * fall * (0.5 * seconds) ** 2 * up
    off = lift * up
    feet = tuple(
        FootTracks(side, up + [x, 0.88, 0.0], off + [x, 0.1, 0.0], off + [x, 0.0, -0.05], off + [x, 0.0, 0.1])
        for side, x in (("left", 0.1), ("right", -0.1))
    )
    return Tracks(pelvis, feet, 0.88, 1.0 / fps)


@pytest.mark.parametrize("size", [1.0, 0.01, 5.0])
def test_who_falls_slower_than_gravity_was_made_at_another_rate(size: float) -> None:
    """A leap of 0.5 s at 120 fps, declared as 30, lasts 2 s: a sixteenth of gravity, whatever the unit of the file."""

    def sized(tracks: Tracks) -> Tracks:
        feet = (FootTracks(f.side, size * f.hip, size * f.ankle, size * f.heel, size * f.toe) for f in tracks.feet)
        return Tracks(size * tracks.pelvis, tuple(feet), size * tracks.leg_length, tracks.frame_time)

    assert frame_rate(sized(leap(0.5, 120.0)), DoubtParams()) == ()
    (note,) = frame_rate(sized(leap(2.0, 30.0, 9.81 / 16.0)), DoubtParams())
    assert "16 times slower than gravity" in note.text and "about 120 fps" in note.text
    assert frame_rate(sized(leap(2.0, 30.0, 9.81 / 16.0, lift=0.05)), DoubtParams()) == ()  # the feet hardly leave


@pytest.mark.parametrize("seconds", [0.2, 0.3])  # a hop in which the pelvis rises by 5 or 11 cm
@pytest.mark.parametrize("times", [2.0, 3.0, 5.0])
def test_a_low_hop_at_half_of_its_rate_is_told_too(seconds: float, times: float) -> None:
    made = 120.0
    assert frame_rate(leap(seconds, made, lift=0.1), DoubtParams()) == ()
    (note,) = frame_rate(leap(times * seconds, made / times, 9.81 / times**2, lift=0.1), DoubtParams())
    assert f"about {made:.0f} fps" in note.text


@pytest.mark.parametrize("fps", [24, 25, 30, 48, 50, 60, 90, 100, 120, 150, 200, 240, 250, 300])
def test_the_rate_that_is_named_is_the_nearest_of_those_in_use(fps: int) -> None:
    """A leap of half a second declared as one of 2 s: at a quarter of the rate it was made at."""
    (note,) = frame_rate(leap(2.0, fps / 4.0, 9.81 / 16.0), DoubtParams())
    assert f"about {fps:.0f} fps" in note.text


@pytest.mark.parametrize(("hertz", "told"), [(0.25, True), (0.35, True), (0.6, False), (1.5, False)])
def test_feet_that_speed_up_and_slow_down_as_nobodys_do_move_in_slow_motion(hertz: float, told: bool) -> None:
    t = np.arange(300) / 24.0
    swing = 0.3 * np.sin(2.0 * np.pi * hertz * t)[:, None] * np.array([0.0, 0.0, 1.0])
    still = np.zeros((len(t), 3))
    feet = tuple(
        FootTracks(side, still + [x, 0.9, 0.0], swing + [x, 0.1, 0.0], swing + [x, 0.0, 0.0], swing + [x, 0.0, 0.2])
        for side, x in (("left", 0.1), ("right", -0.1))
    )
    notes = frame_rate(Tracks(still + [0.0, 1.0, 0.0], feet, 0.88, 1.0 / 24.0), DoubtParams())
    assert bool(notes) == told


@pytest.mark.parametrize(("rhythm", "slow"), [(0.25, True), (0.8, False)])  # [Hz]
@pytest.mark.parametrize("noise", [0.0, 0.004])  # [m]
def test_feet_that_never_hurry_are_in_slow_motion_however_noisy(rhythm: float, slow: bool, noise: float) -> None:
    random = np.random.default_rng(4)
    t = np.arange(300) / 30.0
    swing = np.stack([0.0 * t, 0.0 * t, 0.25 * np.sin(2.0 * np.pi * rhythm * t)], axis=1)
    feet = tuple(
        FootTracks(side, *(swing + [x, y, 0.0] + random.normal(0.0, noise, swing.shape) for y in (0.88, 0.1, 0.0, 0.0)))
        for side, x in (("left", 0.1), ("right", -0.1))
    )
    notes = frame_rate(Tracks(0.0 * swing + [0.0, 0.9, 0.0], feet, 0.88, 1.0 / 30.0), DoubtParams())
    assert ["slow motion" in note.text for note in notes] == [True] * slow

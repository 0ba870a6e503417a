"""What comes out of a stream: every frame, in time, with feet that stand and joints that don't jump."""

from __future__ import annotations

import numpy as np
import pytest
from streams import FRAMES, sample, streamed

import footfix
from footfix.motion import rotation
from footfix.motion.clip import Clip
from footfix.motion.contacts import runs
from footfix.motion.kinematics import forward
from footfix.settings import Settings
from footfix.stream.engine import HOP, frames_of
from footfix.stream.session import Live, StreamParams


def clip_of(name: str, values: np.ndarray) -> Clip:  # type: ignore[type-arg]
    from footfix.formats.bvh.channels import placed, to_clip

    file = sample(name)
    own = to_clip(file.skeleton, file.channels, values, file.base, file.frame_time)
    return placed(own, file.unit_m, file.up)


@pytest.mark.parametrize("name", ["walk_skate", "turn"])
def test_every_frame_comes_out_once_in_order_and_one_for_one(name: str) -> None:
    values, frames, most = streamed(name)
    assert [frame.number for frame in frames] == list(range(FRAMES))  # type: ignore[attr-defined]
    assert most == 1
    assert values.shape == sample(name).values[:FRAMES].shape


@pytest.mark.parametrize("look_ahead", [0.0, 0.15])
def test_no_frame_waits_longer_than_look_ahead_and_a_thirtieth_of_a_second(look_ahead: float) -> None:
    file = sample("walk_skate")
    stream = footfix.Stream(file, look_ahead)
    last = -1
    for number, row in enumerate(file.values[:40]):
        for frame in stream.push(row):
            last = frame.number
        assert (number - last - 1) * file.frame_time <= look_ahead + 1.0 / 30.0 + 1e-9
    assert stream.delay <= look_ahead + 1.0 / 30.0 + 1e-9


@pytest.mark.parametrize("name", ["walk_skate", "turn"])
def test_feet_that_are_told_to_stand_stand(name: str) -> None:
    values, frames, _ = streamed(name)
    before, after = sample(name).clip.frames(slice(FRAMES)), clip_of(name, values)
    rig = footfix.find_rig(before)
    contacts = np.stack([frame.contacts for frame in frames])  # type: ignore[attr-defined]
    slides = []
    pose = forward(after)
    for e, sole in enumerate(rig.soles):
        toe = rig.legs[sole.leg].toe
        for a, b in runs(contacts[:, e]):
            if sole.part == "toe" and toe is not None and b - a >= 5:
                track = pose.position(toe)[a + 1 : b - 1][:, ::2]
                slides.append(1e3 * np.hypot(*(track - np.median(track, axis=0)).T).max())
    assert len(slides) >= 2
    assert max(slides) < 1.0


@pytest.mark.parametrize("name", ["walk_skate", "turn"])
def test_no_joint_jumps_by_over_two_degrees_more_than_it_did(name: str) -> None:
    values, _, _ = streamed(name)
    before, after = sample(name).clip.frames(slice(FRAMES)), clip_of(name, values)
    for leg in footfix.find_rig(before).legs:
        for joint in leg.chain:
            was, now = (
                np.degrees(rotation.angle(rotation.multiply(rotation.inverse(turns[:-1]), turns[1:])))
                for turns in (before.rotation(joint), after.rotation(joint))
            )
            near = np.maximum(was, np.maximum(np.append(was[1:], was[-1]), np.append(was[0], was[:-1])))
            assert (now - near).max() <= 2.0 * 120.0 * before.frame_time


@pytest.mark.parametrize(("frame_time", "hop"), [(0.016667, 2), (0.0083334, 4), (0.0333333, 1), (1.0 / 240.0, 8)])
def test_a_hop_is_a_thirtieth_of_a_second_however_the_rate_is_rounded(frame_time: float, hop: int) -> None:
    assert frames_of(HOP, frame_time) == hop
    assert frames_of(0.15, frame_time) == round(0.15 / frame_time - 0.4)


def test_no_frame_takes_more_than_its_share_of_a_hops_parts() -> None:
    file = sample("walk_skate")
    clip = file.clip
    stream = Live(clip.skeleton, 1.0 / 120.0, Settings(), StreamParams(), known=clip)
    rows = np.concatenate([clip.positions.reshape(len(clip), -1), clip.rotations.reshape(len(clip), -1)], axis=1)
    stream.push(rows[:40])
    engine = stream._engine
    assert engine is not None
    done = []
    for row in rows[40:80]:
        before = 0 if len(engine._hop) == engine.hop - 1 else engine._work.done
        stream.push(row[None])
        done.append(engine._work.done - before)
    assert max(done) <= 2
    assert sum(done) == 8 * 10


def test_frames_pushed_at_once_are_those_pushed_one_by_one() -> None:
    file = sample("walk_skate")
    stream = footfix.Stream(file)
    frames = stream.push(file.values[:FRAMES]) + stream.close()
    assert np.array_equal(np.stack([frame.values for frame in frames]), streamed("walk_skate")[0])


def test_a_stream_of_arrays_is_that_of_the_file() -> None:
    file = sample("walk_skate")
    clip = file.clip
    stream = footfix.Stream(clip.skeleton, frame_time=clip.frame_time, calibrate_on=clip)
    frames = stream.push(clip.frames(slice(FRAMES))) + stream.close()
    known = clip_of("walk_skate", streamed("walk_skate")[0])
    assert np.allclose(np.stack([frame.positions for frame in frames]), known.positions, atol=1e-6)


@pytest.mark.parametrize("before", ["pass", "wait"])
def test_frames_before_calibration_pass_as_they_are_or_wait(before: str) -> None:
    file = sample("walk_skate")
    header = footfix.load(str(file.name))
    live = Live(header, file.frame_time, Settings(), StreamParams(calibration=1.0, before=before))  # type: ignore[arg-type]
    shown = [each for row in file.values[:FRAMES] for each in live.push(row[None])] + live.close()
    rows = np.stack([each.row for each in shown])
    assert [each.number for each in shown] == list(range(FRAMES))
    early = round(1.0 / file.frame_time) - live.delay - 1
    assert np.array_equal(rows[:early], file.values[:early]) == (before == "pass")
    assert not np.array_equal(rows, file.values[:FRAMES])


def test_nothing_depends_on_how_long_calibration_takes() -> None:
    file, found = sample("walk_skate"), []
    for waits in (True, False):
        live, shown = Live(file, file.frame_time, Settings(), StreamParams(calibration=0.8)), []
        for row in file.values[:FRAMES]:
            if waits and live._coming is not None:
                live._coming.result()
            shown += live.push(row[None])
        found.append(np.stack([each.row for each in shown + live.close()]))
    assert np.array_equal(*found)
    assert not np.array_equal(found[0], file.values[:FRAMES])


def test_a_stream_goes_on_after_a_restart_and_counts_on() -> None:
    file = sample("walk_skate")
    live = Live(file, file.frame_time, Settings(), StreamParams(), known=file)
    shown = live.push(file.values[:30]) + live.restart(file.frame_time) + live.push(file.values[:20]) + live.close()
    assert [each.number for each in shown] == list(range(50))


def test_strikes_and_lifts_alternate_and_bound_the_contacts() -> None:
    _, frames, _ = streamed("walk_skate")
    stream = footfix.Stream(sample("walk_skate"))
    for e, name in enumerate(stream.effectors):
        told = [event for frame in frames for event in frame.events if event.effector == name]  # type: ignore[attr-defined]
        assert [event.kind for event in told] == ["strike", "lift"] * (len(told) // 2) + ["strike"] * (len(told) % 2)
        contacts = np.array([frame.contacts[e] for frame in frames])  # type: ignore[attr-defined]
        starts = [a for a, _ in runs(contacts)]
        assert [event.frame for event in told if event.kind == "strike"] == starts
        assert all(0.0 <= event.confidence <= 1.0 for event in told)


def test_what_is_no_stream_is_refused_in_words() -> None:
    file = sample("walk_skate")
    with pytest.raises(footfix.ArgumentError, match="frame_time"):
        footfix.Stream(file.clip.skeleton)
    with pytest.raises(footfix.ArgumentError, match="rows must be"):
        footfix.Stream(file).push(np.zeros((2, 3)))
    with pytest.raises(footfix.ArgumentError, match="NaN"):
        footfix.Stream(file).push(np.full(len(file.channels), np.nan))
    with pytest.raises(footfix.UsageError, match="look_ahead"):
        footfix.Stream(file, look_ahead=60.0)
    with pytest.raises(footfix.UsageError, match="whole clip"):
        footfix.Stream(file, settings=footfix.make_settings(None, {"detect.method": "threshold"}))

"""Frames that stand twice are found, left out, and put back; a pause is none of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from walker import make
from walker_plan import Gait

from footfix.motion.clip import Clip, Ints
from footfix.motion.contacts import Contact, Contacts, Effector
from footfix.motion.duplicate_frames import doubled
from footfix.notes import Note

FRAMES = 90


def walking() -> Clip:
    return make(Gait(fps=30.0, duration=(FRAMES - 1) / 30.0)).clip


def of(clip: Clip, frames: Ints, fps: float) -> Clip:
    return replace(clip.frames(frames), frame_time=1.0 / fps)


@pytest.mark.parametrize(("pattern", "fps"), [((2,), 60.0), ((3,), 90.0), ((3, 2), 75.0), ((1, 1, 1, 2), 37.5)])
def test_the_clip_without_what_is_repeated_is_the_one_at_the_true_rate(pattern: tuple[int, ...], fps: float) -> None:
    clip = walking()
    counts = np.resize(pattern, FRAMES)
    long = of(clip, np.repeat(np.arange(FRAMES), counts), fps)
    found = doubled(long)
    assert found and found.share == pytest.approx(1.0 - FRAMES / len(long))
    own = found.clip(long)
    assert np.array_equal(own.positions, clip.positions) and np.array_equal(own.rotations, clip.rotations)
    assert own.frame_time == pytest.approx(clip.frame_time, rel=0.02)
    assert np.array_equal(found.owner, np.repeat(np.arange(FRAMES), counts))
    assert np.array_equal(found.track_back(own.position(0)), long.position(0))
    (note,) = found.notes(long)
    assert note.id == "frames-doubled" and "30" in note.text and f"{100.0 * found.share:.0f} %" in note.text


@pytest.mark.parametrize("counts", [(2,), (3, 2), (1,) * 11 + (2,)])
def test_what_differs_by_rounding_is_repeated_too(counts: tuple[int, ...]) -> None:
    at = np.repeat(np.arange(FRAMES), np.resize(counts, FRAMES))
    long = of(walking(), at, 60.0)
    rng = np.random.default_rng(1)
    noise = np.where(np.diff(at, prepend=-1) == 0, 1e-5, 0.0)  # [m]
    noisy = long.with_joints({0: long.position(0) + noise[:, None] * rng.normal(size=(len(at), 3))}, {})
    assert np.array_equal(doubled(noisy).owner, at)
    signs = np.where(np.arange(len(at)) % 3, 1.0, -1.0)[:, None]  # q and -q are one rotation
    assert np.array_equal(doubled(long.with_joints({}, {0: signs * long.rotation(0)})).owner, at)


def test_noise_of_a_figure_that_stands_is_no_repetition() -> None:
    clip = walking()
    still = np.concatenate([np.arange(40), np.full(30, 40), np.arange(40, FRAMES)])
    pause = of(clip, still, 30.0)
    noise = 1e-5 * np.random.default_rng(2).normal(size=(len(still), 3))  # [m]
    assert not doubled(pause.with_joints({0: pause.position(0) + noise}, {}))
    slowing = clip.frames(np.arange(FRAMES)).with_joints(
        {0: clip.position(0)[0] + np.outer(np.exp(-0.5 * np.arange(FRAMES)), [1.0, 0.0, 0.0])},
        {joint: np.repeat(clip.rotation(joint)[:1], FRAMES, axis=0) for joint in range(len(clip.skeleton))},
    )
    assert not doubled(slowing)


def test_what_moves_in_every_frame_or_pauses_is_left_whole() -> None:
    clip = walking()
    pause = np.concatenate([np.arange(40), np.full(30, 40), np.arange(40, FRAMES)])
    once = np.insert(np.arange(FRAMES), 20, 20)
    for frames in (np.arange(FRAMES), pause, once, np.zeros(60, dtype=np.intp)):
        whole = of(clip, frames, 30.0)
        found = doubled(whole)
        assert not found and found.clip(whole) is whole and found.notes(whole) == ()


def test_a_pause_among_doubled_frames_is_as_long_as_it_was() -> None:
    pause = np.concatenate([np.arange(40), np.full(20, 40), np.arange(41, FRAMES)])
    long = of(walking(), np.repeat(pause, 2), 60.0)
    found = doubled(long)
    assert np.array_equal(found.clip(long).rotations, long.rotations[::2])


def test_contacts_and_notes_go_there_and_back() -> None:
    clip = walking()
    found = doubled(of(clip, np.repeat(np.arange(FRAMES), 2), 60.0))
    own = tuple(Contact(a, b, 0.5) for a, b in ((0, 3), (10, 30), (80, FRAMES)))
    contacts = Contacts(FRAMES, 1.0 / 30.0, (Effector("left_toe", "left", "toe", "LeftToeBase", own),),
                        notes=(Note("a", "b", start=10, end=FRAMES),))  # fmt: skip
    long = found.contacts_back(contacts)
    assert [(c.start, c.end) for c in long["left_toe"].contacts] == [(0, 6), (20, 60), (160, 2 * FRAMES)]
    assert long.frames == 2 * FRAMES and long.frame_time == pytest.approx(1.0 / 60.0)
    assert (long.notes[0].start, long.notes[0].end) == (20, 2 * FRAMES)
    assert found.contacts(long).effectors == contacts.effectors
    odd = replace(long, effectors=(replace(long.effectors[0], contacts=(Contact(21, 59),)),))
    assert [(c.start, c.end) for c in found.contacts(odd)["left_toe"].contacts] == [(10, 30)]
    wide = found.among(5, 2 * FRAMES + 7)
    assert np.array_equal(wide.kept, [*range(5), *range(5, 2 * FRAMES + 5, 2), 2 * FRAMES + 5, 2 * FRAMES + 6])

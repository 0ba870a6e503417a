"""Cuts: whole strides, in poses that are alike; and a clear word where there are none."""

from __future__ import annotations

from dataclasses import replace

import artefacts
import numpy as np
import pytest
from walker import make
from walker_gaits import Gait
from walks import rig_of, walk

from footfix.errors import InputError
from footfix.locomotion.loop.cut_search import Cut, find_cuts
from footfix.locomotion.loop.cyclic_contacts import wrapped
from footfix.locomotion.loop.params import LoopParams
from footfix.locomotion.loop.point_cloud import clouds, distances, fit
from footfix.locomotion.loop.strides import count_strides, find_strides
from footfix.motion.contacts import Contact, Contacts

PERIODS = [(name, fps) for name in ("walk", "run", "curve", "backwards", "sideways") for fps in (30.0, 60.0)]


def truth(contacts: Contacts) -> list[int]:
    """The lengths of strides in frames, from strike to strike and from lift to lift of either foot."""
    mask, found = contacts.mask(), []
    for leg in (0, 2):
        down = mask[:, leg : leg + 2].any(axis=1).astype(int)
        for change in (1, -1):
            found += np.diff(np.flatnonzero(np.diff(down) == change)).tolist()
    return found


@pytest.mark.parametrize(("name", "fps"), PERIODS)
def test_a_round_is_one_whole_stride_of_the_walker(name: str, fps: float) -> None:
    made = walk(name, fps, 4.0)
    best = find_cuts(made.clip, rig_of(made), made.contacts, LoopParams())[0]
    known = truth(made.contacts)
    assert best.strides == 1
    assert min(abs(best.end - best.start - each) for each in known) <= 1


@pytest.mark.parametrize("strides", [1, 2, 3])
def test_so_many_strides_as_are_asked_for(strides: int) -> None:
    made = walk(duration=5.0)
    rig = rig_of(made)
    best = find_cuts(made.clip, rig, made.contacts, LoopParams(strides=strides))[0]
    usual = float(np.median(truth(made.contacts)))
    assert best.strides == strides
    assert abs(best.end - best.start - strides * usual) <= 1 + strides
    assert count_strides(wrapped(made.contacts, best.start, best.end - best.start), rig) == strides


def test_frames_given_by_hand_are_taken_and_one_finds_the_other() -> None:
    made = walk()
    rig = rig_of(made)
    both = find_cuts(made.clip, rig, made.contacts, LoopParams(start=40, end=99))
    assert [(cut.start, cut.end) for cut in both] == [(40, 99)]
    usual = float(np.median(truth(made.contacts)))
    (ahead,) = find_cuts(made.clip, rig, made.contacts, LoopParams(start=40))
    assert (ahead.start, abs(ahead.end - 40 - usual) <= 1.5) == (40, True)
    (back,) = find_cuts(made.clip, rig, made.contacts, LoopParams(end=110))
    assert (back.end, abs(110 - back.start - usual) <= 1.5) == (110, True)


def test_half_a_stride_is_no_stride_even_where_a_plant_was_not_found() -> None:
    made = walk(duration=5.0)
    rig = rig_of(made)
    gone = made.contacts["right_toe"].contacts[1]
    effectors = tuple(
        replace(e, contacts=tuple(c for c in e.contacts if c.end < gone.start - 20 or c.start > gone.end + 20))
        if e.side == "right"
        else e
        for e in made.contacts.effectors
    )
    holed = replace(made.contacts, effectors=effectors)
    usual = float(np.median(truth(made.contacts)))
    for own in find_strides(holed, rig):
        assert all(abs(stride.frames - usual) < 0.2 * usual for stride in own)


def test_clouds_are_as_far_apart_as_the_best_turn_and_shift_leave_them() -> None:
    made = walk()
    rig = rig_of(made)
    moved = artefacts.turned(made.clip, 1.1, (3.0, -2.0))
    here, there = (clouds(clip, rig, np.array([50, 70]), 0.1) for clip in (made.clip, moved))
    assert np.allclose(np.diag(distances(here, there)), 0.0, atol=1e-7)
    assert np.allclose(distances(here, there), distances(here, here), atol=1e-7)
    gap = distances(here, here)[0, 1]
    assert gap > 0.01
    two = fit(made.clip, rig, 50, 70, 0.0)
    assert two.z == pytest.approx(20 / 60 * 1.3, rel=0.25)  # [m] a walk of 1.3 m/s along z


@pytest.mark.parametrize(
    ("gait", "word"),
    [
        (Gait(name="stand", duration=3.0, fps=30.0), "a cycle needs two plants of one foot"),
        (Gait(name="jump", duration=4.0, fps=30.0), "no cycle found"),
    ],
    ids=lambda each: each.name if isinstance(each, Gait) else "",
)
def test_what_is_no_walk_gets_a_clear_word(gait: Gait, word: str) -> None:
    made = make(gait)
    with pytest.raises(InputError, match=word):
        find_cuts(made.clip, rig_of(made), made.contacts, LoopParams())


def test_one_step_gets_a_clear_word_and_so_do_frames_that_are_not_there() -> None:
    made = walk()
    rig = rig_of(made)
    step = slice(0, 40)
    few = replace(
        made.contacts, frames=40,
        effectors=tuple(
            replace(e, contacts=tuple(replace(c, end=min(c.end, 40)) for c in e.contacts if c.start < 40))
            for e in made.contacts.effectors
        ),
    )  # fmt: skip
    with pytest.raises(InputError, match="no cycle found"):
        find_cuts(made.clip.frames(step), rig, few, LoopParams())
    with pytest.raises(InputError, match="no part of a clip of"):
        find_cuts(made.clip, rig, made.contacts, LoopParams(start=3, end=5000))
    with pytest.raises(InputError, match="does not hold 9 strides on end"):
        find_cuts(made.clip, rig, made.contacts, LoopParams(strides=9))


def test_what_stands_at_the_seam_stands_at_both_of_its_ends() -> None:
    spans = ((5, 30), (70, 95))
    one = walk().contacts
    known = replace(one, effectors=(replace(one.effectors[0], contacts=tuple(Contact(*s) for s in spans)),))
    over = wrapped(known, 20, 60).effectors[0].contacts
    assert [(c.start, c.end) for c in over] == [(0, 10), (50, 61)]
    before = wrapped(known, 29, 60).effectors[0].contacts  # all but a frame of the first is over, the second stands
    assert [(c.start, c.end) for c in before] == [(0, 1), (41, 61)]
    alone = wrapped(known, 32, 37).effectors[0].contacts  # the second begins as the round ends: hardly anything of it
    assert alone == ()
    assert (over[0].start, isinstance(Cut(0, 1, 0, 1, 0, 0.0).cost, float)) == (0, True)

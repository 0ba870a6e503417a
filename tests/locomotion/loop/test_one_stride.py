"""The one stride of a short clip."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from walks import rig_of, walk

from footfix.enforce.params import EnforceParams
from footfix.errors import InputError
from footfix.locomotion.loop.one_stride import single_stride
from footfix.locomotion.loop.params import LoopParams
from footfix.locomotion.loop.run import Loop, make_loop
from footfix.motion.clip import Clip
from footfix.motion.contacts import Contact, Contacts, runs
from footfix.rig.motion_crop import Crop


@cache
def cut(name: str, start: int, frames: int) -> tuple[Clip, Contacts]:
    made = walk(name, 60.0)
    crop = Crop(start, start + frames, len(made.clip))
    return crop.clip(made.clip), crop.contacts(made.contacts)


def period(name: str) -> int:
    """[frames] between the first two times that a foot comes down within the clip."""
    down = walk(name, 60.0).contacts.mask()[:, :2].any(axis=1)
    first, second = (np.flatnonzero(np.diff(down.astype(int)) == 1) + 1)[:2]
    return int(second - first)


@pytest.mark.parametrize(("name", "start"), [("walk", 60), ("run", 75), ("curve", 90)])
def test_one_stride_is_a_cycle_wherever_it_begins(name: str, start: int) -> None:
    length = period(name)
    clip, contacts = cut(name, start, length + 1)
    found = make_loop(clip, rig_of(walk(name, 60.0)), contacts, LoopParams(), EnforceParams())
    assert isinstance(found, Loop)
    assert abs(found.end - found.start - length) <= 1
    assert found.strides == 1


@pytest.mark.parametrize("start", [60, 75, 90])
def test_half_a_stride_is_none_though_its_poses_look_alike(start: int) -> None:
    half = period("walk") // 2
    clip, contacts = cut("walk", start, half + 1)
    assert single_stride(clip, rig_of(walk("walk", 60.0)), contacts, LoopParams()) == ()
    with pytest.raises(InputError, match="no cycle found"):
        make_loop(clip, rig_of(walk("walk", 60.0)), contacts, LoopParams(), EnforceParams())


def test_a_figure_that_stands_first_and_last_has_gone_no_cycle() -> None:
    clip, contacts = cut("walk", 60, period("walk") + 1)
    frames = np.concatenate([np.zeros(30, int), np.arange(len(clip)), np.full(30, len(clip) - 1)])
    plants = tuple(
        replace(e, contacts=tuple(Contact(int(a), int(b)) for a, b in runs(own)))
        for e, own in zip(contacts.effectors, contacts.mask()[frames].T, strict=True)
    )
    told = replace(contacts, frames=len(frames), effectors=plants)
    assert single_stride(clip.frames(frames), rig_of(walk("walk", 60.0)), told, LoopParams()) == ()

"""A solution made anew only where something changed is the one made anew everywhere."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import artefacts
import numpy as np
import pytest
from walks import rig_of, walk

from footfix.enforce import again as module
from footfix.enforce.again import again
from footfix.enforce.aims import aimed, levelled
from footfix.enforce.course import courses
from footfix.enforce.ease import EaseParams
from footfix.enforce.foot import feet, posed
from footfix.enforce.judge import JudgeParams
from footfix.enforce.plants import PlantParams, stances
from footfix.enforce.reach import ReachParams
from footfix.enforce.root import RootParams
from footfix.enforce.solve import LegParams, floors, limbs, solution

PARAMS = LegParams(
    solver="closed", shares=False, strength=1.0, plants=PlantParams(), ease=EaseParams(), reach=ReachParams(),
    root=RootParams(), judge=JudgeParams(),
)  # fmt: skip


def spoilt(gait: str) -> tuple[Any, ...]:
    """A walker that wanders, its legs as they are solved, and its stances."""
    made = walk(gait, duration=20.0)
    rig, clip = rig_of(made), artefacts.wander(made.clip, 0.05)
    pose = posed(clip, rig)
    legs = feet(rig, pose)
    found = stances(made.contacts, legs, clip.frame_time, rig.leg_length, PARAMS.plants)
    ways = courses(found, legs, PARAMS.plants)
    stands = [
        aimed(s, ways[s.leg], rig.leg_length, PARAMS.plants)
        for s in levelled(found, legs, rig.floor, rig.leg_length, PARAMS.plants)
    ]
    return clip, rig, pose, limbs(clip, rig, pose, legs, stands, PARAMS), stands


@pytest.mark.parametrize("gait", ["walk", "turn", "run"])
def test_a_change_is_felt_no_farther_than_it_is_made_anew(gait: str, monkeypatch: pytest.MonkeyPatch) -> None:
    clip, rig, pose, whole, stands = spoilt(gait)
    soft = [np.zeros(len(clip)) for _ in whole]
    before = solution(clip, rig, pose, whole, stands, floors(whole, stands, len(clip)), soft, PARAMS)
    k = len(stands) // 2
    shorter = tuple(replace(plant, start=plant.start + 2, end=plant.end - 1) for plant in stands[k].plants)
    fewer = [*stands[:k], replace(stands[k], plants=shorter), *stands[k + 1 :]]
    changed = np.zeros(len(clip), dtype=bool)
    changed[stands[k].frames] = True

    monkeypatch.setattr(module, "_MOST", 1.0)
    calls: list[int] = []
    monkeypatch.setattr(module, "solution", lambda *args: (calls.append(len(args[0])), solution(*args))[1])
    part = again(clip, rig, pose, whole, fewer, soft, changed, before, PARAMS)
    full = solution(clip, rig, pose, whole, fewer, floors(whole, fewer, len(clip)), soft, PARAMS)
    assert len(calls) == 1 and calls[0] < 0.5 * len(clip)
    for a, b in zip(part.points, full.points, strict=True):
        assert np.abs(a - b).max() < 5e-5
    for joint, q in full.rotations.items():
        assert np.abs(part.rotations[joint] - q).max() < 5e-4
    assert max(np.abs(a - b).max() for a, b in zip(part.points, before.points, strict=True)) > 1e-4


def test_where_a_change_is_felt_farther_all_is_made_anew() -> None:
    clip, rig, pose, whole, stands = spoilt("walk")
    soft = [np.zeros(len(clip)) for _ in whole]
    floor = floors(whole, stands, len(clip))
    elsewhere = [np.full(len(clip), 0.16) for _ in whole]  # everything else was held softly before, too
    before = solution(clip, rig, pose, whole, stands, floor, elsewhere, PARAMS)
    changed = np.zeros(len(clip), dtype=bool)
    changed[stands[3].frames] = True
    after = again(clip, rig, pose, whole, stands, soft, changed, before, PARAMS)
    full = solution(clip, rig, pose, whole, stands, floor, soft, PARAMS)
    assert np.array_equal(after.shift, full.shift)

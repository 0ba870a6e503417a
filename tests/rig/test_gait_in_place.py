"""The ground under a gait in place: found from the feet alone, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from walker import Walk, make
from walker_gaits import Gait
from walks import rig_of

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.rig.gait_in_place import Gait as InPlace
from footfix.rig.gait_in_place import carried, gait_in_place
from footfix.rig.rig import Rig


def made(name: str, fps: float = 60.0, **more: float) -> tuple[Walk, Rig]:
    walk = make(Gait(name=name, fps=fps, duration=4.0, **more))  # type: ignore[arg-type]
    return walk, rig_of(walk)


def held(walk: Walk) -> tuple[Clip, Floats]:
    """The walk with its root's mean travel taken out, and (3,) [m/s] what was taken."""
    place = walk.clip.position(0)
    seconds = walk.clip.frame_time * np.arange(len(place))
    speed = np.polyfit(seconds, place[:, [0, 2]], 1)[0]
    travel = np.array([speed[0], 0.0, speed[1]])
    return walk.clip.with_joints({0: place - seconds[:, None] * travel}, {}), travel


def found(clip: Clip, rig: Rig) -> InPlace | None:
    return gait_in_place(rig, rig.pose(clip), clip.frame_time)


@pytest.mark.parametrize("fps", [24.0, 30.0, 120.0])
@pytest.mark.parametrize("name", ["walk", "run", "sprint", "forefoot-run", "backwards", "treadmill"])
def test_the_ground_passes_as_the_figure_would_have_travelled(name: str, fps: float) -> None:
    walk, rig = made(name, fps)
    clip, travel = held(walk) if name != "treadmill" else (walk.clip, -np.array(walk.belt))
    gait = found(clip, rig)
    assert gait is not None
    assert np.linalg.norm(gait.velocity + travel) < 0.01 * np.linalg.norm(travel)
    seconds = clip.frame_time * (len(clip) - 1)
    assert np.linalg.norm(gait.passed[-1] / seconds + travel) < 0.07 * np.linalg.norm(travel)


@pytest.mark.parametrize("name", ["walk", "run", "turn", "curve", "backwards", "sideways", "stairs", "stairs-down",
                                  "jump", "stand", "tiptoe", "spot-turn"])  # fmt: skip
def test_who_travels_or_stays_for_another_reason_has_no_ground_that_passes(name: str) -> None:
    walk, rig = made(name)
    assert found(walk.clip, rig) is None


def test_feet_that_slide_forth_and_back_are_no_gait() -> None:
    walk, rig = made("stand")
    sway = 0.25 * np.sin(np.linspace(0.0, 12.0 * np.pi, len(walk.clip)))[:, None] * [0.0, 0.0, 1.0]
    assert found(walk.clip.with_joints({0: walk.clip.position(0) + sway}, {}), rig) is None


def test_a_figure_that_is_turned_has_its_ground_turned() -> None:
    walk, rig = made("walk")
    clip, _ = held(walk)
    about = rotation.about_vertical(1.1)
    turned = clip.with_joints(
        {0: rotation.rotate(about, clip.position(0))}, {0: rotation.multiply(about, clip.rotation(0))}
    )  # fmt: skip
    one, other = found(clip, rig), found(turned, rig)
    assert one is not None and other is not None
    assert np.allclose(rotation.rotate(about, one.velocity), other.velocity, atol=1e-9)
    assert np.allclose(rotation.rotate(about, one.passed), other.passed, atol=1e-9)


def test_a_figure_that_is_carried_over_its_ground_stands() -> None:
    walk, rig = made("walk")
    clip, _ = held(walk)
    gait = found(clip, rig)
    assert gait is not None
    over = carried(clip, rig, gait.passed)
    assert found(over, rig) is None
    for track, effector in zip(rig.tracks(rig.pose(over)), walk.contacts.effectors, strict=True):
        for contact in effector.contacts:
            still = track[contact.start : contact.end][:, [0, 2]]
            by_ground = np.linalg.norm(gait.velocity) * clip.frame_time * len(still)
            assert np.linalg.norm(still[-1] - still[0]) < 0.1 * by_ground

"""Gaps: what is between the two ends of a cut, and how fast it grows."""

from __future__ import annotations

import numpy as np
import pytest

from footfix.locomotion.loop.root_motion import Travel
from footfix.locomotion.loop.seam_gap import gaps_below, gaps_of_root
from footfix.motion import rotation
from footfix.motion.clip import Clip, Skeleton

FPS = 60.0
TIME = np.arange(61) / FPS
X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def clip(root: np.ndarray, spins: list[np.ndarray], slides: list[np.ndarray]) -> Clip:
    """A root at places (F, 3) [m] and joints below it, turned by rotation vectors and moved, (F, 3) each."""
    count = len(spins)
    skeleton = Skeleton(tuple("abcdef"[: count + 1]), np.array([-1] + [0] * count), np.zeros((count + 1, 3)))
    places = np.stack([root, *slides], axis=1)
    still = np.zeros((len(TIME), 3))
    turns = np.stack([rotation.from_rotation_vector(each) for each in (still, *spins)], axis=1)
    return Clip(skeleton, places, turns, 1.0 / FPS)


STILL = np.zeros((61, 3))


def test_what_turns_evenly_is_apart_by_its_way_and_has_no_gap_of_speed() -> None:
    moves = clip(STILL, [np.outer(TIME, 0.7 * X), np.outer(TIME, -0.3 * Z)], [np.outer(TIME, X), STILL])
    place, turn = gaps_below(moves, 0, 12, 48)
    assert turn.joints == (1, 2)
    assert np.allclose(turn.value, [0.7 * 0.6 * X, -0.3 * 0.6 * Z], atol=1e-9)
    assert np.allclose(turn.speed, 0.0, atol=1e-9)
    assert place.joints == (1,)  # the other one stays
    assert np.allclose(place.value, [0.6 * X], atol=1e-9)
    assert np.allclose(place.speed, 0.0, atol=1e-9)


def test_what_gets_faster_has_the_gap_of_its_speeds() -> None:
    quicker = clip(STILL, [np.outer(0.5 * TIME**2, X)], [np.outer(0.25 * TIME**2, Z)])
    place, turn = gaps_below(quicker, 0, 12, 48)
    assert np.allclose(turn.speed, [(48 - 12) / FPS * X], atol=1e-6)  # d/dt of t^2 / 2
    assert np.allclose(place.speed, [0.5 * (48 - 12) / FPS * Z], atol=1e-6)


@pytest.mark.parametrize("travel", [Travel(0.0, 0.0, 1.2), Travel(0.5, 0.3, 0.9)])
def test_a_root_that_only_travels_has_no_gap(travel: Travel) -> None:
    turns, shifts = travel.share((TIME - TIME[10]) / (TIME[50] - TIME[10]))
    root = rotation.rotate(turns, np.array([0.4, 0.9, 0.1])) + shifts
    moves = clip(root, [STILL], [STILL]).with_joints({}, {0: np.asfortranarray(turns)})
    for gap in gaps_of_root(moves, 0, 10, 50, travel):
        assert np.allclose(gap.value, 0.0, atol=1e-9)
        assert np.allclose(gap.speed, 0.0, atol=1e-6)

"""A toe joint that is slow and low, but in no contact, is held to its captured motion; elsewhere nothing is added."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from legmaker import Figure, figure_of
from walks import rig_of
from walks import short_walk as walk

from footfix.enforce.leg import TOE
from footfix.enforce.pins import Pins
from footfix.enforce.slow_feet import slow_toes
from footfix.motion.clip import Clip, Floats

FRAMES, FIRST, LAST = 121, 40, 80  # of the clip, and its contact


def shifted(shift: Floats) -> Figure:
    """A walker that stands as if frozen, its root shifted by (F, 3) [m]."""
    made = walk("stand", 60.0, 2.0)
    clip = made.clip.frames(np.zeros(FRAMES, dtype=int))
    positions = clip.positions.copy()
    positions[:, 0] += shift
    moved = Clip(clip.skeleton, positions, clip.rotations, clip.frame_time)
    return figure_of(moved, rig_of(made), replace(made.contacts, frames=FRAMES))


def pins_of(hold: float) -> tuple[Pins, ...]:
    """Pins of heel and toe, of which the toe joint alone is held, from `FIRST` to `LAST`."""
    steps, frames = np.zeros(FRAMES - 1), np.zeros(FRAMES)
    free = Pins(
        steps, np.zeros((3, FRAMES - 1)), frames > 1.0, frames, frames, frames - np.inf, np.zeros((3, FRAMES)), frames
    )
    held, stands = steps.copy(), frames > 1.0
    held[FIRST : LAST - 1], stands[FIRST:LAST] = hold, hold > 0.0
    return free, replace(free, hold=held, stands=stands)


def toe_of(made: Figure, ground: Floats | None = None, *, hold: float = 0.8) -> tuple[Pins, Pins]:
    """The toe joint's pin without and with what is added."""
    leg, still = made.legs[0], np.zeros((FRAMES, 3))
    before = pins_of(hold)
    found = slow_toes(
        before, leg, still if ground is None else ground, np.zeros(FRAMES), 1.0 / 60.0, made.rig.leg_length
    )
    assert found[0] is before[0], "the heel is no part of it"
    return before[TOE], found[TOE]


def drift(speed: float, axis: int) -> Floats:
    """A shift (F, 3) [m] at a speed [m/s] along one axis."""
    return speed / 60.0 * np.arange(FRAMES)[:, None] * np.eye(3)[axis]


def test_within_a_contact_nothing_changes() -> None:
    before, after = toe_of(shifted(drift(0.05, 0)))
    own = slice(FIRST, LAST - 1)
    assert np.array_equal(before.hold[own], after.hold[own])
    assert np.array_equal(before.slip[:, own], after.slip[:, own])
    assert np.array_equal(before.stands, after.stands), "no frame becomes a contact"


def test_a_foot_that_creeps_is_held_to_its_captured_motion_far_more_lightly_than_a_plant() -> None:
    made = shifted(drift(0.05, 2))
    before, after = toe_of(made)
    out = before.hold == 0.0
    assert np.all(after.hold[out][[FIRST - 5, FIRST + 5]] > 0.0)
    assert not np.any(after.hold[: FIRST - 15]), "far from the contact nothing is held, so that the correction ends"
    assert after.hold[out].max() < 0.2 * before.hold.max()
    assert np.allclose(after.slip[:, out], np.diff(made.legs[0].place(TOE), axis=1)[:, out])


@pytest.mark.parametrize("shift", [drift(3.0, 0), np.where(np.arange(FRAMES) < FIRST, 0.2, 0.0)[:, None] * [0, 1, 0]])
def test_a_foot_that_is_quick_or_high_is_free(shift: Floats) -> None:
    _, after = toe_of(shifted(shift))
    assert np.all(after.hold[: FIRST - 1] < 1e-3)


def test_speed_is_that_over_the_ground() -> None:
    belt = drift(3.0, 0)
    _, along = toe_of(shifted(belt), belt)
    _, at_rest = toe_of(shifted(np.zeros((FRAMES, 3))))
    assert np.allclose(along.hold, at_rest.hold)


def test_a_toe_joint_without_contacts_stays_as_it_is() -> None:
    before, after = toe_of(shifted(drift(0.05, 0)), hold=0.0)
    assert after is before

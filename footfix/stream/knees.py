"""Knee axes and flexion of all legs together, as `enforce.leg` computes for one."""

from __future__ import annotations

import numpy as np

from footfix.enforce.leg import STRAIGHT
from footfix.motion.clip import Floats
from footfix.stream.arithmetic import cross

_LEAST = 1e-300


def knees(thigh: Floats, shank: Floats, usual: Floats) -> tuple[Floats, Floats, Floats]:
    """Measure knees: their axes (3, L, F), their flexion (L, F) [rad], and `LegTracks.reach` (3, L, F) [m^2].

    The axis is at right angles to the thigh, so that much of `enforce.leg.knee_of` is zero.

    Args:
        thigh, shank: (3, L, F) [m] from hip to knee, and from knee to ankle.
        usual: (3, L, F) mean unit axes of the knees, in the world.
    """
    both = np.stack([thigh, shank])
    thigh_square, shank_square = np.add.reduce(both * both, axis=1)
    along, normal = np.add.reduce(thigh * shank, axis=0), cross(thigh, shank)
    sines = normal / np.sqrt(np.maximum(thigh_square * shank_square, _LEAST))
    c = np.add.reduce(sines * usual, axis=0)
    square = c * c + STRAIGHT**2
    share = c * np.abs(c) / square
    axis = (np.sqrt(square) - share * c) * usual + share * sines
    axis -= np.add.reduce(axis * thigh, axis=0) / np.maximum(thigh_square, _LEAST) * thigh
    axis /= np.sqrt(np.maximum(np.add.reduce(axis * axis, axis=0), _LEAST))
    bent = np.add.reduce(axis * normal, axis=0)
    return axis, np.arctan2(bent, along), np.stack([thigh_square + shank_square, 2.0 * along, -2.0 * bent])

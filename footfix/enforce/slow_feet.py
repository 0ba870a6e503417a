"""Feet that are slow and low beside a contact: the correction of the plant does not move them farther than captured.

The correction of a plant grows before it and fades after it, over the frames between plants. In those in which the
foot hardly moves that would show: a foot that has nearly landed would slide on, or go back. So the change of the
correction has a price there, a low one, and goes where the foot is quick or high. The captured motion has none: a foot
that really slides into its place still does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from footfix.enforce.leg import TOE, LegTracks
from footfix.enforce.pins import Pins
from footfix.motion.clip import Bools, Floats

_WEIGHT = 0.1  # of what a foot at rest on the floor moves farther than captured, relative to slip in a contact
_SLOW = 0.25  # [leg lengths/s] speed over the ground at which that weight is halved
_LOW = 0.025  # [leg lengths] height over the joint's usual one at which it is halved
_SHARP = 4.0  # exponent of both
_AROUND = 0.2  # [s] from a contact to where the weight has faded to nothing, so that the correction ends


def slow_toes(
    pins: tuple[Pins, ...], leg: LegTracks, ground: Floats, step: Floats, frame_time: float, leg_length: float
) -> tuple[Pins, ...]:
    """Hold a toe joint to its captured motion, lightly, where it is slow, near its floor, and in no contact.

    Args:
        pins: of the leg's points; a toe joint that no contact holds anywhere stays as it is.
        leg: as captured.
        ground: (F, 3) [m] displacement of the ground.
        step: (F,) [m] height of the floor under the foot over the rig's.
        frame_time: [s].
        leg_length: [m].

    Returns:
        The pins, that of the toe joint with weight in more frames.
    """
    pin, track = pins[TOE], leg.place(TOE)
    if not np.any(pin.hold > 0.0):
        return pins
    moves, height = np.diff(track, axis=1), track[1] - step
    over_ground = (moves - np.diff(ground.T, axis=1))[[0, 2]]
    speed = np.hypot(*over_ground) / (frame_time * leg_length)  # (F - 1,) [leg lengths/s]
    lifted = np.maximum(height - np.median(height[pin.stands]), 0.0) / leg_length  # (F,) [leg lengths]
    lifted = np.maximum(lifted[1:], lifted[:-1])
    weight = _WEIGHT / ((1.0 + (speed / _SLOW) ** _SHARP) * (1.0 + (lifted / _LOW) ** _SHARP))
    weight *= np.maximum(1.0 - _away(pin.stands) * frame_time / _AROUND, 0.0)
    free = pin.hold <= 0.0
    held = replace(pin, hold=np.where(free, weight, pin.hold), slip=np.where(free, moves, pin.slip))
    return (*pins[:TOE], held, *pins[TOE + 1 :])


def _away(stands: Bools) -> Floats:
    """Count how many frames each step (F - 1,) is away from the nearest frame of a mask (F,)."""
    at, planted = np.arange(len(stands)), np.flatnonzero(stands)
    after = np.searchsorted(planted, at)
    nearest = np.minimum(
        np.abs(at - planted[np.maximum(after - 1, 0)]), np.abs(planted[np.minimum(after, len(planted) - 1)] - at)
    )
    return np.asarray(np.minimum(nearest[1:], nearest[:-1]), dtype=np.float64)

"""Weights of heel and toe of feet that turn on the floor, so that they keep their captured pivot.

Heel and toe of a foot of length l, which turns at a rate w about a pivot at distance r from its heel, slip by w r and
w (l - r). With equal weights their sum is w l wherever the pivot is, so that it stays where it was captured; with
unequal weights the foot would always turn about the end with the greater weight. The ankle's weight counts with the
heel's, so that as much more is needed ahead (`pins.pins`).
"""

from __future__ import annotations

import numpy as np

from footfix.enforce.leg import HEEL, TOE, LegTracks
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.motion.smoothing import savgol

_SMOOTH = 0.09  # [s] window of the rate
_RESTS = 0.001  # [leg lengths] a shorter path is rest


def held_alike(heel: Floats, toe: Floats, both: Bools, share: Floats) -> tuple[Floats, Floats]:
    """Give heel and toe the greater of their weights while both are planted.

    Args:
        heel, toe: (F - 1,) weights of slip.
        both: (F - 1,) whether both stand.
        share: (F - 1,) factor on the weight, less than 1 where the foot turns.
    """
    surer = np.maximum(heel, toe) * share
    return np.where(both, surer, heel), np.where(both, surer, toe)


def ankle_stiller(leg: LegTracks, ground: Floats, both: Bools, leg_length: float) -> Floats:
    """Compute how many times as far as the ankle the heel goes while both ends of the foot stand, (F - 1,) 1 or more.

    Skate moves both alike. Where the ankle rests and the heel does not, the foot rolls about the ankle, or the heel was
    estimated in the wrong place: to hold the heel would make an ankle slide that stood.

    Args:
        leg: as captured.
        ground: (F, 3) [m] displacement of the ground.
        both: (F - 1,) whether heel and toe stand.
        leg_length: [m].
    """
    moves = np.diff(ground.T, axis=1)
    steps = [np.hypot(*(np.diff(track, axis=1) - moves)[[0, 2]]) for track in (leg.place(HEEL), leg.ankle)]
    found, least = np.ones(len(both)), _RESTS * leg_length
    for start, end in runs(both):
        heel, ankle = (float(each[start:end].sum()) for each in steps)
        found[start:end] = max((heel + least) / (ankle + least), 1.0)
    return found


def shared_behind(heel: Floats, ankle: Floats, stiller: Floats) -> tuple[Floats, Floats]:
    """Share the weight of heel and ankle between them: the ankle's grows `stiller`-fold relative to the heel's.

    Args:
        heel, ankle: (F - 1,) weights of slip.
        stiller: (F - 1,) from `ankle_stiller`.

    Returns:
        Their weights, (F - 1,) each, of the same sum.
    """
    held = stiller * ankle
    whole = (heel + ankle) / np.maximum(heel + held, 1e-12)
    more = stiller > 1.0  # elsewhere to the digit as they were
    return np.where(more, whole * heel, heel), np.where(more, whole * held, ankle)


def share_held(leg: LegTracks, both: Bools, frame_time: float, turning: float) -> Floats:
    """Compute a factor (F - 1,) on the weights that falls as the foot turns: skate moves heel and toe alike.

    Args:
        leg: as captured.
        both: (F - 1,) whether heel and toe stand.
        frame_time: [s].
        turning: [rad/s] the rate of turn at which the factor is 0.5.
    """
    return np.where(both, 1.0 / (1.0 + (turn_rate(leg, frame_time) / turning) ** 2), 1.0)


def turn_rate(leg: LegTracks, frame_time: float) -> Floats:
    """Compute how fast (F - 1,) [rad/s] the line from heel to toe turns over the floor."""
    x, y, z = leg.place(TOE) - leg.place(HEEL)  # (F,) [m]
    long = np.maximum(np.hypot(x, z), 0.5 * np.sqrt(x**2 + y**2 + z**2))  # a foot on its tip has no direction
    line = np.stack([x, z], axis=1)
    velocity = savgol(line, frame_time, seconds=_SMOOTH, degree=2, derivative=1)  # (F, 2) [m/s]
    rate = np.abs(line[:, 0] * velocity[:, 1] - line[:, 1] * velocity[:, 0]) / np.maximum(long, 1e-9) ** 2
    return np.asarray(np.minimum(rate[1:], rate[:-1]))

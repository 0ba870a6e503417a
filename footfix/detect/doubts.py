"""What a detector doubts about a clip: its frame rate, and where heel and toe could be either way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.detect.cycles import CycleParams, find_cycles
from footfix.detect.tracks import Foot, Tracks
from footfix.motion.clip import Floats
from footfix.motion.contacts import runs
from footfix.notes import Note

_LEG = 0.88  # [m] of a usual adult: what a clip's own unit says is not asked
_WALK_RATIO = 0.4  # [m s] step length times step duration, walking; running is not far from it
_RATES = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 150.0, 200.0, 240.0, 250.0, 300.0)


@dataclass(frozen=True, kw_only=True)
class DoubtParams:
    """When to speak.

    Args:
        quick, slow: how many times longer than usual for their length steps may last, at the least and at
            most [factor].
        shortest, longest: [s] cycles between these are plausible whatever the length of the steps.
        cycles: fewer than this many say nothing [count].
        uneven: nor do cycles that usually differ by more than this, of their length [share].
        unsure: [s] a stretch that could be contact or not is told from this length on.
        most: stretches told of one foot [count].
    """

    quick: float = 0.4
    slow: float = 3.5
    shortest: float = 0.4
    longest: float = 3.0
    cycles: int = 3
    uneven: float = 0.12
    unsure: float = 0.3
    most: int = 2


def frame_rate(tracks: Tracks, params: DoubtParams) -> tuple[Note, ...]:
    """A note where steps of this length can't last as long as the declared frame rate says."""
    for left in range(0, len(tracks.feet) - 1, 2):
        ratio = _slowness(tracks, tracks.feet[left], tracks.feet[left + 1], params)
        if ratio is not None:
            declared, likely = 1.0 / tracks.frame_time, ratio / tracks.frame_time
            rate = min(_RATES, key=lambda each: abs(np.log(each / likely)))
            text = (
                f"at the declared {declared:.4g} fps the steps last {ratio:.1f} times as long as steps of their "
                f"length do; the motion looks as if it were made at about {rate:.0f} fps"
            )
            return (Note("frame-rate-implausible", text, "warning"),)
    return ()


def _slowness(tracks: Tracks, left: Foot, right: Foot, params: DoubtParams) -> float | None:
    """How many times longer than usual the steps last, if that is implausible."""
    wide = CycleParams(smooth=0.04, shortest=0.0, longest=np.inf)
    cycles = find_cycles(tracks, left, right, wide)
    if len(cycles) < params.cycles:
        return None
    periods = np.array([cycle.end - cycle.start for cycle in cycles]) * tracks.frame_time
    period = float(np.median(periods))
    if np.median(np.abs(periods - period)) > params.uneven * period:
        return None  # no gait at all, or a very noisy one
    step = _LEG * float(np.median([cycle.step for cycle in cycles]))
    ratio = 0.5 * period * step / _WALK_RATIO
    hasty = ratio < params.quick and period < params.shortest
    dragging = ratio > params.slow and period > params.longest
    return ratio if hasty or dragging else None


def unsure(planted: Floats, tracks: Tracks, side: str, params: DoubtParams) -> tuple[Note, ...]:
    """Notes on the longest stretches in which a foot may be planted or not.

    Args:
        planted: (F,) probability that heel or toe is in contact.
        tracks: of the clip.
        side: which foot.
        params: when to speak.
    """
    between = runs((planted > 0.2) & (planted < 0.8))
    long = [(a, b) for a, b in between if (b - a) * tracks.frame_time >= params.unsure]
    longest = sorted(sorted(long, key=lambda stretch: stretch[0] - stretch[1])[: params.most])
    return tuple(
        Note(
            "contact-doubtful",
            f"{side} foot, {a * tracks.frame_time:.2f} to {b * tracks.frame_time:.2f} s: could be planted or not",
            start=a,
            end=b,
        )
        for a, b in longest
    )

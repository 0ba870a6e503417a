"""Glardon, Boulic & Thalmann's detector: a height threshold of its own for each plant of a gait cycle (G §4.2)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from footfix.detect.gait_cycles import Cycle, CycleParams, find_cycles
from footfix.detect.threshold import ThresholdParams, threshold
from footfix.detect.tracks import Finding, Tracks
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.motion.smoothing import savgol
from footfix.notes import Note

# G table 1: idx(F_b), idx(F_e) of right ankle, right metatarsal, left ankle, left metatarsal, on cycles of 25
# frames, the first of which is the right heel strike.
_FRAMES = 25
_WALK = ((1, 12), (3, 15), (13, 26), (15, 29))
_RUN = ((1, 7), (1, 9), (12, 19), (13, 22))


@dataclass(frozen=True, kw_only=True)
class AdaptiveParams:
    """Parameters of the adaptive height threshold, and of the search for gait cycles.

    Args:
        delta: the threshold, from the lowest height (0) to the mean height at the window's ends (1) (G eq. 8) [share].
        smooth: [s] smoothing window of the heights.
        cycles: what counts as a gait cycle.
    """

    delta: float = 0.4
    smooth: float = 0.05
    cycles: CycleParams = field(default_factory=CycleParams)


def adaptive(tracks: Tracks, params: AdaptiveParams, elsewhere: ThresholdParams) -> Finding:
    """Detect contacts by height within windows of the gait cycle (G §4.2).

    Where no gait cycle is found, Kim & Neff's detector is used with the parameters `elsewhere`; a note says so.
    """
    mask = threshold(tracks, elsewhere).mask.copy()
    cyclic = np.zeros(len(tracks), dtype=np.bool_)
    for left in range(0, len(tracks.feet) - 1, 2):
        cycles = find_cycles(tracks, tracks.feet[left], tracks.feet[left + 1], params.cycles)
        within = _frames_of(cycles, len(tracks))
        right = left + 1
        # in the order of the table: right heel, right toe, left heel, left toe
        for row, column in enumerate((2 * right, 2 * right + 1, 2 * left, 2 * left + 1)):
            point = tracks.feet[column // 2].soles[column % 2]
            height = savgol(point[:, 1], tracks.frame_time, seconds=params.smooth, degree=2)
            found = _plants(height, _with_ends(cycles), row, params.delta)
            mask[:, column] = np.where(within, found, mask[:, column])
        cyclic |= within
    return Finding(mask, None, _where_not(cyclic, tracks.frame_time))


def _frames_of(cycles: list[Cycle], frames: int) -> Bools:
    within = np.zeros(frames, dtype=np.bool_)
    for cycle in cycles:
        within[round(cycle.start) : round(cycle.end) + 1] = True
    return within


def _with_ends(cycles: list[Cycle]) -> list[Cycle]:
    """Add one cycle before and after each stretch: a plant that reaches into the stretch begins in it."""
    more = []
    starts, ends = {cycle.start for cycle in cycles}, {cycle.end for cycle in cycles}
    for cycle in cycles:
        period = cycle.end - cycle.start
        if cycle.start not in ends:
            more.append(replace(cycle, start=cycle.start - period, end=cycle.start))
        if cycle.end not in starts:
            more.append(replace(cycle, start=cycle.end, end=cycle.end + period))
    return cycles + more


def _plants(height: Floats, cycles: list[Cycle], row: int, delta: float) -> Bools:
    """Find the plants (F,) of one joint."""
    mask = np.zeros(len(height), dtype=np.bool_)
    for cycle in cycles:
        first, last = (_RUN if cycle.run else _WALK)[row]
        period = cycle.end - cycle.start
        F_b = max(round(cycle.start + (first - 1) / _FRAMES * period), 0)
        F_e = min(round(cycle.start + (last - 1) / _FRAMES * period), len(height) - 1)
        if F_e <= F_b:
            continue
        inside = height[F_b : F_e + 1]
        h, least = 0.5 * (inside[0] + inside[-1]), inside.min()
        eps_p = least + delta * (h - least)  # G eq. 8
        # walking inwards from both ends, so that a plant never splits
        low = np.flatnonzero(inside <= eps_p)
        if len(low):
            mask[F_b + low[0] : F_b + low[-1] + 1] = True
    return mask


def _where_not(cyclic: Bools, frame_time: float) -> tuple[Note, ...]:
    """Make notes on the stretches without a gait cycle."""
    return tuple(
        Note(
            "no-cycle",
            f"no gait cycle from {a * frame_time:.2f} to {b * frame_time:.2f} s; heights and speeds decide there",
            start=a, end=b,
        )
        for a, b in runs(~cyclic)
    )  # fmt: skip

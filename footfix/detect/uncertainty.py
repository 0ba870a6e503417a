"""Doubtful results of detection: an implausible frame rate, and stretches that may be contact or not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.detect.gait_cycles import CycleParams, find_cycles
from footfix.detect.tracks import FootTracks, Tracks
from footfix.motion.clip import Floats
from footfix.motion.contacts import runs
from footfix.motion.smoothing import savgol
from footfix.notes import Note

_LEG = 0.88  # [m] leg length of an average adult, assumed whatever the clip's own unit says
_WALK_RATIO = 0.4  # [m s] step length times step duration, walking; running is not far from it
_GRAVITY = 9.81  # [m/s^2]
_OFF = 0.08  # [leg lengths] a foot higher over the floor than this is off it
_FEWEST = 6  # least number of frames of a jump
_HOP = 0.01  # [m] least rise and fall of the pelvis in a jump
_PARABOLA = 0.08  # greatest deviation of the pelvis from a parabola, as a share of that rise
_PACE = 0.5  # [s] window of velocities from which the pace is computed: long enough to average noise out
_RATES = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 150.0, 200.0, 240.0, 250.0, 300.0)


@dataclass(frozen=True, kw_only=True)
class DoubtParams:
    """Thresholds of the notes on frame rate and unsure contacts.

    Args:
        quick, slow: least and greatest plausible duration of steps, relative to the usual one for their
            length [factor].
        floating: a fall with both feet off the floor that is no faster than this is slow motion [g].
        sinking: the same of a pelvis that sinks between the steps of a walk [g].
        slow_fall: least duration of steps, relative to the usual one, that is slow motion if falls are, too [factor].
        slow_few: the same where there are fewer than `cycles` gait cycles [factor].
        dull: feet move in slow motion if their accelerations relative to their speeds give a lower frequency [Hz],
        travelling: provided that they sometimes exceed this speed [m/s]
        long: and the clip lasts at least this long [s].
        stride: shortest steps for which slow falls are considered [m].
        shortest, longest: [s] gait cycles between these are plausible whatever the length of the steps.
        cycles: least number of gait cycles to judge by [count].
        uneven: cycles whose lengths typically differ by more than this are not judged [share].
        unsure: [s] shortest stretch of unsure contact that is reported.
        most: greatest number of such stretches reported for one foot [count].
    """

    quick: float = 0.4
    slow: float = 3.5
    floating: float = 0.4
    sinking: float = 0.13
    slow_fall: float = 2.0
    slow_few: float = 2.6
    dull: float = 0.46
    travelling: float = 0.15
    long: float = 4.0
    stride: float = 0.4
    shortest: float = 0.4
    longest: float = 3.0
    cycles: int = 3
    uneven: float = 0.12
    unsure: float = 0.3
    most: int = 2


def frame_rate(tracks: Tracks, params: DoubtParams) -> tuple[Note, ...]:
    """Make a note if steps or jumps are implausibly long or short at the declared frame rate."""
    falls = _falls(tracks)
    if len(falls) and np.median(falls) <= params.floating:
        slowness = float(np.median(falls)) ** -0.5
        text = (
            f"at the declared {1.0 / tracks.frame_time:.4g} fps the figure falls {1.0 / np.median(falls):.0f} times "
            "slower than gravity lets it"
        )
        return (_implausible(tracks, text, slowness),)
    for left in range(0, len(tracks.feet) - 1, 2):
        ratio = _slowness(tracks, tracks.feet[left], tracks.feet[left + 1], params)
        if ratio is not None:
            text = (
                f"at the declared {1.0 / tracks.frame_time:.4g} fps the steps last {ratio:.1f} times as long as steps "
                "of their length do"
            )
            return (_implausible(tracks, text, ratio),)
    pace, top = _pace(tracks)
    if pace < params.dull and top > params.travelling and len(tracks) * tracks.frame_time >= params.long:
        text = (
            f"at the declared {1.0 / tracks.frame_time:.4g} fps the feet speed up and slow down at {pace:.2f} Hz, "
            "which is slow motion; unless it was meant so, the motion was made at a higher rate"
        )
        return (Note("frame-rate-implausible", text, "warning"),)
    return ()


def _pace(tracks: Tracks) -> tuple[float, float]:
    """Measure how quickly feet change speed, whatever the size of their motion [Hz], and their top speed [m/s].

    The root mean square acceleration over the root mean square velocity is 2 pi f for a foot that swings at f.
    """
    speeds, squares = [], []
    for foot in tracks.feet:
        place = _LEG * foot.ankle / tracks.leg_length
        first, second = (
            savgol(place, tracks.frame_time, seconds=_PACE, degree=2, derivative=order) for order in (1, 2)
        )
        speeds.append(np.linalg.norm(first, axis=1))
        squares.append(np.sum(second**2, axis=1))
    if not speeds or not len(tracks):
        return np.inf, 0.0
    speed = np.concatenate(speeds)
    quick = float(np.sqrt(np.mean(speed**2)))
    pace = float(np.sqrt(np.mean(np.concatenate(squares)))) / max(2.0 * np.pi * quick, 1e-9)
    return pace, float(np.quantile(speed, 0.99))


def _implausible(tracks: Tracks, what: str, slowness: float) -> Note:
    """Make the note that the motion is implausibly slow or fast."""
    likely = slowness / tracks.frame_time
    rate = min(_RATES, key=lambda each: abs(np.log(each / likely)))
    text = f"{what}; the motion looks as if it were made at about {rate:.0f} fps"
    return Note("frame-rate-implausible", text, "warning")


def _falls(tracks: Tracks) -> Floats:
    """Measure the downward acceleration [g] in every jump: feet off the floor, and the pelvis on a parabola."""
    points = np.stack([point[:, 1] for foot in tracks.feet for point in (foot.heel, foot.toe)])
    lowest = points.min(axis=0) / tracks.leg_length
    height = _LEG * tracks.pelvis[:, 1] / tracks.leg_length  # [m]
    falls = []
    for start, end in runs(lowest > np.quantile(lowest, 0.1) + _OFF):
        if end - start < _FEWEST or start == 0 or end == len(lowest):
            continue
        t = np.linspace(-1.0, 1.0, end - start)
        a, b, _ = fit = np.polyfit(t, height[start:end], 2)
        far, off = np.ptp(height[start:end]), height[start:end] - np.polyval(fit, t)
        inside = a < 0.0 and abs(b) < -1.2 * a  # the highest place lies well within
        if inside and far > _HOP and np.sqrt(np.mean(off**2)) < _PARABOLA * far:
            falls.append(-2.0 * a / (0.5 * (end - start - 1) * tracks.frame_time) ** 2 / _GRAVITY)
    return np.array(falls)


def _slow_fall(tracks: Tracks) -> float:
    """Measure the downward acceleration of the pelvis [g]: the second percentile over the clip."""
    height = savgol(_LEG * tracks.pelvis[:, 1] / tracks.leg_length, tracks.frame_time, seconds=0.2, degree=2)
    k = max(1, round(0.05 / tracks.frame_time))
    if len(height) <= 2 * k:
        return np.inf
    rises = (height[2 * k :] - 2.0 * height[k:-k] + height[: -2 * k]) / (k * tracks.frame_time) ** 2
    return float(-np.quantile(rises, 0.02)) / _GRAVITY


def _slowness(tracks: Tracks, left: FootTracks, right: FootTracks, params: DoubtParams) -> float | None:
    """Compute the duration of steps relative to the usual one, if it is implausible."""
    wide = CycleParams(smooth=0.04, shortest=0.0, longest=np.inf)
    cycles = find_cycles(tracks, left, right, wide)
    if not cycles:
        return None
    periods = np.array([cycle.end - cycle.start for cycle in cycles]) * tracks.frame_time
    period = float(np.median(periods))
    if np.median(np.abs(periods - period)) > params.uneven * period:
        return None  # no gait at all, or a very noisy one
    step = _LEG * float(np.median([cycle.step for cycle in cycles]))
    ratio = 0.5 * period * step / _WALK_RATIO
    floats = period > 0.8 * params.longest and step >= params.stride and _slow_fall(tracks) <= params.sinking
    if floats and ratio >= (params.slow_fall if len(cycles) >= params.cycles else params.slow_few):
        return ratio
    if len(cycles) < params.cycles:
        return None
    hasty = ratio < params.quick and period < params.shortest
    dragging = ratio > params.slow and period > params.longest
    return ratio if hasty or dragging else None


def unsure(planted: Floats, tracks: Tracks, side: str, params: DoubtParams) -> tuple[Note, ...]:
    """Make notes on the longest stretches in which it is unsure whether a foot is planted.

    Args:
        planted: (F,) probability that heel or toe is in contact.
        tracks: of the clip.
        side: which foot.
        params: thresholds of the notes.
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

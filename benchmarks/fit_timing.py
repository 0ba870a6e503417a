"""Fits the lines of `footfix.detect.timing`: how much later than a moment a foot lands, and leaves.

Moments are taken about every event that plates measured, up to the farthest that a path may be wrong. Each line
is the one of least squares that a penalty on its weights keeps flat (ridge regression: A. Hoerl, R. Kennard,
1970), so that it holds for others than the few people it has seen. Each of these counts as the root of how
often; made walkers have a small say, since they land and leave as joints tell and not as plates do.
"""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from fit_takes import RATE, Take
from fit_variants import FPS, Random, as_captured, with_wrong_soles

from footfix.detect.evidence import STEP
from footfix.detect.network import SWING
from footfix.detect.timing import Line, Timing, braking, seen, tipping
from footfix.motion.clip import Bools, Floats

# What a line may move is kept short where the path is seldom wrong: feet that are set down with care, as on
# stairs, brake before they land.
FARTHEST = {"landing": 1.2, "leaving": 3.0}  # [grid steps]
LANDING, LEAVING = (-4, -2, 0, 2, 4), (-6, -4, -2, 0, 2, 4, 6)  # [grid steps] taps
AWAY = np.linspace(-4.0, 4.0, 17)  # [grid steps] of the moments about an event
WALKER_SAY = 0.05  # of all
FLAT = 0.5  # the penalty on a weight, of a curve whose spread is 1
MICRO = 1e-6 / STEP  # [grid steps] of a microsecond


@dataclass(frozen=True, eq=False)
class Moments:
    """Moments about the landings, or the leavings, of a variant of a take.

    Args:
        subject: whose.
        taps: (T,) [grid steps].
        events: how many.
        curve: (m, T) braking, or tipping, around each moment.
        later: (m,) [grid steps] from each to its event.
    """

    subject: str
    taps: tuple[int, ...]
    events: int
    curve: Floats
    later: Floats


def moments(take: Take, variant: int) -> tuple[Moments, Moments]:
    """About the landings and the leavings of one variant of a take; the first is as recorded."""
    random = np.random.default_rng([zlib.crc32(take.name.encode()), variant])
    changed, rate, fps = _changed(take, random) if variant else (take, RATE, take.fps)
    sampled, first = as_captured(changed, rate, fps, random if variant else None)
    known = take.allowed[first:]
    landings = _moments(take.subject, [braking(sampled, k) for k in (0, 1)], _landings(known), rate, LANDING)
    leavings = _moments(take.subject, [tipping(sampled, k) for k in (0, 1)], _leavings(known), rate, LEAVING)
    return landings, leavings


def _moments(
    subject: str, curves: list[Floats], steps: list[list[float]], rate: float, taps: tuple[int, ...]
) -> Moments:
    """About events at some steps of a take of some rate [Hz], by foot."""
    around, later = [np.zeros((0, len(taps)))], [np.zeros(0)]
    for curve, events in zip(curves, steps, strict=True):
        for step in events:
            at = step / rate / STEP + AWAY
            inside = (at >= -taps[0]) & (at <= len(curve) - 1 - taps[-1])
            around.append(seen(curve, at[inside], taps))
            later.append(-AWAY[inside])
    return Moments(subject, taps, len(later) - 1, np.concatenate(around), np.concatenate(later))


def _changed(take: Take, random: Random) -> tuple[Take, float, float]:
    """The take with other sole points, its rate [Hz] once it is quicker or slower, and frames a second."""
    if random.random() < 0.5:
        take = with_wrong_soles(take, random)
    rate = RATE * float(np.exp(random.uniform(-0.15, 0.15)))
    return take, rate, float(random.choice(FPS)) if random.random() < 0.6 else take.fps


def _landings(allowed: Bools) -> list[list[float]]:
    """By foot: steps between the last at which it is known to swing and the first at which it is known to stand."""
    stands, swings = ~allowed[:, :, SWING], allowed[:, :, SWING] & (allowed.sum(axis=2) == 1)
    return [[float(i) + 0.5 for i in np.flatnonzero(swings[:-1, k] & stands[1:, k])] for k in (0, 1)]


def _leavings(allowed: Bools) -> list[list[float]]:
    """The same from standing to swinging."""
    backwards = _landings(allowed[::-1])
    return [[len(allowed) - 1 - step for step in reversed(steps)] for steps in backwards]


def fit_timing(all_of: list[tuple[Moments, Moments]]) -> Timing:
    """Both lines, their numbers rounded as they will be written."""
    landing, leaving = zip(*all_of, strict=True)
    return Timing(_line(landing, FARTHEST["landing"]), _line(leaving, FARTHEST["leaving"]))


def _line(all_of: Sequence[Moments], farthest: float) -> Line:
    often: Counter[str] = Counter()
    for each in all_of:
        often[each.subject] += each.events
    curve, later = (np.concatenate([getattr(each, part) for each in all_of]) for part in ("curve", "later"))
    made = np.concatenate([np.full(len(each.later), each.subject == "walker") for each in all_of])
    weight = np.concatenate([np.full(len(each.later), max(often[each.subject], 1) ** -0.5) for each in all_of])
    for kind, say in ((made, WALKER_SAY), (~made, 1.0 - WALKER_SAY)):
        weight[kind] *= say / max(weight[kind].sum(), 1e-9)
    mean, usual = weight @ curve, weight @ later
    spread = np.sqrt(weight @ (curve - mean) ** 2)
    unit = (curve - mean) / spread
    tilted = (unit * weight[:, None]).T
    slopes = np.linalg.solve(tilted @ unit + FLAT * np.eye(len(mean)), tilted @ (later - usual)) / spread
    weights = MICRO * np.round(slopes / MICRO)
    bias = float(MICRO * np.round((usual - mean @ weights) / MICRO))
    return Line(all_of[0].taps, weights, bias, farthest)

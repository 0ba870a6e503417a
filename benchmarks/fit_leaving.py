"""Fits the line of `footfix.detect.leaving`: how much later a foot leaves than a moment, by how it tips around it.

Moments are drawn about every leaving that plates measured, up to the farthest that a path may be wrong. The line
is the one of least squares that a penalty on its weights keeps flat (ridge regression: A. Hoerl, R. Kennard,
1970), so that it holds for others than the few people it has seen. Each of these counts as the root of how
often; made walkers have a small say, since they leave as joints tell and not as plates do.
"""

from __future__ import annotations

import zlib
from collections import Counter
from dataclasses import dataclass

import numpy as np
from fit_takes import RATE, Take
from fit_variants import FPS, Random, as_captured, with_wrong_soles

from footfix.detect.evidence import STEP
from footfix.detect.leaving import Leaving, seen, tipping
from footfix.detect.network import SWING
from footfix.motion.clip import Bools, Floats

TAPS = (-6, -4, -2, 0, 2, 4, 6)  # [grid steps]
AWAY = 4.0  # [grid steps] that moments are drawn before and after a leaving
MOMENTS = 12  # of each leaving of each variant
WALKER_SAY = 0.03  # of all
FLAT = 0.5  # the penalty on a weight, of a curve whose spread is 1
MICRO = 1e-6 / STEP  # [grid steps] of a microsecond


@dataclass(frozen=True, eq=False)
class Moments:
    """Moments about the leavings of a variant of a take.

    Args:
        subject: whose.
        leavings: how many.
        curve: (m, T) [rad/s^2] tipping around each moment.
        later: (m,) [grid steps] from each to its leaving.
    """

    subject: str
    leavings: int
    curve: Floats
    later: Floats


def moments(take: Take, variant: int) -> Moments:
    """Of one variant of a take; the first is as recorded."""
    random = np.random.default_rng([zlib.crc32(take.name.encode()), variant])
    changed, rate, fps = _changed(take, random) if variant else (take, RATE, take.fps)
    sampled, first = as_captured(changed, rate, fps, random if variant else None)
    count, curves, later = 0, [np.zeros((0, len(TAPS)))], [np.zeros(0)]
    for k in (0, 1):
        tips = tipping(sampled, k)
        for left in _leavings(take.allowed[:, k]):
            away = random.uniform(-AWAY, AWAY, MOMENTS)
            at = (left - first) / rate / STEP + away
            inside = (at >= -TAPS[0]) & (at <= len(tips) - 1 - TAPS[-1])
            curves.append(seen(tips, at[inside], TAPS))
            later.append(-away[inside])
            count += 1
    return Moments(take.subject, count, np.concatenate(curves), np.concatenate(later))


def _changed(take: Take, random: Random) -> tuple[Take, float, float]:
    """The take with other sole points, its rate [Hz] once it is quicker or slower, and frames a second."""
    if random.random() < 0.5:
        take = with_wrong_soles(take, random)
    rate = RATE * float(np.exp(random.uniform(-0.15, 0.15)))
    return take, rate, float(random.choice(FPS)) if random.random() < 0.6 else take.fps


def _leavings(allowed: Bools) -> list[float]:
    """Steps of a take, between the last at which a foot is known to stand and the first at which it does not."""
    stands, swings = ~allowed[:, SWING], allowed[:, SWING] & (allowed.sum(axis=1) == 1)
    return [float(k) + 0.5 for k in np.flatnonzero(stands[:-1] & swings[1:])]


def fit_leaving(all_of: list[Moments]) -> Leaving:
    """The line through moments, its numbers rounded as they will be written."""
    often: Counter[str] = Counter()
    for each in all_of:
        often[each.subject] += each.leavings
    curve, later = (np.concatenate([getattr(each, part) for each in all_of]) for part in ("curve", "later"))
    made = np.concatenate([np.full(len(each.later), each.subject == "walker") for each in all_of])
    weight = np.concatenate([np.full(len(each.later), max(often[each.subject], 1) ** -0.5) for each in all_of])
    for kind, say in ((made, WALKER_SAY), (~made, 1.0 - WALKER_SAY)):
        weight[kind] *= say / max(weight[kind].sum(), 1e-9)
    mean, usual = weight @ curve, weight @ later
    spread = np.sqrt(weight @ (curve - mean) ** 2)
    unit = (curve - mean) / spread
    tilted = (unit * weight[:, None]).T
    slopes = np.linalg.solve(tilted @ unit + FLAT * np.eye(len(TAPS)), tilted @ (later - usual)) / spread
    weights = MICRO * np.round(slopes / MICRO)
    return Leaving(TAPS, weights, float(MICRO * np.round((usual - mean @ weights) / MICRO)))


def lines(leaving: Leaving) -> list[str]:
    """The lines of `footfix/detect/fitted.py` that hold it."""
    weights = ", ".join(str(round(float(weight) / MICRO)) for weight in leaving.weights)
    return [
        "",
        "# How much later a foot leaves than a moment, by its tipping at some steps about it.",
        "LEAVING = Leaving(",
        f"    taps={leaving.taps},  # [0.01 s]",
        f"    weights=1e-4 * np.array(({weights})),  # [us per rad/s^2]",
        f"    bias=1e-4 * {round(leaving.bias / MICRO)},  # [us]",
        ")",
    ]

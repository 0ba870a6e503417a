"""Feet that step slowly though they look planted: motion of one foot alone is a step, not skate.

Skate is common to the figure: a root that drifts, or whose path is scaled, moves every planted foot alike, and so
does a treadmill. Two planted feet therefore have the same velocity, whatever the root does. Where two feet that look
planted move apart, one of them is stepping: the one that moves faster over the floor.

Slow steps differ from the small motion of resting feet by their length: a foot that seems planted all the time has
stepped if it comes to rest farther from its last rest than creeping explains. A step lasts from rest to rest, even
if only its middle is fast, or high. Under a travelling pelvis, and in noisy clips, a resting foot may creep.

Where the other foot swings, or steps as well, there is no planted foot to compare with. A foot that is at rest before
and after, and fast in between, stepped all the same: a foot that skates does so for as long as it stands. Where both
move apart, and neither with the pelvis, no one motion of the figure explains them: both step, though slowly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from footfix.detect.evidence import STEP, floors
from footfix.detect.network import HEEL, SWING
from footfix.detect.tracks import FootTracks, Tracks
from footfix.motion.clip import Floats
from footfix.motion.contacts import runs
from footfix.motion.smoothing import savgol

WINDOW = 0.09  # [s] over which velocities are taken


@dataclass(frozen=True, kw_only=True)
class SteppingParams:
    """When two feet that look planted move apart, and so one of them is stepping.

    Args:
        parting: [leg lengths/s] speed between the feet at which one steps with probability 0.5, figure standing still.
        travel: [factor] increase of that speed for each leg length/s of the pelvis' speed over the planted foot.
        noise: [factor] increase of that speed for each leg length/s at which the foot moves in the rests before and
            after, the faster of the two: on a belt and in noisy clips feet are never still.
        fast: [leg lengths/s] speed between two rests at which a foot steps with probability 0.5 whatever the other foot
            does; `noise` increases it, too.
        rest: [s] least duration of such a rest.
        within: [s] how far before and after a rest is searched.
        length: [leg lengths] distance from rest to rest that is a step with probability 0.5, foot still at rest.
        creeping: [factor] increase of that distance for each leg length that the foot would creep in the same time.
        still: [leg lengths/s] a foot that moves away from the other more slowly than this is at rest,
        calm: [factor] or more slowly than this many times its speed in its rests.
        sharp: [factor] exponent of the speed in the odds.
    """

    parting: float = 0.15
    travel: float = 0.8
    noise: float = 10.0
    fast: float = 0.5
    rest: float = 0.12
    within: float = 2.0
    length: float = 0.035
    creeping: float = 3.0
    still: float = 0.03
    calm: float = 2.0
    sharp: float = 6.0


def stepping(
    answers: tuple[Floats, ...], mates: Sequence[int], pelvis: Floats, each: Sequence[Floats], params: SteppingParams
) -> tuple[Floats, ...]:  # fmt: skip
    """Update each foot's log probabilities (n, 4) by its motion relative to the other foot of its pair.

    The two feet move apart with probability a, and the stepping foot is this one with probability r: the faster one,
    and the one less likely to be planted. With p the probability that this foot is planted before, and q that of the
    other, it is planted with probability p (1 - q a r); or with p (1 - b), if that is less, where it moves from rest to
    rest so fast, and so far, that it steps with probability b whatever the other one does. Motion that it has in common
    with both the pelvis and the other foot does not count there; what a spike in the data throws off is soon back.
    Slower motion counts for b where the other one moves by itself, too.

    Args:
        answers: for each foot (n, 4) log probabilities.
        mates: for each foot the other one of its pair.
        pelvis: (n, 2) [leg lengths/s] velocity over the ground.
        each: for each foot (n, 2, 2) [leg lengths/s] velocities of heel and toe.
        params: when two feet move apart.
    """
    speeds = [slowest(velocity) for velocity in each]
    rests = [resting_speed(speed, params) for speed in speeds]
    planted = [-np.expm1(answer[:, SWING]) for answer in answers]
    unlikely = [answer[:, SWING] - np.log(np.maximum(p, 1e-12)) for answer, p in zip(answers, planted, strict=True)]
    figure = np.stack([np.zeros_like(pelvis), pelvis], axis=1)  # (n, 2, 2) at rest, or going with the pelvis
    from_figure = [parting(velocity, figure) for velocity in each]
    alone = params.parting + params.travel * np.linalg.norm(pelvis, axis=1)
    out = []
    for k, mate in enumerate(mates):
        if mate == k:
            out.append(answers[k])
            continue
        travel = _to_segment(pelvis, each[mate])
        rest = rests[k]
        even = params.parting + params.travel * travel + params.noise * rest
        apart = parting(each[k], each[mate])
        parts = likely(apart, even, params.sharp)
        faster = params.sharp * _log_ratio(speeds[k], speeds[mate])
        steps = planted[mate] * parts * probability(faster + unlikely[k] - unlikely[mate])
        least = np.maximum(params.still, params.calm * rest)
        by_itself = np.minimum(speeds[k], np.maximum(apart, from_figure[k]))
        both = np.minimum(apart, np.minimum(from_figure[k], from_figure[mate]))
        fast = np.maximum(
            likely(by_itself, params.fast + params.noise * rest, params.sharp),
            planted[mate] * likely(both, alone + params.noise * np.maximum(rest, rests[mate]), params.sharp),
        )
        for a, b in planted_throughout(speeds[k] - least, planted[k]):
            far = likely(slowest(each[k][a:b].sum(axis=0, keepdims=True) * STEP), params.length, params.sharp)
            steps[a:b] = np.maximum(steps[a:b], fast[a:b].max() * far)
        leaves = np.where(speeds[k] > speeds[mate], apart - least, 0.0)
        for a, b in from_rest_to_rest(leaves, even - params.parting, planted[k]):
            whole = whole_step(each[k][a:b], each[mate][a:b], float(rest[a:b].max()), params)
            whole *= float(planted[mate][a:b].min())
            steps[a:b] = np.maximum(steps[a:b], max(whole, float(steps[a:b].max())))
        out.append(stands(answers[k], steps))
    return tuple(out)


def from_rest_to_rest(leaves: Floats, creeps: Floats, planted: Floats) -> list[tuple[int, int]]:
    """Find the stretches [start, end) in which a foot moves away from the other, and rests before and after.

    Args:
        leaves: (n,) [leg lengths/s] its speed away from the other, less that of a foot at rest.
        creeps: (n,) [leg lengths/s] further speed allowed at rest, unless it looks planted all the time.
        planted: (n,) probability that it is planted.

    Returns:
        Stretches in which it looks planted all the time, then others; some may lie within others.
    """
    between = [(a, b) for a, b in runs(leaves > creeps) if a > 0 and b < len(leaves)]
    return planted_throughout(leaves, planted) + [(a, b) for a, b in between if min(planted[a - 1], planted[b]) > 0.5]


def planted_throughout(leaves: Floats, planted: Floats) -> list[tuple[int, int]]:
    """Find the stretches [start, end) between two rests in which a foot moves and looks planted all the time.

    Args:
        leaves: (n,) [leg lengths/s] its speed, less that of a foot at rest.
        planted: (n,) probability that it is planted.
    """
    between = [(a, b) for a, b in runs(leaves > 0.0) if a > 0 and b < len(leaves)]
    return [(a, b) for a, b in between if planted[a - 1 : b + 1].min() > 0.5]


def whole_step(one: Floats, other: Floats, rest: float, params: SteppingParams) -> float:
    """Compute the probability that a foot with velocities (n, 2, 2) steps, from its distance gained on the other."""
    ways = [velocity.sum(axis=0, keepdims=True) * STEP for velocity in (one, other)]  # (1, 2, 2) [leg lengths]
    far = parting(ways[0], ways[1])
    even = params.length + params.creeping * rest * len(one) * STEP
    odds = params.sharp * _log_ratio(far, np.array([even]))
    odds = np.minimum(odds, params.sharp * _log_ratio(slowest(ways[0]), slowest(ways[1])))
    return float(probability(odds)[0])


def _log_ratio(a: Floats, b: Floats | float) -> Floats:
    return np.asarray(np.log(np.maximum(a, 1e-6)) - np.log(np.maximum(b, 1e-6)))


def resting_speed(speed: Floats, params: SteppingParams) -> Floats:
    """Estimate the speed (n,) that a resting foot reaches before or after each moment; the larger of the two.

    Where the clip is too short for a rest on one side, the other side counts; infinite where there is neither.
    """
    steps = max(round(params.rest / STEP), 1)
    if len(speed) <= steps:
        return np.full_like(speed, np.inf)
    # the highest speed within a rest that starts at each step, and one that ends there
    starts = np.concatenate([sliding_window_view(speed, steps).max(axis=1), np.full(steps - 1, np.inf)])
    ends = np.concatenate([np.full(steps - 1, np.inf), starts[: 1 - steps]])
    ahead, behind = floors(starts, params.within)[0], floors(ends, params.within)[1]
    worse = np.maximum(ahead, behind)
    return np.where(np.isfinite(worse), worse, np.minimum(ahead, behind))


def likely(speed: Floats, even: Floats | float, sharp: float) -> Floats:
    """Evaluate a logistic in log speed (n,): 0.5 at `even`, odds growing as speed ** sharp."""
    return probability(sharp * _log_ratio(speed, even))


def probability(odds: Floats) -> Floats:
    """Convert log odds (n,) to probabilities (n,)."""
    return np.asarray(0.5 + 0.5 * np.tanh(0.5 * odds))


def stands(answer: Floats, steps: Floats) -> Floats:
    """Lower the contact states of log probabilities (..., 4) by the probability (...) that the foot is stepping."""
    out = answer.copy()
    out[..., HEEL:] += np.log1p(-np.minimum(steps, 1.0 - 1e-6))[..., None]
    planted = np.logaddexp.reduce(out[..., HEEL:], axis=-1)
    out[..., SWING] = np.log(np.maximum(-np.expm1(np.minimum(planted, -1e-12)), 1e-12))
    return out


def velocities_of(tracks: Tracks, part: slice = slice(None)) -> tuple[Floats, list[Floats]]:
    """Compute velocities over the ground [leg lengths/s]: pelvis (n, 2), heel and toe of each foot (n, 2, 2)."""
    return velocity_of(tracks.pelvis[part, ::2]), [velocities(foot, part) for foot in tracks.feet]


def velocities(foot: FootTracks, part: slice = slice(None)) -> Floats:
    """Compute the velocities of heel and toe over the ground, (n, 2, 2) [leg lengths/s]."""
    both = np.stack([foot.heel[part, ::2], foot.toe[part, ::2]], axis=1)
    return velocity_of(both)


def velocity_of(places: Floats) -> Floats:
    """Compute the velocities (n, ...) [leg lengths/s] of positions on the grid."""
    return np.asarray(savgol(places, STEP, seconds=WINDOW, degree=2, derivative=1))


def slowest(velocity: Floats) -> Floats:
    """Compute the speed (n,) of the slowest point between heel and toe, on which a rolling or turning sole rests."""
    return _to_segment(np.zeros_like(velocity[:, 0]), velocity)


def parting(one: Floats, other: Floats) -> Floats:
    """Compute the least relative speed (n,) of any point of one sole and any of the other, velocities (n, 2, 2)."""
    ends = [_to_segment(one[:, k], other) for k in (0, 1)] + [_to_segment(other[:, k], one) for k in (0, 1)]
    along, across = one[:, 1] - one[:, 0], other[:, 1] - other[:, 0]
    apart = other[:, 0] - one[:, 0]
    turn = _cross(along, across)
    safe = np.where(np.abs(turn) < 1e-12, 1.0, turn)
    s, t = _cross(apart, across) / safe, _cross(apart, along) / safe
    meet = (np.abs(turn) >= 1e-12) & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    return np.asarray(np.where(meet, 0.0, np.min(ends, axis=0)))


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _to_segment(point: Floats, ends: Floats) -> Floats:
    """Measure the distance (n,) of points (n, 2) from segments (n, 2, 2)."""
    along = ends[:, 1] - ends[:, 0]
    off = point - ends[:, 0]
    share = np.clip(np.sum(off * along, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-12), 0.0, 1.0)
    return np.asarray(np.linalg.norm(off - share[:, None] * along, axis=1))

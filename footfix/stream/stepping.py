"""Feet that step though they look planted: `detect.stepping` for all feet in the newest grid steps.

Also feet that move ahead of a travelling pelvis, as of `detect.overtaking`. Horizontal places and velocities are
complex numbers here: x, and z times i.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.detect.evidence import STEP
from footfix.detect.network import SWING
from footfix.detect.overtaking import OvertakingParams
from footfix.detect.stepping import SteppingParams, from_rest_to_rest, planted_throughout, probability
from footfix.motion.clip import Floats
from footfix.stream.filters import Lowest, slopes
from footfix.stream.ground_velocities import Complexes, slowest, to_segment

_LEAST = 1e-6  # of a speed whose logarithm is taken


def stepping(
    answers: Floats, mates: Sequence[int], velocity: Complexes, speeds: Floats, params: SteppingParams
) -> Floats:
    """Find the probability (feet, n) that a foot steps, from its motion relative to its mate; see `detect.stepping`.

    Args:
        answers: (feet, n, 4) log probabilities.
        mates: for each foot the other one of its pair.
        velocity: (n, 1 + 2 feet) [leg lengths/s] over the ground, of pelvis, heels and toes.
        speeds: (m, feet) [leg lengths/s] of the slowest point of each sole; m is n or more, and the answers are of
            the last n.
        params: when two feet part.
    """
    feet, n = answers.shape[:2]
    mate = list(mates)
    rest = resting_speed(speeds, n, params)
    own = velocity.T[1:].reshape(2, feet, n)
    other, speeds = own[:, mate], speeds[-n:].T
    apart, travel = _parting(own, other, velocity[:, 0])
    figure = np.stack([np.zeros(n), velocity[:, 0]])[:, None]  # (2, 1, n) at rest, or going with the pelvis
    from_figure, _ = _parting(own, figure, velocity[:, 0])
    by_itself = np.minimum(speeds, np.maximum(apart, from_figure))
    both = np.minimum(apart, np.minimum(from_figure, from_figure[mate]))
    swing = answers[..., SWING]
    planted = -np.expm1(swing)
    unlikely = swing - np.log(np.maximum(planted, 1e-12))
    even = params.parting + params.travel * travel + params.noise * rest
    alone = params.parting + params.travel * np.abs(velocity[:, 0]) + params.noise * np.maximum(rest, rest[mate])
    pace = params.fast + params.noise * rest
    logs = np.log(np.maximum(np.stack([apart, even, speeds, by_itself, pace, both, alone]), _LEAST))
    faster = params.sharp * logs[2] + unlikely
    over = params.sharp * np.stack([logs[0] - logs[1], logs[3] - logs[4], logs[5] - logs[6]])
    parts, fast, step_both, quicker = probability(np.stack([*over, faster - faster[mate]]))
    steps = planted[mate] * parts * quicker
    fast = np.maximum(fast, planted[mate] * step_both)
    least = np.maximum(params.still, params.calm * rest)
    for k in np.flatnonzero((speeds > least).any(axis=1)).tolist():
        for a, b in planted_throughout(speeds[k] - least[k], planted[k]):
            far = slowest(*np.add.reduce(own[:, k, a:b], axis=-1) * STEP)
            whole = float(probability(params.sharp * np.log(np.maximum(far, _LEAST) / params.length))[0])
            steps[k, a:b] = np.maximum(steps[k, a:b], fast[k, a:b].max() * whole)
    leaves = np.where(speeds > speeds[mate], apart - least, 0.0)
    for k in np.flatnonzero((leaves > 0.0).any(axis=1)).tolist():
        for a, b in from_rest_to_rest(leaves[k], even[k] - params.parting, planted[k]):
            far = np.add.reduce(np.stack([own[:, k, a:b], other[:, k, a:b]]), axis=-1) * STEP  # (2, 2) [leg lengths]
            whole = _whole_step(far, float(rest[k, a:b].max()) * (b - a) * STEP, params)
            whole *= float(planted[mate[k], a:b].min())
            steps[k, a:b] = np.maximum(steps[k, a:b], max(whole, float(steps[k, a:b].max())))
    unpaired = [k for k, other_foot in enumerate(mate) if other_foot == k]
    steps[unpaired] = 0.0
    return np.asarray(steps)


def _whole_step(far: Complexes, creeps: float, params: SteppingParams) -> float:
    """Find the probability that a foot steps, as `detect.stepping.whole_step` does.

    Args:
        far: (2, 2) [leg lengths] how far heel and toe of the foot go meanwhile, and of the other.
        creeps: [leg lengths] how far at most it would creep at rest.
        params: when two feet part.
    """
    own, other = far[:, :, None, None]
    apart, _ = _parting(own, other, own[0, :, 0])
    one, mate = slowest(*far.T)
    logs = np.log(np.maximum([apart[0, 0], params.length + params.creeping * creeps, one, mate], _LEAST))
    return float(probability(params.sharp * np.minimum(logs[0] - logs[1], logs[2] - logs[3])))


def resting_speed(speeds: Floats, count: int, params: SteppingParams) -> Floats:
    """Find the greatest speed (feet, count) of resting feet, from speeds (m, feet); see `detect.stepping`."""
    steps = max(round(params.rest / STEP), 1)
    m, feet = speeds.shape
    if m <= steps:
        return np.full((feet, count), np.inf)
    highest, width = speeds, 1
    while width < steps:  # the highest of 2 w is the higher of two highest of w
        hop = min(width, steps - width)
        highest = np.maximum(highest[:-hop], highest[hop:])
        width += hop
    both = np.full((2, feet, m), np.inf)  # rests that begin at a step, and that end there
    both[0, :, : len(highest)] = both[1, :, steps - 1 :] = highest.T
    lowest = Lowest(both.reshape(2 * feet, m), params.within, count)
    ahead, behind = lowest.ahead(params.within, slice(0, feet)), lowest.behind(params.within, slice(feet, 2 * feet))
    worse = np.maximum(ahead, behind)
    return np.where(np.isfinite(worse), worse, np.minimum(ahead, behind))


def _parting(own: Complexes, other: Complexes, pelvis: Complexes) -> tuple[Floats, Floats]:
    """Find the least speed at which a point of one sole leaves one of the other, and the pelvis it, (feet, n) each."""
    points = np.empty((5, *own.shape[1:]), dtype=np.complex128)  # own heel and toe, the pelvis, the other's
    starts, ends = np.empty_like(points), np.empty_like(points)
    points[:2], points[2], points[3:] = own, pelvis, other
    starts[:3], starts[3:], ends[:3], ends[3:] = other[0], own[0], other[1], own[1]
    far = to_segment(points, starts, ends)
    along, across = own[1] - own[0], other[1] - other[0]
    apart = other[0] - own[0]
    turn = _cross(along, across)
    askew = np.abs(turn) >= 1e-12
    safe = np.where(askew, turn, 1.0)
    shares = np.stack([_cross(apart, across), _cross(apart, along)]) / safe
    meet = askew & np.logical_and.reduce((shares >= 0.0) & (shares <= 1.0), axis=0)
    least = np.minimum(np.minimum(far[0], far[1]), np.minimum(far[3], far[4]))
    return np.where(meet, 0.0, least), far[2]


def _cross(a: Complexes, b: Complexes) -> Floats:
    return np.asarray((a.conj() * b).imag)


def overtaking(pelvis: Floats, velocity: Complexes, params: OvertakingParams) -> Floats:
    """Find the probability (feet, n) that a foot swings because it moves ahead of the pelvis; see `detect.overtaking`.

    Whether the pelvis travels is found from the time around a step, or from the newest frames where few have followed.

    Args:
        pelvis: (m, 2) [leg lengths] places over the ground; m is n or more.
        velocity: (n, 1 + 2 feet) [leg lengths/s] over the ground, of pelvis, heels and toes.
        params: when a foot moves ahead of the pelvis.
    """
    n = len(velocity)
    lasting = slopes(pelvis, params.lasting, n)
    lasting_way = lasting[:, 0] + 1j * lasting[:, 1]
    travel = np.abs(lasting_way)
    along = (velocity.T * (lasting_way.conj() / np.maximum(travel, 1e-9))).real  # (1 + 2 feet, n)
    goes = np.minimum.reduce(along[1:].reshape(2, -1, n))
    past = goes - np.maximum(travel, along[0])
    even = params.least + params.share * travel
    logs = np.log(np.maximum(np.concatenate([past, even[None], travel[None]]), _LEAST))
    faster, travels = logs[:-2] - logs[-2], logs[-1] - np.log(params.travels)
    return probability(params.sharp * faster) * probability(params.sharp * travels)

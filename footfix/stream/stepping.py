"""Feet that step though they look planted: what `detect.stepping` says of a clip, for all feet of the newest steps.

Places and velocities over the ground are complex numbers here: x, and z times i.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from footfix.detect.evidence import STEP
from footfix.detect.network import SWING
from footfix.detect.stepping import SteppingParams, from_rest_to_rest, stands, whole_step
from footfix.motion.clip import Floats
from footfix.stream.filters import floors

Complexes = NDArray[np.complex128]

_LEAST = 1e-6  # of a speed whose logarithm is taken


def stepping(
    answers: Floats, mates: Sequence[int], pelvis: Complexes, soles: Complexes, params: SteppingParams
) -> Floats:
    """Find the log probabilities of each foot, given what the other of its pair does; see `detect.stepping.stepping`.

    Args:
        answers: (feet, n, 4) log probabilities.
        mates: for each foot the other one of its pair.
        pelvis: (m,) [leg lengths/s] velocity over the ground; m is n or more, and the answers are of the last n.
        soles: (2, feet, m) [leg lengths/s] those of heels and toes.
        params: when two feet part.
    """
    n, mate = answers.shape[1], list(mates)
    heel, toe = soles
    speeds = _to_segment(np.zeros(1, dtype=np.complex128), heel, toe)  # (feet, m)
    rest = resting_speed(speeds, n, params)
    own, other, speeds = soles[..., -n:], soles[:, mate, -n:], speeds[:, -n:]
    apart, travel = _parting(own, other, pelvis[-n:])
    swing = answers[..., SWING]
    planted = -np.expm1(swing)
    unlikely = swing - np.log(np.maximum(planted, 1e-12))
    even = params.parting + params.travel * travel + params.noise * rest
    logs = np.log(np.maximum(np.stack([apart, even, speeds]), _LEAST))
    faster = params.sharp * (logs[2] - logs[2][mate]) + unlikely - unlikely[mate]
    likely = 0.5 + 0.5 * np.tanh(0.5 * np.stack([params.sharp * (logs[0] - logs[1]), faster]))
    steps = planted[mate] * likely[0] * likely[1]
    leaves = np.where(speeds > speeds[mate], apart - np.maximum(params.still, params.calm * rest), 0.0)
    for k in np.flatnonzero((leaves > 0.0).any(axis=1)).tolist():
        for a, b in from_rest_to_rest(leaves[k], (even - params.parting)[k], planted[k]):
            one, mates_way = (_plain(each[:, k, a:b]) for each in (own, other))
            whole = whole_step(one, mates_way, float(rest[k, a:b].max()), params) * float(planted[mate[k], a:b].min())
            steps[k, a:b] = np.maximum(steps[k, a:b], max(whole, float(steps[k, a:b].max())))
    found = stands(answers, steps)
    alone = [k for k, other_foot in enumerate(mate) if other_foot == k]
    found[alone] = answers[alone]
    return found


def _plain(soles: Complexes) -> Floats:
    """(n, 2, 2) of one foot's heel and toe (2, n)."""
    return np.stack([soles.real, soles.imag], axis=-1).swapaxes(0, 1)


def resting_speed(speeds: Floats, count: int, params: SteppingParams) -> Floats:
    """(feet, count) at most how fast feet of some speeds (feet, m) are while they rest; see `detect.stepping`."""
    steps = max(round(params.rest / STEP), 1)
    feet, m = speeds.shape
    if m <= steps:
        return np.full((feet, count), np.inf)
    highest, width = speeds.T, 1
    while width < steps:  # the highest of 2 w is the higher of two highest of w
        hop = min(width, steps - width)
        highest = np.maximum(highest[:-hop], highest[hop:])
        width += hop
    beyond = np.full((steps - 1, feet), np.inf)
    ahead, behind = floors(
        np.concatenate([highest, beyond]), np.concatenate([beyond, highest]), params.within, count,
    )  # fmt: skip
    worse = np.maximum(ahead, behind)
    return np.where(np.isfinite(worse), worse, np.minimum(ahead, behind)).T


def _parting(own: Complexes, other: Complexes, pelvis: Complexes) -> tuple[Floats, Floats]:
    """(feet, n) each: the least speed at which a point of one sole leaves one of the other, and the pelvis it."""
    points = np.concatenate([own, np.broadcast_to(pelvis, (1, *own.shape[1:]))])  # (3, feet, n)
    to_other = _to_segment(points, other[0], other[1])
    to_own = _to_segment(other, own[0], own[1])
    along, across = own[1] - own[0], other[1] - other[0]
    apart = other[0] - own[0]
    turn = _cross(along, across)
    askew = np.abs(turn) >= 1e-12
    safe = np.where(askew, turn, 1.0)
    s, t = _cross(apart, across) / safe, _cross(apart, along) / safe
    meet = askew & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    least = np.minimum(np.minimum(to_other[0], to_other[1]), np.minimum(to_own[0], to_own[1]))
    return np.where(meet, 0.0, least), to_other[2]


def _cross(a: Complexes, b: Complexes) -> Floats:
    return np.asarray((a.conj() * b).imag)


def _to_segment(point: Complexes, start: Complexes, end: Complexes) -> Floats:
    """Distances of points from segments; the shapes broadcast."""
    along, off = end - start, point - start
    across = along.conj()
    share = np.minimum(np.maximum((off * across).real / np.maximum((along * across).real, 1e-12), 0.0), 1.0)
    return np.asarray(np.abs(off - share * along))

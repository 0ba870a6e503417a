"""Which feet a program has put to rest already: no captured foot stands as still as one that was cleaned.

A foot that was held on its ball rolled about one point that did not move at all. Which point that was is not known
any more: the soles found in a cleaned clip are not quite those found in the captured one. But there is one such
point in every joint that was held, and it can be solved for.
"""

from __future__ import annotations

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs

_ROUNDS = 15  # of reweighting, some more than exact solutions have needed,
_COARSE = 0.003  # [leg lengths] from what a captured foot moves in a frame downwards
_SHARE = 0.3  # of the steps that must rest: fewer are chance
_MOST = 2000  # steps that are looked at: enough of any clip
_FAR = 0.06  # leg lengths from the sole point, beyond which a point is none of this foot's


def resting(place: Floats, turn: Floats, offset: Floats, planted: Bools, leg_length: float, rest: float) -> Bools:
    """(F - 1,) the steps between planted frames in which a point of a joint near its sole point rests.

    Of all points o near the sole point, the one is looked for for which |R(t+1) o + p(t+1) - R(t) o - p(t)| is
    zero in as many planted frames as can be: least squares with weights 1 / (r^2 + e^2) that are made anew from the
    residuals r, round by round, as e falls (S. Geman, D. McClure 1987; graduated as by A. Blake, A. Zisserman 1987).

    Args:
        place: (F, 3) [m] of the joint.
        turn: (F, 4) its frame.
        offset: (3,) [m] the sole point in it.
        planted: (F,) frames in which it is in contact.
        leg_length: [m].
        rest: leg lengths from frame to frame, less than which is rest.
    """
    none = np.zeros(max(len(planted) - 1, 0), dtype=np.bool_)
    core = np.zeros_like(planted)  # without the ends of contacts, in which feet land and leave
    for start, end in runs(planted):
        core[start + (end - start) // 4 : end - (end - start) // 4] = True
    steps = np.flatnonzero(core[1:] & core[:-1])
    if len(steps) < 4:
        return none
    few = steps[:: -(-len(steps) // _MOST)]
    m = rotation.to_matrix(turn[np.concatenate([few, few + 1])])  # (2 n, 3, 3)
    turned, still = m[len(few) :] - m[: len(few)], rest * leg_length
    moved = turned @ offset + place[few + 1] - place[few]  # (n, 3) [m] the sole point's steps
    delta = np.zeros(3)
    for e in np.geomspace(_COARSE * leg_length, 0.3 * still, _ROUNDS):
        residual = moved + turned @ delta
        weight = 1.0 / (np.einsum("ni,ni->n", residual, residual) + e * e)
        weighted = weight[:, None, None] * turned
        normal = np.einsum("nij,nik->jk", turned, weighted) + 1e-9 * weight.sum() * np.eye(3)
        delta = -np.linalg.solve(normal, np.einsum("nij,ni->j", weighted, moved))
    rests = np.linalg.norm(moved + turned @ delta, axis=1) <= still
    if np.linalg.norm(delta) > _FAR * leg_length or int(rests.sum()) < max(4, _SHARE * len(few)):
        return none
    point = place + rotation.rotate(turn, offset + delta)
    return np.asarray(planted[1:] & planted[:-1] & (np.linalg.norm(np.diff(point, axis=0), axis=1) <= still))

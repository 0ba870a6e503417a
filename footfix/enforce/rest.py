"""Which feet a program has put to rest already: no captured foot stands as still as one that was cleaned.

A foot that was held on its ball rolled about one point that did not move at all. Which point that was is not known
any more: the soles found in a cleaned clip are not quite those found in the captured one. But there is one such
point in every joint that was held, and it can be solved for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.foot import Foot
from footfix.enforce.plants import Plant, PlantParams, Stance, agreement, heights, longest
from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.motion.vectors import norm

LEFT = "left as it was when this clip was cleaned (enforce.again looks at it)"  # the reason of plants that are

_ROUNDS = 20  # of reweighting, some more than exact solutions have needed,
_COARSE = 0.01  # [leg lengths] from what a captured foot moves in a frame downwards
SHARE = 0.3  # of the steps that must rest: fewer are chance
EXACTLY = 0.1  # of what is rest: in a few frames at a time, nothing captured rests so exactly
_LOCKED, _FEWEST = 0.1, 5  # [s] that it does in a row, and steps: fewer are chance
_GOES_ON = 0.001  # leg lengths that the hip moves meanwhile: a figure that does not move at all rests, too
_MOST = 2000  # steps that are looked at: enough of any clip
_IN_A_ROW = 4  # stands of which none rests: more than are let go one after the other,
_CHANCE = 0.002  # and less likely than this to be
_FAR = 0.08  # leg lengths from the sole point, beyond which a point is none of this foot's


def resting(
    place: Floats, turn: Floats, offset: Floats, planted: Bools, leg_length: float, rest: float, share: float = SHARE
) -> Bools:
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
        share: of the steps; where fewer rest, none do.
    """
    none = np.zeros(max(len(planted) - 1, 0), dtype=np.bool_)
    core = np.zeros_like(planted)  # without the ends of contacts, in which feet land and leave
    for start, end in runs(planted):
        edge = min((end - start) // 4, max((end - start - 4) // 2, 0))
        core[start + edge : end - edge] = True
    steps = np.flatnonzero(core[1:] & core[:-1])
    if len(steps) < 4:
        return none
    few = steps[:: -(-len(steps) // _MOST)]
    m = rotation.to_matrix(turn[np.concatenate([few, few + 1])])  # (2 n, 3, 3)
    turned, still = m[len(few) :] - m[: len(few)], rest * leg_length
    moved = turned @ offset + place[few + 1] - place[few]  # (n, 3) [m] the sole point's steps
    best = (0, np.zeros(3))
    for coarsest in (_COARSE * leg_length, 30.0 * still):  # the sole may be known well: then few steps will do
        delta = np.zeros(3)
        for e in np.geomspace(coarsest, 0.3 * still, _ROUNDS):
            residual = moved + turned @ delta
            weight = 1.0 / (np.einsum("ni,ni->n", residual, residual) + e * e)
            weighted = weight[:, None, None] * turned
            normal = np.einsum("nij,nik->jk", turned, weighted) + 1e-9 * weight.sum() * np.eye(3)
            delta = -np.linalg.solve(normal, np.einsum("nij,ni->j", weighted, moved))
        count = int(np.count_nonzero(norm(moved + turned @ delta) <= still))
        if count > best[0] and np.linalg.norm(delta) <= _FAR * leg_length:
            best = (count, delta)
    rested, delta = best
    point = place + rotation.rotate(turn, offset + delta)
    if rested < max(4, share * len(few)):
        return none
    return np.asarray(planted[1:] & planted[:-1] & (norm(np.diff(point, axis=0)) <= still))


def locked(rests: Bools, hip: Floats, frame_time: float, leg_length: float) -> list[tuple[int, int]]:
    """The rows of frames `[start, end)` in which a sole point rests while its hip (F, 3) [m] goes on.

    So a program leaves it, if the steps (F - 1,) from `resting` rest far more exactly than slow feet do.
    """
    fewest = max(_FEWEST, round(_LOCKED / frame_time))
    return [
        (start, end + 1)
        for start, end in runs(rests)
        if end - start >= fewest and norm(np.ptp(hip[start : end + 1], axis=0)) > _GOES_ON * leg_length
    ]


def as_cleaned(stance: Stance, foot: Foot, rests: Mapping[int, Bools], params: PlantParams) -> Stance:
    """The stance as it stands, kept, if it was cleaned before; otherwise the same value.

    `rests` says of each sole point which of its steps from frame to frame (F - 1,) a program put to rest. Some end
    of a cleaned foot rests most of the time; what is left of its contacts lands or leaves, and was left to do so.
    """
    if any(plant.contact.position is not None or plant.given for plant in stance.plants):
        return stance
    cores = [_core(plant, rests[plant.effector]) for plant in stance.plants]
    frames = max(p.contact.end for p in stance.plants) - min(p.contact.start for p in stance.plants)
    if len({t for core in cores for t in range(core.start, core.stop)}) < max(params.cleaned * frames, 3):
        return stance
    plants = tuple(_as_held(plant, foot, core) for plant, core in zip(stance.plants, cores, strict=True))
    level = float(np.median(heights([plant for plant in plants if plant.kept], foot)))
    return replace(stance, plants=plants, level=level, cleaned=True)


def new_since(stands: Sequence[Stance], rests: Sequence[bool]) -> list[int]:
    """In which row of stances, from 1, each was put into a clip after it was cleaned, as by splicing; 0 if it was not.

    There are some in a row, none of which `rests` in any part: more than chance would put there, of as many as are
    let go in the rest of the clip (the rule of succession, P.-S. Laplace 1774). Stances beside them that were not
    cleaned belong to them: they rest only as far as the cut.
    """
    order = sorted(range(len(stands)), key=lambda k: stands[k].frames.start)
    stir = np.array([not rests[k] for k in order], dtype=np.bool_)
    new = [0] * len(stands)
    for row, (start, end) in enumerate(runs(stir), start=1):
        others = len(stir) - (end - start)
        let_go = (np.count_nonzero(stir) - (end - start) + 1) / (others + 2)
        if end - start >= _IN_A_ROW and let_go ** (end - start) < _CHANCE:
            while start > 0 and not stands[order[start - 1]].cleaned:
                start -= 1
            while end < len(order) and not stands[order[end]].cleaned:
                end += 1
            for k in order[start:end]:
                new[k] = row
    return new


def off_their_floor(stands: Sequence[Stance], floor: float, leg_length: float, params: PlantParams) -> bool:
    """Whether the cleaned stances among these rest, on the whole, a little off a floor that they should be on."""
    off = np.array([stance.level - floor for stance in stands if stance.cleaned]) / leg_length
    near = off[np.abs(off) <= params.snap]
    if not len(near):
        return False
    common, agree = agreement(near)
    # a whole clip is moved as a whole: where its stands disagree, their soles were found elsewhere than before
    return abs(common) > params.off_floor and agree > 0.75


def _core(plant: Plant, rests: Bools) -> slice:
    """The frames of a plant from the first to the last of the longest row of steps (F - 1,) at rest."""
    first = plant.contact.start
    core = longest(rests[first : plant.contact.end - 1])
    return slice(first + core.start, first + core.stop + 1) if core.stop > core.start else slice(first, first)


def _as_held(plant: Plant, foot: Foot, core: slice) -> Plant:
    if core.stop <= core.start:  # it only lands or leaves
        return replace(plant, reason=LEFT)
    target = np.median(foot.point(plant.part)[core], axis=0)
    return replace(plant, start=core.start, end=core.stop, target=target, kept=True)

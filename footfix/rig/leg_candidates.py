"""Find legs in a skeleton: pairs of similar chains, judged by shape and place, with names as evidence."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from footfix.rig.frame_sample import Sample
from footfix.rig.names import read

_SURE = 2.9  # score of names from which a limb is certainly a leg, however far its hip is from the pelvis:
_HIP_BONE = 1.0  # animals are drawn with bones for hips and shoulders that are as long as a thigh
_BEST_OF = 4  # most candidates from each branch


@dataclass(frozen=True)
class Limb:
    """A chain that could be a leg: hip, knee, ankle, by joint index.

    Args:
        branch: the child of the pelvis that it hangs from.
        chain: every joint from hip to ankle.
        thigh, shin: lengths along the bones.
        score: how much it looks like a leg.
    """

    branch: int
    hip: int
    knee: int
    ankle: int
    chain: tuple[int, ...]
    thigh: float
    shin: float
    score: float
    named: float = 0.0

    @property
    def length(self) -> float:
        return self.thigh + self.shin


@dataclass(frozen=True)
class Pair:
    """Two alike limbs that hang from one joint.

    Args:
        pelvis: that joint.
        limbs: the two.
        score: how much they look like the legs of their figure.
        shape: the part of it that comes from their bones alone.
    """

    pelvis: int
    limbs: tuple[Limb, Limb]
    score: float
    shape: float = 0.0

    @property
    def length(self) -> float:
        return 0.5 * (self.limbs[0].length + self.limbs[1].length)

    @property
    def named(self) -> float:
        return 0.5 * (self.limbs[0].named + self.limbs[1].named)


def pairs(sample: Sample, root: int) -> list[Pair]:
    """Find the pairs of alike limbs below a root, the likeliest legs first."""
    skeleton = sample.skeleton
    figure = [joint for joint in range(len(skeleton)) if root in skeleton.ancestors(joint)]
    fork = _fork(sample, root)
    size = float(sample.reach[fork])  # the distance to the joints that carry the body is not part of its size
    if size <= 0.0:
        return []
    found = []
    for pelvis in figure:
        branches = [c for c in skeleton.children[pelvis] if sample.reach[c] > 0.1 * size]
        if len(branches) < 2:
            continue
        candidates = {c: _limbs(sample, c, size) for c in branches}
        for a, b in combinations(branches, 2):
            best = max(
                (_pair(sample, pelvis, x, y) for x in candidates[a] for y in candidates[b]),
                key=lambda pair: pair.score,
                default=None,
            )
            if best is not None and math.isfinite(best.score):
                found.append(best)
    if not found:
        return []
    best_score = max(pair.score for pair in found)
    longest = max(pair.length for pair in found if pair.score >= best_score - 8.0)
    away = {pair.pelvis: _way(sample, fork, size, pair.pelvis) for pair in found}
    judged = [
        replace(
            pair,
            score=pair.score + 1.5 * min(1.0, pair.length / longest) - 0.8 * min(1.5, away[pair.pelvis] / pair.length),
        )
        for pair in found
    ]
    return sorted(judged, key=lambda pair: -pair.score)


def _fork(sample: Sample, root: int) -> int:
    """Find the joint at which a body begins, below joints that only carry it (reference or simulation bones)."""
    while True:
        total = sum(sample.bones[list(sample.below(root)[1:])])
        for child in sample.skeleton.children[root]:
            if sum(sample.bones[list(sample.below(child)[1:])]) > 0.8 * (total - sample.bones[child]) > 0.0:
                root = child
                break
        else:
            return root


def _way(sample: Sample, fork: int, size: float, joint: int) -> float:
    """Measure how far along the bones a joint is from what carries the body: a travelling joint, or where it begins."""
    above = sample.skeleton.ancestors(joint)
    travellers = [place for place, each in enumerate(above) if sample.travel[each] > 0.003 * size]
    last = travellers[0] if travellers else above.index(fork) if fork in above else len(above) - 1
    return float(sum(sample.bones[each] for each in above[:last]))


def _limbs(sample: Sample, branch: int, size: float) -> list[Limb]:
    """Find the chains below one branch that are shaped like a leg, best first."""
    found: list[Limb] = []
    stack: list[tuple[int, tuple[int, ...], tuple[float, ...]]] = [(branch, (branch,), (0.0,))]
    while stack:
        joint, path, way = stack.pop()
        if len(path) >= 3 and way[-1] > 0.07 * size:
            found += _split(sample, branch, path, way)
        if len(path) < 16:
            for child in sample.skeleton.children[joint]:
                stack.append((child, (*path, child), (*way, way[-1] + float(sample.bones[child]))))
    found.sort(key=lambda limb: -limb.score)
    return found[:_BEST_OF]


def limb_of(sample: Sample, ankle: int, knee: int | None, hip: int | None) -> Limb | None:
    """Find the chain above a given ankle, with knee and hip as given or by its shape; None where it has none."""
    path = sample.skeleton.ancestors(ankle)[::-1]
    way = tuple(np.cumsum([0.0, *(float(sample.bones[joint]) for joint in path[1:])]).tolist())
    found = []
    for h in range(len(path) - 2) if hip is None else [path.index(hip)]:
        for k in range(h + 1, len(path) - 1) if knee is None else [path.index(knee)]:
            if h < k:
                found.append(_cut(sample, path[h], path, way, h, k, 0.0))
    given = [limb for limb in found if limb.thigh > 0.0 and limb.shin > 0.0]
    return max(given, key=lambda limb: limb.score, default=None)


def _split(sample: Sample, branch: int, path: tuple[int, ...], way: tuple[float, ...]) -> list[Limb]:
    """List the ways in which a path can be cut into thigh and shin, its last joint being the ankle."""
    foot = float(sample.reach[path[-1]])
    found = []
    for h in range(len(path) - 2):
        length = way[-1] - way[h]
        upper = float(sample.bones[branch]) + way[h]
        if length <= 0.0 or foot > 1.2 * length:
            continue
        for k in range(h + 1, len(path) - 1):
            if upper > 0.9 * length and _named(sample, path, h, k) < _SURE:
                continue
            if 0.35 * (way[-1] - way[k]) < way[k] - way[h] < 2.8 * (way[-1] - way[k]):
                found.append(_cut(sample, branch, path, way, h, k, upper))
    return found


def _cut(
    sample: Sample, branch: int, path: tuple[int, ...], way: tuple[float, ...], h: int, k: int, upper: float
) -> Limb:
    """Cut a limb with its hip and knee at places `h` and `k` of a path, and score how much of a leg it is."""
    last = len(path) - 1
    thigh, shin = way[k] - way[h], way[last] - way[k]
    length = max(thigh + shin, 1e-12)
    foot, total = float(sample.reach[path[last]]), float(sample.reach[branch])
    named = _named(sample, path, h, k)
    score = (
        length / max(total, length)
        - (math.log(max(thigh, 1e-12) / max(shin, 1e-12)) / 0.45) ** 2
        - (3.0 if named < _SURE else _HIP_BONE) * max(0.0, upper / length - 0.35)
        - 3.0 * max(0.0, foot / length - 0.5)
        + (0.3 + 0.05 * foot / length if foot > 0.06 * length else 0.0)
        - 15.0 * (_slack(sample, path, way, h, k) + _slack(sample, path, way, k, last))
        - 0.01 * (h + k)
        + 0.005 * last
        + named
    )
    return Limb(branch, path[h], path[k], path[last], path[h:], thigh, shin, score, named)


def _slack(sample: Sample, path: tuple[int, ...], way: tuple[float, ...], a: int, b: int) -> float:
    """Measure how far a stretch of bones is from being one straight bone, as a share of its length."""
    if b == a + 1:
        return 0.0
    return max(0.0, 1.0 - sample.distance(path[a], path[b]) / (way[b] - way[a]))


_WORTH = {  # score of a part's name at hip, knee and ankle
    "thigh": (1.0, -0.5, -1.0),
    "knee": (-0.5, 1.0, -0.5),
    "leg": (0.4, 0.6, 0.0),
    "ankle": (-1.0, -0.7, 1.0),
    "toe": (-1.0, -1.0, -0.6),
    "heel": (-1.0, -1.0, -0.8),
    "arm": (-1.5, -1.5, -1.5),
    "other": (-1.5, -1.5, -1.5),
    "": (0.0, 0.0, 0.0),
}


def _named(sample: Sample, path: tuple[int, ...], h: int, k: int) -> float:
    names = sample.skeleton.names
    worth = 0.0
    for place, joint in enumerate((path[h], path[k], path[-1])):
        reading = read(names[joint])
        worth += _WORTH[reading.part][place] - (0.6 if reading.helper else 0.0)
    return worth


def _pair(sample: Sample, pelvis: int, a: Limb, b: Limb) -> Pair:
    names = sample.skeleton.names
    unlike = 3.0 * (abs(math.log(a.thigh / b.thigh)) + abs(math.log(a.shin / b.shin)))
    sides = [next((s for s in (read(names[j]).side for j in limb.chain) if s), "") for limb in (a, b)]
    named = 0.0 if not all(sides) else 0.5 if sides[0] != sides[1] else -3.0
    named -= 0.5 * abs(a.named - b.named)  # a leg and a spine make no pair
    width = sample.distance(a.hip, b.hip) / (0.5 * (a.length + b.length))
    odd = 1.5 if width < 0.03 else 2.0 * max(0.0, width - 0.7)
    alike = -unlike - abs(len(a.chain) - len(b.chain)) * 0.2 - odd
    own = 0.5 * (a.score + b.score)
    return Pair(pelvis, (a, b), own + alike + named, own - 0.5 * (a.named + b.named) + alike)

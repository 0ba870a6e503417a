"""Find the ball joint of a foot, over which the heel rises."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion.clip import Floats
from footfix.rig.frame_sample import Sample
from footfix.rig.leg_candidates import Limb
from footfix.rig.names import read

_BALL = 0.7  # share of the way from ankle to tip of toes at which the ball is
_NEAREST = 0.3  # share below which a joint is still the ankle
_LEAST = 0.04  # [leg lengths] from the ankle, likewise
_ABREAST = 0.5  # greatest sideways share of the vector from the ankle


@dataclass(frozen=True)
class _Candidate:
    joint: int
    score: float
    far: float  # [leg lengths] from the ankle
    depth: int  # joints below the ankle


def balls(sample: Sample, limbs: tuple[Limb, Limb]) -> tuple[int | None, int | None]:
    """Find the joints at the balls of two feet that are alike; None where a foot has none."""
    across = sample.places[:, limbs[0].hip] - sample.places[:, limbs[1].hip]
    one, other = (_candidates(sample, limb, across) for limb in limbs)
    if not one or not other:
        return _best(one), _best(other)
    worth = {
        (a.joint, b.joint): a.score + b.score - 5.0 * abs(a.far - b.far) - 0.2 * abs(a.depth - b.depth)
        for a in one
        for b in other
    }
    best = max(worth, key=lambda two: worth[two])
    level = {a.joint: a.depth for a in (*one, *other)}
    # Where each toe has a joint, the balls are those of the big toes, which are nearest to each other.
    apart = {
        two: sample.distance(*two)
        for two in worth
        if worth[two] >= worth[best] - 0.2 and all(level[a] == level[b] for a, b in zip(two, best, strict=True))
    }
    return min(apart, key=lambda two: apart[two])


def ball(sample: Sample, limb: Limb) -> int | None:
    """Find the joint at the ball of one foot; None where it has none."""
    return _best(_candidates(sample, limb, np.zeros((len(sample), 3))))


def _best(candidates: list[_Candidate]) -> int | None:
    return max(candidates, key=lambda each: each.score).joint if candidates else None


def _candidates(sample: Sample, limb: Limb, across: Floats) -> list[_Candidate]:
    """List the joints of a foot that could be its ball; `across` (S, 3) goes from foot to foot."""
    skeleton = sample.skeleton
    origin = sample.places[:, limb.ankle]
    shin, across = _unit(origin - sample.places[:, limb.knee]), _unit(across)
    below = sample.below(limb.ankle)
    spans = {joint: sample.places[:, joint] - origin for joint in below[1:]}
    ends = [sample.ends[:, e] - origin for e, parent in enumerate(skeleton.end_parents.tolist()) if parent in below]
    farthest = max((_length(span) for span in (*spans.values(), *ends)), default=0.0)
    found = []
    for joint, span in spans.items():
        far = _length(span)
        if far < max(_NEAREST * farthest, _LEAST * limb.length):
            continue
        reading = read(skeleton.names[joint])
        if reading.tip:
            continue
        named = reading.part in ("toe", "ankle")  # some call the ball the foot
        if not named and far < 3.0 * _LEAST * limb.length and _along(span, shin) > 0.9 * far:
            continue  # it is straight below the ankle
        sideways = float(np.abs(np.einsum("fi,fi->f", span, across)).mean()) / far
        depth = len(skeleton.ancestors(joint)) - len(skeleton.ancestors(limb.ankle))
        score = -abs(far / farthest - _BALL) - 3.0 * max(0.0, sideways - _ABREAST) - 0.1 * depth
        score += 0.5 * named - 0.5 * reading.helper - 1.0 * (reading.part == "heel")
        found.append(_Candidate(joint, score, far / limb.length, depth))
    return found


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12))


def _length(vectors: Floats) -> float:
    return float(np.linalg.norm(vectors, axis=-1).mean())


def _along(vectors: Floats, units: Floats) -> float:
    return float(np.einsum("fi,fi->f", vectors, units).mean())

"""Feet that go ahead of a pelvis that travels: they swing, however low they pass.

Over a foot that stands the pelvis goes ahead; over one that swings it falls behind. Neither the height of a foot nor
skate changes this: where the way of the root is scaled or drifts, the planted foot is taken along by as much. On a
belt, and where a figure sways on the spot, nothing is told: there the pelvis does not travel for long.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.detect.evidence import STEP
from footfix.detect.stepping import likely, stands
from footfix.motion.clip import Floats
from footfix.motion.smoothing import savgol


@dataclass(frozen=True, kw_only=True)
class OvertakingParams:
    """When a foot that looks planted goes ahead of the pelvis.

    Args:
        least: [leg lengths/s] by how much faster than the pelvis a foot goes the pelvis' way that swings as likely as
            not, of a pelvis that hardly travels.
        share: [factor] how much more for each leg length/s at which the pelvis travels.
        travels: [leg lengths/s] at which a pelvis travels as likely as not.
        lasting: [s] over which it travels, not sways.
        sharp: [factor] how steeply the odds rise with the speed; they are its power.
    """

    least: float = 0.15
    share: float = 0.2
    travels: float = 0.3
    lasting: float = 0.6
    sharp: float = 6.0


def overtaking(
    answers: tuple[Floats, ...], pelvis: Floats, now: Floats, each: Sequence[Floats], params: OvertakingParams
) -> tuple[Floats, ...]:  # fmt: skip
    """The log probabilities (n, 4) of each foot, given where it goes beside the pelvis.

    Args:
        answers: for each foot (n, 4) log probabilities.
        pelvis: (n, 2) [leg lengths] places over the ground.
        now: (n, 2) [leg lengths/s] its velocity.
        each: for each foot (n, 2, 2) [leg lengths/s] those of heel and toe.
        params: when a foot goes ahead.
    """
    lasting = savgol(pelvis, STEP, seconds=params.lasting, degree=1, derivative=1)
    return tuple(stands(answer, ahead(foot, now, lasting, params)) for answer, foot in zip(answers, each, strict=True))


def ahead(foot: Floats, now: Floats, lasting: Floats, params: OvertakingParams) -> Floats:
    """(n,) the probability that a foot swings since it goes ahead of a pelvis that travels.

    Args:
        foot: (n, 2, 2) [leg lengths/s] velocity over the ground of heel and toe.
        now: (n, 2) [leg lengths/s] of the pelvis.
        lasting: (n, 2) [leg lengths/s] the same over a while.
        params: when a foot goes ahead.
    """
    travel = np.linalg.norm(lasting, axis=1)
    way = lasting / np.maximum(travel, 1e-9)[:, None]
    goes = np.min(np.sum(foot * way[:, None], axis=2), axis=1)  # the slower of heel and toe
    past = goes - np.maximum(travel, np.sum(now * way, axis=1))
    faster = likely(past, params.least + params.share * travel, params.sharp)
    return faster * likely(travel, params.travels, params.sharp)

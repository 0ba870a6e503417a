"""Feet that move ahead of a travelling pelvis: they are swinging, however low they pass.

The pelvis moves ahead of a planted foot and falls behind a swinging one. Neither the height of a foot nor skate
changes this: where the root path is scaled or drifts, the planted foot moves along with it. On a belt, and where a
figure sways on the spot, the rule does not apply, since the pelvis does not travel for long.
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
    """When a foot that looks planted moves ahead of the pelvis, and so is swinging.

    Args:
        least: [leg lengths/s] forward speed over the pelvis at which swing has probability 0.5, pelvis nearly still.
        share: [factor] increase of that speed for each leg length/s of the pelvis' speed.
        travels: [leg lengths/s] speed at which the pelvis is travelling with probability 0.5.
        lasting: [s] window of that speed, long enough to average swaying out.
        sharp: [factor] exponent of the speed in the odds.
    """

    least: float = 0.15
    share: float = 0.2
    travels: float = 0.3
    lasting: float = 0.6
    sharp: float = 6.0


def overtaking(
    answers: tuple[Floats, ...], pelvis: Floats, now: Floats, each: Sequence[Floats], params: OvertakingParams
) -> tuple[Floats, ...]:  # fmt: skip
    """Update each foot's log probabilities (n, 4) by its motion relative to the pelvis.

    Args:
        answers: for each foot (n, 4) log probabilities.
        pelvis: (n, 2) [leg lengths] places over the ground.
        now: (n, 2) [leg lengths/s] velocity of the pelvis.
        each: for each foot (n, 2, 2) [leg lengths/s] velocities of heel and toe.
        params: when a foot moves ahead of the pelvis.
    """
    lasting = savgol(pelvis, STEP, seconds=params.lasting, degree=1, derivative=1)
    return tuple(stands(answer, ahead(foot, now, lasting, params)) for answer, foot in zip(answers, each, strict=True))


def ahead(foot: Floats, now: Floats, lasting: Floats, params: OvertakingParams) -> Floats:
    """Compute the probability (n,) that a foot is swinging because it moves ahead of a travelling pelvis.

    Args:
        foot: (n, 2, 2) [leg lengths/s] velocity over the ground of heel and toe.
        now: (n, 2) [leg lengths/s] of the pelvis.
        lasting: (n, 2) [leg lengths/s] of the pelvis, over the longer window.
        params: when a foot moves ahead of the pelvis.
    """
    travel = np.linalg.norm(lasting, axis=1)
    way = lasting / np.maximum(travel, 1e-9)[:, None]
    goes = np.min(np.sum(foot * way[:, None], axis=2), axis=1)  # the slower of heel and toe
    past = goes - np.maximum(travel, np.sum(now * way, axis=1))
    faster = likely(past, params.least + params.share * travel, params.sharp)
    return faster * likely(travel, params.travels, params.sharp)

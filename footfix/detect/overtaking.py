"""Feet that go ahead of a pelvis that travels: they swing, however low they pass.

Over a foot that stands the pelvis goes ahead; over one that swings it falls behind. Neither the height of a foot nor
skate changes this: where the way of the root is scaled or drifts, the planted foot is taken along by as much. On a
belt, and where a figure sways on the spot, nothing is told: there the pelvis does not travel for long.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.detect.evidence import STEP, Sampled
from footfix.detect.stepping import stands, velocities, velocity_of
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
    answers: tuple[Floats, ...], sampled: Sampled, part: slice, params: OvertakingParams
) -> tuple[Floats, ...]:
    """The log probabilities (n, 4) of each foot, given where it goes beside the pelvis.

    Args:
        answers: for each foot (n, 4) log probabilities.
        sampled: the clip.
        part: of its grid that the answers are of.
        params: when a foot goes ahead.
    """
    places = sampled.tracks.pelvis[part, ::2]
    now, lasting = velocity_of(places), savgol(places, STEP, seconds=params.lasting, degree=1, derivative=1)
    feet = (velocities(foot, part) for foot in sampled.tracks.feet)
    return tuple(stands(answer, ahead(foot, now, lasting, params)) for answer, foot in zip(answers, feet, strict=True))


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
    return _likely(past, params.least + params.share * travel, params) * _likely(travel, params.travels, params)


def _likely(speed: Floats, even: Floats | float, params: OvertakingParams) -> Floats:
    """(n,) the probability of something that is as likely as not at a speed, and the likelier the higher it is."""
    ratio = np.maximum(speed, 0.0) / even
    return np.asarray(ratio**params.sharp / (1.0 + ratio**params.sharp))

"""Legs that shake from frame to frame are steadied before their feet are held.

Noise that is new in every frame is small in place and vast in acceleration: 0.2 degrees of it at 120 frames a second
accelerate an ankle ten times as much as walking does. Held feet under a shaking leg make the knee shake instead, so
that such a clip can't be corrected invisibly without it. Captured motion is not touched: what it does from one
frame to the next has to do with what it did before, and noise has not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.ease import fit
from footfix.enforce.foot import Foot
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats
from footfix.motion.vectors import dot, norm
from footfix.notes import Note
from footfix.rig.rig import Rig


@dataclass(frozen=True, kw_only=True)
class SteadyParams:
    """When legs shake, and how calm they are to be."""

    white: float = -0.6  # how alike neighbouring fourth differences are, at most: -0.8 in noise, above 0 in motion
    carries: float = 3.5  # the noise's own acceleration times this reaches the leg's peaks: noise is what they are
    least: float = 3.0  # [leg lengths/s^2] of the noise: less is not seen
    share: float = 0.14  # of the calm leg's peak acceleration, what noise may still add to it; 0 steadies nothing


_FEWEST = 24  # frames, of which noise can be told from motion
_PEAK = 99.0  # [percentile] of a leg's accelerations
_SETTLE = np.geomspace(0.002, 0.06, 30)  # [s] times that are tried, from what no noise needs to a third of a step


@dataclass(frozen=True)
class Shaking:
    """Noise in a track that is new in every frame.

    Args:
        sigma: [m, or the track's unit] its standard deviation.
        white: the mean product of neighbouring fourth differences over their mean square. The coefficients
            1, -4, 6, -4, 1 make it -56 / 70 of white noise; of an oscillation of f hertz it is cos(2 pi f / fps).
    """

    sigma: float
    white: float


def shaking(track: Floats) -> Shaking:
    """What of a track (F, D) is noise, by the medians of its fourth differences, in which motion hardly shows.

    Source: the difference-based estimator of J. von Neumann et al., Annals of Mathematical Statistics 12 (1941), of
    higher order and with medians, since steps and strikes are no noise.
    """
    fourth = np.diff(track, n=4, axis=0)
    if len(fourth) < 8:
        return Shaking(0.0, 1.0)
    ahead, behind = fourth[1:], fourth[:-1]
    square = 0.5 * float(np.median(dot(ahead, ahead) + dot(behind, behind)))
    deviation = np.median(np.abs(fourth), axis=0) / 0.6745  # of a normal distribution
    # the variance of a fourth difference: 1 + 16 + 36 + 16 + 1 = 70 times that of a frame
    sigma = float(np.sqrt(np.sum(deviation**2) / 70.0))
    return Shaking(sigma, float(np.median(dot(ahead, behind))) / max(square, 1e-300))


def settled(track: Floats, frame_time: float, settle: float) -> Floats:
    """The track (F, D) without what is quicker than `settle` [s]: a smoothing spline over the whole clip."""
    everywhere = np.ones(len(track), dtype=np.bool_)
    return fit(np.ones(len(track)), track, everywhere, frame_time, settle, np.inf)


def settle_of(track: Floats, frame_time: float, leg_length: float, params: SteadyParams) -> float:
    """[s] over which a leg whose ankle goes this way (F, 3) [m] from its hip is to be steadied; 0 if it does not shake.

    The shortest that leaves no more than a share of the leg's own peak acceleration to the noise. The spline passes
    1 / (1 + (settle w)^4) of a frequency w, so that of noise with deviation sigma an acceleration is left whose square
    is  sigma^2 frame_time / pi  times the integral of  w^4 / (1 + (settle w)^4)^2,  which is
    sqrt(2) pi / (16 settle^5).
    """
    noise = shaking(track)
    accelerates = noise.sigma * np.sqrt(6.0) / frame_time**2  # [m/s^2] second differences of noise: 1 + 4 + 1
    if noise.white > params.white or accelerates < params.least * leg_length or params.share <= 0.0:
        return 0.0
    if _peak(track, frame_time) > params.carries * accelerates:
        return 0.0
    for settle in _SETTLE:
        left = noise.sigma * np.sqrt(frame_time * np.sqrt(2.0) / 16.0) * settle**-2.5
        if left <= params.share * _peak(settled(track, frame_time, settle), frame_time):
            break
    return float(settle)


def _peak(track: Floats, frame_time: float) -> float:
    """[m/s^2] the acceleration of a track (F, 3) [m] at its fastest."""
    return float(np.percentile(norm(np.diff(track, n=2, axis=0)), _PEAK)) / frame_time**2


def steadied(
    clip: Clip, rig: Rig, legs: Sequence[Foot], strength: float, params: SteadyParams
) -> tuple[Clip, tuple[int, ...], tuple[Note, ...]]:
    """The clip with legs that do not shake.

    All joints from the root to the toes are steadied whose own rotations shake; what hangs above the legs keeps its
    channels.

    Args:
        clip: F frames.
        rig: its legs.
        legs: their tracks.
        strength: 0 to 1: how much of it.
        params: measures.

    Returns:
        The clip, the joints that turn otherwise in it, and a note; the same clip where no leg shakes.
    """
    if len(clip) < _FEWEST:
        return clip, (), ()
    settle = max(
        (settle_of(foot.ankle - foot.hip, clip.frame_time, rig.leg_length, params) for foot in legs), default=0.0
    )
    if settle == 0.0 or strength <= 0.0:
        return clip, (), ()
    joints = {
        joint for leg in rig.legs
        for joint in (*clip.skeleton.ancestors(leg.hip), *leg.chain, leg.toe) if joint is not None
    }  # fmt: skip
    turns = {}
    for joint in sorted(joints):
        q = rotation.continuous(clip.turn(joint))
        if np.any(q != q[:1]) and shaking(q).white <= params.white:
            calm = rotation.normalize(settled(q, clip.frame_time, settle))
            turns[joint] = rotation.slerp(q, calm, np.full(len(clip), min(strength, 1.0)))
    if not turns:
        return clip, (), ()
    text = (
        f"the legs shake from frame to frame more than they move, so {len(turns)} joints from the root to the toes are "
        f"smoothed over {1000.0 * settle:.0f} ms (enforce.steady.share: 0 leaves them)"
    )
    return clip.with_joints({}, turns), tuple(turns), (Note("legs-steadied", text),)

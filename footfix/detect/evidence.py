"""Evidence of contact: features of each foot that do not depend on scale, on a time grid of fixed rate.

Everything is in leg lengths and seconds, relative to the floor right there, to the pelvis or to the other
foot, so that neither the unit, the size of the figure, where and which way it walks nor the height of the
floor matter; and it is sampled at one rate, so that the rate of the clip does not matter either.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from footfix.detect.tracks import FootTracks, Tracks
from footfix.motion.clip import Floats
from footfix.motion.smoothing import savgol
from footfix.motion.threads import at_once

STEP = 0.01  # [s] of the grid

# The features of each foot in order, each with the unit that it is divided by before asinh compresses it.
OWN: dict[str, float] = {
    "heel over floor ahead": 0.02, "heel over floor behind": 0.02,
    "toe over floor ahead": 0.02, "toe over floor behind": 0.02,
    "heel over its own floor": 0.01, "toe over its own floor": 0.01,
    "heel rise": 0.3, "toe rise": 0.3,
    "heel lift": 10.0, "toe lift": 10.0,
    "heel speed": 0.3, "toe speed": 0.3,
    "forward of pelvis": 0.3, "outward of pelvis": 0.1,
    "forward speed past pelvis": 0.5, "outward speed past pelvis": 0.3,
    "forward push": 10.0,
    "reach": 0.1, "reach speed": 0.5,
    "over lower foot": 0.05,
}  # fmt: skip
# Those of the above features that are taken from the other foot of the pair, too.
OTHER = (
    "heel over floor ahead", "toe over floor behind", "heel rise", "toe rise", "heel speed", "toe speed",
    "forward of pelvis", "forward speed past pelvis", "reach",
)  # fmt: skip
BODY: dict[str, float] = {"pelvis rise": 0.3, "pelvis lift": 5.0, "jitter": 2.0}


# Windows [s]. They are not settings, since the network is fitted to them.
SMOOTH = 0.03  # smoothing before a clip is sampled down to the grid
SPEED, LIFT = 0.05, 0.09  # first and second derivative
FLOOR = 0.5  # how far ahead and behind the floor under a foot is searched
OWN_FLOOR = 1.0  # the same for each sole point alone, which allows for a sole point estimated too high
BOTH = 0.8  # the same for the lower foot of a pair
FACING = 0.25  # the facing direction of the hips


@dataclass(frozen=True, eq=False)
class Sampled:
    """Tracks in leg lengths on the time grid, with facts taken from the whole clip.

    Args:
        tracks: sampled every `STEP`.
        mates: for each foot the other one of its pair; itself where there is none.
        axes: for each foot unit vectors (n, 2) in the ground plane, forward and outward.
        jitter: noise of the clip, in thousandths of a leg.
    """

    tracks: Tracks
    mates: tuple[int, ...]
    axes: tuple[tuple[Floats, Floats], ...]
    jitter: float


def evidence(sampled: Sampled, part: slice = slice(None)) -> tuple[Floats, ...]:
    """Compute each foot's features (n, len(COLUMNS)) in a part of the grid, as if the clip ended there."""
    feet = tuple(
        FootTracks(foot.side, foot.hip[part], foot.ankle[part], foot.heel[part], foot.toe[part])
        for foot in sampled.tracks.feet
    )
    pelvis = sampled.tracks.pelvis[part]
    body = _body(pelvis, sampled.jitter)
    lowest = [np.minimum(foot.heel[:, 1], foot.toe[:, 1]) for foot in feet]
    own = []
    for k, foot in enumerate(feet):
        pair = np.minimum(lowest[k], lowest[sampled.mates[k]])
        forward, outward = sampled.axes[k]
        own.append(_own(foot, pelvis, (forward[part], outward[part]), pair))
    asked = [list(OWN).index(name) for name in OTHER]
    return tuple(
        np.concatenate([own[k], own[mate][asked], body]).T for k, mate in enumerate(sampled.mates)
    )


COLUMNS = tuple(OWN) + tuple(f"other {name}" for name in OTHER) + tuple(BODY)


def mates(feet: tuple[FootTracks, ...]) -> tuple[int, ...]:
    """Find each foot's mate, whose hip is nearest: left and right of a biped, of the fore legs, of the hind legs."""
    hips = [foot.hip.mean(axis=0) for foot in feet]
    nearest = []
    for k, hip in enumerate(hips):
        others = [j for j in range(len(hips)) if j != k]
        nearest.append(min(others, key=lambda j: float(np.linalg.norm(hips[j] - hip)), default=k))
    return tuple(nearest)


def resample(tracks: Tracks) -> Sampled:
    """Sample a clip's tracks in leg lengths every `STEP` seconds from its first frame on."""

    def sample(x: Floats) -> Floats:
        if 2.5 * tracks.frame_time < SMOOTH:
            x = savgol(x, tracks.frame_time, seconds=SMOOTH, degree=2)
        return catmull_rom(x, STEP / tracks.frame_time) / tracks.leg_length

    points = [tracks.pelvis, *(x for foot in tracks.feet for x in (foot.hip, foot.ankle, foot.heel, foot.toe))]
    pelvis, *rest = at_once([partial(sample, x) for x in points], len(tracks))
    each = zip(tracks.feet, rest[0::4], rest[1::4], rest[2::4], rest[3::4], strict=True)
    feet = tuple(FootTracks(foot.side, hip, ankle, heel, toe) for foot, hip, ankle, heel, toe in each)
    sampled = Tracks(pelvis, feet, 1.0, STEP)
    pairs = mates(feet)
    axes = tuple(_axes(feet[k], feet[mate]) for k, mate in enumerate(pairs))
    return Sampled(sampled, pairs, axes, _jitter(tracks))


def catmull_rom(x: Floats, step: float) -> Floats:
    """Sample a track (F, ...) every `step` frames by Catmull-Rom splines, from its first frame on."""
    places = np.arange(0.0, len(x) - 1 + 1e-9, step)
    left = np.minimum(places.astype(np.intp), max(len(x) - 2, 0))
    q = (places - left).reshape(-1, *[1] * (x.ndim - 1))
    before, after = np.maximum(left - 1, 0), np.minimum(left + 2, len(x) - 1)
    a, b, c, d = x[before], x[left], x[np.minimum(left + 1, len(x) - 1)], x[after]
    return np.asarray(
        b + 0.5 * q * (c - a + q * (2 * a - 5 * b + 4 * c - d + q * (3 * (b - c) + d - a)))
    )


def _body(pelvis: Floats, jitter: float) -> Floats:
    """Compute the features (len(BODY), n) of the pelvis' vertical motion and of the clip's noise."""
    height = pelvis[:, 1]
    rise = savgol(height, STEP, seconds=0.11, degree=2, derivative=1)
    lift = savgol(height, STEP, seconds=0.15, degree=2, derivative=2)
    noise = np.full(len(height), jitter)
    return np.asarray(np.arcsinh(np.stack([rise, lift, noise]) / np.array(list(BODY.values()))[:, None]))


def _jitter(tracks: Tracks) -> float:
    """Estimate the noise of the ankles in thousandths of a leg length, from third differences where they are small."""
    thirds = [np.abs(np.diff(foot.ankle[:, 1], 3)) for foot in tracks.feet]
    if not thirds or len(thirds[0]) == 0:
        return 0.0
    # for white noise the third difference has sqrt(20) times its deviation
    noise = float(np.quantile(np.concatenate(thirds), 0.3) / (0.385 * 20.0**0.5))
    return 1e3 * noise / tracks.leg_length


def _axes(foot: FootTracks, mate: FootTracks) -> tuple[Floats, Floats]:
    """Find unit vectors (n, 2) in the ground plane: where the hips face, and outward on this foot's side."""
    outward = (foot.hip - mate.hip)[:, ::2]
    if foot is mate:
        outward = (foot.toe - foot.heel)[:, ::2] @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    outward = savgol(outward, STEP, seconds=FACING, degree=1)
    outward = outward / np.maximum(np.hypot(*outward.T)[:, None], 1e-9)
    forward = np.stack([-outward[:, 1], outward[:, 0]], axis=1)
    facing = (foot.toe - foot.heel)[:, ::2]
    return forward * np.where(np.sum(np.sum(forward * facing, axis=1)) < 0.0, -1.0, 1.0), outward


def _own(
    foot: FootTracks, pelvis: Floats, axes: tuple[Floats, Floats], pair: Floats
) -> Floats:
    """Compute the features (len(OWN), n) of one foot, compressed by asinh."""
    heel, toe = foot.heel, foot.toe
    lowest = np.minimum(heel[:, 1], toe[:, 1])
    ahead, behind = floors(lowest, FLOOR)
    both = np.minimum(*floors(pair, BOTH))
    heel_velocity, toe_velocity = (
        savgol(p, STEP, seconds=SPEED, degree=2, derivative=1) for p in (heel, toe)
    )
    heel_lift, toe_lift = (
        savgol(p[:, 1], STEP, seconds=LIFT, degree=2, derivative=2) for p in (heel, toe)
    )
    from_pelvis = (foot.ankle - pelvis)[:, ::2]
    forward, outward = (np.sum(from_pelvis * axis, axis=1) for axis in axes)
    past = savgol(np.stack([forward, outward], axis=1), STEP, seconds=SPEED, degree=2, derivative=1)
    push = savgol(forward, STEP, seconds=LIFT, degree=2, derivative=2)
    reach = np.linalg.norm(foot.ankle - foot.hip, axis=1)
    reach_speed = savgol(reach, STEP, seconds=SPEED, degree=2, derivative=1)
    curves = [
        heel[:, 1] - ahead, heel[:, 1] - behind, toe[:, 1] - ahead, toe[:, 1] - behind,
        heel[:, 1] - np.maximum(*floors(heel[:, 1], OWN_FLOOR)),
        toe[:, 1] - np.maximum(*floors(toe[:, 1], OWN_FLOOR)),
        heel_velocity[:, 1], toe_velocity[:, 1], heel_lift, toe_lift,
        np.hypot(heel_velocity[:, 0], heel_velocity[:, 2]), np.hypot(toe_velocity[:, 0], toe_velocity[:, 2]),
        forward, outward, past[:, 0], past[:, 1], push, 1.0 - reach, reach_speed, lowest - both,
    ]  # fmt: skip
    return np.asarray(np.arcsinh(np.stack(curves) / np.array(list(OWN.values()))[:, None]))


def floors(height: Floats, seconds: float) -> tuple[Floats, Floats]:
    """Find the lowest value (n,) within some seconds ahead, and behind, each including the present step."""
    n = max(round(seconds / STEP), 1) + 1
    ahead, width = np.concatenate([height, np.full(n, np.inf)]), 1
    while width < n:  # the lowest of 2 w is the lower of two lowest of w
        hop = min(width, n - width)
        ahead[:-hop] = np.minimum(ahead[:-hop], ahead[hop:])
        width += hop
    ahead = ahead[: len(height)]
    last_of = np.concatenate([np.full(n, np.inf), height])
    width = 1
    while width < n:
        hop = min(width, n - width)
        last_of[hop:] = np.minimum(last_of[hop:], last_of[:-hop])
        width += hop
    return ahead, last_of[n:]

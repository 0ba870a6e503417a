"""Key-times of walks: which times of two walks correspond."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footfix.locomotion.follow.prepared_walk import Walk
from footfix.motion.clip import Floats, Ints
from footfix.motion.spline import Cubic, monotone

_EXACT = 1e-8  # [strides] Newton's method ends after a step shorter than this


@dataclass(frozen=True, eq=False)
class Keys:
    """The key-times of a walk (K 6.1): its frame at each moment of a generic stride, and back.

    K interpolates linearly, F(t) = F_i + (F_i+1 - F_i) (t - K_i) / (K_i+1 - K_i); here a monotone cubic is used, so
    that feet do not change speed abruptly at a key.

    Args:
        times: (n,) generic times [strides] of the keys of a round, from 0.
        frames: (n,) their frames.
        strides: of a round.
        length: [frames] of a round.
        stances: for each leg when it comes down and for how long it stands [strides]; None where that is unclear.
    """

    times: Floats
    frames: Floats
    strides: int
    length: int
    stances: tuple[tuple[float, float] | None, ...] = ()

    def frame(self, time: Floats) -> Floats:
        """Compute the frames (F,) at generic times (F,)."""
        rounds = np.floor(time / self.strides)
        return np.asarray(self._curve(time - rounds * self.strides)[..., 0] + rounds * self.length)

    def time(self, frame: Floats) -> Floats:
        """Compute the generic times (F,) at frames (F,)."""
        first = self.frames[0]
        rounds = np.floor((frame - first) / self.length)
        within = frame - rounds * self.length
        curve = self._curve
        time = np.interp(within, *self._fine)
        for _ in range(4):  # Newton
            step = (curve(time)[..., 0] - within) / np.maximum(curve(time, 1)[..., 0], 1e-6)
            time = np.clip(time - step, 0.0, self.strides)
            if np.abs(step).max(initial=0.0) < _EXACT:
                break
        return np.asarray(time + rounds * self.strides)

    @cached_property
    def _fine(self) -> tuple[Floats, Floats]:
        """List frames close together, and their generic times."""
        fine = np.linspace(0.0, self.strides, 64 * len(self.times) + 1)
        return self._curve(fine)[:, 0], fine

    @cached_property
    def _curve(self) -> Cubic:
        """Fit the curve of frames over generic times, with a round more on either side."""
        more = [(k * self.strides, k * self.length) for k in (-1, 0, 1, 2)]
        times = np.concatenate([self.times + t for t, _ in more])
        return monotone(times, np.concatenate([self.frames + f for _, f in more])[:, None])


def stance_of(walk: Walk, keys: Keys, leg: int) -> tuple[float, float] | None:
    """Find when a leg comes down and for how long it stands, mean generic times [strides]; None where unclear."""
    down, up = walk.strikes(leg)
    if not len(down) or len(down) != walk.strides:
        return None
    strike, lift = keys.time(down.astype(np.float64)), keys.time(up.astype(np.float64))
    first = float(strike[0])
    return first + float(np.mean((strike - first + 0.5) % 1.0 - 0.5)), float(np.mean(lift - strike))


def in_step(time: Floats, strike: float, stands: Floats, own: float) -> Floats:
    """Convert generic times (F,) [strides] of a leg with stance duration `stands` to those of one with `own`.

    Middle of stance to middle of stance, strike to strike, lift to lift, by tan(pi u') = k tan(pi u): the smoothest map
    of a circle that does.

    Args:
        time: (F,) generic times [strides].
        strike: at which both come down.
        stands: (F,) how long the one stands [strides],
        own: and the other.
    """
    u = time - strike - 0.5 * stands
    whole = np.round(u)
    steep = np.tan(0.5 * np.pi * own) / np.tan(0.5 * np.pi * stands)
    angle = np.pi * (u - whole)
    return np.asarray(strike + 0.5 * own + whole + np.arctan2(steep * np.sin(angle), np.cos(angle)) / np.pi)


def align(walks: Sequence[Walk]) -> tuple[Keys, ...]:
    """Find key-times of walks (K 6.1): strikes of every leg.

    K uses lifts, too. With stances of different duration the whole figure would then speed up and slow down between
    keys; instead `in_step` aligns the lifts of each leg separately.

    Walks with different numbers of strides are aligned stride by stride, as by K's shorter clip in between.
    """
    strikes = [_strikes(walk) for walk in walks]
    legs = [leg for leg in strikes[0] if all(leg in each for each in strikes)]
    tried = (_aligned(walks, strikes, wanted) for wanted in (legs, legs[:1]))
    keys = next((found for found in tried if found is not None), None)
    if keys is None:
        keys = tuple(Keys(np.zeros(1), np.zeros(1), walk.strides, walk.frames) for walk in walks)
    every = range(len(walks[0].rig.legs))
    return tuple(
        replace(each, stances=tuple(stance_of(walk, each, leg) for leg in every))
        for walk, each in zip(walks, keys, strict=True)
    )


def _strikes(walk: Walk) -> dict[int, Ints]:
    """Find the frames (strides,) at which legs that strike once in each stride do so, from the first leg's on."""
    found: dict[int, Ints] = {}
    start = 0
    for leg in range(len(walk.rig.legs)):
        down, _ = walk.strikes(leg)
        if len(down) != walk.strides:
            if leg == 0:
                return {}
            continue
        if leg == 0:
            start = int(down[0])
        found[leg] = np.sort((down - start) % walk.frames) + start
    return found


def _aligned(walks: Sequence[Walk], strikes: Sequence[dict[int, Ints]], legs: Sequence[int]) -> tuple[Keys, ...] | None:
    """Make key-times from strikes of some legs; None where walks have them in different orders."""
    if not legs:
        return None
    phases = []
    for walk, own in zip(walks, strikes, strict=True):
        first = own[legs[0]].astype(np.float64)
        on = np.append(first, first[0] + walk.frames)
        inside = np.stack([(own[leg] - first) / np.diff(on) for leg in legs])  # (legs, strides)
        inside[1:] -= np.floor(inside[1:])
        phases.append(inside)
    orders = {tuple(np.argsort(column).tolist()) for each in phases for column in each.T}
    if len(orders) > 1:
        return None
    times = np.mean([each.mean(axis=1) for each in phases], axis=0)
    order = np.argsort(times)
    if np.any(np.diff(np.append(times[order], 1.0)) < 0.02):
        return None
    keys = []
    for walk, own, inside in zip(walks, strikes, phases, strict=True):
        first = own[legs[0]].astype(np.float64)
        on = np.append(first, first[0] + walk.frames)
        frames = (first + inside * np.diff(on))[order]
        if np.any(np.diff(np.append(frames.T.ravel(), frames[0, 0] + walk.frames)) <= 0.0):
            return None
        at = times[order][:, None] + np.arange(walk.strides)
        keys.append(Keys(at.T.ravel(), frames.T.ravel(), walk.strides, walk.frames))
    return tuple(keys)

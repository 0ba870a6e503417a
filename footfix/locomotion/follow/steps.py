"""Where feet step along a path: each stance in one rigid frame of it, and from one to the next between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from footfix.locomotion.follow.blend import ease
from footfix.locomotion.follow.path import Path
from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs

_BRIEF = 0.06  # [s] a stance, or a swing, that is shorter is none
_TURNS = 0.05  # [rad/m] from this curvature on feet do not turn while they stand
_STRAYS = 0.012  # [m] a toe that strays farther while it stands is left to inverse kinematics over the whole clip
_EDGE = 0.015  # [s] at both ends of a contact in which the toe may still land or leave
_EASE = 0.16  # [s] in which a foot gets back to how it was captured


@dataclass(frozen=True, eq=False)
class Steps:
    """A leg's stances over F frames.

    Args:
        stances: frames `[start, end)`.
        moment: (F,) the frame whose place on the path carries the foot: the middle of a stance throughout it.
        swing: (F,) 0 to 1 from one stance to the next; 0 while it stands.
    """

    stances: tuple[tuple[int, int], ...]
    moment: Floats
    swing: Floats


def find_steps(down: Bools, frame_time: float) -> Steps:
    """Tell which moment carries a foot in each frame.

    Args:
        down: (F,) whether it stands.
        frame_time: [s].
    """
    F, brief = len(down), max(2, round(_BRIEF / frame_time))
    down = down.copy()
    for start, end in runs(~down):
        if end - start < brief and start > 0 and end < F:
            down[start:end] = True
    stances = [each for each in runs(down) if each[1] - each[0] >= brief]
    time = np.arange(F, dtype=np.float64)
    moment, swing = time.copy(), np.zeros(F)
    if not stances:
        return Steps((), moment, swing)
    middle = [0.5 * (a + b - 1) for a, b in stances]
    for (a, b), m in zip(stances, middle, strict=True):
        moment[a:b] = m
    for ((_, b), (a, _)), (m, n) in zip(pairwise(stances), pairwise(middle), strict=True):
        u = (time[b:a] - (b - 1)) / (a - b + 1)
        moment[b:a] = m + (n - m) * ease(u)
        swing[b:a] = u
    first, last = stances[0][0], stances[-1][1]
    moment[:first] = middle[0] + time[:first] - first
    moment[last:] = middle[-1] + time[last:] - (last - 1)
    return Steps(tuple(stances), moment, swing)


@dataclass(frozen=True, eq=False)
class Ground:
    """A path as feet and body stand on it, frame by frame.

    Args:
        place: (F, 2) [m] x and z.
        heading: (F,) [rad].
        aside: (F,) [m] by which what stands there is moved to the left.
    """

    place: Floats
    heading: Floats
    aside: Floats

    @property
    def turn(self) -> Floats:
        """(F, 4) the heading as a rotation."""
        return rotation.about_vertical(self.heading)

    def lay(self, points: Floats) -> Floats:
        """(F, 3) [m] in the world of points (F, 3) [m] that walk along z."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        left, ahead = points[:, 0] + self.aside, points[:, 2]
        x = self.place[:, 0] + left * c + ahead * s
        z = self.place[:, 1] - left * s + ahead * c
        return np.stack([x, points[:, 1], z], axis=1)


def ground_at(path: Path, s: Floats, aside: Floats) -> Ground:
    """A path at arc lengths (F,) [m]."""
    return Ground(path.place(s), path.heading(s), aside)


def lower_swing(height: Floats, steps: Steps, scale: Floats) -> Floats:
    """(F,) [m] heights of a foot that is lifted less where strides are shorter (K 7.2).

    Args:
        height: (F,) [m] as captured.
        steps: its stances.
        scale: (F,) of strides.
    """
    out = height.copy()
    if np.all(scale == 1.0):
        return out
    for (_, b), (a, _) in pairwise(steps.stances):
        u = steps.swing[b:a]
        line = height[b - 1] + (height[a] - height[b - 1]) * u
        out[b:a] += (scale[b:a] - 1.0) * np.sin(np.pi * u) ** 2 * np.maximum(height[b:a] - line, 0.0)
    return out


def firmness(curvature: Floats) -> Floats:
    """(F,) 0 on straight paths, where feet stand as captured, to 1 on curves, where they neither slide nor turn."""
    return ease(np.abs(curvature) / _TURNS)


def unturned(
    turn: Floats, heel: Floats, toes: Bools, steps: Steps, share: Floats, frame_time: float
) -> tuple[Floats, Floats]:  # fmt: skip
    """By how much a foot is turned about the vertical so that it does not turn while it stands.

    K 7.1 gives a plant its mean swivel angle; this leads back to the captured one after it, and where the path is
    straight the foot turns as it was captured. It turns about its toe; before that is down, about its heel.

    Args:
        turn: (F, 4) of the foot, walking along z.
        heel: (F, 3) [m] from its toe to its heel.
        toes: (F,) whether the toe stands.
        steps: its stances.
        share: (F,) how much of that is wanted: none on a straight path.
        frame_time: [s].

    Returns:
        (F,) [rad], and (F, 3) [m] by which the toe is moved.
    """
    F = len(turn)
    yaw, shift = np.zeros(F), np.zeros((F, 3))
    fade = max(3, round(_EASE / frame_time))
    for k, (a, b) in enumerate(steps.stances):
        part = float(share[(a + b) // 2])
        if part == 0.0:
            continue
        own = rotation.yaw(rotation.multiply(turn[a:b], rotation.inverse(turn[[(a + b) // 2]])))
        fix = part * (np.median(own) - own)
        before = steps.stances[k - 1][1] if k else 0
        after = steps.stances[k + 1][0] if k + 1 < len(steps.stances) else F
        fore, aft = min(fade, a - before), min(fade, after - b)
        yaw[a:b] += fix
        yaw[b : b + aft] += _decay(fix[::-1], aft)
        yaw[a - fore : a] += _decay(fix, fore)[::-1]
        down = np.flatnonzero(toes[a:b])
        if not len(down) or down[0] == 0:
            continue
        rolls = slice(a, a + int(down[0]) + 1)
        moved = rotation.rotate(rotation.about_vertical(yaw[rolls]), heel[rolls]) - heel[rolls]
        fix = moved[-1] - moved  # the heel is as far from its place as when the toe comes down
        shift[rolls] += fix
        shift[a - fore : a] += np.stack([_decay(each, fore)[::-1] for each in fix.T], axis=1)
    return yaw, shift


def unslid(toe: Floats, toes: Bools, share: Floats, frame_time: float) -> Floats:
    """(F, 3) [m] by which a toe is moved over the floor so that it stands in one place while it is planted.

    Args:
        toe: (F, 3) [m] in the frame that carries it.
        toes: (F,) whether it stands.
        share: (F,) how much of that is wanted.
        frame_time: [s].
    """
    shift = np.zeros_like(toe)
    edge, fade = max(1, round(_EDGE / frame_time)), max(3, round(_EASE / frame_time))
    for start, end in runs(toes):
        a, b = start + edge, end - edge
        part = float(share[(start + end) // 2])
        if b - a < 3 or part == 0.0:
            continue
        off = part * (np.median(toe[a:b], axis=0) - toe[a:b]) * [1.0, 0.0, 1.0]
        if np.hypot(off[:, 0], off[:, 2]).max() > _STRAYS:
            continue
        fore, aft = min(fade, a), min(fade, len(toe) - b)
        shift[a:b] += off
        shift[b : b + aft] += np.stack([_decay(each[::-1], aft) for each in off.T], axis=1)
        shift[a - fore : a] += np.stack([_decay(each, fore)[::-1] for each in off.T], axis=1)
    return shift


def _decay(fix: Floats, frames: int) -> Floats:
    """(frames,) how a value that begins as `fix` goes on outwards, with its slope, and comes to rest at zero."""
    if frames <= 0:
        return np.zeros(0)
    slope = 0.0 if len(fix) < 3 else float(fix[0] - fix[2]) / 2.0
    slope = float(np.clip(slope, -abs(fix[0]) / 2.0, abs(fix[0]) / 2.0))
    u = np.arange(1, frames + 1) / (frames + 1)
    return np.asarray((1.0 - u) ** 2 * ((1.0 + 2.0 * u) * fix[0] + u * (frames + 1) * slope * (1.0 - u) ** 2))


def reach_lack(hips: Sequence[Floats], ankles: Sequence[Floats], captured: Sequence[Floats]) -> Floats:
    """(F,) [m] by how much a figure is to be lowered so that no leg is stretched beyond what it was captured.

    Args:
        hips, ankles: for each leg (F, 3) [m], the ankle where it is to be.
        captured: for each leg (F,) [m] from hip to ankle.
    """
    lack = np.zeros(len(hips[0]))
    for hip, ankle, far in zip(hips, ankles, captured, strict=True):
        most = np.maximum(far, far.max())
        line = hip - ankle
        level = np.hypot(line[:, 0], line[:, 2])
        up = np.sqrt(np.maximum(most**2 - level**2, (0.5 * most) ** 2))
        lack = np.maximum(lack, line[:, 1] - up)
    return np.where(lack > 1e-6, lack, 0.0)


def envelope(lack: Floats, width: int) -> Floats:
    """(F,) [m] a smooth curve that is nowhere below `lack` (F,) [m]: the largest within a window, in the mean."""
    if not np.any(lack):
        return lack
    half = max(2, width // 2)
    window = np.hanning(2 * half + 3)[1:-1]
    highest = sliding_window_view(np.pad(lack, half, mode="edge"), 2 * half + 1).max(axis=1)
    return np.convolve(np.pad(highest, half, mode="edge"), window / window.sum(), mode="valid")

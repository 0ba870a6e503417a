"""Footsteps along a path: each stance in one rigid frame of the path, with interpolation in between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from footfix.locomotion.follow.blend_weight import ease
from footfix.locomotion.follow.path import Path
from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs

_BRIEF = 0.06  # [s] shorter swings are ignored
_TOUCH = 0.04  # [s] shorter stances are ignored; in a gallop they last about this long


@dataclass(frozen=True, eq=False)
class Steps:
    """A leg's stances over F frames.

    Args:
        stances: frames `[start, end)`.
        moment: (F,) the frame whose place on the path positions the foot: the middle of the stance throughout it.
        swing: (F,) 0 to 1 from one stance to the next; 0 while it stands.
    """

    stances: tuple[tuple[int, int], ...]
    moment: Floats
    swing: Floats


def find_steps(down: Bools, frame_time: float) -> Steps:
    """Find which time positions a foot on the path in each frame.

    Args:
        down: (F,) whether it stands.
        frame_time: [s].
    """
    F, brief, touch = len(down), *(max(2, round(each / frame_time)) for each in (_BRIEF, _TOUCH))
    down = down.copy()
    for start, end in runs(~down):
        if end - start < brief and start > 0 and end < F:
            down[start:end] = True
    stances = [each for each in runs(down) if each[1] - each[0] >= touch]
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
    """Places on a path for feet or body, frame by frame.

    Args:
        position: (F, 2) [m] x and z.
        heading: (F,) [rad].
        aside: (F,) [m] shift to the left.
    """

    position: Floats
    heading: Floats
    aside: Floats

    @property
    def turn(self) -> Floats:
        """Convert the heading to rotations (F, 4)."""
        return rotation.about_vertical(self.heading)

    def lay(self, points: Floats) -> Floats:
        """Lay points (F, 3) [m] that walk along z in the world, (F, 3) [m], by displacement mapping (K 6.3).

        r_o = r_m + R(theta_m) R(theta^)^-1 (r_i - r^_i): what a point is off its reference line is turned along with
        the path; the printed equation leaves it unturned. The reference line is z here.
        """
        c, s = np.cos(self.heading), np.sin(self.heading)
        left, ahead = points[:, 0] + self.aside, points[:, 2]
        x = self.position[:, 0] + left * c + ahead * s
        z = self.position[:, 1] - left * s + ahead * c
        return np.stack([x, points[:, 1], z], axis=1)


def ground_at(path: Path, s: Floats, aside: Floats) -> Ground:
    """Get places on a path at arc lengths (F,) [m]."""
    return Ground(path.position(s), path.heading(s), aside)


def lower_swing(height: Floats, steps: Steps, scale: Floats) -> Floats:
    """Compute the heights (F,) [m] of a foot that is lifted less where strides are shorter (K 7.2).

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


def reach_lack(hips: Sequence[Floats], ankles: Sequence[Floats], farthest: Sequence[Floats]) -> Floats:
    """Compute by how much to lower a figure so that no leg is stretched too far, (F,) [m].

    Args:
        hips, ankles: for each leg (F, 3) [m], the ankle where it is to be.
        farthest: for each leg (F,) [m] from hip to ankle, at most.
    """
    lack = np.zeros(len(hips[0]))
    for hip, ankle, most in zip(hips, ankles, farthest, strict=True):
        line = hip - ankle
        level = np.hypot(line[:, 0], line[:, 2])
        up = np.sqrt(np.maximum(most**2 - level**2, (0.5 * most) ** 2))
        lack = np.maximum(lack, line[:, 1] - up)
    return np.where(lack > 1e-6, lack, 0.0)


def envelope(lack: Floats, width: int) -> Floats:
    """Compute a smooth curve (F,) [m] nowhere below `lack` (F,) [m]: the moving maximum, averaged over a window."""
    if not np.any(lack):
        return lack
    half = max(2, width // 2)
    window = np.hanning(2 * half + 3)[1:-1]
    highest = sliding_window_view(np.pad(lack, half, mode="edge"), 2 * half + 1).max(axis=1)
    return np.convolve(np.pad(highest, half, mode="edge"), window / window.sum(), mode="valid")

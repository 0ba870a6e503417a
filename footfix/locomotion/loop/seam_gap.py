"""The gap between the two ends of a cut: differences of place, rotation and velocity of each joint."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from footfix.locomotion.loop.root_motion import Travel, root_in_world
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints

_BESIDE = 1.0 / 30.0  # [s] before and after a frame, from which its velocity is computed
RATIO = 0.5  # share of the gap closed at the start; the rest is closed at the end


@dataclass(frozen=True, eq=False)
class Gap:
    """The gaps of some tracks from the start of a cut to its end.

    Args:
        joints: whose tracks they are.
        value: (J, 3) [m], or [rad] as rotation vectors on the left.
        speed: (J, 3) [1/s] of the same.
    """

    joints: tuple[int, ...]
    value: Floats
    speed: Floats

    def some(self) -> Gap:
        """Keep the gaps that are not zero."""
        which = np.flatnonzero(np.any((self.value != 0.0) | (self.speed != 0.0), axis=1))
        return Gap(tuple(self.joints[k] for k in which.tolist()), self.value[which], self.speed[which])


def gaps_below(clip: Clip, root: int, start: int, end: int) -> tuple[Gap, Gap]:
    """Compute the gaps of places [m] and rotations [rad] of all joints except the root and those above it.

    Args:
        clip: F frames.
        root: what carries the figure.
        start, end: the frames that are to be one pose.
    """
    joints = tuple(j for j in range(len(clip.skeleton)) if j not in clip.skeleton.ancestors(root))
    (at_a, weight_a), (at_b, weight_b) = (_beside(frame, len(clip), clip.frame_time) for frame in (start, end))
    found = []
    for track, gap in ((clip.position, _place_gap), (clip.rotation, _turn_gap)):
        a, b = (np.array([track(j)[at] for j in joints]).reshape(len(joints), len(at), -1) for at in (at_a, at_b))
        found.append(Gap(joints, *gap((a, start - at_a[0], weight_a), (b, end - at_b[0], weight_b))).some())
    return found[0], found[1]


def gaps_of_root(clip: Clip, root: int, start: int, end: int, travel: Travel) -> tuple[Gap, Gap]:
    """Compute the gaps of the root's place [m] and rotation [rad] in the world, the end moved back by the travel.

    Args:
        clip: F frames.
        root: what carries the figure.
        start, end: the frames that are to be one pose.
        travel: from the one to the other.
    """
    (at_a, weight_a), (at_b, weight_b) = (_beside(frame, len(clip), clip.frame_time) for frame in (start, end))
    place, turn = root_in_world(clip.frames(np.concatenate([at_a, at_b])), root)
    n, back = len(at_a), rotation.inverse(travel.turn)
    ends = (
        (_place_gap, place[None, :n], travel.places_back(place[None, n:])),
        (_turn_gap, turn[None, :n], rotation.multiply(back, turn[None, n:])),
    )
    place_gap, turn_gap = (
        Gap((root,), *gap((a, start - at_a[0], weight_a), (b, end - at_b[0], weight_b))) for gap, a, b in ends
    )
    return place_gap, turn_gap


_End = tuple[Floats, int, Floats]  # (J, n, 3 or 4) of the frames about an end, which of these it is, (n,) weights [1/s]


def _place_gap(first: _End, last: _End) -> tuple[Floats, Floats]:
    """Compute the gaps (J, 3) [m] and (J, 3) [m/s] from the start of tracks to their end."""
    (a, i, weight_a), (b, j, weight_b) = first, last
    va, vb = weight_a @ (a - a[:, i, None]), weight_b @ (b - b[:, j, None])
    return b[:, j] - a[:, i], vb - va


def _turn_gap(first: _End, last: _End) -> tuple[Floats, Floats]:
    """Compute the gaps (J, 3) [rad] and (J, 3) [rad/s], as left rotation vectors, from the start of tracks to their
    end.

    The velocities are those that both ends have when they are turned to where they meet.
    """
    (a, i, weight_a), (b, j, weight_b) = first, last
    va, vb = (weight @ _turned(turn, k) for turn, k, weight in ((a, i, weight_a), (b, j, weight_b)))
    gap = rotation.to_rotation_vector(rotation.multiply(b[:, j], rotation.inverse(a[:, i])))
    va = rotation.rotate(rotation.from_rotation_vector(RATIO * gap), va)
    vb = rotation.rotate(rotation.from_rotation_vector((RATIO - 1.0) * gap), vb)
    return gap, vb - va


def _turned(turn: Floats, frame: int) -> Floats:
    """Compute the rotation vectors (J, n, 3) [rad] from one of n frames to each."""
    return rotation.to_rotation_vector(rotation.multiply(turn, rotation.inverse(turn[:, frame, None])))


def _beside(frame: int, frames: int, dt: float) -> tuple[Ints, Floats]:
    """Choose the frames from which a frame's velocity is computed, and their weights [1/s]: a polynomial's slope.

    It is a cubic, so that a changing acceleration does not count as velocity, and a parabola where the clip ends.
    """
    n = max(2, round(_BESIDE / dt))
    before, after = min(n, frame), min(n, frames - 1 - frame)
    return np.arange(frame - before, frame + after + 1), _slope(before, after, dt)


@cache
def _slope(before: int, after: int, dt: float) -> Floats:
    at = np.arange(-before, after + 1)
    degree = 3 if min(before, after) >= 2 else min(2, len(at) - 1)
    return np.asarray(np.linalg.pinv(np.vander(at * dt, degree + 1, increasing=True))[1])

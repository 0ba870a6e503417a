"""Poses compared as clouds of points: the joints of some frames before and after, so that velocity counts.

Source: L. Kovar, M. Gleicher, F. Pighin, Motion graphs, SIGGRAPH 2002: of all turns about the vertical and shifts
over the floor those are taken that bring two clouds nearest to one another, in closed form. All of it is products of
matrices here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.locomotion.strides import weights
from footfix.locomotion.travel import Travel
from footfix.motion.clip import Clip, Floats, Ints
from footfix.motion.kinematics import places

_SAMPLES = 5  # frames that make a cloud


@dataclass(frozen=True, eq=False)
class Clouds:
    """The clouds of N frames, each about its own middle.

    Args:
        x, y, z: (N, P) [m], times the root of each point's weight.
        middle: (N, 2) [m] over the floor.
    """

    x: Floats
    y: Floats
    z: Floats
    middle: Floats

    def __len__(self) -> int:
        return len(self.x)


def clouds(clip: Clip, frames: Ints, window: float) -> Clouds:
    """The clouds of some frames.

    Args:
        clip: F frames.
        frames: (N,) which.
        window: [s] before and after; shorter where the clip ends.
    """
    reach = round(window / clip.frame_time)
    around = np.rint(np.linspace(-reach, reach, _SAMPLES)).astype(np.intp) if reach else np.zeros(1, np.intp)
    which = np.clip(frames[:, None] + around, 0, len(clip) - 1)  # (N, samples)
    needed, back = np.unique(which, return_inverse=True)
    points = places(clip.frames(needed))[back.reshape(which.shape)]  # (N, samples, J, 3)
    share = np.tile(weights(clip) / len(around), len(around))
    points = points.reshape(len(frames), -1, 3)
    middle = np.einsum("npi,p->ni", points[..., [0, 2]], share)
    root = np.sqrt(share)
    x, z = ((points[..., axis] - middle[:, k, None]) * root for k, axis in enumerate((0, 2)))
    return Clouds(x, points[..., 1] * root, z, middle)


def distances(first: Clouds, second: Clouds) -> Floats:
    """(N, M) [m] root mean square distance of each cloud to each, turned and shifted over the floor to fit."""
    along = first.x @ second.x.T + first.z @ second.z.T
    across = first.z @ second.x.T - first.x @ second.z.T
    size = [np.einsum("np,np->n", c.x, c.x) + np.einsum("np,np->n", c.z, c.z) for c in (first, second)]
    tall = [np.einsum("np,np->n", c.y, c.y) for c in (first, second)]
    flat = size[0][:, None] + size[1] - 2.0 * np.hypot(along, across)
    height = tall[0][:, None] + tall[1] - 2.0 * first.y @ second.y.T
    return np.asarray(np.sqrt(np.maximum(flat + height, 0.0)))


def fit(clip: Clip, start: int, end: int, window: float) -> Travel:
    """How a figure gets from the pose of one frame to that of another, over the floor.

    Args:
        clip: F frames.
        start, end: the frames.
        window: [s] before and after them.
    """
    both = clouds(clip, np.array([start, end]), window)
    along = both.x[0] @ both.x[1] + both.z[0] @ both.z[1]
    across = both.z[0] @ both.x[1] - both.x[0] @ both.z[1]
    turn = Travel(float(np.arctan2(across, along)))
    first, last = (np.array([x, 0.0, z]) for x, z in both.middle)
    x, _, z = last - turn.places(first)
    return Travel(turn.yaw, float(x), float(z))

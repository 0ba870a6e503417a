"""Compare poses as point clouds: the joints in some frames before and after, so that velocity counts.

Source: L. Kovar, M. Gleicher, F. Pighin, Motion graphs, SIGGRAPH 2002: two clouds are aligned by the turn about the
vertical and the horizontal shift that bring them nearest to one another, in closed form, here as matrix products.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.locomotion.loop.root_motion import Travel
from footfix.locomotion.loop.strides import weights
from footfix.motion.clip import Clip, Floats, Ints
from footfix.motion.kinematics import places
from footfix.rig.rig import Rig

_SAMPLES = 5  # frames of a cloud
_USUAL = 0.97  # quantile of a joint's accelerations that counts as its usual largest
_NEAR = 0.042  # [s] around a frame in which accelerations count


@dataclass(frozen=True, eq=False)
class Clouds:
    """The point clouds of N frames, each relative to its centre.

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

    def some(self, which: Ints) -> Clouds:
        """Take the clouds of some of its frames, by index."""
        return Clouds(self.x[which], self.y[which], self.z[which], self.middle[which])


def clouds(clip: Clip, rig: Rig, frames: Ints, window: float) -> Clouds:
    """Make the point clouds of some frames.

    Args:
        clip: F frames.
        rig: whose joints are the points.
        frames: (N,) which.
        window: [s] before and after; shorter where the clip ends.
    """
    reach = round(window / clip.frame_time)
    around = np.rint(np.linspace(-reach, reach, _SAMPLES)).astype(np.intp) if reach else np.zeros(1, np.intp)
    which = np.clip(frames[:, None] + around, 0, len(clip) - 1)  # (N, samples)
    needed, back = np.unique(which, return_inverse=True)
    points = places(clip.frames(needed))[back.reshape(which.shape)]  # (N, samples, J, 3)
    share = np.tile(weights(clip, rig) / len(around), len(around))
    points = points.reshape(len(frames), -1, 3)
    middle = np.einsum("npi,p->ni", points[..., [0, 2]], share)
    root = np.sqrt(share)
    x, z = ((points[..., axis] - middle[:, k, None]) * root for k, axis in enumerate((0, 2)))
    return Clouds(x, points[..., 1] * root, z, middle)


def distances(first: Clouds, second: Clouds) -> Floats:
    """Compute the root mean square distance of each cloud to each, (N, M) [m], after alignment."""
    along = first.x @ second.x.T + first.z @ second.z.T
    across = first.z @ second.x.T - first.x @ second.z.T
    size = [np.einsum("np,np->n", c.x, c.x) + np.einsum("np,np->n", c.z, c.z) for c in (first, second)]
    tall = [np.einsum("np,np->n", c.y, c.y) for c in (first, second)]
    flat = size[0][:, None] + size[1] - 2.0 * np.hypot(along, across)
    height = tall[0][:, None] + tall[1] - 2.0 * first.y @ second.y.T
    return np.asarray(np.sqrt(np.maximum(flat + height, 0.0)))


def unrest(clip: Clip, rig: Rig) -> Floats:
    """Measure how violent the motion is around each frame, (F,): largest acceleration relative to the usual largest.

    A heel strike, or a spike of noise, would show in every round if a cycle began there.

    Args:
        clip: F frames.
        rig: whose joints count, each as much as its bones are long.
    """
    sharp = np.zeros((len(clip), len(clip.skeleton)))
    if len(clip) < 3:
        return sharp[:, 0]
    sharp[1:-1] = np.linalg.norm(np.diff(places(clip), n=2, axis=0), axis=2)
    usual = np.quantile(sharp, _USUAL, axis=0)
    reach = max(1, round(_NEAR / clip.frame_time))
    padded = np.pad(sharp, ((reach, reach), (0, 0)))
    largest = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1, axis=0).max(axis=-1)
    share = weights(clip, rig) * (usual > 0.0)
    return np.asarray(largest / np.where(usual > 0.0, usual, 1.0) @ share)


def turns(first: Clouds, second: Clouds) -> Floats:
    """Compute the turn about the vertical that brings each cloud nearest to each, (N, M) [rad]."""
    along = first.x @ second.x.T + first.z @ second.z.T
    across = first.z @ second.x.T - first.x @ second.z.T
    return np.asarray(np.arctan2(across, along))


def fit(clip: Clip, rig: Rig, start: int, end: int, window: float) -> Travel:
    """Compute the travel from the pose of one frame to that of another.

    Args:
        clip: F frames.
        rig: whose joints are the points.
        start, end: the frames.
        window: [s] before and after them; shorter where the clip ends.
    """
    left = min(start, end, len(clip) - 1 - start, len(clip) - 1 - end)  # both must have them
    window = min(window, left * clip.frame_time)
    both = clouds(clip, rig, np.array([start, end]), window)
    turn = Travel(float(turns(both, both)[0, 1]))
    first, last = (np.array([x, 0.0, z]) for x, z in both.middle)
    x, _, z = last - turn.places(first)
    return Travel(turn.yaw, float(x), float(z))

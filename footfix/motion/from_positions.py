"""Make a clip from joint positions in the world, such as those of text-to-motion and pose-estimation networks.

Positions give the direction of bones, but not their twist. Each bone is turned by the smallest rotation from where its
parent's rotation would put it, so that nothing spins; several bones from one joint, such as the pelvis, get the one
rotation that fits them best.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.errors import ArgumentError
from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Skeleton
from footfix.motion.vectors import norm, unit

_SPREAD = 0.1  # second singular value over the first: bones that spread less are one line, whose twist is unknown


def fit_rotations(
    positions: Floats, parents: Sequence[int], frame_time: float, *, names: Sequence[str] | None = None,
    rest: Floats | None = None,
) -> Clip:  # fmt: skip
    """Fit the rotations of a skeleton to joint positions in the world.

    Forward kinematics of the clip gives the positions back, to rounding, in each frame and with each frame's own bone
    lengths.

    Args:
        positions: (F, J, 3) [m] of the joints in the world, y up.
        parents: (J,) each joint's parent, before the joint; -1 for the root.
        frame_time: [s].
        names: of the joints; `joint0` and so on by default.
        rest: (J, 3) [m] of the joints in a rest pose; by default the frame in which the figure stands tallest.

    Returns:
        The clip; the rotations of its rest pose are identities.

    Raises:
        ArgumentError: the parents are no tree of the joints.
    """
    frames, count = positions.shape[:2]
    above = np.asarray(parents, dtype=np.intp)
    if above.shape != (count,):
        raise ArgumentError(f"{count} joints need {count} parents, not {above.size}")
    pose = positions[_tallest(positions)] if rest is None else np.asarray(rest, dtype=np.float64)
    if pose.shape != (count, 3):
        raise ArgumentError(f"rest must be ({count}, 3), one a joint, not {pose.shape}")
    bones, offsets = positions.copy(), pose.copy()
    below = np.flatnonzero(above >= 0)
    bones[:, below] -= positions[:, above[below]]
    offsets[below] -= pose[above[below]]
    offsets[below] *= (np.median(norm(bones[:, below]), axis=0) / np.maximum(norm(offsets[below]), 1e-12))[:, None]
    skeleton = Skeleton(tuple(names or (f"joint{j}" for j in range(count))), above, offsets)
    world = np.empty((count, frames, 4))
    local = rotation.identity((frames, count))
    places = bones.copy()  # a root's place is the world's
    for joint, children in enumerate(skeleton.children):
        parent = int(above[joint])
        before = world[parent] if parent >= 0 else rotation.identity((frames,))
        world[joint] = _turned(before, offsets[list(children)], bones[:, list(children)])
        local[:, joint] = rotation.multiply(rotation.inverse(before), world[joint])
        if parent >= 0:
            places[:, joint] = rotation.rotate(rotation.inverse(before), bones[:, joint])
    return Clip(skeleton, places, rotation.normalize(local), frame_time)


def _tallest(positions: Floats) -> int:
    """Find the frame in which the joints are highest, on the whole, over the lowest of them."""
    heights = positions[..., 1]
    return int(np.argmax(heights.mean(axis=1) - heights.min(axis=1)))


def _turned(before: Floats, offsets: Floats, bones: Floats) -> Floats:
    """Compute the turn of a joint in the world, (F, 4).

    Args:
        before: (F, 4) that of its parent.
        offsets: (n, 3) [m] its bones at rest.
        bones: (F, n, 3) [m] its bones in the world.
    """
    long = norm(offsets) > 1e-9
    if not long.any():
        return before
    offsets, bones = offsets[long], bones[:, long]
    spread = np.linalg.svd(offsets, compute_uv=False)
    if len(offsets) > 1 and spread[1] > _SPREAD * spread[0]:
        return _together(offsets, bones)
    along, rests = bones.sum(axis=1), offsets.sum(axis=0)
    carried = rotation.rotate(before, np.broadcast_to(unit(rests), along.shape))
    return rotation.multiply(rotation.between(carried, unit(along)), before)


def _together(offsets: Floats, bones: Floats) -> Floats:
    """Compute the turns (F, 4) that bring several bones nearest to where they are, by least squares.

    Source: W. Kabsch, A solution for the best rotation to relate two sets of vectors, Acta Cryst. A32 (1976).
    """
    u, _, vt = np.linalg.svd(np.einsum("fni,nj->fij", bones, offsets))
    u[..., 2] *= np.sign(np.linalg.det(u @ vt))[:, None]  # a rotation, no mirror image
    return rotation.from_matrix(u @ vt)

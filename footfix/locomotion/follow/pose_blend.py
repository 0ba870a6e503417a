"""Blend tracks and poses of two walks by the weight of the second."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats


def mixed(one: Floats, two: Floats, seen: Sequence[Bools], weight: Floats, *, turn: bool = False) -> Floats:
    """Blend tracks of two walks, each given in some of n frames.

    Args:
        one, two: (..., n1, D), (..., n2, D) the tracks in the frames in which they are seen.
        seen: for either (n,) in which frames that is; the first where the weight is below 1, the second where it is
            above 0.
        weight: (n,) of the second.
        turn: whether they are rotations.

    Returns:
        (..., n, D), exactly one track's values where only that counts.
    """
    if not np.any(seen[1]):
        return one
    if not np.any(seen[0]):
        return two
    out = np.empty((*one.shape[:-2], one.shape[-1], len(weight))).swapaxes(-1, -2)
    out[..., seen[1], :] = two
    first = weight <= 0.0
    out[..., first, :] = one[..., first[seen[0]], :]
    both = (weight > 0.0) & (weight < 1.0)
    a, b, w = one[..., both[seen[0]], :], two[..., both[seen[1]], :], weight[both]
    out[..., both, :] = _on_one_side(a, b, w) if turn else a + w[:, None] * (b - a)
    return out


def _on_one_side(a: Floats, b: Floats, weight: Floats) -> Floats:
    """Compute the rotations from a to b (..., n, 4), always by the arc that is shorter where weights are equal.

    The shorter arc of each frame by itself changes sides where two poses come to be half a turn apart.
    """
    if not len(weight):
        return a
    step = rotation.multiply(rotation.inverse(a), b)
    step = np.moveaxis(rotation.continuous(np.moveaxis(step, -2, 0)), 0, -2)
    far = step[..., 3] @ (weight * (1.0 - weight)) < 0.0
    step = np.where(far[..., None, None], -step, step)
    sine = np.sqrt(np.einsum("...i,...i->...", step[..., :3], step[..., :3]))
    angle = 2.0 * np.arctan2(sine, step[..., 3])  # up to a whole turn
    axis = step[..., :3] / np.maximum(sine, 1e-300)[..., None]
    return rotation.multiply(a, rotation.from_axis_angle(axis, weight * angle))


def mixed_clip(
    clips: tuple[Clip, Clip], seen: Sequence[Bools], weight: Floats, joints: Mapping[int, tuple[Clip, Clip, Floats]]
) -> Clip:  # fmt: skip
    """Blend the poses of two walks.

    Args:
        clips: of either walk in the frames in which it is seen.
        seen: see `mixed`.
        weight: (n,) how much of the second.
        joints: joints with their own clips and weight (n,).
    """
    count = len(clips[0].skeleton)
    places: list[Floats] = [np.zeros((0, 3))] * count
    turns: list[Floats] = [np.zeros((0, 4))] * count
    by_weight: dict[int, list[int]] = {}
    own = [joints.get(joint, (*clips, weight)) for joint in range(count)]
    for joint, (_, _, mine) in enumerate(own):
        by_weight.setdefault(id(mine), []).append(joint)
    for some in by_weight.values():
        mine = own[some[0]][2]
        for tracks, given, turn in (
            (places, [[each.position(joint) for each in own[joint][:2]] for joint in some], False),
            (turns, [[each.rotation(joint) for each in own[joint][:2]] for joint in some], True),
        ):
            for joint, track in zip(some, _mixed_all(given, seen, mine, turn=turn), strict=True):
                tracks[joint] = track
    return Clip.from_tracks(clips[0].skeleton, places, turns, clips[0].frame_time)


def _mixed_all(
    pairs: Sequence[Sequence[Floats]], seen: Sequence[Bools], weight: Floats, *, turn: bool
) -> list[Floats]:  # fmt: skip
    """Mix many pairs of tracks at once, see `mixed`; those that are one value in both walks are that value."""
    both = (weight > 0.0) & (weight < 1.0)
    if not np.any(both):
        return [mixed(one, two, seen, weight, turn=turn) for one, two in pairs]
    still = [_still(one, two) for one, two in pairs]
    out = [np.broadcast_to(one[:1], (len(weight), one.shape[1])) for one, _ in pairs]
    moving = [k for k, each in enumerate(still) if not each]
    if moving:
        one, two = (np.stack([pairs[k][side].T for k in moving]).swapaxes(1, 2) for side in (0, 1))
        for k, track in zip(moving, mixed(one, two, seen, weight, turn=turn), strict=True):
            out[k] = track
    return out


def _still(one: Floats, two: Floats) -> bool:
    """Tell whether two tracks are one value throughout."""
    held = len(one) and len(two) and one.strides[0] == 0 and two.strides[0] == 0
    return bool(held and np.array_equal(one[0], two[0]))


def joined(clips: Sequence[Clip]) -> Clip:
    """Join clips of one skeleton end to end."""
    if len(clips) == 1:
        return clips[0]
    joints = range(len(clips[0].skeleton))
    places = [np.concatenate([clip.position(joint) for clip in clips]) for joint in joints]
    turns = [np.concatenate([clip.rotation(joint) for clip in clips]) for joint in joints]
    return Clip.from_tracks(clips[0].skeleton, places, turns, clips[0].frame_time)

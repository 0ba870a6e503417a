"""Find out whether a skin's and a clip's joints have the same frames, so that the skin's own binding can be used."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.motion.clip import Floats
from footfix.rig.frame_sample import Sample
from footfix.rig.rig import Leg
from footfix.rig.skin import Skin, SkinFoot, SkinLeg
from footfix.rig.soles import SoleEstimate

_SAME = float(np.cos(np.radians(4.0)))  # of bones in the same frames
_SAME_SIZE = 0.01  # [share] greatest difference of bone lengths after scaling, for the same skeleton
_SAME_UP = float(np.cos(np.radians(25.0)))  # of the up directions in the same frames


def shared_frames(
    skin: Skin, seen: Sample, legs: Sequence[Leg], own: Sequence[SkinLeg], feet: Sequence[SoleEstimate],
    soles: Sequence[SkinFoot], *, named: bool,
) -> Floats | None:  # fmt: skip
    """Find the axes (J, 3, 3) of the skin's joints that the clip's frames are, if both have the same frames.

    They do where the clip is the skin's own, or where it was exported with all frames equal to the world's in the bind
    pose. None where they differ: then only places of joints can be compared.
    """
    local = np.median(seen.local, axis=0)  # (J, 3)
    bones = [bone for leg, it in zip(legs, own, strict=True) for bone in _bones(skin, seen, leg, it)]
    its = np.array([np.linalg.norm(skin.places[here] - skin.places[up]) for _, here, up in bones])
    ratios = np.array([np.linalg.norm(local[there]) for there, _, _ in bones]) / np.maximum(its, 1e-12)
    alike = len(ratios) > 0 and float(np.ptp(ratios)) < _SAME_SIZE * float(ratios.mean())
    candidates = [skin.turns] if named else []
    turn = _common_turn(skin, seen, legs, own)
    if turn is not None:
        candidates.append(np.broadcast_to(turn.T, skin.turns.shape))
    for axes in candidates:
        fits = all(
            _alike(local[there], axes[up].T @ (skin.places[here] - skin.places[up]))
            for there, here, up in bones
        )
        stands = all(
            float((axes[sole.leg.ankle].T @ sole.up) @ foot.up) > _SAME_UP
            for sole, foot in zip(soles, feet, strict=True)
        )
        if fits and (stands or (named and alike and axes is skin.turns)):
            return axes
    return None


def _bones(skin: Skin, seen: Sample, leg: Leg, own: SkinLeg) -> list[tuple[int, int, int]]:
    """List the bones into ankle and toe: (the clip's joint, the skin's joint, the skin's joint above it)."""
    ends = [(leg.ankle, own.ankle)] + ([(leg.toe, own.toe)] if leg.toe is not None and own.toe is not None else [])
    above = {leg.ankle: own.knee, leg.toe: own.ankle}
    mine = {leg.ankle: leg.knee, leg.toe: leg.ankle}
    return [
        (there, here, above[there])
        for there, here in ends
        if int(seen.skeleton.parents[there]) == mine[there] and int(skin.parents[here]) == above[there]
    ]


def _common_turn(skin: Skin, seen: Sample, legs: Sequence[Leg], own: Sequence[SkinLeg]) -> Floats | None:
    """Find the rotation (3, 3) from the skin's space to the clip's zero pose, in which all frames equal the world's."""
    skeleton = seen.skeleton
    at = np.array(skeleton.offsets)
    for joint, parent in enumerate(skeleton.parents.tolist()):
        at[joint] += at[parent] if parent >= 0 else 0.0
    pairs = [(leg.hip, leg.knee, leg.ankle, leg.toe) for leg in legs]
    its = [(leg.hip, leg.knee, leg.ankle, leg.toe) for leg in own]
    a, b = [], []
    for mine, other in zip(pairs, its, strict=True):
        for k in range(3):
            if mine[k + 1] is not None and other[k + 1] is not None:
                a.append(skin.places[other[k + 1]] - skin.places[other[k]])
                b.append(at[mine[k + 1]] - at[mine[k]])
    a.append(skin.places[its[0][0]] - skin.places[its[-1][0]])
    b.append(at[pairs[0][0]] - at[pairs[-1][0]])
    first, second = (np.array(each) / np.maximum(np.linalg.norm(each, axis=1, keepdims=True), 1e-12) for each in (a, b))
    u, _, v = np.linalg.svd(second.T @ first)
    turn = u @ np.diag([1.0, 1.0, float(np.sign(np.linalg.det(u @ v)))]) @ v
    return turn if float(np.einsum("ni,ni->n", first @ turn.T, second).min()) > _SAME else None


def _alike(one: Floats, other: Floats) -> bool:
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return size > 0.0 and float(one @ other) > _SAME * size

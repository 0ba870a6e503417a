"""The outline of a mesh's soles for the page: parts of the foot, each placed by three points that the page has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from footfix.measure.skinned_joints import tip_of
from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Part
from footfix.motion.kinematics import Pose, forward
from footfix.rig.foot_mesh import FootMesh
from footfix.rig.rig import Rig

_FRAMES = 25  # frames of a clip that the place of an outline in its part is measured on
_CORNERS = 24  # of an outline, at most

_PARTS: tuple[Part, ...] = ("heel", "toe")

Place = tuple[str, int]  # ("joint", its number in the page) or ("point", the number of a sole point)


@dataclass(frozen=True, eq=False)
class SolePart:
    """The sole of one part of a foot.

    Args:
        lane: the sole point it belongs to.
        at, to, beside: points that move with it. `at` is its origin, its first axis points to `to`, and its third is
            perpendicular to that and to the direction of `beside`.
        outline: (N, 3) [m] its corners along these axes.
    """

    lane: int
    at: Place
    to: Place
    beside: Place
    outline: Floats

    def packed(self) -> dict[str, Any]:
        """Give plain JSON values, in millimetres."""
        return {
            "lane": self.lane, "at": list(self.at), "to": list(self.to), "beside": list(self.beside),
            "outline": np.round(1000.0 * self.outline).astype(int).tolist(),
        }  # fmt: skip


def sole_parts(clip: Clip, rig: Rig) -> tuple[SolePart, ...]:
    """Outline the soles of a rig's meshes; none where it has none.

    Args:
        clip: before it is corrected.
        rig: its legs, sole points and meshes.
    """
    if not rig.meshes or not len(clip):
        return ()
    pose = forward(clip.frames(np.linspace(0, len(clip) - 1, min(_FRAMES, len(clip))).astype(np.intp)))
    lanes = {(sole.leg, sole.part): k for k, sole in enumerate(rig.soles)}
    found = []
    for mesh in rig.meshes:
        for part, outline in zip(_PARTS, mesh.outlines, strict=False):
            if len(outline) < 3:
                continue
            at, to, beside = _places(clip, rig, mesh.leg, part, lanes)
            corners = np.array(outline)[:: max(1, -(-len(outline) // _CORNERS))]
            where = _along(pose, rig, clip, (at, to, beside), mesh, corners)
            found.append(SolePart(lanes[mesh.leg, part], at, to, beside, where))
    return tuple(found)


def _places(
    clip: Clip, rig: Rig, number: int, part: Part, lanes: Mapping[tuple[int, Part], int]
) -> tuple[Place, Place, Place]:
    """Choose three points that move with a part of a foot."""
    leg = rig.legs[number]
    heel, toe = ("point", lanes[number, "heel"]), ("point", lanes[number, "toe"])
    if leg.toe is None:
        return ("joint", leg.ankle), toe, heel
    tip = tip_of(clip.skeleton, leg.toe)
    if part == "heel" or tip is None:
        return ("joint", leg.ankle), ("joint", leg.toe), heel
    joint, offset = tip
    carried = clip.skeleton.end_parents == joint
    same = (np.nan_to_num(clip.skeleton.end_offsets) == offset).all(axis=-1)
    known = np.flatnonzero(carried & same).tolist()
    at_end = bool(np.any(offset)) and known
    return ("joint", leg.toe), ("joint", len(clip.skeleton) + known[0] if at_end else joint), ("joint", leg.ankle)


def _along(
    pose: Pose, rig: Rig, clip: Clip, places: tuple[Place, Place, Place], mesh: FootMesh, corners: Any
) -> Floats:
    """Find the median places of corners along the axes of a part (N, 3) [m]."""
    at, to, beside = (_track(pose, rig, clip, place) for place in places)
    first = _unit(to - at)
    third = _unit(np.cross(first, beside - at))
    axes = np.stack([first, np.cross(third, first), third], axis=1)  # (F, 3, 3)
    away = mesh.tracks(pose, corners) - at[:, None]
    return np.asarray(np.median(np.einsum("fab,fnb->fna", axes, away), axis=0))


def _track(pose: Pose, rig: Rig, clip: Clip, place: Place) -> Floats:
    kind, number = place
    if kind == "point":
        return pose.point(rig.soles[number].joint, np.array(rig.soles[number].offset))
    joints = len(clip.skeleton)
    if number < joints:
        return pose.position(number)
    return pose.point(int(clip.skeleton.end_parents[number - joints]), clip.skeleton.end_offsets[number - joints])


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9))

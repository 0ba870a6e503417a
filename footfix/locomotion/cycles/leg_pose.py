"""The legs of a model in the world, and their hips and knees turned so that their ankles are where they are wanted.

All legs are done together, as rotation matrices: at one time, as a live engine has it, what counts is the number of
operations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Floats, Skeleton
from footfix.motion.vectors import cross, dot, norm, unit
from footfix.rig.rig import Rig

_LONGEST = 0.9998  # share of a leg's length to which it is stretched at most


@dataclass(frozen=True, eq=False)
class LegPoses:
    """The legs at T times, in the world.

    Args:
        hip, knee, ankle, heel, toe: (T, L, 3) [m] joints, the sole point of the heel, and the toe joint (or the ball of
            the sole where there is none).
        above_hip, thigh, above_knee, shank, above_ankle, foot, above_toe, toes: (T, L, 3, 3) frames of the hip joint,
            the knee, the ankle and the toe joint, and of what each hangs from.
    """

    hip: Floats
    knee: Floats
    ankle: Floats
    heel: Floats
    toe: Floats
    above_hip: Floats
    thigh: Floats
    above_knee: Floats
    shank: Floats
    above_ankle: Floats
    foot: Floats
    above_toe: Floats
    toes: Floats

    def some(self, which: slice) -> LegPoses:
        """The poses at some of the times."""
        return LegPoses(*(getattr(self, name)[which] for name in self.__dataclass_fields__))


@dataclass(frozen=True, eq=False)
class Legs:
    """What of a skeleton moves its legs.

    Args:
        skeleton: of the figure.
        rig: its legs and soles.
    """

    skeleton: Skeleton
    rig: Rig

    @cached_property
    def needed(self) -> tuple[int, ...]:
        """The joints below the root that legs hang from, and those of the legs, parents first."""
        ends = [leg.ankle if leg.toe is None else leg.toe for leg in self.rig.legs]
        root = self.rig.root
        return tuple(j for j in self.skeleton.with_ancestors(ends) if root in self.skeleton.ancestors(j)[1:])

    @cached_property
    def turned(self) -> tuple[int, ...]:
        """The joints that `bent` turns: hips, knees, ankles, toe joints."""
        legs = self.rig.legs
        toes = [leg.toe for leg in legs if leg.toe is not None]
        return tuple([leg.hip for leg in legs] + [leg.knee for leg in legs] + [leg.ankle for leg in legs] + toes)

    def _sole(self, part: str) -> Floats:
        """(L, 3) [m] a sole point of each leg in the frame of its ankle."""
        found = []
        for number in range(len(self.rig.legs)):
            found.append(next(s.offset for s in self.rig.soles if (s.leg, s.part) == (number, part)))
        return np.array(found)

    @cached_property
    def _soles(self) -> tuple[Floats, Floats]:
        return self._sole("heel"), self._sole("toe")

    def poses(self, place: Floats, turn: Floats, turns: Floats) -> LegPoses:
        """Forward kinematics.

        Args:
            place: (T, 3) [m] the root.
            turn: (T, 4) its frame in the world.
            turns: (T, J, 4) all joints in their parents' frames; the root's is not looked at.
        """
        needed, root, parents = self.needed, self.rig.root, self.skeleton.parents
        local = rotation.to_matrix(turns[:, needed])
        places, frames = {root: place}, {root: rotation.to_matrix(turn)}
        for k, joint in enumerate(needed):
            parent = int(parents[joint])
            places[joint] = places[parent] + frames[parent] @ self.skeleton.offsets[joint]
            frames[joint] = frames[parent] @ local[:, k]
        legs = self.rig.legs

        def stacked(values: dict[int, Floats], joints: list[int]) -> Floats:
            return np.stack([values[joint] for joint in joints], axis=1)

        ends = [leg.ankle if leg.toe is None else leg.toe for leg in legs]
        hips, knees, ankles = ([getattr(leg, name) for leg in legs] for name in ("hip", "knee", "ankle"))
        ankle, foot = stacked(places, ankles), stacked(frames, ankles)
        heel_at, toe_at = self._soles
        heel = ankle + (foot @ heel_at[..., None])[..., 0]
        if all(leg.toe is not None for leg in legs):
            toe = stacked(places, ends)
        else:
            toe = ankle + (foot @ toe_at[..., None])[..., 0]
        above = [stacked(frames, [int(parents[j]) for j in joints]) for joints in (hips, knees, ankles)]
        above_toe = stacked(frames, [leg.ankle if leg.toe is None else int(parents[leg.toe]) for leg in legs])
        return LegPoses(
            stacked(places, hips), stacked(places, knees), ankle, heel, toe, above[0], stacked(frames, hips), above[1],
            stacked(frames, knees), above[2], foot, above_toe, stacked(frames, ends),
        )  # fmt: skip

    def bent(self, pose: LegPoses, knees: Floats, ankle: Floats, foot: Floats, toes: Floats) -> Floats:
        """Turn hips, knees and ankles so that the ankles are at a place, by the law of cosines.

        A knee flexes about its axis; the leg then swings about the hip by the smallest turn. Bones keep their lengths,
        and what hangs between keeps its pose.

        Args:
            pose: the legs as the cycle has them.
            knees: (L, 3) axes of the knees in the frames of the thighs.
            ankle: (T, L, 3) [m] where the ankles are to be; beyond its reach a leg points there.
            foot, toes: (T, L, 3, 3) frames of ankles and toe joints as they are to be.

        Returns:
            (T, n, 4) rotations of `turned` in their parents' frames.
        """
        thigh, shank = pose.knee - pose.hip, pose.ankle - pose.knee
        axis = (pose.thigh @ knees[..., None])[..., 0]
        along = unit(thigh)
        axis = unit(axis - dot(axis, along)[..., None] * along)
        in_plane = shank - dot(shank, axis)[..., None] * axis
        flexion = np.arctan2(dot(cross(thigh, in_plane), axis), dot(thigh, in_plane))
        line = ankle - pose.hip
        bones = dot(thigh, thigh) + dot(shank, shank)
        far = np.minimum(norm(line), reach(pose))
        lever = np.maximum(2.0 * norm(thigh) * norm(in_plane), 1e-12)
        wanted = np.arccos(np.clip((far * far - bones) / lever, -1.0, 1.0))
        wanted = np.where(flexion < -0.3, -wanted, wanted)
        bend = about(axis, wanted - flexion)
        swing = between(thigh + (bend @ shank[..., None])[..., 0], line)
        parts = [_back(pose.above_hip) @ (swing @ pose.thigh), _back(pose.above_knee) @ (bend @ pose.shank),
                 _back(swing @ (bend @ pose.above_ankle)) @ foot]  # fmt: skip
        if all(leg.toe is not None for leg in self.rig.legs):
            above_toe = foot @ (_back(pose.foot) @ pose.above_toe)
            parts.append(_back(above_toe) @ toes)
        return rotation.from_matrix(np.concatenate(parts, axis=1))


def reach(pose: LegPoses) -> Floats:
    """(T, L) [m] how far ankles can be from their hips: what the legs are long, or what they were posed at."""
    bones = norm(pose.knee - pose.hip) + norm(pose.ankle - pose.knee)
    return np.maximum(_LONGEST * bones, norm(pose.ankle - pose.hip))


def _back(frames: Floats) -> Floats:
    return np.swapaxes(frames, -1, -2)


def about(axis: Floats, angle: Floats) -> Floats:
    """(..., 3, 3) turns about unit axes (..., 3) by angles (...) [rad]."""
    return turned_by(axis * angle[..., None])


def turned_by(vector: Floats) -> Floats:
    """(..., 3, 3) turns by rotation vectors (..., 3) [rad] (Rodrigues)."""
    square = np.sum(vector * vector, axis=-1)
    angle = np.sqrt(square)
    safe = np.maximum(angle, 1e-9)
    s = np.where(angle < 1e-6, 1.0, np.sin(safe) / safe)[..., None, None]
    c = np.where(angle < 1e-6, 0.5, (1.0 - np.cos(safe)) / (safe * safe))[..., None, None]
    k = _crosswise(vector)
    return np.asarray(np.eye(3) + s * k + c * (k @ k))


def _crosswise(v: Floats) -> Floats:
    """(..., 3, 3) the matrices whose products with w are the cross products v x w."""
    out = np.zeros((*v.shape, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = v[..., 2], -v[..., 1], v[..., 0]
    return out


def between(a: Floats, b: Floats) -> Floats:
    """(..., 3, 3) the smallest turns that take directions (..., 3) to others."""
    a, b = unit(a), unit(b)
    k = _crosswise(cross(a, b))
    return np.asarray(np.eye(3) + k + (k @ k) / np.maximum(1.0 + dot(a, b), 1e-9)[..., None, None])


def vector_between(a: Floats, b: Floats) -> Floats:
    """(..., 3) [rad] rotation vectors of the turns from frames (..., 3, 3) to others, small ones above all."""
    m = b @ _back(a)
    odd = m - _back(m)
    axis = 0.5 * np.stack([odd[..., 2, 1], odd[..., 0, 2], odd[..., 1, 0]], axis=-1)
    sine = np.linalg.norm(axis, axis=-1)
    angle = np.arctan2(sine, 0.5 * (np.trace(m, axis1=-2, axis2=-1) - 1.0))
    return np.asarray(axis * np.where(sine < 1e-9, 1.0, angle / np.maximum(sine, 1e-12))[..., None])

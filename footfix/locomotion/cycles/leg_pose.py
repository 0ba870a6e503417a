"""Leg poses of a model in the world, and inverse kinematics that brings ankles to goals.

All legs are computed together, as rotation matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.locomotion.cycles.leg_vectors import applied, back, between, cross, dot, norm, quaternions, turned_by, unit
from footfix.motion.clip import Bools, Floats, Ints, Skeleton
from footfix.rig.rig import Rig

_SOFT = 0.01  # [leg lengths] range over which the limit of a leg's reach is rounded
_LONGEST = 0.9998  # greatest stretch of a leg, as a share of its length


@dataclass(frozen=True, eq=False)
class LegPoses:
    """The legs at T times, in the world.

    Args:
        hip, knee, ankle: (T, L, 3) [m] joints.
        soles: (T, L, 2, 3) [m] the sole point of the heel, and the toe joint (or the place where it would be).
        ends: (T, L, 2, 3, 3) frames of the ankle and of the toe joint.
        above_hip, thigh, above_knee, shank, above_ankle, above_toe: (T, L, 3, 3) frames of the hip joint and the knee,
            and of what hip joint, knee, ankle and toe joint hang from.
    """

    hip: Floats
    knee: Floats
    ankle: Floats
    soles: Floats
    ends: Floats
    above_hip: Floats
    thigh: Floats
    above_knee: Floats
    shank: Floats
    above_ankle: Floats
    above_toe: Floats

    @property
    def heel(self) -> Floats:
        """Get the sole point of the heel, (T, L, 3) [m]."""
        return self.soles[:, :, 0]

    @property
    def toe(self) -> Floats:
        """Get the toe joint, or the place where it would be, (T, L, 3) [m]."""
        return self.soles[:, :, 1]

    @property
    def foot(self) -> Floats:
        """Get the frames of the ankles, (T, L, 3, 3)."""
        return self.ends[:, :, 0]

    @property
    def toes(self) -> Floats:
        """Get the frames of the toe joints, (T, L, 3, 3)."""
        return self.ends[:, :, 1]

    @cached_property
    def reach(self) -> Floats:
        """Compute the greatest distance from hips to ankles, (T, L) [m]: the length of the legs, or as posed."""
        bones = norm(self.knee - self.hip) + norm(self.ankle - self.knee)
        return np.maximum(_LONGEST * bones, self.far)

    @cached_property
    def far(self) -> Floats:
        """Compute the distance from hips to ankles, (T, L) [m]."""
        return norm(self.ankle - self.hip)

    def some(self, which: slice) -> LegPoses:
        """Take the poses at some of the times."""
        return LegPoses(*(getattr(self, name)[which] for name in self.__dataclass_fields__))


@dataclass(frozen=True, eq=False)
class Legs:
    """The joints of a skeleton that move its legs.

    Args:
        skeleton: of the figure.
        rig: its legs and soles.
    """

    skeleton: Skeleton
    rig: Rig

    @cached_property
    def turned(self) -> tuple[int, ...]:
        """List the joints that `bent` turns: hips, knees, ankles, toe joints."""
        legs = self.rig.legs
        toes = [leg.toe for leg in legs if leg.toe is not None]
        return tuple([leg.hip for leg in legs] + [leg.knee for leg in legs] + [leg.ankle for leg in legs] + toes)

    @cached_property
    def has_toes(self) -> bool:
        """Tell whether all legs have toe joints."""
        return all(leg.toe is not None for leg in self.rig.legs)

    def _sole(self, part: str) -> Floats:
        """Get what a heel or toe of each leg holds, in the frame of its joint, (L, 3) [m]."""
        found = []
        for number in range(len(self.rig.legs)):
            found.append(next(self.rig.held_at(s)[1] for s in self.rig.soles if (s.leg, s.part) == (number, part)))
        return np.array(found)

    @cached_property
    def _chains(self) -> tuple[Ints, Floats, Bools, tuple[int, ...]]:
        """List the joints of all legs side by side, from below the root to the toe joints.

        Where one leg has fewer joints between hip, knee, ankle and toe joint than another, it is padded with joints
        that do not turn.

        Returns:
            (D, L) the joints, (D, L, 3) [m] their offsets, (D, L) whether they are padding, and the indices of hip,
            knee, ankle and toe joint among the D.
        """
        joints, offsets, still = list[list[int]](), list[Floats](), list[list[bool]]()
        places, legs = [], self.rig.legs
        above = [self.rig.root] * len(legs)
        for name in ("hip", "knee", "ankle", "toe"):
            to = [getattr(leg, name) if getattr(leg, name) is not None else leg.ankle for leg in legs]
            ways = [self._way(a, b) for a, b in zip(above, to, strict=True)]
            for k in range(max(map(len, ways)), 0, -1):
                own = [way[-k] if len(way) >= k else None for way in ways]
                joints.append([0 if j is None else j for j in own])
                offsets.append(np.array([np.zeros(3) if j is None else self.skeleton.offsets[j] for j in own]))
                still.append([j is None for j in own])
            places.append(len(joints) - 1)
            above = to
        return np.array(joints), np.array(offsets), np.array(still), tuple(places)

    def _way(self, above: int, joint: int) -> list[int]:
        """List the joints from below one joint down to another."""
        way = [joint]
        while way[0] != above:
            way.insert(0, int(self.skeleton.parents[way[0]]))
        return way[1:]

    @cached_property
    def _soles(self) -> tuple[Floats, Floats]:
        return self._sole("heel"), self._sole("toe")

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """List the joints of all legs, down from below the root."""
        joints, _, still, _ = self._chains
        return tuple(dict.fromkeys(joints[~still].tolist()))

    @cached_property
    def _among(self) -> Ints:
        """Find the index in `joints` of each joint of the chains, (D, L)."""
        found = {joint: k for k, joint in enumerate(self.joints)}
        return np.array([[found.get(joint, 0) for joint in row] for row in self._chains[0].tolist()])

    @cached_property
    def _steps(self) -> tuple[Floats, Bools | None, tuple[int, ...]]:
        """Prepare the chains for `poses`: offsets (D, 3, 1, L), which are padding (None without any), the four indices.
        """
        _, offsets, still, places = self._chains
        return offsets.swapaxes(1, 2)[:, :, None], still if still.any() else None, places

    def poses(self, place: Floats, turn: Floats, turns: Floats) -> LegPoses:
        """Pose the legs by forward kinematics.

        Args:
            place: (T, 3) [m] the root.
            turn: (T, 3, 3) its frame in the world.
            turns: (T, N, 3, 3) `joints` in their parents' frames.
        """
        rest, still, (hip, knee, ankle, toe) = self._steps
        count, (depth, legs) = len(place), self._among.shape
        # components first, so that a product of two matrices is two operations on rows of numbers
        step = np.empty((depth, 3, 4, count, legs))  # each joint's turn, and in the last column its offset
        step[:, :, :3] = turns[:, self._among].transpose(1, 3, 4, 0, 2)
        if still is not None:
            step[:, :, :3].transpose(0, 4, 1, 2, 3)[still] = np.eye(3)[:, :, None]
        step[:, :, 3] = rest
        whole = np.empty((depth + 1, 3, 4, count, legs))
        whole[0, :, :3] = turn.transpose(1, 2, 0)[..., None]
        whole[0, :, 3] = place.T[..., None]
        for d in range(depth):
            np.add.reduce(whole[d, :, :3, None] * step[d], axis=1, out=whole[d + 1])
        frames = whole[:, :, :3].transpose(3, 0, 4, 1, 2)
        places = np.add.accumulate(whole[:, :, 3]).transpose(2, 0, 3, 1)
        foot, heel_at = frames[:, ankle + 1], places[:, ankle + 1]
        soles, ends = np.empty((count, legs, 2, 3)), np.empty((count, legs, 2, 3, 3))
        soles[:, :, 0] = heel_at + applied(foot, self._soles[0])
        soles[:, :, 1] = places[:, -1] if self.has_toes else heel_at + applied(foot, self._soles[1])
        ends[:, :, 0], ends[:, :, 1] = foot, frames[:, -1]
        above_toe = frames[:, toe] if toe > ankle else foot
        return LegPoses(
            places[:, hip + 1], places[:, knee + 1], heel_at, soles, ends, frames[:, hip], frames[:, hip + 1],
            frames[:, knee], frames[:, knee + 1], frames[:, ankle], above_toe,
        )  # fmt: skip

    def bent(self, pose: LegPoses, knees: Floats, ankle: Floats, foot: Floats, toes: Floats) -> Floats:
        """Turn hips, knees and ankles so that the ankles are at a place, by the law of cosines.

        A knee flexes about its axis; the leg then swings about the hip by the smallest turn. Bones keep their lengths,
        and joints between them keep their pose.

        Args:
            pose: the legs as the cycle has them.
            knees: (L, 3) axes of the knees in the frames of the thighs.
            ankle: (T, L, 3) [m] where the ankles are to be; beyond its reach a leg points there.
            foot, toes: (T, L, 3, 3) frames of ankles and toe joints as they are to be.

        Returns:
            (T, n, 4) rotations of `turned` in their parents' frames.
        """
        thigh, shank = pose.knee - pose.hip, pose.ankle - pose.knee
        axis = applied(pose.thigh, knees)
        square, small = dot(thigh, thigh), 1e-300
        axis = unit(axis - (dot(axis, thigh) / np.maximum(square, small))[..., None] * thigh)
        in_plane = shank - dot(shank, axis)[..., None] * axis
        flexion = np.arctan2(dot(cross(thigh, in_plane), axis), dot(thigh, in_plane))
        line = ankle - pose.hip
        far = np.minimum(norm(line), pose.reach)
        lever = np.maximum(2.0 * np.sqrt(square * dot(in_plane, in_plane)), 1e-12)
        cosine = (far * far - square - dot(shank, shank)) / lever
        wanted = np.arccos(np.minimum(np.maximum(cosine, -1.0), 1.0))
        wanted = np.where(flexion < -0.3, -wanted, wanted)
        bend = turned_by(axis * (wanted - flexion)[..., None])
        swing = between(thigh + applied(bend, shank), line)
        parts = 4 if self.has_toes else 3
        below, above = np.empty((2, *thigh.shape[:1], parts, *thigh.shape[1:], 3))  # frames as they are to be
        above[:, 0], above[:, 1] = pose.above_hip, pose.above_knee
        np.matmul(swing, bend @ pose.above_ankle, out=above[:, 2])
        np.matmul(swing, pose.thigh, out=below[:, 0])
        np.matmul(bend, pose.shank, out=below[:, 1])
        below[:, 2] = foot
        if self.has_toes:
            np.matmul(foot, back(pose.foot) @ pose.above_toe, out=above[:, 3])
            below[:, 3] = toes
        turns = back(above) @ below
        return quaternions(turns.reshape(len(turns), parts * turns.shape[2], 3, 3))


def too_short(line: Floats, limit: Floats, size: float) -> Floats:
    """Compute how far (...) [m] hips must come down for ankles, (..., 3) [m] from them, to be within reach.

    Near the limit the result is rounded, so that it changes smoothly.
    """
    flat = line[..., 0] ** 2 + line[..., 2] ** 2
    short = -line[..., 1] - np.sqrt(np.maximum(limit**2 - flat, 0.0))
    soft = _SOFT * size
    return np.where(np.abs(short) < soft, (short + soft) ** 2 / (4.0 * soft), np.maximum(short, 0.0))

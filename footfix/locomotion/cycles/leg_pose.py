"""The legs of a model in the world, and their hips and knees turned so that their ankles are where they are wanted.

All legs are done together, as rotation matrices: at one time, as a live engine has it, what counts is the number of
operations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats, Ints, Skeleton
from footfix.motion.vectors import cross, dot, norm, unit
from footfix.rig.rig import Rig

_STILL = np.eye(3)
_SOFT = 0.01  # [leg lengths] that a leg may lack, from which on it is noticed
_LONGEST = 0.9998  # share of a leg's length to which it is stretched at most


@dataclass(frozen=True, eq=False)
class LegPoses:
    """The legs at T times, in the world.

    Args:
        hip, knee, ankle: (T, L, 3) [m] joints.
        soles: (T, L, 2, 3) [m] the sole point of the heel, and the toe joint (or the ball of the sole where there is
            none).
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
        """(T, L, 3) [m] the sole point of the heel."""
        return self.soles[:, :, 0]

    @property
    def toe(self) -> Floats:
        """(T, L, 3) [m] the toe joint, or the ball of the sole."""
        return self.soles[:, :, 1]

    @property
    def foot(self) -> Floats:
        """(T, L, 3, 3) frames of the ankles."""
        return self.ends[:, :, 0]

    @property
    def toes(self) -> Floats:
        """(T, L, 3, 3) frames of the toe joints."""
        return self.ends[:, :, 1]

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
    def turned(self) -> tuple[int, ...]:
        """The joints that `bent` turns: hips, knees, ankles, toe joints."""
        legs = self.rig.legs
        toes = [leg.toe for leg in legs if leg.toe is not None]
        return tuple([leg.hip for leg in legs] + [leg.knee for leg in legs] + [leg.ankle for leg in legs] + toes)

    @cached_property
    def has_toes(self) -> bool:
        """Whether all legs have toe joints."""
        return all(leg.toe is not None for leg in self.rig.legs)

    def _sole(self, part: str) -> Floats:
        """(L, 3) [m] a sole point of each leg in the frame of its ankle."""
        found = []
        for number in range(len(self.rig.legs)):
            found.append(next(s.offset for s in self.rig.soles if (s.leg, s.part) == (number, part)))
        return np.array(found)

    @cached_property
    def _chains(self) -> tuple[Ints, Floats, Bools, tuple[int, ...]]:
        """The joints of all legs side by side, from below the root to the toe joints.

        Where one leg has fewer joints between two of the four than another, joints that do not turn stand in.

        Returns:
            (D, L) the joints, (D, L, 3) [m] their offsets, (D, L) whether they stand in, and where among the D hip,
            knee, ankle and toe joint are.
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
        """The joints below one on the way down to another."""
        way = [joint]
        while way[0] != above:
            way.insert(0, int(self.skeleton.parents[way[0]]))
        return way[1:]

    @cached_property
    def _soles(self) -> tuple[Floats, Floats]:
        return self._sole("heel"), self._sole("toe")

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """The joints of all legs, down from below the root."""
        joints, _, still, _ = self._chains
        return tuple(dict.fromkeys(joints[~still].tolist()))

    @cached_property
    def _among(self) -> Ints:
        """(D, L) where those of the chains are among `joints`."""
        found = {joint: k for k, joint in enumerate(self.joints)}
        return np.array([[found.get(joint, 0) for joint in row] for row in self._chains[0].tolist()])

    def poses(self, place: Floats, turn: Floats, turns: Floats) -> LegPoses:
        """Forward kinematics.

        Args:
            place: (T, 3) [m] the root.
            turn: (T, 4) its frame in the world.
            turns: (T, N, 4) `joints` in their parents' frames.
        """
        _, offsets, still, (hip, knee, ankle, toe) = self._chains
        joints = self._among
        count, legs = len(place), joints.shape[1]
        local = rotation.to_matrix(turns[:, joints])  # (T, D, L, 3, 3)
        if still.any():
            local[:, still] = np.eye(3)
        frame = rotation.to_matrix(turn)[:, None]
        at = place[:, None]
        frames, places = [np.broadcast_to(frame, (count, legs, 3, 3))], [np.broadcast_to(at, (count, legs, 3))]
        for d in range(len(joints)):
            at = at + (frame @ offsets[d][..., None])[..., 0]
            frame = frame @ local[:, d]
            places.append(at)
            frames.append(frame)
        heel_at, toe_at = self._soles
        foot = frames[ankle + 1]
        soles, ends = np.empty((count, legs, 2, 3)), np.empty((count, legs, 2, 3, 3))
        soles[:, :, 0] = places[ankle + 1] + (foot @ heel_at[..., None])[..., 0]
        if self.has_toes:
            soles[:, :, 1] = at
        else:
            soles[:, :, 1] = places[ankle + 1] + (foot @ toe_at[..., None])[..., 0]
        ends[:, :, 0], ends[:, :, 1] = foot, frame
        above_toe = frames[toe] if toe > ankle else foot
        return LegPoses(
            places[hip + 1], places[knee + 1], places[ankle + 1], soles, ends, frames[hip], frames[hip + 1],
            frames[knee], frames[knee + 1], frames[ankle], above_toe,
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
        if self.has_toes:
            above_toe = foot @ (_back(pose.foot) @ pose.above_toe)
            parts.append(_back(above_toe) @ toes)
        return rotation.from_matrix(np.concatenate(parts, axis=1))


def reach(pose: LegPoses) -> Floats:
    """(T, L) [m] how far ankles can be from their hips: what the legs are long, or what they were posed at."""
    bones = norm(pose.knee - pose.hip) + norm(pose.ankle - pose.knee)
    return np.maximum(_LONGEST * bones, norm(pose.ankle - pose.hip))


def too_short(line: Floats, limit: Floats, size: float) -> Floats:
    """Tell by how much (...) [m] hips have to come down for ankles, (..., 3) [m] from them, to be within reach.

    Near to the limit the answer is rounded, so that it changes without a kink.
    """
    flat = line[..., 0] ** 2 + line[..., 2] ** 2
    short = -line[..., 1] - np.sqrt(np.maximum(limit**2 - flat, 0.0))
    soft = _SOFT * size
    return np.where(np.abs(short) < soft, (short + soft) ** 2 / (4.0 * soft), np.maximum(short, 0.0))


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
    return np.asarray(_STILL + s * k + c * (k @ k))


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
    return np.asarray(_STILL + k + (k @ k) / np.maximum(1.0 + dot(a, b), 1e-9)[..., None, None])


def turns_between(a: Floats, b: Floats) -> Floats:
    """(..., 3) [rad] rotation vectors of the turns from frames (..., 3, 3) to others, small ones above all."""
    m = b @ _back(a)
    axis = np.empty(m.shape[:-1])
    np.subtract(m[..., 2, 1], m[..., 1, 2], out=axis[..., 0])
    np.subtract(m[..., 0, 2], m[..., 2, 0], out=axis[..., 1])
    np.subtract(m[..., 1, 0], m[..., 0, 1], out=axis[..., 2])
    twice = norm(axis)  # the sine of the angle, twice
    angle = np.arctan2(twice, m[..., 0, 0] + m[..., 1, 1] + m[..., 2, 2] - 1.0)
    axis *= np.where(twice < 2e-9, 0.5, angle / np.maximum(twice, 2e-12))[..., None]
    return axis

"""All legs of a stream together: as captured, and the places of their points in a state.

It corresponds to `enforce.leg` and `enforce.leg_state` for one leg. Arrays have components first, then points, legs and
frames: (3, P, L, F). Windows of a stream are short, so that time depends on the number of operations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.detect.tracks import FootTracks, Tracks
from footfix.enforce.leg import ANKLE, HEEL, LEG, ROOT, TIP, TOE, B, K, LegTracks, Q, W, tip_of
from footfix.motion.clip import Floats, Ints
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Leg
from footfix.stream.arithmetic import cross, exponential, exponential_and_jacobian, rotated, turned
from footfix.stream.knees import knees
from footfix.stream.subskeleton import Subskeleton

POINTS = 4
_LEAST = 1e-300  # [m] of a length by which is divided
_TURNING = np.array([0, 1, 1, 1, 1])  # what turns the ankle, the line, and the points about it, the foot
_VECTORS = ("hip", "ankle", "line", "thigh", "shank", "axis", "toe_hinge", "reach")


@dataclass(frozen=True, eq=False)
class Kinds:
    """Properties of legs that are the same in every frame.

    Args:
        legs: their joints.
        tips: of each leg whether its toes have a tip,
        bends: whether the file can bend them,
        turns: and whether it can turn hip, knee and ankle.
    """

    legs: tuple[Leg, ...]
    tips: tuple[bool, ...]
    bends: tuple[bool, ...]
    turns: tuple[bool, ...]


@dataclass(frozen=True, eq=False)
class Legs:
    """The legs of some frames; a leg without a tip has one at its toe joint.

    Args:
        kinds: what they are like.
        hip, ankle, line, thigh, shank, axis, toe_hinge, reach: (3, L, F) as of `LegTracks`.
        soles: (3, 2, L, F) [m] heel and toe from the ankle.
        tip: (3, L, F) [m] from the toe.
        flexion, least: (L, F) [rad].
    """

    kinds: Kinds
    hip: Floats
    ankle: Floats
    line: Floats
    thigh: Floats
    shank: Floats
    axis: Floats
    toe_hinge: Floats
    reach: Floats
    soles: Floats
    tip: Floats
    flexion: Floats
    least: Floats

    @classmethod
    def of_rows(cls, kinds: Kinds, rows: Floats) -> Legs:
        """Unpack rows (F, C) that `rows` made."""
        table, L = np.ascontiguousarray(rows.T), len(kinds.legs)
        n = table.shape[1]
        vectors = table[: 3 * L * len(_VECTORS)].reshape(len(_VECTORS), 3, L, n)
        at = 3 * L * len(_VECTORS)
        soles, tip = table[at : at + 6 * L].reshape(3, 2, L, n), table[at + 6 * L : at + 9 * L].reshape(3, L, n)
        flexion, least = table[at + 9 * L :].reshape(2, L, n)
        return cls(
            kinds, **dict(zip(_VECTORS, vectors, strict=True)), soles=soles, tip=tip, flexion=flexion, least=least
        )

    def rows(self) -> Floats:
        """Pack all that differs from frame to frame in rows (F, 35 L)."""
        n = self.flexion.shape[1]
        parts = [getattr(self, name) for name in _VECTORS] + [self.soles, self.tip, self.flexion, self.least]
        return np.concatenate([part.reshape(-1, n) for part in parts]).T

    def apart(self) -> tuple[LegTracks, ...]:
        """Split them by leg."""
        found = []
        for k, leg in enumerate(self.kinds.legs):
            points = (self.soles[:, HEEL, k], self.soles[:, TOE, k], self.tip[:, k])
            found.append(LegTracks(
                leg, **{name: getattr(self, name)[:, k] for name in _VECTORS}, flexion=self.flexion[k],
                least=self.least[k], points=points if self.kinds.tips[k] else points[:2], bends=self.kinds.bends[k],
                turns=self.kinds.turns[k],
            ))  # fmt: skip
        return tuple(found)

    def places(self) -> Floats:
        """Get the points (3, P, L, F) [m] as captured."""
        out = np.empty((3, POINTS, *self.flexion.shape))
        out[:, :ANKLE], out[:, ANKLE] = self.soles, 0.0
        np.add(self.soles[:, TOE], self.tip, out=out[:, TIP])
        out += self.ankle[:, None]
        return out

    def frames(self, which: slice) -> Legs:
        """Cut the legs to some frames."""
        names = (*_VECTORS, "soles", "tip", "flexion", "least")
        return Legs(self.kinds, **{name: getattr(self, name)[..., which] for name in names})

    def raised(self, lift: Floats) -> Legs:
        """Raise the legs by (F,) [m]."""
        some = {name: getattr(self, name) for name in (*_VECTORS, "soles", "tip", "flexion", "least")}
        for name in ("hip", "ankle"):
            some[name] = some[name] + np.array([0.0, 1.0, 0.0])[:, None, None] * lift
        return Legs(self.kinds, **some)


class LegMeasurer:
    """Measures the legs of a figure in its pose."""

    def __init__(self, part: Subskeleton, joints: Sequence[int]) -> None:
        """Prepare for a figure, and for poses of some of its joints."""
        rig, known, skeleton = part.known.rig, part.known.legs, part.skeleton
        slot = {joint: k for k, joint in enumerate(joints)}
        toes = [leg.ankle if leg.toe is None else leg.toe for leg in rig.legs]
        tips = [tip_of(skeleton, rig, k) for k in range(len(rig.legs))]
        soles = [
            next(sole for sole in rig.soles if (sole.leg, sole.part) == (k, name))
            for name in ("heel", "toe") for k in range(len(rig.legs))
        ]  # fmt: skip
        self._rig, self._frame = rig, slot[rig.pelvis]
        self._joints = np.array([[slot[joint] for joint in (leg.hip, leg.knee, leg.ankle)] for leg in rig.legs]).T
        self._bases = np.array([slot[sole.joint] for sole in soles])
        held = [rig.held_at(sole) for sole in soles[len(rig.legs) :]]
        self._holds = np.array([slot[joint] for joint, _ in held])
        hips, _, ankles = self._joints
        self._frames: Ints = np.concatenate([hips, ankles, self._bases, self._holds, [slot[toe] for toe in toes]])
        self._vectors = np.concatenate([
            [leg.knee_axis for leg in known], [leg.toe_hinge for leg in known], [sole.offset for sole in soles],
            [offset for _, offset in held], [np.zeros(3) if tip is None else tip for tip in tips],
        ])[:, None]  # fmt: skip
        self._least = np.array([leg.least for leg in known])[:, None]
        rotates = skeleton.rotates
        self.kinds = Kinds(
            rig.legs, tuple(tip is not None for tip in tips),
            tuple(tip is not None and bool(rotates[toe]) for tip, toe in zip(tips, toes, strict=True)),
            tuple(bool(np.all(rotates[[leg.hip, leg.knee, leg.ankle]])) for leg in rig.legs),
        )  # fmt: skip

    def __call__(self, pose: Pose, frame_time: float) -> tuple[Legs, Tracks]:
        """Lay out the legs in a pose of F frames for enforcement, and their feet for detection."""
        L, n = len(self._rig.legs), len(pose.positions)
        places, turns = pose.positions.transpose(2, 1, 0), pose.rotations.transpose(1, 0, 2)
        hip, knee, ankle = places[:, self._joints].swapaxes(0, 1)  # (3, L, F) each
        inside = turned(turns[self._frames], self._vectors).transpose(2, 0, 1)  # (3, 6 L, F)
        usual, hinge, tip = inside[:, :L], inside[:, L : 2 * L], inside[:, 5 * L :]
        soles = (places[:, self._bases] + inside[:, 2 * L : 4 * L]).reshape(3, 2, L, n)
        thigh, shank = knee - hip, ankle - knee
        axis, flexion, reach = knees(thigh, shank, usual)
        line = ankle - hip
        standing = soles.copy()
        standing[:, TOE] = places[:, self._holds] + inside[:, 4 * L : 5 * L]
        legs = Legs(
            self.kinds, hip, ankle, line / np.maximum(np.sqrt(np.add.reduce(line * line, axis=0)), _LEAST), thigh,
            shank, axis, hinge, reach, standing - ankle[:, None], tip, flexion, np.minimum(flexion, self._least),
        )  # fmt: skip
        feet = tuple(
            FootTracks(leg.side, hip[:, k].T, ankle[:, k].T, heel=soles[:, HEEL, k].T, toe=soles[:, TOE, k].T,
                 knee=knee[:, k].T)
            for k, leg in enumerate(self._rig.legs)
        )  # fmt: skip
        return legs, Tracks(pose.positions[:, self._frame], feet, self._rig.leg_length, frame_time)


@dataclass(frozen=True, eq=False)
class LegStates:
    """Points (3, P, L, F) [m] of a state, and their derivatives (L, F, 3 P, 11) by the root and the leg's unknowns."""

    places: Floats
    jacobian: Floats


def own_of(x: Floats) -> Floats:
    """Take the legs' unknowns (8, L, F) of a state (U, F)."""
    return x[ROOT:].reshape(-1, LEG, x.shape[1]).swapaxes(0, 1)


def states_of(legs: Legs, root: Floats, x: Floats) -> LegStates:
    """Compute the points of a state with derivatives: root (3, F) [m], and the legs' unknowns (8, L, F)."""
    vectors = _vectors(legs, x)
    both = exponential_and_jacobian(vectors)
    places, thrust, bent, arms, hinge = _points(legs, root, x[K], both[:, :, 0])
    n = places.shape[2:]
    by = np.empty((3, 1 + POINTS, *n))  # what line and foot turn: the ankle, and the points about it
    by[:, 0], by[:, 1:] = thrust, arms
    swept = cross(both[:, :, 1, _TURNING], by[:, None])  # (3, 3, 5, L, F)
    out = np.zeros((*n, 3, POINTS, ROOT + LEG))
    for c in range(3):
        out[..., c, :, c] = 1.0
    rest = out[..., ROOT:]
    rest[..., Q] = swept[:, :, 0].transpose(2, 3, 0, 1)[..., None, :]
    rest[..., K] = bent.transpose(1, 2, 0)[..., None]
    rest[..., W] = swept[:, :, 1:].transpose(3, 4, 0, 2, 1)
    rest[..., TIP, B] = hinge.transpose(1, 2, 0)
    return LegStates(places, out.reshape(*n, 3 * POINTS, ROOT + LEG))


def places_of(legs: Legs, root: Floats, x: Floats) -> Floats:
    """Compute the points (3, P, L, F) [m] of a state: root (3, F) [m], and the legs' unknowns (8, L, F)."""
    return _points(legs, root, x[K], exponential(_vectors(legs, x)))[0]


def _vectors(legs: Legs, x: Floats) -> Floats:
    """Compute the rotation vectors (3, 3, L, F) [rad] of line, foot and toes in a state."""
    out = np.empty((3, 3, *legs.flexion.shape))
    out[:, 0], out[:, 1] = x[Q], x[W]
    np.multiply(x[B], legs.toe_hinge, out=out[:, 2])
    return out


def _points(legs: Legs, root: Floats, k: Floats, turn: Floats) -> tuple[Floats, ...]:
    """Work out points (3, P, L, F) [m], and what their derivatives are made of.

    Besides the points: from hip to ankle, and its change by the knee's flexion (3, L, F); arms from the ankle to the
    points (3, P, L, F); the tip's change as toes bend (3, L, F).

    Args:
        legs: as captured.
        root: (3, F) [m].
        k: (L, F) [rad] by how much knees bend.
        turn: (3, 3, 3, L, F) matrices of line, foot and toes.
    """
    c0, c1, c2 = legs.reach
    cos, sin = np.cos(k), np.sin(k)
    distance = np.sqrt(np.maximum(c0 + c1 * cos + c2 * sin, 1e-12))
    line = rotated(turn[:, :, 0], legs.line)
    thrust, bent = line * distance, line * ((c2 * cos - c1 * sin) / (2.0 * distance))
    in_foot = np.empty((3, 4, *k.shape))
    in_foot[:, :2], in_foot[:, 2], in_foot[:, 3] = legs.soles, legs.toe_hinge, rotated(turn[:, :, 2], legs.tip)
    by_foot = rotated(turn[:, :, 1, None], in_foot)
    arms = np.empty((3, POINTS, *k.shape))
    arms[:, :2], arms[:, 2], arms[:, TIP] = by_foot[:, :2], 0.0, by_foot[:, TOE] + by_foot[:, 3]
    places = (legs.hip + root[:, None] + thrust)[:, None] + arms
    return places, thrust, bent, arms, cross(by_foot[:, 2], by_foot[:, 3])

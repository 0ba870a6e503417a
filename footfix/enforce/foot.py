"""A leg and its foot as captured: the tracks that targets and solvers work on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from footfix.motion import rotation
from footfix.motion.clip import Clip, Floats, Ints, some
from footfix.motion.kinematics import Pose, forward
from footfix.motion.vectors import norm
from footfix.rig.rig import Leg, Rig


@dataclass(frozen=True, eq=False)
class Foot:
    """One leg as captured, all in the world.

    Args:
        leg: its joints.
        effectors: indices of its heel and its ball among `Rig.soles`.
        hip, knee, ankle: (F, 3) [m] tracks of the joints.
        turn: (F, 4) the ankle's frame.
        heel, ball: (F, 3) [m] tracks of the sole points.
        heel_in_foot, ball_in_foot: (F, 3) [m] the sole points in the ankle's frame. The ball moves in it
            when the toe joint bends.
    """

    leg: Leg
    effectors: tuple[int, int]
    hip: Floats
    knee: Floats
    ankle: Floats
    turn: Floats
    heel: Floats
    ball: Floats
    heel_in_foot: Floats
    ball_in_foot: Floats

    def __len__(self) -> int:
        return len(self.ankle)

    def frames(self, which: Ints) -> Foot:
        """The leg in some frames only."""
        return Foot(self.leg, self.effectors, *(some(getattr(self, name), which) for name in _TRACKS))

    @property
    def length(self) -> Floats:
        """(F,) [m] of thigh and shank together."""
        return norm(self.knee - self.hip) + norm(self.ankle - self.knee)

    def point(self, part: str) -> Floats:
        """(F, 3) [m] track of "heel" or "toe"."""
        return self.heel if part == "heel" else self.ball


_TRACKS = ("hip", "knee", "ankle", "turn", "heel", "ball", "heel_in_foot", "ball_in_foot")


def feet(rig: Rig, pose: Pose) -> tuple[Foot, ...]:
    """The legs of a rig as posed, in the order of the rig."""
    tracks = rig.tracks(pose)
    found = []
    for k, leg in enumerate(rig.legs):
        heel = next(e for e, sole in enumerate(rig.soles) if sole.leg == k and sole.part == "heel")
        ball = next(e for e, sole in enumerate(rig.soles) if sole.leg == k and sole.part == "toe")
        ankle, turn = pose.position(leg.ankle), pose.rotation(leg.ankle)
        back = rotation.inverse(turn)
        found.append(
            Foot(
                leg=leg,
                effectors=(heel, ball),
                hip=pose.position(leg.hip),
                knee=pose.position(leg.knee),
                ankle=ankle,
                turn=turn,
                heel=tracks[heel],
                ball=tracks[ball],
                heel_in_foot=rotation.rotate(back, tracks[heel] - ankle),
                ball_in_foot=rotation.rotate(back, tracks[ball] - ankle),
            )
        )
    return tuple(found)


def posed(clip: Clip, rig: Rig) -> Pose:
    """Forward kinematics of all that enforcement looks at: the rig's joints and what its legs hang from."""
    joints = set(rig.joints())
    for leg in rig.legs:
        hinged = [leg.hip, leg.knee, leg.ankle] + ([] if leg.toe is None else [leg.toe])
        joints.update(int(clip.skeleton.parents[joint]) for joint in hinged)
    return forward(clip, sorted(joints - {-1}))


def can_turn(clip: Clip, leg: Leg) -> bool:
    """Whether the file can animate what inverse kinematics has to turn: hip, knee and ankle."""
    return bool(np.all(clip.skeleton.rotates[[leg.hip, leg.knee, leg.ankle]]))

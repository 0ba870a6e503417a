"""The input of all detectors: tracks of sole points, hips and pelvis over the motion range."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.kinematics import Pose
from footfix.notes import Note
from footfix.rig.foot_mesh import FootMesh
from footfix.rig.rig import Rig

GRAVITY = 9.81  # [m/s^2]


@dataclass(frozen=True, eq=False)
class FootTracks:
    """One foot over time.

    Args:
        side: "left", "right", or the leg's own name.
        hip, ankle, heel, toe: (F, 3) [m] tracks in the world, y up.
        knee: the same; None where detectors do not need it.
        mesh: (V, F, 3) [m] tracks of the vertices of its sole, for detectors that use them.
        of_toe: (V,) which of these belong to the toe, the others to the heel.
    """

    side: str
    hip: Floats
    ankle: Floats
    heel: Floats
    toe: Floats
    knee: Floats | None = None
    mesh: Floats | None = None
    of_toe: Bools | None = None

    @property
    def soles(self) -> tuple[Floats, Floats]:
        """Get the tracks of heel and toe."""
        return self.heel, self.toe


@dataclass(frozen=True, eq=False)
class Tracks:
    """The input of detectors.

    Args:
        pelvis: (F, 3) [m] track of the joint the legs hang from.
        feet: in the order of the rig's legs.
        leg_length: [m].
        frame_time: [s].
    """

    pelvis: Floats
    feet: tuple[FootTracks, ...]
    leg_length: float
    frame_time: float

    def __len__(self) -> int:
        return len(self.pelvis)

    @property
    def froude_speed(self) -> float:
        """Compute sqrt(g l) [m/s]; walking speeds of large and small figures are alike in this unit."""
        return float(np.sqrt(GRAVITY * self.leg_length))


class Finding(NamedTuple):
    """The result of a detector: for each foot heel, then toe, in the order of the rig's legs."""

    mask: Bools  # (F, 2 legs)
    confidence: Floats | None = None  # (F, 2 legs), averaged over each contact
    notes: tuple[Note, ...] = ()


def tracks_of(
    clip: Clip, rig: Rig, pose: Pose | None = None, *, mesh: bool = False, watched: bool = False
) -> Tracks:  # fmt: skip
    """Compute the tracks of a clip by forward kinematics (or from a pose that is already known).

    Args:
        clip: in metres, y up.
        rig: its legs and soles.
        pose: of the clip, where it is already known.
        mesh: whether to track the vertices of soles, too, where the rig has some.
        watched: whether heel and toe are those of `rig.watched`.
    """
    pose = rig.pose(clip) if pose is None else pose
    points = (rig.watched or rig.soles) if watched else rig.soles
    soles = {(sole.leg, sole.part): pose.point(sole.joint, np.array(sole.offset)) for sole in points}
    meshes = {each.leg: each for each in rig.meshes if mesh and each.sole.any()}
    feet = tuple(
        FootTracks(
            leg.side,
            pose.position(leg.hip),
            pose.position(leg.ankle),
            heel=soles[k, "heel"],
            toe=soles[k, "toe"],
            knee=pose.position(leg.knee),
            **(_of_mesh(meshes[k], pose) if k in meshes else {}),
        )
        for k, leg in enumerate(rig.legs)
    )
    return Tracks(pose.position(rig.pelvis), feet, rig.leg_length, clip.frame_time)


def _of_mesh(mesh: FootMesh, pose: Pose) -> dict[str, Any]:
    sole = np.flatnonzero(mesh.sole)
    return {"mesh": mesh.tracks(pose, sole).transpose(1, 0, 2), "of_toe": mesh.toe[sole]}

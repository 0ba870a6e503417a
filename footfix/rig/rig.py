"""Rig: the legs and soles of a skeleton, its size and its floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from footfix.motion.clip import Clip, Floats
from footfix.motion.contacts import Contacts, Effector, Part
from footfix.motion.kinematics import Pose, forward
from footfix.notes import Note
from footfix.rig.foot_mesh import FootMesh


@dataclass(frozen=True)
class Leg:
    """One leg, by joint index.

    Args:
        name: "left", "right", or the config's own name ("front_left").
        side: "left" or "right"; the name on figures where sides mean nothing.
        hip, knee, ankle: the joints at the top of the thigh, at the knee and at the ankle.
        toe: the joint at the ball of the foot, None where the skeleton has none.
        chain: every joint from hip to ankle, both included: (hip, knee, ankle) on a plain leg, more with
            twist bones or on animal legs.
    """

    name: str
    side: str
    hip: int
    knee: int
    ankle: int
    toe: int | None
    chain: tuple[int, ...]


@dataclass(frozen=True)
class SolePoint:
    """A point of the sole, fixed in the frame of a joint of the foot.

    Args:
        name: leg name and part, `left_heel`.
        leg: index into `Rig.legs`.
        part: "heel", or "toe" (the ball of the foot).
        joint: the joint it is fixed to.
        offset: (x, y, z) [m] in that joint's frame.
        held: (x, y, z) [m] in that joint's frame, of a toe's point on a foot without toe joint: where that joint would
            be. None where plants hold a toe joint, or this very point.
    """

    name: str
    leg: int
    part: Part
    joint: int
    offset: tuple[float, float, float]
    held: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Rig:
    """The legs and soles of one figure, its size and its floor. A file may hold several figures.

    Args:
        root: the joint that carries the figure's travel through the world.
        pelvis: the joint the legs hang from.
        legs: left before right on a biped.
        soles: for each leg its heel, then its toe.
        leg_length: [m] from hip joint to ankle along the bones, mean of the legs.
        floor: [m] height of the floor: the file's zero plane, or the lowest level that the feet often rest on.
        notes: how each of these was estimated, and what is doubtful.
        origins: where each was found.
        meshes: of each leg the foot of a character's skin, where one was given.
        watched: `soles` as detectors use them: for legs that stand on their toes, estimated as without a skin. Empty
            without a skin.
    """

    root: int
    pelvis: int
    legs: tuple[Leg, ...]
    soles: tuple[SolePoint, ...]
    leg_length: float
    floor: float
    notes: tuple[Note, ...] = ()
    origins: Mapping[str, str] = field(default_factory=dict)
    meshes: tuple[FootMesh, ...] = ()
    watched: tuple[SolePoint, ...] = ()

    def of_figure(self, number: int) -> Rig:
        """Name legs and soles for one of several figures (`figure2_left_heel`); the first keeps its names."""
        if number < 2:
            return self
        legs = tuple(replace(leg, name=f"figure{number}_{leg.name}") for leg in self.legs)
        soles = tuple(replace(sole, name=f"figure{number}_{sole.name}") for sole in self.soles)
        return replace(self, legs=legs, soles=soles)

    def joints(self) -> tuple[int, ...]:
        """List the joints that later steps need: root, pelvis, leg chains, toes, and joints that carry sole points."""
        wanted = {self.root, self.pelvis}
        for leg in self.legs:
            wanted.update(leg.chain)
            if leg.toe is not None:
                wanted.add(leg.toe)
        wanted.update(sole.joint for sole in self.soles)
        wanted.update(joint for mesh in self.meshes for joint in mesh.carriers)
        return tuple(sorted(wanted))

    def pose(self, clip: Clip) -> Pose:
        """Compute forward kinematics of `joints()` and all joints above them, whose frames turn the legs."""
        return forward(clip, clip.skeleton.with_ancestors(self.joints()))

    def tracks(self, pose: Pose) -> tuple[Floats, ...]:
        """Compute for each sole point its (F, 3) [m] track in the world."""
        return tuple(pose.point(sole.joint, np.array(sole.offset)) for sole in self.soles)

    def held_at(self, sole: SolePoint) -> tuple[int, Floats]:
        """Tell what a plant holds: the joint it is fixed to, and where it is in that joint's frame (3,) [m].

        It is the sole point of the heel, and the toe *joint* (G §4: "ankle and metatarsal joints"), since the skin of
        the toes is bound to that; where a foot has no toe joint, the place where it would be. The sole point below that
        moves by its depth times the sine of the foot's pitch as the heel rises, although the foot stands.
        """
        toe = self.legs[sole.leg].toe
        if sole.part == "toe" and toe is not None:
            return toe, np.zeros(3)
        return sole.joint, np.array(sole.offset if sole.held is None else sole.held)

    def held(self, pose: Pose) -> tuple[Floats, ...]:
        """Track what a plant holds, for each sole point (F, 3) [m] in the world."""
        return tuple(pose.point(*self.held_at(sole)) for sole in self.soles)

    def held_height(self, sole: SolePoint) -> float:
        """Get the height [m] of what a plant holds over the floor while its sole point is on it."""
        return float(np.linalg.norm(np.array(sole.offset) - self.held_at(sole)[1]))

    def mesh_of(self, sole: SolePoint) -> FootMesh | None:
        """Get the mesh of the foot of a sole point; None where no skin was given."""
        return next((mesh for mesh in self.meshes if mesh.leg == sole.leg), None)

    def lowest(self, pose: Pose) -> tuple[Floats, ...]:
        """Compute for each sole point the height (F,) [m] of the lowest vertex of its part of the foot.

        Without a mesh it is the height of the sole point itself.
        """
        found = []
        for sole, track in zip(self.soles, self.tracks(pose), strict=True):
            mesh = self.mesh_of(sole)
            part = None if mesh is None else mesh.toe == (sole.part == "toe")
            if mesh is None or part is None or not part.any():
                found.append(np.asarray(track[:, 1]))
            else:
                found.append(mesh.lowest(pose, part))
        return tuple(found)

    def no_contacts(self, clip: Clip) -> Contacts:
        """Make the effectors of this rig, nothing in contact."""
        names = clip.skeleton.names
        effectors = tuple(
            Effector(sole.name, self.legs[sole.leg].side, sole.part, names[sole.joint]) for sole in self.soles
        )
        return Contacts(len(clip), clip.frame_time, effectors)


def joined(rigs: Sequence[Rig]) -> Rig:
    """Join the legs and soles of several rigs; root, size and floor are the first one's."""
    first, *others = rigs
    legs, soles, meshes = first.legs, first.soles, first.meshes
    for rig in others:
        meshes += tuple(replace(mesh, leg=mesh.leg + len(legs)) for mesh in rig.meshes)
        soles += tuple(replace(sole, leg=sole.leg + len(legs)) for sole in rig.soles)
        legs += rig.legs
    return replace(first, legs=legs, soles=soles, meshes=meshes) if others else first

"""The input of the solvers: legs as captured, footplants, their floors and the ground."""

from __future__ import annotations

from dataclasses import dataclass

from footfix.enforce import ground as grounds
from footfix.enforce import mesh_floor as meshes
from footfix.enforce.footing import Footing
from footfix.enforce.footplant import footplants, given
from footfix.enforce.ground import GroundParams
from footfix.enforce.leg import LegCalibration, LegTracks, calibrate, raise_leg, tracks
from footfix.enforce.params import EnforceParams
from footfix.enforce.plant_faults import kept
from footfix.enforce.standing_heights import floors as floors_of
from footfix.enforce.standing_heights import lacks
from footfix.enforce.style import styled
from footfix.motion.clip import Clip, Floats, Skeleton
from footfix.motion.contacts import Contacts
from footfix.motion.kinematics import Pose, forward
from footfix.notes import Note
from footfix.rig.rig import Rig


@dataclass(frozen=True, eq=False)
class Task:
    """The input of the solvers for one clip.

    Args:
        pose: of the clip, from `pose_of`.
        calibration: what was measured of each leg on the whole clip.
        legs: as captured, raised by `lift`.
        footing: the plants and their floors.
        lift: [m] by which the whole figure is raised.
        notes: for the user.
    """

    pose: Pose
    calibration: tuple[LegCalibration, ...]
    legs: tuple[LegTracks, ...]
    footing: Footing
    lift: float
    notes: tuple[Note, ...]


def pose_of(clip: Clip, rig: Rig) -> Pose:
    """Compute forward kinematics of all joints that enforcement needs."""
    return forward(clip, posed_joints(clip.skeleton, rig))


def posed_joints(skeleton: Skeleton, rig: Rig) -> tuple[int, ...]:
    """List the joints that enforcement needs: the rig's, and those its legs hang from."""
    joints = set(rig.joints())
    for leg in rig.legs:
        hinged = [leg.hip, leg.knee, leg.ankle] + ([] if leg.toe is None else [leg.toe])
        joints.update(int(skeleton.parents[joint]) for joint in hinged)
    return tuple(sorted(joints - {-1}))


def ground_of(clip: Clip, rig: Rig, contacts: Contacts, params: GroundParams) -> Floats:
    """Find the intended motion of the ground under planted feet (a belt), (F, 3) [m]; zeros on a floor at rest."""
    return grounds.belt(rig, rig.pose(clip), contacts, clip.frame_time, params)


def task_of(clip: Clip, rig: Rig, contacts: Contacts, params: EnforceParams) -> Task:
    """Make the task of a clip of F frames from its contacts."""
    pose = pose_of(clip, rig)
    calibration = calibrate(rig, pose, clip)
    legs = tracks(clip, rig, pose, calibration)
    plants, notes = footplants(contacts, rig, legs, params.pins.asked)
    ground = grounds.belt(rig, pose, contacts, clip.frame_time, params.ground)
    notes += grounds.belt_notes(ground, clip.frame_time)
    lift = 0.0
    if params.heights == "floor" and params.method != "root" and clip.skeleton.translates[rig.root]:
        lift = grounds.lift(lacks(plants, legs, rig), rig.leg_length, params.ground)
    if lift:
        legs = tuple(raise_leg(leg, lift) for leg in legs)
        text = f"the whole figure is {'raised' if lift > 0 else 'lowered'} by {1000.0 * abs(lift):.0f} mm to its floor"
        notes += (Note("height-moved", text),)
    floors = floors_of(plants, legs, rig, params.pins.near * rig.leg_length)
    plants = styled(plants, legs, rig, floors, params.style)
    by_hand = tuple(given(contacts, plant) for plant in plants)
    keep = kept(
        plants, legs, ground, floors, clip.frame_time, rig.leg_length,
        heights=params.heights == "floor", params=params.pins, noticed=params.costs.noticed, by_hand=by_hand,
    )  # fmt: skip
    if rig.meshes and params.heights == "floor":
        deep = meshes.sunk(plants, rig, pose, lift, floors, params.pins.near * rig.leg_length)
        keep = tuple(stays and not sinks for stays, sinks in zip(keep, deep.tolist(), strict=True))
    return Task(pose, calibration, legs, Footing(plants, floors, ground, keep, by_hand), lift, notes)

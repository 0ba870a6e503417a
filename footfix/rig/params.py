"""What a user can say about a rig in place of letting it be found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class LegParams:
    """One leg, by joint names.

    Args:
        hip, knee, ankle: names of the joints at the top of the thigh, at the knee and at the ankle. Either
            all three, or the ankle alone: then hip and knee are found above it.
        toe: name of the joint at the ball of the foot; "" lets it be found, "none" says there is none.
        side: "left", "right", or "" to take it from the leg's name or the geometry.
    """

    hip: str = ""  # joint at the top of the thigh
    knee: str = ""  # joint at the knee
    ankle: str = ""  # joint at the ankle
    toe: str = ""  # joint at the ball of the foot; "none": there is none
    side: str = ""  # left, right, or "" to find out


@dataclass(frozen=True, kw_only=True)
class SoleParams:
    """One sole point.

    Args:
        joint: name of the joint it is fixed to; "" keeps the one that was found.
        offset: (x, y, z) [m] in that joint's frame of the clip turned y up.
    """

    joint: str = ""  # joint it moves with; "" keeps the found one
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)  # place in that joint's frame, in metres, y up


@dataclass(frozen=True, kw_only=True)
class RigParams:
    """Everything about the rig that can be set. What is not set is found in the clip.

    Joint names are compared without the namespace (`mixamorig:`) and without case where that is unique.

    Args:
        unit_m: metres per unit of the file.
        up: the file's up axis: "y", "z", "x", "-y", "-z", "-x".
        floor: height of the floor [m], y up.
        root: the joint that carries the figure through the world.
        legs: leg name -> its joints. Given legs replace the found ones, any number of them.
        soles: sole point name (`left_heel`) -> its place.
    """

    unit_m: float | None = None  # metres per unit of the file; none: from the leg's length
    up: str | None = None  # the file's up axis; none: from the motion
    floor: float | None = None  # [m] height of the floor; none: where the soles rest most
    root: str | None = None  # name of the joint that carries the travel; none: found
    legs: Mapping[str, LegParams] = field(default_factory=dict)  # none: found
    soles: Mapping[str, SoleParams] = field(default_factory=dict)  # none: found

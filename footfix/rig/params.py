"""Parameters of a rig: what a user may set; the rest is found in the clip."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

NO_SKIN = "none"  # in place of a file: soles are estimated, whatever mesh there is


@dataclass(frozen=True, kw_only=True)
class LegParams:
    """One leg, by joint names.

    Args:
        hip, knee: the joints at the top of the thigh and at the knee; "" lets them be found above the ankle.
        ankle: the joint at the ankle, where the shin ends.
        toe: the joint at the ball of the foot; "" lets it be found, "none" says that there is none.
        side: "left", "right", or "" to take it from the leg's name or else its place.
    """

    hip: str = ""  # joint at the top of the thigh; "": found
    knee: str = ""  # joint at the knee; "": found
    ankle: str = ""  # joint at the ankle
    toe: str = ""  # joint at the ball of the foot; "": found; "none": there is none
    side: str = ""  # left or right; "": from the leg's name, or else its place


@dataclass(frozen=True, kw_only=True)
class SoleParams:
    """One sole point.

    Args:
        joint: the joint it moves with; "" keeps the one that was found.
        offset: (x, y, z) [m] from that joint, in that joint's frame.
    """

    joint: str = ""  # joint it moves with; "": the one found
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [m] from that joint, in its frame


@dataclass(frozen=True, kw_only=True)
class RigParams:
    """Everything about a rig that can be set. What is not set is found in the clip.

    Joints are given by name. A name may leave out its namespace (`mixamorig:`) and need not mind case, as long
    as it is still the name of one joint only.

    Args:
        unit_m: length of one unit of the file; found from the length of the legs where it is not set [m].
        up: the file's up axis, "y", "z", "x", "-y", "-z" or "-x"; found from the motion where it is not set.
        floor: height of the floor [m], with y up; "zero" takes the file's zero plane, wherever the feet are.
        root: the joint that carries the figure through the world; found where it is not set.
        legs: leg name -> its joints. Given legs replace the found ones; there may be any number.
        soles: sole point name (`left_heel`) -> its place; the others are found.
        skin: a glTF file of the character whose feet these are (its own, or one it will be shown with): the soles are
            taken from its mesh. A glTF clip that shows a mesh takes its own where none is named; "none" estimates.
    """

    unit_m: float | None = None  # metres per unit of the file; none: from the length of the legs
    up: Literal["y", "z", "x", "-y", "-z", "-x"] | None = None  # up axis of the file; none: from the motion
    floor: float | Literal["zero"] | None = None  # [m] height of the floor; zero: the file's own; none: found
    root: str | None = None  # joint that carries the travel; none: found
    legs: Mapping[str, LegParams] = field(default_factory=dict)  # leg name -> joints; none: found
    soles: Mapping[str, SoleParams] = field(default_factory=dict)  # sole point name -> place; none: found
    skin: str | None = None  # glTF file whose mesh has the soles; not set: a glTF clip's own; "none": estimated

"""Parameters of walks that follow a path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class FollowParams:
    """How captured walks follow a path.

    Args:
        speed: factor on the captured speed, shared by stride time and stride length [times].
        speed_to: speed of every walk; None for the captured one [m/s].
        seconds: duration; None for as long as the path takes [s].
        stride: whether strides, and so the speed, are shorter where the path is curved.
        lean: whether the figure leans into curves.
        head: share of the lean that the head compensates, 1 for a level head [share].
        on_path: what stays on the path in curves: "root", with footsteps farther outwards, or "feet".
        shrink: reduction of a stride where the path turns by a radian per leg length [share].
        shortest: shortest stride, however curved the path is, relative to the captured one [share].
        stance_turn: greatest turn of the path during one stance; sharper kinks are rounded [degrees].
        kink: turn at a point of the path from which it is a corner, not part of a curve [degrees].
        unit: unit of the points of a path read from a file [m].
        shortest_blend: shortest blend from one walk to another [s].
        longest_blend: longest blend from one walk to another [strides].
    """

    speed: float = 1.0
    speed_to: float | None = None
    seconds: float | None = None
    stride: bool = True
    lean: bool = True
    head: float = 1.0
    on_path: Literal["root", "feet"] = "root"
    shrink: float = 0.28
    shortest: float = 0.5
    stance_turn: float = 50.0
    kink: float = 45.0
    unit: float = 1.0
    shortest_blend: float = 0.2
    longest_blend: float = 2.0

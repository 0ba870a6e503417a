"""What can be asked of walks that follow a path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class FollowParams:
    """How captured walks are led along a path.

    Args:
        speed: times as fast as captured; the time of a stride and its length share it [times].
        speed_to: of every walk; None for the captured one [m/s].
        seconds: how long; None for as long as the path takes [s].
        stride: whether strides, and so speed, shrink where the path is curved.
        lean: whether the figure leans into curves.
        head: how much of the lean the head takes back, 1 for a level head [share].
        on_path: what keeps to the path: "root", while feet step outwards by what the figure leans, or "feet".
        shrink: of a stride by so much, where a leg length is turned by a radian [share].
        shortest: of a stride, however curved the path is [share].
        stance_turn: by which the path may turn at most while a foot stands; sharper kinks are rounded [degrees].
        kink: at which points of a path count as a corner, not as points of a curve [degrees].
        unit: of the points of a path that is read [m].
        shortest_blend: from one walk to another [s].
        longest_blend: from one walk to another [strides].
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

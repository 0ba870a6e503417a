"""Parameters of a loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class LoopParams:
    """How a loop is cut out of a walk and closed.

    Args:
        method: "offset" fades the gap at the seam out from both ends; "kim-neff" blends across the seam, as K 5.2.
        strides: number of strides in the loop; None for as few as represent the style of the walk [strides].
        most_strides: greatest number of strides tried where `strides` is None [strides].
        start, end: first and last frame of the loop in the clip; None for the best. The last frame has the pose of the
            first [frames].
        in_place: whether travel and turn are removed.
        open: whether the last frame, which repeats the first, is left out.
        straighten: whether the mean turn of a round is removed, so that the loop walks straight.
        blend: time at each end over which the gap fades out [s].
        window: time before and after a frame in which poses are compared [s].
        farthest: greatest difference of the two end poses, root mean square over the joints [leg lengths].
        style: greatest difference of the clip's strides from those of the loop, root mean square over the joints, at
            which the loop represents them [leg lengths].
    """

    method: Literal["offset", "kim-neff"] = "offset"
    strides: int | None = None
    most_strides: int = 4
    start: int | None = None
    end: int | None = None
    in_place: bool = False
    open: bool = False
    straighten: bool = False
    blend: float = 0.3
    window: float = 0.1
    farthest: float = 0.11
    style: float = 0.07

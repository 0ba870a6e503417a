"""What can be asked of a loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class LoopParams:
    """How a loop is cut out of a walk, and closed.

    Args:
        method: "offset" lets the gap at the seam decay from both ends; "kim-neff" blends across the seam, as K 5.2.
        strides: of one round; None for as few as the style of the walk needs [strides].
        most_strides: the most that are tried where `strides` is None [strides].
        start, end: which of the clip become the first and the last one; None for the best. The last frame has the
            pose of the first [frames].
        in_place: whether travel and turn are taken out.
        open: whether the last frame, which repeats the first, is left out.
        straighten: whether the mean turn of a round is taken out.
        blend: time at either end, over which the gap decays [s].
        window: time before and after a frame, of which the poses are compared [s].
        farthest: poses that differ by more, as root mean square over the joints, are no cycle [leg lengths].
        style: strides that differ by less from those of the loop, as root mean square over the joints, are told well
            enough by it [leg lengths].
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

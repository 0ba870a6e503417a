"""Parameters of footplant enforcement, for all of its steps."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from footfix.enforce.costs import CostParams
from footfix.enforce.ground import GroundParams
from footfix.enforce.papers.glardon import GlardonParams
from footfix.enforce.papers.kim_neff import KimNeffParams
from footfix.enforce.papers.lyard import LyardRootParams
from footfix.enforce.pins import PinParams
from footfix.enforce.style import StyleParams


@dataclass(frozen=True, kw_only=True)
class EnforceParams:
    """How footplants are enforced.

    Args:
        method: "ik" bends the legs, "root" moves the root alone, "both" moves the root by what planted feet have in
            common and bends the legs for the rest.
        solver: "whole_clip" is one least-squares problem, "glardon" and "kim_neff" are the methods of these papers.
        cycle: whether the clip is a cycle, whose last frame leads to its first: "find", "yes" or "no"; "likely" also
            accepts ends that nearly meet, in place, as in game animations. For glTF files "find" means "likely".
        heights: "floor" moves plants to their floor, "keep" leaves them at their captured height.
        strength: how much of the correction is applied, 0 to 1 [share].
        pins: when a plant is corrected, and how firmly its points are held.
        costs: the cost of each change to the capture.
        ground: treadmill belts, and figures that float above the floor or sink into it.
        style: changes to how planted feet stand.
        glardon: parameters of the solver "glardon".
        kim_neff: parameters of the solver "kim_neff".
        root: parameters of the method "root".
    """

    method: Literal["ik", "root", "both"] = "ik"
    solver: Literal["whole_clip", "glardon", "kim_neff"] = "whole_clip"
    cycle: Literal["find", "likely", "yes", "no"] = "find"
    heights: Literal["floor", "keep"] = "floor"
    strength: float = 1.0
    pins: PinParams = field(default_factory=PinParams)
    costs: CostParams = field(default_factory=CostParams)
    ground: GroundParams = field(default_factory=GroundParams)
    style: StyleParams = field(default_factory=StyleParams)
    glardon: GlardonParams = field(default_factory=GlardonParams)
    kim_neff: KimNeffParams = field(default_factory=KimNeffParams)
    root: LyardRootParams = field(default_factory=LyardRootParams)

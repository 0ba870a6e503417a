"""How footplants are enforced: the parameters of all of its steps."""

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
        method: "ik" bends the legs, "root" moves the root alone, "both" gives the root what planted feet share and
            the legs the rest.
        solver: "whole_clip" is one least squares, "glardon" and "kim_neff" the papers' own ways.
        cycle: whether the last frame leads to the first, over a closed seam: "find", "yes" or "no"; "likely" is content
            with ends that nearly meet, in place, as in animations of games. For glTF files "find" means that.
        heights: "floor" draws plants to their floor, "keep" leaves them the height they have.
        strength: how much of the correction is applied, 0 to 1 [share].
        pins: when a plant is corrected, and what of it is held.
        costs: what each departure from the capture costs.
        ground: belts, and figures that float or are sunk.
        style: how planted feet stand otherwise than captured.
        glardon: the solver of that name.
        kim_neff: the solver of that name.
        root: method "root".
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

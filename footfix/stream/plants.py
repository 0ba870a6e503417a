"""Plants of a stream: which points are planted now, and their final places."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from footfix.enforce.easing import gamma
from footfix.enforce.leg import ANKLE, HEEL, TOE
from footfix.enforce.standing_heights import height
from footfix.motion.clip import Bools, Floats, Ints
from footfix.stream.arithmetic import median

STANDING = (HEEL, TOE, ANKLE)  # the points that have plants; the ankle stands while heel and toe do
_SETTLES = 0.2  # [s] over which a plant comes down to its floor
_STRAYS = 0.5  # [leg lengths] a foot whose capture is farther than this from its place is released
_LANDS = 0.1  # [s] no plant is released before this
_SLIPS = 0.005  # [leg lengths] a plant that slips farther is released, too


@dataclass(frozen=True, kw_only=True)
class Ground:
    """What plants stand on.

    Args:
        rest: (legs, 2) [m] usual height of heel and toe while planted.
        nominal: (legs, 2) [m] height at which their soles are on the rig's floor.
        tips: (legs,) [m] usual height of the toes' tips in a flat foot.
        near: [m] a plant within this distance of the floor stands on it.
        sink: [m] greatest depth of a point below the floor.
        leg_length: [m].
        frame_time: [s].
        heights: whether plants are moved to their floor.
    """

    rest: Floats
    nominal: Floats
    tips: Floats
    near: float
    sink: float
    leg_length: float
    frame_time: float
    heights: bool

    def level(self, own: Floats, leg: int, point: int) -> float:
        """Compute the height [m] at which a point stands that was captured at heights (n,)."""
        usual = float(median(own))
        if point == ANKLE:
            return usual
        return height(usual, float(self.rest[leg, point]), float(self.nominal[leg, point]), self.near)

    def step(self, level: float, leg: int, point: int) -> float:
        """Compute how much higher than the rig's the floor is under a point that stands at a level [m]."""
        up = level - float(self.rest[leg, point])
        return up if abs(up) >= self.near else 0.0


@dataclass(frozen=True, eq=False)
class Plant:
    """A planted point of a foot.

    Args:
        start: number of its first frame.
        level: [m] its final height.
        belt: (3,) [m] that its ground moves in a frame.
        place: (3,) [m] its place in frame `at`, once that was shown; None while it is landing.
        at: number of that frame.
        free: whether it was released.
    """

    start: int
    level: float
    belt: Floats
    place: Floats | None = None
    at: int = 0
    free: bool = False

    def places(self, frames: Ints, frame_time: float) -> Floats:
        """Compute its places (3, n) [m] in some frames; its height eases to its level once (G eq. 10, 11)."""
        assert self.place is not None
        gone = frames - self.at
        out = self.place[:, None] + self.belt[:, None] * gone
        if gone[0] * frame_time >= _SETTLES:  # it has reached its level
            out[1] = self.level
        else:
            fall = gamma(np.asarray(gone * frame_time / _SETTLES, dtype=np.float64))
            out[1] = fall * self.place[1] + (1.0 - fall) * self.level
        return np.asarray(out)

    def off(self, point: Floats, frame: int) -> float:
        """Measure how far a point (3,) is from its place in a frame, over the ground [m]."""
        assert self.place is not None
        (x, _, z), (px, _, pz), (bx, _, bz) = point.tolist(), self.place.tolist(), self.belt.tolist()
        gone = frame - self.at
        return hypot(x - px - gone * bx, z - pz - gone * bz)


@dataclass(frozen=True, eq=False)
class FootPlants:
    """The plants of one foot in a stream.

    Args:
        plants: of heel, toe and ankle; None where one does not stand.
        step: [m] how much higher than the rig's the floor is on which it last stood.
    """

    plants: tuple[Plant | None, ...] = (None, None, None)
    step: float = 0.0

    def stands(self, point: int) -> bool:
        """Tell whether a point stands, and where."""
        plant = self.plants[point]
        return plant is not None and plant.place is not None

    @property
    def left(self) -> bool:
        """Tell whether the foot was released: its toe, or its heel if that alone is planted."""
        heel, toe, _ = self.plants
        return toe.free if toe is not None else heel is not None and heel.free


def masks(on: Bools) -> tuple[Bools, ...]:
    """Lay out when heel, toe, ankle and tip are to stand, of (n, 2) when heel and toe are planted."""
    return on[:, 0], on[:, 1], on[:, 0] & on[:, 1], on[:, 1]


def follow(
    foot: FootPlants, k: int, captured: Floats, places: Floats, pinned: tuple[Floats, Floats], on: Bools, window: Ints,
    shown: slice, ground: Ground, belt: Floats,
) -> FootPlants:  # fmt: skip
    """Update a foot's plants after frames were shown.

    Args:
        foot: its plants before.
        k: which leg.
        captured: (3, P, n) [m] its points over the window as captured,
        places: and as corrected.
        pinned: (3, P, n) [m] their target places, and (P, n) the weights of these.
        on: (n, 2) when heel and toe are planted.
        window: (n,) numbers of its frames.
        shown: which of them were shown just now.
        ground: what plants stand on.
        belt: (3,) [m] that the ground of new plants moves in a frame.
    """
    plants, step = list(foot.plants), foot.step
    for point, mask in zip(STANDING, masks(on), strict=False):
        plant = plants[point]
        for t in range(shown.start, shown.stop):
            if not mask[t]:
                plant = None
            elif plant is None:
                level = ground.level(captured[1, point, t : t + int(np.argmin(np.append(mask[t:], False)))], k, point)
                step = step if point == ANKLE else ground.step(level, k, point)
                plant = Plant(int(window[t]), level, belt)
            if plant is not None and plant.place is None and window[t] > plant.start:
                here = places[:, point, t].copy()
                if point != TOE and pinned[1][point, t]:
                    here[::2] = pinned[0][::2, point, t]
                keeps = point == ANKLE or not ground.heights
                plant = replace(plant, place=here, at=int(window[t]), level=float(here[1]) if keeps else plant.level)
        plants[point] = plant and _held(plant, captured[:, point], places[:, point], window, shown.stop - 1, ground)
    return FootPlants(tuple(plants), step)


def _held(plant: Plant, captured: Floats, place: Floats, window: Ints, last: int, ground: Ground) -> Plant:
    """Release the plant where its foot has left it or can't be held."""
    if plant.place is None or plant.free:
        return plant
    frame = int(window[last])
    strays, slips = plant.off(captured[:, last], frame), plant.off(place[:, last], frame)
    settled = (frame - plant.start) * ground.frame_time > _LANDS
    free = settled and (strays > _STRAYS * ground.leg_length or slips > _SLIPS * ground.leg_length)
    return replace(plant, free=True) if free else plant

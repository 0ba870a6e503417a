"""Pins: in which frames a point of a foot is held, with what weight, and how high its floor is.

Each pin belongs to a point of the foot: heel, toe joint, ankle, or the tip of the toes. Contacts say when it is held.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.footing import Footing
from footfix.enforce.footplant import Footplant, stands
from footfix.enforce.leg import HEEL, POINTS, TIP, TOE, LegTracks
from footfix.enforce.pivots import ankle_stiller, held_alike, share_held, shared_behind
from footfix.enforce.standing_heights import floor_steps, nominal
from footfix.motion.clip import Bools, Floats
from footfix.rig.rig import Rig

_FORCED = 100.0  # weight of a forced contact, relative to a detected one
_KEPT = 0.04  # weight of the captured place of a kept plant, relative to a requested place


@dataclass(frozen=True, kw_only=True)
class PinParams:
    """When a plant is corrected, and how firmly its points are held.

    Args:
        keep_slide: a plant that slides no farther than this (2 mm for an adult), and is within `keep_height` of its
            floor, stays as captured; a toe joint that labels say is planted does only if at rest [leg lengths].
        keep_height: greatest distance from its floor at which a plant may stay as captured [leg lengths].
        keep_rested: whether a plant whose foot a program has locked in 30 % of its frames stays as captured, too.
        edge: time at the start and end of a detected contact in which the foot may still be landing or leaving [s].
        edge_weight: weight of a pin at the very start and end of a contact, relative to its middle [share].
        ankle: weight of the ankle relative to the toe joint, while heel and toe are planted; more of the heel's where
            the ankle was captured stiller than the heel [share].
        bare_ankle: the same for a foot without toe joint, whose heel and toe are estimated [share].
        tip: weight of the toes' tip relative to the toe joint [share].
        near: a plant within this distance of the floor stands on it, any other on a step of its own [leg lengths].
        sink: greatest depth of a point below the floor, unless it was captured deeper [leg lengths].
        turning: rate of turn about the vertical at which a foot is held with half the weight [rad/s].
        asked: farthest place requested by labels that is used; others are ignored, unless forced [leg lengths].
    """

    keep_slide: float = 0.0022
    keep_height: float = 0.0055
    keep_rested: bool = True
    edge: float = 0.015
    edge_weight: float = 0.1
    ankle: float = 0.4
    bare_ankle: float = 1.4
    tip: float = 0.4
    near: float = 0.067
    sink: float = 0.0033
    turning: float = 4.0
    asked: float = 0.12


@dataclass(frozen=True, eq=False)
class Pins:
    """The constraints on one point of a foot, over F frames.

    Args:
        hold: (F - 1,) weight of slip from each frame to the next, 1 for a contact of confidence 1.
        slip: (3, F - 1) [m] motion that does not count as slip: the ground's own, or a kept plant's as captured.
        stands: (F,) whether it is planted.
        level: (F,) [m] target height while it is planted.
        draw: (F,) weight of that height, 0 or more.
        lowest: (F,) [m] least allowed height.
        spans: the frames `[start, end)` of each plant that is to be held.
        sliding: those of each plant let go, which no static friction holds.
        place, placed: (3, F) [m] target place from labels or a style, and (F,) its weight.
        rise: (F,) [m] of a tip that the file can bend, how far above its toe joint it may be; none for other points.
    """

    hold: Floats
    slip: Floats
    stands: Bools
    level: Floats
    draw: Floats
    lowest: Floats
    place: Floats
    placed: Floats
    spans: tuple[tuple[int, int], ...] = ()
    sliding: tuple[tuple[int, int], ...] = ()
    rise: Floats | None = None

    def let_slide(self, spans: Sequence[tuple[int, int]]) -> Pins:
        """Let some plants go: nothing draws them to their floor, and only kinetic friction is left.

        Without that they would take up what their neighbours' correction has to lose, and slide farther than captured.
        """
        draw = self.draw.copy()
        for start, end in spans:
            draw[start:end] = 0.0
        left = tuple(span for span in self.spans if span not in spans)
        return replace(self, draw=draw, spans=left, sliding=(*self.sliding, *spans))

    def sticking(self) -> Floats:
        """Compute the weight of static friction from each frame to the next, (F - 1,)."""
        hold = self.hold.copy()
        for start, end in self.sliding:
            hold[start : end - 1] = 0.0
        return hold


def pins(
    footing: Footing, leg: LegTracks, k: int, rig: Rig, frame_time: float, *, heights: bool, params: PinParams
) -> tuple[Pins, ...]:
    """Make the pins of a foot's points.

    Args:
        footing: the plants of the clip, and what they stand on.
        leg: leg number `k` as captured.
        k: which one it is.
        rig: its soles and floor.
        frame_time: [s].
        heights: whether plants are drawn to their floor.
        params: the tolerances.

    Returns:
        The pins of heel, toe, ankle and, where the toes have one, tip.
    """
    own, frames = footing.of_leg(k), len(leg.flexion)
    step = floor_steps(own, footing.floors, frames, params.near * rig.leg_length)
    points = [HEEL, TOE, TIP] if len(leg.points) > 2 else [HEEL, TOE]
    heel, toe, *tips = (_pin(footing, leg, k, point, step, rig, frame_time, heights, params) for point in points)
    both = _both(footing, k, frames)
    share = share_held(leg, both, frame_time, params.turning)
    alike = held_alike(heel.hold, toe.hold, both, share)
    heel, toe = (replace(each, hold=hold) for each, hold in zip((heel, toe), alike, strict=True))
    ankle = _ankle(heel, toe, footing, leg, k, params.bare_ankle if rig.legs[k].toe is None else params.ankle)
    stiller = ankle_stiller(leg, footing.ground, both, rig.leg_length)
    heel_held, ankle_held = shared_behind(heel.hold, ankle.hold, stiller)
    heel, ankle = replace(heel, hold=heel_held), replace(ankle, hold=ankle_held)
    # While heel and toe are planted, the ankle's weight stands on the other end of the foot, too: on the tip, or on the
    # toe joint of a foot without one. Else a foot that turns about its toe would be made to turn farther back.
    tips = [replace(tip, hold=np.where(both, params.ankle * toe.hold, tip.hold)) for tip in tips]
    if not tips and rig.legs[k].toe is not None:
        toe = replace(toe, hold=np.where(both, heel.hold + ankle.hold, toe.hold))
    return (heel, toe, ankle, *tips)


def _both(footing: Footing, k: int, frames: int) -> Bools:
    """Mark the steps (F - 1,) in which heel and toe are both planted by detected contacts."""
    own = footing.of_leg(k)
    heel, toe = stands(own, frames, k + 1)[k]
    both = heel & toe
    for plant in own:
        both[plant.frames] &= not (plant.force or footing.by_hand[plant.id])
    return np.asarray(both[1:] & both[:-1])


def _ankle(heel: Pins, toe: Pins, footing: Footing, leg: LegTracks, k: int, weight: float) -> Pins:
    """Make the ankle's pin: planted while heel and toe are, with the lesser weight of the two."""
    frames = len(leg.flexion)
    slides = np.zeros(frames, dtype=np.bool_)
    for plant in footing.of_leg(k):
        slides[plant.frames] |= not footing.keep[plant.id]
    as_captured = ~(slides[1:] & slides[:-1])
    slip = np.where(as_captured, np.diff(leg.ankle, axis=1), np.diff(footing.ground.T, axis=1))
    nothing = np.zeros(frames)
    return Pins(
        weight * np.minimum(heel.hold, toe.hold), slip, heel.stands & toe.stands, nothing, nothing,
        np.full(frames, -np.inf), np.zeros((3, frames)), nothing,
    )  # fmt: skip


def _pin(
    footing: Footing, leg: LegTracks, k: int, point: int, step: Floats, rig: Rig, frame_time: float, heights: bool,
    params: PinParams,
) -> Pins:  # fmt: skip
    """Make the pin of a heel, a toe joint, or a tip (planted while its toe joint is); `step` (F,) [m] of the floor."""
    part, tip = POINTS[min(point, TOE)], point == TIP
    own, frames = [plant for plant in footing.of_leg(k) if plant.part == part], len(leg.flexion)
    track = leg.place(point)  # (3, F) [m]
    hold, draw, stand = _weights(own, footing, frames, frame_time, params.tip if tip else 1.0, params)
    rise = None
    slip = np.diff(footing.ground.T, axis=1)
    effector = next(e for e, sole in enumerate(rig.soles) if (sole.leg, sole.part) == (k, part))
    for plant in own:
        if footing.keep[plant.id]:
            slip[:, plant.start : plant.end - 1] = np.diff(track[:, plant.frames], axis=1)
    if tip:
        level, place, placed = track[1].copy(), np.zeros((3, frames)), np.zeros(frames)
        usual = float(footing.floors.tips[k])
        if leg.bends and leg.turns:
            # Toes lie as captured, or as they usually do in a flat foot. To hold the tip alone would bend them up
            # until they are level, where their length over the floor changes least as the foot rolls off.
            rise = np.where(stand, np.maximum(leg.points[TIP - 1][1], usual - footing.floors.rest[effector]), np.inf)
    else:
        level, place, placed = _places(own, footing, track, step, rig.floor)
        rest = float(footing.floors.rest[effector])
        usual = max(rest, nominal(rig, effector)) if own else rest
    if not heights or tip:
        draw[:] = 0.0
        slip[1] = np.diff(track[1])
    if not leg.turns:  # the root must not move to serve a leg that can't turn
        hold[:] = draw[:] = placed[:] = 0.0
    lowest = np.minimum(track[1], usual + step - params.sink * rig.leg_length)
    unsure = [p for p in own if not (footing.keep[p.id] or p.force or footing.by_hand[p.id]) and p.end - p.start >= 2]
    spans = tuple((p.start, p.end) for p in unsure)
    return Pins(hold, slip, stand, level, draw, lowest, place, placed, spans, rise=rise)


def _weights(
    own: Sequence[Footplant], footing: Footing, frames: int, frame_time: float, share: float, params: PinParams
) -> tuple[Floats, Floats, Bools]:
    """Compute the weights of slip (F - 1,) and of height (F,), and mark the planted frames (F,)."""
    hold, draw, stand = np.zeros(frames - 1), np.zeros(frames), np.zeros(frames, dtype=np.bool_)
    for plant in own:
        a, b = plant.start, plant.end
        weight = share * (_FORCED if plant.force else plant.confidence)
        ramp = np.ones(b - a - 1) if footing.by_hand[plant.id] else _ramp(a, b, frames, frame_time, params)
        hold[a : b - 1] = weight * ramp
        if plant.asked is None:  # what was asked for is a place, and needs no level
            draw[a:b] = 1.0 / max(1.0, 10.0 * (b - a) * frame_time)
        stand[a:b] = True
    return hold, draw, stand


def _places(
    own: Sequence[Footplant], footing: Footing, track: Floats, step: Floats, floor: float
) -> tuple[Floats, Floats, Floats]:
    """Compute the target height (F,) [m], place (3, F) [m] and its weight (F,), of kept plants and requested places.

    A requested place includes its height, and the height is not drawn to a floor there (`_weights`).
    """
    level, place, placed = track[1].copy(), np.zeros_like(track), np.zeros(track.shape[1])
    for plant in own:
        at, height = plant.frames, footing.floors.plants[plant.id]
        if footing.keep[plant.id]:
            place[:, at], placed[at] = track[:, at], _KEPT
        else:
            level[at] = height
        if plant.asked is not None:
            up = height - floor - step[plant.start]
            place[:, at] = (np.array(plant.asked) + np.array([0.0, up, 0.0]))[:, None]
            placed[at] = _FORCED if plant.force else 1.0
            level[at] = place[1, at]
    return level, place, placed


def _ramp(start: int, end: int, frames: int, frame_time: float, params: PinParams) -> Floats:
    """Compute weights (n - 1,) of a contact's steps, lower where the foot lands or leaves; not at the clip's ends.

    The middle step has full weight even in short contacts: at 30 fps a plant of a run may be two steps long.
    """
    steps = np.arange(end - start - 1)
    soft = max(1, round(params.edge / frame_time))
    soft = min(soft, max(len(steps) - 1, 0) // 2)
    ramp = np.ones(len(steps))
    if soft:
        ease = (np.arange(soft) + 0.5) / max(1, round(params.edge / frame_time))
        rise = np.minimum(ease**2 + params.edge_weight, 1.0)
        if start > 0:
            ramp[:soft] = rise
        if end < frames:
            ramp[-soft:] = np.minimum(ramp[-soft:], rise[::-1])
    return ramp

"""Pins: what is to stand in which frames, how surely, and how high its floor is.

A pin belongs to a point of the foot: the heel, the toe joint, or the tip of the toes. Contacts say when it stands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.footplant import Footplant
from footfix.enforce.leg import ANKLE, POINTS, TIP, TOE, LegTracks
from footfix.enforce.pivots import held_alike, share_held
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import Contacts, runs
from footfix.notes import Note
from footfix.rig.rig import Rig

_BY_HAND = ("labels", "known")  # methods whose contacts were given, not detected
_FORCED = 100.0  # times as much as others that contacts count which are held whatever it costs
FEWEST = 5  # frames of a plant: for fewer, a foot that lands or leaves would stamp; no measure counts them
_KEPT = 0.04  # how much the place of a plant that is kept counts, against one that was asked for


@dataclass(frozen=True, kw_only=True)
class PinParams:
    """When a plant is corrected, and what of it is held.

    Args:
        keep_slide: a plant that slides no farther (2 mm of a grown-up) and is as near to its floor as below stays as
            it is [leg lengths].
        keep_height: distance from its floor up to which it may stay as it is [leg lengths].
        keep_rested: whether a plant that a program has put to rest in most of its frames stays as it is, too.
        edge: time at both ends of a detected contact in which the foot may still land or leave [s].
        edge_weight: weight of a pin at the outermost frame of these, of its own [share].
        ankle: weight of the ankle against that of the toe joint, while heel and toe stand [share].
        tip: weight of the toes' tip against that of the toe joint [share].
        near: a plant nearer than this to the floor stands on it, else on a step of its own [leg lengths].
        sink: how deep a point may be in the floor, if it was not captured deeper [leg lengths].
        turning: a foot that turns over the floor at this rate is held half as much [rad/s].
        asked: a place that labels ask for farther away is not taken, unless forced [leg lengths].
    """

    keep_slide: float = 0.0022
    keep_height: float = 0.0055
    keep_rested: bool = True
    edge: float = 0.015
    edge_weight: float = 0.05
    ankle: float = 0.4
    tip: float = 0.3
    near: float = 0.067
    sink: float = 0.0033
    turning: float = 4.0
    asked: float = 0.12


@dataclass(frozen=True, eq=False)
class Pins:
    """What one point of a foot is to do, over F frames.

    Args:
        hold: (F - 1,) how much a metre of slip from each frame to the next counts, 1 for a sure contact.
        slip: (3, F - 1) [m] the slip that is none: the ground's own, or the captured one of a plant that is kept.
        stands: (F,) whether it is planted.
        level: (F,) [m] the height it is drawn to while it is planted.
        draw: (F,) how much that counts, 0 or more.
        lowest: (F,) [m] how low it may be.
        spans: the frames `[start, end)` of each plant that is to be held.
        place, placed: (3, F) [m] where labels or a style want it, and (F,) in which frames.
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

    def let_slide(self, spans: Sequence[tuple[int, int]]) -> Pins:
        """Let some plants go: nothing holds or draws them any more."""
        hold, draw = self.hold.copy(), self.draw.copy()
        for start, end in spans:
            hold[start : end - 1] = draw[start:end] = 0.0
        return replace(self, hold=hold, draw=draw, spans=tuple(s for s in self.spans if s not in spans))


@dataclass(frozen=True, eq=False)
class Floors:
    """How high each sole point's joint is while it stands on the floor.

    Args:
        rest: (E,) [m] usual height of the toe joint, or of the heel, at rest.
        tips: (legs,) [m] usual height of the toes' tip while the foot lies flat.
        plants: for each plant, by its id, the height [m] its joint stands at.
    """

    rest: Floats
    tips: Floats
    plants: tuple[float, ...]


def footplants(
    contacts: Contacts, rig: Rig, legs: Sequence[LegTracks], params: PinParams
) -> tuple[tuple[Footplant, ...], tuple[Note, ...]]:
    """Make a footplant of each contact; forbidden ones are none.

    Places that contacts ask for are left out where a foot can't be brought there: labels come from other versions of
    a clip, too, on another path, or of a figure of another size.

    Args:
        contacts: as detected or given, the effectors in the order of `rig.soles`.
        rig: its sole points.
        legs: as captured.
        params: how far away a place may be.

    Returns:
        The footplants by effector, then time, and a note where a place was left out.
    """
    made: list[Footplant] = []
    asked = taken = 0
    for e, (sole, effector) in enumerate(zip(rig.soles, contacts.effectors, strict=True)):
        for c in effector.contacts:
            if c.wish == "forbid" or c.end <= c.start:
                continue
            place, force = c.position, c.wish == "force"
            if place is not None and not force:
                own = np.median(legs[sole.leg].place(POINTS.index(sole.part))[:, c.start : c.end], axis=1)
                near = float(np.hypot(*(own - np.array(place))[[0, 2]])) <= params.asked * rig.leg_length
                asked, taken = asked + 1, taken + near
                place = place if near else None
            made.append(Footplant(
                len(made), e, sole.name, sole.leg, sole.part, c.start, c.end, c.confidence, force, place
            ))  # fmt: skip
    if asked == taken:
        return tuple(made), ()
    text = f"{asked - taken} of {asked} positions in the labels are too far from the motion and were ignored"
    return tuple(made), (Note("places-not-taken", text),)


def lacks(plants: Sequence[Footplant], legs: Sequence[LegTracks], rig: Rig) -> Floats:
    """Measure what each plant's joint lacks to the height at which its sole is on the rig's floor, (N,) [m]."""
    return np.array([
        nominal(rig, p.effector) - np.median(legs[p.leg].place(_point(p))[1, p.frames]) for p in plants
    ])  # fmt: skip


def given(contacts: Contacts, plant: Footplant) -> bool:
    """Tell whether somebody gave a contact, so that its ends are certain."""
    return plant.force or (contacts.method in _BY_HAND and plant.confidence >= 1.0)


def floors(plants: Sequence[Footplant], legs: Sequence[LegTracks], rig: Rig, params: PinParams) -> Floors:
    """Find the height at which each joint stands on its floor, from the heights at which it usually does.

    Args:
        plants: of the clip.
        legs: as captured.
        rig: its floor and soles.
        params: what is near.
    """
    near = params.near * rig.leg_length
    rest = np.array([nominal(rig, e) for e in range(len(rig.soles))])
    own = [float(np.median(legs[p.leg].place(_point(p))[1, p.frames])) for p in plants]
    for e in range(len(rest)):
        mine = [p for p in plants if p.effector == e and abs(own[p.id] - rest[e]) < near]
        if mine:
            rest[e] = np.median(np.concatenate([legs[p.leg].place(_point(p))[1, p.frames] for p in mine]))
    on = stands(plants, len(legs[0].flexion), len(legs))
    tips = np.zeros(len(legs))
    for k, leg in enumerate(legs):
        flat = on[k, 0] & on[k, 1]
        if len(leg.points) > 2:
            frames = flat if np.any(flat) else on[k, 1] if np.any(on[k, 1]) else np.ones_like(flat)
            tips[k] = np.median(leg.place(TIP)[1, frames])
    heights = tuple(height(own[p.id], float(rest[p.effector]), nominal(rig, p.effector), near) for p in plants)
    return Floors(rest, tips, heights)


def height(own: float, rest: float, floor: float, near: float) -> float:
    """[m] the height a plant stands at: its own on a step, the usual one of its joint near that.

    Where a joint usually is below the rig's floor, no plant that came in higher is drawn below the floor with it.
    """
    if abs(own - rest) >= near:
        return own
    return max(rest, min(own, floor))


def nominal(rig: Rig, effector: int) -> float:
    """Get the height [m] of a sole point's joint, its sole on the rig's floor: a toe joint's own height above it."""
    sole = rig.soles[effector]
    at_joint = sole.part == "toe" and rig.legs[sole.leg].toe is not None
    return rig.floor + (float(np.linalg.norm(sole.offset)) if at_joint else 0.0)


def stands(plants: Sequence[Footplant], frames: int, legs: int) -> Bools:
    """Mark the frames in which heel and toe of each leg are planted, (legs, 2, F)."""
    on = np.zeros((legs, 2, frames), dtype=np.bool_)
    for plant in plants:
        on[plant.leg, _point(plant), plant.frames] = True
    return on


def _point(plant: Footplant) -> int:
    return POINTS.index(plant.part)


def pins(
    plants: Sequence[Footplant], leg: LegTracks, k: int, rig: Rig, ground: Floats, floors: Floors, keep: Sequence[bool],
    by_hand: Sequence[bool], frame_time: float, *, heights: bool, params: PinParams,
) -> tuple[Pins, ...]:  # fmt: skip
    """Lay out what each point of a leg's foot is to do.

    Args:
        plants: of the clip.
        leg: leg number `k` as captured.
        k: which one it is.
        rig: its soles and floor.
        ground: (F, 3) [m] displacement of the ground.
        floors: from `floors`.
        keep: for each plant whether it stays as it is.
        by_hand: for each plant whether its ends are certain.
        frame_time: [s].
        heights: whether plants are drawn to their floor.
        params: the tolerances.
    """
    own = [plant for plant in plants if plant.leg == k]
    effector: dict[str, int] = {sole.part: e for e, sole in enumerate(rig.soles) if sole.leg == k}
    step = floor_steps(own, floors, len(leg.flexion), params.near * rig.leg_length)
    found: list[Pins] = []
    both = _both(own, k, by_hand, len(leg.flexion))
    for point in range(len(POINTS) if len(leg.points) > 2 else TIP):
        part = POINTS[min(point, TOE)]
        mine = [plant for plant in own if plant.part == part]
        rest = floors.tips[k] if point == TIP else floors.rest[effector[part]]
        if point == ANKLE:
            share = share_held(leg, both, frame_time, params.turning)
            alike = held_alike(found[0].hold, found[1].hold, both, share)
            found = [replace(each, hold=hold) for each, hold in zip(found, alike, strict=True)]
            found.append(_ankle(found, own, leg, ground, keep, params))
            continue
        found.append(_pins(
            mine, leg, point, rest, step, ground, floors, keep, by_hand, rig, frame_time, heights, params
        ))  # fmt: skip
        if point == TIP:  # while heel and toe stand, it counts as the ankle does at the other side of the toe joint
            tip = np.where(both, params.ankle * found[TOE].hold, found[TIP].hold)
            found[TIP] = replace(found[TIP], hold=tip)
    return tuple(found)


def _both(own: Sequence[Footplant], k: int, by_hand: Sequence[bool], frames: int) -> Bools:
    """Mark the steps (F - 1,) in which heel and toe stand by contacts that were detected."""
    heel, toe = stands(own, frames, k + 1)[k]
    both = heel & toe
    for plant in own:
        both[plant.frames] &= not (plant.force or by_hand[plant.id])
    return np.asarray(both[1:] & both[:-1])


def _ankle(
    feet: Sequence[Pins], plants: Sequence[Footplant], leg: LegTracks, ground: Floats, keep: Sequence[bool],
    params: PinParams,
) -> Pins:  # fmt: skip
    """The ankle's pin: it stands while heel and toe do, as surely as the less sure of them."""
    heel, toe = feet
    frames = len(leg.flexion)
    slides = np.zeros(frames, dtype=np.bool_)
    for plant in plants:
        slides[plant.frames] |= not keep[plant.id]
    as_captured = ~(slides[1:] & slides[:-1])
    slip = np.where(as_captured, np.diff(leg.ankle, axis=1), np.diff(ground.T, axis=1))
    nothing = np.zeros(frames)
    return Pins(
        params.ankle * np.minimum(heel.hold, toe.hold), slip, heel.stands & toe.stands, nothing, nothing,
        np.full(frames, -np.inf), np.zeros((3, frames)), nothing,
    )  # fmt: skip


def _pins(
    own: Sequence[Footplant], leg: LegTracks, point: int, rest: float, step: Floats, ground: Floats, floors: Floors,
    keep: Sequence[bool], by_hand: Sequence[bool], rig: Rig, frame_time: float, heights: bool, params: PinParams,
) -> Pins:  # fmt: skip
    frames = len(leg.flexion)
    track = leg.place(point)  # (3, F) [m]
    hold, stand = np.zeros(frames - 1), np.zeros(frames, dtype=np.bool_)
    slip = np.diff(ground.T, axis=1)
    level, draw = track[1].copy(), np.zeros(frames)
    place, placed = np.zeros((3, frames)), np.zeros(frames)
    for plant in own:
        a, b = plant.start, plant.end
        stand[a:b] = True
        weight = _FORCED if plant.force else plant.confidence
        weight *= params.tip if point == TIP else 1.0
        ramp = np.ones(b - a - 1) if by_hand[plant.id] else _ramp(a, b, frames, frame_time, params)
        hold[a : b - 1] = weight * ramp
        draw[a:b] = 1.0 / max(1.0, 10.0 * (b - a) * frame_time)
        if keep[plant.id]:
            slip[:, a : b - 1] = np.diff(track[:, a:b], axis=1)
            if point != TIP:
                place[:, a:b], placed[a:b] = track[:, a:b], _KEPT
        elif point != TIP:
            level[a:b] = floors.plants[plant.id]
        if plant.asked is not None and point != TIP:
            up = floors.plants[plant.id] - rig.floor - step[plant.start]
            place[:, a:b] = np.array(plant.asked)[:, None] + np.array([0.0, up, 0.0])[:, None]
            placed[a:b] = _FORCED if plant.force else 1.0
            level[a:b], draw[a:b] = place[1, a:b], 0.0
    if not heights or point == TIP:
        draw[:] = 0.0
        slip[1] = np.diff(track[1])
    if not leg.turns:  # the root is not to follow a leg that can't
        hold[:] = draw[:] = placed[:] = 0.0
    usual = rest if point == TIP else max(rest, nominal(rig, own[0].effector)) if own else rest
    lowest = np.minimum(track[1], usual + step - params.sink * rig.leg_length)
    unsure = [p for p in own if not (keep[p.id] or p.force or by_hand[p.id]) and p.end - p.start >= 2]
    spans = tuple((p.start, p.end) for p in unsure)
    return Pins(hold, slip, stand, level, draw, lowest, place, placed, spans)


def _ramp(start: int, end: int, frames: int, frame_time: float, params: PinParams) -> Floats:
    """(n - 1,) weights of a contact's steps, less where the foot lands or leaves; not so at the clip's own ends."""
    steps = np.arange(end - start - 1)
    soft = max(1, round(params.edge / frame_time))
    soft = min(soft, len(steps) // 2)
    ramp = np.ones(len(steps))
    if soft:
        ease = (np.arange(soft) + 0.5) / max(1, round(params.edge / frame_time))
        rise = np.minimum(ease**2 + params.edge_weight, 1.0)
        if start > 0:
            ramp[:soft] = rise
        if end < frames:
            ramp[-soft:] = np.minimum(ramp[-soft:], rise[::-1])
    return ramp


def floor_steps(plants: Sequence[Footplant], floors: Floors, frames: int, near: float) -> Floats:
    """(F,) [m] how much higher than the rig's the floor under a foot is: between plants, the lower of the two."""
    step = np.zeros(frames)
    steps = [floors.plants[p.id] - floors.rest[p.effector] for p in plants]
    by_plant = sorted((p.start, p.end, up if abs(up) >= near else 0.0) for p, up in zip(plants, steps, strict=True))
    if not by_plant:
        return step
    known = np.full(frames, np.nan)
    for start, end, high in by_plant:
        known[start:end] = np.fmin(known[start:end], high)
    for start, end in runs(np.isnan(known)):
        sides = known[max(start - 1, 0)], known[min(end, frames - 1)]
        known[start:end] = np.fmin(*sides)
    return known

"""Plants and stances: contacts on their way through enforcement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from footfix.enforce.foot import Foot
from footfix.motion.clip import Bools, Floats, Ints
from footfix.motion.contacts import Contact, Contacts, runs
from footfix.motion.segments import centres, segments
from footfix.motion.vectors import norm


@dataclass(frozen=True, kw_only=True)
class PlantParams:
    """When a plant is corrected, and where it goes. Lengths in leg lengths."""

    snap: float = 0.045  # a plant nearer than this to the rig's floor stands on it; else on its own level (stairs)
    sunk: float = 0.075  # or, below that floor, nearer than this: there are steps up, but hardly pits
    hovers: float = 0.06  # or nearer than that to where they all are, if that is no farther than this from the floor
    air: float = 0.1  # a plant that is farther off the rig's floor stands on a step, if it is steady:
    steady: float = 0.01  # if half the time it is no farther than this from its usual height; else it is in the air
    keep_slide: float = 0.0009  # a plant that slides less, stands as level and turns as little, is left alone
    keep_speed: float = 0.011  # [leg lengths/s] if it is at no time faster than this,
    keep_mean: float = 0.0012  # [leg lengths/s] and on the whole no faster than this,
    keep_slow: float = 0.0002  # or slides even less,
    keep_height: float = 0.006  # and is no farther than this from its floor
    keep_turn: float = 0.7  # [degrees]
    rest: float = 2e-5  # from frame to frame: what moves less was put to rest by a program; captured feet never are
    cleaned: float = 0.4  # of a stand's frames: one that rests so long was cleaned before, and is left alone
    off_floor: float = 0.025  # stands that rest, but on the whole farther than this from their floor, are moved to it
    low: float = 0.12  # an unplanted foot that is lower than this over the floor stays there when the figure moves
    sink: float = 0.0025  # what of a moving foot is deeper in the floor than this is lifted out of it
    knee_sink: float = 0.03  # a plant that pushes the knee of its leg this much deeper into the floor is released
    toe_sink: float = 0.006  # toes of a planted foot that are deeper in the floor than this, and than flat, bend
    quiver: float = 0.0002  # toes that carry the ball to and fro in a foot that stands, by more than this, are stilled
    lies: float = 20.0  # [degrees] a foot that is pitched farther does not lie flat: its higher end is let go
    pivot: float = 20.0  # [degrees] a flat foot that turns farther is meant to, about the end that moves less
    asked: float = 0.12  # a place asked for that is farther away than this is not taken, but by a forced contact
    shortest: float = 0.04  # [s] a detected stand shorter than this is no plant
    max_shift: float = 0.25  # a plant whose correction would move it farther is released
    stands: float = 0.5  # of a plant's frames: where so many stand, those at its edges that don't are not held
    holds: float = 0.0002  # a held plant is this near to its target
    noticed: float = 0.023  # a plant that stays farther than this from its target (viewers notice 21 mm) is released
    places: int = 9  # places along a stance's slide that are tried where its leg would be stretched too far
    stretch: float = 0.98  # of the leg's length: up to here a leg may be stretched beyond the source
    stretch_cost: float = 4.0  # how much a stretch beyond it counts against a way of the foot as long
    edge_speed: float = 0.5  # [leg lengths/s] frames at a plant's edges that move faster are left to the swing,
    edge_factor: float = 2.5  # if they are also so many times faster than the plant on the whole,
    edge_distance: float = 0.02  # or farther than this from where it stands and a fifth as fast


# Contacts that somebody gave are held as they are, the edges of those that a detector found are less certain. A file
# of labels may be a detector's, too: those it is not sure of are its own.
_BY_HAND = ("labels", "known")


@dataclass(frozen=True)
class Plant:
    """One contact on its way to a `Footplant`.

    Args:
        effector: index among `Rig.soles`.
        part: "heel" or "toe".
        contact: as detected or given.
        start, end: the frames `[start, end)` in which it is held.
        target: (3,) [m].
        given: somebody gave the contact, and it is held as it is.
        kept: it stands well enough.
        reason: why it is released, empty while it is not.
    """

    effector: int
    part: str
    contact: Contact
    start: int
    end: int
    target: Floats
    given: bool = False
    kept: bool = False
    reason: str = ""

    @property
    def frames(self) -> slice:
        return slice(self.start, self.end)


@dataclass(frozen=True)
class Stance:
    """Contacts of one foot that overlap or touch: one stand, rolling from heel to toe.

    Args:
        leg: index among `Rig.legs`.
        plants: its contacts.
        level: [m] height of the floor it stands on.
        pivots: "", or which end ("heel", "toe") it turns about while flat.
        cleaned: it rests already, and is left alone.
        row: of stances that were put into a cleaned clip together, from 1; 0 for all others.
    """

    leg: int
    plants: tuple[Plant, ...]
    level: float = 0.0
    pivots: str = ""
    cleaned: bool = False
    row: int = 0

    @cached_property
    def frames(self) -> slice:
        return slice(min(p.start for p in self.plants), max(p.end for p in self.plants))

    @cached_property
    def released(self) -> bool:
        """Whether it is left as it was."""
        return any(plant.reason for plant in self.plants)

    def let_go(self, reason: str) -> Stance:
        """The stance released; what is kept stays kept."""
        return replace(self, plants=tuple(p if p.kept else replace(p, reason=reason) for p in self.plants))

    @cached_property
    def flat(self) -> Bools:
        """(n,) of its frames, in which both ends are planted."""
        first = self.frames.start
        on = {part: np.zeros(self.frames.stop - first, dtype=np.bool_) for part in ("heel", "toe")}
        for plant in self.plants:
            on[plant.part][plant.start - first : plant.end - first] = True
        return np.asarray(on["heel"] & on["toe"])

    def parts(self, part: str) -> list[Plant]:
        """Its plants of one end of the foot."""
        return [plant for plant in self.plants if plant.part == part]


def stances(
    contacts: Contacts, feet: Sequence[Foot], frame_time: float, leg_length: float, params: PlantParams
) -> list[Stance]:
    """The contacts of each foot, gathered into stands. Forbidden ones are no contacts."""
    found = []
    for k, foot in enumerate(feet):
        plants = []
        for part, e in zip(("heel", "toe"), foot.effectors, strict=True):
            track = foot.point(part)
            own = [c for c in contacts.effectors[e].contacts if c.wish != "forbid" and c.end > c.start]
            given = [
                c.wish == "force" or (contacts.method in _BY_HAND and c.confidence >= 1.0) for c in own
            ]
            spans = _still(own, given, track, frame_time, leg_length, params)
            for contact, by_hand, (start, end) in zip(own, given, spans, strict=True):
                contact = _at_hand(contact, track, leg_length, params)
                plants.append(Plant(e, part, contact, start, end, np.zeros(3), by_hand))
        plants.sort(key=lambda plant: (plant.start, plant.part))
        group: list[Plant] = []
        end = -1
        for plant in plants:
            if group and plant.start > end:
                found.append(Stance(k, tuple(group)))
                group = []
            group.append(plant)
            end = max(end, plant.end)
        if group:
            found.append(Stance(k, tuple(group)))
    return found


def lying(
    stands: Sequence[Stance], feet: Sequence[Foot], frame_time: float, params: PlantParams
) -> list[Stance]:
    """The stances; and apart from them, let go, plants of an end that is far above the other while both are planted.

    Levelled, such a foot would be slammed on the floor: one that rests on its heel, or kneels on its toes. And so are
    plants of a frame or two, for which a foot that lands or leaves would stamp.
    """
    found = []
    for stance in stands:
        reasons = [""] * len(stance.plants)
        if not stance.cleaned and not stance.released:
            foot = feet[stance.leg]
            reasons = [
                _brief(plant, len(foot), frame_time, params) or _above(plant, stance, foot, params)
                for plant in stance.plants
            ]
        if not any(reasons):
            found.append(stance)
            continue
        both = list(zip(stance.plants, reasons, strict=True))
        if not all(reasons):
            found.append(replace(stance, plants=tuple(plant for plant, why in both if not why)))
        found.append(replace(stance, plants=tuple(replace(plant, reason=why) for plant, why in both if why)))
    return found


def where_it_was(stance: Stance, foot: Foot) -> Stance:
    """The stance, let go before it was aimed anywhere, with the middle of where each plant was as its target."""
    plants = [replace(p, target=np.median(foot.point(p.part)[p.frames], axis=0)) for p in stance.plants]
    return replace(stance, plants=tuple(plants))


def _brief(plant: Plant, clip: int, frame_time: float, params: PlantParams) -> str:
    """Why a plant is let go that is a moment only, and none that the clip, of so many frames, cuts off; or nothing."""
    frames = plant.contact.end - plant.contact.start
    goes_on = plant.contact.start == 0 or plant.contact.end == clip
    if plant.given or goes_on or (frames > 1 and frames * frame_time >= params.shortest):
        return ""
    return too_short(frames * frame_time)


def _above(plant: Plant, stance: Stance, foot: Foot, params: PlantParams) -> str:
    """Why a plant is let go whose end is above the other one, as it is planted, for most of its frames; or nothing."""
    both = stance.flat[plant.start - stance.frames.start : plant.end - stance.frames.start]
    if plant.given or np.count_nonzero(both) < params.stands * (plant.end - plant.start):
        return ""
    part, other_part = ("heel", "ball") if plant.part == "heel" else ("ball", "heel")
    heel, ball = foot.heel[plant.frames][both], foot.ball[plant.frames][both]
    span = heel - ball if plant.part == "heel" else ball - heel
    pitch = float(np.median(np.degrees(np.arctan2(span[:, 1], np.hypot(span[:, 0], span[:, 2])))))
    if pitch <= params.lies:
        return ""
    return f"the foot does not lie flat: its {part} is {1000.0 * np.median(span[:, 1]):.0f} mm above its {other_part}"


def _at_hand(contact: Contact, track: Floats, leg_length: float, params: PlantParams) -> Contact:
    """The contact without the place it asks for, where that is farther away than a foot could be brought.

    Places in labels come from other versions of a clip, too: on another path, or on a figure of another size.
    """
    if contact.position is None or contact.wish == "force":
        return contact
    far = float(np.linalg.norm(centre(track[contact.start : contact.end]) - np.array(contact.position)))
    return contact if far <= params.asked * leg_length else replace(contact, position=None)


def _still(
    contacts: Sequence[Contact],
    given: Sequence[bool],
    track: Floats,
    frame_time: float,
    leg_length: float,
    params: PlantParams,
) -> list[tuple[int, int]]:
    """The frames `[start, end)` of each contact without those at its edges in which the point still lands or is gone.

    A label one frame too long at 30 frames a second is a foot pulled back by a hand's breadth.
    """
    spans = [(contact.start, contact.end) for contact in contacts]
    able = [k for k, c in enumerate(contacts) if not given[k] and c.end - c.start >= 3]
    if not able:
        return spans
    parts, steps = segments([spans[k] for k in able]), segments([(spans[k][0] + 1, spans[k][1]) for k in able])
    places = track[parts.frames]
    away = norm(places - centres(places, parts)[parts.owner])
    # all but held: what does not stand is no plant
    stands, stood = parts.longest(away < params.keep_slide * leg_length)
    holds = stood - stands >= params.stands * parts.lengths
    speed = norm(track[steps.frames] - track[steps.frames - 1]) / (frame_time * leg_length)
    usual = (params.edge_factor * steps.median(speed))[steps.owner]
    far = away > params.edge_distance * leg_length
    landing = speed > np.maximum(params.edge_speed, usual)
    drifting = speed > np.maximum(params.edge_speed / 5.0, usual)
    to = np.arange(len(steps.frames)) + steps.owner + 1  # where each step ends among the places
    head = steps.leading(landing | (drifting & far[to - 1]))
    tail = steps.trailing(landing | (drifting & far[to]))
    leaves = parts.lengths - head - tail >= 2
    first = np.where(holds, stands, np.where(leaves, head, 0))
    last = np.where(holds, stood, np.where(leaves, parts.lengths - tail, parts.lengths))
    for k, begin, end in zip(able, first.tolist(), last.tolist(), strict=True):
        spans[k] = (spans[k][0] + begin, spans[k][0] + end)
    return spans


def too_short(seconds: float) -> str:
    """Why what stands for so long [s] is let go."""
    return f"too short to be a plant: {seconds:.3f} s"


def turns_about(part: str) -> str:
    """Why the other end of a foot is let go that turns about its "heel" or "toe"."""
    return f"the foot turns on the floor, about its {'ball' if part == 'toe' else 'heel'}"


def stiller(foot: Foot, frames: slice | Ints) -> str:
    """Which end of a foot, "heel" or "toe", keeps nearer to where it is on the floor in these frames."""
    places = [foot.point(part)[frames][:, [0, 2]] for part in ("heel", "toe")]
    ways = [float(norm(each - each.mean(axis=0)).max()) for each in places]
    return "heel" if ways[0] < ways[1] else "toe"


def heights(plants: Sequence[Plant], foot: Foot) -> Floats:
    """(N,) [m] of plants of a foot, in all of their frames."""
    return np.concatenate([foot.point(plant.part)[plant.frames, 1] for plant in plants])


def agreement(values: Floats) -> tuple[float, float]:
    """What is common to values (N,), and the share of them that is off it by less than half of it."""
    common = float(np.median(values))
    return common, float(np.mean(np.abs(values - common) < 0.5 * abs(common)))


def centre(points: Floats, weights: Floats | None = None) -> Floats:
    """The place (D,) with the least sum of distances to points (N, D)."""
    return np.asarray(centres(points, segments([(0, len(points))]), weights)[0])


def longest(mask: Bools) -> slice:
    """The longest stretch in which a mask is True."""
    spans = runs(mask)
    start, end = max(spans, key=lambda span: span[1] - span[0], default=(0, 0))
    return slice(start, end)


def exact(stance: Stance, residual: Floats, leg_length: float, params: PlantParams) -> Stance:
    """The stance with each plant's frames narrowed to those in which it truly holds, if these are most of them.

    `residual` (F, E) [m] says how far each sole point is from its target.
    """
    plants = list(stance.plants)
    for k, plant in enumerate(plants):
        near = residual[plant.frames, plant.effector] <= params.holds * leg_length
        if plant.reason or plant.given or np.all(near):
            continue
        holds = longest(near)
        if holds.stop - holds.start >= max(params.stands * (plant.contact.end - plant.contact.start), 2):
            plants[k] = replace(plant, start=plant.start + holds.start, end=plant.start + holds.stop)
    if all(new is old for new, old in zip(plants, stance.plants, strict=True)):
        return stance
    return replace(stance, plants=tuple(plants))

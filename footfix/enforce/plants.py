"""Where plants are to stand: heel and ball of one foot as one rigid, level sole on the plant's own floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.foot import Foot
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import Contact, Contacts, runs


@dataclass(frozen=True, kw_only=True)
class PlantParams:
    """When a plant is corrected, and where it goes. Lengths in leg lengths."""

    snap: float = 0.06  # a plant nearer than this to the rig's floor stands on it; else on its own level (stairs)
    keep_slide: float = 0.0008  # a plant that slides less, stands as level and turns as little, is left alone
    keep_height: float = 0.004  # and is no farther than this from its floor
    keep_turn: float = 0.7  # [degrees]
    sink: float = 0.003  # what of a moving foot is deeper in the floor than this is lifted out of it
    pivot: float = 20.0  # [degrees] a flat foot that turns farther is meant to, about the end that moves less
    shortest: float = 0.04  # [s] a detected stand shorter than this is no plant
    max_shift: float = 0.25  # a plant whose correction would move it farther is released
    stands: float = 0.6  # of a plant's frames: where so many stand, those at its edges that don't are not held
    holds: float = 0.0002  # a held plant is this near to its target
    places: int = 9  # places along a stance's slide that are tried where its leg would be stretched too far
    stretch: float = 0.98  # of the leg's length: up to here a leg may be stretched beyond the source
    stretch_cost: float = 4.0  # how much a stretch beyond it counts against a way of the foot as long
    edge_speed: float = 0.5  # [leg lengths/s] frames at a plant's edges that move faster are left to the swing,
    edge_factor: float = 2.5  # if they are also so many times faster than the plant on the whole,
    edge_distance: float = 0.02  # or farther than this from where it stands and a fifth as fast


@dataclass(frozen=True)
class Plant:
    """One contact on its way to a `Footplant`.

    Args:
        effector: index among `Rig.soles`.
        part: "heel" or "toe".
        contact: as detected or given.
        start, end: the frames `[start, end)` in which it is held.
        target: (3,) [m].
        kept: it stands well enough.
        reason: why it is released, empty while it is not.
    """

    effector: int
    part: str
    contact: Contact
    start: int
    end: int
    target: Floats
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
    """

    leg: int
    plants: tuple[Plant, ...]
    level: float = 0.0
    pivots: str = ""

    @property
    def frames(self) -> slice:
        return slice(min(p.start for p in self.plants), max(p.end for p in self.plants))

    @property
    def released(self) -> bool:
        """Whether it is left as it was."""
        return any(plant.reason for plant in self.plants)

    def parts(self, part: str) -> list[Plant]:
        """Its plants of one end of the foot."""
        return [plant for plant in self.plants if plant.part == part]

    def on(self, part: str, frames: int) -> Bools:
        """(F,) True where that end is planted."""
        mask = np.zeros(frames, dtype=np.bool_)
        for plant in self.parts(part):
            mask[plant.frames] = True
        return mask


def stances(
    contacts: Contacts, feet: Sequence[Foot], frame_time: float, leg_length: float, params: PlantParams
) -> list[Stance]:
    """The contacts of each foot, gathered into stands. Forbidden ones are no contacts."""
    found = []
    for k, foot in enumerate(feet):
        plants = [
            Plant(e, part, contact, *_still(contact, foot.point(part), frame_time, leg_length, params), np.zeros(3))
            for part, e in zip(("heel", "toe"), foot.effectors, strict=True)
            for contact in contacts.effectors[e].contacts
            if contact.wish != "forbid" and contact.end > contact.start
        ]
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


def _still(
    contact: Contact, track: Floats, frame_time: float, leg_length: float, params: PlantParams
) -> tuple[int, int]:
    """The frames `[start, end)` of a contact without those at its edges in which the point is still landing or gone.

    A label one frame too long at 30 frames a second is a foot pulled back by a hand's breadth.
    """
    start, end = contact.start, contact.end
    if contact.wish == "force" or end - start < 3:
        return start, end
    places = track[start:end]
    stands = _longest(np.linalg.norm(places - centre(places), axis=1) < params.keep_slide * leg_length)
    if stands.stop - stands.start >= params.stands * len(places):  # all but held: what does not stand is no plant
        return start + stands.start, start + stands.stop
    speed = np.linalg.norm(np.diff(places, axis=0), axis=1) / (frame_time * leg_length)
    far = np.linalg.norm(places - centre(places), axis=1) > params.edge_distance * leg_length
    usual = params.edge_factor * float(np.median(speed))
    landing = speed > max(params.edge_speed, usual)
    drifting = speed > max(params.edge_speed / 5.0, usual)
    moving_on = landing | (drifting & far[:-1])  # from this frame to the next
    moving_off = landing | (drifting & far[1:])  # to this frame from the one before
    head = int(np.argmin(np.append(moving_on, False)))
    tail = int(np.argmin(np.append(moving_off[::-1], False)))
    if end - start - head - tail < 2:
        return start, end
    return start + head, end - tail


def centre(points: Floats, weights: Floats | None = None) -> Floats:
    """The place (D,) with the least sum of distances to points (N, D): a median that knows no axes.

    A few steps of Weiszfeld's way from the mean, with distances never counted as less than a hundredth of the usual.
    """
    share = np.ones(len(points)) if weights is None else weights
    place = np.average(points, axis=0, weights=share)
    for _ in range(6):
        away = np.linalg.norm(points - place, axis=1)
        closeness = share / np.maximum(away, max(0.01 * float(away.mean()), 1e-9))
        place = closeness @ points / closeness.sum()
    return np.asarray(place)


def _longest(mask: Bools) -> slice:
    """The longest stretch in which a mask is True."""
    spans = runs(mask)
    start, end = max(spans, key=lambda span: span[1] - span[0], default=(0, 0))
    return slice(start, end)


def exact(stance: Stance, residual: Floats, leg_length: float, params: PlantParams) -> Stance:
    """The stance with each plant's frames narrowed to those in which it truly holds, if these are most of them.

    `residual` (F, E) [m] says how far each sole point is from its target.
    """
    plants = []
    for plant in stance.plants:
        off = residual[plant.frames, plant.effector]
        holds = _longest(off <= params.holds * leg_length)
        most = holds.stop - holds.start >= max(params.stands * (plant.contact.end - plant.contact.start), 2)
        if plant.reason or plant.contact.wish == "force" or off.max() <= params.holds * leg_length or not most:
            plants.append(plant)
        else:
            plants.append(replace(plant, start=plant.start + holds.start, end=plant.start + holds.stop))
    return replace(stance, plants=tuple(plants))


def aimed(stance: Stance, foot: Foot, floor: float, leg_length: float, params: PlantParams) -> Stance:
    """The stance with its level and its plants' targets."""
    level = _level(stance, foot, floor, leg_length, params)
    flat = stance.on("heel", len(foot)) & stance.on("toe", len(foot))
    pivots = _pivots(foot, flat, params)
    plants = [replace(plant, target=_place(plant, foot, flat, level)) for plant in stance.plants]
    if not pivots:
        plants = _rigid(plants, foot)
    stance = replace(stance, plants=tuple(plants), level=level, pivots=pivots)
    if all(plant.contact.position is None for plant in plants):
        stance = _within_reach(stance, foot, leg_length, params)
    return stance


def judged(stance: Stance, foot: Foot, frame_time: float, leg_length: float, params: PlantParams) -> Stance:
    """The stance kept where it stands well enough, given up where a plant of it would have to move too far."""
    flat = stance.on("heel", len(foot)) & stance.on("toe", len(foot))
    if _stands_well(stance, foot, flat, leg_length, params):
        return replace(stance, plants=tuple(replace(plant, kept=True) for plant in stance.plants))
    if any(plant.contact.wish == "force" for plant in stance.plants):
        return stance
    seconds = (stance.frames.stop - stance.frames.start) * frame_time
    if seconds < params.shortest:
        reason = f"too short to be a plant: {seconds:.3f} s"
        return replace(stance, plants=tuple(replace(each, reason=reason) for each in stance.plants))
    for plant in stance.plants:
        if stance.pivots and plant.part != stance.pivots:
            continue
        far = float(np.linalg.norm(foot.point(plant.part)[plant.frames] - plant.target, axis=1).max())
        if far > params.max_shift * leg_length:
            reason = f"slides so far that it seems meant: {far:.2f} m from where it would stand"
            return replace(stance, plants=tuple(replace(each, reason=reason) for each in stance.plants))
    return stance


def _level(stance: Stance, foot: Foot, floor: float, leg_length: float, params: PlantParams) -> float:
    """The floor under this stance: the one asked for, the rig's, or its own where that is a step away."""
    asked = [plant.contact.position[1] for plant in stance.plants if plant.contact.position is not None]
    if asked:
        return float(np.median(asked))
    heights = np.concatenate([foot.point(plant.part)[plant.frames, 1] for plant in stance.plants])
    own = float(np.median(heights))
    return floor if abs(own - floor) <= params.snap * leg_length else own


def _place(plant: Plant, foot: Foot, flat: Bools, level: float) -> Floats:
    """Where one end stands when it stands alone: asked for, or the middle of where it was, on the floor."""
    if plant.contact.position is not None:
        return np.array([plant.contact.position[0], level, plant.contact.position[2]])
    track = foot.point(plant.part)[plant.frames]
    whole = track[flat[plant.frames]] if np.any(flat[plant.frames]) else track
    x, z = centre(whole[:, [0, 2]])
    return np.array([x, level, z])


def _rigid(plants: list[Plant], foot: Foot) -> list[Plant]:
    """Heel and ball as far apart as the foot is long: the longest plant stands, the others give way to it."""
    order = sorted(range(len(plants)), key=lambda k: plants[k].start - plants[k].end)
    placed: list[int] = []
    for k in order:
        plant = plants[k]
        common = [
            (min(plant.end, plants[j].end) - max(plant.start, plants[j].start), j)
            for j in placed
            if plants[j].part != plant.part
        ]
        shared, j = max(common, default=(0, -1))
        asked = plant.contact.position is not None and plants[j].contact.position is not None
        if shared > 0 and not asked:
            other = plants[j]
            both = slice(max(plant.start, other.start), min(plant.end, other.end))
            span = foot.point(plant.part)[both] - foot.point(other.part)[both]
            length = float(np.median(np.linalg.norm(span, axis=1)))
            heading = span[:, [0, 2]].sum(axis=0)
            heading /= max(float(np.linalg.norm(heading)), 1e-300)
            target = other.target + length * np.array([heading[0], 0.0, heading[1]])
            plants[k] = replace(plant, target=target)
        placed.append(k)
    return plants


def _within_reach(stance: Stance, foot: Foot, leg_length: float, params: PlantParams) -> Stance:
    """The stance moved over the floor, along its own slide, to where its leg is stretched least beyond the source.

    Of the places that the foot slides through, the one in the middle asks the shortest way of the foot; but a leg
    that is straight when it lands can't reach ahead.
    """
    frames = stance.frames
    off = np.zeros((frames.stop - frames.start, 3))
    ends = np.zeros(len(off))
    for plant in stance.plants:
        own = slice(plant.start - frames.start, plant.end - frames.start)
        off[own] += plant.target - foot.point(plant.part)[plant.frames]
        ends[own] += 1.0
    off /= np.maximum(ends, 1.0)[:, None]
    line = foot.ankle[frames] - foot.hip[frames]
    captured = np.linalg.norm(line, axis=1)
    thigh, shank = foot.knee[frames] - foot.hip[frames], foot.ankle[frames] - foot.knee[frames]
    length = np.linalg.norm(thigh, axis=1) + np.linalg.norm(shank, axis=1)
    free = np.maximum(captured, params.stretch * length)
    picks = np.unique(np.linspace(0, len(off) - 1, params.places).round().astype(np.intp))
    moves = np.concatenate([np.zeros((1, 3)), -off[picks] * [1.0, 0.0, 1.0]])
    wanted = off + moves[:, None]  # (places, n, 3)
    beyond = np.maximum(np.linalg.norm(line + wanted, axis=2) - free, 0.0).max(axis=1)
    if beyond[0] < 0.001 * leg_length:
        return stance
    cost = params.stretch_cost * beyond + np.linalg.norm(wanted, axis=2).max(axis=1)
    move = moves[int(np.argmin(cost))]
    return replace(stance, plants=tuple(replace(plant, target=plant.target + move) for plant in stance.plants))


def heading(foot: Foot) -> Floats:
    """(F,) [rad] where the foot points on the floor, from heel to ball, continuous over time."""
    along = foot.ball - foot.heel
    return np.unwrap(np.arctan2(along[:, 0], along[:, 2]))


def _pivots(foot: Foot, flat: Bools, params: PlantParams) -> str:
    """Which end a flat foot turns about, if it turns."""
    if np.count_nonzero(flat) < 2:
        return ""
    turned = heading(foot)[flat]
    if np.ptp(turned) < np.radians(params.pivot):
        return ""
    travel = [float(np.ptp(foot.point(part)[flat][:, [0, 2]], axis=0).max()) for part in ("heel", "toe")]
    return "heel" if travel[0] < travel[1] else "toe"


def _stands_well(stance: Stance, foot: Foot, flat: Bools, leg_length: float, params: PlantParams) -> bool:
    for plant in stance.plants:
        off = foot.point(plant.part)[plant.frames] - plant.target
        moves = stance.pivots not in ("", plant.part)
        if not moves and np.hypot(off[:, 0], off[:, 2]).max() > params.keep_slide * leg_length:
            return False
        if np.abs(off[:, 1]).max() > params.keep_height * leg_length:
            return False
    return bool(
        not np.any(flat) or stance.pivots or np.ptp(heading(foot)[flat]) <= np.radians(params.keep_turn)
    )

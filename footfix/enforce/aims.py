"""Where plants are to stand: heel and ball of one foot as one rigid, level sole on the plant's own floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.foot import Foot
from footfix.enforce.plants import Plant, PlantParams, Stance, longest
from footfix.motion.clip import Bools, Floats
from footfix.motion.segments import centres, distinct, middle, segments
from footfix.motion.vectors import norm


def aimed(
    stance: Stance,
    foot: Foot,
    spot: Mapping[tuple[int, int], Floats],
    floor: float,
    leg_length: float,
    params: PlantParams,
) -> Stance:
    """The stance with its level and its plants' targets; `spot` is from `spots`."""
    level = level_of(stance, foot, floor, leg_length, params)
    flat = stance.flat()
    pivots = _pivots(stance, foot, flat, params)
    plants = [replace(plant, target=_place(plant, spot[plant.effector, plant.start], level)) for plant in stance.plants]
    if not pivots:
        plants = _rigid(plants, foot)
    stance = replace(stance, plants=tuple(plants), level=level, pivots=pivots)
    if all(plant.contact.position is None for plant in plants):
        stance = _within_reach(stance, foot, leg_length, params)
    return stance


def judged(stance: Stance, foot: Foot, frame_time: float, leg_length: float, params: PlantParams) -> Stance:
    """The stance kept where it stands well enough, given up where a plant of it would have to move too far."""
    if _stands_well(stance, foot, stance.flat(), frame_time, leg_length, params):
        return replace(stance, plants=tuple(replace(plant, kept=True) for plant in stance.plants))
    if any(plant.contact.wish == "force" for plant in stance.plants):
        return stance
    seconds = (stance.frames.stop - stance.frames.start) * frame_time
    if seconds < params.shortest:
        return stance.let_go(f"too short to be a plant: {seconds:.3f} s")
    for plant in stance.plants:
        if stance.pivots and plant.part != stance.pivots:
            continue
        far = float(norm(foot.point(plant.part)[plant.frames] - plant.target).max())
        if far > params.max_shift * leg_length:
            return stance.let_go(f"slides so far that it seems meant: {far:.2f} m from where it would stand")
    return stance


def level_of(stance: Stance, foot: Foot, floor: float, leg_length: float, params: PlantParams) -> float:
    """The floor under this stance: the one asked for, the rig's, or its own where that is a step away."""
    asked = [plant.contact.position[1] for plant in stance.plants if plant.contact.position is not None]
    if asked:
        return float(np.median(asked))
    heights = np.concatenate([foot.point(plant.part)[plant.frames, 1] for plant in stance.plants])
    own = middle(heights)
    return floor if abs(own - floor) <= params.snap * leg_length else own


def spots(stances: Sequence[Stance], feet: Sequence[Foot]) -> dict[tuple[int, int], Floats]:
    """For each plant, by effector and start, the middle (2,) [m] of where it was on the floor, flat if ever it was."""
    found = {}
    for k, foot in enumerate(feet):
        ends: dict[str, list[Plant]] = {"heel": [], "toe": []}
        on = {part: np.zeros(len(foot), dtype=np.bool_) for part in ends}
        for plant in (plant for stance in stances if stance.leg == k for plant in stance.plants):
            ends[plant.part].append(plant)
            on[plant.part][plant.frames] = True
        flat = on["heel"] & on["toe"]
        for part, plants in ends.items():
            if not plants:
                continue
            parts = segments([(plant.start, plant.end) for plant in plants])
            on_sole = flat[parts.frames].astype(np.float64)
            share = np.where(parts.largest(on_sole)[parts.owner] > 0.0, on_sole, 1.0)
            middles = centres(foot.point(part)[parts.frames][:, [0, 2]], parts, share)
            found.update({(plant.effector, plant.start): middles[n] for n, plant in enumerate(plants)})
    return found


def _place(plant: Plant, spot: Floats, level: float) -> Floats:
    """Where one end stands when it stands alone: asked for, or the middle of where it was, on the floor."""
    asked = plant.contact.position
    x, z = spot if asked is None else (asked[0], asked[2])
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
        if shared > 0:
            other = plants[j]
            both = slice(max(plant.start, other.start), min(plant.end, other.end))
            span = foot.point(plant.part)[both] - foot.point(other.part)[both]
            length = middle(norm(span))
            asked = plant.contact.position is not None and other.contact.position is not None
            heading = (plant.target - other.target)[[0, 2]] if asked else span[:, [0, 2]].sum(axis=0)
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
    captured = norm(line)
    thigh, shank = foot.knee[frames] - foot.hip[frames], foot.ankle[frames] - foot.knee[frames]
    length = norm(thigh) + norm(shank)
    free = np.maximum(captured, params.stretch * length)
    if np.max(norm(line + off) - free) < 0.001 * leg_length:
        return stance
    picks = distinct(np.linspace(0, len(off) - 1, params.places).round().astype(np.intp))
    moves = np.concatenate([np.zeros((1, 3)), -off[picks] * [1.0, 0.0, 1.0]])
    wanted = off + moves[:, None]  # (places, n, 3)
    beyond = np.maximum(norm(line + wanted) - free, 0.0).max(axis=1)
    cost = params.stretch_cost * beyond + norm(wanted).max(axis=1)
    move = moves[int(np.argmin(cost))]
    return replace(stance, plants=tuple(replace(plant, target=plant.target + move) for plant in stance.plants))


def heading(foot: Foot, frames: slice) -> Floats:
    """(n,) [rad] where the foot points on the floor, from heel to ball, continuous over the frames."""
    along = foot.ball[frames] - foot.heel[frames]
    return np.unwrap(np.arctan2(along[:, 0], along[:, 2]))


def _pivots(stance: Stance, foot: Foot, flat: Bools, params: PlantParams) -> str:
    """Which end a flat foot turns about, if it turns."""
    if np.count_nonzero(flat) < 2:
        return ""
    if np.ptp(heading(foot, stance.frames)[flat]) < np.radians(params.pivot):
        return ""
    places = [foot.point(part)[stance.frames][flat][:, [0, 2]] for part in ("heel", "toe")]
    travel = [float(np.linalg.norm(each - each.mean(axis=0), axis=1).max()) for each in places]
    return "heel" if travel[0] < travel[1] else "toe"


LEFT = "left as it was when this clip was cleaned"


def as_cleaned(
    stance: Stance, foot: Foot, rests: Mapping[int, Bools], floor: float, leg_length: float, params: PlantParams
) -> Stance:
    """The stance as it stands, kept, if it was cleaned before; otherwise the same value.

    `rests` says of each sole point which of its steps from frame to frame (F - 1,) a program put to rest. Some end
    of a cleaned foot rests most of the time, on the floor or a step away from it; what is left of its contacts lands
    or leaves, and was left to do so.
    """
    if any(plant.contact.position is not None or plant.contact.wish == "force" for plant in stance.plants):
        return stance
    cores = [_core(plant, rests[plant.effector]) for plant in stance.plants]
    frames = max(p.contact.end for p in stance.plants) - min(p.contact.start for p in stance.plants)
    if len({t for core in cores for t in range(core.start, core.stop)}) < max(params.cleaned * frames, 3):
        return stance
    plants = tuple(_as_held(plant, foot, core) for plant, core in zip(stance.plants, cores, strict=True))
    heights = np.concatenate([foot.point(plant.part)[plant.frames, 1] for plant in plants if plant.kept])
    level = float(np.median(heights))
    if params.off_floor * leg_length < abs(level - floor) <= params.snap * leg_length:
        return stance
    return replace(stance, plants=plants, level=level, cleaned=True)


def _core(plant: Plant, rests: Bools) -> slice:
    """The frames of a plant from the first to the last of the longest row of steps (F - 1,) at rest."""
    first = plant.contact.start
    core = longest(rests[first : plant.contact.end - 1])
    return slice(first + core.start, first + core.stop + 1) if core.stop > core.start else slice(first, first)


def _as_held(plant: Plant, foot: Foot, core: slice) -> Plant:
    if core.stop <= core.start:  # it only lands or leaves
        return replace(plant, reason=LEFT)
    target = np.median(foot.point(plant.part)[core], axis=0)
    return replace(plant, start=core.start, end=core.stop, target=target, kept=True)


def _stands_well(
    stance: Stance, foot: Foot, flat: Bools, frame_time: float, leg_length: float, params: PlantParams
) -> bool:
    for plant in stance.plants:
        off = foot.point(plant.part)[plant.frames] - plant.target
        moves = stance.pivots not in ("", plant.part)
        if not moves and np.hypot(off[:, 0], off[:, 2]).max() > params.keep_slide * leg_length:
            return False
        steps = np.diff(off[:, [0, 2]], axis=0)
        if not moves and np.hypot(*steps.T).max(initial=0.0) > params.keep_speed * leg_length * frame_time:
            return False
        if np.abs(off[:, 1]).max() > params.keep_height * leg_length:
            return False
    return bool(
        not np.any(flat) or stance.pivots or np.ptp(heading(foot, stance.frames)[flat]) <= np.radians(params.keep_turn)
    )

"""Where plants are to stand: heel and ball of one foot as one rigid, level sole on the plant's own floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.course import Course
from footfix.enforce.foot import Foot
from footfix.enforce.plants import Plant, PlantParams, Stance, agreement, heights, stiller, too_short
from footfix.enforce.reach import reserve
from footfix.motion.clip import Floats
from footfix.motion.contacts import runs
from footfix.motion.segments import distinct, middle
from footfix.motion.vectors import norm

_AGREE = 0.8  # of the stances: where so many are off the floor by about as much, the clip is
_EVEN = 0.025  # leg lengths: feet side by side that differ by less are level
_STRAIGHT, _LEGS_APART = 0.004, 0.015  # legs that lack so little to their length, on feet that differ by more
_BESIDE = 0.6  # of the shorter stance: feet that stand so long together stand side by side


def levelled(
    stands: Sequence[Stance], feet: Sequence[Foot], floor: float, leg_length: float, params: PlantParams
) -> list[Stance]:
    """The stances with the floor under each: the one asked for, the rig's, or its own where that is a step away.

    Feet that stand side by side are not drawn to the rig's floor one without the other: if they are nearly level they
    stand on one floor, otherwise each on its own. Of two straight legs with their feet at different heights one would
    have to bend, by 20 degrees for 12 mm: they stay so, on and above the floor.
    """
    own = np.array([middle(heights(stance.plants, feet[stance.leg])) for stance in stands])
    asked = [
        [plant.contact.position[1] for plant in stance.plants if plant.contact.position is not None]
        for stance in stands
    ]
    free = [k for k, stance in enumerate(stands) if not (asked[k] or stance.cleaned or stance.released)]
    snap = params.snap * leg_length
    off = _off(own[free] - floor, params.hovers * leg_length)
    near = np.minimum(np.abs(own - floor), np.abs(own - floor - off)) <= snap
    sunk = (own < floor) & (own >= floor - params.sunk * leg_length)
    level = np.where(near | sunk, floor, own)
    lacks = [reserve(foot) for foot in feet]
    for group in _side_by_side([stands[k].frames for k in free], [stands[k].leg for k in free], own[free], snap):
        members = np.array(free)[group]
        drawn, uneven = level[members] == floor, float(np.ptp(own[members])) / leg_length
        straight = [np.median(lacks[stands[k].leg][stands[k].frames]) < _STRAIGHT for k in members]
        if uneven > _LEGS_APART and all(straight):  # the lowest on its floor, the others as far above it as captured
            level[members] = own[members] + float(np.min(level[members])) - float(np.min(own[members]))
        elif np.any(drawn) and not np.all(drawn):
            seconds = [stands[k].frames.stop - stands[k].frames.start for k in members]
            common = float(np.average(own[members], weights=seconds))
            level[members] = own[members] if uneven > _EVEN else floor if abs(common - floor) <= snap else common
    found = []
    for k, stance in enumerate(stands):
        where = float(np.median(asked[k])) if asked[k] else float(level[k])
        found.append(stance if stance.cleaned else replace(stance, level=where))
    return found


def _off(above: Floats, most: float) -> float:
    """[m] by which the stances (N,) are off their floor on the whole, if they agree and it is no more than `most`."""
    if not len(above):
        return 0.0
    off, agree = agreement(above)
    return off if abs(off) <= most and agree >= _AGREE else 0.0


def _side_by_side(spans: Sequence[slice], legs: Sequence[int], heights: Floats, near: float) -> list[list[int]]:
    """Which stances stand side by side: most of the shorter while the other does, on another leg, about as high."""
    first = list(range(len(spans)))  # by stance, another one of its group

    def root(k: int) -> int:
        while first[k] != k:
            first[k] = k = first[first[k]]
        return k

    standing: list[int] = []
    for k in sorted(first, key=lambda k: spans[k].start):
        standing = [j for j in standing if spans[j].stop > spans[k].start]
        for j in standing:
            common = min(spans[k].stop, spans[j].stop) - spans[k].start
            shorter = min(spans[k].stop - spans[k].start, spans[j].stop - spans[j].start)
            if legs[j] != legs[k] and common >= _BESIDE * shorter and abs(heights[j] - heights[k]) <= near:
                first[root(j)] = root(k)
        standing.append(k)
    groups: dict[int, list[int]] = {}
    for k in range(len(spans)):
        groups.setdefault(root(k), []).append(k)
    return [group for group in groups.values() if len(group) > 1]


def aimed(stance: Stance, course: Course, leg_length: float, params: PlantParams) -> Stance:
    """The stance, its level known, with its plants' targets."""
    pivots = _pivots(stance, course, params)
    plants = [replace(p, target=_place(p, course.spots[p.effector, p.start], stance.level)) for p in stance.plants]
    if not pivots:
        plants = _rigid(plants, course.foot)
    stance = replace(stance, plants=tuple(plants), pivots=pivots)
    if all(plant.contact.position is None for plant in plants):
        stance = _within_reach(stance, course, leg_length, params)
    return stance


def judged(
    stance: Stance, course: Course, floor: float, frame_time: float, leg_length: float, params: PlantParams
) -> Stance:
    """The stance kept where it stands well enough, given up where a plant of it would have to move too far."""
    foot = course.foot
    if _stands_well(stance, course, frame_time, leg_length, params):
        return replace(stance, plants=tuple(replace(plant, kept=True) for plant in stance.plants))
    if any(plant.contact.wish == "force" for plant in stance.plants):
        return stance
    seconds = (stance.frames.stop - stance.frames.start) * frame_time
    if seconds < params.shortest and not any(plant.given for plant in stance.plants):
        return stance.let_go(too_short(seconds))
    if not any(plant.given for plant in stance.plants) and abs(stance.level - floor) > params.air * leg_length:
        at = heights(stance.plants, foot)
        if np.median(np.abs(at - np.median(at))) > params.steady * leg_length:
            by, off = 1000.0 * np.ptp(at), 1000.0 * (stance.level - floor)
            where = f"{abs(off):.0f} mm {'above' if off > 0.0 else 'below'} the floor"
            return stance.let_go(f"no stand: it moves up and down by {by:.0f} mm, {where}")
    for plant in stance.plants:
        if stance.pivots and plant.part != stance.pivots:
            continue
        far = float(norm(foot.point(plant.part)[plant.frames] - plant.target).max())
        if far > params.max_shift * leg_length:
            return stance.let_go(f"slides so far that it seems meant: {far:.2f} m from where it would stand")
    return stance


def _place(plant: Plant, spot: Floats, level: float) -> Floats:
    """Where one end stands when it stands alone: asked for, or the middle of where it was, on the floor."""
    asked = plant.contact.position
    x, z = spot if asked is None else (asked[0], asked[2])
    return np.array([x, level, z])


def _rigid(plants: list[Plant], foot: Foot) -> list[Plant]:
    """Heel and ball as far apart as the foot is long: the longest plant stands, the others give way to it.

    Each in its turn goes by the placed one that it shares the most frames with, as in a tree that spans them (R. C.
    Prim 1957): a foot that swivels on its heel has its ball in two places, and both go by that heel.
    """
    waiting = sorted(range(len(plants)), key=lambda k: plants[k].start - plants[k].end)
    placed: list[int] = []
    while waiting:
        shared, _, k, j = max(
            ((_shared(plants[k], plants[j]), -n, k, j) for n, k in enumerate(waiting) for j in placed),
            default=(0, 0, waiting[0], -1),
        )
        if shared <= 0:
            k, j = waiting[0], -1
        waiting.remove(k)
        placed.append(k)
        if j >= 0:
            plants[k] = _at_length(plants[k], plants[j], foot)
    return plants


def _shared(plant: Plant, other: Plant) -> int:
    """In how many frames both hold, if they are of different ends."""
    return 0 if plant.part == other.part else min(plant.end, other.end) - max(plant.start, other.start)


def _at_length(plant: Plant, other: Plant, foot: Foot) -> Plant:
    """The plant as far from the other end's as the foot is long, in the direction captured or asked for."""
    both = slice(max(plant.start, other.start), min(plant.end, other.end))
    span = foot.point(plant.part)[both] - foot.point(other.part)[both]
    length = middle(norm(span))
    asked = plant.contact.position is not None and other.contact.position is not None
    heading = (plant.target - other.target)[[0, 2]] if asked else span[:, [0, 2]].sum(axis=0)
    heading /= max(float(np.linalg.norm(heading)), 1e-300)
    target = other.target + length * np.array([heading[0], 0.0, heading[1]])
    return replace(plant, target=target)


def _within_reach(stance: Stance, course: Course, leg_length: float, params: PlantParams) -> Stance:
    """The stance moved over the floor, along its own slide, to where its leg is stretched least beyond the source.

    Of the places that the foot slides through, the one in the middle asks the shortest way of the foot; but a leg
    that is straight when it lands can't reach ahead.
    """
    frames = stance.frames
    off = np.zeros((frames.stop - frames.start, 3))
    ends = np.zeros(len(off))
    for plant in stance.plants:
        own = slice(plant.start - frames.start, plant.end - frames.start)
        off[own] += plant.target - course.foot.point(plant.part)[plant.frames]
        ends[own] += 1.0
    off /= np.maximum(ends, 1.0)[:, None]
    line, free = course.line[frames], course.free[frames]
    wanted = line + off
    if np.max(np.einsum("fi,fi->f", wanted, wanted) - (free + 0.001 * leg_length) ** 2) < 0.0:
        return stance
    picks = distinct(np.linspace(0, len(off) - 1, params.places).round().astype(np.intp))
    moves = np.concatenate([np.zeros((1, 3)), -off[picks] * [1.0, 0.0, 1.0]])
    wanted = off + moves[:, None]  # (places, n, 3)
    beyond = np.maximum(norm(line + wanted) - free, 0.0).max(axis=1)
    cost = params.stretch_cost * beyond + norm(wanted).max(axis=1)
    move = moves[int(np.argmin(cost))]
    return replace(stance, plants=tuple(replace(plant, target=plant.target + move) for plant in stance.plants))


def _pivots(stance: Stance, course: Course, params: PlantParams) -> str:
    """Which end a flat foot turns about, if it turns."""
    if _turn(stance, course) < np.radians(params.pivot):
        return ""
    return stiller(course.foot, stance.frames.start + np.flatnonzero(course.flat[stance.frames]))


def _turn(stance: Stance, course: Course) -> float:
    """[rad] that it turns while the foot is flat, the most of all such times; below zero where it never is for long."""
    heading = course.heading[stance.frames]
    flat = [span for span in runs(course.flat[stance.frames]) if span[1] - span[0] > 1]
    return max((float(np.ptp(heading[start:end])) for start, end in flat), default=-np.inf)


def _stands_well(
    stance: Stance, course: Course, frame_time: float, leg_length: float, params: PlantParams
) -> bool:
    for plant in stance.plants:
        off = course.foot.point(plant.part)[plant.frames] - plant.target
        moves = stance.pivots not in ("", plant.part)
        slides = 0.0 if moves else float(np.hypot(off[:, 0], off[:, 2]).max()) / leg_length
        speeds = np.hypot(*np.diff(off[:, [0, 2]], axis=0).T) / (frame_time * leg_length)
        mean, fastest = (0.0, 0.0) if moves or not len(speeds) else (float(speeds.mean()), float(speeds.max()))
        stirs = fastest > params.keep_speed or mean > params.keep_mean
        if slides > params.keep_slide or (slides > params.keep_slow and stirs):
            return False
        if np.abs(off[:, 1]).max() > params.keep_height * leg_length:
            return False
    return bool(stance.pivots) or _turn(stance, course) <= np.radians(params.keep_turn)

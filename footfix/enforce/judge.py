"""Judgement: what holding a foot does to its leg, and what gives way where that is too much.

A plant first gives up frames at its edges, whose labels are the least certain; then it lets go of what slides
quickly; and if it would still slide visibly it is released.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from footfix.enforce.ease import ease_frames, running_maximum
from footfix.enforce.plants import Plant, PlantParams, Stance, longest
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.vectors import norm

JERK = "holding it would jerk the leg"  # the reason of plants that are let go
_THEREABOUTS = 0.1  # [s] on either side: how fast a foot was captured there


@dataclass(frozen=True, kw_only=True)
class JudgeParams:
    """What holding a foot may do to the joints of its leg."""

    speed: float = 150.0  # [deg/s] by which a joint may turn faster than captured before a plant gives up its edges
    dart: float = 0.44  # [leg lengths/s] by which its foot may go faster than captured, to the same end
    soften: float = 1.6  # times as fast, before its hold softens
    given: float = 4.0  # times as fast where the contacts were given, not detected
    peel: float = 0.05  # [s] at a plant's edges that are let go at a time, while the leg hurries there,
    peel_most: float = 0.12  # [s] and altogether,
    peel_share: float = 0.3  # but no more of the plant than this
    softness: tuple[float, ...] = (0.04, 0.08, 0.16)  # [s] then the hold's steps: slower slides are still held
    around: float = 0.05  # [s] on either side of such a frame
    beside: float = 0.2  # [s] before and after a plant: a leg that hurries there comes from it or goes to it
    share: float = 0.25  # of the stands: where the legs would let go of more, the root moves with the feet
    most: float = 1.6  # times as fast, at a plant, before that is released


def peeled(stance: Stance, hurried: Bools, frame_time: float, judge: JudgeParams) -> Stance:
    """The stance without the edges of its plants at which the leg hurries; the same value where none does."""
    if not np.any(hurried[max(stance.frames.start - 1, 0) : stance.frames.stop + 1]):
        return stance
    plants = []
    for plant in stance.plants:
        contact = plant.contact
        start, end = plant.start, plant.end
        if not plant.kept and not plant.given:
            most = min(round(judge.peel_most / frame_time), int(judge.peel_share * (contact.end - contact.start)))
            width = max(2, round(judge.peel / frame_time))
            head = np.flatnonzero(hurried[max(start - 1, 0) : start + width])
            tail = np.flatnonzero(hurried[max(end - width, 0) : end + 1])
            if len(head):
                start = max(start, min(max(start - 1, 0) + int(head[-1]) + 1, contact.start + most))
            if len(tail):
                end = min(end, max(max(end - width, 0) + int(tail[0]), contact.end - most))
        unchanged = (start, end) == (plant.start, plant.end) or end - start < 2
        plants.append(plant if unchanged else replace(plant, start=start, end=end))
    if all(new is old for new, old in zip(plants, stance.plants, strict=True)):
        return stance
    return replace(stance, plants=tuple(plants))


def let_go(
    stance: Stance,
    points: Sequence[Floats],
    soft: Floats,
    hurry: Floats,
    most: Floats,
    leg_length: float,
    params: PlantParams,
    beside: int = 0,
    around: int = 0,
    sunk: Floats | None = None,
) -> Stance:
    """The stance with those plants released that still slide, held as softly as they are, or still hurry the leg.

    `hurry` (F,) [deg/s] says by how much its joints turn faster than captured, `most` (F,) by how much they may; so
    many frames `beside` a plant are its doing, too. With `around`, a plant that hurries the leg in places lets go of
    so many frames on either side of them, if most are left. `sunk` (F,) [m] says how much deeper than captured the
    knee is below the floor: a kneeling figure is not pushed through it.
    """
    plants = []
    near = slice(max(stance.frames.start - 1 - beside, 0), stance.frames.stop + 1 + beside)
    calm = not np.any(hurry[near] > most[near]) and not np.any(soft[near])
    deep = np.zeros(len(hurry)) if sunk is None else sunk
    for plant in stance.plants:
        off = norm(points[plant.effector][plant.frames] - plant.target)
        far = float(off.max())
        down = float(deep[plant.frames].max())
        if calm and far <= params.noticed * leg_length and down <= params.knee_sink * leg_length:
            plants.append(plant)
            continue
        held = longest(off <= params.holds * leg_length)
        softened = bool(np.any(soft[plant.frames]))
        slides = softened and far > params.holds * leg_length
        slides = slides and held.stop - held.start < params.stands * (plant.contact.end - plant.contact.start)
        first, last = min(plant.start, plant.contact.start), max(plant.end, plant.contact.end)
        own = slice(max(first - 1 - beside, 0), last + 1 + beside)
        hurries = hurry[own] > most[own]
        if plant.contact.wish == "force" or plant.kept or plant.reason or stance.pivots not in ("", plant.part):
            plants.append(plant)
        elif down > params.knee_sink * leg_length and not plant.given:
            why = f"its knee would be pushed {1000.0 * down:.0f} mm deeper into the floor"
            plants.append(replace(plant, reason=why))
        elif far > params.noticed * leg_length and not plant.given and not softened:
            plants.append(replace(plant, reason=f"out of reach: it would still be {1000.0 * far:.0f} mm away"))
        elif np.any(hurries) and not plant.given and (rest := _calm_part(plant, hurry > most, around, beside, params)):
            plants.append(replace(plant, start=rest.start, end=rest.stop))
        elif np.any(hurries):
            fast, may = float(hurry[own][hurries].max()), float(most[own][hurries].min())
            why = f"{JERK}: as by {fast:.0f} degrees/s beyond its own speed, of {may:.0f} (enforce.judge.speed)"
            plants.append(replace(plant, reason=why))
        elif slides:
            plants.append(replace(plant, reason=f"{JERK}: it would still slide by {1000.0 * far:.0f} mm"))
        elif softened and far > params.noticed * leg_length and not plant.given:  # held in part: the rest swings
            plants.append(replace(plant, start=plant.start + held.start, end=plant.start + held.stop))
        else:
            plants.append(plant)
    if all(new is old for new, old in zip(plants, stance.plants, strict=True)):
        return stance
    if stance.pivots and all(plant.reason for plant in plants if plant.part == stance.pivots):
        why = next(plant.reason for plant in plants if plant.part == stance.pivots)
        plants = [plant if plant.reason else replace(plant, reason=why) for plant in plants]  # it turned about that end
    return replace(stance, plants=tuple(plants))


def _calm_part(plant: Plant, hurries: Bools, around: int, beside: int, params: PlantParams) -> slice | None:
    """The longest frames of a plant that are farther than `around` from any in which the leg hurries, if most are.

    Where it hurries beside the plant, twice as many frames at that edge are not among them.
    """
    if not around:
        return None
    first, last = max(plant.start - around - 1, 0), plant.end + around + 1
    near = running_maximum(hurries[first:last].astype(np.float64), around) > 0.0
    near = near[plant.start - first : plant.end - first]
    near[: 2 * around] |= np.any(hurries[max(plant.start - 1 - beside, 0) : plant.start])
    near[max(len(near) - 2 * around, 0) :] |= np.any(hurries[plant.end : plant.end + 1 + beside])
    calm = longest(~near)
    enough = calm.stop - calm.start >= max(params.stands * (plant.contact.end - plant.contact.start), 2)
    return slice(plant.start + calm.start, plant.start + calm.stop) if enough else None


def hurry_of(clip: Clip, turned: dict[int, Floats]) -> Floats:
    """(F,) [deg/s] by which a joint turns faster, to or from each frame, than it did thereabouts as captured."""
    fastest = np.zeros(len(clip))
    for joint, q in turned.items():
        before, after = _steps(clip.turn(joint)), _steps(q)
        more = np.degrees(after - running_maximum(before, 1)) / clip.frame_time
        fastest = np.maximum(fastest, _to_or_from(more))
    return fastest


def dart_of(captured: Floats, ankle: Floats, frame_time: float) -> Floats:
    """(F,) [m/s] by which an ankle (F, 3) [m] goes faster, to or from each frame, than it did thereabouts as captured.

    A foot that was held while it slid has the whole way before it when it is let go.
    """
    if len(ankle) < 2:
        return np.zeros(len(ankle))
    before, after = (norm(np.diff(track, axis=0)) / frame_time for track in (captured, ankle))
    return _to_or_from(after - running_maximum(before, ease_frames(frame_time, _THEREABOUTS)))


def _to_or_from(steps: Floats) -> Floats:
    """(F,) the larger of the steps (F - 1,) to and from each frame; zero where neither is above."""
    ends = np.concatenate([[0.0], steps, [0.0]])
    return np.asarray(np.maximum(np.maximum(ends[1:], ends[:-1]), 0.0))


def _steps(q: Floats) -> Floats:
    """(F - 1,) [rad] how far rotations (F, 4) turn from frame to frame."""
    return rotation.angle(rotation.multiply(q[1:], rotation.inverse(q[:-1])))

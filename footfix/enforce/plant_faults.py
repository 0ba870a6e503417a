"""Faults of plants: which need no correction, and how far the others stray from their place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.costs import CostParams
from footfix.enforce.footing import Footing
from footfix.enforce.footplant import FEWEST, Footplant
from footfix.enforce.leg import HEEL, TOE, LegTracks
from footfix.enforce.pins import PinParams
from footfix.enforce.standing_heights import Floors
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import PUT_TO_REST, runs
from footfix.motion.segments import segments

_RESTED = 0.0005  # [leg lengths] a plant that strays less than this throughout was locked by a program, too
_LASTS = 0.06  # [s] least duration of a lock; pauses and duplicate frames are shorter,
_CARRIED = 2  # but of fewer frames in a row where the hip moves on, which it does in neither of them:
_MOVES_ON = 20.0  # [factor] it is this many times as fast as the fastest locked foot
_FEWEST_GIVEN = 2  # frames of a plant that was given, so that it is no foot that only passes
_AROUND = 0.35  # [s] before and after a plant, in which the correction fades in and out
_RESTING = 0.3  # [share] a plant locked in this share of its frames is kept as captured in all of them,
_OTHER_END = 0.5  # [share] and so is one in which the other end of the foot is locked in this share
_CLEANED = 0.7  # [share] where so much of the planted time is in such plants, a program has cleaned the clip


def kept(
    plants: Sequence[Footplant], legs: Sequence[LegTracks], ground: Floats, floors: Floors, frame_time: float,
    leg_length: float, *, heights: bool, params: PinParams, noticed: float = CostParams.noticed,
    by_hand: Sequence[bool] = (),
) -> tuple[bool, ...]:  # fmt: skip
    """Tell for each plant whether it stands well enough as it is.

    It does if its slide and its distance from the floor are within the tolerances, or, where `keep_rested` is set, if
    a program has locked it in 30 % of its frames, or the other end of its foot in half of them while the hip moves on:
    programs lock feet, and a cleaned foot is found planted some frames longer at one end than before. Where a program
    has locked most plants, it has let the others go for a reason: these stay as they are, too, unless viewers notice.

    Of plants that were given it is known that they stand: a toe joint is kept only if it is at rest, and a heel only if
    its toe joint is kept as well. Where exactly the heel touches is not in the clip, so it has the tolerances.

    Args:
        plants: of the clip.
        legs: as captured.
        ground: (F, 3) [m] displacement of the ground.
        floors: from `floors`.
        frame_time: [s].
        leg_length: [m].
        heights: whether heights count.
        params: the tolerances.
        noticed: [leg lengths] smallest fault that viewers notice.
        by_hand: for each plant whether it was given, not detected; none was by default.
    """
    sure = by_hand or (False,) * len(plants)
    fewest = [_FEWEST_GIVEN if own else FEWEST for own in sure]
    found = [not plant.force and plant.end - plant.start < fewest[plant.id] for plant in plants]
    rested = np.zeros(len(plants), dtype=np.bool_)
    if params.keep_rested:
        held = [_held(leg, ground, frame_time, leg_length) for leg in legs]
        rested[:] = [_rests(plant, held[plant.leg][plant.point]) for plant in plants]
    frames = np.array([plant.end - plant.start for plant in plants])
    if not any(sure) and np.sum(frames[rested]) >= _CLEANED * max(np.sum(frames), 1):
        params = replace(
            params, keep_slide=max(params.keep_slide, noticed), keep_height=max(params.keep_height, noticed)
        )
    for e in {plant.effector for plant in plants}:
        own = [plant for plant in plants if plant.effector == e]
        leg, point = own[0].leg, own[0].point
        track = legs[leg].place(point).T - ground
        cores, level = [core(p, frame_time, params.edge) for p in own], [floors.plants[p.id] for p in own]
        # where a toe joint is, the clip tells exactly; where a heel is, it does not
        exact = [sure[p.id] and point == TOE and legs[leg].leg.toe is not None for p in own]
        most = np.where(exact, _RESTED, params.keep_slide)
        still = _still(cores, track, level, leg_length, heights, most, params)
        for plant, keep, strict in zip(own, still.tolist(), exact, strict=True):
            found[plant.id] |= keep or (bool(rested[plant.id]) and not strict)
    return _heels_with_toes(plants, found, sure, len(ground))


def _heels_with_toes(
    plants: Sequence[Footplant], keep: Sequence[bool], sure: Sequence[bool], frames: int
) -> tuple[bool, ...]:
    """Keep no heel that was given beside a toe joint that was given and is to be held.

    The foot is stiff from heel to toe joint: a heel left where it slid would lift the toe joint.
    """
    moves: dict[int, Bools] = {}
    for plant in plants:
        if sure[plant.id] and plant.point == TOE and not keep[plant.id]:
            moves.setdefault(plant.leg, np.zeros(frames, dtype=np.bool_))[plant.frames] = True

    def goes_along(plant: Footplant) -> bool:
        beside = moves.get(plant.leg) if sure[plant.id] and plant.point == HEEL else None
        return beside is not None and bool(np.any(beside[plant.frames]))

    return tuple(keep[plant.id] and not goes_along(plant) for plant in plants)


def faults(
    footing: Footing, legs: Sequence[LegTracks], frame_time: float, *, heights: bool, edge: float = PinParams.edge
) -> Floats:
    """Measure how far the plants that need correction stray.

    Args:
        footing: the plants of the clip, and what they stand on.
        legs: as captured.
        frame_time: [s].
        heights: whether heights count.
        edge: [s] at both ends of a contact that are left out.

    Returns:
        (F,) [m] the farthest that any plant nearby slides from its median place, or is from its floor; infinite near
        forced plants.
    """
    ground = footing.ground
    found = np.zeros(len(ground))
    around = round(_AROUND / frame_time)
    wanted = [plant for plant in footing.plants if _wanted(plant) or not footing.keep[plant.id]]
    for e in {plant.effector for plant in wanted}:
        own = [plant for plant in wanted if plant.effector == e]
        track = legs[own[0].leg].place(own[0].point).T - ground
        middle, slides = _strays([core(plant, frame_time, edge, fewest=2) for plant in own], track)
        for plant, slide, height in zip(own, slides.tolist(), middle[:, 1].tolist(), strict=True):
            high = abs(height - footing.floors.plants[plant.id]) if heights else 0.0
            fault = np.inf if _wanted(plant) else max(slide, high)
            near = slice(max(plant.start - around, 0), plant.end + around)
            found[near] = np.maximum(found[near], fault)
    return found


def _wanted(plant: Footplant) -> bool:
    """Tell whether a plant is forced, or has a requested place."""
    return plant.force or plant.asked is not None


def _strays(spans: Sequence[tuple[int, int]], track: Floats) -> tuple[Floats, Floats]:
    """Find the median place (S, 3) [m] of a track (F, 3) in each span, and its farthest horizontal distance (S,)."""
    parts = segments(spans)
    places = track[parts.frames]
    middle = np.stack([parts.median(places[:, axis]) for axis in (0, 1, 2)], axis=1)
    return middle, parts.largest(np.hypot(*(places - middle[parts.owner])[:, [0, 2]].T))


def core(
    plant: Footplant, frame_time: float, edge: float = PinParams.edge, *, fewest: int = FEWEST
) -> tuple[int, int]:
    """Cut `edge` [s] off both ends of a plant, in which the foot may still be landing or leaving.

    At least `fewest` frames are left.
    """
    trim = min(max(1, round(edge / frame_time)), max((plant.end - plant.start - fewest) // 2, 0))
    return plant.start + trim, plant.end - trim


def _still(
    spans: Sequence[tuple[int, int]], track: Floats, level: Sequence[float], leg_length: float, heights: bool,
    most: Floats, params: PinParams,
) -> Bools:  # fmt: skip
    """Tell whether a track (F, 3) [m] stays near one place and its level [m] in each span, (S,).

    Args:
        spans: S stretches of frames.
        track: [m].
        level: (S,) [m].
        leg_length: [m].
        heights: whether heights count.
        most: (S,) [leg lengths] how far it may slide.
        params: how far it may be from its level.
    """
    middle, slide = _strays(spans, track)
    near = np.abs(middle[:, 1] - np.array(level)) <= params.keep_height * leg_length
    rests = slide <= _RESTED * leg_length
    return np.asarray(rests | ((slide <= most * leg_length) & (near | (not heights))))


def _rests(plant: Footplant, held: tuple[Bools, Bools]) -> bool:
    """Tell whether a plant is locked in so many of its steps; `held` marks those of its own end, and of the other."""
    own, other = (np.count_nonzero(each[plant.start : plant.end - 1]) for each in held)
    steps = max(plant.end - plant.start - 1, 1)
    return bool(own >= _RESTING * steps or other >= _OTHER_END * steps)


def _held(
    leg: LegTracks, ground: Floats, frame_time: float, leg_length: float
) -> tuple[tuple[Bools, Bools], tuple[Bools, Bools]]:
    """Mark the steps (F - 1,) in which a foot is so still that a program must have locked it.

    For heel and for toe: the steps in which itself is locked, and those in which the other is while the hip moves on.
    """
    slowest = PUT_TO_REST * leg_length * frame_time  # [m]
    moves_on = _steps(leg.hip.T - ground) > _MOVES_ON * slowest
    rest = [_steps(leg.place(point).T - ground) <= slowest for point in (HEEL, TOE)]
    carried = [_lasting(each & moves_on, _CARRIED) for each in rest]
    still = [_lasting(each, max(3, round(_LASTS / frame_time))) for each in rest]
    own = [each | other for each, other in zip(still, carried, strict=True)]
    return (own[HEEL], carried[TOE]), (own[TOE], carried[HEEL])


def _steps(track: Floats) -> Floats:
    """Measure how far a track (F, 3) [m] moves over the floor from each frame to the next, (F - 1,) [m]."""
    return np.asarray(np.hypot(*np.diff(track[:, [0, 2]], axis=0).T))


def _lasting(mask: Bools, least: int) -> Bools:
    """Keep of a mask (N,) the stretches of at least so many."""
    out = np.zeros_like(mask)
    for start, end in runs(mask):
        out[start:end] = end - start >= least
    return out

"""Remove the residual slide of held feet, a few millimetres at most, by the legs alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footfix.enforce.correction import apply
from footfix.enforce.footplant import Footplant
from footfix.enforce.two_bone_ik import (
    CapturedLeg,
    LegTurns,
    can_turn,
    captured_leg,
    correction_of,
    flexion_for,
    local_rotations,
    where_moved,
    within_reach,
)
from footfix.locomotion.loop.root_motion import Travel
from footfix.motion import rotation
from footfix.motion.clip import Bools, Clip, Floats
from footfix.motion.contacts import runs
from footfix.motion.vectors import norm
from footfix.rig.rig import Rig

_MOST = 0.0055  # [leg lengths] greatest slide of a pinned plant; a larger one has a reason, and is left
_FADE = 0.12  # [s] before and after a plant, over which the change fades
_FEWEST = 3  # least number of frames of a plant
_HARDLY = 0.06  # [rad] a smaller change of flexion counts as hardly any


def settled(clip: Clip, rig: Rig, plants: Sequence[Footplant], travel: Travel, ground: Floats) -> Clip:
    """Make held toes of a closed cycle stand exactly still, also across the seam.

    Args:
        clip: L + 1 frames, the last of which is the first moved by `travel`.
        rig: its legs.
        plants: of the cycle, with the frames in which they are held.
        travel: of one round.
        ground: (L + 1, 3) [m] how far the ground under planted feet has moved, as on a treadmill.
    """
    pose = rig.pose(clip)
    tracks = rig.held(pose)
    turns: dict[int, Floats] = {}
    for number, leg in enumerate(rig.legs):
        if not can_turn(clip, leg):
            continue
        captured = captured_leg(rig, pose, number, tracks)
        own = [p for p in plants if p.leg == number and p.part == "toe" and p.outcome != "released"]
        held = [span for p in own for span in stretches(p, len(clip))]
        shift = _shift(captured.toe, held, travel, ground, clip.frame_time, _MOST * rig.leg_length)
        moves = np.any(shift != 0.0, axis=1)
        if np.any(moves):
            goal = _lifted(captured, captured.ankle + shift)
            new = local_rotations(clip, pose, captured, _solved(captured, goal, moves), captured.turn)
            turns |= where_moved(clip, new, moves)
    for turn in turns.values():
        turn[-1] = turn[0]
    return apply(clip, correction_of(clip, rig, turns)) if turns else clip


def _solved(leg: CapturedLeg, ankle: Floats, moves: Bools) -> LegTurns:
    """Solve a leg for a goal of its ankle (F, 3) [m]; an overstretched knee that hardly moves stays so.

    The same leg length is reached by flexion forwards or backwards. For a tiny motion of the foot, a knee bent
    backwards by some degrees would otherwise jump forwards by twice as many in one frame.

    Args:
        leg: before the change.
        ankle: (F, 3) [m] its goal.
        moves: (F,) where the goal differs from the ankle's place.
    """
    bent = flexion_for(leg, ankle)
    over: Bools = np.asarray(moves & (leg.flexion < 0.0) & (bent > 0.0))
    for start, end in runs(moves):
        some = slice(start, end)
        if np.all((bent + leg.flexion)[some][over[some]] <= _HARDLY):
            bent[some] = np.where(over[some], -bent[some], bent[some])
    bend = rotation.from_axis_angle(leg.knee_axis, bent - leg.flexion)
    thigh, shank = leg.knee - leg.hip, leg.ankle - leg.knee
    return LegTurns(rotation.between(thigh + rotation.rotate(bend, shank), ankle - leg.hip), bend)


def _lifted(leg: CapturedLeg, ankle: Floats) -> Floats:
    """Raise goals of the ankle (F, 3) [m] that would stretch the leg, without moving them horizontally."""
    limit = norm(within_reach(leg, ankle) - leg.hip)
    flat = norm((ankle - leg.hip)[:, [0, 2]])
    out = ankle.copy()
    out[:, 1] = np.maximum(out[:, 1], leg.hip[:, 1] - np.sqrt(np.maximum(limit**2 - flat**2, 0.0)))
    return out


def stretches(plant: Footplant, frames: int) -> tuple[tuple[int, int], ...]:
    """List the frames `[start, end)` in which a plant of a cycle of so many frames is held.

    A pinned plant is held without interruption, and does not end at the seam.
    """
    if plant.outcome not in ("pinned", "kept") or not plant.held:
        return plant.held
    start, end = plant.held[0][0], plant.held[-1][1]
    return ((0 if plant.start == 0 else start, frames if plant.end == frames else end),)


def _shift(
    toe: Floats, held: Sequence[tuple[int, int]], travel: Travel, ground: Floats, frame_time: float, most: float
) -> Floats:  # fmt: skip
    """Compute the shift (L + 1, 3) [m] of a toe to its mean place, fading out before and after.

    Args:
        toe: (L + 1, 3) [m].
        held: the frames in which it stands.
        travel: of one round.
        ground: (L + 1, 3) [m] how far the ground has moved.
        frame_time: [s].
        most: [m] a plant that strays farther is left.
    """
    length = len(toe) - 1
    three = np.concatenate([travel.places_back(toe[:-1]), toe[:-1], travel.places(toe)])  # (3 L + 1, 3)
    three -= np.concatenate([ground[:-1] - ground[-1], ground[:-1], ground[-1] + ground])
    fade = max(1, min(round(_FADE / frame_time), length // 4))
    ease = np.linspace(1.0, 0.0, fade + 2)[1:-1]
    ease = ease * ease * (3.0 - 2.0 * ease)
    out = np.zeros_like(three)
    for start, end in _over_seam(held, length):
        if end - start < _FEWEST:
            continue
        place = three[start:end, [0, 2]]
        off = np.median(place, axis=0) - place
        off *= np.clip(2.0 - np.linalg.norm(off, axis=1) / most, 0.0, 1.0)[:, None]
        for k, axis in enumerate((0, 2)):
            out[start:end, axis] = off[:, k]
            out[max(start - fade, 0) : start, axis] = (ease[::-1] * off[0, k])[-min(start, fade) :]
            out[end : end + fade, axis] = (ease * off[-1, k])[: len(out) - end]
    return _one_round(out, length, travel)


def _over_seam(held: Sequence[tuple[int, int]], length: int) -> list[tuple[int, int]]:
    """Choose the stretches of the middle of three rounds; one across the seam begins in the middle round."""
    first = next((span for span in held if span[0] == 0 and span[1] <= length), None)
    last = next((span for span in held if span[1] == length + 1 and span[0] > 0), None)
    inner = [(a + length, b + length) for a, b in held if (a, b) not in (first, last) and b - a <= length]
    if first is None and last is None:
        return inner
    start = length if last is None else last[0]
    end = length + 1 if first is None else length + first[1]
    return [*inner, (start, end)]


def _one_round(shift: Floats, length: int, travel: Travel) -> Floats:
    """Combine shifts in three rounds (3 L + 1, 3) to one round (L + 1, 3), each turned to the middle one."""
    back, same, on = shift[:length], shift[length : 2 * length], shift[2 * length : 3 * length]
    turn = travel.turn
    out = np.zeros((length + 1, 3))
    out[:-1] = same
    for other, by in ((back, turn), (on, rotation.inverse(turn))):
        empty = ~np.any(out[:-1] != 0.0, axis=1)
        out[:-1][empty] = rotation.rotate(by, other)[empty]
    out[-1] = rotation.rotate(turn, out[0])
    return out

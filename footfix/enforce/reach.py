"""Reach: no leg is stretched beyond what its source does; the root gives way first, smoothly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footfix.enforce.ease import covered, ease_frames
from footfix.enforce.foot import Foot
from footfix.motion import rotation
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.motion.vectors import cross, dot, norm


@dataclass(frozen=True, kw_only=True)
class ReachParams:
    """How far legs stretch, and how far the root comes to help."""

    extension: float = 0.999  # of the leg's length, the straightest a leg may become
    planted: float = 0.5  # of its captured bend at the time, to which the knee of a planted foot may stretch
    swing: float = 0.8  # of its least captured bend, to which a knee may stretch for a moment while its foot swings
    root_limit: float = 0.03  # leg lengths that the root may come down; where more would be needed, it does not
    margin: float = 0.001  # leg lengths that it comes down farther than needed, lest knees pass through straight
    roll: float = 12.0  # [degrees] that a planted foot rolls on one end for its leg to reach
    root_ease: float = 0.15  # [s] how early the root begins to give way


def reserve(foot: Foot) -> Floats:
    """(F,) what a leg as captured lacks to its full length, as a share of it."""
    return np.asarray(1.0 - norm(foot.ankle - foot.hip) / foot.length)


def allowed(
    foot: Foot, hip: Floats, ankle: Floats, params: ReachParams, straightest: float | None = None
) -> Floats:
    """(F,) [m] how far the ankle may be from the hip, when it is wanted at `ankle` (F, 3).

    With x = 1 - distance / length, the leg's reserve: a leg may use up the reserve x0 it had when captured only
    by and by, x0 exp((x - x0) / x0), so that its knee is never quicker than the source's own at that bend; and
    never below what the straightest source frame leaves (`straightest`, the least of `reserve` over the clip, if
    `foot` is not all of it), nor below that of `extension`, nor below what `planted` leaves of its bend: the bend
    goes with the root of the reserve.
    """
    length = foot.length
    captured = 1.0 - norm(foot.ankle - foot.hip) / length
    straightest = float(captured.min()) if straightest is None else straightest
    wanted = 1.0 - norm(ankle - hip) / length
    least = np.maximum(max(1.0 - params.extension, straightest), params.planted**2 * captured)
    spare = np.maximum(captured - least, 1e-9)
    limited = np.minimum(least, captured) + spare * np.exp(np.minimum((wanted - captured) / spare, 0.0))
    reserve = np.where(wanted >= captured, wanted, np.minimum(limited, captured))
    return np.asarray(length * (1.0 - reserve))


def lowering(
    hips: Sequence[Floats],
    ankles: Sequence[Floats],
    limits: Sequence[Floats],
    held: Sequence[Bools],
    frame_time: float,
    leg_length: float,
    params: ReachParams,
) -> Floats:
    """(F,) [m] how far the root comes down so that every planted foot can be reached.

    The least that does it, frame by frame, under a smooth cover: a running maximum, then two running means no
    wider, so that it is nowhere less than needed and is zero where nothing is needed nearby. And up to `margin` more.
    """
    need = np.zeros(len(hips[0]))
    for hip, ankle, limit, planted in zip(hips, ankles, limits, held, strict=True):
        down = hip - ankle
        across = dot(down[:, [0, 2]], down[:, [0, 2]])
        # |(hip - h up) - ankle| = limit, the solution with the hip above the ankle
        height = np.sqrt(np.maximum(limit**2 - across, 0.0))
        short = np.where(norm(down) > limit + 1e-9, down[:, 1] - height, 0.0)
        short = np.where(planted, short, 0.0)
        for start, end in runs(planted):  # where the root's help would not do, the foot rolls or gives way alone
            if short[start:end].max() > params.root_limit * leg_length:
                short[start:end] = 0.0
        need = np.maximum(need, short)
    if not np.any(need > 0.0):
        return need
    lower = covered(need, ease_frames(frame_time, params.root_ease))
    if params.margin == 0.0:
        return lower
    # the bend goes with the root of the reserve: used up to the bound and given back, it would have a cusp there
    margin = params.margin * leg_length
    return np.asarray(lower - margin * np.expm1(-lower / margin))


def rolled(hip: Floats, ankle: Floats, pivot: Floats, limit: Floats, where: Bools, most: float) -> Floats:
    """The turn (F, 4) in the world that rolls a planted foot about the end it stands on until its leg reaches.

    In the plane of hip, ankle and pivot the ankle comes nearer to the hip: the heel leaves the floor a little
    earlier, or the toe comes down a little later, and what stands keeps standing.

    Args:
        hip: (F, 3) [m].
        ankle: (F, 3) [m] where it is wanted.
        pivot: (F, 3) [m] the end the foot stands on.
        limit: (F,) [m] how far the ankle may be from the hip.
        where: (F,) the frames in which the foot stands.
        most: [rad] that it rolls at most.
    """
    arm, line = ankle - pivot, hip - pivot
    a, d = norm(arm), np.maximum(norm(line), 1e-300)
    cosine_now = np.clip(dot(arm, line) / np.maximum(a * d, 1e-300), -1.0, 1.0)
    # law of cosines in the triangle of pivot, hip and ankle
    cosine = np.clip((a * a + d * d - limit**2) / np.maximum(2.0 * a * d, 1e-300), -1.0, 1.0)
    angle = np.arccos(cosine_now) - np.arccos(np.maximum(cosine, cosine_now))
    axis = cross(arm, line)
    length = norm(axis)
    angle = np.where(where & (length > 1e-12), np.maximum(angle, 0.0), 0.0)
    half = 0.5 * most
    angle = np.where(angle > half, half + half * np.tanh((angle - half) / half), angle)
    return rotation.from_axis_angle(axis / np.maximum(length, 1e-300)[:, None], angle)


def clamp(hip: Floats, ankle: Floats, limit: Floats) -> Floats:
    """The ankle's goal, drawn towards the hip where it is farther than `limit` (F,) [m]."""
    line = ankle - hip
    distance = norm(line)
    factor = np.where(distance > limit, limit / np.maximum(distance, 1e-300), 1.0)
    return np.asarray(np.where((factor < 1.0)[:, None], hip + factor[:, None] * line, ankle))

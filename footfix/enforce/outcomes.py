"""What became of each footplant, read from the solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.footplant import Footplant, Outcome
from footfix.enforce.leg import POINTS, LegTracks
from footfix.enforce.pins import Floors
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs
from footfix.rig.rig import Rig

_STANDS = 0.05  # [leg lengths/s] of slip: what moves less stands
_PINNED = 0.0055  # [leg lengths] a plant that strays no farther over its whole contact is pinned
_MOST = 0.5  # of its frames: a plant that stands in fewer is released


def outcomes(
    plants: Sequence[Footplant], legs: Sequence[LegTracks], points: Sequence[tuple[Floats, Floats]], ground: Floats,
    keep: Sequence[bool], floors: Floors, rig: Rig, frame_time: float,
) -> tuple[Footplant, ...]:  # fmt: skip
    """Say of each plant whether it was kept, stands, stands in part, or slides.

    Args:
        plants: as asked for.
        legs: as captured.
        points: for each leg the corrected tracks (3, F) [m] of heel and toe.
        ground: (F, 3) [m] displacement of the ground.
        keep: for each plant whether it was to stay as it was.
        floors: the heights the joints stand at.
        rig: size and floor.
        frame_time: [s].
    """
    found = []
    for plant in plants:
        point = POINTS.index(plant.part)
        track = points[plant.leg][point][:, plant.frames].T - ground[plant.frames]
        slip = np.hypot(*np.diff(track, axis=0)[:, [0, 2]].T)
        still = slip <= _STANDS * rig.leg_length * frame_time
        held = tuple((plant.start + a, plant.start + b + 1) for a, b in runs(still))
        on = np.append(still, still[-1:]) if len(still) else np.ones(1, dtype=np.bool_)
        place = np.median(track[on] if np.any(on) else track, axis=0)
        far = float(np.hypot(*(track - place)[:, [0, 2]].T).max())
        x, y, z = (place + ground[(plant.start + plant.end) // 2]).tolist()
        y -= floors.rest[plant.effector] - rig.floor  # a plant stands where its sole does
        outcome, reason = _outcome(keep[plant.id], still, far, rig.leg_length, plant, legs[plant.leg].turns)
        found.append(replace(plant, target=(x, y, z), outcome=outcome, reason=reason, residual=far, held=held))
    return tuple(found)


def _outcome(
    keep: bool, still: Bools, far: float, leg_length: float, plant: Footplant, turns: bool
) -> tuple[Outcome, str]:
    if keep:
        return "kept", ""
    if far <= _PINNED * leg_length:
        return "pinned", ""
    if not turns:
        return "released", "the file has no rotation channels for a joint of this leg"
    share = float(still.mean()) if len(still) else 0.0
    slides = f"it slides by {1000.0 * far:.0f} mm in {np.count_nonzero(~still)} of {plant.end - plant.start} frames"
    if share >= _MOST:
        return "partly", f"{slides}: holding it there would cost more than the slide"
    return "released", f"{slides}: holding it would cost more than the slide"

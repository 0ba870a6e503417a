"""What became of each footplant, read from the solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.footplant import Footplant, Outcome
from footfix.enforce.leg import POINTS, LegTracks, posed
from footfix.enforce.pins import Floors
from footfix.motion.clip import Bools, Floats
from footfix.motion.contacts import runs

_STANDS = 0.05  # [leg lengths/s] of slip: what moves less stands
_PINNED = 0.0055  # [leg lengths] a plant that strays no farther over its whole contact is pinned
_MOST = 0.5  # of its frames: a plant that stands in fewer is released


def outcomes(
    plants: Sequence[Footplant], legs: Sequence[LegTracks], x: Floats, columns: Sequence[slice], ground: Floats,
    keep: Sequence[bool], floors: Floors, level: float, frame_time: float, leg_length: float,
) -> tuple[Footplant, ...]:  # fmt: skip
    """Say of each plant whether it was kept, stands, stands in part, or slides.

    Args:
        plants: as asked for.
        legs: as captured.
        x: (U, F) the solution.
        columns: where each leg's unknowns stand in it.
        ground: (F, 3) [m] displacement of the ground.
        keep: for each plant whether it was to stay as it was.
        floors: the heights the joints stand at.
        level: [m] height of the rig's floor.
        frame_time: [s].
        leg_length: [m].
    """
    tracks = [posed(leg, x[:3], x[own], derive=False).places for leg, own in zip(legs, columns, strict=True)]
    found = []
    for plant in plants:
        track = tracks[plant.leg][POINTS.index(plant.part)][:, plant.frames].T - ground[plant.frames]
        slip = np.hypot(*np.diff(track, axis=0)[:, [0, 2]].T)
        still = slip <= _STANDS * leg_length * frame_time
        held = tuple((plant.start + a, plant.start + b + 1) for a, b in runs(still))
        on = np.append(still, still[-1:]) if len(still) else np.ones(1, dtype=np.bool_)
        place = np.median(track[on] if np.any(on) else track, axis=0)
        middle = ground[(plant.start + plant.end) // 2]
        far = float(np.hypot(*(track - place)[:, [0, 2]].T).max())
        outcome, reason = _outcome(bool(keep[plant.id]), still, far, leg_length, plant)
        up = floors.rest[plant.effector] - level  # a plant stands where its sole does
        x_, y, z = (place + middle).tolist()
        found.append(replace(
            plant, target=(x_, y - up, z), outcome=outcome, reason=reason, residual=far, held=held,
        ))  # fmt: skip
    return tuple(found)


def _outcome(keep: bool, still: Bools, far: float, leg_length: float, plant: Footplant) -> tuple[Outcome, str]:
    if keep:
        return "kept", ""
    if far <= _PINNED * leg_length:
        return "pinned", ""
    share = float(still.mean()) if len(still) else 0.0
    slides = f"it slides by {1000.0 * far:.0f} mm in {np.count_nonzero(~still)} of {plant.end - plant.start} frames"
    if share >= _MOST:
        return "partly", f"{slides}: holding it there would cost more than the slide"
    return "released", f"{slides}: holding it would cost more than the slide"

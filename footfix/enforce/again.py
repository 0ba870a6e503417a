"""A solution made anew where something changed, and only there.

What a stance asks of the legs and of the root is felt around it, but no farther than a second away: plants pin the
feet, and what leads over between them dies away within a few tenths of a second. Where it does not, it shows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from footfix.enforce.ease import within_reach
from footfix.enforce.plants import Stance
from footfix.enforce.solve import LegParams, Limb, Solved, floors, solution
from footfix.motion.clip import Bools, Clip, Floats, Ints
from footfix.motion.kinematics import Pose
from footfix.rig.rig import Rig

_FELT = 1.0  # [s] around a change within which it is felt
_SEAM = 2e-5  # leg lengths: where it is felt farther away than that by more, all is done anew
_MOST = 0.3  # of the clip: where more is to be done anew, all of it is


def again(
    clip: Clip,
    rig: Rig,
    pose: Pose,
    legs: Sequence[Limb],
    stands: Sequence[Stance],
    soft: Sequence[Floats],
    changed: Bools,
    before: Solved,
    params: LegParams,
) -> Solved:
    """The solution `before` made anew for stances that differ in frames `changed` (F,); arguments as of `solution`."""
    floor = floors(legs, stands, len(clip))
    inner = within_reach(changed, clip.frame_time, _FELT)
    wide = inner.copy()
    for stance in stands:  # what is decided for a whole stance needs all of it
        if np.any(inner[stance.frames]):
            wide[stance.frames] = True
    wide = within_reach(wide, clip.frame_time, _FELT)
    if params.solver != "closed" or wide.mean() > _MOST:
        return solution(clip, rig, pose, legs, stands, floor, soft, params)
    which, place = np.flatnonzero(wide), np.concatenate([[0], np.cumsum(wide)])
    part = solution(
        clip.frames(which), rig, pose.frames(which), [leg.frames(which) for leg in legs], _moved(stands, place),
        [each[which] for each in floor], [each[which] for each in soft], params,
    )  # fmt: skip
    at = np.flatnonzero(inner)
    seams = at[np.append(True, np.diff(at) > 1) | np.append(np.diff(at) > 1, True)]
    seams = seams[(seams > 0) & (seams < len(clip) - 1)]
    off = [np.abs(old[seams] - new[place[seams]]) for old, new in zip(before.points, part.points, strict=True)]
    if max(float(each.max(initial=0.0)) for each in off) > _SEAM * rig.leg_length:
        return solution(clip, rig, pose, legs, stands, floor, soft, params)
    joints = before.rotations.keys() | part.rotations.keys()
    kept = clip.frames(which)
    return Solved(
        _joined(before.shift, part.shift, at, place),
        {
            joint: _joined(
                before.rotations.get(joint, clip.turn(joint)), part.rotations.get(joint, kept.turn(joint)), at, place
            )
            for joint in joints
        },
        tuple(_joined(old, new, at, place) for old, new in zip(before.points, part.points, strict=True)),
        tuple(_joined(old, new, at, place) for old, new in zip(before.hurry, part.hurry, strict=True)),
        tuple(_joined(old, new, at, place) for old, new in zip(before.sunk, part.sunk, strict=True)),
    )


def _moved(stands: Sequence[Stance], place: Ints) -> list[Stance]:
    """The stances as they lie in a part of the clip; frame t of the clip is frame `place` (F + 1,)[t] of it."""
    moved = []
    for stance in stands:
        plants = tuple(replace(p, start=int(place[p.start]), end=int(place[p.end])) for p in stance.plants)
        plants = tuple(plant for plant in plants if plant.end > plant.start)
        if plants:
            moved.append(replace(stance, plants=plants))
    return moved


def _joined(whole: Floats, part: Floats, at: Ints, place: Ints) -> Floats:
    joined = np.array(whole)
    joined[at] = part[place[at]]
    return joined
